"""Which cells the map has, family by family, and where boundaries are looked for."""

from dataclasses import dataclass, replace
from typing import Callable

from tern.extremes import scenes
from tern.extremes.cell import Cell

COUPLINGS = {"explicit": "coupling.algorithm=explicit", "one pass": "coupling.max_iterations=1", "repeated": "coupling.tolerance=1e-4"}
RATIOS, LAYERS, MODULI, FACES = (0.01, 0.1, 1, 10), (2, 4, 8), (1e5, 1e7, 1e9), (1, 2)
LIVELY = (12.0, 0.05, 0.05)  # jets of an impact reach several times the speed they come from


def _set(cell, *options):
    return replace(cell, options=(*cell.options, *options))


def plate_name(ratio, layers, modulus, faces):
    return f"density ratio {ratio:g}, {layers} across, E {modulus:g} Pa, {'one face' if faces == 1 else 'both faces'} wet"


def plates():
    """Density ratio x thickness x E x wet faces, staggered, in one pass, and repeated; the default is between the last two."""
    for faces in FACES:
        for ratio in RATIOS:
            for layers in LAYERS:
                for modulus in MODULI:
                    name = plate_name(ratio, layers, modulus, faces)
                    for coupling, option in COUPLINGS.items():  # what explicit coupling does to a heavy plate grows slowly
                        cell = scenes.plate("plates", f"{name}, {coupling}", ratio=ratio, layers=layers, modulus=modulus, faces=faces,
                                            allow_unstable=coupling == "explicit", until=0.2 if coupling == "explicit" else 0.1,
                                            row=f"{ratio:g}, {layers} across",
                                            column=f"{modulus:.0e}, {faces} wet".replace("e+0", "e"))
                        yield _set(cell, option)


def poisson():
    for nu in (0.3, 0.45, 0.49, 0.499, 0.4999, 0.49999):
        yield scenes.plate("poisson", f"plate under water, Poisson's ratio {nu}", nu=nu, row="plate under water", column=str(nu))
    for nu in (0.3, 0.49, 0.4999):
        yield scenes.squeezed("poisson", f"block squeezed to 0.9, Poisson's ratio {nu}", left=0.9, nu=nu, row="block squeezed to 0.9",
                              column=str(nu))


def thickness():
    for layers in (1, 2, 3, 4, 6, 8):
        for faces in FACES:
            yield scenes.plate("thickness", f"plate of 20 mm, {layers} across, {'one face' if faces == 1 else 'both faces'} wet",
                               layers=layers, spacing=0.02 / layers, faces=faces, row="one face" if faces == 1 else "both faces",
                               column=str(layers))


def spacing():
    for ratio in (0.25, 0.5, 1, 1.5, 2, 2.5, 4):
        yield scenes.plate("spacing", f"structure over fluid {ratio:g}, four across, one face wet", spacing=ratio * scenes.FLUID_SPACING,
                           faces=1, layers=4, row="four across, one face", column=f"{ratio:g}")
    for ratio in (0.25, 0.5, 1):
        yield scenes.plate("spacing", f"structure over fluid {ratio:g}, 20 mm, both faces wet", spacing=ratio * scenes.FLUID_SPACING,
                           thickness=0.02, layers=round(2 / ratio), row="20 mm, both faces", column=f"{ratio:g}")


def steps():
    for value in (0.05, 0.15, 0.3, 0.5, 0.6):
        yield _set(scenes.column("steps", f"column that breaks, courant {value}", limits=LIVELY, row="fluid.courant", column=str(value)),
                   f"fluid.numerics.courant={value}")
    for value in (0.025, 0.1, 0.2, 0.35, 0.5, 0.6):
        yield _set(scenes.plate("steps", f"plate under water, gravity_courant {value}", row="fluid.gravity_courant", column=str(value),
                                until=0.2, tail=0.4 * value), f"fluid.numerics.gravity_courant={value}",
                   f"fluid.numerics.courant={min(value * 1.5, 0.5)}")
    for value in (0.1, 0.3, 0.6, 0.7):
        yield _set(scenes.plate("steps", f"plate under water, explicit, structure courant {value}", row="structure.courant",
                                column=str(value)),
                   f"structure.numerics.courant={value}", "structure.numerics.integrator=explicit")


def tolerance():
    for exponent in (12, 10, 8, 6, 4, 3, 2):
        for name, make in (("tank", scenes.tank), ("plate", scenes.plate)):
            yield _set(make("tolerance", f"{name}, pressure solved to 1e-{exponent}", row=name, column=f"1e-{exponent}"),
                       f"fluid.numerics.pressure_tolerance=1e-{exponent}")


def sealed():
    yield scenes.tank("sealed", "full tank, tilted", sealed=True, row="rigid", column="-")
    for ratio in (0.1, 1, 10):
        yield scenes.plate("sealed", f"full tank with a plate in it, density ratio {ratio}", sealed=True, ratio=ratio, row="plate inside",
                           column=str(ratio))
    for modulus in (1e5, 1e7, 1e9):
        yield scenes.plate("sealed", f"full tank on an elastic floor, E {modulus:g} Pa", sealed=True, faces=1, modulus=modulus,
                           row="elastic floor", column=f"{modulus:g}")


def spray():
    for speed in (2, 10, 50):
        until = 0.4 / speed
        yield scenes.drop("spray", f"drop at {speed} m/s on a pool", speed=speed, until=until, limits=LIVELY, row="drop on a pool",
                          column=str(speed))
        yield scenes.drop("spray", f"drop at {speed} m/s, elastic floor", speed=speed, until=until, modulus=1e7, limits=LIVELY,
                          row="elastic floor", column=str(speed))
    yield scenes.column("spray", "column that breaks against a wall", limits=LIVELY, row="column", column="wall")
    yield scenes.column("spray", "column that breaks against a plate", modulus=3.5e6, limits=LIVELY, row="column", column="plate")
    # Single particles decide where so light a body goes.
    for ratio, modulus in ((0.02, 1e6), (0.02, 1e5), (0.005, 1e6)):
        yield scenes.column("spray", f"column that breaks against a light flap, density ratio {ratio:g}, E {modulus:g} Pa", modulus=modulus,
                            density=ratio * scenes.WATER, layers=5, limits=LIVELY, row="light flap", column=f"{ratio:g}, E {modulus:g} Pa")


def compression():
    for material in ("neo_hookean", "st_venant_kirchhoff"):
        for left in (0.7, 0.5, 0.3, 0.1, 0.02):
            yield scenes.squeezed("compression", f"{material} squeezed to {left} of its height", left=left, material=material,
                                  limits=(20.0, 0.05, 0.05), row=material, column=str(left))


def rest():
    still = (0.0, -9.81)
    yield scenes.tank("rest", "water at rest for 40 sqrt(H/g)", gravity=still, until=40 * (scenes.DEPTH / 9.81) ** 0.5,
                      limits=(0.1, 0.01, 0.01), row="tank", column="40 sqrt(H/g)")
    yield scenes.plate("rest", "plate under water at rest for 20 sqrt(H/g)", gravity=still, until=20 * (scenes.DEPTH / 9.81) ** 0.5,
                       limits=(0.5, 0.05, 0.01), row="plate", column="20 sqrt(H/g)")
    yield scenes.plate("rest", "floor under water at rest for 20 sqrt(H/g)", gravity=still, faces=1,
                       until=20 * (scenes.DEPTH / 9.81) ** 0.5,
                       limits=(0.5, 0.05, 0.01), row="floor", column="20 sqrt(H/g)")


def weightless():
    none = (0.0, 0.0)
    yield scenes.tank("weightless", "water at rest without gravity", gravity=none, limits=(1e-6, 1e-6, 0.01), row="tank", column="at rest")
    yield scenes.tank("weightless", "water drifts against a wall", gravity=none, velocity=(0.5, 0.2), limits=LIVELY, row="tank",
                      column="drifting")
    yield scenes.plate("weightless", "plate and water at rest", gravity=none, limits=(1e-6, 1e-6, 0.01), row="plate", column="at rest")
    yield scenes.plate("weightless", "plate in water that drifts", gravity=none, velocity=(0.5, 0.2), row="plate", column="drifting")
    yield scenes.plate("weightless", "light plate in water that drifts", gravity=none, velocity=(0.5, 0.2), ratio=0.1, row="plate",
                       column="light")


def pairs():
    """Two at once, where one makes the other worse."""
    # A light wall that nothing can escape from: added mass without bound, and one pressure that is known only by the wall's yielding.
    yield scenes.plate("pairs", "sealed and light: full tank on a floor of density ratio 0.1", sealed=True, faces=1, ratio=0.1,
                       row="sealed, light")
    # The solver's error is a load that a light body follows at once.
    yield _set(scenes.plate("pairs", "light and loosely solved: density ratio 0.1, tolerance 1e-2", ratio=0.1, row="light, loose"),
               "fluid.numerics.pressure_tolerance=1e-2")
    # The longest windows with the lightest plate: most motions of the plate are not resolved.
    yield _set(scenes.plate("pairs", "light and long steps: density ratio 0.1, gravity_courant 0.3", ratio=0.1, tail=0.12,
                            row="light, long steps"),
               "fluid.numerics.gravity_courant=0.3")
    # Nearly incompressible on both sides, and thin.
    yield scenes.plate("pairs", "thin and incompressible: two across, Poisson's ratio 0.4999", layers=2, nu=0.4999,
                       row="thin, incompressible")
    # A violent load where two particles carry it.
    yield scenes.column("pairs", "spray on a soft thin plate: two across, E 1e5 Pa", modulus=1e5, layers=2, limits=LIVELY,
                        row="spray, thin, soft")
    # Strong compression of what cannot be compressed.
    yield scenes.squeezed("pairs", "squeezed and incompressible: to 0.5, Poisson's ratio 0.4999", left=0.5, nu=0.4999,
                          limits=(20.0, 0.05, 0.05),
                          row="squeezed, incompressible")
    # Without gravity nothing but the light plate holds the water.
    yield _set(scenes.plate("pairs", "weightless, light and loosely solved", gravity=(0.0, 0.0), velocity=(0.5, 0.2), ratio=0.1,
                            row="weightless, light, loose"), "fluid.numerics.pressure_tolerance=1e-2")


def three_dimensions():
    """Plates with water above them, and on both faces and around three edges; a cube with water all around."""
    for faces, place in ((1, "floor"), (2, "standing plate")):
        for ratio in RATIOS:
            yield scenes.plate_3d("three_dimensions", f"{place} in 3D, density ratio {ratio:g}", ratio=ratio, faces=faces, row=place,
                                  column=f"{ratio:g}")
        yield scenes.plate_3d("three_dimensions", f"{place} in 3D, density ratio 0.1, E 1e5 Pa", ratio=0.1, modulus=1e5, faces=faces,
                              row=f"{place}, soft", column="0.1")
        yield scenes.plate_3d("three_dimensions", f"{place} in 3D, density ratio 0.1, 2 across", ratio=0.1, layers=2, faces=faces,
                              row=f"{place}, thin", column="0.1")
        for ratio, coupling in ((0.1, "one pass"), (1, "repeated")):
            yield _set(scenes.plate_3d("three_dimensions", f"{place} in 3D, density ratio {ratio:g}, {coupling}", ratio=ratio, faces=faces,
                                       row=f"{place}, {coupling}", column=f"{ratio:g}"), COUPLINGS[coupling])
    for ratio in RATIOS:
        yield scenes.block_3d("three_dimensions", f"free cube in 3D, density ratio {ratio:g}", ratio=ratio, row="free cube",
                              column=f"{ratio:g}")


FAMILIES = {"plates": plates, "poisson": poisson, "thickness": thickness, "spacing": spacing, "steps": steps, "tolerance": tolerance,
            "sealed": sealed, "spray": spray, "compression": compression, "rest": rest, "weightless": weightless, "pairs": pairs,
            "three_dimensions": three_dimensions}

# Seconds all together; one of each kind of outcome and of most families, and the worst of each that is bounded.
QUICK = {
    "density ratio 0.1, 4 across, E 1e+07 Pa, one face wet, explicit", "density ratio 0.1, 4 across, E 1e+07 Pa, one face wet, repeated",
    "density ratio 0.01, 4 across, E 1e+09 Pa, both faces wet, repeated",
    "density ratio 10, 2 across, E 1e+07 Pa, both faces wet, explicit",
    "density ratio 1, 4 across, E 1e+07 Pa, both faces wet, one pass",
    "plate under water, Poisson's ratio 0.49999", "plate of 20 mm, 1 across, both faces wet",
    "structure over fluid 0.25, 20 mm, both faces wet",
    "column that breaks, courant 0.6", "plate, pressure solved to 1e-2", "full tank with a plate in it, density ratio 1",
    "drop at 10 m/s on a pool", "neo_hookean squeezed to 0.1 of its height", "st_venant_kirchhoff squeezed to 0.1 of its height",
    "water at rest without gravity", "floor under water at rest for 20 sqrt(H/g)", "structure over fluid 4, four across, one face wet",
    "light and loosely solved: density ratio 0.1, tolerance 1e-2", "standing plate in 3D, density ratio 1",
    "floor in 3D, density ratio 0.1, one pass",
}


@dataclass(frozen=True)
class Boundary:
    """Where one number ends to be possible, between a value that is bounded and one that is not."""

    family: str
    name: str
    unit: str
    bounded: float
    beyond: float
    make: Callable[[float], Cell]
    theory: str


def boundaries():
    """Looked for by bisection, with what theory says of them."""
    def piston(ratio):
        return _set(scenes.piston("boundary", f"piston, explicit, m_a/m_s {ratio:.4g}", ratio=ratio, allow_unstable=True),
                    "coupling.algorithm=explicit")

    def plate_density(coupling, layers, modulus):
        def make(ratio):
            cell = scenes.plate("boundary", f"plate under water, E {modulus:g} Pa, {layers} across, {coupling}, density ratio {ratio:.4g}",
                                ratio=ratio, layers=layers, modulus=modulus, allow_unstable=coupling == "explicit",
                                until=0.2 if coupling == "explicit" else 0.1)
            return cell if coupling == "default" else _set(cell, COUPLINGS[coupling])
        return make

    def gravity_courant(value):
        return _set(scenes.plate("boundary", f"plate under water, windows of {value:.4g} sqrt(dx/g)", until=0.2, tail=0.4 * value),
                    f"fluid.numerics.gravity_courant={value:.6g}", "fluid.numerics.courant=0.5")

    def structure_courant(value):
        return _set(scenes.plate("boundary", f"plate under water, explicit sub-steps of {value:.4g} dx_s/c_p"),
                    f"structure.numerics.courant={value:.6g}", "structure.numerics.integrator=explicit")

    def squeeze(left):
        return scenes.squeezed("boundary", f"st_venant_kirchhoff squeezed to {left:.4g}", left=left, material="st_venant_kirchhoff",
                               limits=(20.0, 0.05, 0.05))

    yield Boundary("boundary", "explicit coupling, largest added mass of a piston over the mass it answers with", "-", 0.3, 5.0, piston,
                   "1: the mismatch of the velocities is multiplied by minus this ratio in each window")
    yield Boundary("boundary", "explicit coupling, lightest stiff plate under water, 20 mm of 4 across, 1e9 Pa", "density ratio",
                   10.0, 0.05,
                   plate_density("explicit", 4, 1e9),
                   "2: added mass of 0.043 m of water, a ratio of 1")
    yield Boundary("boundary", "default, lightest plate under water of 2 across and 1e5 Pa", "density ratio", 1.0, 0.02,
                   plate_density("default", 2, 1e5),
                   "none: trials are repeated until they agree")
    yield Boundary("boundary", "longest windows, plate under water", "sqrt(dx/g)", 0.1, 0.5, gravity_courant,
                   "none: implicit in the pressure; 0.5 is the end of the range")
    yield Boundary("boundary", "explicit sub-steps of a plate under water", "dx_s/c_p", 0.3, 0.6, structure_courant,
                   "0.71 for central differences on a square lattice; the range ends at 0.6")
    yield Boundary("boundary", "St Venant-Kirchhoff, strongest squeeze", "height left", 0.8, 0.1, squeeze,
                   "0.58: its resistance is largest there and falls below, a block between clamps can go further")
