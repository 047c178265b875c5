"""docs/TRADE.md, its picture, and the table in README.md, from the tables in docs/trade."""

import re
import textwrap
from pathlib import Path

from tern.launch import cases
from tern import paths
from tern.errors import BAD_INPUT, DONE, Error
from tern.studies import front, report, rows
from tern.studies.parameters import PARAMETERS
from tern.studies import picture as trade

BEGIN, END = "<!-- trade: written by ./tern study --write-docs -->", "<!-- trade: end -->"
WIDTH = 140
ERRORS = (0.05, 0.02, 0.01, 0.005, 0.002)

INTRODUCTION = """# What accuracy costs

Written by `./tern study --write-docs` from `docs/trade/*.csv`, each the `cost_accuracy.csv` of `./tern study CASE`; do
not edit.

Every parameter is changed by itself around the case as it stands. Runs are done one at a time.

* *Error* is the root mean square of (value - reference)/scale over the quantities that the case's `study.toml` names.
  Where the reference is another code or an experiment (confidence B), the error has a floor, and nearness to the
  reference may be an accident. Runs are then judged by how far they are from the finest, as they are without a
  reference.
* *From the finest* is the distance of all gauges' curves from the run with the smallest spacings: the root mean square
  over the gauges of the L2 distance over time over the largest magnitude. For the finest run itself it is its
  uncertainty, the distance of the next finest.
* *Moves the curves by* is the same distance from the case as it stands: the effect of the parameter alone.
* CPU times are those of a shared machine with other work beside it. Each scene says how far two runs of the same
  differ; a speed-up of 0.8 to 1.2 may be noise. Steps and pressure iterations are free of that.

Each scene names the version that its rows are of.
"""


def read_all():
    """{case: rows} of docs/trade."""
    tables = {path.stem: rows.read(path) for path in sorted((paths.source() / "docs" / "trade").glob("*.csv"))}
    if not tables:
        raise Error(BAD_INPUT, "docs/trade holds no table; measure one first: ./tern study CASE, then ./tern study CASE --write-docs.")
    return tables


def _preset_error(row, found):
    """Error and distance from the finest run; of a run that others are measured by, how far it can be trusted."""
    best = front.finest(found)
    if row is None:
        return "did not end"
    error = report.percent(row.error)
    if row.judged_by == "finest" and front.spacings(row) == front.spacings(best) and row.distance_to_finest == best.distance_to_finest:
        return f"{error} (what the others are held to, ± {report.percent(row.distance_to_finest)})"
    return f"{error} ({report.percent(row.distance_to_finest)})"


def preset_table(tables):
    """One line per scene: error and cost of the three presets."""
    lines = []
    for case, found in tables.items():
        cost, scatter = front.standard_cost(found)
        cells = [f"`{case}`"]
        for name in report.PRESETS:
            row = front.find(found, name)
            cells.append(_preset_error(row, found))
            spent = cost if name == "standard" else row and row.cpu_s
            cells.append("" if not spent else
                         f"{report.seconds(spent)}" + (f" ± {50 * scatter:.0f} %" if name == "standard" else f" ({spent / cost:.2g} x)"))
        lines.append(cells)
    head = ["scene"] + [cell for name in report.PRESETS for cell in (f"{name}: error (from the finest)", "CPU")]
    return report.table(head, lines)


def wish_table(tables):
    """The cheapest measured settings for a wanted error, per scene."""
    lines = []
    for case, found in tables.items():
        best = None
        for wanted in ERRORS:
            row, met = front.best_for_error(found, wanted)
            if met and row is not best:
                best = row
                lines.append([f"`{case}`", report.percent(wanted), report.options_of(row), report.percent(row.error),
                              report.percent(row.distance_to_finest), report.seconds(row.cpu_s)])
    return report.table(["scene", "for an error of", "take", "error", "from the finest", "CPU"], lines)


def _value(row, standard):
    """The value as a factor of the standard's where it is one, so that scenes can be compared."""
    parameter = next((parameter for parameter in PARAMETERS if parameter.key == row.parameter), None)
    if parameter and parameter.scaled and row.parameter != "spacing":
        name = f"{parameter.key}_{parameter.unit}" if parameter.unit else parameter.key
        return f"{float(row.settings[name]) / float(standard.settings[name]):.3g} x" + (f" (with {', '.join(parameter.with_)})"
                                                                                        if parameter.with_ else "")
    return row.value + (f" (with {', '.join(parameter.with_)})" if parameter and parameter.with_ else "")


def parameter_summary(tables):
    """Every value of every parameter over all scenes that have it."""
    entries = {}
    for found in tables.values():
        cost, _ = front.standard_cost(found)
        standard = front.find(found, "standard")
        for row in found:
            if row.parameter and row.parameter != "preset" and standard:
                label = _value(row, standard) if row.done else row.value
                entries.setdefault((row.parameter, label), []).append((row, cost, standard))
    order = {parameter.key: number for number, parameter in enumerate(PARAMETERS)}
    lines = []
    for (parameter, value), found in sorted(entries.items(), key=lambda entry: order.get(entry[0][0], 99)):
        done = [(row, cost, standard) for row, cost, standard in found if row.done]
        added = [row.error - standard.error for row, _, standard in done
                 if row.judged_by == "reference" and row.error is not None and standard.error is not None]
        lines.append([f"`{parameter}`", value, report.span([cost / row.cpu_s for row, cost, _ in done], lambda x: f"{x:.2g}"),
                      report.span(added, report.points),
                      report.span([row.distance_to_standard for row, _, _ in done], lambda x: f"{100 * x:.2g} %"),
                      f"{len(done)}" + (f", {len(found) - len(done)} did not end" if len(done) < len(found) else "")])
    return report.table(["parameter", "value", "speed-up", "error added", "moves the curves by", "scenes"], lines)


def _case_section(case, found):
    cost, scatter = front.standard_cost(found)
    end = next((row.end_time_s for row in found), 0.0)
    versions = ", ".join(sorted({row.version for row in found}))
    parts = [f"## {case}", "",
             f"`./tern study {case}`, {versions}, to t = {end:g} s. The case as it stands takes {report.seconds(cost)} of CPU; its runs "
             f"at begin and end differ by {report.percent(scatter)}. {report.finest_sentence(found)}", "", report.quantity_lines(found), "",
             "The front:", "", report.front_table(found), "", "Observed orders:", "", report.order_lines(found), "", "Parameters:", "",
             report.parameter_table(found), ""]
    if report.failures(found):
        parts += ["Did not end:", "", report.failures(found), ""]
    return "\n".join(parts)


def _wrapped(text):
    """`text` in lines that can be read; tables, headings and pictures as they are."""
    lines = []
    for line in text.split("\n"):
        if len(line) <= WIDTH or line.startswith(("|", "#", "!")):
            lines.append(line)
            continue
        # What is in backticks stays on one line.
        whole = re.sub(r"`[^`]*`", lambda code: code[0].replace(" ", "\0"), line)
        lines += textwrap.wrap(whole, WIDTH, subsequent_indent="  " if line.startswith("* ") else "", break_long_words=False,
                               break_on_hyphens=False)
    return "\n".join(lines).replace("\0", " ")


def trade_text(tables):
    """docs/TRADE.md."""
    return _wrapped("\n".join([INTRODUCTION, "![Error against CPU time](pictures/trade.png)", "", "## The presets", "", _presets_words(),
                               "", preset_table(tables), "",
                      "## Which settings for which error", "", wish_table(tables), "", "## The parameters, over all scenes", "",
                               parameter_summary(tables), "",
                      *(_case_section(case, found) for case, found in tables.items())]))


def _presets_words():
    return (paths.source() / "docs" / "trade" / "presets.md").read_text(encoding="utf-8").strip()


def readme_block(tables):
    """What stands between the markers of README.md."""
    return f"{BEGIN}\n{preset_table(tables)}\n{END}"


def replace_block(text, block):
    """`text` with what is between the markers replaced; Error without them."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise Error(BAD_INPUT, f"README.md has no lines {BEGIN} and {END}; put them where the table belongs.")
    return before + block + after


def _take_over(source, target, keep_versions):
    """Copies the rows that belong to the latest run of the case as it stands."""
    found = rows.read(source)
    standard = next((row for row in reversed(found) if row.point == "standard"), None)
    if standard is None:
        raise Error(BAD_INPUT, f"{source} has no row of the case as it stands; let the study go on first.")
    own = [row for row in found if (row.base, row.end_time_s) == (standard.base, standard.end_time_s)
           and (keep_versions or row.version == standard.version)]
    rows.write(target, own, rows.header(standard.quantities, standard.settings))


def write(arguments):
    """./tern study [CASE] --write-docs: takes over the table of CASE, and writes all documents; returns the exit code."""
    root = paths.source()
    if arguments.case:
        name = cases.find(arguments.case).parent.name
        source = (Path(arguments.out) if arguments.out else Path("runs") / f"study-{name}") / "cost_accuracy.csv"
        if not source.is_file():
            raise Error(BAD_INPUT, f"{source} does not exist; measure it first: ./tern study {arguments.case}.")
        (root / "docs" / "trade").mkdir(exist_ok=True)
        _take_over(source, root / "docs" / "trade" / f"{name}.csv", arguments.keep)
    tables = read_all()
    (root / "docs" / "TRADE.md").write_text(trade_text(tables) + "\n", encoding="utf-8")
    readme = root / "README.md"
    readme.write_text(replace_block(readme.read_text(encoding="utf-8"), readme_block(tables)), encoding="utf-8")
    trade.panels(tables, root / "docs" / "pictures" / "trade.png")
    print(f"tern: docs/TRADE.md, docs/pictures/trade.png and README.md written from {', '.join(tables)}.")
    return DONE
