"""How far off a run is: from the references of its case, and from another run.

Against references: root mean square over the quantities that count of (value - reference)/scale. It judges a run if all of them
are of confidence A; else the distance from the finest run does, for another code may be met by accident. The quantities are those of
expected.toml with a reference other than 0, over its magnitude; a study.toml beside it chooses others:

    until = 0.45                     # s; a study ends here, earlier than the case (left out: the end time of the case)
    curves = ["P.ux_m"]              # columns of gauges.csv in the distance between runs (left out: all)

    [[quantity]]
    name = "first maximum of P"      # of expected.toml; its other keys may be replaced here
    scale = 0.0732                   # left out: the magnitude of the reference
    label = "first maximum"          # its name in tables, where other keys change its meaning (left out: as it is)
"""

import math
import tomllib
from dataclasses import dataclass

import numpy as np

from tern.verify import bands, expected
from tern.errors import BAD_INPUT, Error
from tern.errors import ReductionError


@dataclass
class Criterion:
    """What counts in a study of one case."""

    quantities: list  # tables as of expected.toml, each with its "over" (the scale)
    left_out: list    # names of those that need a later end
    until: float      # s
    curves: list      # columns; empty = all

    @property
    def judged_by(self):
        """References of confidence A are held to be true; another code is something to be compared with, not to be met."""
        return "reference" if self.quantities and all(quantity["confidence"] == "A" for quantity in self.quantities) else "finest"


def _read_toml(path):
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise Error(BAD_INPUT, f"{path} is not valid TOML: {error}.") from error


def _scaled(where, quantity, scale):
    reference = quantity.get("reference", 0.0)
    scale = abs(reference) if scale is None and isinstance(reference, (int, float)) else scale
    if isinstance(scale, bool) or not isinstance(scale, (int, float)) or not 0 < scale < math.inf:
        raise Error(BAD_INPUT, f"{where} ({quantity['name']}): scale is {scale}, but has to be a number greater than 0 (the "
                                       "size of the quantity, in its unit).")
    return quantity | {"reference": reference, "over": float(scale)}


def _chosen(path, known):
    """The quantities of a study.toml, from those of expected.toml by name."""
    table = _read_toml(path)
    wrong = sorted(set(table) - {"until", "curves", "quantity"})
    if wrong:
        raise Error(BAD_INPUT, f"{path} has the unknown key {wrong[0]}; there are until, curves and [[quantity]].")
    chosen = []
    for number, entry in enumerate(table.get("quantity", []), 1):
        where = f"{path}, quantity {number}"
        base = next((quantity for quantity in known if quantity["name"] == entry.get("name")), None)
        if base is None:
            raise Error(BAD_INPUT, f"{where}: expected.toml has no quantity named {entry.get('name')!r}; it has "
                                           f"{', '.join(quantity['name'] for quantity in known) or 'none'}.")
        # `scale` of a reducer divides the value itself; here it is the size an error is measured by.
        merged = base | {key: value for key, value in entry.items() if key not in ("scale", "label")}
        merged["name"] = entry.get("label", base["name"])
        chosen.append(_scaled(where, expected.check(where, merged, path.parent), entry.get("scale")))
    return table, chosen


def read(folder, end_time, until=None):
    """The criterion of the case in `folder`; `until` [s]: an end other than that of study.toml or of the case."""
    folder = folder.resolve()
    known = expected.read(folder / "expected.toml") if (folder / "expected.toml").is_file() else []
    table = {}
    if (folder / "study.toml").is_file():
        table, quantities = _chosen(folder / "study.toml", known)
    else:
        quantities = [_scaled("expected.toml", quantity, None) for quantity in known
                      if isinstance(quantity.get("reference"), (int, float)) and quantity["reference"] != 0]
    until = until or table.get("until") or end_time
    late = [quantity["name"] for quantity in quantities
            if any(isinstance(quantity.get(key), (int, float)) and quantity[key] > until + 1e-9 for key in ("at", "from", "to"))]
    return Criterion([quantity for quantity in quantities if quantity["name"] not in late], late, until, table.get("curves", []))


def errors(directory, criterion):
    """{name: |value - reference|/scale} of a run; ReductionError where one cannot be computed."""
    result = {}
    for quantity in criterion.quantities:
        value = bands.evaluate(directory, quantity)
        if not math.isfinite(value):
            raise ReductionError(f"{quantity['name']} is {value}")
        result[quantity["name"]] = abs(value - quantity["reference"]) / quantity["over"]
    return result


def root_mean_square(values):
    """0.05 for [0.03, 0.04, ...]; None for no values."""
    values = list(values)
    return math.sqrt(sum(value * value for value in values) / len(values)) if values else None


def _groups(columns):
    """{(gauge, unit): [columns]}: components of one vector are measured by its magnitude."""
    groups = {}
    for column in columns:
        gauge, _, quantity = column.rpartition(".")
        groups.setdefault((gauge, quantity.partition("_")[2]), []).append(column)
    return groups


def distance(table, other, curves=()):
    """Root mean square over the gauges of (distance in L2 over time)/(largest magnitude), of `table` from `other`.

    Both are {column: array} of gauges.csv. Where a value is undefined in either (no water at a gauge), nothing is compared.
    """
    columns = [column for column in other if column != "t_s" and column in table and (not curves or column in curves)]
    parts = []
    for members in _groups(columns).values():
        defined = np.all([np.isfinite(other[column]) for column in members], axis=0)
        own = np.all([np.isfinite(table[column]) for column in members], axis=0)
        if defined.sum() < 2 or own.sum() < 2:
            continue
        defined &= (other["t_s"] >= table["t_s"][own][0]) & (other["t_s"] <= table["t_s"][own][-1])
        t = other["t_s"][defined]
        magnitude = math.sqrt(max(sum(other[column][defined] ** 2 for column in members), default=0.0))
        if len(t) < 2 or magnitude == 0:
            continue
        square = sum((np.interp(t, table["t_s"][own], table[column][own]) - other[column][defined]) ** 2 for column in members)
        parts.append(math.sqrt(np.trapz(square, t) / (t[-1] - t[0])) / magnitude)
    return root_mean_square(parts)
