#!/usr/bin/python3
"""Do two versions of tern compute the same bits? One line per scene: a digest of everything that its run has computed.

    bench/digests.py > before.txt          with the one version
    bench/digests.py > after.txt           with the other
    diff before.txt after.txt              nothing: the same bits

TERN_BUILD=DIRECTORY takes executables built elsewhere. The digest covers the tables (but for the wall time of a step) and every
dataset of every frame. Each scene runs for a few dozen windows only; on 2 cores all of them take about three minutes. Digests of different
machines differ where their libraries do.
"""

import argparse
import csv
import hashlib
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy

ROOT = Path(__file__).resolve().parent.parent
PLATE = ("--until", "0.25", "--set", "fluid.spacing=0.008", "--set", "structure.body.plate.spacing=0.002")
SPLASH = ROOT / "tests/process/cases/splash_plate"
SMALL = ROOT / "tests/process/cases/small_plate"

# Name of the digest: case and options.
SCENES = {
    "bending_column_2d": ("bending_column_2d", "--until", "0.1"),
    "bending_column_3d": ("bending_column_3d", "--until", "0.02"),
    "conformance": ("conformance", "--until", "0.05"),
    "dam_break_3d": ("dam_break_3d", "--until", "0.02"),
    "dam_break_front": ("dam_break_front", "--until", "0.1"),
    "dam_break_long": ("dam_break_long", "--until", "0.15"),
    "dam_break_plate": ("dam_break_plate", "--until", "0.06"),
    "dam_break_plate coarse": ("dam_break_plate", *PLATE),
    "dam_break_plate shell": ("dam_break_plate", *PLATE[:4], "--set", "structure.body.plate.model=shell", "--set",
                              "structure.body.plate.spacing=0.005"),
    "dam_break_plate_gate": ("dam_break_plate_gate", "--until", "0.06"),
    "dam_break_pressure": ("dam_break_pressure", "--until", "0.1"),
    "drop_on_pool": ("drop_on_pool", "--until", "0.03"),
    "dry_plate": ("dry_plate", "--until", "0.1"),
    "floating_block": ("floating_block", "--until", "0.05"),
    "gray_cantilever": ("gray_cantilever", "--until", "0.05"),
    "hydrostatic_plate": ("hydrostatic_plate", "--until", "0.01"),
    "hydrostatic_tank": ("hydrostatic_tank", "--until", "0.3"),
    "hydrostatic_tank_3d": ("hydrostatic_tank_3d", "--until", "0.05"),
    "piston": ("piston", "--until", "0.005"),
    "rising_ball_3d": ("rising_ball_3d", "--until", "0.005"),
    "rising_disc": ("rising_disc", "--until", "0.01"),
    "rotating_square_patch": ("rotating_square_patch", "--until", "0.1"),
    "sloshing": ("sloshing", "--until", "0.2"),
    "standing_wave": ("standing_wave", "--until", "0.1"),
    "submerged_block": ("submerged_block", "--until", "0.05"),
    "submerged_block_3d": ("submerged_block_3d", "--until", "0.03"),
    "submerged_plate_modes": ("submerged_plate_modes", "--until", "0.002"),
    "taylor_green": ("taylor_green", "--until", "0.1"),
    "tensile_bar": ("tensile_bar", "--until", "0.002"),
    "turek_hron_csm1": ("turek_hron_csm1", "--until", "0.05"),
    "turek_hron_csm3": ("turek_hron_csm3", "--until", "0.05"),
    "plate, explicit": ("dam_break_plate", *PLATE, "--set", "coupling.algorithm=explicit", "--allow-unstable", "--until", "0.2"),
    "plate, repeated": ("dam_break_plate", *PLATE, "--set", "coupling.tolerance=1e-4"),
    "plate, fsa": ("dam_break_plate", *PLATE, "--set", "coupling.scheme=fsa"),
    "plate, pressure integration": ("dam_break_plate", *PLATE, "--set", "coupling.scheme=pi"),
    "plate, vem sum": ("dam_break_plate", *PLATE, "--set", "coupling.vem.form=sum"),
    "plate, vem seed": ("dam_break_plate", *PLATE, "--set", "coupling.vem.form=seed"),
    "plate, gradient sum": ("dam_break_plate", *PLATE, "--set", "fluid.numerics.gradient=sum"),
    "plate, viscous": ("dam_break_plate", *PLATE, "--set", "fluid.viscosity=0.01"),
    "plate, explicit structure": ("dam_break_plate", *PLATE, "--set", "structure.numerics.integrator=explicit"),
    "plate, implicit structure": ("dam_break_plate", *PLATE, "--set", "structure.numerics.integrator=implicit"),
    "plate, St Venant-Kirchhoff": ("dam_break_plate", *PLATE, "--set", "structure.body.plate.material=st_venant_kirchhoff"),
    "plate, two threads": ("dam_break_plate", *PLATE, "--threads", "2"),
    "plate, draft": ("dam_break_plate", "--preset", "draft", "--until", "0.27"),
    "dam_break_3d, two threads": ("dam_break_3d", "--until", "0.02", "--threads", "2"),
    "splash_plate": (SPLASH,),
    "splash_plate, explicit": (SPLASH, "--set", "structure.numerics.integrator=explicit"),
    "small_plate": (SMALL, "--until", "0.3"),
    "sealed, bodies": (ROOT / "bench/digests/sealed",),
    "moving walls, bodies": (ROOT / "bench/digests/moving",),
    "sealed box, cube": (ROOT / "bench/digests/cube",),
}


def parts_of(run, without):
    """What of a run's directory is compared, as (name, bytes), always in the same order; `without`: begin of datasets left out."""
    for name in ("gauges.csv", "energy.csv", "steps.csv"):
        path = run / name
        if not path.exists():
            continue
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        kept = [k for k, column in enumerate(rows[0]) if column != "wall_ms"]
        yield name, repr([[row[k] for k in kept] for row in rows]).encode()
    for name in ("fluid.h5", "structure.h5"):
        path = run / name
        if not path.exists():
            continue
        with h5py.File(path, "r") as file:
            datasets = []
            file.visititems(lambda place, item: datasets.append(place) if isinstance(item, h5py.Dataset) else None)
            for place in sorted(datasets):
                if without and place.split("/")[-1].startswith(without):
                    continue
                values = numpy.asarray(file[place])
                yield f"{name}/{place}", str((values.dtype, values.shape)).encode() + values.tobytes()


def digest(scene, keep, without):
    """Runs a scene. One digest of all its parts; what went wrong instead where it ends early (which may be meant)."""
    case, *options = SCENES[scene]
    run = Path(keep) / scene.replace(" ", "_").replace(",", "")
    done = subprocess.run([ROOT / "tern", "run", str(case), *options, "--out", run, "--quiet", "--force"], cwd=ROOT,
                          stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if not (run / "steps.csv").exists():
        return f"did not run (exit {done.returncode}): {done.stderr.strip().splitlines()[-1:]}"
    whole = hashlib.sha256()
    for name, content in parts_of(run, without):
        whole.update(name.encode() + b"\0" + content)
    windows = len((run / "steps.csv").read_text(encoding="utf-8").splitlines()) - 1
    return f"{whole.hexdigest()[:24]}  exit {done.returncode}, {windows} windows"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="beginning of a scene's name (default: all)")
    parser.add_argument("--keep", metavar="DIR", help="leave the runs there")
    parser.add_argument("--without", metavar="NAME", help="leave out datasets of frames whose name begins like that, as \"stress\"")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="scenes at a time (default 2)")
    chosen = parser.parse_args()
    names = [name for name in SCENES if not chosen.scenes or any(name.startswith(wanted) for wanted in chosen.scenes)]
    if not names:
        parser.error(f"no scene begins like that; there are: {'; '.join(SCENES)}")
    with tempfile.TemporaryDirectory() as scratch, ThreadPoolExecutor(chosen.jobs) as pool:
        for name, line in zip(names, pool.map(lambda name: digest(name, chosen.keep or scratch, chosen.without), names)):
            print(f"{name:32} {line}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
