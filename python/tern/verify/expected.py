"""expected.toml: the quantities a case is held to, each with its reference, band, source and confidence.

    [[quantity]]
    name = "first maximum of P"
    kind = "maximum"              # a reducer of tern/verify/reducers.py, or "field", or "measure"
    column = "P.ux_m"             # of gauges.csv, or of `file`; a list of columns: their sum
    from = 0.27
    to = 0.40
    unit = "m"
    reference = 0.0732            # printed, with the error against it; the band decides
    band = [0.062, 0.080]         # or at_most = ..., or at_least = ...
    source = "SPHinXsys, run by us, 4 mm"
    confidence = "B"              # A closed form or converged, B another code or digitised data
    shortfall = "..."             # only where the band is known to be missed: how far and why; it still counts as FAIL
"""

import tomllib

from tern.verify import field_reducers, reducers
from tern.errors import BAD_INPUT, Error

_COMMON = {"name", "kind", "unit", "reference", "band", "at_most", "at_least", "source", "confidence", "shortfall"}


def _check_keys(where, quantity, required, optional):
    absent = [key for key in sorted(required) if key not in quantity]
    if absent:
        raise Error(BAD_INPUT, f"{where} lacks {', '.join(absent)}.")
    unknown = sorted(set(quantity) - _COMMON - required - optional)
    if unknown:
        raise Error(BAD_INPUT, f"{where} has keys that kind {quantity['kind']!r} does not know: "
                                       f"{', '.join(unknown)}; it knows {', '.join(sorted(required | optional))}.")


def check(where, quantity, folder):
    """Validates one [[quantity]]; makes the path of its CSV absolute."""
    _check_keys(where, quantity, {"name", "kind"}, set(quantity))
    where = f"{where} ({quantity['name']})"
    _check_keys(where, quantity, {"source", "confidence", "unit"}, set(quantity))
    kind = quantity["kind"]
    if kind == "measure":
        _check_keys(where, quantity, {"measure"}, {"magnitude"})
    elif kind == "field":
        _check_keys(where, quantity, field_reducers.REQUIRED, field_reducers.OPTIONAL)
        if quantity["norm"] not in field_reducers.NORMS:
            raise Error(BAD_INPUT, f"{where}: norm {quantity['norm']!r} is none of {field_reducers.NORMS}.")
    elif kind in reducers.KINDS:
        _, required, optional = reducers.KINDS[kind]
        _check_keys(where, quantity, required | {"column"}, optional | {"file"})
        if kind in ("max_difference", "l1_difference", "l2_difference") and ("expression" in quantity) == ("csv" in quantity):
            raise Error(BAD_INPUT, f"{where} needs either csv with csv_column, or expression.")
    else:
        raise Error(BAD_INPUT, f"{where}: there is no reducer {kind!r}; there are measure, field, "
                                       f"{', '.join(sorted(reducers.KINDS))}.")
    limits = [key for key in ("band", "at_most", "at_least") if key in quantity]
    if len(limits) != 1:
        raise Error(BAD_INPUT, f"{where} needs exactly one of band, at_most, at_least; it has {limits or 'none'}.")
    if "csv" in quantity:
        quantity["csv"] = folder / quantity["csv"]
        if not quantity["csv"].is_file() or "csv_column" not in quantity:
            raise Error(BAD_INPUT, f"{where}: {quantity['csv']} does not exist or csv_column is missing.")
    return quantity


def read(path):
    """All quantities of an expected.toml, validated."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise Error(BAD_INPUT, f"There is no {path}: the case has nothing to be held against; write one (see "
                                       f"docs/VERIFICATION.md) or use ./tern run.") from error
    except tomllib.TOMLDecodeError as error:
        raise Error(BAD_INPUT, f"{path} is not valid TOML: {error}.") from error
    quantities = table.get("quantity", [])
    if not quantities or set(table) != {"quantity"}:
        raise Error(BAD_INPUT, f"{path} must hold [[quantity]] tables and nothing else.")
    return [check(f"{path}, quantity {number}", quantity, path.parent) for number, quantity in enumerate(quantities, 1)]


def limits(quantity):
    """(lowest, highest) allowed value; None where there is no limit."""
    if "band" in quantity:
        return tuple(quantity["band"])
    return quantity.get("at_least"), quantity.get("at_most")
