#!/usr/bin/python3 -B
"""What a wet window of the dam break on the plate is made of, and what coupler and messages take of it. Table of docs/SPEED.md:

    TERN_BUILD=build/release bench/coupled_window.py [--repeats N] [--set KEY=VALUE]...

Runs cases/dam_break_plate (5000 particles; the water is at the plate from 0.24 s on). Each process reports what it has done so far
every 2 s; what it has done between its first report after --from and --until, over its windows in between, is printed: least and
median of the repeats, each row for itself. `messages` is timing_s.exchange of the three processes together: it contains what a process
that has something to do waits for a core, but not what ZeroMQ's threads and waking up take. That is in `fluid idle`, which bounds all
that the fluid does not do itself, the structure's trial included. CPU time is that of all threads of a process.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ROLES = ("coupler", "fluid", "structure")


def reports_from_then_on(out, begin, run):
    """The first report of each role after the time `begin`, while `run` goes on."""
    found = {}
    while len(found) < len(ROLES) and run.poll() is None:
        for role in ROLES:
            path = Path(out) / f"report.{role}.json"
            if role not in found and path.exists() and (report := json.loads(path.read_text()))["time_s"] > begin:
                found[role] = report
        time.sleep(0.05)
    return found


def window(out, words):
    """(windows, name -> milliseconds per window) of one run."""
    options = [part for key in words.set for part in ("--set", key)]
    with subprocess.Popen([ROOT / "tern", "run", ROOT / "cases" / "dam_break_plate", "--out", out, "--force", "--quiet",
                           "--until", words.until, *options], stdout=subprocess.DEVNULL) as run:
        before = reports_from_then_on(out, float(words.begin), run)
    if run.returncode != 0 or len(before) < len(ROLES):
        sys.exit(f"The run ended (exit code {run.returncode}) before all three had reported from after {words.begin} s: --until later.")
    after = json.loads((Path(out) / "run.json").read_text())["processes"]
    windows = {role: after[role]["steps"] - before[role]["steps"] for role in ROLES}
    wet = after["coupler"]["counts"]["wet_windows"] - before["coupler"]["counts"]["wet_windows"]
    if wet < windows["coupler"]:
        sys.exit(f"Only {wet} of {windows['coupler']} windows are wet: begin later (--from).")

    def per_window(role, get):
        return 1e3 * (get(after[role]) - get(before[role])) / windows[role]

    def timed(role, name):
        return per_window(role, lambda report: report["timing_s"][name])

    cpu = {role: per_window(role, lambda report: report["cpu_s"]) for role in ROLES}
    messages = sum(timed(role, "exchange") for role in ROLES)
    return windows["coupler"], {
        "window": per_window("coupler", lambda report: report["wall_s"]),
        "fluid computes": timed("fluid", "compute"),
        "structure computes": timed("structure", "compute"),
        "prediction": timed("structure", "compute.trial"),
        "coupler computes": timed("coupler", "compute"),
        "messages": messages,
        "coupler and messages": timed("coupler", "compute") + messages,
        "fluid idle": timed("fluid", "wait") + timed("fluid", "exchange"),
        "CPU of the coupler": cpu["coupler"],
        "CPU of the structure": cpu["structure"],
        "CPU of all three": sum(cpu.values())}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--from", dest="begin", default="0.25")
    parser.add_argument("--until", default="0.4")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--set", action="append", default=[])
    words = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tern-bench-") as directory:
        runs = [window(os.path.join(directory, "run"), words) for _ in range(words.repeats)]
    print(f"{words.repeats} runs, {', '.join(str(windows) for windows, _ in runs)} windows\n")
    print("| per window | least [ms] | median [ms] | of the window |\n|---|---|---|---|")
    rows = [row for _, row in runs]
    for name in rows[0]:
        share = statistics.median(row[name] / row["window"] for row in rows)
        least, middle = min(row[name] for row in rows), statistics.median(row[name] for row in rows)
        print(f"| {name} | {least:.3f} | {middle:.3f} | {100 * share:.1f} % |")


if __name__ == "__main__":
    main()
