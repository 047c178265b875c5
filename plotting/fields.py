"""Fields at a time: fluid coloured by pressure, structure by Cauchy shear stress, the interface a black line.

Particles are drawn as discs of their own spacing in metres, so a gap in the picture is a gap in the particles. In 3D
the picture shows the particles within one spacing of the middle plane.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection

from plotting import style


def choose_times(run, times):
    """The frames asked for, or four spread over the run, without repetitions."""
    existing = [time for time, _ in run.frame_times("fluid") or run.frame_times("structure")]
    if not existing:
        return []
    wanted = times or [existing[-1] * part for part in (0.25, 0.5, 0.75, 1.0)]
    return sorted({min(existing, key=lambda time: abs(time - want)) for want in wanted})


def _discs(axis, position, values, spacing, colours, limits):
    diameter = np.full(len(position), 1.15 * spacing)  # a little overlap: no white between the discs of a full lattice
    discs = EllipseCollection(diameter, diameter, np.zeros(len(position)), units="xy", offsets=position[:, :2],
                              transOffset=axis.transData, array=values, cmap=colours)
    discs.set_clim(*limits)
    axis.add_collection(discs)
    return discs


def _outline(axis, position):
    """Joins every interface point with its two nearest neighbours: the surface, in whatever order its points come."""
    if len(position) < 3:
        return
    distance = np.linalg.norm(position[:, None, :] - position[None, :, :], axis=2)
    np.fill_diagonal(distance, np.inf)
    nearest = np.argsort(distance, axis=1)[:, :2]
    reach = 2.5 * np.median(distance.min(axis=1))
    lines = [(position[one], position[two]) for one in range(len(position)) for two in nearest[one]
             if distance[one, two] < reach]
    axis.add_collection(LineCollection(lines, colors="black", linewidths=1.0))


def _middle(fields, spacing):
    """Which particles a flat picture shows: all in 2D, the middle slice in 3D."""
    depth = fields["position"][:, 2]
    if np.ptp(depth) < 1e-12:
        return np.ones(len(depth), dtype=bool)
    return np.abs(depth - 0.5 * (depth.min() + depth.max())) <= spacing


def _draw(axis, run, fluid, structure, limits):
    """Draws both sides; returns the mappable of each (None where absent)."""
    drawn = [None, None]
    for lower, upper, open_faces in run.wall_boxes():
        (x0, y0), (x1, y1) = lower[:2], upper[:2]
        sides = {"x_min": ((x0, y0), (x0, y1)), "x_max": ((x1, y0), (x1, y1)), "y_min": ((x0, y0), (x1, y0)),
                 "y_max": ((x0, y1), (x1, y1))}
        axis.add_collection(LineCollection([line for face, line in sides.items() if face not in open_faces],
                                           colors="0.35", linewidths=1.5))
    if fluid is not None:
        shown = _middle(fluid, run.spacing("fluid"))
        drawn[0] = _discs(axis, fluid["position"][shown], fluid["pressure"][shown], run.spacing("fluid"), "turbo",
                          limits[0])
    if structure is not None:
        shown = _middle(structure, run.spacing("structure"))
        drawn[1] = _discs(axis, structure["position"][shown], structure["stress_xy"][shown], run.spacing("structure"),
                          "PuOr_r", limits[1])
        if "surface_position" in structure and len(structure["surface_position"]):
            surface = structure["surface_position"]
            _outline(axis, surface[np.abs(surface[:, 2] - np.median(surface[:, 2])) <= run.spacing("structure")][:, :2])
    axis.set_aspect("equal")
    axis.grid(False)
    return drawn


def limits_of(fluid, structure):
    """Colour ranges: pressure between its outermost half per cents and 0, shear stress symmetric about 0."""
    known = fluid is not None and len(fluid["pressure"]) > 0
    lowest, highest = np.percentile(fluid["pressure"], [0.5, 99.5]) if known else (0.0, 1.0)
    shear = np.percentile(np.abs(structure["stress_xy"]), 99.5) if structure is not None else 1.0
    return (min(float(lowest), 0.0), max(float(highest), 1e-9)), (-max(float(shear), 1e-9), max(float(shear), 1e-9))


def _foot(structure):
    """(centre, half width) of the zoom: where the clamped part of the structure ends; None without a clamp."""
    clamped = structure.get("clamped", np.zeros(1)).astype(bool)
    if clamped.shape != structure["position"].shape[:1] or not clamped.any() or clamped.all():
        return None
    held, free = structure["position"][clamped], structure["position"][~clamped]
    gap = np.linalg.norm(held[:, None, :2] - free[None, :, :2], axis=2).min(axis=1)
    edge = held[gap < 1.5 * gap.min()][:, :2]
    return edge.mean(axis=0), 0.22 * max(np.ptp(free[:, 0]), np.ptp(free[:, 1]))


def read(run, time):
    """(time, fields of the fluid, fields of the structure) of the frame nearest to `time`; None for a side that has none."""
    frames = {process: run.frame(process, time) for process in ("fluid", "structure")}
    exact = next(frame[0] for frame in frames.values() if frame is not None)
    if frames["structure"] is not None:  # a foreign structure may know no stress
        structure = frames["structure"][1]
        structure.setdefault("stress_xy", np.zeros(len(structure["position"])))
    return exact, *(frame[1] if frame is not None else None for frame in frames.values())


def picture(run, time):
    """RUN/plots/field_<time>.png; returns its path."""
    exact, fluid, structure = read(run, time)
    figure, axis = plt.subplots(figsize=(10, 6.5), layout="constrained")
    drawn = panel(axis, run, fluid, structure, limits_of(fluid, structure))
    axis.set_ylabel("y [m]")
    axis.set_title(f"{run.title}, t = {exact:.3f} s", loc="left")
    colour_bars(figure, axis, drawn, shrink=0.75)
    return style.save(figure, run, f"field_{exact:.3f}s")


def colour_bars(figure, axes, drawn, **options):
    """One bar for each side that was drawn."""
    for mappable, label in zip(drawn, ("pressure p of the fluid [Pa]", "shear stress $\\sigma_{xy}$ of the structure [Pa]")):
        if mappable is not None:
            bar = figure.colorbar(mappable, ax=axes, pad=0.02, label=label, **options)
            bar.formatter.set_powerlimits((-3, 4))


def panel(axis, run, fluid, structure, limits):
    """Both sides, with the foot of a clamped structure enlarged; returns the mappable of each (None where absent)."""
    drawn = _draw(axis, run, fluid, structure, limits)
    axis.autoscale_view()
    _frame_view(axis, run, fluid, structure)
    axis.set_xlabel("x [m]")
    foot = _foot(structure) if structure is not None and fluid is not None else None
    if foot is not None:
        (x, y), half = foot
        inset = axis.inset_axes([0.03, 0.52, 0.34, 0.45])
        _draw(inset, run, fluid, structure, limits)
        inset.set_xlim(x - 1.2 * half, x + 1.2 * half)
        inset.set_ylim(y - 0.4 * half, y + 1.6 * half)
        inset.set_xticks([])
        inset.set_yticks([])
        for spine in inset.spines.values():
            spine.set_visible(True)
        axis.indicate_inset_zoom(inset, edgecolor="0.3")
    return drawn


def _frame_view(axis, run, fluid, structure):
    """Axis limits: walls and structure wholly, the fluid but for single drops far away."""
    parts = [np.percentile(fluid["position"][:, :2], (0.2, 99.8), axis=0)] if fluid is not None else []
    if structure is not None:
        parts.append(structure["position"][:, :2])
    parts += [np.array([lower[:2], upper[:2]], dtype=float) for lower, upper, _ in run.wall_boxes()]
    corners = np.concatenate(parts)
    margin = 0.03 * np.ptp(corners, axis=0).max()
    axis.set_xlim(corners[:, 0].min() - margin, corners[:, 0].max() + margin)
    axis.set_ylim(corners[:, 1].min() - margin, corners[:, 1].max() + margin)
