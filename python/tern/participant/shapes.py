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
    if kind == "difference":
        return bounds(value[0])
    lows, highs = zip(*(bounds(part) for part in value))
    return numpy.min(lows, axis=0), numpy.max(highs, axis=0)
