#!/usr/bin/python3 -B
"""What a wet window of the dam break on the plate is made of, and what coupler and messages take of it. Table of docs/SPEED.md:

    TERN_BUILD=build/release bench/coupled_window.py [--repeats N] [--set KEY=VALUE]...

Two runs of cases/dam_break_plate (5000 particles; the water is at the plate from 0.24 s on), to --from and to --until: the difference
of their run.json is what the windows between the two cost, without start and end.
The repeat with the shortest windows is printed, and the median of all. `messages` is timing_s.exchange of the three processes: it
contains what a process that has something to do waits for a core. What the messages take in ZeroMQ's threads and what waking up takes
is in none of the three: `fluid idle`, in which it is, bounds all that the fluid does not do itself, the structure's trial included.
CPU time is that of all threads of a process; the trial gets the share of the structure's that it has of what the structure computes.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ROLES = ("coupler", "fluid", "structure")


def totals(directory, until, options):
    """(windows, wet ones among them, (CPU [s], timing_s) by role) of a run to `until`."""
    out = Path(directory) / "run"
    subprocess.run([ROOT / "tern", "run", ROOT / "cases" / "dam_break_plate", "--out", out, "--force", "--quiet", "--until", until,
                    *options], check=True, stdout=subprocess.DEVNULL)
    report = json.loads((out / "run.json").read_text())
    counts = report["processes"]["coupler"]["counts"]
    return report["steps"], counts["wet_windows"], {role: (report["processes"][role]["cpu_s"], report["processes"][role]["timing_s"]) for role in ROLES}


def window(directory, words, options):
    """Milliseconds per window between the two ends: name -> value."""
    few, few_wet, before = totals(directory, words.begin, options)
    many, many_wet, after = totals(directory, words.until, options)
    if many - few != many_wet - few_wet:
        sys.exit(f"Only {many_wet - few_wet} of the {many - few} windows are wet: begin later (--from).")

    def per_window(get):
        return {role: 1e3 * (get(after[role]) - get(before[role])) / (many - few) for role in ROLES}

    cpu = per_window(lambda entry: entry[0])
    compute, exchange, wait, output = (per_window(lambda entry, name=name: entry[1][name])
                                       for name in ("compute", "exchange", "wait", "output"))
    trial = 1e3 * (after["structure"][1]["compute.trial"] - before["structure"][1]["compute.trial"]) / (many - few)
    trial_cpu = cpu["structure"] * trial / compute["structure"]
    whole = compute["fluid"] + exchange["fluid"] + wait["fluid"] + output["fluid"]
    return {"window": whole, "fluid computes": compute["fluid"], "structure computes": compute["structure"], "trial of CM2": trial,
            "coupler computes": compute["coupler"], "messages": sum(exchange.values()),
            "coupler and messages": compute["coupler"] + sum(exchange.values()),
            "fluid idle": whole - compute["fluid"] - output["fluid"],
            "CPU of the coupler": cpu["coupler"], "CPU of the trial": trial_cpu, "CPU of all three": sum(cpu.values()), "windows": many - few}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--from", dest="begin", default="0.3")
    parser.add_argument("--until", default="0.4")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--set", action="append", default=[])
    words = parser.parse_args()
    options = [part for key in words.set for part in ("--set", key)]
    with tempfile.TemporaryDirectory(prefix="tern-bench-") as directory:
        rows = [window(directory, words, options) for _ in range(words.repeats)]
    best = min(rows, key=lambda row: row["window"])
    print(f"{best['windows']} windows, {words.repeats} times\n")
    print("| per window | shortest [ms] | of it | median [ms] | of it |\n|---|---|---|---|---|")
    for name in best:
        if name == "windows":
            continue
        middle = statistics.median(row[name] for row in rows)
        share = statistics.median(row[name] / row["window"] for row in rows)
        print(f"| {name} | {best[name]:.3f} | {100 * best[name] / best['window']:.1f} % | {middle:.3f} | {100 * share:.1f} % |")


if __name__ == "__main__":
    main()
