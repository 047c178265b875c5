"""./tern run: validates, starts the processes a case needs, watches them, and leaves one run.json."""

import contextlib
import fcntl
import os
import shlex
import shutil
import sys
import time
from dataclasses import dataclass, field, replace
from datetime import datetime, timezone
from pathlib import Path

from tern import paths
from tern.errors import BAD_INPUT, DONE, INPUT_OUTPUT, PEER_LOST, STATUS, Error, UnreadableRun, refusal
from tern.launch import build, cases, first_cause, hosts, packages, process_state, ranks, resumption, spent, status, window_repeat
from tern.launch import reports as report_files
from tern.launch.processes import Group, Interrupts
from tern.launch.record import ROOM, overwrite_json, write_json
from tern.results import report as run_report
from tern.results import summary

OLD_SOLVERS = Path("proto/python/participants")  # where they were one version ago
IN_LAUNCH = ("until", "threads", "ranks", "oversubscribe", "hosts", "interface", "ports", "deadline", "record", "allow_unstable", "only",
             "endpoint", "network_options")
ROLES = ("coupler", "fluid", "structure")  # the order of starting: the coupler binds the endpoint
TICK_S = 2.0**-32  # the clock of a run counts these
A_MOMENT_S = 1.0  # in which another part of a run has emptied their directory


@dataclass
class Request:
    """What ./tern run is asked for; the defaults are those of its options."""

    case: str                    # a case.toml, its folder, or a name
    case_options: list = field(default_factory=list)  # --set and --preset, in words
    out: str | None = None
    force: bool = False
    until: float | None = None   # s
    threads: int | None = None
    ranks: int | None = None     # processes of the fluid
    oversubscribe: bool = False  # more of them than cores
    hosts: str | None = None     # a file with the machines of the ranks
    interface: str | None = None  # the network between these
    ports: str | None = None     # what Open MPI may open there
    deadline: float | None = None  # s
    quiet: bool = False
    build: str = "release"
    fluid: str | None = None     # a command in place of tern-fluid
    structure: str | None = None
    record: bool = False
    allow_unstable: bool = False
    only: str | None = None      # one role
    endpoint: str | None = None
    network_options: list = field(default_factory=list)  # --keys and --insecure, in words
    resume: str | None = None    # directory of the run that goes on
    retries: int = 0             # how often a run that lost a process goes on by itself
    takes_back: bool = True      # whether windows that fail are repeated
    repeat: window_repeat.Repeat | None = None  # which ones are now


def roles_of(case, only):
    """The processes this case needs: a side it does not have is not started, one side alone needs no coupler."""
    sides = [role for role in ("fluid", "structure") if case[f"has_{role}"]]
    needed = ["coupler", *sides] if len(sides) == 2 else sides
    if only is None:
        return needed
    if only not in needed:
        raise Error(BAD_INPUT, f"--only {only}: the case {case['name']} needs no {only} process, only "
                                       f"{' and '.join(needed)}.")
    return [only]


def _program(word):
    """What a command starts: a file, a program on the PATH, or by its name one of the participants that come with tern."""
    own = Path(word)
    if own.parent == OLD_SOLVERS:
        print(f"tern: {own.parent} is gone; write {own.name} only, from any folder.", file=sys.stderr)
    return shutil.which(word) or (shutil.which(own.name, path=paths.solvers()) if own.parent in (Path(), OLD_SOLVERS) else None)


def foreign_command(text, role, case, roles):
    """The words of a command that takes the place of tern-ROLE, its program found; None for no command."""
    if text is None:
        return None
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise Error(BAD_INPUT, f"--{role} {text!r} cannot be split into words: {error}.") from error
    if not words:
        raise Error(BAD_INPUT, f"--{role} is empty; give the command that takes the place of tern-{role}.")
    if not (case["has_fluid"] and case["has_structure"]):
        raise Error(BAD_INPUT, f"--{role}: the case {case['name']} is not coupled; one side can be replaced only where "
                                       "there are two.")
    if role not in roles:
        raise Error(BAD_INPUT, f"--{role} is of no use with --only {roles[0]}.")
    program = _program(words[0])
    if program is None:
        reason = ("is not executable; make it so (chmod +x), or put its interpreter before it" if os.path.isfile(words[0])
                  else "is neither a file nor a program on the PATH")
        raise Error(BAD_INPUT, f"--{role}: {words[0]} {reason}.")
    return [os.path.abspath(program), *words[1:]]


def foreign_environment(directory, threads):
    """What a participant started by us finds: the build that reads cases, the Python library of participants, and as many
    threads in the libraries it uses as tern's own processes have."""
    threads = str(threads or 1)
    return os.environ | {"TERN_BUILD": str(directory), "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads,
                         "PYTHONPATH": os.pathsep.join(map(str, filter(None,
                                                                       (paths.python(), paths.old_names(), os.environ.get("PYTHONPATH")))))}


def _touched(path):
    """When a file was written last; None where it is missing."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return None


def _write_end(path, contents):
    """On a full disk the first cause is what must not be missing."""
    try:
        write_json(path, contents)
    except OSError:
        overwrite_json(path, contents, ("processes", "settings", "gauge_places"))


def _merged(run, processes, reports, cause, wall_s):
    """The contents of run.json after the end. Of a run that went on from a checkpoint they count all its parts."""
    any_report = next((report for report in reports.values() if report), {})
    for process in processes:
        report = reports.setdefault(process.role, {})
        report["program"] = process.program
        report["exit_code"] = process.exit_code
        report["cpu_s"] = process.cpu_s
        if report.get("status") in (None, "running"):
            report["status"] = "killed" if process.exit_code < 0 else "failed" if process.exit_code or process.never_joined else "done"
    taken = spent.together(run.pop("spent"), reports | {spent.RUN: {"wall_s": wall_s}})
    for process in processes:
        reports[process.role] |= taken[process.role]
    return run | {
        "status": STATUS[cause.exit_code], "exit_code": cause.exit_code, "first_cause": cause.sentence,
        "first_cause_role": cause.role,
        "exit_codes": {process.role: process.exit_code for process in processes},
        "wall_s": taken[spent.RUN]["wall_s"], "cpu_s": sum(report["cpu_s"] for report in reports.values() if "cpu_s" in report),
        "steps": max((report.get("steps") or 0 for report in reports.values()), default=0) or run.get("resumed", [{}])[-1].get("step", 0),
        "version": any_report.get("version", ""), "git": any_report.get("git", ""),
        "processes": reports,
    }


def say(text):
    """Prints to who may have gone, as `head -1` does: the run is what counts."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # the interpreter flushes once more at its end


def tell(text):
    """The same on standard error."""
    try:
        print(text, file=sys.stderr, flush=True)
    except OSError:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")


class Work:
    """What lasts over all parts of a run: the signals that end it, and the hold on its directory. A run of one `role` may share that
    with those of the others."""

    def __init__(self, stack, role):
        self._stack, self._role, self._held, self._interrupts = stack, role, None, None
        self._descriptor = None
        self.spent = {}  # by what was begun anew

    def interrupts(self):
        if self._interrupts is None:
            self._interrupts = self._stack.enter_context(Interrupts())
        return self._interrupts

    @property
    def interrupted(self):
        return self._interrupts is not None and self._interrupts.count > 0

    def hold(self, directory, to_empty=False):
        """No other run is to work in this directory meanwhile. Returns whether all of it may be emptied (`to_empty`): not where other
        parts of this run are at work in it. Raises Error where another run is, or where this part is already."""
        directory = directory.resolve()
        if directory == self._held:
            return self._role is None
        descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        self._stack.callback(os.close, descriptor)
        try:
            alone = (self._role is None or to_empty) and _lock(descriptor, fcntl.LOCK_EX)
            if not alone and (self._role is None or not _lock(descriptor, fcntl.LOCK_SH, A_MOMENT_S)):
                raise _at_work(directory)
        except OSError:
            return True  # a file system without locks
        self._held, self._descriptor = directory, descriptor
        return alone

    def share(self):
        """Lets the other parts of a run of one role in, once run.json says whose directory it is."""
        if self._role and self._held and not _lock(self._descriptor, fcntl.LOCK_SH, A_MOMENT_S):
            raise _at_work(self._held)

    def join(self, case):
        """Raises Error unless who is at work in the directory may be the other parts of this run: of the same case, and none of this
        role."""
        try:
            there = run_report.read(self._held)
        except UnreadableRun:
            there = {}  # it is about to be written
        lives = there.get("status") == "running" and process_state.of(there.get("launcher")) not in (None, "Z", "X")
        same_part = lives and there.get("launch", {}).get("only") in (None, self._role)
        if (same_part or (lives and there.get("case_hash") != case["hash"])
                or any(process.startswith(f"{self._role},") for process in status.living(self._held))):
            raise _at_work(self._held)


def _at_work(directory):
    return Error(BAD_INPUT, f"Another ./tern is at work in {summary.shown(directory)}; wait for its end, or give another --out.")


def _lock(descriptor, kind, patience_s=0.0):
    """Whether the lock could be had in so long."""
    until = time.monotonic() + patience_s
    while True:
        try:
            fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() >= until:
                return False
            time.sleep(0.02)


def run(request):
    """Runs a case. Returns (why it ended: first_cause.Cause, directory of the results). Windows that have failed are taken back and
    repeated at half their length. After a lost process a run with retries goes on from its newest checkpoint."""
    with contextlib.ExitStack() as stack:
        return _run(request, Work(stack, request.only))


def _run(request, work):
    cause, out, contents = _run_once(request, work)
    left = request.retries
    while contents:
        work.spent = spent.until_now(contents, out)
        try:
            if cause.exit_code == PEER_LOST and left > 0:
                following = resumed(out, request)
                note = f"The run goes on from its newest checkpoint ({left} of {request.retries} retries left)."
                left -= 1
            elif request.takes_back and (repeat := window_repeat.plan(out, contents, cause, resumption.manifests(out))):
                following = replace(request, out=str(out), resume=None, force=True) if repeat.anew else resumed(out, request)
                following = replace(following, repeat=repeat)
                note = repeat.note
            else:
                if window_repeat.may_help(contents, cause) and contents.get("taken_back"):
                    cause.sentence += window_repeat.history(contents["taken_back"])
                    _amend(out, contents, cause)
                break
            if work.interrupted:
                cause = first_cause.by_user()
                _amend(out, contents, cause)
                break
            tell(f"tern: {cause.sentence} {note}")
            cause, out, contents = _run_once(following, work)
        except Error as error:
            tell(f"tern: {error}")
            break
    if not request.quiet and contents:
        say(summary.text(contents, out))
        for warning in contents["warnings"]:
            tell(f"tern: warning: {warning}")
    return cause, out


def _amend(out, contents, cause):
    """Another end of the run in its run.json; on a full disk the one before stays."""
    contents |= {"status": STATUS[cause.exit_code], "exit_code": cause.exit_code, "first_cause": cause.sentence,
                 "first_cause_role": cause.role}
    with contextlib.suppress(OSError):
        _write_end(out / "run.json", contents)


def resumed(out, request):
    """The request for what is left of the run in `out`; of `request` what may be new: end, threads, ranks, deadline, quiet, and more
    --set."""
    contents, _ = resumption.newest(out)
    launch, commands = contents["launch"], contents["commands"]
    own = {"case": contents["case_path"], "case_options": contents["options"], "out": str(out), "resume": str(out),
           "until": request.until or launch.get("until"),
           **{name: getattr(request, name) or launch.get(name) for name in ("threads", "ranks", "hosts", "interface", "ports", "deadline")},
           "oversubscribe": request.oversubscribe or launch.get("oversubscribe", False), "quiet": request.quiet, "build": request.build}
    of_before = {name: value for name, value in (launch | commands).items() if name in (*IN_LAUNCH, "fluid", "structure")}
    return Request(**{**of_before, **own})


def _run_once(request, work):
    path = cases.find(request.case)
    many = request.ranks is not None
    if many:
        ranks.check_count(request.ranks, request.oversubscribe, request.hosts is not None)  # before a build of some minutes
    directory = build.ensure("ranks" if many and request.build == "release" else request.build)
    case = cases.read(directory, path, request.case_options)
    roles = roles_of(case, request.only)
    commands = {role: command for role in ("fluid", "structure")
                if (command := foreign_command(getattr(request, role), role, case, roles))}
    for command in commands.values():
        packages.ensure_for(command)
    if many:
        ranks.check(roles, commands)
    machines = None
    if many and request.hosts:
        machines = hosts.read(request.hosts, request.interface, request.ports, request.ranks, request.oversubscribe)
        hosts.examine(machines, [directory / "tern-fluid", directory / ranks.LISTENER, path])
    before = None
    if request.resume:
        out = Path(request.resume).resolve()
        before, checkpoint = resumption.newest(out)
        work.hold(out)
        if changed := resumption.differences(before["settings"], case.get("settings", {})):
            raise Error(BAD_INPUT, f"{path} is not the case of {summary.shown(out)} any more: {'; '.join(changed)}. Undo that, or begin "
                                   f"anew; only {resumption.IN_WORDS}.")
        if checkpoint and request.until is not None and request.until < checkpoint["time_s"] - TICK_S:
            raise Error(BAD_INPUT, f"--until {request.until:g} s is before the newest checkpoint of {summary.shown(out)}, t = "
                                   f"{checkpoint['time_s']:.6g} s: a run goes on, not back; give a later time.")
        if checkpoint:
            resumption.check_tables(out, checkpoint)
    else:
        if request.repeat and case["hash"] != request.repeat.case_hash:
            raise Error(BAD_INPUT, f"{path} has changed since the windows that are to be repeated: begin anew.")
        asked = Path(request.out) if request.out else Path("runs") / case["name"]
        whose = cases.ROLES
        if request.force and asked.is_dir() and not work.hold(asked, to_empty=True):  # before anything in it is removed
            work.join(case)
            whose = roles
        out = cases.make_out_directory(case["name"], request.out, request.force, whose)
        work.hold(out)
    if not request.quiet:
        # Said before the first progress line: where the results appear, and under which name.
        where = f", goes on from step {checkpoint['step']}, t = {checkpoint['time_s']:.6g} s" if before and checkpoint else ""
        if not request.repeat:  # windows that are repeated are of a case that has been introduced
            say(f"tern: {case['name']} ({', '.join(roles)}){where}, results in {summary.shown(out)}")
            for warning in case.get("warnings", []):
                tell(f"tern: warning: {warning}")

    contents = {"case": case["name"], "case_path": str(path), "title": case.get("title", ""), "case_hash": case["hash"],
                "started": datetime.now(timezone.utc).isoformat(timespec="seconds"), "status": "running",
                "launcher": os.getpid(), "settings": case.get("settings", {}), "gauge_places": case.get("gauge_places", []),
                "options": request.case_options,
                "commands": {role: shlex.join(command) for role, command in commands.items()},
                "launch": {name: getattr(request, name) for name in IN_LAUNCH},
                "spent": spent.until_now(before, out) if before else work.spent}
    if before:
        now = datetime.now(timezone.utc).isoformat(timespec="seconds")
        contents["started"] = before["started"]
        contents["resumed"] = [*before.get("resumed", []), {"date": now, **(checkpoint or {})}]
    # A part that was lost before it had a checkpoint of the repeated windows has to repeat them as well.
    repeat = request.repeat or (window_repeat.again(before, resumption.manifests(out)) if before else None)
    if taken_back := repeat.taken_back if repeat else (before or {}).get("taken_back"):
        contents["taken_back"] = taken_back
    options = [*request.case_options, "--out", str(out), *request.network_options]
    if request.until is not None:
        options += ["--until", repr(request.until)]
    if request.threads is not None:
        options += ["--threads", str(request.threads)]
    if request.deadline is not None and (len(roles) > 1 or request.only):
        options += ["--deadline", repr(request.deadline)]
    if request.force:
        options.append("--force")
    if before:
        options.append("--resume")
    if request.allow_unstable:
        options.append("--allow-unstable")
    timekeeper = "coupler" if "coupler" in roles else roles[0]
    began = time.monotonic()
    steps = out / "steps.csv"
    touched = _touched(steps)  # the coupler makes it, or cuts it back, when all have joined
    interrupts = work.interrupts()
    with Group(out) as group:
        endpoint = request.endpoint or f"ipc://{group.directory}/tern.sock"
        try:
            write_json(out / "run.json", contents, ROOM)
            work.share()
            for role in roles:
                own = list(options)
                if len(roles) > 1 or request.only:
                    own += ["--endpoint", endpoint]
                if request.record and role == "coupler":
                    own.append("--record")
                if repeat and role == timekeeper:
                    own += ["--repeat", str(repeat.halvings), repr(repeat.until), repr(repeat.longest)]
                if request.quiet or (len(roles) > 1 and role != "coupler"):
                    own.append("--quiet")  # one progress line: the coupler's, or that of the process that runs alone
                if role in commands:
                    group.start(role, [*commands[role], str(path), *own], Path(commands[role][0]).name,
                                foreign_environment(directory, request.threads))
                elif many and role == "fluid":
                    words = [str(directory / f"tern-{role}"), str(path), *own]
                    start = ranks.Start(directory, Path(group.directory), request.ranks, request.oversubscribe, endpoint, machines)
                    if machines:
                        tell(f"tern: {machines.sentence(request.ranks)}")
                    group.start(role, start.command(words), None, start.environment(), in_ranks=True)
                else:
                    group.start(role, [str(directory / f"tern-{role}"), str(path), *own])
        except OSError as error:
            raise Error(INPUT_OUTPUT, f"The run could not be started: {refusal(error)}.") from error
        group.supervise(interrupts, (lambda: _touched(steps) != touched) if "coupler" in roles else lambda: True)
        wall_s = time.monotonic() - began
        for half_written in [*out.glob("*.tmp"), *out.glob("checkpoint/*.tmp")]:  # by a process that was killed while it wrote
            half_written.unlink(missing_ok=True)
        reports = {role: report_files.read(out / f"report.{role}.json") for role in roles}
        cause = first_cause.find(group.processes, reports, interrupts.count > 0)
        cause.sentence = first_cause.without_missing_logs(cause.sentence, group.processes, out)
        if before:
            # The process that keeps time has taken an older checkpoint where the newest was not whole.
            contents["resumed"][-1] |= reports[timekeeper].pop("resumed", {})
        contents = _merged(contents, group.processes, reports, cause, wall_s)
        contents["warnings"] = summary.warnings(contents, out)
        refused = before and cause.exit_code == BAD_INPUT
        if refused:
            contents = before  # what was there is as it was
        try:
            for role in roles:
                (out / f"report.{role}.json").unlink(missing_ok=True)
            _write_end(out / "run.json", contents)
        except OSError as error:
            if cause.exit_code == DONE:
                raise Error(INPUT_OUTPUT, f"The results are in {out}, but run.json could not be written: "
                                                  f"{error}.") from error
    return cause, out, None if refused else contents
