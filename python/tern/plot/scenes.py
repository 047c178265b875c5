"""Pictures of a run as its dimension asks for: flat in 2D, in 3D rendered or, where a plane is given, a slice."""

from dataclasses import dataclass, field as default

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from tern.errors import BAD_INPUT, Error
from tern.plot import fields, render, style, walls

MISES = ("von Mises stress of the structure [Pa]", "YlOrRd", lambda side: side["von_mises"])
FIELDS = fields.FIELDS | {"pressure": (fields.PRESSURE, MISES)}
SEEN_THROUGH = 0.4  # opacity of water that bodies may be in; a cut opens it anyway
LABEL = (110, 14)  # room for the name of a gauge [pixels]
HEADROOM = 0.25  # above what is in an open tank is shown, of the longest other side


@dataclass
class Look:
    """How a 3D run is looked at. `clip` and `slice`: (direction, coordinate [m]) or None."""

    camera: render.Camera = default(default_factory=render.Camera)
    clip: tuple | None = None
    slice: tuple | None = None


@dataclass
class Changing:
    """What a film draws anew in each picture: the image of the scene, and the marks of the gauges."""

    image: object
    gauges: list


def name_of(look):
    """What a file's name says of how a run is looked at: "" by default, else for example "_clip_z0.1"."""
    look = look or Look()
    planes = "".join(f"_{kind}_{'xyz'[plane[0]]}{plane[1]:g}" for kind, plane in (("clip", look.clip), ("slice", look.slice)) if plane)
    camera = look.camera
    turned = "" if camera == render.Camera() else f"_camera_{camera.azimuth:g}_{camera.elevation:g}"
    return planes + turned + (f"_{camera.zoom:g}" if camera.zoom != 1 else "")


def is_rendered(run, look):
    return run.dimension == 3 and not (look and look.slice)


def box_of(run, fluid, structure):
    """(lower, upper corner) [m] of what is shown: all there is but single drops far away, of the walls above it only a part."""
    inner = [np.percentile(side["position"], spread, axis=0) for side, spread in ((fluid, (0.2, 99.8)), (structure, (0, 100)))
             if side is not None and len(side["position"])]
    outer = [place(walls.corners(wall)) for wall, place in walls.placed(run.settings.get("wall", []), fluid) if place]
    return box_around(inner, outer, run.settings.get("gravity", []))


def box_around(inner, outer, gravity):
    """The same of the corners of what is inside and of the walls, lists of arrays [n, 3]."""
    corners = np.concatenate([*inner, *outer] or [np.array([[0.0] * 3, [1.0] * 3])])
    low, high = corners.min(axis=0), corners.max(axis=0)
    _, up, _ = render.basis(gravity)
    axis = int(np.argmax(np.abs(up)))
    if inner:
        room = HEADROOM * max(np.delete(high - low, axis))
        content = np.concatenate(inner)[:, axis]
        if up[axis] > 0:
            high[axis] = min(high[axis], content.max() + room)
        else:
            low[axis] = max(low[axis], content.min() - room)
    return low, high


def limits_of(fluid, structure):
    """Colour ranges: of the pressure as in 2D, of the von Mises stress from 0 to its outermost half per cent."""
    pressure, _ = fields.limits_of(fluid, None)
    known = structure is not None and "von_mises" in structure and len(structure["von_mises"])
    return pressure, (0.0, max(float(np.percentile(structure["von_mises"], 99.5)), 1e-9) if known else 1.0)


def check(run, plane, box, option):
    """Refuses a plane that is not inside the scene."""
    axis, at = plane
    if not box[0][axis] < at < box[1][axis]:
        raise Error(BAD_INPUT, f"{option} {'xyz'[axis]}={at:g}: {run.directory} reaches from {box[0][axis]:.4g} to {box[1][axis]:.4g} m in "
                               f"{'xyz'[axis]}; take a plane in between.")


def in_layers(side, values, spacing):
    """(position, value) of the particles of a body so that they fill it: a shell thicker than its spacing is several layers.

    Its normal at a particle is across the plane that fits the eight nearest ones best.
    """
    position, thickness = side["position"], side.get("shell_thickness")
    if thickness is None or thickness.max() < 1.5 * spacing:
        return position, values
    count = round(float(thickness[0]) / spacing)
    normal = np.empty_like(position)
    for number, x in enumerate(position):
        squared = np.sum((position - x) ** 2, axis=1)
        near = position[np.argpartition(squared, min(8, len(position) - 1))[:9]]
        normal[number] = np.linalg.svd(near - near.mean(axis=0))[2][-1]
    heights = ((np.arange(count) + 0.5) / count - 0.5) * float(thickness[0])
    return np.concatenate([position + height * normal for height in heights]), np.tile(values, count)


def bodies_of(run, process, side):
    """[(number, fields of its particles, spacing [m])] of the bodies of a frame; the fluid is one."""
    numbers = side["body"] if "body" in side else np.zeros(len(side["position"]), dtype=int)
    count = len(numbers)
    return [(int(body), {name: values[numbers == body] for name, values in side.items() if len(values) == count},
             run.spacings(process)[int(body)]) for body in np.unique(numbers)]


def pixels(run, fluid, structure, limits, field, box, look):
    """A frame, rendered."""
    parts = []
    for process, side, (_, colours, values), range_ in zip(("fluid", "structure"), (fluid, structure), FIELDS[field], limits):
        if side is None or len(side["position"]) == 0:
            continue
        known = values is not MISES[2] or "von_mises" in side
        is_hiding = process == "fluid" and structure is not None and not look.clip
        for _, body, spacing in bodies_of(run, process, side):
            place, value = in_layers(body, values(body) if known else np.zeros(len(body["position"])), spacing)
            parts.append((place, value, spacing, colours if known else None, range_, SEEN_THROUGH if is_hiding else 1.0))
    placed = walls.placed(run.settings.get("wall", []), fluid)
    return render.image(parts, placed, box, run.settings.get("gravity", []), look.camera, look.clip), [
        wall["name"] for wall, place in placed if place is None]


def triad(axis, gravity, look):
    """The axes of the scene in the lower left corner, as the camera sees them."""
    right, above, _ = render.axes_of(look.camera, gravity)
    for direction, name in enumerate("xyz"):
        end = 45 * np.array([right[direction], above[direction]])
        axis.annotate("", xy=(60 + end[0], 740 - end[1]), xytext=(60, 740), arrowprops={"arrowstyle": "->", "color": "0.3"})
        axis.text(60 + 1.35 * end[0], 740 - 1.35 * end[1], name, ha="center", va="center", fontsize=9, color="0.3")


def draw_gauges(axis, places, camera, box, gravity):
    """Marks gauges at their places, in front of all else: points, rectangles, and for discs their middle. Returns what it has drawn."""
    drawn, rows = [], []
    for place in places:
        if "from" in place:  # opposite corners of a rectangle
            low, high = np.array(place["from"]), np.array(place["to"])
            one = np.eye(3)[(int(np.argmin(np.abs(high - low))) + 1) % 3] * (high - low)
            points = [low, low + one, high, high - one, low]
        else:
            points = [place["at"]]
        seen = render.projected(points, box, gravity, camera)
        drawn += axis.plot(*seen.T, color="tab:red", linewidth=1.0, linestyle="--", marker="+", markersize=6, scalex=False, scaley=False)
        at = seen.mean(axis=0)
        row = at[1]
        while any(abs(row - other[1]) < LABEL[1] and abs(at[0] - other[0]) < LABEL[0] for other in rows):
            row -= 1
        rows.append((at[0], row))
        drawn.append(axis.annotate(style.plain(place["name"]), (at[0], row), xytext=(3, 3), textcoords="offset points",
                                   color="tab:red", fontsize=7, annotation_clip=True))
    return drawn


def below(box, look):
    """The line that says how large what is seen is, and what is left away."""
    size = " x ".join(f"{length:.3g}" for length in box[1] - box[0])
    clip = f"; cut at {'xyz'[look.clip[0]]} = {look.clip[1]:.4g} m, what is in front of that is left away" if look.clip else ""
    return f"shown: {size} m in x, y, z{clip}"


def stage(run, fluid, structure, limits, field, box, look, **options):
    """(figure, axis, what changes in a film) of the first picture, with colour bars."""
    whole, axis = plt.subplots(figsize=(10, 6.5), **options)
    shown, lost = pixels(run, fluid, structure, limits, field, box, look)
    drawn = axis.imshow(shown)
    axis.set_axis_off()
    triad(axis, run.settings.get("gravity", []), look)
    changing = Changing(drawn, draw_gauges(axis, fields.gauge_places(run, structure), look.camera, box, run.settings.get("gravity", [])))
    axis.text(0.99, -0.01, below(box, look), ha="right", va="top", transform=axis.transAxes, fontsize=9, color="0.3")
    if lost:
        axis.text(0.99, 0.99, style.plain(f"not drawn, the frames do not say where they are: {', '.join(lost)}"), ha="right", va="top",
                  transform=axis.transAxes, fontsize=8, color="tab:red")
    mappables = [None if side is None or (label is MISES[0] and "von_mises" not in side) else ScalarMappable(Normalize(*range_), colours)
                 for side, range_, (label, colours, _) in zip((fluid, structure), limits, FIELDS[field])]
    bars = {label: mappable for mappable, (label, _, _) in zip(mappables, FIELDS[field]) if mappable is not None}
    for label, mappable in bars.items():
        whole.colorbar(mappable, ax=axis, pad=0.02, label=label, shrink=0.75).formatter.set_powerlimits((-3, 4))
    return whole, axis, changing


def change(axis, changing, run, fluid, structure, limits, field, box, look):
    """The next picture of a film into the axis of stage(): the scene, and the gauges where they are now."""
    changing.image.set_data(pixels(run, fluid, structure, limits, field, box, look)[0])
    for mark in changing.gauges:
        mark.remove()
    changing.gauges = draw_gauges(axis, fields.gauge_places(run, structure), look.camera, box, run.settings.get("gravity", []))


def figure(run, time, look=None):
    """A run at the frame nearest to `time`: (the time of the frame, the figure)."""
    look = look or Look()
    exact, fluid, structure = fields.read(run, time)
    if not is_rendered(run, look):
        if look.slice:
            check(run, look.slice, box_of(run, fluid, structure), "--slice")
        return fields.figure(run, time, fields.Cut(*look.slice) if look.slice else None)
    box = box_of(run, fluid, structure)
    if look.clip:
        check(run, look.clip, box, "--clip")
    whole, axis, _ = stage(run, fluid, structure, limits_of(fluid, structure), "pressure", box, look, layout="constrained")
    fields.title(axis, run, exact, None)
    return exact, whole
