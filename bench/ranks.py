#!/usr/bin/python3 -B
"""Weak scaling of the fluid on this machine: as many particles for every rank, on more and more ranks. A table:

    bench/ranks.py [--ranks 1 2 4 8 16] [--particles 20000 50000] [--dimensions 3 2] [--repeats 3]

Wall time of a window, the least of the repeats, and the efficiency: that of one rank over it. Each rank has a core to itself: ./tern
refuses more ranks than cores, for what ranks cost that share one says nothing. Beside other work the figures say nothing either.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# What the water fills [m^D], and the end of a run over the spacing [s/m]: some 25 windows.
CASES = {2: ("dam_break_front", 0.146 * 0.292, 12.5), 3: ("dam_break_3d", 0.2 * 0.4 * 0.2, 5.5)}


def run(dimension, ranks, of_rank, out):
    """Particles, windows, seconds of a window and ghosts over particles."""
    case, size, until = CASES[dimension]
    spacing = (size / (ranks * of_rank)) ** (1 / dimension)
    words = ["--ranks", str(ranks), "--set", f"fluid.spacing={spacing:.9g}", "--until", f"{until * spacing:.9g}", "--out", out, "--force"]
    subprocess.run([ROOT / "tern", "run", ROOT / "cases" / case, *words, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    fluid = json.loads((Path(out) / "run.json").read_text(encoding="utf-8"))["processes"]["fluid"]
    particles = fluid["counts"]["particles"]
    return particles, fluid["steps"], fluid["timing_s"]["compute"] / fluid["steps"], fluid["measures"].get("ghost_share", 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ranks", type=int, nargs="*", default=[1, 2, 4, 8, 16], metavar="N")
    parser.add_argument("--particles", type=int, nargs="*", default=[20000, 50000], metavar="N", help="of a rank")
    parser.add_argument("--dimensions", type=int, nargs="*", default=[3, 2], choices=list(CASES))
    parser.add_argument("--repeats", type=int, default=3, metavar="N")
    chosen = parser.parse_args()
    print("| dimension | ranks | particles | windows | ghosts over particles | a window [ms] | efficiency |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as out:
        for dimension in chosen.dimensions:
            for of_rank in chosen.particles:
                of_one = None
                for ranks in chosen.ranks:
                    particles, windows, seconds, ghosts = min((run(dimension, ranks, of_rank, out) for _ in range(chosen.repeats)),
                                                              key=lambda of_run: of_run[2])
                    of_particle = seconds / (particles / ranks)  # lattices have not quite as many particles as were asked for
                    of_one = of_one or of_particle
                    numbers = f"{dimension} | {ranks} | {particles} | {windows} | {ghosts:.2f}"
                    print(f"| {numbers} | {1e3 * seconds:.1f} | {100 * of_one / of_particle:.0f} % |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
