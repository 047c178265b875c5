"""Reducers: what an expected.toml can ask of a time series. Each takes (series, quantity) and returns one number.

A series is [(t, value)]; a quantity is the table of expected.toml, with `from` and `to` [s] limiting the window where that
makes sense. Times are interpolated linearly between rows. What cannot be computed raises ReductionError.
"""

import math

from tern.results import series as series_module
from tern.expression import compile_expression
from tern.errors import ReductionError
from tern.results.series import at, covers, read, window


def _part(series, quantity):
    part = window(series, quantity.get("from"), quantity.get("to"))
    # A run that ended early must not pass a window it never reached: both ends have to be recorded.
    length = part[-1][0] - part[0][0]
    covers(series, quantity.get("from"), quantity.get("to"), max(0.02 * length, 1e-6))
    return part


def _integral(part):
    return sum(0.5 * (v0 + v1) * (t1 - t0) for (t0, v0), (t1, v1) in zip(part, part[1:]))


def value(series, quantity):
    """The value at t = `at`."""
    return at(series, quantity["at"])


def mean(series, quantity):
    """The time average over the window (trapezoidal rule; rows may be unevenly spaced)."""
    part = _part(series, quantity)
    if len(part) < 2:
        raise ReductionError("a mean over time needs at least two values in the window")
    return _integral(part) / (part[-1][0] - part[0][0])


def maximum(series, quantity):
    """The largest value in the window."""
    return max(v for _, v in _part(series, quantity))


def minimum(series, quantity):
    """The smallest value in the window."""
    return min(v for _, v in _part(series, quantity))


def time_of_maximum(series, quantity):
    """The time of the largest value in the window (of the first, if there are several)."""
    return max(_part(series, quantity), key=lambda row: row[1])[0]


def time_of_minimum(series, quantity):
    """The time of the smallest value in the window (of the first, if there are several)."""
    return min(_part(series, quantity), key=lambda row: row[1])[0]


def largest_magnitude(series, quantity):
    """max |value| in the window: held against at_most it says that a quantity stayed bounded."""
    return max(abs(v) for _, v in _part(series, quantity))


def span(series, quantity):
    """The largest less the smallest value in the window."""
    values = [v for _, v in _part(series, quantity)]
    return max(values) - min(values)


def crossing(series, quantity):
    """The first time at which |value| reaches `threshold` from below."""
    threshold = quantity["threshold"]
    part = window(series, quantity.get("from"), quantity.get("to"))
    for (t0, v0), (t1, v1) in zip(part, part[1:]):
        if abs(v0) < threshold <= abs(v1):
            return t0 + (t1 - t0) * (threshold - abs(v0)) / (abs(v1) - abs(v0))
    raise ReductionError(f"the magnitude never rises through {threshold:g}")


def _zero_crossings(series, quantity):
    about = quantity.get("about", 0.0)
    times = []
    last = None
    for t, v in _part(series, quantity):
        side = v - about
        if side == 0.0:
            continue  # the crossing is found between the rows on either side
        if last is not None and (side > 0) != (last[1] > 0):
            times.append(last[0] + (t - last[0]) * last[1] / (last[1] - side))
        last = (t, side)
    return times


def period(series, quantity):
    """The mean period from all zero crossings (both directions) of value - `about` in the window."""
    times = _zero_crossings(series, quantity)
    if len(times) < 3:
        raise ReductionError(f"a period needs three zero crossings, there are {len(times)}")
    return 2.0 * (times[-1] - times[0]) / (len(times) - 1)


def frequency(series, quantity):
    """1 / period [Hz]."""
    return 1.0 / period(series, quantity)


def loss_per_period(series, quantity):
    """The share of the swing about `about` that is lost per period: of an exponential through the half swings between the zero crossings of
    the window, by least squares of their logarithms."""
    times = _zero_crossings(series, quantity)
    if len(times) < 4:
        raise ReductionError(f"a loss per period needs four zero crossings, there are {len(times)}")
    about = quantity.get("about", 0.0)
    part = _part(series, quantity)
    swings = [math.log(max(abs(v - about) for t, v in part if begin <= t <= end)) for begin, end in zip(times, times[1:])]
    middle, mean = (len(swings) - 1) / 2, sum(swings) / len(swings)
    slope = (sum((n - middle) * (swing - mean) for n, swing in enumerate(swings))
             / sum((n - middle) ** 2 for n in range(len(swings))))
    return 1.0 - math.exp(2.0 * slope)


def zero_crossing(series, quantity):
    """The time of zero crossing number `number` (1 = the first) in the window."""
    times = _zero_crossings(series, quantity)
    number = quantity.get("number", 1)
    if len(times) < number:
        raise ReductionError(f"there are {len(times)} zero crossings, number {number} was asked for")
    return times[number - 1]


def non_monotone(series, quantity):
    """The largest step against `direction` ("decreasing" or "increasing") between rows; 0 for a monotone series."""
    sign = {"decreasing": 1.0, "increasing": -1.0}[quantity["direction"]]
    part = _part(series, quantity)
    return max([0.0, *(sign * (v1 - v0) for (_, v0), (_, v1) in zip(part, part[1:]))])


def largest_rise(series, quantity):
    """The largest increase above any earlier value of the window; 0 for a series that never grows."""
    lowest, rise = math.inf, 0.0
    for _, v in _part(series, quantity):
        lowest = min(lowest, v)
        rise = max(rise, v - lowest)
    return rise


def _differences(series, quantity):
    """[(t, value - reference)] over the window, at the times of the run."""
    part = _part(series, quantity)
    if "csv" in quantity:
        reference = read(quantity["csv"], quantity["csv_column"])
        return [(t, v - at(reference, t)) for t, v in part]
    reference = compile_expression(quantity["expression"])
    return [(t, v - reference({"t": t})) for t, v in part]


def max_difference(series, quantity):
    """max |value - reference| over the window; the reference is a column of a CSV or an expression in t."""
    return max(abs(d) for _, d in _differences(series, quantity))


def l1_difference(series, quantity):
    """The time average of |value - reference| over the window, divided by `scale` (default 1)."""
    distances = [(t, abs(d)) for t, d in _differences(series, quantity)]
    if len(distances) < 2:
        raise ReductionError("an L1 difference needs at least two values in the window")
    return _integral(distances) / (distances[-1][0] - distances[0][0]) / quantity.get("scale", 1.0)


def l2_difference(series, quantity):
    """Root of the time average of (value - reference)^2 over the window, divided by `scale` (default 1)."""
    squares = [(t, d * d) for t, d in _differences(series, quantity)]
    if len(squares) < 2:
        raise ReductionError("an L2 difference needs at least two values in the window")
    return math.sqrt(_integral(squares) / (squares[-1][0] - squares[0][0])) / quantity.get("scale", 1.0)


_WINDOW = {"from", "to"}
_REFERENCE = _WINDOW | {"csv", "csv_column", "expression"}
#: kind -> (function, required keys, optional keys)
KINDS = {
    "value": (value, {"at"}, set()),
    "mean": (mean, set(), _WINDOW),
    "maximum": (maximum, set(), _WINDOW),
    "minimum": (minimum, set(), _WINDOW),
    "time_of_maximum": (time_of_maximum, set(), _WINDOW),
    "time_of_minimum": (time_of_minimum, set(), _WINDOW),
    "largest_magnitude": (largest_magnitude, set(), _WINDOW),
    "span": (span, set(), _WINDOW),
    "crossing": (crossing, {"threshold"}, _WINDOW),
    "period": (period, set(), _WINDOW | {"about"}),
    "frequency": (frequency, set(), _WINDOW | {"about"}),
    "loss_per_period": (loss_per_period, set(), _WINDOW | {"about"}),
    "zero_crossing": (zero_crossing, set(), _WINDOW | {"about", "number"}),
    "non_monotone": (non_monotone, {"direction"}, _WINDOW),
    "largest_rise": (largest_rise, set(), _WINDOW),
    "max_difference": (max_difference, set(), _REFERENCE),
    "l1_difference": (l1_difference, set(), _REFERENCE | {"scale"}),
    "l2_difference": (l2_difference, set(), _REFERENCE | {"scale"}),
}


def reduce(path, column, quantity):
    """Applies the reducer named by quantity["kind"] to a column of a CSV file, or to the sum of a list of columns."""
    if isinstance(column, list):
        parts = [dict(series_module.read(path, name)) for name in column]
        series = [(t, sum(part[t] for part in parts)) for t in parts[0] if all(t in part for part in parts)]
    else:
        series = series_module.read(path, column)
    return KINDS[quantity["kind"]][0](series, quantity)
