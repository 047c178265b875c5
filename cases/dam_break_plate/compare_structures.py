"""The plate by tern's particles and by GetFEM's finite elements, under the same fluid: two tables and a picture.

    ./tern python cases/dam_break_plate/compare_structures.py

The dam break to 0.5 s and two metres of water at rest (hydrostatic_plate). Runs go to runs/structures/NAME, the picture to
runs/structures/plates.png; a run that is there is used again.
"""

import argparse
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from tern import paths
from tern.plot import style
from tern.studies.reuse import at, run_or_reuse
from tern.verify import reducers

matplotlib.use("Agg")
ROOT = Path(__file__).resolve().parent.parent.parent
GETFEM = paths.solvers() / "getfem_structure.py"
FINITE_ELEMENTS = "GetFEM, 2 elements across"
PLATES = {  # label: (directory, particles across or None, command)
    "tern, 4 particles across": ("tern_4", 4, {}),
    "tern, 8 particles across": ("tern_8", 8, {}),
    FINITE_ELEMENTS: ("getfem_2", None, {"structure": str(GETFEM)}),
    "GetFEM, 4 elements across": ("getfem_4", None, {"structure": f"{GETFEM} --across 4"}),
}
TIMES = (0.26, 0.30, 0.35, 0.40, 0.45, 0.50)


def run(case, thickness, label, directory, until):
    name, across, commands = PLATES[label]
    settings = (f"structure.body.plate.spacing={thickness / across!r}",) if across else ()
    return run_or_reuse(label, ROOT / "cases" / case, directory / f"{case}_{name}", until, settings, commands)


def cpu(result):
    return result.contents["processes"]["structure"]["cpu_s"]


def dam_break(directory):
    """u_x(P), its first maximum, and how far it gets from that of the finite elements."""
    runs = {label: run("dam_break_plate", 0.004, label, directory, 0.5) for label in PLATES}
    tables = {label: result.gauges for label, result in runs.items()}
    reference = tables[FINITE_ELEMENTS]
    print("| u_x(P) [m] at | " + " | ".join(f"{time:.2f} s" for time in TIMES) + " | first maximum | largest distance to 2 elements "
          "| CPU of the structure |")
    print("|---" * (len(TIMES) + 4) + "|")
    for label, table in tables.items():
        t = reference["t_s"]
        distance = np.abs(np.interp(t, table["t_s"], table["P.ux_m"]) - reference["P.ux_m"]).max()
        print(f"| {label} | " + " | ".join(f"{at(table, 'P.ux_m', time):.4f}" for time in TIMES) + f" | {table['P.ux_m'].max():.4f} m "
              f"at {t_of_maximum(table):.3f} s | {1e3 * distance:.2f} mm | {cpu(runs[label]):.0f} s |")
    return tables


def t_of_maximum(table):
    return table["t_s"][np.argmax(table["P.ux_m"])]


def hydrostatic(directory):
    """Deflection at rest, frequency and load of the floor under two metres of water."""
    print("\n| two metres of water | deflection at rest | frequency | load of the water |")
    print("|---|---|---|---|")
    for label in ("tern, 4 particles across", "tern, 8 particles across", FINITE_ELEMENTS):
        result = run("hydrostatic_plate", 0.05, label, directory, 0.5)
        curves = result.directory / "gauges.csv"
        deflection, load = (reducers.reduce(curves, column, {"kind": "mean", "from": 0.25, "to": 0.5})
                            for column in ("middle.uy_m", "load.Fy_N_per_m"))
        frequency = reducers.reduce(curves, "middle.uy_m", {"kind": "frequency", "about": -7.06e-5, "from": 0.0, "to": 0.1})
        print(f"| {label} | {deflection:.3e} m | {frequency:.1f} Hz | {load:.0f} N/m |")


def picture(tables, path):
    figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
    for (label, table), colour in zip(tables.items(), style.RUN_COLOURS):
        axes.plot(table["t_s"], table["P.ux_m"], color=colour, label=label)
    axes.set_xlim(0.2, 0.5)
    axes.set_xlabel("t [s]")
    axes.set_ylabel("displacement x of P [m]")
    axes.legend()
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "runs" / "structures", help="directory of the runs")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    style.apply()
    tables = dam_break(arguments.out)
    hydrostatic(arguments.out)
    picture(tables, arguments.out / "plates.png")


if __name__ == "__main__":
    main()
