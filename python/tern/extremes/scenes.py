"""The scenes of the map. Cases as text; of water, in 2D of some hundred particles each, in 3D of some thousand."""

import math

from tern.extremes.cell import GRAVITY, WATER, Cell

DEPTH, WIDTH, FLUID_SPACING, PLATE_SPACING = 0.16, 0.24, 0.01, 0.005
SLOSH = (0.98, -GRAVITY)  # a tank tilted by a tenth of gravity at t = 0


def _numbers(values):
    return "[" + ", ".join(f"{value:.9g}" for value in values) + "]"


def box(*corners):
    """The lower corner, then the upper one."""
    half = len(corners) // 2
    return f"{{ box = {{ min = {_numbers(corners[:half])}, max = {_numbers(corners[half:])} }} }}"


def head(title, end_time, gravity, domain):
    dimension = len(gravity)
    return (f'title = "{title}"\ndimension = {dimension}\nend_time = {end_time:.9g}\ngravity = {_numbers(gravity)}\n'
            f"[domain]\nmin = {_numbers(domain[:dimension])}\nmax = {_numbers(domain[dimension:])}\n")


def tank_wall(box, open_faces=("y_max",)):
    return f'[[wall]]\nname = "tank"\ncontainer = {box}\nopen = {list(open_faces)!r}\n'.replace("'", '"')


def fluid_of(shapes, spacing, velocity=None):
    text = f"[fluid]\ndensity = {WATER}\nspacing = {spacing:.9g}\n"
    for shape in shapes:
        text += f"[[fluid.body]]\nshape = {shape}\n" + (f"velocity = [{velocity[0]}, {velocity[1]}]\n" if velocity else "")
    return text


def body(shape, spacing, density, modulus, nu, clamps, extra=""):
    return (f'[[structure.body]]\nname = "plate"\nshape = {shape}\nspacing = {spacing:.9g}\ndensity = {density:.9g}\n'
            f"young_modulus = {modulus:.9g}\npoisson_ratio = {nu:.9g}\nclamp = [{', '.join(clamps)}]\n{extra}")


EVERY_WINDOW = "[output]\nframe_interval = 1000\ngauge_interval = 1e-6\n"
LOAD = '[[gauge]]\nkind = "interface_force"\nname = "load"\nbody = "plate"\n'


def plate(family, name, *, ratio=1.0, layers=4, modulus=1e7, faces=2, nu=0.3, spacing=PLATE_SPACING, thickness=None, gravity=SLOSH,
          sealed=False, until=0.1, tail=0.04, velocity=None, **more):
    """A tank of 0.24 m with 0.16 m of water. One wet face: the plate is its floor, clamped at both sides. Two: it stands in the
    middle, 0.08 m high, clamped at its foot. Water and plate start at rest, the plate unloaded. The run goes on for a `tail`: windows are
    stretched to meet its end, and a change of their length shows vibrations that it strobes otherwise."""
    thickness = thickness or layers * spacing
    height = DEPTH if sealed else 2 * DEPTH
    open_faces = () if sealed else ("y_max",)
    if faces == 1:
        held = 4 * spacing
        tank = tank_wall(box(0, -0.1, WIDTH, height), (*open_faces, "y_min"))
        water = [box(0, 0, WIDTH, DEPTH)]
        shape = (-held, -thickness, WIDTH + held, 0)
        clamps = [box(-1, -1, 0, 1), box(WIDTH, -1, 1, 1)]
    else:
        middle, top = WIDTH / 2, DEPTH / 2
        tank = tank_wall(box(0, 0, WIDTH, height), open_faces)
        water = [box(middle + thickness, 0, WIDTH, top), box(0, top, WIDTH, DEPTH), box(0, 0, middle, top)]
        shape = (middle, -4 * spacing, middle + thickness, top)
        clamps = [box(-1, -1, 1, 0)]
    case = (head("Plate in a tank that is tilted", until + tail, gravity, (-1, -1, 1, 1)) + tank + fluid_of(water, FLUID_SPACING, velocity)
            + body(box(*shape), spacing, ratio * WATER, modulus, nu, clamps) + LOAD + EVERY_WINDOW)
    mass = ratio * WATER * (shape[2] - shape[0]) * (shape[3] - shape[1])
    length = WIDTH if faces == 1 else DEPTH
    return Cell(family, name, case, (GRAVITY * DEPTH) ** 0.5, WATER * GRAVITY * DEPTH**2 * WIDTH / 2, mass=mass,
                load=WATER * GRAVITY * DEPTH * length, until=until, **more)


def plate_3d(family, name, *, ratio=1.0, layers=4, modulus=1e7, faces=2, until=0.08, tail=0.02, **more):
    """The tank in three dimensions: 0.16 m long, 0.08 m wide, 0.12 m of water, tilted both ways. One wet face: the plate is its floor,
    clamped at both ends. Two: it stands in the middle, 0.06 m high and half as wide as the tank, so that water passes it above and at
    both sides."""
    long, wide, deep, spacing = 0.16, 0.08, 0.12, 0.01
    thickness = layers * spacing
    if faces == 1:
        held = 2 * spacing
        tank = tank_wall(box(0, -0.1, 0, long, 2 * deep, wide), ("y_max", "y_min"))
        water = [box(0, 0, 0, long, deep, wide)]
        shape = (-held, -thickness, 0, long + held, 0, wide)
        clamps = [box(-1, -1, -1, 0, 1, 1), box(long, -1, -1, 1, 1, 1)]
    else:
        begin, top, side = long / 2 - thickness / 2, deep / 2, wide / 4
        tank = tank_wall(box(0, 0, 0, long, 2 * deep, wide))
        shape = (begin, -2 * spacing, side, begin + thickness, top, wide - side)
        water = [f"{{ difference = [{box(0, 0, 0, long, deep, wide)}, {box(*shape)}] }}"]
        clamps = [box(-1, -1, -1, 1, 0, 1)]
    case = (head("Plate in a tank that is tilted, 3D", until + tail, (*SLOSH, 0.5), (-1, -1, -1, 1, 1, 1)) + tank + fluid_of(water,
                                                                                                                            FLUID_SPACING)
            + body(box(*shape), spacing, ratio * WATER, modulus, 0.3, clamps) + LOAD + EVERY_WINDOW)
    volume = math.prod(shape[c + 3] - shape[c] for c in range(3))
    area = long * wide if faces == 1 else shape[4] * (shape[5] - shape[2])
    return Cell(family, name, case, (GRAVITY * deep) ** 0.5, WATER * GRAVITY * deep**2 * long * wide / 2, mass=ratio * WATER * volume,
                load=WATER * GRAVITY * deep * area, until=until, **more)


def block_3d(family, name, *, ratio, modulus=1e7, until=0.08, tail=0.02, **more):
    """A free cube of 0.06 m let go in the middle of a tank of 0.16 m: its faces, edges and corners are wet all around."""
    wide, deep, side, spacing = 0.16, 0.16, 0.06, 0.01
    low, high = (wide - side) / 2, (wide + side) / 2
    cube = box(low, low, low, high, high, high)
    case = (head("Free cube under water", until + tail, (0.0, -GRAVITY, 0.0),
                  (-1, -1, -1, 1, 1, 1)) + tank_wall(box(0, 0, 0, wide, 2 * deep, wide))
            + fluid_of([f"{{ difference = [{box(0, 0, 0, wide, deep, wide)}, {cube}] }}"], FLUID_SPACING)
            + body(cube, spacing, ratio * WATER, modulus, 0.3, []) + LOAD + EVERY_WINDOW)
    return Cell(family, name, case, (GRAVITY * deep) ** 0.5, WATER * GRAVITY * deep**2 * wide**2 / 2, mass=ratio * WATER * side**3,
                load=WATER * GRAVITY * deep * side**2, until=until, **more)


def tank(family, name, *, gravity=SLOSH, until=0.5, sealed=False, velocity=None, spacing=FLUID_SPACING, **more):
    """The same tank without a plate."""
    height = DEPTH if sealed else 2 * DEPTH
    case = (head("Tank that is tilted", until, gravity, (-1, -1, 1, 1)) + tank_wall(box(0, 0, WIDTH, height), () if sealed else ("y_max",))
            + fluid_of([box(0, 0, WIDTH, DEPTH)], spacing, velocity) + EVERY_WINDOW)
    return Cell(family, name, case, (GRAVITY * DEPTH) ** 0.5, WATER * GRAVITY * DEPTH**2 * WIDTH / 2, until=until, **more)


def column(family, name, *, until=0.4, modulus=None, layers=2, density=1200, **more):
    """A column of water that breaks and hits the far wall, or an elastic plate before it; the plate of the dam break, coarse."""
    high, wide = 0.16, 0.08
    case = head("Column that breaks", until, (0.0, -GRAVITY), (-0.1, -0.2, 0.4, 1)) + tank_wall(box(0, 0, 0.32, 0.6))
    case += fluid_of([box(0, 0, wide, high)], 0.005)
    mass = 0.0
    if modulus:
        thickness = layers * 0.002
        case += body(box(0.24, -0.008, 0.24 + thickness, 0.05), 0.002, density, modulus, 0.4, [box(0.2, -0.1, 0.3, 0)]) + LOAD
        mass = density * thickness * 0.058
    load = WATER * GRAVITY * high * 0.05 if modulus else 0.0
    return Cell(family, name, case + EVERY_WINDOW, (GRAVITY * high) ** 0.5, WATER * GRAVITY * high**2 * wide / 2, mass=mass, load=load,
                until=until, **more)


def drop(family, name, *, speed, until, modulus=None, **more):
    """A disc of 0.1 m of water hits a pool of 0.1 m, or an elastic floor under it. Scales: speed and energy of the disc."""
    case = head("Drop on a pool", until, (0.0, -GRAVITY), (-1, -0.5, 2, 4)) + tank_wall(
        box(0, -0.1, 0.6, 0.6), ("y_max", "y_min") if modulus else ("y_max",)).replace("-0.1", "-0.1" if modulus else "0")
    case += fluid_of([box(0, 0, 0.6, 0.1)], 0.01)
    case += f"[[fluid.body]]\nshape = {{ ball = {{ center = [0.3, 0.165], radius = 0.05 }} }}\nvelocity = [0, {-speed}]\n"
    mass = 0.0
    if modulus:
        case += body(box(-0.04, -0.02, 0.64, 0), 0.005, 1200, modulus, 0.3, [box(-1, -1, 0, 1), box(0.6, -1, 1, 1)]) + LOAD
        mass = 1200 * 0.02 * 0.68
    return Cell(family, name, case + EVERY_WINDOW, speed, WATER * 3.1416 * 0.05**2 * speed**2 / 2, mass=mass, until=until, **more)


def squeezed(family, name, *, left, material="neo_hookean", nu=0.3, wide=2.0, layers=8, **more):
    """A block, 1 m high, between two clamps of which the upper one comes down to `left` of the height in 0.1 s. Scales: wave speed
    and energy of the squeeze, E/2 (1 - left)^2 of its volume."""
    modulus, spacing = 1e6, 1.0 / layers
    edge = spacing
    held = (f'[[structure.clamp]]\nname = "lid"\nbody = "plate"\nregion = {box(-1, 1, wide + 1, 2)}\n'
            f'displacement = [0, "{left - 1}*min(t/0.1,1)"]\n')
    case = (f'title = "Squeezed block"\ndimension = 2\nend_time = 0.12\ngravity = [0, 0]\n'
            + body(box(0, -edge, wide, 1 + edge), spacing, 1000, modulus, nu, [box(-1, -1, wide + 1, 0)],
                    f'material = "{material}"\n') + held
            + "[output]\nframe_interval = 1000\ngauge_interval = 1e-3\n")
    mass = 1000 * wide * (1 + 2 * edge)
    return Cell(family, name, case, (modulus / 1000) ** 0.5, modulus * wide * (1 - left) ** 2 / 2, mass=mass, until=0.12, **more)


def piston(family, name, *, ratio, **more):
    """Water of 0.1 m between slip walls on a bar of 0.04 m, as wide as the column: one-dimensional, so that its added mass is known,
    rho H, and the theory of one mode holds. `ratio`: of that over the mass with which the bar answers, a third of its own, since its
    displacement falls linearly to the held end."""
    depth, thick, wide = 0.1, 0.02, 0.1
    density = 3 * WATER * depth / (ratio * thick)
    case = (head("Water on an elastic piston", 0.06, (0.0, -GRAVITY), (-0.1, -0.4, 0.3, 0.6)) + tank_wall(box(0, -0.3, wide, 0.4))
            + fluid_of([box(0, 0, wide, depth)], 0.01)
            + body(box(0, -thick - 0.01, wide, 0), 0.005, density, 2e5, 0, [box(-1, -1, 1, -thick)]) + LOAD + EVERY_WINDOW)
    return Cell(family, name, case, (GRAVITY * depth) ** 0.5, WATER * GRAVITY * depth**2 * wide / 2, mass=density * 0.03 * wide,
                load=WATER * GRAVITY * depth * wide, until=0.05, **more)
