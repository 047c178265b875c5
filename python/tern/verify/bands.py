"""The results of a run, reduced to the quantities of expected.toml and held to their bands."""

import math

from tern.errors import ReductionError
from tern.results import report, summary
from tern.verify import expected, field_reducers, reducers


def evaluate(directory, quantity):
    """The value of one quantity from the results in `directory`; ReductionError if there is none."""
    if quantity["kind"] == "field":
        return field_reducers.reduce(directory, quantity)
    if quantity["kind"] == "measure":
        value = summary.measure(report.read(directory), quantity["measure"])
        if value is None:
            raise ReductionError(f"no process reported the measure {quantity['measure']}")
        return abs(value) if quantity.get("magnitude") else value
    return reducers.reduce(directory / quantity.get("file", "gauges.csv"), quantity["column"], quantity)


def judge(directory, quantities):
    """One row per quantity: name, unit, value, reference, error, band, passed, why, source, confidence."""
    rows = []
    for quantity in quantities:
        row = {key: quantity.get(key) for key in ("name", "unit", "reference", "source", "confidence", "shortfall")}
        lowest, highest = expected.limits(quantity)
        row |= {"value": None, "error": None, "band": [lowest, highest], "passed": False, "why": ""}
        try:
            row["value"] = evaluate(directory, quantity)
            if not math.isfinite(row["value"]):
                raise ReductionError(f"the value is {row['value']}")
            row["passed"] = (lowest is None or row["value"] >= lowest) and (highest is None or row["value"] <= highest)
            if isinstance(row["reference"], (int, float)):
                row["error"] = row["value"] - row["reference"]
        except ReductionError as error:
            row["value"], row["why"] = None, str(error)
        rows.append(row)
    return rows


def number(value):
    """A value of the table as text."""
    return "" if value is None else f"{value:.4g}" if isinstance(value, (int, float)) else str(value)


def band(limits):
    """The band of a row as text."""
    lowest, highest = limits
    if lowest is None:
        return f"<= {highest:.4g}"
    return f">= {lowest:.4g}" if highest is None else f"{lowest:.4g} .. {highest:.4g}"
