"""The frame around a participant in Python, as run/run_main.cpp is around tern's own: command line, effective case,
results directory, log, report, signals and exit code. structure_side.py and fluid_side.py are the loops that run in it.
"""

import argparse
import contextlib
import ctypes
import errno
import json
import math
import os
import resource
import signal
import subprocess
import sys
import time
import traceback
from pathlib import Path

import numpy
import zmq

from tern import paths
from tern.errors import BAD_INPUT, INPUT_OUTPUT, INTERRUPTED, NUMERICAL_FAILURE, PEER_LOST, TOLD_TO_FINISH, refusal
from tern.participant.channel import NumericalFailure, Participant, RunEnded
from tern.participant.checkpoints import Checkpoints
from tern.participant.schema import wire

TICKS_PER_SECOND = 2.0**32
REPORT_INTERVAL_S = 2.0
PATIENCE_S = 1.0  # after a signal: for the coupler to complete the window, have a checkpoint made and end the run
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_SIGNAL_NAMES = {signal.SIGINT: "SIGINT (Ctrl-C)", signal.SIGTERM: "SIGTERM", signal.SIGHUP: "SIGHUP (terminal closed)"}
_ROLES = {"fluid": wire.FLUID, "structure": wire.STRUCTURE}


def bad_input(sentence):
    """The error for a case or option that this participant cannot use."""
    return RunEnded(BAD_INPUT, sentence)


def finite(name, values, step):
    """The values as a flat list for a message; NumericalFailure where one is not finite."""
    array = numpy.asarray(values, dtype=float).ravel()
    bad = ~numpy.isfinite(array)
    if bad.any():
        index = int(numpy.argmax(bad))
        place = f"{name}[{index}]" if array.size > 1 else name
        raise NumericalFailure(f"{place} is {array[index]} at step {step}; the computation has diverged: "
                               "a smaller step may help; the frames before show where it began.")
    return array.tolist()


class Case:
    """The effective case, as `tern-case json` prints it: file, preset and --set with every default filled in."""

    def __init__(self, contents):
        self.name, self.path, self.hash = contents["name"], contents["path"], contents["hash"]
        self.dimension, self.end_time, self.settings = contents["dimension"], contents["end_time"], contents["settings"]
        self._account = contents["account"]

    @property
    def gravity(self):
        """Constant gravity [m/s^2]."""
        components = self.settings["gravity"]
        if any(isinstance(component, str) for component in components):
            raise bad_input(f"{self.path}: gravity is {components}, an expression; this solver takes constant gravity only.")
        return numpy.array(components, dtype=float)

    def gauges(self, role):
        """[(gauge, number of its values)] of one side, in the order of the case file."""
        columns = self._account[role]["gauge"]
        found = []
        for gauge in self.settings.get("gauge", []):
            count = sum(column.rsplit(".", 1)[0] == gauge["name"] for column in columns)
            if count:
                found.append((gauge, count))
        return found

    def only_body(self):
        """The one elastic body of the case."""
        bodies = self.settings["structure"]["body"]
        if len(bodies) != 1:
            raise bad_input(f"{self.path} has {len(bodies)} elastic bodies; this solver takes exactly one.")
        return bodies[0]

    def face_length(self, body):
        """Longest side of a face of a body's surface [m], as tern-structure cuts them (scene/case_file.hpp): its spacing, or a whole
        part of it that is at most half of the fluid's. To the particles longer ones are no even face: the load of still water jumps."""
        spacing, fluid = body["spacing"], self.settings.get("fluid")
        longest = 0.5 * fluid["spacing"] if fluid else spacing
        return spacing / max(1, math.ceil(spacing / longest * (1 - 1e-9)))

    def body_box(self):
        """Corners (min, max) of the one elastic body, which has to be a box."""
        shape = self.only_body()["shape"]
        if "box" not in shape:
            raise bad_input(f"{self.path}: the body '{self.only_body()['name']}' is a {next(iter(shape))}; this solver takes a "
                            "box only.")
        return tuple(numpy.array(shape["box"][side], dtype=float) for side in ("min", "max"))


def _read_case(options):
    build = Path(os.environ.get("TERN_BUILD") or paths.build())
    words = [part for text in options.set for part in ("--set", text)]
    words += ["--preset", options.preset] if options.preset else []
    try:
        answer = subprocess.run([build / "tern-case", "json", options.case, *words], capture_output=True, text=True, check=False)
    except OSError as error:
        raise bad_input(f"{build} has no tern-case to read the case with ({error.strerror}); build there first, or set "
                        "TERN_BUILD to a finished build directory.") from error
    if answer.returncode != 0:
        code = INPUT_OUTPUT if answer.returncode == INPUT_OUTPUT else BAD_INPUT
        raise RunEnded(code, answer.stderr.strip().removeprefix("tern-case: "))
    return Case(json.loads(answer.stdout))


class Report:
    """report.<role>.json: what the launcher gathers in run.json; rewritten every 2 s and at the end."""

    def __init__(self, role, options):
        self._path = Path(options.out) / f"report.{role}.json"
        self._begin = self._written = time.monotonic()
        self.timing = dict.fromkeys(("compute", "exchange", "output", "wait"), 0.0)
        self.measures, self.counts = {}, {}
        self.time_s, self.steps = 0.0, 0
        self.contents = {"role": role, "process_id": os.getpid(), "status": "running", "exit_code": 0, "cause": "", "cause_time": 0,
                         "preset": options.preset or "", "overrides": options.set, "threads": options.threads}

    def set_case(self, case, options):
        self.contents |= {"case": case.name, "case_path": case.path, "case_hash": case.hash, "settings": case.settings,
                          "end_time_s": options.until or case.end_time}

    def set_end(self, exit_code, cause, shorter_windows_may_help=False):
        status = {0: "done", INTERRUPTED: "interrupted"}.get(exit_code, "failed")
        self.contents |= {"status": status, "exit_code": exit_code, "cause": cause, "cause_time": time.time() if exit_code else 0,
                          "shorter_windows_may_help": shorter_windows_may_help}

    def write(self):
        usage = resource.getrusage(resource.RUSAGE_SELF)
        self._written = time.monotonic()
        self.contents |= {"wall_s": self._written - self._begin, "cpu_s": usage.ru_utime + usage.ru_stime, "steps": self.steps,
                          "time_s": self.time_s, "timing_s": self.timing, "measures": self.measures, "counts": self.counts}
        temporary = self._path.with_suffix(".tmp")
        try:
            temporary.write_text(json.dumps(self.contents, indent=1) + "\n", encoding="utf-8")
            os.replace(temporary, self._path)
        except OSError:
            temporary.unlink(missing_ok=True)
            raise

    def update(self):
        if time.monotonic() - self._written >= REPORT_INTERVAL_S:
            self.write()


class Run:
    """What a loop works with: the case, the options, the channel to the coupler, log, report and the clock of each activity."""

    def __init__(self, role, program, options):
        self.role, self.program, self.options = role, program, options
        self.case = self.channel = None
        self._waiting, self._signal, self._late = False, None, False
        self.resumes = options.resume
        self._checkpoints = Checkpoints(options.out, role)
        self._log = open(Path(options.out) / f"{role}.log", "a" if self.resumes else "w", buffering=1, encoding="utf-8")
        self.report = Report(role, options)

    def log(self, sentence, level="info"):
        """A line in the log. A disk that is full stops the run where results are lost, not here."""
        now = time.time()
        with contextlib.suppress(OSError):
            self._log.write(f"{time.strftime('%Y-%m-%d %H:%M:%S', time.localtime(now))}.{int(now % 1 * 1000):03d} {level} {sentence}\n")

    def warn(self, sentence):
        """A line in the log and on standard error."""
        self.log(sentence, "warning")
        with contextlib.suppress(OSError):
            print(f"{self.program}: warning: {sentence}", file=sys.stderr)

    @contextlib.contextmanager
    def timed(self, activity):
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.report.timing[activity] += time.perf_counter() - begin

    def handshake(self, hello, saves=False):
        """Completes Hello, says it, and returns Welcome. `saves`: next_order() is given what keeps the state, and where Welcome has a
        resume_step the solver goes back to it: restored() tells what was kept."""
        hello.saves = saves
        if self.resumes:
            if not saves:
                raise bad_input(f"The run cannot be continued: {self.program} keeps no checkpoints (docs/PARTICIPANTS.md).")
            hello.checkpoint.extend([wire.Checkpoint(step=step, hash=digest) for step, digest in self._checkpoints.files()])
        hello.case_hash, hello.dimension = hello.case_hash or self.case.hash, self.case.dimension
        hello.version = hello.version or f"{self.program} (Python)"
        with self._interruptible():
            welcome = self.channel.handshake(hello)
        if self.resumes != (welcome.resume_step > 0):
            raise bad_input("Start all processes of the run with --resume, or all without: "
                            f"the coupler {'begins anew' if self.resumes else 'goes on from a checkpoint'}.")
        if not self.resumes:
            self._checkpoints.clear()
        self.log(f"joined the coupler (version {welcome.version}) at {self.options.endpoint}: {welcome.surface_points} surface "
                 "points")
        return welcome

    def next_order(self, keep=None):
        """The next begin_window or finish; before that keep(), a dict of arrays by name, goes to a file when the coupler wants it."""
        kinds = ("begin_window", "finish") + (("save",) if keep else ())
        while (order := self.receive(*kinds)).WhichOneof("body") == "save":
            with self.timed("output"):
                report = {"report.steps": self.report.steps, "report.time_s": self.report.time_s}
                digest = self._checkpoints.save(order.step, keep() | report)
            self.send(saved=wire.Saved(hash=digest))
        return order

    def restored(self, welcome):
        """What keep() has given at the step from which the run goes on."""
        kept = self._checkpoints.load(welcome.resume_step)
        self.report.steps, self.report.time_s = int(kept.pop("report.steps")), float(kept.pop("report.time_s"))
        self.log(f"goes on from the checkpoint of step {welcome.resume_step}")
        return kept

    def receive(self, *kinds):
        """The next message of the coupler; Ctrl-C ends the wait."""
        with self._interruptible():
            return self.channel.receive(*kinds)

    def send(self, **body):
        with self.timed("exchange"):
            self.channel.send(**body)

    def step_done(self, order):
        """A window has been completed: its end is where the report stands."""
        window = order.begin_window
        self.report.steps += 1
        self.report.time_s = (window.begin_ticks + window.duration_ticks) / TICKS_PER_SECOND
        self.report.update()

    def finish(self, order, account):
        """Answers Finish. Raises RunEnded when the user has ended the run."""
        self.send(finished=wire.Finished(account=account))
        if order.finish.interrupted:
            raise RunEnded(INTERRUPTED, TOLD_TO_FINISH)

    def account(self, energies, gauge):
        """wire.Account: `energies` by name in the order of the columns of energy.csv; `gauge(gauge)` gives the values of one gauge of
        this side, or None where it has none."""
        account = wire.Account(energy=[finite(f"energy {name}", value, self.channel.step)[0] for name, value in energies.items()])
        for entry, count in self.case.gauges(self.role):
            values = gauge(entry)
            account.gauge.extend([0.0] * count if values is None else finite(f"gauge {entry['name']}", values, self.channel.step))
            account.undefined.extend([values is None] * count)
        return account

    def remember_signal(self, number, _frame):
        """Ends a wait, of a run that has begun after PATIENCE_S; a computation is ended at the next wait, so that no file is left half
        written."""
        if number != signal.SIGALRM:
            self._signal = number
        self._late = number == signal.SIGALRM or not (self.channel and self.channel.step)
        if not self._late:
            signal.setitimer(signal.ITIMER_REAL, PATIENCE_S)
        if self._waiting:
            self._throw_if_interrupted()

    def _throw_if_interrupted(self):
        if self._late:
            raise RunEnded(INTERRUPTED, f"Interrupted by {_SIGNAL_NAMES[self._signal]} at step {self.report.steps}; everything "
                                        "written up to here is kept.")

    @contextlib.contextmanager
    def _interruptible(self):
        with self.timed("wait"):
            self._waiting = True
            try:
                self._throw_if_interrupted()
                yield
            finally:
                self._waiting = False

    def close(self):
        if self.channel is not None:
            self.channel.close()
        with contextlib.suppress(OSError):
            self._log.close()


def _parser(role, program):
    parser = argparse.ArgumentParser(prog=program, description=f"The {role} of a tern run.", allow_abbrev=False,
                                     epilog=f'Started by ./tern run CASE --{role} "{program} ...", or by hand with --endpoint.')
    parser.add_argument("case", metavar="CASE", help="case.toml, its folder, or the name of a folder under cases/")
    parser.add_argument("--out", metavar="DIR", required=True, help="directory of the results")
    parser.add_argument("--endpoint", metavar="ADDRESS", required=True, help="ZeroMQ address of the coupler")
    parser.add_argument("--keys", metavar="DIR", help="directory with this role's keys, made by ./tern keys")
    parser.add_argument("--insecure", action="store_true", help="use a network address without keys")
    parser.add_argument("--deadline", metavar="S", type=float, default=300.0, help="give the coupler up that leaves a message out "
                        "for 2 S seconds: it waits itself")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="override a key of the case")
    parser.add_argument("--preset", metavar="NAME", help="numerical settings as a group")
    parser.add_argument("--until", metavar="T", type=float, help="end at this simulated time [s]; the coupler keeps it")
    parser.add_argument("--threads", metavar="N", type=int, default=1, help="threads of this process")
    parser.add_argument("--resume", action="store_true", help="go on from the newest checkpoint in DIR")
    parser.add_argument("--force", action="store_true", help="replace the results of an earlier run in DIR")
    parser.add_argument("--allow-unstable", action="store_true", help="for the coupler")
    parser.add_argument("--quiet", action="store_true", help="for the coupler, which owns the progress line")
    return parser


def _end_with_launcher():
    """SIGTERM when the launcher dies that has named itself in TERN_LAUNCHER, whatever becomes of its guardian (base/interrupt.hpp)."""
    if os.environ.get("TERN_LAUNCHER") == str(os.getppid()):
        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(1, int(signal.SIGTERM), 0, 0, 0)  # PR_SET_PDEATHSIG


def _prepare_directory(options, role):
    directory = Path(options.out)
    directory.mkdir(parents=True, exist_ok=True)
    for name in (f"report.{role}.json", f"{role}.h5"):
        if not options.force and not options.resume and (directory / name).exists():
            raise bad_input(f"{options.out} holds {name} of an earlier run; choose another --out, or --force to replace it.")


def _cause_of(error, program):
    """(exit code, sentence) of whatever ended a run."""
    if isinstance(error, RunEnded):
        return error.exit_code, str(error)
    if isinstance(error, zmq.ZMQError):
        return PEER_LOST, f"The coupler process cannot be reached any more: {error}."
    if isinstance(error, OSError) and error.errno in NO_ROOM:
        what = error.filename or f"a file of {program}"
        return INPUT_OUTPUT, f"Cannot write {what}: {error.strerror}; free space or choose another --out."
    if isinstance(error, OSError):
        return INPUT_OUTPUT, f"{program} was refused by the system: {refusal(error)}."
    place = _last_place_outside(Path(__file__).parent, error)
    return NUMERICAL_FAILURE, f"{program} met an unexpected fault of its own: {type(error).__name__}: {str(error).rstrip(' .')}{place}."


def _last_place_outside(library, error):
    """" (its file, line n)" of the last call that is a solver's own; its whole way is in the log."""
    calls = [call for call in traceback.extract_tb(error.__traceback__) if Path(call.filename).parent != library]
    own = [call for call in calls if Path(call.filename).is_file() and "-packages" not in call.filename]
    return f" ({Path(own[-1].filename).name}, line {own[-1].lineno})" if own else ""


def run_participant(role, obey, add_options=None):
    """The whole of main() of a participant; returns the exit code. `obey(run)` is the loop; `add_options(parser)` may add options
    of the solver's own, which are then in run.options."""
    program = Path(sys.argv[0]).name
    parser = _parser(role, program)
    if add_options:
        add_options(parser)
    options = parser.parse_args()
    run, code, sentence, failed_numerically = None, 0, "", False
    try:
        _prepare_directory(options, role)
        run = Run(role, program, options)
        for number in (*_SIGNAL_NAMES, signal.SIGALRM):
            signal.signal(number, run.remember_signal)
        _end_with_launcher()
        run.log("started as: " + " ".join(sys.argv))
        run.channel = Participant(options.endpoint, _ROLES[role], progress_deadline_s=2 * options.deadline, keys=options.keys,
                                  insecure=options.insecure)
        run.case = _read_case(options)
        run.report.set_case(run.case, options)
        run.report.write()
        obey(run)
    except Exception as error:  # whatever it is, the coupler is told and the launcher finds a report
        code, sentence = _cause_of(error, program)
        failed_numerically = isinstance(error, NumericalFailure)
        if run and not isinstance(error, RunEnded):
            run.log(traceback.format_exc(), "err")
        if run and run.channel:
            with contextlib.suppress(zmq.ZMQError):
                run.channel.abort(code, sentence.encode("ascii", "replace").decode()[:4096])
        try:
            print(f"{program}: {sentence}", file=sys.stderr)
        except OSError:  # nobody reads it; the coupler and the report have it
            sys.stderr = open(os.devnull, "w", encoding="utf-8")
    if run:
        run.report.set_end(code, sentence, failed_numerically)
        try:
            run.report.write()
            run.log(f"ends with exit code {code} at step {run.report.steps}, t = {run.report.time_s:.9g} s. {sentence}")
        except OSError as error:
            print(f"{program}: the report cannot be written: {error}.", file=sys.stderr)
            code = code or INPUT_OUTPUT
        run.close()
    return code
