"""Scenes that nobody has tuned: tanks at rest, shaken and broken dams, with an elastic body and perhaps a rigid obstacle, drawn at random.

A seed and a number make a scene, whatever the scenes before it. All settings that are not geometry, material or spacing are the defaults.
"""

import math
import random

from tern.extremes.cell import GRAVITY, WATER, Cell
from tern.extremes.scenes import EVERY_WINDOW, LOAD, body, box, fluid_of, head, tank_wall

FLOWS = ("at rest", "shaken", "broken dam")
BODIES = ("standing plate", "hanging gate", "leaning plate", "floor", "block on the floor", "free block", "free ball")
LIMITS = {"at rest": (3.0, 0.05, 0.05), "shaken": (12.0, 1.0, 0.05), "broken dam": (12.0, 0.05, 0.05)}  # nobody counts what shaking gives


def _log(draw, low, high):
    """Evenly distributed in the logarithm, to three digits."""
    return float(f"{math.exp(draw.uniform(math.log(low), math.log(high))):.3g}")


def _even(draw, low, high):
    return float(f"{draw.uniform(low, high):.3g}")


def _ball(center, radius):
    return f"{{ ball = {{ center = [{center[0]:.6g}, {center[1]:.6g}], radius = {radius:.6g} }} }}"


def _polygon(vertices):
    return "{ polygon = { vertices = [" + ", ".join(f"[{x:.6g}, {y:.6g}]" for x, y in vertices) + "] } }"


def _difference(shapes):
    return shapes[0] if len(shapes) == 1 else "{ difference = [" + ", ".join(shapes) + "] }"


def _elastic(draw, kind, width, depth, left):
    """(shape, clamps, thickness, area) of a body; `left`: where it may begin, so that it stands in the water or before the dam."""
    middle = _even(draw, max(left, 0.3 * width), 0.7 * width)
    thick = _even(draw, 0.06, 0.2) * depth
    high = _even(draw, 0.35, 0.8) * depth
    if kind == "standing plate":
        return box(middle, -2 * thick, middle + thick, high), [box(-9, -9, 9, 0)], thick, thick * high
    if kind == "hanging gate":
        low, top = _even(draw, 0.1, 0.4) * depth, 1.6 * depth
        return box(middle, low, middle + thick, top), [box(-9, 1.4 * depth, 9, 9)], thick, thick * (top - low)
    if kind == "leaning plate":  # clamped at the lower end, above the floor
        lean, foot = _even(draw, -0.9, 0.9), 0.15 * depth
        along, across = (math.sin(lean), math.cos(lean)), (math.cos(lean), -math.sin(lean))
        corner = [(middle + a * high * along[0] + b * thick * across[0], foot + a * high * along[1] + b * thick * across[1])
                  for a, b in ((0, 0), (0, 1), (1, 1), (1, 0))]
        return _polygon(corner), [_ball((middle + thick / 2 * across[0], foot + thick / 2 * across[1]), 0.8 * thick)], thick, thick * high
    if kind == "floor":
        held = 2 * thick
        return box(-held, -thick, width + held, 0), [box(-9, -9, 0, 9), box(width, -9, 9, 9)], thick, thick * width
    if kind == "block on the floor":
        wide = _even(draw, 0.2, 0.6) * depth
        return box(middle, 0, middle + wide, high), [box(-9, -9, 9, 0.2 * high)], min(wide, high), wide * high
    side = _even(draw, 0.2, 0.4) * depth
    low = _even(draw, 0.3, 0.5) * depth
    if kind == "free block":
        return box(middle, low, middle + 1.5 * side, low + side), [], side, 1.5 * side**2
    return _ball((middle, low + side / 2), side / 2), [], side, math.pi * side**2 / 4


def scene(seed, number):
    """The cell of one random scene."""
    draw = random.Random(f"{seed}/{number}")
    flow, kind = draw.choice(FLOWS), draw.choice(BODIES)
    depth, gravity = _even(draw, 0.1, 1.0), ("0", f"{-GRAVITY}")
    width = _even(draw, 1.2, 2.5) * depth
    fluid_density = draw.choice((WATER, 850.0, 1260.0))
    spacing = float(f"{depth / draw.randint(14, 26):.3g}")
    ratio, modulus, nu, layers = _log(draw, 0.05, 8), _log(draw, 3e4, 1e9), _even(draw, 0.1, 0.45), draw.randint(3, 6)
    viscosity = draw.choice((None, None, 1e-3, 0.5))
    until = 3 * math.sqrt(depth / GRAVITY)
    dam = 0.25 * width
    shape, clamps, thick, area = _elastic(draw, kind, width, depth, 1.3 * dam if flow == "broken dam" else 0.0)
    body_spacing = float(f"{thick / layers:.3g}")
    if kind in ("block on the floor", "free block", "free ball"):
        body_spacing = min(body_spacing, float(f"{spacing:.3g}"))
    if flow == "shaken":
        gravity = (f"{_even(draw, 0.5, 4)}*sin({_even(draw, 2, 12)}*t)", gravity[1])
    rigid = draw.random() < 0.3 and flow == "broken dam"
    hump = box(1.05 * dam, 0, 1.05 * dam + 2 * spacing, 3 * spacing)
    filled = box(0, 0, dam if flow == "broken dam" else width, depth)
    case = (head(f"{kind}, {flow}", until, (0.0, 0.0), (-2 * width, -2 * depth, 3 * width, 5 * depth))
            .replace("gravity = [0, 0]", f'gravity = ["{gravity[0]}", "{gravity[1]}"]')
            + tank_wall(box(0, 0, width, 2 * depth), ("y_max", "y_min") if kind == "floor" else ("y_max",))
            + (f'[[wall]]\nname = "hump"\nobstacle = {hump}\n' if rigid else "")
            + fluid_of([filled if kind == "floor" else _difference([filled, shape])], spacing).replace(
                f"density = {WATER}", f"density = {fluid_density}" + (f"\nviscosity = {viscosity}" if viscosity else ""))
            + body(shape, body_spacing, ratio * fluid_density, modulus, nu, clamps) + LOAD + EVERY_WINDOW)
    name = f"{seed}/{number}: {kind}, {flow}, density ratio {ratio:g}, E {modulus:g} Pa, nu {nu:g}, {layers} across" + (
        ", obstacle" if rigid else "")
    volume = depth * (dam if flow == "broken dam" else width)
    return Cell("random", name, case, math.sqrt(GRAVITY * depth), fluid_density * GRAVITY * depth * volume / 2,
                mass=ratio * fluid_density * area, load=fluid_density * GRAVITY * depth * depth, until=until, limits=LIMITS[flow],
                row=kind, column=flow)
