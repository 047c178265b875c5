"""Reducers of whole fields: norms of field - expression at one frame, or the worst frame of a window (HDF5, numpy).

Vector fields enter with their magnitude. The expression is in x, y, z [m] of the particle and t [s]; `min` and `max`
limit the particles to a box; `scale` divides the result.
"""

from tern.errors import ReductionError
from tern.expression import compile_expression
from tern.results import frames

NORMS = ("l2", "max", "mean")
REQUIRED = {"process", "field", "norm", "expression"}
OPTIONAL = {"at", "from", "to", "min", "max", "scale"}


def _frames(path, quantity):
    """The frames asked for: at a time, at the "end", or all between `from` and `to`."""
    found = frames.read(path)
    if not found:
        raise ReductionError(f"{path} holds no frame")
    if "at" not in quantity:
        start, end = quantity.get("from", 0.0), quantity.get("to", float("inf"))
        part = [frame for frame in found if start - 1e-9 <= frame.time <= end + 1e-9]
        if not part:
            raise ReductionError(f"there is no frame between t = {start:g} s and t = {end:g} s")
        return part
    if quantity["at"] == "end":
        return [found[-1]]
    nearest = frames.nearest(found, quantity["at"])
    if abs(nearest.time - quantity["at"]) > 1e-3:
        raise ReductionError(f"there is no frame within 1 ms of t = {quantity['at']:g} s; the nearest is at "
                             f"{nearest.time:g} s (set output.frame_interval)")
    return [nearest]


def _norm(frame, quantity):
    import numpy
    time = frame.time
    position = numpy.asarray(frame["position"], dtype=float)
    values = numpy.asarray(frame[quantity["field"]], dtype=float)
    if values.ndim == 2:
        values = numpy.linalg.norm(values, axis=1)
    inside = numpy.ones(len(position), dtype=bool)
    for axis in range(3):
        if "min" in quantity and axis < len(quantity["min"]):
            inside &= position[:, axis] >= quantity["min"][axis]
        if "max" in quantity and axis < len(quantity["max"]):
            inside &= position[:, axis] <= quantity["max"][axis]
    if not inside.any():
        raise ReductionError(f"no particle is inside the box at t = {time:g} s")
    reference = compile_expression(quantity["expression"])
    exact = numpy.array([reference({"x": x, "y": y, "z": z, "t": time}) for x, y, z in position[inside]])
    difference = (values[inside] - exact) / quantity.get("scale", 1.0)
    if not numpy.isfinite(difference).all():
        raise ReductionError(f"the field {quantity['field']} is not finite at t = {time:g} s")
    if quantity["norm"] == "l2":
        return float(numpy.sqrt(numpy.mean(difference**2)))
    if quantity["norm"] == "max":
        return float(numpy.max(numpy.abs(difference)))
    return float(numpy.mean(difference))


def reduce(run, quantity):
    """The norm asked for; over several frames, the one of largest magnitude."""
    path = run / f"{quantity['process']}.h5"
    if not path.is_file():
        raise ReductionError(f"{path} does not exist")
    chosen = _frames(path, quantity)
    if quantity["field"] not in chosen[0]:
        raise ReductionError(f"{path} has no field {quantity['field']}; it has {', '.join(chosen[0])}")
    return max((_norm(frame, quantity) for frame in chosen), key=abs)
