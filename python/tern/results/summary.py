"""The table at the end of a run: where the time went and what was kept, from run.json."""

import math
import os
import shlex

from tern.errors import UnreadableRun
from tern.results.tables import read_columns

#: Part of the energy that went through the interface from which what it made is worth a word of advice.
WORTH_SAYING = 0.1
#: Part of the energy that the run has moved below which what the coupling made is nothing: of still water little goes through the interface
#: at all, and a part of that says nothing.
NEGLIGIBLE = 1e-3

#: The works of both sides at the interface, row by row: how much they go together, and the factor between them, before a foreign structure
#: is named. In right runs the factor is 0.8 to 1.3, or they do not go together (docs/PROTOCOL.md, 5.6).
TOGETHER, FACTOR, ROWS = 0.98, 1.5, 20

# What every run is asked about: measure, label, form.
CONSERVATION = (
    ("volume_drift", "volume drift of the fluid", "{:+.3%}"),
    ("momentum_audit_max", "momentum audit, largest relative sum of interface forces", "{:.1e}"),
    ("added_mass_ratio_predicted", "added-mass ratio, predicted", "{:.3g}"),
    ("particles_leaked", "particles through a face", "{:.0f}"),
    ("particles_removed", "particles that left the domain", "{:.0f}"),
)


def shown(path):
    """`path` as short as it can be typed from here."""
    relative = os.path.relpath(path)
    return str(path) if relative.startswith("..") else relative


def measure(contents, name):
    """A measure or count by name from whichever process reports it; None if nobody does."""
    for role in ("coupler", "fluid", "structure"):
        report = contents.get("processes", {}).get(role, {})
        for table in ("measures", "counts"):
            if report.get(table, {}).get(name) is not None:
                return report[table][name]
    return None


def warnings(contents, out):
    """What its results do not show by themselves, in sentences: fluid that has been lost, a foreign structure with a work of its own."""
    said = []
    if through := measure(contents, "particles_leaked") or 0:
        said.append(f"{through:.0f} particle{'s' * (through != 1)} of the fluid went through a face of a wall or body. What pushed them "
                    "there moves too fast for its steps, or jumps.")
    if removed := measure(contents, "particles_removed") or 0:
        left = measure(contents, "particles") or 0
        said.append(f"The fluid has lost {removed:.0f} of {removed + left:.0f} particles, and as much of its mass, at the edge of "
                    "[domain].")
    if (command := contents.get("commands", {}).get("structure")) and (works := _unlike_works(contents, out)):
        said.append(f"{works} One of them is wrong: the structure misuses its load, or its work or velocity is of another size. "
                    f"./tern conform structure {shlex.quote(command)} can tell.")
    return said


def _energies(contents, out):
    """The columns of energy.csv of a coupled run; none if they are not there or damaged: the end of a run is told all the same."""
    path = out / "energy.csv"
    if "coupler" not in contents["processes"] or not path.is_file():
        return {}
    try:
        return read_columns(path)
    except UnreadableRun:
        return {}


def _works(energies, *names):
    """Columns of energy.csv, from the begin of the run; None if they are not there."""
    if not set(names) <= set(energies) or len(energies[names[0]]) < 2:
        return None
    return [energies[name] for name in names]


def _unit(contents):
    return "J/m" if contents["processes"]["coupler"].get("settings", {}).get("dimension") == 2 else "J"


def _unlike_works(contents, out):
    """Both works at the interface in a sentence, if they go together and differ; None if not."""
    works = _works(_energies(contents, out), "interface_work_on_structure_J", "interface_work_on_fluid_J")
    if works is None or len(works[0]) <= ROWS:
        return None
    on_structure = [after - before for before, after in zip(works[0], works[0][1:])]
    from_fluid = [before - after for before, after in zip(works[1], works[1][1:])]
    squares = [sum(a * a for a in steps) for steps in (on_structure, from_fluid)]
    both = sum(a * b for a, b in zip(on_structure, from_fluid))
    if not all(0 < square < math.inf for square in squares) or abs(both) < TOGETHER * math.sqrt(squares[0] * squares[1]):
        return None
    factor = both / squares[1]
    if 1 / FACTOR <= factor <= FACTOR:
        return None
    return (f"The account of the structure tells of {works[0][-1]:.3g} {_unit(contents)} of work that the fluid has done on it, and the "
            f"coupler of {-works[1][-1]:.3g} {_unit(contents)} that the fluid has lost to it; from row to row of energy.csv the first is "
            f"{factor:.3g} times the second.")


def _timing(report):
    """`compute 12.1 s (80 %), wait ...` in order of size, from timing_s."""
    timing = {name: value for name, value in report.get("timing_s", {}).items() if value and value > 0}
    wall = report.get("wall_s") or sum(timing.values()) or 1.0
    parts = sorted(timing.items(), key=lambda item: -item[1])
    return [f"{name} {value:.3g} s ({100 * value / wall:.0f} %)" for name, value in parts]


def ranks(report):
    """What each process of a fluid in many has to do and has spent, as lines of a table; none of a fluid in one."""
    rows = report.get("ranks") or []
    if not rows:
        return []
    lines = ["rank  particles    ghosts     CPU s  waiting s    MiB  machine"]
    lines += [f"{number:4}  {row['particles']:9}  {row['ghosts']:8}  {row['cpu_s']:8.1f}  {row['waiting_s']:9.1f}  "
              f"{row['peak_memory_bytes'] / 2**20:5.0f}  {row['machine']}" for number, row in enumerate(rows)]
    return lines


def _ranks(report):
    """The same in one line."""
    rows = report["ranks"]
    shares = [row["particles"] for row in rows]
    waits = [row["waiting_s"] for row in rows]
    mean = sum(shares) / len(shares)
    over = f" ({max(shares) / mean:.2f} times the mean)" if mean else ""
    ghosts = sum(row["ghosts"] for row in rows) / max(1, sum(shares))
    return (f"{len(rows)} ranks: {min(shares)} to {max(shares)} particles{over}, {ghosts:.0%} ghosts, waiting {min(waits):.3g} to "
            f"{max(waits):.3g} s")


def text(contents, out):
    """The end of a run for people, a dozen lines."""
    lines = ["", f"{contents['case']}: {contents['status']}"
             + (f" at t = {_reached(contents):.6g} s" if _reached(contents) is not None else "")]
    lines.append(f"  wall {contents['wall_s']:.1f} s, CPU {contents['cpu_s']:.1f} s, {contents['steps']} steps")
    for role, report in contents["processes"].items():
        lines.append(f"  {role:<10} CPU {report.get('cpu_s', 0.0):8.1f} s   {report.get('status', '')}"
                     f" (exit code {report['exit_code']})")
        timing = _timing(report)
        for first in range(0, len(timing), 4):
            lines.append(f"  {'':<10} {', '.join(timing[first:first + 4])}")
        if report.get("ranks"):
            lines.append(f"  {'':<10} {_ranks(report)}")
    mean, most = measure(contents, "pressure_iterations_mean"), measure(contents, "pressure_iterations_max")
    if mean is not None:
        lines.append(f"  pressure iterations per step: mean {mean:.1f}, max {most or 0:.0f}")
    trials, open_windows = measure(contents, "coupling_iterations_mean"), measure(contents, "coupling_windows_open")
    if trials is not None:
        lines.append(f"  coupling iterations per window: mean {trials:.1f}, max {measure(contents, 'coupling_iterations_max') or 0:.0f}"
                     + (f"; {open_windows:.0f} windows did not reach the tolerance" if open_windows else ""))
    if taken_back := contents.get("taken_back"):
        lines.append(f"  windows that failed, repeated at half their length or less: {len(taken_back)} times, first from t = "
                     f"{taken_back[0]['time_s']:.6g} s, at the shortest 1/{2**max(entry['halvings'] for entry in taken_back)} as long")
    for name, label, form in CONSERVATION:
        value = measure(contents, name)
        if value is not None:
            lines.append(f"  {label}: {form.format(value)}")
    if made := _made_by_coupling(contents, out):
        lines.append(f"  {made}")
    lines.append(f"  results: {shown(out)}   pictures: ./tern plot {shown(out)}")
    return "\n".join(lines)


def _moved(energies):
    """The energy that a run has moved [J, J/m], from energy.csv: of all bodies the largest kinetic and strain energy, and the way of the
    potential one from its lowest to its highest value (its zero is arbitrary)."""
    moved = 0.0
    for name, values in energies.items():
        if name.endswith(("_kinetic_J", "_strain_J", "_potential_J")):
            energy = [0.0 if math.isnan(value) else value for value in values]
            moved += max(energy) - (min(energy) if name.endswith("_potential_J") else 0.0)
    return moved


def _made_by_coupling(contents, out):
    """The sum of the works on both sides of the interface (docs/SCHEMES.md), and its part of all that has gone through it to and fro.
    Without this part, and without advice, where it is less than NEGLIGIBLE of the energy that the run has moved: the largest kinetic and
    strain energy and the change of the potential one."""
    energies = _energies(contents, out)
    works = _works(energies, "interface_work_on_structure_J", "interface_staggering_J")
    if works is None:
        return None
    work, made = [0 if math.isnan(value) else value for value in works[0]], works[1][-1]
    through = sum(abs(after - before) for before, after in zip(work, work[1:]))
    if not math.isfinite(made) or through == 0:
        return None
    said = f"energy that the coupling has made: {made:+.3g} {_unit(contents)}"
    if abs(made) < NEGLIGIBLE * _moved(energies):
        return f"{said}, less than {NEGLIGIBLE:.1%} of what the run has moved"
    advice = "; half the windows make about half of it (fluid.numerics courant, gravity_courant)" if made > WORTH_SAYING * through else ""
    return f"{said}, {made / through:.1%} of what went through the interface{advice}"


def _reached(contents):
    times = [report["time_s"] for report in contents["processes"].values() if report.get("time_s") is not None]
    return max(times) if times else None
