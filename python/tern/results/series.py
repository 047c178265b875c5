"""Time series read from the CSV files of a run or of a reference: `t_s` and named columns, empty cells undefined."""

import math
from bisect import bisect_left

from tern.errors import ReductionError, UnreadableRun
from tern.results import tables


def read(path, column):
    """[(t, value)] of one column, rows with an undefined value left out. ReductionError where there are none, or the file is damaged."""
    if not path.is_file():
        raise ReductionError(f"{path} does not exist")
    try:
        return _pairs(path, column)
    except UnreadableRun as error:
        raise ReductionError(str(error)) from None


def _pairs(path, column):
    header, rows = tables.read_cells(path)
    if "t_s" not in header or column not in header:
        raise ReductionError(f"{path} has no column {column}; it has {', '.join(header)}")
    at_time, at_value = header.index("t_s"), header.index(column)
    series = []
    for line, row in rows:
        if row[at_value].strip():
            value = tables.number(path, line, column, row[at_value])
            if not math.isfinite(value):
                raise ReductionError(f"{path}, line {line}: {column} is {row[at_value]}")
            series.append((tables.number(path, line, "t_s", row[at_time]), value))
    return series


def window(series, start, end):
    """The part of the series from `start` to `end` [s]; both may be None. Never empty."""
    part = [(t, value) for t, value in series
            if (start is None or t >= start - 1e-9) and (end is None or t <= end + 1e-9)]
    if not part:
        raise ReductionError(f"there is no value between t = {start} s and t = {end} s")
    return part


def covers(series, start, end, slack):
    """Raises unless the series begins and ends within `slack` [s] of the window asked for."""
    if (start is not None and series[0][0] > start + slack) or (end is not None and series[-1][0] < end - slack):
        raise ReductionError(f"values exist only from t = {series[0][0]:g} s to t = {series[-1][0]:g} s, not over the "
                             f"whole window from {start} to {end} s")


def at(series, t):
    """Linear interpolation at `t`; no extrapolation."""
    if not series or t < series[0][0] - 1e-9 or t > series[-1][0] + 1e-9:
        raise ReductionError(f"t = {t:g} s is outside the recorded times")
    place = bisect_left(series, (t,))
    if place == 0:
        return series[0][1]
    if place == len(series):
        return series[-1][1]
    (t0, v0), (t1, v1) = series[place - 1], series[place]
    return v1 if t1 == t0 else v0 + (v1 - v0) * (t - t0) / (t1 - t0)
