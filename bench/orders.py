#!/usr/bin/python3 -B
"""How results depend on the length of the windows: six scenes at three lengths each, and the order that they show.

    TERN_BUILD=build/release PYTHONPATH=python bench/orders.py                          some ten minutes
    TERN_BUILD=build/release PYTHONPATH=python bench/orders.py piston ring_in_annulus   some of them

Prints a Markdown table. The lengths are the default, a half and a quarter of it. The spacing stays: the results do not tend to the
reference, but to what the spacing makes of it. The order is log2 of the ratio of the two changes; it is missing where the second change is
not smaller than the first, or has the other sign, so that something else decides. The last column is the second change: what
windows of half the length still change, over the reference.
"""

import argparse
import math
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import tern
from tern.verify import bands, expected

ROOT = Path(__file__).resolve().parents[1]
COURANT, GRAVITY_COURANT = 0.4, 0.1  # the defaults

# A drop of radius 0.5 m that a central force swings between two ellipses, without viscosity: for small swings sqrt(2) rad/s.
DROP = """
title = "Oscillating drop"
dimension = 2
end_time = 13.5
gravity = ["-x", "-y"]

[fluid]
density = 1000
spacing = 0.02

[[fluid.body]]
shape = { ball = { center = [0, 0], radius = 0.5 } }
velocity = ["0.4*x", "-0.4*y"]
"""


@dataclass
class Scene:
    case: str
    quantity: str | dict  # name in the case's expected.toml, or a quantity as there
    courant: float = COURANT
    settings: dict = field(default_factory=dict)
    until: float | None = None


SCENES = [
    Scene("standing_wave", "largest kinetic energy in the fifth period"),
    Scene("taylor_green", {"name": "kinetic energy after 1 s, without viscosity", "kind": "value", "file": "energy.csv",
                           "column": "fluid_kinetic_J", "at": 1.0, "unit": "J/m", "reference": 250.0},
          settings={"fluid.viscosity": 1e-9}, until=1.0),
    Scene("oscillating_drop", {"name": "largest kinetic energy in the third period", "kind": "maximum", "file": "energy.csv",
                               "column": "fluid_kinetic_J", "from": 8.0, "to": 13.5, "unit": "J/m", "reference": 7.854}),
    Scene("piston", "frequency of the piston"),
    Scene("hydrostatic_plate", "frequency of the wet plate"),
    Scene("ring_in_annulus", "frequency in the fluid", courant=0.063),  # the speed of the fluid then limits windows to 0.1 s
]


def measured(scene, share, directory):
    """(windows, value, unit, name, reference) of one run."""
    case = scene.case
    if case == "oscillating_drop":
        case = Path(directory) / "oscillating_drop"
        case.mkdir(exist_ok=True)
        (case / "case.toml").write_text(DROP, encoding="utf-8")
    settings = scene.settings | {"fluid.numerics.courant": share * scene.courant, "fluid.numerics.gravity_courant": share * GRAVITY_COURANT}
    run = tern.run(case, settings, out=Path(directory) / f"{scene.case}-{share}", until=scene.until)
    quantity = scene.quantity
    if isinstance(quantity, str):
        all_of_case = expected.read(ROOT / "cases" / scene.case / "expected.toml")
        quantity = next(one for one in all_of_case if one["name"] == quantity)
    value = bands.evaluate(run.directory, quantity)
    return run.contents["steps"], value, quantity["unit"], quantity["name"], quantity["reference"]


def order(coarse, half, quarter):
    """By Richardson; None where the changes show none."""
    first, second = coarse - half, half - quarter
    return math.log2(first / second) if second and first / second > 1 else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="*", help=", ".join(scene.case for scene in SCENES))
    wanted = parser.parse_args().scene
    if unknown := set(wanted) - {scene.case for scene in SCENES}:
        sys.exit(f"There is no scene {', '.join(sorted(unknown))}; there are {', '.join(scene.case for scene in SCENES)}.")
    print("| scene | quantity | reference | default | half | quarter | windows | order | second change |\n" + "|---" * 9 + "|", flush=True)
    with tempfile.TemporaryDirectory(prefix="tern-orders-") as directory:
        for scene in SCENES:
            if wanted and scene.case not in wanted:
                continue
            runs = [measured(scene, share, directory) for share in (1, 0.5, 0.25)]
            values = [run[1] for run in runs]
            _, _, unit, name, reference = runs[0]
            found = order(*values)
            print(f"| {scene.case} | {name} [{unit}] | {reference:g} | " + " | ".join(f"{value:.5g}" for value in values)
                  + f" | {', '.join(str(run[0]) for run in runs)} | {'' if found is None else f'{found:.1f}'} "
                  + f"| {(values[1] - values[2]) / reference:+.2%} |", flush=True)


if __name__ == "__main__":
    main()
