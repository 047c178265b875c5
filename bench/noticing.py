#!/usr/bin/python3 -B
"""How long after an event the whole run has ended, on a machine with other work to do.

    TERN_BUILD=build/release bench/noticing.py            while 8 processes compute beside it
    TERN_BUILD=build/release bench/noticing.py 0          on a machine that is otherwise idle

The event happens to one process of the small scene of the process tests, or to the launcher. Prints a Markdown table with the times from
the event to the end of the launcher [s], three of each; ends with exit code 3 when one is longer than documented.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CASE = ROOT / "tests" / "process" / "cases" / "small_plate"
# Event: signal, to whom, seconds documented in ROBUSTNESS.md and README.md.
EVENTS = {
    "killed (SIGKILL)": (signal.SIGKILL, ("fluid", "structure", "coupler"), 1),
    "terminated (SIGTERM)": (signal.SIGTERM, ("fluid", "structure", "coupler"), 2),
    "frozen (SIGSTOP)": (signal.SIGSTOP, ("fluid", "structure", "coupler"), 10),
    "Ctrl-C": (signal.SIGINT, ("launcher",) * 3, 2),
}


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


def seconds_to_the_end(number, whom, out):
    """Runs the scene, signals once it is under way; the time from then to the end of ./tern."""
    run = subprocess.Popen([ROOT / "tern", "run", CASE, "--out", out, "--quiet"], stderr=subprocess.DEVNULL, start_new_session=True)
    steps = out / "steps.csv"
    while run.poll() is None and not (steps.exists() and steps.read_text().count("\n") > 20):
        time.sleep(0.02)
    victim = run.pid if whom == "launcher" else process_of(whom, out)
    began = time.monotonic()
    os.kill(victim, number)
    run.wait()
    return time.monotonic() - began


def main():
    load = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(load)]
    late = False
    try:
        print(f"| event, with {load} busy processes on {os.cpu_count()} cores | to whom: time to the end [s] | documented [s] |")
        print("|---|---|---|")
        for event, (number, victims, documented) in EVENTS.items():
            cells = []
            for whom in victims:
                with tempfile.TemporaryDirectory(prefix="tern-noticing-") as directory:
                    taken = seconds_to_the_end(number, whom, Path(directory) / "run")
                late = late or taken > documented
                cells.append(f"{whom} {taken:.1f}")
            print(f"| {event} | {', '.join(cells)} | {documented} |", flush=True)
    finally:
        for process in busy:
            process.kill()
            process.wait()
    sys.exit(3 if late else 0)


main()
