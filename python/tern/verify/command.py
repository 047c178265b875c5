"""./tern verify: runs a case, reduces its results to the quantities of expected.toml, and holds them to their bands."""

import json
from pathlib import Path

from tern.errors import BAD_INPUT, DONE, NUMERICAL_FAILURE, Error
from tern.launch import cases, run
from tern.results import report
from tern.verify import bands, expected


def table(case, rows):
    """The rows as a table for people."""
    cells = [["quantity", "value", "unit", "reference", "error", "band", "conf.", ""]]
    for row in rows:
        cells.append([row["name"], bands.number(row["value"]) or "none", row["unit"], bands.number(row["reference"]),
                      bands.number(row["error"]), bands.band(row["band"]), row["confidence"], "pass" if row["passed"] else "FAIL"])
    widths = [max(len(line[column]) for line in cells) for column in range(len(cells[0]))]
    lines = [f"{case}:"] + ["  " + "  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip()
                            for line in cells]
    lines += [f"  {row['name']}: {row['why']}" for row in rows if row["why"]]
    lines += [f"  {row['name']}: known shortfall: {row['shortfall']}" for row in rows if row["shortfall"]]
    return "\n".join(lines)


def _refuse_other_case(directory, path):
    """A run of another case, or one that did not end, would be judged by quantities that mean nothing there."""
    contents = report.read(directory)
    case, status = contents.get("case"), contents.get("status")
    if case != path.parent.name:
        raise Error(BAD_INPUT, f"{directory} is a run of '{case}', not of '{path.parent.name}': name that case, or another run.")
    if status != "done":
        print(f"warning: the run in {directory} did not end ({status}); what it never reached counts as failed.", flush=True)


def _verify_one(name, arguments):
    path = cases.find(name)
    quantities = expected.read(path.parent / "expected.toml")
    if arguments.run:
        directory = Path(arguments.run)
        _refuse_other_case(directory, path)
        code = DONE
    else:
        cause, directory = run.run(run.Request(name, arguments.case_options, until=arguments.until, threads=arguments.threads,
                                               deadline=arguments.deadline, quiet=arguments.quiet, build=arguments.build))
        code = cause.exit_code
        if code != DONE:
            raise Error(code, f"{path.parent.name} stopped before it could be verified: {cause.sentence}")
    rows = bands.judge(directory, quantities)
    return {"case": path.parent.name, "run": str(directory), "passed": all(row["passed"] for row in rows), "rows": rows}


def verify(arguments):
    """Verifies all cases named (or all that have an expected.toml); returns the exit code."""
    everything = cases.named("expected.toml")
    names = arguments.case or everything
    if arguments.run and len(names) != 1:
        raise Error(BAD_INPUT, "--run holds the results of one case: name exactly that CASE.")
    arguments.quiet = arguments.quiet or arguments.json
    results, worst = [], DONE
    for name in names:
        try:
            result = _verify_one(name, arguments)
        except Error as error:
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
