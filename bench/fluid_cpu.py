#!/usr/bin/python3
"""CPU time of the fluid per particle and step, by builds in turn: a table for docs/SPEED.md.

    bench/fluid_cpu.py                                     the executables of build/release
    bench/fluid_cpu.py BUILD...                            directories with a tern-fluid each, one run of each after the other
    bench/fluid_cpu.py --scenes "3D, 21k" --repeats 3

CPU time is user and system time of the process, also beside other work; a shared cache and a shared core still raise it. So each figure is
the least of the repeats, and builds take turns. What a run takes to start and to write is left out by a second, shorter run.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# Case, end of the short and of the long run, further options.
SCENES = {
    "2D, 3.2k": ("dam_break_front", 0.05, 0.25, ()),
    "2D, 80k": ("dam_break_front", 0.002, 0.02, ("--set", "fluid.spacing=0.00073")),
    "3D, 21k": ("dam_break_3d", 0.02, 0.12, ()),
    "3D, 128k": ("dam_break_3d", 0.005, 0.03, ("--set", "fluid.spacing=0.005")),
}


def spent(build, case, until, options, out):
    """CPU seconds, steps and particles of one run."""
    command = [Path(build) / "tern-fluid", ROOT / "cases" / case / "case.toml", "--out", out, "--force", "--quiet", "--threads", "1",
               "--until", str(until), *options]
    subprocess.run(command, check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env={**os.environ, "OMP_NUM_THREADS": "1"})
    report = json.loads((Path(out) / "report.fluid.json").read_text(encoding="utf-8"))
    return report["cpu_s"], report["steps"], report["counts"]["particles"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("builds", nargs="*", default=[ROOT / "build/release"], metavar="BUILD")
    parser.add_argument("--scenes", nargs="*", default=list(SCENES), choices=list(SCENES), metavar="SCENE")
    parser.add_argument("--repeats", type=int, default=3, metavar="N")
    chosen = parser.parse_args()
    print("| scene | particles | steps | " + " | ".join(f"{Path(build).name} [us]" for build in chosen.builds) + " |")
    print("|---|---|---|" + "---|" * len(chosen.builds))
    with tempfile.TemporaryDirectory() as out:
        for scene in chosen.scenes:
            case, short, end, options = SCENES[scene]
            least = {}
            for _ in range(chosen.repeats):
                for build in chosen.builds:
                    for until in (short, end):
                        cpu, steps, particles = spent(build, case, until, options, out)
                        least[build, until] = min(least.get((build, until), (1e300,)), (cpu, steps, particles))
            cells = []
            for build in chosen.builds:
                (cpu, steps, particles), (cpu_short, steps_short, _) = least[build, end], least[build, short]
                cells.append(f"{(cpu - cpu_short) / ((steps - steps_short) * particles) * 1e6:.2f}")
            print(f"| {scene} | {particles} | {steps - steps_short} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
