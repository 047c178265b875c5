"""./tern verify: runs a case, reduces its results to the quantities of expected.toml, and holds them to their bands."""

import json
import math
from pathlib import Path

from launcher import build, cases, expected, field_reducers, reducers, run, summary
from launcher.errors import BAD_INPUT, DONE, NUMERICAL_FAILURE, LauncherError
from launcher.series import ReductionError


def evaluate(directory, quantity):
    """The value of one quantity from the results in `directory`; ReductionError if there is none."""
    if quantity["kind"] == "field":
        return field_reducers.reduce(directory, quantity)
    if quantity["kind"] == "measure":
        contents = json.loads((directory / "run.json").read_text(encoding="utf-8"))
        value = summary.measure(contents, quantity["measure"])
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


def table(case, rows):
    """The rows as a table for people."""
    cells = [["quantity", "value", "unit", "reference", "error", "band", "conf.", ""]]
    for row in rows:
        cells.append([row["name"], number(row["value"]) or "none", row["unit"], number(row["reference"]),
                      number(row["error"]), band(row["band"]), row["confidence"], "pass" if row["passed"] else "FAIL"])
    widths = [max(len(line[column]) for line in cells) for column in range(len(cells[0]))]
    lines = [f"{case}:"] + ["  " + "  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip()
                            for line in cells]
    lines += [f"  {row['name']}: {row['why']}" for row in rows if row["why"]]
    lines += [f"  {row['name']}: known shortfall: {row['shortfall']}" for row in rows if row["shortfall"]]
    return "\n".join(lines)


def _refuse_other_case(directory, path):
    """A run of another case, or one that did not end, would be judged by quantities that mean nothing there."""
    try:
        report = json.loads((directory / "run.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise LauncherError(BAD_INPUT, f"{directory}/run.json cannot be read: {error}.") from error
    case, status = report.get("case"), report.get("status")
    if case != path.parent.name:
        raise LauncherError(BAD_INPUT, f"{directory} is a run of '{case}', not of '{path.parent.name}': name that case, or another run.")
    if status != "done":
        print(f"warning: the run in {directory} did not end ({status}); what it never reached counts as failed.", flush=True)


def _verify_one(name, arguments):
    path = cases.find(name)
    quantities = expected.read(path.parent / "expected.toml")
    if arguments.run:
        directory = Path(arguments.run)
        if not (directory / "run.json").is_file():
            raise LauncherError(BAD_INPUT, f"{directory} holds no run.json: it is not the directory of a finished run.")
        _refuse_other_case(directory, path)
        code = DONE
    else:
        arguments.case, arguments.out, arguments.only, arguments.endpoint = name, None, None, None
        arguments.fluid = arguments.structure = None
        arguments.force = arguments.allow_unstable = arguments.record = False
        arguments.network_options = []
        cause, directory = run.run(arguments)
        code = cause.exit_code
        if code != DONE:
            raise LauncherError(code, f"{path.parent.name} stopped before it could be verified: {cause.sentence}")
    rows = judge(directory, quantities)
    return {"case": path.parent.name, "run": str(directory), "passed": all(row["passed"] for row in rows), "rows": rows}


def verify(arguments):
    """Verifies all cases named (or all that have an expected.toml); returns the exit code."""
    everything = sorted(path.parent.name for path in (build.ROOT / "cases").glob("*/expected.toml"))
    names = arguments.case or everything
    if arguments.run and len(names) != 1:
        raise LauncherError(BAD_INPUT, "--run holds the results of one case: name exactly that CASE.")
    arguments.quiet = arguments.quiet or arguments.json
    results, worst = [], DONE
    for name in names:
        try:
            result = _verify_one(name, arguments)
        except LauncherError as error:
            if len(names) == 1:
                raise
            result = {"case": name, "run": "", "passed": False, "rows": [], "why": str(error)}
            worst = worst or error.exit_code
        results.append(result)
        if not arguments.json:
            print(table(result["case"], result["rows"]) if result["rows"] else f"{name}: FAIL: {result['why']}", flush=True)
    if arguments.json:
        print(json.dumps(results, indent=1))
    if worst == DONE and not all(result["passed"] for result in results):
        worst = NUMERICAL_FAILURE
    return worst
