#!/usr/bin/python3 -B
"""How long after an event the whole run has ended, on a machine with other work to do.

    TERN_BUILD=build/release bench/noticing.py            while 8 processes compute beside it
    TERN_BUILD=build/release bench/noticing.py 0          on a machine that is otherwise idle

The event happens to one process of a small scene of the process tests, or to the launcher. A stuck process is made so by the library of
the failure matrix (`ninja fault_injection`): its main thread does nothing any more, its heartbeats go on. Prints a Markdown table with the
times from the event to the end of the launcher [s]; ends with exit code 3 when one is longer than documented.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
CASES = ROOT / "tests" / "process" / "cases"
BUILD = Path(os.environ.get("TERN_BUILD", ROOT / "build" / "release")).resolve()
DEADLINE_S = 4
# Before the pressure, the surface, or the condition of the 40th window is sent (bodies of proto/wire/tern.proto).
STUCK_AT = {"fluid": "send:16:40", "structure": "send:13:40", "coupler": "send:15:40"}


class Event(NamedTuple):
    """What happens to one process; a run is made for each of `victims`. With `stuck` its main thread does nothing any more."""

    name: str
    signal: int | None  # None: that it is stuck is the event
    victims: tuple
    documented_s: int  # in ROBUSTNESS.md and README.md
    stuck: bool = False


ALL = ("fluid", "structure", "coupler")
EVENTS = (
    Event("killed (SIGKILL)", signal.SIGKILL, ALL, 1),
    Event("terminated (SIGTERM)", signal.SIGTERM, ALL, 2),
    Event("frozen (SIGSTOP)", signal.SIGSTOP, ALL, 10),
    Event("Ctrl-C", signal.SIGINT, ("launcher",) * 3, 2),
    Event("Ctrl-C in a window that does not end", signal.SIGINT, ALL, 2, stuck=True),
    Event(f"stuck, with --deadline {DEADLINE_S}", None, ("fluid", "structure"), DEADLINE_S + 8, stuck=True),
    Event(f"stuck, after two deadlines of {DEADLINE_S} s", None, ("coupler",), 2 * DEADLINE_S + 8, stuck=True),
)


def process_of(role, out):
    """The process id of tern-ROLE of this run; None when it is not there."""
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if str(out) in words and Path(words[0]).name == f"tern-{role}":
            return int(entry.name)
    return None


def is_under_way(out, whom):
    """Whether 20 windows are done; where a process is to get stuck (`whom`), whether it is."""
    if whom:
        found = process_of(whom, out)
        return found is not None and Path(f"/proc/{found}/comm").read_text() == "stuck\n"
    steps = out / "steps.csv"
    return steps.exists() and steps.read_text().count("\n") > 20


def seconds_to_the_end(event, whom, out):
    """Runs a scene, signals once it is under way; the time from then to the end of ./tern."""
    words, environment = ["--quiet"], dict(os.environ)
    if event.stuck:
        words += ["--deadline", str(DEADLINE_S)]
        environment |= {"LD_PRELOAD": str(BUILD / "tests" / "libfault_injection.so"), "TERN_FAULT_PROCESS": f"tern-{whom}",
                        "TERN_FAULT_AT": STUCK_AT[whom], "TERN_FAULT_DO": "stuck"}
    run = subprocess.Popen([ROOT / "tern", "run", CASES / ("splash_plate" if event.stuck else "small_plate"), "--out", out, *words],
                           env=environment, stderr=subprocess.DEVNULL, start_new_session=True)
    while run.poll() is None and not is_under_way(out, whom if event.stuck else None):
        time.sleep(0.02)
    began = time.monotonic()
    if event.signal is not None:
        os.kill(run.pid if event.stuck or whom == "launcher" else process_of(whom, out), event.signal)
    run.wait()
    return time.monotonic() - began


def main():
    if not (BUILD / "tests" / "libfault_injection.so").exists():
        sys.exit(f"{BUILD}/tests/libfault_injection.so is missing: ninja fault_injection makes it")
    load = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(load)]
    late = False
    try:
        print(f"| event, with {load} busy processes on {os.cpu_count()} cores | to whom: time to the end [s] | documented [s] |")
        print("|---|---|---|")
        for event in EVENTS:
            cells = []
            for whom in event.victims:
                with tempfile.TemporaryDirectory(prefix="tern-noticing-") as directory:
                    taken = seconds_to_the_end(event, whom, Path(directory) / "run")
                late = late or taken > event.documented_s
                cells.append(f"{whom} {taken:.1f}")
            print(f"| {event.name} | {', '.join(cells)} | {event.documented_s} |", flush=True)
    finally:
        for process in busy:
            process.kill()
            process.wait()
    sys.exit(3 if late else 0)


main()
