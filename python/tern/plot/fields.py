"""Fields at a time: fluid coloured by pressure, structure by Cauchy shear stress, or both by speed; the interface a black line.

Particles are drawn as discs of their own spacing in metres, so a gap in the picture is a gap in the particles. Of a 3D run
these pictures show a slice, the particles within one spacing of a plane, and say so in their title; scenes.py renders it whole.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.patches import Circle, Rectangle
from matplotlib.ticker import MaxNLocator

from tern.plot import style, walls
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


def spacing_of_each(run, fields, process):
    """The spacing [m] of the body of each particle of a frame."""
    spacings = run.spacings(process)
    if "body" not in fields:
        return np.full(len(fields["position"]), spacings.get(0, np.nan))
    return np.array([spacings[int(body)] for body in fields["body"]])


def _discs(axis, position, values, spacing, colours, limits):
    diameter = 1.15 * spacing  # a little overlap: no white between the discs of a full lattice
    discs = EllipseCollection(diameter, diameter, np.zeros(len(position)), units="xy", offsets=position[:, :2],
                              transOffset=axis.transData, array=values, cmap=colours)
    discs.set_clim(*limits)
    axis.add_collection(discs)
    return discs


def joined(position):
    """Pairs of interface points between which the surface goes, in whatever order the points come: every point with the two of its near
    ones that are near and on opposite sides. The nearest of all may be on the other face of a thin body."""
    if len(position) < 3:
        return np.zeros((0, 2), dtype=int)
    distance = np.linalg.norm(position[:, None, :] - position[None, :, :], axis=2)
    np.fill_diagonal(distance, np.inf)
    near = np.argsort(distance, axis=1)[:, :min(6, len(position) - 1)]
    far = np.take_along_axis(distance, near, axis=1)
    towards = (position[near] - position[:, None, :]) / np.maximum(far, 1e-300)[:, :, None]
    cosine = np.einsum("nad,nbd->nab", towards, towards)
    cost = (far[:, :, None] + far[:, None, :]) * (1 + 2 * (1 + cosine))  # a way straight on is worth five times as long as one back
    out = far > 2.5 * far[:, 1:2]  # bodies have points of their own spacing; the second nearest is on the same face
    cost[out[:, :, None] | out[:, None, :] | np.eye(near.shape[1], dtype=bool)] = np.inf
    both = np.stack(np.unravel_index(cost.reshape(len(near), -1).argmin(axis=1), cost.shape[1:]), axis=1)
    found = np.take_along_axis(near, both, axis=1)
    return np.stack([np.repeat(np.arange(len(position)), 2), found.ravel()], axis=1)


def _outline(axis, position):
    axis.add_collection(LineCollection(position[joined(position)], colors="black", linewidths=1.0))


class Cut:
    """The plane of a slice of a 3D run: the coordinate `direction` (0, 1, 2) is `at` [m]; shown is what is within `reach` [m] of it."""

    def __init__(self, direction, at):
        self.direction, self.at = direction, at
        self.kept = [axis for axis in range(3) if axis != direction]

    def text(self, reach):
        return f"slice at {'xyz'[self.direction]} = {self.at:.4g} m (particles within {reach:.2g} m of it)"


def middle_cut(run):
    """The plane through the middle of all particles of the first frame, across z."""
    depth = [frames[0]["position"][:, 2] for frames in map(run.frames_of, ("fluid", "structure")) if frames and len(frames[0]["position"])]
    if not depth:
        return Cut(2, 0.0)
    depth = np.concatenate(depth)
    return Cut(2, 0.5 * (float(depth.min()) + float(depth.max())))


def flat(run, fields, process, cut):
    """The fields a flat picture shows, positions with two columns: all in 2D, in 3D what is within one spacing of the plane of `cut`."""
    if fields is None:
        return None
    if cut is None:
        return fields | {name: fields[name][:, :2] for name in ("position", "surface_position") if name in fields}
    reach, count = run.spacing(process), len(fields["position"])
    shown = np.abs(fields["position"][:, cut.direction] - cut.at) <= spacing_of_each(run, fields, process)
    result = {name: values[shown] if len(values) == count else values for name, values in fields.items()}
    result["position"] = result["position"][:, cut.kept]
    if "surface_position" in fields:
        surface = fields["surface_position"]
        result["surface_position"] = surface[np.abs(surface[:, cut.direction] - cut.at) <= 0.6 * reach][:, cut.kept]
    return result


def gauge_places(run, structure):
    """Where the gauges are in a frame of the structure: those of a body are carried along by the particle that was nearest at the start."""
    places = run.contents.get("gauge_places", [])
    carried = {gauge["name"] for gauge in run.settings.get("gauge", []) if "body" in gauge}
    if structure is None or not carried or not len(structure["position"]):
        return places
    first = run.frames_of("structure")[0]
    if len(first["position"]) != len(structure["position"]):
        return places

    def moved(place):
        if place["name"] not in carried or "at" not in place:
            return place
        nearest = np.argmin(np.linalg.norm(first["position"] - place["at"], axis=1))
        return place | {"at": list(place["at"] + structure["position"][nearest] - first["position"][nearest])}
    return [moved(place) for place in places]


def draw_gauges(axis, places, kept=(0, 1)):
    """Marks gauges at their places: points, lines, and discs of the size of a sensor."""
    kept = list(kept)
    for place in places:
        if "from" in place:
            (x0, y0), (x1, y1) = (np.array(place[end])[kept] for end in ("from", "to"))
            axis.plot([x0, x1], [y0, y1], color="tab:red", linewidth=1.0, linestyle="--")
            x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
        else:
            x, y = np.array(place["at"])[kept]
            axis.plot(x, y, marker="+", color="tab:red", markersize=5, linestyle="none")
            if "diameter" in place:
                axis.add_patch(Circle((x, y), 0.5 * place["diameter"], fill=False, edgecolor="tab:red", linewidth=0.8))
        axis.annotate(style.plain(place["name"]), (x, y), xytext=(3, 3), textcoords="offset points", color="tab:red", fontsize=6,
                      annotation_clip=True)


def _draw_walls(axis, placed, cut, view):
    """The outlines of the walls where they are; in a corner the names of those of which nobody knows that."""
    for wall, place in placed:
        if place is None:
            continue
        lines = walls.cut(wall, place, cut.direction, cut.at, view) if cut else place(walls.outline(wall).reshape(-1, 2)).reshape(-1, 2, 2)
        axis.add_collection(LineCollection(lines, colors="0.35", linewidths=1.5))
    if lost := [wall["name"] for wall, place in placed if place is None]:
        axis.text(0.99, 0.99, style.plain(f"not drawn, the frames do not say where they are: {', '.join(lost)}"), ha="right", va="top",
                  transform=axis.transAxes, fontsize=8, color="tab:red")


def _draw(axis, run, fluid, structure, limits, field, placed, cut, view):
    """Draws both sides; returns the mappable of each (None where absent)."""
    drawn = [None, None]
    (_, fluid_colours, of_fluid), (_, structure_colours, of_structure) = FIELDS[field]
    _draw_walls(axis, placed, cut, view)
    gauges = gauge_places(run, structure)
    fluid, structure = flat(run, fluid, "fluid", cut), flat(run, structure, "structure", cut)
    if fluid is not None:
        drawn[0] = _discs(axis, fluid["position"], of_fluid(fluid), spacing_of_each(run, fluid, "fluid"), fluid_colours, limits[0])
    if structure is not None:
        drawn[1] = _discs(axis, structure["position"], of_structure(structure), spacing_of_each(run, structure, "structure"),
                          structure_colours, limits[1])
        if "surface_position" in structure:
            _outline(axis, structure["surface_position"])
    draw_gauges(axis, gauges, cut.kept if cut else (0, 1))
    for set_limits, range_ in zip((axis.set_xlim, axis.set_ylim), view):
        set_limits(*range_)
    axis.set_aspect("equal")
    axis.grid(False)
    sides = [high - low for low, high in view]
    for side, ticks in zip(sides, (axis.xaxis, axis.yaxis)):  # along the shorter one the numbers would run into each other
        ticks.set_major_locator(MaxNLocator(int(np.clip(8 * side / max(sides), 3, 8))))
    return drawn


def limits_of(fluid, structure):
    """Colour ranges: pressure between its outermost half per cents and 0, shear stress symmetric about 0."""
    known = fluid is not None and len(fluid["pressure"]) > 0
    lowest, highest = np.percentile(fluid["pressure"], [0.5, 99.5]) if known else (0.0, 1.0)
    shear = np.percentile(np.abs(structure["stress_xy"]), 99.5) if structure is not None else 1.0
    return (min(float(lowest), 0.0), max(float(highest), 1e-9)), (-max(float(shear), 1e-9), max(float(shear), 1e-9))


def displacement(structure, first):
    """How far each particle of the structure is from where it was [m]; `first`: its fields in the first frame."""
    if "displacement" in structure:
        return np.linalg.norm(structure["displacement"], axis=1)
    if first is None or len(first["position"]) != len(structure["position"]):
        return np.zeros(len(structure["position"]))
    return np.linalg.norm(structure["position"] - first["position"], axis=1)


def focus(run, structure, view):
    """(number of the particle, half width [m]) of an enlargement of what moves most; None where nothing moves, or the picture shows it
    large enough already."""
    if structure is None or len(structure["position"]) == 0:
        return None
    moved = displacement(structure, run.frames_of("structure")[0])
    number = int(np.argmax(moved))
    if moved[number] == 0:
        return None
    own = structure["position"][structure["body"] == structure["body"][number]] if "body" in structure else structure["position"]
    size = np.ptp(own, axis=0).max()
    return (number, 0.6 * size) if size < 0.35 * max(high - low for low, high in view) else None


def read(run, time):
    """(time, fields of the fluid, fields of the structure) of the frame nearest to `time`; None for a side that has none."""
    found = [nearest(run.frames_of(process), time) for process in ("fluid", "structure")]
    exact = next(frame.time for frame in found if frame is not None)
    fluid, structure = (None if frame is None else dict(frame) for frame in found)
    if structure is not None:  # a foreign structure may know no stress
        structure.setdefault("stress_xy", np.zeros(len(structure["position"])))
        structure.setdefault("velocity", np.zeros((len(structure["position"]), 3)))
    return exact, fluid, structure


def axes_of(with_focus, **options):
    """(figure, axes of the whole, axes of the enlargement beside it, or None)."""
    if not with_focus:
        return *plt.subplots(figsize=(10, 6.5), **options), None
    whole, (axis, beside) = plt.subplots(1, 2, figsize=(12.5, 6.5), gridspec_kw={"width_ratios": [3, 1]}, **options)
    return whole, axis, beside


def figure(run, time, cut=None):
    """Both sides at the frame nearest to `time`: (the time of the frame, the figure). Of a 3D run a slice, by default the middle one."""
    exact, fluid, structure = read(run, time)
    cut = (cut or middle_cut(run)) if run.dimension == 3 else None
    view = view_of(run, fluid, structure, cut)
    shown = focus(run, structure, view) if fluid is not None else None
    whole, axis, beside = axes_of(shown, layout="constrained")
    drawn = panel(axis, run, fluid, structure, limits_of(fluid, structure), view=view, cut=cut, shown=shown, beside=beside)
    title(axis, run, exact, cut)
    colour_bars(whole, [axis, beside] if beside else axis, drawn, shrink=0.75)
    return exact, whole


def title(axis, run, time, cut):
    reach = max(filter(None, map(run.spacing, ("fluid", "structure"))))
    slice_ = f"\n{cut.text(reach)}" if cut else ""
    axis.set_title(f"{style.plain(run.title)}, t = {time:.3f} s{slice_}", loc="left")


def colour_bars(whole, axes, drawn, field="pressure", **options):
    """One bar for each side that was drawn; one for both where they share a scale."""
    bars = {label: mappable for mappable, (label, _, _) in zip(drawn, FIELDS[field]) if mappable is not None}
    for label, mappable in bars.items():
        bar = whole.colorbar(mappable, ax=axes, pad=0.02, label=label, **options)
        bar.formatter.set_powerlimits((-3, 4))


def panel(axis, run, fluid, structure, limits, field="pressure", view=None, cut=None, shown=None, beside=None):
    """Both sides; returns the mappable of each (None where absent).

    `view` ((x, x), (y, y)) holds still over a film. `shown` of focus(): what the axes `beside` show enlarged, a rectangle says where.
    """
    placed = walls.placed(run.settings.get("wall", []), fluid)
    view = view or view_of(run, fluid, structure, cut)
    drawn = _draw(axis, run, fluid, structure, limits, field, placed, cut, view)
    kept = cut.kept if cut else [0, 1]
    axis.set_xlabel(f"{'xyz'[kept[0]]} [m]")
    axis.set_ylabel(f"{'xyz'[kept[1]]} [m]")
    if shown is not None:
        (x, y), half = structure["position"][shown[0]][kept], shown[1]
        near = ((x - half, x + half), (y - half, y + half))
        _draw(beside, run, fluid, structure, limits, field, placed, cut, near)
        beside.set_xticks([])
        beside.set_yticks([])
        for spine in beside.spines.values():
            spine.set_visible(True)
        beside.set_title(f"{2 * half:.2g} m across, where the\nstructure moved most", loc="left", fontsize=9)
        axis.add_patch(Rectangle((x - half, y - half), 2 * half, 2 * half, fill=False, edgecolor="black", linewidth=1.0))
    return drawn


def view_of(run, fluid, structure, cut=None):
    """((x, x), (y, y)) [m]: walls and structure wholly, the fluid but for single drops far away."""
    known = fluid is not None and len(fluid["position"]) > 0
    kept = cut.kept if cut else [0, 1]
    parts = [np.percentile(fluid["position"][:, kept], (0.2, 99.8), axis=0)] if known else []
    if structure is not None:
        parts.append(structure["position"][:, kept])
    parts += [place(walls.corners(wall))[:, kept] for wall, place in walls.placed(run.settings.get("wall", []), fluid) if place]
    corners = np.concatenate(parts or [np.array([[0.0, 0.0], [1.0, 1.0]])])
    margin = 0.03 * np.ptp(corners, axis=0).max()
    return tuple((float(low - margin), float(high + margin)) for low, high in zip(corners.min(axis=0), corners.max(axis=0)))
