#!/usr/bin/python3 -B
"""What a fluid in many processes is expected to cost, by the model of python/tern/scale_model.py. Tables of docs/SCALE.md:

    PYTHONPATH=python bench/scale_model.py [--particles N ...] [--latency S] [--bandwidth B] [--imbalance X]
    bench/scale_model.py --count RANKS        counts of messages, bytes, collectives and iterations, from runs on this machine

Counts and CPU times are measured on this machine. The cluster is assumed: nothing of it has been measured.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from tern import scale_model

ROOT = Path(__file__).resolve().parent.parent
CASES = {"dam_break_front": "0.02", "dam_break_3d": "0.02", "dam_break_plate_3d": "0.02", "submerged_block_3d": "0.05"}
COUNTS = ("particle_exchanges", "node_exchanges", "other_exchanges", "messages", "message_bytes", "collectives", "collective_bytes")
RANKS = (1, 10, 100, 1000, 10000)


def counts(ranks):
    """Prints what a rank says in a window, in the mean of the ranks."""
    print(f"| case, {ranks} ranks | iterations | ghosts | " + " | ".join(name.replace("_", " ") for name in COUNTS) + " |")
    print("|---|---|---|" + "---|" * len(COUNTS))
    for case, until in CASES.items():
        with tempfile.TemporaryDirectory() as out:
            words = ["--ranks", str(ranks), "--oversubscribe", "--until", until, "--out", out, "--force", "--quiet"]
            subprocess.run([ROOT / "tern", "run", ROOT / "cases" / case, *words], check=True, stdout=subprocess.DEVNULL)
            measures = json.loads((Path(out) / "run.json").read_text(encoding="utf-8"))["processes"]["fluid"]["measures"]
        cells = [f"{measures['pressure_iterations_mean']:.1f}", f"{measures['ghost_share']:.2f}"]
        cells += [f"{measures[f'{name}_per_step']:.0f}" for name in COUNTS]
        print(f"| {case} | " + " | ".join(cells) + " |", flush=True)


def model(particles, cluster):
    print("| dimension | particles of a rank | " + " | ".join(f"{ranks} ranks" for ranks in RANKS) + " |")
    print("|---|---|" + "---|" * len(RANKS))
    for fluid in scale_model.MEASURED.values():
        for of_rank in particles:
            cells = [f"{100 * scale_model.efficiency(fluid, cluster, ranks, of_rank):.0f} %" for ranks in RANKS]
            print(f"| {fluid.dimension} | {of_rank} | " + " | ".join(cells) + " |")
    for fluid in scale_model.MEASURED.values():
        print(f"\n{fluid.dimension}D, {particles[0]} particles of a rank, milliseconds of a window:\n")
        print("| part | " + " | ".join(f"{ranks} ranks" for ranks in RANKS) + " |")
        print("|---|" + "---|" * len(RANKS))
        of_ranks = [scale_model.costs(fluid, cluster, ranks, particles[0]) for ranks in RANKS]
        for part in scale_model.PARTS:
            print(f"| {part} | " + " | ".join(f"{1e3 * costs[part]:.2f}" for costs in of_ranks) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, metavar="RANKS")
    parser.add_argument("--particles", type=int, nargs="*", default=[50000, 200000, 10000], metavar="N", help="of a rank")
    parser.add_argument("--latency", type=float, metavar="S")
    parser.add_argument("--bandwidth", type=float, metavar="B", help="bytes per second of a machine")
    parser.add_argument("--imbalance", type=float, metavar="X", help="most over mean, less 1")
    chosen = parser.parse_args()
    if chosen.count:
        return counts(chosen.count)
    given = {"latency_s": chosen.latency, "machine_bytes_per_s": chosen.bandwidth, "imbalance": chosen.imbalance}
    model(chosen.particles, replace(scale_model.Cluster(), **{key: value for key, value in given.items() if value is not None}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
