"""Fields at a time: fluid coloured by pressure, structure by Cauchy shear stress, or both by speed; the interface a black line.

Particles are drawn as discs of their own spacing in metres, so a gap in the picture is a gap in the particles. In 3D
the picture shows the particles within one spacing of the middle plane.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.patches import Circle

from tern.plot import style
from tern.results.frames import nearest

# For each field a film can show: what colours the fluid, what the structure.
PRESSURE = ("pressure p of the fluid [Pa]", "turbo", lambda side: side["pressure"])
SHEAR = ("shear stress $\\sigma_{xy}$ of the structure [Pa]", "PuOr_r", lambda side: side["stress_xy"])
SPEED = ("speed |u| [m/s]", "viridis", lambda side: np.linalg.norm(side["velocity"], axis=1))
FIELDS = {"pressure": (PRESSURE, SHEAR), "speed": (SPEED, SPEED)}


def times_of(run):
    """The times of the frames [s], of the fluid if there is one."""
    return [frame.time for frame in run.frames_of("fluid") or run.frames_of("structure")]


def choose_times(run, times):
    """The frames asked for, or four spread over the run, without repetitions."""
    existing = times_of(run)
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


def _draw_gauges(axis, run):
    """Where the gauges of the case are at the start: points, lines, and discs of the size of a sensor."""
    for place in run.contents.get("gauge_places", []):
        if "from" in place:
            (x0, y0), (x1, y1) = place["from"][:2], place["to"][:2]
            axis.plot([x0, x1], [y0, y1], color="tab:red", linewidth=1.0, linestyle="--")
            x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
        else:
            x, y = place["at"][:2]
            axis.plot(x, y, marker="+", color="tab:red", markersize=5, linestyle="none")
            if "diameter" in place:
                axis.add_patch(Circle((x, y), 0.5 * place["diameter"], fill=False, edgecolor="tab:red", linewidth=0.8))
        axis.annotate(style.plain(place["name"]), (x, y), xytext=(3, 3), textcoords="offset points", color="tab:red", fontsize=6)


def _draw(axis, run, fluid, structure, limits, field):
    """Draws both sides; returns the mappable of each (None where absent)."""
    drawn = [None, None]
    (_, fluid_colours, of_fluid), (_, structure_colours, of_structure) = FIELDS[field]
    for lower, upper, open_faces in run.wall_boxes():
        (x0, y0), (x1, y1) = lower[:2], upper[:2]
        sides = {"x_min": ((x0, y0), (x0, y1)), "x_max": ((x1, y0), (x1, y1)), "y_min": ((x0, y0), (x1, y0)),
                 "y_max": ((x0, y1), (x1, y1))}
        axis.add_collection(LineCollection([line for face, line in sides.items() if face not in open_faces],
                                           colors="0.35", linewidths=1.5))
    if fluid is not None:
        shown = _middle(fluid, run.spacing("fluid"))
        drawn[0] = _discs(axis, fluid["position"][shown], of_fluid(fluid)[shown], run.spacing("fluid"), fluid_colours, limits[0])
    if structure is not None:
        shown = _middle(structure, run.spacing("structure"))
        drawn[1] = _discs(axis, structure["position"][shown], of_structure(structure)[shown], run.spacing("structure"),
                          structure_colours, limits[1])
        if "surface_position" in structure and len(structure["surface_position"]):
            surface = structure["surface_position"]
            _outline(axis, surface[np.abs(surface[:, 2] - np.median(surface[:, 2])) <= run.spacing("structure")][:, :2])
    _draw_gauges(axis, run)
    axis.set_aspect("equal")
    axis.grid(False)
    return drawn


def limits_of(fluid, structure):
    """Colour ranges: pressure between its outermost half per cents and 0, shear stress symmetric about 0."""
    known = fluid is not None and len(fluid["pressure"]) > 0
    lowest, highest = np.percentile(fluid["pressure"], [0.5, 99.5]) if known else (0.0, 1.0)
    shear = np.percentile(np.abs(structure["stress_xy"]), 99.5) if structure is not None else 1.0
    return (min(float(lowest), 0.0), max(float(highest), 1e-9)), (-max(float(shear), 1e-9), max(float(shear), 1e-9))


def foot(structure):
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
    found = [nearest(run.frames_of(process), time) for process in ("fluid", "structure")]
    exact = next(frame.time for frame in found if frame is not None)
    fluid, structure = (None if frame is None else dict(frame) for frame in found)
    if structure is not None:  # a foreign structure may know no stress
        structure.setdefault("stress_xy", np.zeros(len(structure["position"])))
        structure.setdefault("velocity", np.zeros((len(structure["position"]), 3)))
    return exact, fluid, structure


def figure(run, time):
    """Both sides at the frame nearest to `time`: (the time of the frame, the figure)."""
    exact, fluid, structure = read(run, time)
    whole, axis = plt.subplots(figsize=(10, 6.5), layout="constrained")
    drawn = panel(axis, run, fluid, structure, limits_of(fluid, structure))
    axis.set_ylabel("y [m]")
    axis.set_title(f"{style.plain(run.title)}, t = {exact:.3f} s", loc="left")
    colour_bars(whole, axis, drawn, shrink=0.75)
    return exact, whole


def colour_bars(whole, axes, drawn, field="pressure", **options):
    """One bar for each side that was drawn; one for both where they share a scale."""
    bars = {label: mappable for mappable, (label, _, _) in zip(drawn, FIELDS[field]) if mappable is not None}
    for label, mappable in bars.items():
        bar = whole.colorbar(mappable, ax=axes, pad=0.02, label=label, **options)
        bar.formatter.set_powerlimits((-3, 4))


def panel(axis, run, fluid, structure, limits, field="pressure", view=None, foot_half=None):
    """Both sides, with the foot of a clamped structure enlarged; returns the mappable of each (None where absent).

    `view` ((x, x), (y, y)) and `foot_half`, the half width of the enlargement, hold still over a film.
    """
    drawn = _draw(axis, run, fluid, structure, limits, field)
    for set_limits, range_ in zip((axis.set_xlim, axis.set_ylim), view or view_of(run, fluid, structure)):
        set_limits(*range_)
    axis.set_xlabel("x [m]")
    place = foot(structure) if structure is not None and fluid is not None else None
    if place is not None:
        (x, y), half = place[0], foot_half or place[1]
        inset = axis.inset_axes([0.03, 0.52, 0.34, 0.45])
        _draw(inset, run, fluid, structure, limits, field)
        inset.set_xlim(x - 1.2 * half, x + 1.2 * half)
        inset.set_ylim(y - 0.4 * half, y + 1.6 * half)
        inset.set_xticks([])
        inset.set_yticks([])
        for spine in inset.spines.values():
            spine.set_visible(True)
        axis.indicate_inset_zoom(inset, edgecolor="0.3")
    return drawn


def view_of(run, fluid, structure):
    """((x, x), (y, y)) [m]: walls and structure wholly, the fluid but for single drops far away."""
    known = fluid is not None and len(fluid["position"]) > 0
    parts = [np.percentile(fluid["position"][:, :2], (0.2, 99.8), axis=0)] if known else []
    if structure is not None:
        parts.append(structure["position"][:, :2])
    parts += [np.array([lower[:2], upper[:2]], dtype=float) for lower, upper, _ in run.wall_boxes()]
    corners = np.concatenate(parts or [np.array([[0.0, 0.0], [1.0, 1.0]])])
    margin = 0.03 * np.ptp(corners, axis=0).max()
    return tuple((float(low - margin), float(high + margin)) for low, high in zip(corners.min(axis=0), corners.max(axis=0)))
