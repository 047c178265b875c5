"""Running the points of a study, one at a time so that their CPU times can be compared, cheap ones first."""

import shlex
import sys
import time
from dataclasses import dataclass
from datetime import datetime, timedelta

from tern.errors import BAD_INPUT, DONE, INTERRUPTED, STATUS, Error, ReductionError
from tern.launch import cases, run
from tern.results import report, summary
from tern.studies import accuracy, parameters
from tern.studies.rows import Row


@dataclass
class Planned:
    """A point that is still to be run, with the CPU time that tern-case expects for its case [s]; the file or why not."""

    point: parameters.Point
    expected_s: float
    settings: dict
    refused: str = ""
    exit_code: int = DONE


class Budget(Exception):
    """The next point is not expected to fit."""


def plan(build, path, base_options, wanted):
    """The points with their expected cost, cheapest first; the case as it stands at the begin and at the end."""
    planned = []
    for point in wanted:
        try:
            case = cases.read(build, path, [*base_options, *point.options])
            planned.append(Planned(point, case.get("expected_cpu_s", 1.0), case.get("settings", {})))
        except Error as error:
            planned.append(Planned(point, 0.0, {}, str(error), error.exit_code))
    place = {"standard": 0, "standard-again": 2}
    return sorted(planned, key=lambda one: (place.get(one.point.name, 1), one.expected_s))


def effective_cells(settings, scene_parameters):
    """{key with unit: text} of every parameter of the scene."""
    cells = {}
    for parameter in scene_parameters:
        if parameter.key in ("preset", "spacing"):
            continue
        value = parameters.effective(settings, parameter.key)
        name = f"{parameter.key}_{parameter.unit}" if parameter.unit else parameter.key
        cells[name] = "" if value is None else f"{value:.9g}" if isinstance(value, float) else str(value)
    return cells


def _iterations(contents):
    mean = summary.measure(contents, "pressure_iterations_mean")
    steps = contents.get("processes", {}).get("fluid", {}).get("steps") or contents.get("steps") or 0
    return None if mean is None else mean * steps


class Sweep:
    """The state of one call of ./tern study: what a run is measured by, and how long runs take here."""

    def __init__(self, path, base_options, out, criterion, scene_parameters):
        self.path, self.base_options, self.out, self.criterion = path, base_options, out, criterion
        self.scene_parameters = scene_parameters
        self.wall_s = self.expected_s = 0.0  # of the runs so far: their ratio scales what is expected

    def measured_before(self, expected_s, wall_s):
        """A row of an earlier call tells how fast this machine is."""
        self.expected_s += expected_s
        self.wall_s += wall_s

    def seconds(self, planned):
        """What a point is expected to take; None before anything was measured."""
        return planned.expected_s * self.wall_s / self.expected_s if self.expected_s else None

    def measure(self, planned):
        """Runs a point (or takes note of why it cannot be run) and returns its row; KeyboardInterrupt ends the study."""
        point = planned.point
        row = Row(point.name, point.parameter, point.value, shlex.join(point.options), end_time_s=self.criterion.until,
                  judged_by=self.criterion.judged_by,
                  settings=effective_cells(planned.settings, self.scene_parameters))
        if planned.refused:
            row.status, row.exit_code, row.cause = STATUS.get(planned.exit_code, "failed"), planned.exit_code, planned.refused
            return row
        out = self.out / "points" / point.name
        out.parent.mkdir(parents=True, exist_ok=True)
        try:
            cause, directory = run.run(run.Request(str(self.path), [*self.base_options, *point.options], out=str(out), force=True,
                                                   until=self.criterion.until, threads=1, quiet=True, takes_back=False))
        except Error as error:
            row.status, row.exit_code, row.cause = STATUS.get(error.exit_code, "failed"), error.exit_code, str(error)
            return row
        if cause.exit_code == INTERRUPTED:
            raise KeyboardInterrupt
        contents = report.read(directory)
        row.status, row.exit_code, row.cause = STATUS[cause.exit_code], cause.exit_code, cause.sentence or ""
        row.cpu_s, row.wall_s, row.steps = contents["cpu_s"], contents["wall_s"], contents["steps"]
        row.pressure_iterations = _iterations(contents)
        if cause.exit_code == DONE:
            self.measured_before(planned.expected_s, contents["wall_s"])
            try:
                row.quantities = accuracy.errors(directory, self.criterion)
                row.error = accuracy.root_mean_square(row.quantities.values())
            except ReductionError as error:
                row.cause = f"no error: {error}"
            for frames in [*directory.glob("*.h5"), *directory.glob("*.xmf")]:
                frames.unlink()  # half a gigabyte in forty points; those of a failed run may tell why
        return row


def run_all(sweep, planned, budget_s, keep):
    """Runs the points in order and hands each row to `keep`. Returns the points that were left out for the budget."""
    began = time.monotonic()
    for number, one in enumerate(planned, 1):
        seconds, rest = sweep.seconds(one), planned[number - 1:]
        spent = time.monotonic() - began
        # The repetition of the standard is worth its time: without it nobody knows how far the costs can be trusted.
        last = rest[-1] if rest[-1].point == parameters.STANDARD_AGAIN and one is not rest[-1] else None
        reserve = sweep.seconds(last) or 0.0 if last else 0.0
        if seconds is not None and spent + seconds + reserve > budget_s:
            if last and spent + reserve <= budget_s:
                keep(sweep.measure(last))
                return rest[:-1]
            return rest
        _progress(number, len(planned), one, seconds, [sweep.seconds(other) for other in rest])
        keep(sweep.measure(one))
    return []


def _progress(number, count, planned, seconds, rest):
    eta = ""
    if seconds is not None:
        total = sum(rest)
        at = datetime.now() + timedelta(seconds=total)
        eta = f", about {seconds:.0f} s; all {total / 60:.0f} min, until {at:%H:%M}"
    print(f"tern: study {number}/{count}: {planned.point.name}{eta}", file=sys.stderr, flush=True)


def check_budget(minutes):
    """The budget in seconds; infinite for none."""
    if minutes is None:
        return float("inf")
    if not 0 < minutes < float("inf"):
        raise Error(BAD_INPUT, f"--budget is {minutes} min, but has to be greater than 0.")
    return 60.0 * minutes
