"""What the rows of a study say: the front, the finest run, observed orders, speed-ups, and the answer to a wish."""

import math
from dataclasses import dataclass

REPEATED = "standard-again"


def find(rows, name):
    """The finished row of a point; None if there is none."""
    return next((row for row in rows if row.point == name and row.done), None)


def error_of(row):
    """What a row is judged by: the error against the reference, or the distance to the finest run where there is none to trust."""
    return row.error if row.error is not None and row.judged_by == "reference" else row.distance_to_finest


def by_reference(rows):
    """Whether the study is judged by references."""
    return any(row.error is not None and row.judged_by == "reference" for row in rows)


def _same_computation(row):
    """What two rows share if the one parameter more did nothing: then only the noise of CPU times could tell them apart."""
    return row.steps, row.pressure_iterations, row.error, row.distance_to_standard, tuple(row.quantities.values())


def measured(rows):
    """The finished rows with a cost and an error; of equal computations one, a preset before others."""
    known = [row for row in rows if row.done and row.cpu_s and error_of(row) is not None and row.point != REPEATED]
    known.sort(key=lambda row: 0 if row.point == "standard" else 1 if row.parameter == "preset" else 2)
    distinct = {}
    for row in known:
        distinct.setdefault(_same_computation(row), row)
    return list(distinct.values())


def pareto(rows):
    """The rows no other beats, from the cheapest to the most accurate: each at least 1 % closer than all that are cheaper."""
    front = []
    for row in sorted(measured(rows), key=lambda row: (row.cpu_s, error_of(row))):
        if not front or error_of(row) < 0.99 * error_of(front[-1]):
            front.append(row)
    return front


def spacings(row):
    """(of the fluid, of the structure) [m], as far as the scene has them; what is refined first comes first."""
    names = ("fluid.spacing_m", "structure.body.spacing_m")
    return tuple(float(row.settings[name]) for name in names if row.settings.get(name))


def finest(rows):
    """The finished run of the smallest spacings; among equals the one of most steps and iterations."""
    done = [row for row in rows if row.done and spacings(row) and row.point != REPEATED]
    return min(done, key=lambda row: (*spacings(row), -(row.steps or 0), -(row.pressure_iterations or 0)), default=None)


def next_finest(rows):
    """The finished run of the next coarser spacing, with nothing else changed; its distance is the uncertainty of the finest."""
    best = finest(rows)
    coarser = [row for row in rows if row.done and best and spacings(row) and spacings(row)[0] > 1.01 * spacings(best)[0]
               and (row.point == "standard" or row.parameter.endswith("spacing"))]
    return min(coarser, key=spacings, default=None)


def standard_cost(rows):
    """(mean CPU time of the case as it stands [s], scatter of it: largest over smallest of its runs - 1)."""
    costs = [row.cpu_s for row in rows if row.done and row.cpu_s and row.point in ("standard", REPEATED)]
    return (sum(costs) / len(costs), max(costs) / min(costs) - 1) if costs else (None, None)


def family(rows, parameter):
    """[(value, row)] of a parameter that refines, the case as it stands included, from coarse to fine."""
    entries = [(_value(row, parameter), row) for row in rows if row.done and row.parameter == parameter]
    standard = find(rows, "standard")
    if entries and standard and parameter != "spacing":
        entries.append((_value(standard, parameter), standard))
    elif entries and standard:
        entries.append((1.0, standard))
    return sorted((entry for entry in entries if entry[0] is not None), key=lambda entry: -entry[0])


def _value(row, parameter):
    if parameter == "spacing":
        return float(row.value.split()[0])
    cell = next((cell for name, cell in row.settings.items() if name == parameter or name.startswith(parameter + "_")), "")
    try:
        return float(cell)
    except ValueError:
        return None


def order(coarse, fine):
    """Observed order between two (value, error): the power of the value by which the error falls; None if undefined."""
    (value, error), (finer_value, finer_error) = coarse, fine
    if not (error and finer_error and value > finer_value > 0):
        return None
    return math.log(error / finer_error) / math.log(value / finer_value)


def order_of_three(values, to_finest):
    """Order p of error = c value^p from the distances of two runs to a third, finer one; None if none fits (0.05 to 8).

    (v1^p - v3^p)/(v2^p - v3^p) = d1/d2 grows with p, so bisection finds it.
    """
    (coarse, middle, fine), (far, near) = values, to_finest
    if not (coarse > middle > fine > 0 and far and near and far > near):
        return None

    def excess(power):
        return (coarse**power - fine**power) / (middle**power - fine**power) - far / near

    low, high = 0.05, 8.0
    if excess(low) > 0 or excess(high) < 0:
        return None
    for _ in range(60):
        half = 0.5 * (low + high)
        low, high = (half, high) if excess(half) < 0 else (low, half)
    return 0.5 * (low + high)


@dataclass
class Order:
    """How a parameter converges: errors and distances to the finest of the parameter, with the orders they show."""

    parameter: str
    entries: list          # [(value, row)], coarse to fine
    against_reference: list  # between neighbours
    of_itself: float | None  # from the last three
    plateau: float | None    # value from which on refining removes less than a tenth of the error


def orders(rows, parameters):
    """One Order per parameter of `parameters` with three values."""
    result = []
    for parameter in parameters:
        entries = family(rows, parameter)
        if len(entries) < 3:
            continue
        errors = [(value, row.error) for value, row in entries]
        found = [order(*pair) for pair in zip(errors, errors[1:])]
        last = entries[-3:]
        # The standard belongs to many parameters; how far it is from the finest of this one, that one knows.
        to_finest = [last[2][1].distance_to_standard if row.point == "standard" else row.distance_in_parameter for _, row in last[:2]]
        itself = order_of_three([value for value, _ in last], to_finest)
        plateau = None
        for (value, error), (_, finer) in zip(reversed(errors[:-1]), reversed(errors[1:])):
            if error is None or finer is None or finer < 0.9 * error:
                break
            plateau = value
        result.append(Order(parameter, entries, found, itself, plateau))
    return result


def best_for_error(rows, wanted):
    """(row, met): the cheapest that is within the wanted error, or else the most accurate."""
    known = measured(rows)
    within = [row for row in known if error_of(row) <= wanted]
    if within:
        return min(within, key=lambda row: row.cpu_s), True
    return min(known, key=error_of, default=None), False


def best_for_time(rows, seconds):
    """(row, met): the most accurate that takes at most so much wall time, or else the quickest."""
    known = [row for row in measured(rows) if row.wall_s is not None]
    within = [row for row in known if row.wall_s <= seconds]
    if within:
        return min(within, key=lambda row: (error_of(row), row.cpu_s)), True
    return min(known, key=lambda row: row.wall_s, default=None), False
