"""The interface schemes on the dam break on the plate: runs them, prints a table, and from 0.8 s on draws the fields.

    ./tern python cases/dam_break_plate/compare_schemes.py                 to 0.45 s
    ./tern python cases/dam_break_plate/compare_schemes.py --until 0.82    with the picture of the published comparison at 0.80 s

Runs go to runs/schemes/NAME, the picture to runs/schemes/fields.png; a run that has already come as far is used again.
"""

import argparse
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from tern.plot import fields, style
from tern.results.summary import measure
from tern.results.tables import read_table
from tern.studies.reuse import at, run_or_reuse

matplotlib.use("Agg")
ROOT = Path(__file__).resolve().parent.parent.parent
CASE = ROOT / "cases" / "dam_break_plate"
SCHEMES = {  # label: (directory, scheme, with VEM, shown in the picture)
    "FSA": ("fsa", "fsa", False, True),
    "FSA + VEM": ("fsa_vem", "fsa", True, True),
    "Riemann + VEM": ("riemann_vem", "riemann", True, True),
    "PI": ("pi", "pi", False, False),
}
TIMES = (0.26, 0.30, 0.35, 0.40, 0.45, 0.50, 0.60, 0.70, 0.80)
PICTURE = 0.80
WINDOW = (0.60, 0.80)  # the fields are judged over the frames in between
GRAVITY, DENSITY, HEIGHT, WIDTH = 9.81, 997.0, 0.4, 0.2
FOOT = 0.04  # side of the squares before and behind the plate's foot [m]


def case_without_vem(directory):
    """A copy of the case whose [coupling.vem] is left out: a table that is there cannot be overridden away."""
    lines = (CASE / "case.toml").read_text(encoding="utf-8").splitlines(keepends=True)
    first = lines.index("[coupling.vem]\n")
    last = next(n for n in range(first + 1, len(lines)) if lines[n].startswith("["))
    folder = directory / "case_without_vem" / "dam_break_plate"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "case.toml").write_text("".join(lines[:first] + lines[last:]), encoding="utf-8")
    return folder


def run(label, directory, until, overrides):
    """The run of one scheme, done now unless it exists and reaches `until`."""
    name, scheme, vem, _ = SCHEMES[label]
    case = CASE if vem else case_without_vem(directory)
    return run_or_reuse(label, case, directory / name, until, (f"coupling.scheme={scheme}", "coupling.max_iterations=1", *overrides))


def sides(start):
    """Of every surface point, -1 on the face towards the dam, 1 on the other, 0 on the tip: from the undeformed plate."""
    x, y = start["surface_position"][:, 0], start["surface_position"][:, 1]
    return np.where(y > y.max() - 1e-6, 0, np.where(x < 0.5 * (x.min() + x.max()), -1, 1))


def roughness(fluid, structure, side, spacing):
    """Root mean square of what a linear fit over the fluid on the same side, within 2h, leaves of the pressure of the
    particles within 2h of the plate [Pa]."""
    reach = 3 * spacing
    x, surface = fluid["position"][:, :2], structure["surface_position"][:, :2]
    distance = np.linalg.norm(x[:, None, :] - surface[None, :, :], axis=2)
    nearest = distance.argmin(axis=1)
    depth = distance[np.arange(len(x)), nearest]
    own = side[nearest]
    left = []
    for i in np.flatnonzero((depth < reach) & (own != 0)):
        d = x - x[i]
        around = (np.linalg.norm(d, axis=1) < reach) & (own == own[i])
        if around.sum() < 6:
            continue
        basis = np.column_stack([np.ones(around.sum()), d[around]])
        fit = np.linalg.lstsq(basis, fluid["pressure"][around], rcond=None)[0]
        left.append(fluid["pressure"][i] - fit[0])
    return float(np.sqrt(np.mean(np.square(left)))) if left else float("nan")


def void(fluid, structure, spacing):
    """Area of the two squares at the plate's foot that is farther than one spacing from any particle [m^2/m of plate]."""
    step = 0.125 * spacing
    foot = structure["surface_position"][:, :2]
    foot = foot[foot[:, 1] < foot[:, 1].min() + 2 * spacing]
    low, high = foot[:, 0].min(), foot[:, 0].max()
    y = np.arange(0.5 * step, FOOT, step)
    x = np.concatenate([np.arange(low - FOOT + 0.5 * step, low, step), np.arange(high + 0.5 * step, high + FOOT, step)])
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    matter = np.concatenate([fluid["position"][:, :2], structure["position"][:, :2]])
    matter = matter[(np.abs(matter[:, 0] - 0.5 * (low + high)) < 2 * FOOT) & (matter[:, 1] < 2 * FOOT)]
    nearest = np.full(len(points), np.inf)
    for position in matter:
        np.minimum(nearest, np.linalg.norm(points - position, axis=1), out=nearest)
    return float((nearest > spacing).sum() * step * step)


def judge(label, result):
    """The numbers of one run."""
    gauges, energy = result.gauges, result.energies
    numbers = {f"P {time:.2f}": at(gauges, "P.ux_m", time) for time in TIMES}
    for name in ("momentum_audit_max", "volume_drift", "particles_leaked"):
        numbers[name] = measure(result.contents, name)
    end = {name: values[-1] for name, values in energy.items()}
    numbers["staggering"] = end["interface_staggering_J"]
    kept = [name for name in end if name.endswith(("kinetic_J", "potential_J", "strain_J", "dissipation_J", "diffusion_J"))]
    numbers["energy"] = sum(end[name] for name in kept) / (0.5 * DENSITY * GRAVITY * HEIGHT**2 * WIDTH)
    numbers["end"] = gauges["t_s"][-1]
    frames = [frame.time for frame in result.frames_of("fluid") if WINDOW[0] - 1e-6 <= frame.time <= WINDOW[1] + 1e-6]
    if frames:
        spacing, side = result.spacing("fluid"), sides(result.frames_of("structure")[0])
        both = [fields.read(result, time)[1:] for time in frames]
        rough = [roughness(fluid, plate, side, spacing) for fluid, plate in both]
        voids = [void(fluid, plate, spacing) for fluid, plate in both]
        numbers |= {"roughness": np.nanmean(rough), "void": np.mean(voids), "roughness end": rough[-1], "void end": voids[-1]}
    return numbers


def print_table(results, until):
    """Markdown, one row per scheme."""
    times = [time for time in TIMES if time <= until + 1e-9]
    print("| u_x(P) [m] at | " + " | ".join(f"{time:.2f}" for time in times) + " | momentum audit | volume drift | through a face "
          "| staggering [J/m] | energy |")
    print("|---" * (len(times) + 6) + "|")
    reference = read_table(CASE / "reference" / "sphinxsys_dp4mm_nogate_hp0.09.csv")
    print("| SPHinXsys (plate 4 mm further) | " + " | ".join(f"{at(reference, 'ux_P_m', time):.4f}" for time in times) + " | | | | | |")
    for label, numbers in results.items():
        row = [f"{numbers[f'P {time:.2f}']:.4f}" for time in times]
        row += [f"{numbers['momentum_audit_max']:.0e}", f"{100 * numbers['volume_drift']:+.3f} %", str(numbers["particles_leaked"]),
                f"{numbers['staggering']:+.2f}", f"{100 * numbers['energy']:+.1f} %"]
        print(f"| {label} | " + " | ".join(row) + " |")
    if not any("void" in numbers for numbers in results.values()):
        return
    print(f"\n| fields, {WINDOW[0]:.2f} to {WINDOW[1]:.2f} s (last frame) | pressure roughness / rho g H | void at the foot |")
    print("|---|---|---|")
    for label, numbers in results.items():
        if "void" in numbers:
            scale = DENSITY * GRAVITY * HEIGHT
            print(f"| {label} | {100 * numbers['roughness'] / scale:.2f} % ({100 * numbers['roughness end'] / scale:.2f} %) "
                  f"| {1e6 * numbers['void']:.0f} mm^2 ({1e6 * numbers['void end']:.0f} mm^2) |")


def picture(runs, directory):
    """Fields of the published comparison beside each other, and the histories of P below."""
    shown = {label: result for label, result in runs.items() if SCHEMES[label][3]}
    figure = plt.figure(figsize=(6.2 * len(shown), 9.5), layout="constrained")
    grid = figure.add_gridspec(2, len(shown), height_ratios=(1.6, 1))
    frames = {label: fields.read(result, PICTURE) for label, result in shown.items()}
    each = [fields.limits_of(fluid, plate) for _, fluid, plate in frames.values()]
    limits = tuple((min(one[side][0] for one in each), max(one[side][1] for one in each)) for side in (0, 1))
    axes = []
    for column, (label, (exact, fluid, plate)) in enumerate(frames.items()):
        axes.append(figure.add_subplot(grid[0, column]))
        drawn = fields.panel(axes[-1], shown[label], fluid, plate, limits)
        axes[-1].set_title(f"{label}, t = {exact:.2f} s", loc="left")
    fields.colour_bars(figure, axes, drawn, shrink=0.8, aspect=35)
    history = figure.add_subplot(grid[1, :])
    reference = read_table(CASE / "reference" / "sphinxsys_dp4mm_nogate_hp0.09.csv")
    end = max(result.gauges["t_s"][-1] for result in runs.values())
    shown_part = reference["t_s"] <= end
    history.plot(reference["t_s"][shown_part], reference["ux_P_m"][shown_part], label="SPHinXsys (another code)", **style.REFERENCE)
    for (label, result), colour in zip(runs.items(), style.RUN_COLOURS):
        table = result.gauges
        history.plot(table["t_s"], table["P.ux_m"], color=colour, label=label)
    history.set_xlim(0.2, end)
    history.set_xlabel("t [s]")
    history.set_ylabel("displacement x of P [m]")
    history.legend()
    path = directory / "fields.png"
    figure.savefig(path, bbox_inches="tight", dpi=110)
    plt.close(figure)
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--until", type=float, default=0.45, help="end of the runs [s] (default 0.45)")
    parser.add_argument("--out", type=Path, default=ROOT / "runs" / "schemes", help="directory of the runs")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="override a key of the case, in all runs")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    style.apply()
    runs = {label: run(label, arguments.out, arguments.until, arguments.set) for label in SCHEMES}
    print_table({label: judge(label, result) for label, result in runs.items()}, arguments.until)
    if arguments.until >= PICTURE:
        print(f"\n{picture(runs, arguments.out)}")


if __name__ == "__main__":
    main()
