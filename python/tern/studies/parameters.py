"""The parameters of a study: every numerical option, the values tried, and what a scene needs to have it.

Values are tried one at a time around the case as it stands; the first of each list tell most, --levels takes as many.
"""

import difflib
from dataclasses import dataclass, field
from math import gcd

from tern.errors import BAD_INPUT, Error


@dataclass(frozen=True)
class Parameter:
    """One option. `values`: numbers that multiply the value of the case where `scaled`, else the values themselves."""

    key: str
    needs: str          # of the scene: any, fluid, structure, both, viscosity
    values: tuple
    scaled: bool = False
    unit: str = ""
    refines: bool = False  # a smaller value is a finer computation, with an order to observe
    with_: tuple = ()      # settings without which the parameter does nothing


# Factors of a spacing that are no power of two are moved to where the lattice still divides the boxes; see `_fitting`.
_SPACING = (2.0, 0.5, 2**0.5, 0.5**0.5)

PARAMETERS = (
    Parameter("preset", "any", ("draft", "reference")),
    Parameter("spacing", "both", _SPACING, True, "", True),
    Parameter("fluid.spacing", "fluid", _SPACING, True, "m", True),
    Parameter("structure.body.spacing", "structure", _SPACING, True, "m", True),
    Parameter("fluid.numerics.courant", "fluid", (1.25, 0.5), True, "", True),
    Parameter("fluid.numerics.gravity_courant", "fluid", (2.0, 0.5), True, "", True),
    Parameter("fluid.numerics.viscous_courant", "viscosity", (0.5, 0.25), True, "", True),
    Parameter("fluid.numerics.pressure_tolerance", "fluid", (1e-4, 1e-8, 1e-3, 1e-2), refines=True),
    Parameter("fluid.numerics.smoothing_length_ratio", "fluid", (1.3, 1.8, 1.2)),
    Parameter("fluid.numerics.gradient", "fluid", ("sum",)),
    Parameter("fluid.numerics.blend_theta", "fluid", (0.0, 0.5)),
    Parameter("fluid.numerics.density_relaxation", "fluid", (0.0, 0.05)),
    Parameter("fluid.numerics.shifting", "fluid", (0.0, 2.0)),
    Parameter("fluid.numerics.noise_damping", "fluid", (0.0, 0.4)),
    Parameter("fluid.numerics.contact_distance", "fluid", (0.0, 0.4)),
    Parameter("structure.numerics.integrator", "structure", ("explicit", "implicit")),
    Parameter("structure.numerics.courant", "structure", (2.0, 0.5), True, "", True, ("structure.numerics.integrator=explicit",)),
    Parameter("structure.numerics.smoothing_length_ratio", "structure", (1.3, 1.0)),
    Parameter("structure.numerics.riemann_diffusion", "structure", (0.0, 0.5), with_=("structure.numerics.integrator=explicit",)),
    Parameter("coupling.algorithm", "both", ("explicit",)),
    Parameter("coupling.max_iterations", "both", (1,)),
    Parameter("coupling.tolerance", "both", (1e-2, 1e-4, 1e-6), refines=True),
    Parameter("coupling.scheme", "both", ("pi", "fsa")),
    Parameter("coupling.riemann_limiter", "both", (0.0, 6.0)),
    Parameter("coupling.robin_mass_factor", "both", (0.5, 1.2)),
    # --set cannot take a table away; a coefficient of 1e-9 is as good as none.
    Parameter("coupling.vem.coefficient", "both", (1e-9, 1.0, 5.0)),
    Parameter("coupling.vem.form", "both", ("sum", "seed"), with_=("coupling.vem.coefficient=1",)),
)


@dataclass(frozen=True)
class Point:
    """One run of a study: the case with `options`."""

    name: str
    parameter: str = ""
    value: str = ""
    options: tuple = field(default_factory=tuple)  # words of the command line


STANDARD = Point("standard")
STANDARD_AGAIN = Point("standard-again")  # the last run: how much the same costs an hour later


def select(names):
    """The parameters called by whole name or by an ending of it that only one has; all for no names."""
    if not names:
        return list(PARAMETERS)
    chosen = []
    for name in names:
        found = [parameter for parameter in PARAMETERS if parameter.key == name] or [parameter for parameter in PARAMETERS
                                                                                     if parameter.key.endswith("." + name)]
        if len(found) > 1:
            raise Error(BAD_INPUT, f"--parameters {name} may be {' or '.join(parameter.key for parameter in found)}; write it in full.")
        if not found:
            keys = [parameter.key for parameter in PARAMETERS]
            near = difflib.get_close_matches(name, keys + [key.rpartition(".")[2] for key in keys], n=1, cutoff=0.5)
            raise Error(BAD_INPUT, f"--parameters: there is no parameter {name}{f', did you mean {near[0]}?' if near else ';'} "
                                           f"known are {', '.join(keys)}.")
        chosen += found
    return chosen


def effective(settings, key):
    """The value of a key in the effective settings, of the first element of a list of tables; None if it has none."""
    place = settings
    for part in key.split("."):
        place = place[0] if isinstance(place, list) else place
        place = place.get(part) if isinstance(place, dict) else None
    return place


def applies(parameter, settings):
    """Whether the scene has what the parameter turns."""
    fluid, structure = "fluid" in settings, "structure" in settings
    return {"any": True, "fluid": fluid, "structure": structure, "both": fluid and structure,
            "viscosity": fluid and "viscosity" in settings["fluid"]}[parameter.needs]


def _box_sides(bodies, spacing):
    """Sides of all bodies that are boxes, in spacings; None where one is no whole number of them."""
    sides = []
    for body in bodies:
        box = body["shape"].get("box")
        lengths = [(high - low) / spacing for low, high in zip(box["min"], box["max"])] if box else []
        if any(abs(length - round(length)) > 1e-6 for length in lengths):
            return None
        sides += [round(length) for length in lengths]
    return sides


def _fitting(factor, bodies, spacing):
    """The factor nearest to this one with which the lattice still divides every box; None if that is too far off."""
    sides = _box_sides(bodies, spacing)
    if not sides:
        return round(factor, 3)
    common = gcd(*sides)
    fits = [common / count for count in range(1, 4 * common + 1)]
    best = min(fits, key=lambda fit: abs(fit / factor - 1))
    return best if abs(best / factor - 1) < 0.12 else None


def _number(value):
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def _body_spacings(settings, factor):
    """[(key, value)] of the spacing of every elastic body, scaled; None where a lattice would no longer fit."""
    keys = []
    for body in settings["structure"]["body"]:
        fit = _fitting(factor, [body], body["spacing"])
        if fit is None:
            return None
        keys.append((f"structure.body.{body['name']}.spacing", body["spacing"] * fit))
    return keys


def _fluid_spacing(settings, factor):
    fluid = settings["fluid"]
    fit = _fitting(factor, fluid["body"], fluid["spacing"])
    return None if fit is None else [("fluid.spacing", fluid["spacing"] * fit)]


def _settings_of(parameter, value, settings):
    """(what is printed as the value, [(key, value)]) of one try; None if it is no other than the case, or does not fit."""
    if parameter.key in ("fluid.spacing", "structure.body.spacing"):
        pairs = (_fluid_spacing if parameter.needs == "fluid" else _body_spacings)(settings, value)
        return pairs and (_number(pairs[0][1]), pairs)
    if parameter.key == "spacing":
        fluid, bodies = _fluid_spacing(settings, value), _body_spacings(settings, value)
        return fluid and bodies and (f"{value:.4g} x", fluid + bodies)
    now = effective(settings, parameter.key)
    if now is None and parameter.key == "structure.numerics.integrator":
        now = "auto" if "fluid" in settings else "explicit"  # what an absent key means
    if parameter.scaled:
        return None if now is None else (_number(now * value), [(parameter.key, now * value)])
    same = isinstance(now, (int, float)) and isinstance(value, float) and abs(now - value) <= 1e-12 * abs(now)
    return None if same or now == value else (_number(value), [(parameter.key, value)])


def points(settings, parameters, levels):
    """All points of a study but the two of the case as it stands."""
    result = []
    for parameter in parameters:
        if not applies(parameter, settings):
            continue
        for value in parameter.values[:levels]:
            if parameter.key == "preset":
                result.append(Point(value, "preset", value, ("--preset", value)))
                continue
            found = _settings_of(parameter, value, settings)
            if found:
                pairs = [*(pair.split("=") for pair in parameter.with_), *found[1]]
                words = tuple(word for key, setting in pairs for word in ("--set", f"{key}={_number(setting)}"))
                result.append(Point(f"{parameter.key}={found[0].replace(' ', '')}", parameter.key, found[0], words))
    return result
