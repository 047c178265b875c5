"""How the displacement of P converges: one thing at a time changed from the case as it stands.

    ./tern python cases/dam_break_plate/convergence.py                 to 0.40 s, all rows but the finest fluid
    ./tern python cases/dam_break_plate/convergence.py --finest        with the fluid at 2 mm

Prints a table of P, its largest distance from the row it should converge to, and the CPU time. Runs go to
runs/convergence/NAME; a run that has already come as far is used again.
"""

import argparse
from pathlib import Path

import numpy as np

from tern.results.summary import measure
from tern.studies.reuse import at, run_or_reuse

ROOT = Path(__file__).resolve().parent.parent.parent
CASE = ROOT / "cases" / "dam_break_plate"
TIMES = (0.26, 0.28, 0.30, 0.35, 0.40)
# Name, what is changed, its settings, and the row that it should approach (of the same family, the finest).
CASE_ITSELF = "case"
ROWS = (
    (CASE_ITSELF, "fluid 4 mm, plate 1 mm, one pass, as all but the last two", (), "repeated"),
    ("fluid_8", "fluid 8 mm", ("fluid.spacing=0.008",), "fluid_2"),
    ("fluid_2", "fluid 2 mm", ("fluid.spacing=0.002",), "fluid_2"),
    ("plate_133", "plate 1.33 mm (three across)", ("structure.body.plate.spacing=0.00133333333",), "plate_05"),
    ("plate_05", "plate 0.5 mm (eight across)", ("structure.body.plate.spacing=0.0005",), "plate_05"),
    ("window_15", "windows half as long again", ("fluid.numerics.courant=0.45", "fluid.numerics.gravity_courant=0.15"), "window_05"),
    ("window_05", "windows half as long", ("fluid.numerics.courant=0.15", "fluid.numerics.gravity_courant=0.05"), "window_05"),
    ("tolerance_4", "pressure solved to 1e-4", ("fluid.numerics.pressure_tolerance=1e-4",), "tolerance_8"),
    ("tolerance_8", "pressure solved to 1e-8", ("fluid.numerics.pressure_tolerance=1e-8",), "tolerance_8"),
    ("explicit", "plate by explicit sub-steps", ("structure.numerics.integrator=explicit",), "case"),
    ("repeated_loose", "repeated to 1e-2", ("coupling.tolerance=1e-2",), "repeated"),
    ("repeated", "repeated to 1e-4: both sides agree", ("coupling.tolerance=1e-4",), "repeated"),
)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--until", type=float, default=0.40, help="end of the runs [s] (default 0.40)")
    parser.add_argument("--finest", action="store_true", help="also the fluid at 2 mm, half of the time of all other rows together")
    parser.add_argument("--out", type=Path, default=ROOT / "runs" / "convergence", help="directory of the runs")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = [row for row in ROWS if arguments.finest or row[0] != "fluid_2"]
    one_pass = ("coupling.max_iterations=1",)
    runs = {name: run_or_reuse(what, CASE, arguments.out / name, arguments.until,
                               settings if any("coupling" in setting for setting in settings) else one_pass + settings)
            for name, what, settings, _ in rows}
    tables = {name: run.gauges for name, run in runs.items()}
    times = [time for time in TIMES if time <= arguments.until + 1e-9]
    print("| u_x(P) [m] at | " + " | ".join(f"{time:.2f}" for time in times)
          + " | largest distance [mm] | from | steps | trials | CPU [s] |\n" + "|---" * (len(times) + 6) + "|")
    for name, what, _, finest in rows:
        distance, towards = "", ""
        if finest in tables and finest != name:
            t = np.arange(0.2, arguments.until, 0.001)
            apart = [abs(at(tables[name], "P.ux_m", s) - at(tables[finest], "P.ux_m", s)) for s in t]
            distance, towards = f"{1e3 * max(apart):.2f}", next(row[1] for row in rows if row[0] == finest).split(":")[0]
        contents = runs[name].contents
        trials = measure(contents, "coupling_iterations_mean")
        print(f"| {what} | " + " | ".join(f"{at(tables[name], 'P.ux_m', time):.4f}" for time in times)
              + f" | {distance} | {towards} | {contents['steps']} | {'' if trials is None else f'{trials:.1f}'} "
              + f"| {contents['cpu_s']:.0f} |")


if __name__ == "__main__":
    main()
