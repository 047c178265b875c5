"""A case as it stands before the first step: what it describes, where it is, and where walls and clamps go.

Particles and motions are those of `tern-case scene`, which fills the bodies and places the walls as the processes do. Lengths are in m.
"""

from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import OffsetFrom
from matplotlib.transforms import ScaledTranslation

from tern.errors import BAD_INPUT, INPUT_OUTPUT, Error
from tern.plot import fields, render, scenes, style, walls

MOST_PARTICLES = 300_000  # of a scene; of a larger one the outlines of the shapes are drawn
FLUID, CLAMPED, MOVING, LOAD = "#7fb2e5", "black", "#b05a00", "#7a2f9c"
BODIES = style.RUN_COLOURS[1:]
MOST_NAMES = 12  # of bodies in the legend; those after are counted


@dataclass
class Body:
    """A fluid or structure body. `points` is None where the scene has too many."""

    kind: str
    name: str
    spacing: float
    count: int
    colour: str
    shape: dict
    points: np.ndarray | None = None
    clamped: np.ndarray | None = None
    clamped_count: int = 0
    velocity: list = ()
    fastest: float = 0.0


def _points(rows, step, dimension):
    """The points of rows along x: (x, y[, z] of the first, how many)."""
    if not rows:
        return np.zeros((0, dimension))
    rows = np.array(rows)
    count = rows[:, -1].astype(int)
    points = np.repeat(rows[:, :dimension], count, axis=0)
    points[:, 0] += step * (np.arange(len(points)) - np.repeat(np.cumsum(count) - count, count))
    return points


def bodies_of(settings, start):
    """[Body] of the answer of tern-case scene."""
    shapes = [body["shape"] for side in ("fluid", "structure") for body in settings.get(side, {}).get("body", [])]
    result, number = [], 0
    for said, shape in zip(start["bodies"], shapes):
        colour = FLUID if said["kind"] == "fluid" else BODIES[number % len(BODIES)]
        number += said["kind"] != "fluid"
        body = Body(said["kind"], said["name"], said["spacing"], said["count"], colour, shape, clamped_count=said.get("clamped", 0),
                    velocity=said["velocity"], fastest=said["fastest"])
        if "rows" in said:
            body.points = _points(said["rows"], said["step"], settings["dimension"])
            body.clamped = _points(said.get("clamped_rows", []), said["step"], settings["dimension"])
        result.append(body)
    return result


def _place(entry):
    """What maps points as they are in the case to where they are at an entry of a path."""
    origin, *ends = np.array(entry["place"])
    return lambda points: origin + np.asarray(points, dtype=float) @ (np.array(ends) - origin)


def placed_walls(settings, start):
    """[(wall, place at t = 0)], as walls.placed() for a frame."""
    return [(wall, _place(said["path"][0]) if "path" in said else lambda points: points)
            for wall, said in zip(settings.get("wall", []), start["walls"])]


@dataclass
class Motion:
    """What moves: `path` [n, D] of the corner that goes farthest, to where it is farthest away, and a sentence with `name`."""

    name: str
    path: np.ndarray
    text: str
    farthest: object = None


def _motion(name, path, corners, settings):
    middle = corners.mean(axis=0, keepdims=True)
    shift = np.linalg.norm(np.array([_place(entry)(middle)[0] for entry in path]) - _place(path[0])(middle)[0], axis=1).max()
    turn = max((entry["angle"] - path[0]["angle"] for entry in path), key=abs)
    followed = np.array([_place(entry)(corners if turn else middle) for entry in path])
    away = np.linalg.norm(followed - followed[0], axis=2)
    number, corner = np.unravel_index(np.argmax(away), away.shape)
    parts = [f"its middle moves by up to {shift:.3g} m"] if shift > 1e-9 * np.ptp(corners, axis=0).max() else []
    parts += [f"turns by {np.degrees(turn):.3g}°"] if turn else []
    what = " and ".join(parts) or "does not move"
    return Motion(name, followed[:number + 1, corner], f"{name}: {what} within {settings['end_time']:g} s",
                  _place(path[number]))


def motions_of(settings, start):
    """[Motion] of the walls and clamps that move."""
    found = [_motion(wall["name"], said["path"], walls.corners(wall), settings)
             for wall, said in zip(settings.get("wall", []), start["walls"]) if "path" in said]
    clamps = settings.get("structure", {}).get("clamp", [])
    return found + [_motion(f"clamp {clamp['name']}", said["path"], walls.corners({"obstacle": clamp["region"]}), settings)
                    for clamp, said in zip(clamps, start["clamps"]) if "path" in said]


def _loads(settings):
    return settings.get("structure", {}).get("load", [])


def _count(number, what):
    return f"{number:,} {what}".replace(",", " ")


def _handle(colour, marker="o"):
    return Line2D([], [], color=colour, marker=marker, linestyle="none", markersize=6)


def legend_of(settings, start, bodies, motions, places):
    """[(handle, text)] of all that is drawn."""
    lines = []
    fluid = [body for body in bodies if body.kind == "fluid"]
    if fluid:
        number = f"fluid ({len(fluid)} bodies)" if len(fluid) > 1 else "fluid"
        total = _count(sum(body.count for body in fluid), "particles")
        lines.append((_handle(FLUID), f"{number}: {total}, spacing {fluid[0].spacing:.4g} m"))
    solids = [body for body in bodies if body.kind != "fluid"]
    lines += [(_handle(body.colour), f"{body.name}: {_count(body.count, 'particles')}, spacing {body.spacing:.4g} m")
              for body in solids[:MOST_NAMES]]
    if len(solids) > MOST_NAMES:
        rest = solids[MOST_NAMES:]
        lines.append((_handle("0.5"), f"{len(rest)} more bodies: {_count(sum(body.count for body in rest), 'particles')}"))
    if clamped := sum(body.clamped_count for body in bodies):
        lines.append((_handle(CLAMPED), f"held: {_count(clamped, 'particles')}"))
    if names := [wall["name"] + (" (open: " + ", ".join(wall["open"]) + ")" if wall.get("open") else "")
                 for wall in settings.get("wall", [])]:
        lines.append((Line2D([], [], color="0.35"), "walls: " + ", ".join(names)))
    lines += [(Line2D([], [], color=MOVING, linestyle=":", marker=">"), motion.text) for motion in motions]
    for load in _loads(settings):
        kind = next(key for key in ("traction", "pressure", "body_force") if key in load)
        lines.append((Line2D([], [], color=LOAD, linestyle="-."), f"load {load['name']}: {kind.replace('_', ' ')} on {load['body']}"
                      + ("" if "region" in load else ", all of it")))
    if any(start["periodic"]):
        sides = ", ".join(name for name, periodic in zip("xyz", start["periodic"]) if periodic)
        lines.append((Line2D([], [], color="tab:green", linestyle="--"),
                      f"periodic in {sides}: what leaves at one side enters at the other"))
    shown = {place["name"] for place in places}
    if shown:
        lines.append((Line2D([], [], color="tab:red", marker="+", linestyle="--"), f"gauges: {', '.join(sorted(shown))}"))
    if others := [f"{gauge['name']} ({gauge['kind'].replace('_', ' ')})" for gauge in settings.get("gauge", [])
                  if gauge["name"] not in shown]:
        lines.append((Line2D([], [], linestyle="none"), f"gauges not drawn: {', '.join(others)}"))
    if fastest := max((body.fastest for body in bodies), default=0.0):
        lines.append((Line2D([], [], color="0.2", marker=r"$\rightarrow$", linestyle="none", markersize=9),
                      f"velocity at the start, up to {fastest:.3g} m/s"))
    return lines


def _gravity_text(settings, start):
    size = float(np.linalg.norm(start["gravity"]))
    if any(isinstance(part, str) for part in settings.get("gravity", [])):
        return f"gravity at t = 0 in the middle: {size:.4g} m/s$^2$"
    return f"gravity {size:.4g} m/s$^2$" if size else "no gravity"


def _too_many(start):
    return f"outlines only: of {start['count']:.3g} particles, more than {MOST_PARTICLES:.0e}, none are drawn"


def _discs(axis, points, spacing, colour):
    if len(points) == 0:
        return
    size = np.full(len(points), spacing)
    axis.add_collection(EllipseCollection(size, size, np.zeros(len(points)), units="xy", offsets=points, transOffset=axis.transData,
                                          facecolors=colour, edgecolors="none"))


def _lines(axis, pieces, **options):
    axis.add_collection(LineCollection(pieces, **options))


def _moved(lines, place):
    return place(lines.reshape(-1, 2)).reshape(-1, 2, 2)


def _outline(shape):
    return walls.outline({"obstacle": shape})


def _draw_flat(axis, settings, start, bodies, motions, places, view):
    for body in bodies:
        if body.points is None:
            _lines(axis, _outline(body.shape), colors=body.colour, linewidths=2)
        else:
            _discs(axis, body.points, body.spacing, body.colour)
            _discs(axis, body.clamped, body.spacing, CLAMPED)
        if body.velocity:
            velocity = np.array(body.velocity)
            axis.quiver(*velocity[:, 0].T, *velocity[:, 1].T, color="0.2", width=0.002)
    for (wall, place), motion in zip(placed_walls(settings, start), _motion_of_walls(start, motions)):
        _lines(axis, _moved(walls.outline(wall), place), colors="0.35" if motion is None else MOVING, linewidths=1.5)
        if motion is not None:
            _lines(axis, _moved(walls.outline(wall), motion.farthest), colors=MOVING, linewidths=0.8, linestyles=":")
    for load in _loads(settings):
        if "region" in load:
            _lines(axis, _outline(load["region"]), colors=LOAD, linewidths=1.0, linestyles="-.")
    (low, high), ends = np.array(start["domain"]), np.array(start["domain"])
    for direction in np.flatnonzero(start["periodic"]):
        for end in ends[:, direction]:
            side = np.array([low, high])
            side[:, direction] = end
            _lines(axis, [side], colors="tab:green", linewidths=1.5, linestyles="--")
    for motion in motions:
        low, high = np.array(view).T
        if np.any(np.all((motion.path >= low) & (motion.path <= high), axis=1)):
            _arrow(axis, np.clip(motion.path, low, high), motion.name)  # a wall may leave the picture
    fields.draw_gauges(axis, places)
    axis.set_xlim(*view[0])
    axis.set_ylim(*view[1])
    axis.set_aspect("equal")
    axis.grid(False)


def _motion_of_walls(start, motions):
    found = iter(motions)
    return [next(found) if "path" in said else None for said in start["walls"]]


def _arrow(axis, path, name):
    """The path of what moves as a line with a head, and its name."""
    if np.ptp(path, axis=0).max() > 0:
        axis.plot(*path.T, color=MOVING, linewidth=1.0, linestyle=":", scalex=False, scaley=False)
        back = next((point for point in path[::-1] if np.any(point != path[-1])), path[0])
        axis.annotate("", xy=path[-1], xytext=back, arrowprops={"arrowstyle": "-|>", "color": MOVING, "shrinkA": 0, "shrinkB": 0})
    axis.annotate(style.plain(name), path[-1], xytext=(4, -10), textcoords="offset points", color=MOVING, fontsize=8, annotation_clip=True)


def _corners(bodies, dimension):
    parts = []
    for body in bodies:
        if body.points is None or not len(body.points):
            parts.append(walls.corners({"obstacle": body.shape}))
        else:
            half = 0.5 * body.spacing
            parts.append(np.array([body.points.min(axis=0) - half, body.points.max(axis=0) + half]))
    return [part[:, :dimension] for part in parts]


def _view(corners):
    """((x, x), (y, y)) around corners, with a margin."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.04 * (high - low).max()
    return list(zip(low - margin, high + margin))


def _enlarged(bodies, view):
    """The view of an enlargement of the smallest body, None where the picture shows it large enough."""
    whole = max(high - low for low, high in view)
    sizes = [(np.ptp(corners, axis=0).max(), number) for number, corners in enumerate(_corners(bodies, 2))
             if bodies[number].kind != "fluid"]
    if not sizes or min(sizes)[0] > 0.35 * whole:
        return None, None
    size, number = min(sizes)
    middle = _corners(bodies, 2)[number].mean(axis=0)
    return [(float(at - 0.6 * size), float(at + 0.6 * size)) for at in middle], bodies[number].name


def _flat(settings, start, bodies, motions, places):
    outer = [place(walls.corners(wall)) for wall, place in placed_walls(settings, start)]
    outer += [np.array(start["domain"])] if any(start["periodic"]) else []
    view = _view(np.concatenate([*_corners(bodies, 2), *outer]))
    near, name = _enlarged(bodies, view)
    width, height = (high - low for low, high in view)
    ratio = height / width
    size = (11, min(max(2.5 + 9.5 * ratio, 4.5), 10)) if near is None else (13, min(max(2.5 + 8.5 * ratio, 5), 10))
    if near is None:
        figure, axis = plt.subplots(figsize=size, layout="constrained")
    else:
        figure, (axis, beside) = plt.subplots(1, 2, figsize=size, layout="constrained", gridspec_kw={"width_ratios": [3, 1]})
        _draw_flat(beside, settings, start, bodies, motions, places, near)
        beside.set_xticks([])
        beside.set_yticks([])
        for spine in beside.spines.values():
            spine.set_visible(True)
        beside.set_title(style.plain(f"{name},\n{near[0][1] - near[0][0]:.2g} m across"), loc="left", fontsize=9)
        axis.add_patch(Rectangle((near[0][0], near[1][0]), near[0][1] - near[0][0], near[1][1] - near[1][0], fill=False,
                                 edgecolor="black", linewidth=0.8))
    _draw_flat(axis, settings, start, bodies, motions, places, view)
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    pull = np.array(start["gravity"])
    if np.any(pull):
        along = 34 * pull / np.linalg.norm(pull)
        begin = (1.015, 0.99)
        axis.annotate("", xy=along, xycoords=OffsetFrom(axis, begin, "points"), xytext=begin, textcoords="axes fraction",
                      annotation_clip=False, arrowprops={"arrowstyle": "-|>", "color": "0.3", "shrinkA": 0, "shrinkB": 0})
        axis.annotate("g", begin, xycoords="axes fraction", xytext=(6, -12), textcoords="offset points", color="0.3", fontsize=9)
    return figure, axis


def _edges(low, high, direction):
    """The two faces of a box across `direction`, each as a closed line."""
    one, two = (axis for axis in range(3) if axis != direction)
    for end in (low, high):
        face = np.array([low] * 5)
        face[:, direction] = end[direction]
        face[[1, 2], one] = high[one]
        face[[2, 3], two] = high[two]
        yield face


def _rendered(settings, start, bodies, motions, places, look):
    gravity = start["gravity"]
    placed = placed_walls(settings, start)
    outer = [place(walls.corners(wall)) for wall, place in placed]
    outer += [np.array(start["domain"])] if any(start["periodic"]) else []
    box = scenes.box_around([], [*_corners(bodies, 3), *outer], gravity)
    if look.clip:
        axis, at = look.clip
        if not box[0][axis] < at < box[1][axis]:
            raise Error(BAD_INPUT, f"--clip {'xyz'[axis]}={at:g}: the scene reaches from {box[0][axis]:.4g} to {box[1][axis]:.4g} m in "
                                   f"{'xyz'[axis]}; take a plane in between.")
    parts, outlines = [], []
    fluid = [body for body in bodies if body.kind == "fluid"]
    solids = [body for body in bodies if body.kind != "fluid"]
    if bodies and bodies[0].points is not None:
        if fluid:
            water = np.concatenate([body.points for body in fluid])
            opacity = scenes.SEEN_THROUGH if solids and not look.clip else 1.0
            parts.append((water, np.zeros(len(water)), fluid[0].spacing, _scale(FLUID, FLUID), (0, 1), opacity))
        for body in solids:
            clamped = {tuple(point) for point in body.clamped}
            values = np.array([tuple(point) in clamped for point in body.points], dtype=float) if clamped else np.zeros(len(body.points))
            parts.append((body.points, values, body.spacing, _scale(body.colour, CLAMPED), (0, 1), 1.0))
    else:
        from matplotlib.colors import to_rgb
        outlines = [(body.shape, to_rgb(body.colour)) for body in bodies]
    pixels = render.image(parts, placed, box, gravity, look.camera, look.clip, outlines=outlines)
    figure, axis = plt.subplots(figsize=(11, 8.5), layout="constrained")
    axis.imshow(pixels)
    axis.set_axis_off()
    scenes.triad(axis, gravity, look)

    def seen(points):
        return render.projected(points, box, gravity, look.camera)
    low, high = np.array(start["domain"])
    for direction in np.flatnonzero(start["periodic"]):
        for face in _edges(low, high, direction):
            axis.plot(*seen(face).T, color="tab:green", linewidth=1.0, linestyle="--", scalex=False, scaley=False)
    for load in _loads(settings):
        if "region" in load:
            low, high = (part(walls.corners({"obstacle": load["region"]}), axis=0) for part in (np.min, np.max))
            for direction in range(3):
                for face in _edges(low, high, direction):
                    axis.plot(*seen(face).T, color=LOAD, linewidth=0.8, linestyle="-.", scalex=False, scaley=False)
    for motion in motions:
        path = seen(motion.path)
        _arrow(axis, np.clip(path, 0, np.array(render.SIZE) - 1), motion.name)
    scenes.draw_gauges(axis, places, look.camera, box, gravity)
    for body in bodies:
        if body.velocity:
            for place, velocity in np.array(body.velocity):
                ends = seen(np.array([place, place + 0.12 * (box[1] - box[0]).max() * velocity / body.fastest]))
                axis.annotate("", xy=ends[1], xytext=ends[0], arrowprops={"arrowstyle": "->", "color": "0.2", "linewidth": 0.7})
    if np.any(pull := np.array(gravity)):
        right, above, _ = render.axes_of(look.camera, gravity)
        along = 45 * np.array([pull @ right, -pull @ above]) / np.linalg.norm(pull)
        axis.annotate("", xy=(1140 + along[0], 60 + along[1]), xytext=(1140, 60), arrowprops={"arrowstyle": "-|>", "color": "0.3"})
        axis.text(1125, 60, "g", ha="right", va="center", fontsize=9, color="0.3")
    axis.text(0.99, -0.01, scenes.below(box, look), ha="right", va="top", transform=axis.transAxes, fontsize=9, color="0.3")
    return figure, axis


def _scale(first, last):
    return LinearSegmentedColormap.from_list("body", [first, last])


def figure_of(case, start, look=None):
    """A case as a figure: what `tern-case json` and `tern-case scene` say of it, in 3D looked at as `look` (scenes.Look) says."""
    settings, places = case["settings"], case["gauge_places"]
    bodies, motions = bodies_of(settings, start), motions_of(settings, start)
    flat = settings["dimension"] == 2
    if flat:
        figure, axis = _flat(settings, start, bodies, motions, places)
    else:
        figure, axis = _rendered(settings, start, bodies, motions, places, look or scenes.Look())
    few = f"\n{_too_many(start)}" if bodies and bodies[0].points is None else ""
    name = style.plain(case["title"] or case["name"])
    axis.set_title(f"{name}, before the first step; {_gravity_text(settings, start)}{few}", loc="left")
    handles, texts = zip(*legend_of(settings, start, bodies, motions, places))
    axis.legend(handles, [style.plain(text) for text in texts], loc="upper left", bbox_to_anchor=(0.0, 0.0),
                bbox_transform=axis.transAxes + ScaledTranslation(0, -0.6 if flat else -0.2, figure.dpi_scale_trans),
                ncols=2 if len(texts) > 4 else 1, frameon=False, fontsize=9)
    return figure


def write(case, start, file, look=None):
    """Draws a case into a file, as figure_of() does; returns its path."""
    style.apply()
    file = Path(file)
    figure = figure_of(case, start, look)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(file, bbox_inches="tight")
    except OSError as error:
        raise Error(INPUT_OUTPUT, f"The picture {file} could not be written ({error.strerror or error}); name another file after "
                                  "--picture.") from None
    finally:
        plt.close(figure)
    return file
