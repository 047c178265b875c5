"""Where the rigid walls of a run are at the time of a frame: their outlines in 2D, in 3D as boxes and balls with a place."""

import numpy as np

MOVES = {"displacement", "rotation", "motion_file"}
FACES = {"x_min": (0, 0), "x_max": (0, 1), "y_min": (1, 0), "y_max": (1, 1), "z_min": (2, 0), "z_max": (2, 1)}


def signed_distance(shape, points):
    """Negative inside, 0 on the boundary, positive outside [m]; its size is not the distance everywhere."""
    (kind, what), = shape.items()
    if kind == "box":
        low, high = (np.asarray(what[name], dtype=float) for name in ("min", "max"))
        return np.max(np.maximum(low - points, points - high), axis=1)
    if kind == "ball":
        return np.linalg.norm(points - np.asarray(what["center"], dtype=float), axis=1) - what["radius"]
    if kind == "polygon":
        return _of_polygon(np.asarray(what["vertices"], dtype=float), points)
    if kind == "tube":  # the whole of it, whatever its angles
        axis = "xyz".index(what.get("axis", "z"))
        off = np.asarray(points) - np.asarray(what["center"], dtype=float)
        across = np.abs(np.hypot(off[:, (axis + 1) % 3], off[:, (axis + 2) % 3]) - what["radius"]) - what["thickness"] / 2
        return np.maximum(across, np.abs(off[:, axis]) - what["length"] / 2)
    parts = [signed_distance(part, points) for part in what]
    return np.min(parts, axis=0) if kind == "union" else np.max([parts[0], *(-part for part in parts[1:])], axis=0)


def _of_polygon(corners, points):
    inside, nearest = np.zeros(len(points), dtype=bool), np.full(len(points), np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
        crossed = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= crossed & (points[:, 0] < a[0] + (points[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
    return np.where(inside, -nearest, nearest)


def _edges(shape):
    """The straight pieces of the outlines of all primitives of a 2D shape: an array [n, 2 ends, 2]."""
    (kind, what), = shape.items()
    if kind in ("union", "difference"):
        return np.concatenate([_edges(part) for part in what])
    if kind == "ball":
        angle = np.linspace(0, 2 * np.pi, 181)
        corners = np.asarray(what["center"], dtype=float) + what["radius"] * np.column_stack([np.cos(angle), np.sin(angle)])
        return np.stack([corners[:-1], corners[1:]], axis=1)
    if kind == "ring":
        angle = np.linspace(what.get("begin", 0), what.get("end", 2 * np.pi), 181)
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        sides = [np.array(what["center"]) + (what["radius"] + z * what["thickness"]) * circle for z in (-0.5, 0.5)]
        return np.concatenate([np.stack([side[:-1], side[1:]], axis=1) for side in sides])
    if kind == "line":
        corners = np.asarray(what["vertices"], dtype=float)
        return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)[:len(corners) - (not what.get("closed", False))]
    if kind == "box":
        (x0, y0), (x1, y1) = what["min"], what["max"]
        corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=float)
    else:
        corners = np.asarray(what["vertices"], dtype=float)
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def outline(wall):
    """The straight pieces [n, 2 ends, 2] of a 2D wall as it was at t = 0: without open faces and what is inside another part."""
    shape = wall.get("container") or wall.get("obstacle")
    edges = _edges(shape)
    if "box" in shape:
        low_high = shape["box"]["min"], shape["box"]["max"]
        for direction, end in (FACES[face] for face in wall.get("open", [])):
            edges = edges[~np.all(edges[:, :, direction] == low_high[end][direction], axis=1)]
        return edges
    if not {"union", "difference"} & set(shape):
        return edges
    part = np.linspace(0, 1, 201)[None, :, None]  # a piece of a primitive may be outline in part
    points = edges[:, :1] * (1 - part) + edges[:, 1:] * part
    pieces = np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 2)
    size = np.ptp(edges.reshape(-1, 2), axis=0).max()
    return pieces[np.abs(signed_distance(shape, pieces.mean(axis=1))) < 1e-4 * size]


def cut(wall, place, direction, at, view):
    """The outline [n, 2 ends, 2] of a 3D wall, which is at `place`, in the plane where a coordinate is `at`, within `view`."""
    kept = [axis for axis in range(3) if axis != direction]
    shape = wall.get("container") or wall.get("obstacle")
    origin = place(np.zeros((1, 3)))[0]
    if "box" in shape and np.allclose(place(np.eye(3)) - origin, np.eye(3), atol=1e-12):
        low, high = (np.array(shape["box"][name], dtype=float) + origin for name in ("min", "max"))
        if not low[direction] <= at <= high[direction]:
            return np.zeros((0, 2, 2))
        ends = {"min": low[kept].tolist(), "max": high[kept].tolist()}
        names = {"xyz"[axis]: "xy"[number] for number, axis in enumerate(kept)}
        faces = [names[face[0]] + face[1:] for face in wall.get("open", []) if face[0] in names]
        return outline({"obstacle": {"box": ends}, "open": faces})
    from contourpy import contour_generator
    axes = [np.linspace(*range_, 400) for range_ in view]
    points = np.empty((400 * 400, 3))
    points[:, direction] = at
    points[:, kept] = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    turn = place(np.eye(3)) - origin
    distance = signed_distance(shape, (points - origin) @ turn.T).reshape(400, 400)
    lines = contour_generator(*axes, distance).lines(0.0)
    return np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines] or [np.zeros((0, 2, 2))])


def moves(wall):
    return bool(MOVES & set(wall))


def placed(walls, fields):
    """[(wall, place)] of the walls of a case at a frame of the fluid, None for the first: x = place(points at t = 0).

    `place` is None where nobody knows it: of a moving wall, when the fluid did not write where it was.
    """
    known = None if fields is None or "wall_place" not in fields else fields["wall_place"]
    dimension = next((len(next(iter(_bounded(wall)))[0]) for wall in walls), 2)
    result, number = [], 0
    for wall in walls:
        if not moves(wall):
            result.append((wall, lambda points: points))
        elif known is None or len(known) < (number + 1) * (dimension + 1):
            result.append((wall, None))
        else:
            origin, *ends = known[number * (dimension + 1):(number + 1) * (dimension + 1), :dimension]
            result.append((wall, lambda points, origin=origin, turn=np.array(ends) - origin: origin + np.asarray(points) @ turn))
        number += moves(wall)
    return result


def _bounded(wall):
    shape = wall.get("container") or wall.get("obstacle")
    yield from _boxes(shape)


def _boxes(shape):
    """(lower, upper corner) of the box around each primitive."""
    (kind, what), = shape.items()
    if kind in ("union", "difference"):
        for part in what if kind == "union" else what[:1]:
            yield from _boxes(part)
    elif kind == "box":
        yield what["min"], what["max"]
    elif kind == "ball":
        yield [c - what["radius"] for c in what["center"]], [c + what["radius"] for c in what["center"]]
    elif kind in ("ring", "tube"):
        size = [what["radius"] + what["thickness"] / 2] * len(what["center"])
        if kind == "tube":
            size["xyz".index(what.get("axis", "z"))] = what["length"] / 2
        yield [c - s for c, s in zip(what["center"], size)], [c + s for c, s in zip(what["center"], size)]
    else:
        yield np.min(what["vertices"], axis=0), np.max(what["vertices"], axis=0)


def corners(wall):
    """The corners of the box around a wall as it was at t = 0, an array [2^D, D]."""
    boxes = [np.array(box, dtype=float) for box in _bounded(wall)]
    low, high = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
    return np.stack(np.meshgrid(*np.stack([low, high], axis=1), indexing="ij"), axis=-1).reshape(-1, len(low))
