"""./tern status: how a run is doing, seen from outside: how far it is, which process lives, and who waits for whom."""

import contextlib
import re
import time
from datetime import datetime
from pathlib import Path

from tern.launch import process_state
from tern.launch import reports as report_files
from tern.results import report as run_report
from tern.results import summary
from tern.errors import DONE

STATES = {"R": "running", "S": "running", "D": "running (disk)", "T": "stopped (SIGSTOP)", "t": "in a debugger", "Z": "ended"}
WAITS = re.compile(r"^(\S+ \S+) warning (\w+ waits for .*)$")


def _process_state(report, directory):
    """Whether the process that writes this report still lives: a word for people. Only on the machine it runs on."""
    number = report.get("process_id")
    if not number:
        return "not seen yet"
    try:
        words = Path(f"/proc/{number}/cmdline").read_bytes()
    except OSError:
        words = None
    state = process_state.of(number)
    if words is None or state is None:
        return "gone, or on another machine"
    if str(directory).encode() not in words and f"tern-{report.get('role')}".encode() not in words:
        return "gone"  # the number belongs to somebody else by now
    return STATES.get(state, state)


def _waiting(log, newer_than):
    """The last complaint about a wait in a log, if nothing has happened since the last report."""
    try:
        lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return None
    found = WAITS.match(lines[-1]) if lines else None
    if found is None or datetime.fromisoformat(found.group(1)).timestamp() < newer_than:
        return None
    return found.group(2)


def living(directory):
    """Names of the processes of a run that live on this machine."""
    found = []
    for path in sorted(directory.glob("report.*.json")):
        contents = report_files.read(path)
        state = _process_state(contents, directory)
        if contents.get("status") == "running" and not state.startswith(("gone", "not seen")):
            found.append(f"{contents.get('role', path.name)}, process {contents['process_id']}")
    return found


def text(directory):
    """The report as lines."""
    run = run_report.read(directory)
    paths = sorted(directory.glob("report.*.json"))
    if run.get("status") != "running":
        cause = f": {run['first_cause']}" if run.get("first_cause") else ""
        return [f"{summary.shown(directory)}: {run['status']}{cause}", f"  {run.get('steps', 0)} steps, wall {run.get('wall_s', 0):.1f} s"]

    run_report.demand(directory, run, ("started",))
    reports = {}
    for path in paths:
        with contextlib.suppress(OSError):  # just being replaced, or gone: the run has ended in this moment
            if report := report_files.read(path):
                reports[path.name.split(".")[1]] = report, path.stat().st_mtime
    now = time.time()
    lead = max((report for report, _ in reports.values()), key=lambda report: report.get("time_s") or 0, default={})
    head = f"{summary.shown(directory)}: running since {datetime.fromisoformat(run['started']).astimezone():%Y-%m-%d %H:%M:%S}"
    reached, end = lead.get("time_s") or 0, lead.get("end_time_s") or 0
    begun = lead.get("resumed", {}).get("time_s", 0)  # wall_s is of this part
    if reached > begun and end:
        left = (lead.get("wall_s") or 0) * (end - reached) / (reached - begun)
        head += f", t = {reached:.4g} s of {end:g} s ({100 * reached / end:.0f} %), step {lead.get('steps', 0)}, about {left:.0f} s to go"
    lines = [head]
    living = 0
    for role, (report, written) in reports.items():
        state = _process_state(report, directory)
        living += not state.startswith("gone")
        lines.append(f"  {role:<10} process {report.get('process_id') or '?':<8} {state:<20} step {report.get('steps', 0)}, "
                     f"CPU {report.get('cpu_s') or 0:.1f} s, last report {max(0, now - written):.0f} s ago")
        lines += [f"  {'':<10} {line}" for line in summary.ranks(report)]
        waiting = _waiting(directory / f"{role}.log", written)
        if waiting:
            lines.append(f"  {'':<10} {waiting}")
    if reports and living == 0:
        lines.append("  no process of this run lives on this machine: it was killed together with its launcher, or runs elsewhere")
    return lines


def status(arguments):
    """Prints the state of the runs named."""
    for run in arguments.runs:
        print("\n".join(text(Path(run).resolve())))
    return DONE
