"""Shapes of a case as `tern-case json` prints them: signed distance and size, as in scene/geometry.cpp."""

import numpy


def signed_distance(shape, x):
    """Of the points x (one row each): negative inside, positive outside [m]."""
    kind, value = next(iter(shape.items()))
    if kind == "box":
        beyond = numpy.maximum(numpy.array(value["min"]) - x, x - numpy.array(value["max"]))
        outer = numpy.linalg.norm(numpy.maximum(beyond, 0), axis=1)
        return numpy.where(outer > 0, outer, beyond.max(axis=1))
    if kind == "ball":
        return numpy.linalg.norm(x - numpy.array(value["center"]), axis=1) - value["radius"]
    if kind == "polygon":
        return _polygon(numpy.array(value["vertices"], dtype=float), x)
    if kind == "line":
        return _line(value, x)
    if kind == "ring":
        return _ring(value, *(x - numpy.array(value["center"])).T)
    if kind == "tube":
        axis, first, second = _axes(value)
        from_center = (x - numpy.array(value["center"])).T
        across, along = _ring(value, from_center[first], from_center[second]), numpy.abs(from_center[axis]) - value["length"] / 2
        return numpy.where((across > 0) & (along > 0), numpy.hypot(across, along), numpy.maximum(across, along))
    if kind == "plate":
        corners, origin, axes = _plane(value)
        u, v, w = ((x - origin) @ axes).T
        across, off = _polygon(corners, numpy.column_stack([u, v])), numpy.abs(w) - value["thickness"] / 2
        return numpy.where((across > 0) & (off > 0), numpy.hypot(across, off), numpy.maximum(across, off))
    parts = [signed_distance(part, x) for part in value]
    if kind == "union":
        return numpy.minimum.reduce(parts)
    return numpy.maximum.reduce([parts[0]] + [-part for part in parts[1:]])


def _polygon(vertices, x):
    nearest, inside = numpy.full(len(x), numpy.inf), numpy.zeros(len(x), dtype=bool)
    for a, b in zip(numpy.roll(vertices, 1, axis=0), vertices):
        along = b - a
        s = numpy.clip((x - a) @ along / (along @ along), 0, 1)
        nearest = numpy.minimum(nearest, numpy.linalg.norm(x - a - s[:, None] * along, axis=1))
        if a[1] != b[1]:
            inside ^= ((a[1] > x[:, 1]) != (b[1] > x[:, 1])) & (x[:, 0] < a[0] + along[0] * (x[:, 1] - a[1]) / along[1])
    return numpy.where(inside, -nearest, nearest)


def _plane(plate):
    """(corners in the plane, where its coordinates are 0, unit vectors in the plane and across it as columns)."""
    corners = numpy.array(plate["vertices"], dtype=float)
    from_first = corners - corners[0]
    normal = numpy.cross(from_first, numpy.roll(from_first, -1, axis=0)).sum(axis=0)
    normal /= numpy.linalg.norm(normal)
    sides = numpy.roll(corners, -1, axis=0) - corners
    along = max(sides, key=numpy.linalg.norm)
    along = along / numpy.linalg.norm(along)
    axes = numpy.column_stack([along, numpy.cross(normal, along), normal])
    return (from_first @ axes)[:, :2], corners[0], axes


def _axes(tube):
    axis = "xyz".index(tube.get("axis", "z"))
    return axis, (axis + 1) % 3, (axis + 2) % 3


def _ring(value, x, y):
    half_thickness, begin, end = value["thickness"] / 2, value.get("begin", 0), value.get("end", 2 * numpy.pi)
    across = numpy.abs(numpy.hypot(x, y) - value["radius"]) - half_thickness
    if end - begin >= 2 * numpy.pi * (1 - 1e-12):
        return across
    middle, half = (begin + end) / 2, (end - begin) / 2
    u, v = x * numpy.cos(middle) + y * numpy.sin(middle), numpy.abs(y * numpy.cos(middle) - x * numpy.sin(middle))
    beyond, outwards = v * numpy.cos(half) - u * numpy.sin(half), u * numpy.cos(half) + v * numpy.sin(half)
    of_end = numpy.abs(outwards - value["radius"]) - half_thickness
    outside = numpy.where(of_end > 0, numpy.hypot(of_end, beyond), numpy.abs(beyond))
    inside = numpy.where((across > 0) | (outwards <= 0), across, numpy.maximum(across, beyond))
    return numpy.where(numpy.arctan2(v, u) > half, outside, inside)


def _pieces(line):
    """Ends of the straight pieces of a line."""
    vertices = numpy.array(line["vertices"], dtype=float)
    return list(zip(vertices, numpy.roll(vertices, -1, axis=0)))[:len(vertices) - (not line.get("closed", False))]


def _line(value, x):
    pieces, half_thickness = _pieces(value), value["thickness"] / 2
    result = numpy.full(len(x), numpy.inf)
    for number, (a, b) in enumerate(pieces):
        length = numpy.linalg.norm(b - a)
        along, off = (x - a) @ (b - a) / length, numpy.abs((x - a) @ numpy.array([a[1] - b[1], b[0] - a[0]]) / length)
        here = numpy.hypot(numpy.maximum(0, numpy.maximum(-along, along - length)), off) - half_thickness
        for ends, past in ((number == 0, -along), (number == len(pieces) - 1, along - length)):
            if ends and not value.get("closed", False):  # a flat end
                side = off - half_thickness
                flat = numpy.where((side > 0) & (past > 0), numpy.hypot(side, past), numpy.maximum(side, past))
                here = numpy.where(past > -half_thickness, flat, here)
        result = numpy.minimum(result, here)
    return result


def bounds(shape):
    """Corners (low, high) of a box around the shape."""
    kind, value = next(iter(shape.items()))
    if kind == "box":
        return numpy.array(value["min"], dtype=float), numpy.array(value["max"], dtype=float)
    if kind == "ball":
        return numpy.array(value["center"]) - value["radius"], numpy.array(value["center"]) + value["radius"]
    if kind == "polygon":
        vertices = numpy.array(value["vertices"], dtype=float)
        return vertices.min(axis=0), vertices.max(axis=0)
    if kind == "line":
        vertices = numpy.array(value["vertices"], dtype=float)
        return vertices.min(axis=0) - value["thickness"] / 2, vertices.max(axis=0) + value["thickness"] / 2
    if kind in ("ring", "tube"):  # of the whole of it
        size = numpy.full(len(value["center"]), value["radius"] + value["thickness"] / 2)
        if kind == "tube":
            size[_axes(value)[0]] = value["length"] / 2
        return numpy.array(value["center"]) - size, numpy.array(value["center"]) + size
    if kind == "plate":
        corners, (_, _, axes) = numpy.array(value["vertices"], dtype=float), _plane(value)
        half = value["thickness"] / 2 * numpy.abs(axes[:, 2])
        return corners.min(axis=0) - half, corners.max(axis=0) + half
    if kind == "difference":
        return bounds(value[0])
    lows, highs = zip(*(bounds(part) for part in value))
    return numpy.min(lows, axis=0), numpy.max(highs, axis=0)
