"""What ./tern explain says about another error or time: from the measured trade (docs/TRADE.md), of the scene itself or of its like."""

from pathlib import Path

from tern import paths
from tern.errors import Error
from tern.studies import front, parameters, report, rows, sweep

QUICKER = 1.25       # speed-up from which a parameter is worth a line
UNNOTICED = 0.0005   # error added that is not worth a word
NOTICED = 0.001      # error removed that is, where it is beyond doubt


def _tables(case):
    """({scene: rows}, are they of the scene itself): of the scenes with the same sides."""
    own = [path for path in (Path("runs") / f"study-{case['name']}" / "cost_accuracy.csv",
                             paths.share() / "docs" / "trade" / f"{case['name']}.csv")
           if path.is_file()]
    if own:
        return {case["name"]: rows.read(own[0])}, True
    sides = {"fluid": "fluid.spacing_m", "structure": "structure.body.spacing_m"}
    found = {}
    for path in sorted((paths.share() / "docs" / "trade").glob("*.csv")):
        table = rows.read(path)
        standard = front.find(table, "standard")
        if standard and all(bool(standard.settings.get(column)) == case[f"has_{side}"] for side, column in sides.items()):
            found[path.stem] = table
    return found, False


def _added(row, table):
    """What the case is judged by, beyond that of the case as it stands: its error, or its distance from the finest run."""
    here, standard = front.error_of(row), front.error_of(front.find(table, "standard"))
    return here - standard if here is not None and standard is not None else None


def _doubt(table):
    """What an improvement has to exceed: how far the finest run itself may be off, where that is what others are judged by."""
    return NOTICED if front.by_reference(table) else max(NOTICED, front.finest(table).distance_to_finest or 0.0)


def _where_it_stands(tables, parameter, settings):
    """The tables of scenes in which the parameter has the value that it has here: what a change brings depends on what is changed."""
    own = sweep.effective_cells(settings, [parameter])
    return {name: table for name, table in tables.items() if own.items() <= front.find(table, "standard").settings.items()}


def _effects(tables, point):
    """[(speed-up, error added, doubt)] of one point in all tables that have it and where it ended."""
    effects = []
    for table in tables.values():
        cost, _ = front.standard_cost(table)
        row = front.find(table, point)
        added = _added(row, table) if row and cost and row.cpu_s else None
        if added is not None:
            effects.append((cost / row.cpu_s, added, _doubt(table)))
    return effects


def _line(option, effects):
    speed = report.span([1 / speed for speed, _, _ in effects], lambda x: f"{x:.2g}", " to ")
    added = report.span([added for _, added, _ in effects], lambda x: f"{100 * x:+.2f} %", " to ")
    return f"  {option:<54} {speed} times the CPU time, error {added}"


def text(case):
    """The paragraph, or nothing where no like scene was measured. `case`: of cases.read()."""
    try:
        tables, own = _tables(case)
    except Error:  # a table of the user's own that cannot be read is the business of ./tern study
        return ""
    tables = {name: table for name, table in tables.items() if front.find(table, "standard")}
    if not tables:
        return ""
    where = "measured in this scene" if own else f"measured in {', '.join(tables)}"
    lines = [f"For another error or time ({where}; docs/TRADE.md)"]
    lines += [_line(f"--preset {name}", effects) for name in ("draft", "reference") if (effects := _effects(tables, name))]
    points = {row.point: row for table in tables.values() for row in table
              if row.options and row.parameter not in ("preset", "spacing", "fluid.spacing", "structure.body.spacing")}
    known = {parameter.key: parameter for parameter in parameters.PARAMETERS}
    for point, row in points.items():
        parameter = known.get(row.parameter)
        if parameter is None or parameter.with_ or not parameters.applies(parameter, case["settings"]):
            continue
        effects = _effects(_where_it_stands(tables, parameter, case["settings"]), point)
        if not effects:
            continue
        quicker = all(speed >= QUICKER and added <= UNNOTICED for speed, added, _ in effects)
        better = all(added <= -doubt for _, added, doubt in effects)
        if quicker or better:
            lines.append(_line(row.options, effects))
    lines.append(f"  ./tern study {case['name']} --error 1%   (or --time 60s) measures what this scene needs.")
    return "\n".join(lines)
