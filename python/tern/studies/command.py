"""./tern study: sweeps the parameters of a case, resumes what was begun, and answers which settings to take."""

import shlex
from dataclasses import dataclass, field
from pathlib import Path

from tern.errors import BAD_INPUT, DONE, INPUT_OUTPUT, INTERRUPTED, PEER_LOST, Error, UnreadableRun
from tern.launch import build, cases
from tern.results import summary
from tern.results.run import Run
from tern.studies import accuracy, front, parameters, report, rows, sweep


def parse_error(text):
    """0.05 from "5%", "5 %" or "0.05"."""
    number = text.strip().removesuffix("%").strip()
    try:
        value = float(number) / (100 if text.strip().endswith("%") else 1)
    except ValueError:
        value = float("nan")
    if not 0 < value < float("inf"):
        raise Error(BAD_INPUT, f"--error {text} is not an error greater than 0; write for example 5% or 0.05.")
    return value


def parse_time(text):
    """Seconds from "60", "60s", "2min" or "1h"."""
    units = {"min": 60.0, "s": 1.0, "h": 3600.0}
    number, factor = text.strip(), 1.0
    for unit, size in units.items():
        if number.endswith(unit):
            number, factor = number.removesuffix(unit), size
            break
    try:
        value = float(number) * factor
    except ValueError:
        value = float("nan")
    if not 0 < value < float("inf"):
        raise Error(BAD_INPUT, f"--time {text} is not a time greater than 0; write for example 60s, 2min or 1h.")
    return value


@dataclass
class Request:
    """What ./tern study is asked for; the defaults are those of its options."""

    case: str
    parameters: list = field(default_factory=list)  # names, also several in one, "courant,preset"; none: all the scene has
    levels: int = 2
    budget: float | None = None  # min
    until: float | None = None   # s
    set: list = field(default_factory=list)  # KEY=VALUE
    out: str | None = None
    keep: bool = False


class Study:
    """One case and the directory its points are in."""

    def __init__(self, request):
        self.chosen = parameters.select([name for part in request.parameters for name in part.split(",") if name])
        self.budget_s = sweep.check_budget(request.budget)
        self.path = cases.find(request.case)
        self.build = build.ensure("release")
        self.base_options = [part for setting in request.set for part in ("--set", setting)]
        self.case = cases.read(self.build, self.path, self.base_options)
        self.name = request.case
        self.settings = self.case["settings"]
        self.criterion = accuracy.read(self.path.parent, self.case["end_time"], request.until)
        self.out = Path(request.out) if request.out else Path("runs") / f"study-{self.case['name']}"
        self.out.mkdir(parents=True, exist_ok=True)
        self.csv = self.out / "cost_accuracy.csv"
        self.version, self.keep_versions = build.version(self.build), request.keep
        self.scene_parameters = [parameter for parameter in parameters.PARAMETERS if parameters.applies(parameter, self.settings)]
        wanted = parameters.points(self.settings, self.chosen, request.levels)
        self.wanted = [parameters.STANDARD, *wanted, parameters.STANDARD_AGAIN]
        found = rows.read(self.csv)
        own = {(row.point, row.options): self._judged(row) for row in found if self._belongs(row)}
        self.rows, self.others = list(own.values()), [row for row in found if not self._belongs(row)]

    def _belongs(self, row):
        """Whether the row is of this case as it is now, to this end, and of this version of tern."""
        return (row.base == self.case["hash"] and abs(row.end_time_s - self.criterion.until) < 1e-9
                and (self.keep_versions or row.version == self.version))

    def _judged(self, row):
        """The row with the error over the quantities that count now; study.toml may have changed."""
        row.judged_by = self.criterion.judged_by
        names = {quantity["name"] for quantity in self.criterion.quantities}
        if names <= set(row.quantities):
            row.quantities = {name: value for name, value in row.quantities.items() if name in names}
            row.error = accuracy.root_mean_square(row.quantities.values())
        return row

    def columns(self):
        cells = sweep.effective_cells(self.settings, self.scene_parameters)
        return rows.header([quantity["name"] for quantity in self.criterion.quantities], cells)

    def keep(self, row):
        """Takes a finished point into the table, at once."""
        row.base, row.version = self.case["hash"], self.version
        self.rows = [*(other for other in self.rows if (other.point, other.options) != (row.point, row.options)), row]
        rows.append(self.csv, row, self.columns())
        shown = f"error {report.percent(row.error)}, CPU {report.seconds(row.cpu_s)}" if row.done else f"{row.status}: {row.cause}"
        print(f"tern: {row.point}: {shown}", flush=True)

    def run(self):
        """Runs what is missing; returns (points left out for the budget, whether it was interrupted)."""
        # A process that was killed or a disk that was full says nothing about the settings: such a point is run again.
        known = {(row.point, row.options) for row in self.rows if row.exit_code not in (PEER_LOST, INPUT_OUTPUT)}
        missing = [point for point in self.wanted if (point.name, shlex.join(point.options)) not in known]
        planned = sweep.plan(self.build, self.path, self.base_options,
                             [parameters.STANDARD, *(point for point in missing if point != parameters.STANDARD)])
        standard = next(one for one in planned if one.point == parameters.STANDARD)
        work = sweep.Sweep(self.path, self.base_options, self.out, self.criterion, self.scene_parameters)
        if parameters.STANDARD not in missing:
            planned.remove(standard)
            done = front.find(self.rows, "standard")
            if done:
                work.measured_before(standard.expected_s, done.wall_s)
        if not [one for one in planned if one.point != parameters.STANDARD_AGAIN]:
            planned = [one for one in planned if not front.find(self.rows, front.REPEATED)]
        left_out = []
        try:
            left_out = sweep.run_all(work, planned, self.budget_s, self.keep)
        except KeyboardInterrupt:
            return left_out, True
        return left_out, False

    def fill_distances(self):
        """Distances between the runs, which are known only when the finest is."""
        tables = {row.point: self._table(row) for row in self.rows if row.done}
        best = front.finest(self.rows)
        targets = {row.point: {"distance_to_finest": best and best.point, "distance_to_standard": "standard"} for row in self.rows}
        for parameter in (parameter.key for parameter in self.scene_parameters if parameter.refines):
            entries = front.family(self.rows, parameter)
            for _, row in entries:
                if row.parameter == parameter:
                    targets[row.point]["distance_in_parameter"] = entries[-1][1].point
        for row in self.rows:
            for name, target in targets[row.point].items():
                known = tables.get(row.point) and tables.get(target)
                setattr(row, name, accuracy.distance(tables[row.point], tables[target], self.criterion.curves) if known else None)
        coarser = front.next_finest(self.rows)
        for row in self.rows:
            if row.distance_to_finest == 0:  # the finest, which is not exact: what it may be off, if anything tells
                row.distance_to_finest = coarser.distance_to_finest if coarser else None
        rows.write(self.csv, [*self.others, *self.rows], self.columns())

    def write(self, left_out):
        """The table, study.md and trade.png of what has been measured."""
        self.fill_distances()
        (self.out / "study.md").write_text(report.text(self.case["name"], self.rows, left_out, self.criterion.left_out), encoding="utf-8")
        from tern.studies import picture  # matplotlib takes its time: not before there is something to show
        picture.draw(self.case["name"], self.rows, self.out / "trade.png")

    def _table(self, row):
        """The curves of a row, if what is in its directory is its run: another end or version may have come after it."""
        directory = self.out / "points" / row.point
        try:
            run = Run(directory)
        except UnreadableRun:
            return {}
        table = run.gauges
        same = run.contents.get("options") == [*self.base_options, *shlex.split(row.options)] and run.contents.get("git", "") in row.version
        return table if same and len(table.get("t_s", ())) and abs(table["t_s"][-1] - row.end_time_s) <= 0.02 * row.end_time_s else {}


def _left_out_sentence(left_out):
    names = ", ".join(one.point.name for one in left_out)
    return f"tern: left out, not expected to fit the budget: {names}. Start the same command again to go on." if left_out else ""


def study(arguments):
    """Runs the study (or only answers from it); returns the exit code."""
    wish = {"error": parse_error(arguments.error) if arguments.error else None,
            "time_s": parse_time(arguments.time) if arguments.time else None}
    one = Study(Request(**{name: getattr(arguments, name) for name in Request.__dataclass_fields__}))
    asked = any(value is not None for value in wish.values())
    left_out, interrupted = ([], False) if asked and front.measured(one.rows) else one.run()
    one.write(left_out)
    if asked:
        print(report.answer(one.name, one.rows, **wish, base_options=shlex.join(one.base_options)))
    if left_out:
        print(_left_out_sentence(left_out))
    if one.others:
        print(f"tern: {len(one.others)} rows of the table are of another version, end or case and were left aside"
              f"{'' if one.keep_versions else ' (--keep counts those of another version)'}.")
    print(f"tern: {sum(row.done for row in one.rows)} of {len(one.rows)} points finished; {summary.shown(one.out)}: study.md, trade.png, "
          "cost_accuracy.csv")
    return INTERRUPTED if interrupted else DONE
