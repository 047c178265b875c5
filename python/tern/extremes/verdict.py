"""What came of a cell: bounded with its figures, stopped with a message, or wrong.

Bounded: the run ended, and
  speed    the fastest the water was, or the elastic bodies on average (root mean square), over that of the scene, at most 2;
  energy   what was gained: kinetic, potential and strain energy and everything counted as dissipated, less the work of loads and clamps,
           above that at the start, over that of the scene, at most 0.05;
  volume   |largest drift of the fluid's volume|, at most 0.05, and no more than a hundredth of the particles went through a face;
  unrest   how much the change of the load on a plate changes from window to window, root mean square over the second half of the run, over
           rho g H times its length: at most 0.1, or no more than 1.5 times that of the first half.
A scene may say that it needs other limits. Stopped: exit code 2 or 3 and a sentence that names a key of the case to change.
"""

import math
import re

from tern.errors import BAD_INPUT, DONE, NUMERICAL_FAILURE, ReductionError, UnreadableRun
from tern.results import report, series, summary

FIGURES = ("speed", "energy", "volume", "unrest")
KEY = re.compile(r"\b(fluid|structure|coupling|domain)(\.\w+)+|\[(fluid|structure|domain)\]|\b(spacing|end_time)\b")
LEAST_UNREST, GROWTH = 0.1, 1.5
LOADS = ("load.Fx_N_per_m", "load.Fy_N_per_m", "load.Fx_N", "load.Fy_N", "load.Fz_N")  # per metre in 2D
# What makes the total of the energy account, with its sign.
ACCOUNT = {"fluid_kinetic_J": 1, "fluid_potential_J": 1, "structure_kinetic_J": 1, "structure_strain_J": 1, "structure_potential_J": 1,
           "structure_diffusion_J": 1, "structure_damping_J": 1, "riemann_dissipation_J": 1,
           "vem_dissipation_J": 1, "contact_dissipation_J": 1, "load_work_on_structure_J": -1, "clamp_work_on_structure_J": -1}


def fault_of_message(code, sentence):
    """What is missing in the message of a run that stopped; empty when it can be acted upon."""
    if code not in (BAD_INPUT, NUMERICAL_FAILURE):
        return f"exit code {code}"
    if not KEY.search(sentence):
        return "the message names no key to change"
    if code == NUMERICAL_FAILURE and not re.search(r"t = [0-9]", sentence):
        return "the message does not say when"
    return ""


def _columns(path, names):
    """{name: [(t, value)]} of those of `names` that the file has."""
    found = {}
    for name in names:
        try:
            found[name] = series.read(path, name)
        except ReductionError as error:
            if "has no column" not in str(error):
                raise
    return found


def energy_gained(columns, until):
    """Largest rise of the total above its start; None without an account."""
    rows = [dict(part) for part in columns.values()]
    if not rows:
        return None
    signs = [ACCOUNT[name] for name in columns]
    totals = {t: sum(sign * row.get(t, 0.0) for sign, row in zip(signs, rows)) for t in rows[0] if t <= until}
    start = totals[min(totals)]
    return max(total - start for total in totals.values())


def unrest(loads, until):
    """(first half, second half) of the root mean square of how much the change of the load changes; None for too short a run.

    loads: per direction [(t, value)], a row per window.
    """
    kinks = []
    rows = list(zip(*([value for t, value in part if 0 < t <= until] for part in loads)))
    for before, last, present in zip(rows[2:], rows[3:], rows[4:]):
        kinks.append(math.hypot(*(p - 2 * q + r for p, q, r in zip(present, last, before))))
    half = len(kinks) // 2
    if half == 0:
        return None
    return tuple(math.sqrt(sum(kink * kink for kink in part) / len(part)) for part in (kinks[:half], kinks[half:]))


def figures(cell, directory, contents):
    """{figure: value} of a run that ended, in the scales of the cell; raises ReductionError where a value is not finite."""
    energies = _columns(directory / "energy.csv", ACCOUNT)
    fastest = summary.measure(contents, "largest_speed_of_run_m_per_s") or 0.0
    kinetic = [value for t, value in energies.get("structure_kinetic_J", []) if t <= cell.until]
    if kinetic and cell.mass:
        fastest = max(fastest, math.sqrt(2 * max(kinetic) / cell.mass))
    values = {"speed": fastest / cell.speed, "energy": (energy_gained(energies, cell.until) or 0.0) / cell.energy}
    drift = summary.measure(contents, "volume_drift_largest")
    if drift is not None:
        leaked, particles = summary.measure(contents, "particles_leaked") or 0, contents["processes"]["fluid"]["counts"]["particles"]
        values["volume"] = abs(drift)
        values["leaked"] = leaked / max(particles, 1)
    if cell.load:
        loads = _columns(directory / "gauges.csv", LOADS)
        if not loads:
            raise ReductionError("gauges.csv has no load of the plate")
        halves = unrest(list(loads.values()), cell.until)
        if halves:
            values["unrest_before"], values["unrest"] = (value / cell.load for value in halves)
    return values


def judge(cell, values):
    """(class, why) of a run that ended with these figures."""
    speed, energy, volume = cell.limits
    for name, limit in (("speed", speed), ("energy", energy), ("volume", volume), ("leaked", 0.01)):
        value = values.get(name, 0.0)
        if not abs(value) <= limit:
            return "wrong", f"{name} {value:.3g}, at most {limit:g}"
    late, early = values.get("unrest", 0.0), values.get("unrest_before", 0.0)
    if not (late <= LEAST_UNREST or late <= GROWTH * early):
        return "wrong", f"unrest grows from {early:.3g} to {late:.3g}"
    return "bounded", ""


def classify(cell, directory, exit_code, errors=""):
    """The row of one cell: class, figures, message. `exit_code` None: the run did not end in time."""
    row = {"class": "wrong", "exit_code": "" if exit_code is None else exit_code, "message": "", "windows": ""}
    try:
        contents = report.read(directory)
    except UnreadableRun:
        contents = {}
    row["windows"] = contents.get("steps", "")
    if exit_code is None:
        return row | {"message": "the run did not end in time"}
    if exit_code != DONE:
        sentence = contents.get("first_cause") or errors.strip().removeprefix("tern:").strip()
        fault = fault_of_message(exit_code, sentence)
        return row | {"class": "wrong" if fault else "stopped", "message": (f"{fault}: " if fault else "") + sentence}
    try:
        values = figures(cell, directory, contents)
    except (ReductionError, KeyError, ValueError) as error:
        return row | {"message": f"the results cannot be judged: {error}"}
    verdict, why = judge(cell, values)
    return row | {name: f"{values[name]:.4g}" for name in FIGURES if name in values} | {"class": verdict, "message": why}
