"""Checks of ./tern conform that look at what a structure makes of a load that differs from point to point and from component to
component: does it move along with it on every face, and do the work and the energies of its account tell of that very load.

The checks of work and energy look at one life. Between its windows lie short ones, whose surface is that of the end of the window before
them: so force times displacement is known without the velocity, whatever vibrates within a window.
"""

from dataclasses import dataclass

import numpy

from tern.participant.conformance_motion import HELD, LONG_S, PUSH, TOO_LITTLE
from tern.participant.conformance_orders import StructureOrders
from tern.participant.conformance_session import Breach
from tern.participant.schema import wire

ROUNDS, TRIALS = 5, 4  # of windows, and of trials, with a load of each kind
BETWEEN = 2.0**-10     # of the length of a window: a short one
SEED = 1
INEXACT = 0.05         # of the work of a kind of load (root of the mean square): what the account may be off, window by window
UNEXPLAINED = 0.1      # of the largest energy or work: what may be gained beside the work
# The columns that are energy; of the others, those that are work beside that of the interface.
ENERGIES = ("structure_kinetic", "structure_strain", "structure_potential", "structure_diffusion", "structure_damping")
OTHER_WORKS = ("load_work", "clamp_work")


class Pattern:
    """Loads that would give the mass behind each point a random part of the velocity PUSH in a window, in a random sense. Kinds of load:
    on all points along all axes or along one, and on those faces only that look one way."""

    def __init__(self, surface, mass, duration_s, dimension):
        self._random = numpy.random.default_rng(SEED)
        most = numpy.where(mass < HELD, mass, 0.0) * numpy.array(surface.area) * PUSH / duration_s
        normal = numpy.array(surface.normal).reshape(-1, dimension)
        axis = abs(normal).argmax(axis=1)
        sign = numpy.sign(normal[numpy.arange(len(axis)), axis])
        axes = numpy.eye(dimension)
        along = {f"all points along {'xyz'[a]}": most[:, None] * axes[a] for a in range(dimension)}
        faces = {f"the faces that look along {name}{'xyz'[a]}": most[:, None] * ((axis == a) & (sign == way))[:, None] + 0 * normal
                 for a in range(dimension) for name, way in (("-", -1), ("+", 1))}
        self.one_axis = set(along)  # a body that is guided need not move
        self._kinds = {"all points": most[:, None] + 0 * normal} | along | faces
        self.kinds = [kind for kind, load in self._kinds.items() if load.any()]

    def force(self, kind):
        most = self._kinds[kind]
        return most * self._random.uniform(0.25, 1.0, most.shape) * self._random.choice((-1.0, 1.0), most.shape)


@dataclass
class Loaded:
    """Arrays with one entry per window that is not short."""

    kind: numpy.ndarray    # of its load, by name
    done: numpy.ndarray    # force times displacement
    told: numpy.ndarray    # what the work of the account grows by
    energy: numpy.ndarray  # at the end, since the begin of the first
    work: numpy.ndarray    # of the interface and all else, as told, since then


def _start(s):
    """The orders, and the length of a window."""
    orders = StructureOrders(s)
    proposed_s = s.hello.proposed_step_s
    return orders, min(LONG_S, proposed_s) if proposed_s > 0 else LONG_S


def _work_column(s):
    columns = s.subject.scene["account"]["structure"]["energy"]
    return next((n, name) for n, name in enumerate(columns) if name.startswith("interface_work"))


def _lead(s):
    orders, long_s = _start(s)
    columns = s.subject.scene["account"]["structure"]["energy"]
    at_interface, _ = _work_column(s)
    energies = [n for n, name in enumerate(columns) if name.startswith(ENERGIES)]
    works = [at_interface, *(n for n, name in enumerate(columns) if name.startswith(OTHER_WORKS))]

    def window(duration_s, force):
        """Position and account.energy of the Surface, and the load of the window."""
        orders.duration_s = duration_s
        surface = orders.begin()
        position = numpy.array(surface.position).reshape(-1, s.dimension)
        force = 0 * position if force is None else force
        s.send(surface_load=wire.SurfaceLoad(force=force.ravel()))
        return surface, position, numpy.array(surface.account.energy)

    surface, before, first = window(BETWEEN * long_s, None)
    pattern, rows = Pattern(surface, orders.mass, long_s, s.dimension), []
    for kind in ROUNDS * pattern.kinds:
        force = pattern.force(kind)
        _, _, begin = window(long_s, force)
        _, position, end = window(BETWEEN * long_s, force)
        rows.append((kind, (force * (position - before)).sum(), (end - begin)[at_interface],
                     (end - first)[energies].sum(), (end - first)[works].sum()))
        before = position
    return Loaded(*(numpy.array(column) for column in zip(*rows)))


def _life(s):
    if "loaded" not in s.subject.lives:
        s.subject.lives["loaded"] = _lead(s)
    return s.subject.lives["loaded"]


def _size(values):
    return numpy.sqrt((values**2).mean())


def moves_along_with_the_load(s):
    """moves along with a load that differs from point to point, on all faces and on those that look one way"""
    orders, orders.duration_s = _start(s)
    surface = orders.begin()
    pattern = Pattern(surface, orders.mass, orders.duration_s, s.dimension)

    def answer(force):
        s.send(surface_load=wire.SurfaceLoad(force=force.ravel(), trial=True))
        velocity = s.receive("surface_velocity", paragraph="3.3.6").surface_velocity.velocity
        return numpy.array(velocity).reshape(-1, s.dimension)

    kinds = TRIALS * pattern.kinds
    forces = [pattern.force(kind) for kind in kinds]
    still = answer(0 * forces[0])
    gained = [answer(force) - still for force in forces]
    largest = max(abs(velocity).max() for velocity in gained)
    for kind, force, velocity in zip(kinds, forces, gained):
        along, nothing = (force * velocity).sum(), TOO_LITTLE * abs(force).sum() * largest
        if along < -nothing:
            raise Breach("4, SurfaceLoad", f"under a load on {kind}, which differs from point to point, the surface moves against the "
                         f"load: the sum over the points of force times the velocity that it adds is {along:.3g} W, and above 0 for "
                         "whatever the structure may be made of. Are points or components exchanged, or left out?")
        if along <= nothing and kind not in pattern.one_axis:
            raise Breach("4, SurfaceLoad", f"a load on {kind} moves nothing: the sum over the points of force times the velocity that it "
                         f"adds is {along:.3g} W, where other loads change the velocity by up to {largest:.3g} m/s. Are its points left "
                         "out?")


def accounts_for_the_work(s):
    """accounts for the work of the load: force times displacement, summed over the points"""
    life, (column, name) = _life(s), _work_column(s)
    for kind in dict.fromkeys(life.kind):
        told, done = (values[life.kind == kind] for values in (life.told, life.done))
        off, size = _size(told - done), _size(done)
        if off > INEXACT * size + TOO_LITTLE * _size(life.done):
            factor = (told @ done) / max(done @ done, 1e-300)
            raise Breach("4, Account", f"energy[{column}], {name}, is not the sum over the points of the given force times the "
                         f"displacement in the window: under loads on {kind} it grows by {_size(told):.3g} J in a window where that sum "
                         f"is {size:.3g} J (roots of the mean square; {factor:.3g} times it, and {off / max(size, 1e-300):.2g} of it "
                         "off, window by window)")


def gains_no_energy_of_its_own(s):
    """gains no more energy than the work that is done on it"""
    if any(isinstance(component, str) for component in s.subject.scene["settings"]["gravity"]):
        return  # under a gravity that changes, potential energy is not kept
    life = _life(s)
    gained = life.energy - life.work
    worst = int(gained.argmax())
    if gained[worst] > UNEXPLAINED * max(abs(life.energy).max(), abs(life.work).max()):
        raise Breach("4, Account", f"the energies of the account have grown by {life.energy[worst]:.3g} J in {worst + 1} windows, and its "
                     f"works by {life.work[worst]:.3g} J: the structure moves under more than the load that it accounts for, or an "
                     "energy is too large")
