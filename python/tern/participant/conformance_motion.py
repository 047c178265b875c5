"""Checks of ./tern conform that look at what the numbers of a structure mean: is the surface that of the case's bodies, does it go
where its velocity says, under the load it was given, and does the account tell of that. (And of any participant: its heartbeats.)

Most of them look at one life of the participant, which is led once: windows of alternating length, without load at first, then under a
constant load in one direction. Every load is tried before it is final, so that the velocity at the end of each window is known.
"""

import functools
from dataclasses import dataclass

import numpy

from tern.participant import shapes
from tern.participant.conformance_orders import StructureOrders
from tern.participant.conformance_session import Breach
from tern.participant.schema import wire

LONG_S, SHORT = 2.0**-11, 0.4  # of two windows one is shorter, by this factor
UNLOADED, WINDOWS = 3, 40
PUSH = 0.02         # velocity that the load gives in a long window [m/s]
HELD = 1e12         # section_mass of a point that does not move
HEARTBEAT_S = 3.0   # three intervals of 1.6
ASTRAY = 0.1        # of a way through all windows: what velocity and position may differ by, if the windows resolve the motion:
STEADY = 0.05       # if this part of it at most is left then
TOO_LITTLE = 1e-9   # of the largest motion: a point that moves less does not move


@dataclass
class Life:
    """Arrays with one entry per window, and in it one row per point."""

    dimension: int
    mass: numpy.ndarray
    body: numpy.ndarray
    hello: object             # account
    accounts: list            # of each Surface
    duration: numpy.ndarray
    position: numpy.ndarray
    velocity: numpy.ndarray   # of Surface
    repeated: numpy.ndarray   # SurfaceVelocity under the same load
    at_end: numpy.ndarray     # SurfaceVelocity under the load of the window
    force: numpy.ndarray
    released: numpy.ndarray   # SurfaceVelocity without load in the window after the first push
    normal: numpy.ndarray     # in the first window, as area
    area: numpy.ndarray

    def ways(self, share):
        """Ways in the trial and in the window, where a mean velocity is this share of that at the end, and the rest of that at the
        begin; from the second window on, because the velocity at the begin of the first is not known."""
        before, dt = self.at_end[:-1], self.duration[1:, None, None]
        return tuple(dt * ((1 - share) * before + share * end) for end in (self.velocity[1:], self.at_end[1:]))

    @functools.cached_property
    def share(self):
        """The share that fits best: 1/2 for an even acceleration."""
        shares = numpy.arange(181) / 180
        return shares[numpy.argmin([self.fit(share)[1] for share in shares])]

    def fit(self, share):
        """The motion from surface to surface is `factor` times what the velocities say, and the surface is `part` of the way through the
        window: ((factor, part), what is left of the motion)."""
        trial, way = self.ways(share)
        return _fit(numpy.diff(self.position[1:], axis=0), way[:-1], numpy.diff(trial, axis=0))

    def begin(self):
        """What is known of the position at the begin of a window, and of the ways in the trial and in the window."""
        trial, way = self.ways(self.share)
        return self.position[1:] - 0.5 * trial, trial, way


def _lead(s, windows, pushed):
    """A life of so many windows; `pushed`: with the load after the first ones."""
    orders = StructureOrders(s)
    dimension, hello = s.dimension, s.hello
    long_s = min(LONG_S, hello.proposed_step_s) if hello.proposed_step_s > 0 else LONG_S
    mass = numpy.array(hello.surface.section_mass)
    rows, accounts, released, first, last = [], [], None, None, None
    for n in range(windows):
        orders.duration_s = long_s * (SHORT if n % 2 else 1.0)
        surface = orders.begin()
        position, velocity = (numpy.array(values).reshape(-1, dimension) for values in (surface.position, surface.velocity))
        if n == 0:
            first = surface
            along = numpy.where(mass < HELD, mass, 0.0) * numpy.array(surface.area) * PUSH / long_s
            push = along[:, None] * numpy.full(dimension, dimension**-0.5)
            last = 0 * push

        def answer(force):
            s.send(surface_load=wire.SurfaceLoad(force=force.ravel(), trial=True))
            velocity = s.receive("surface_velocity", paragraph="3.3.6").surface_velocity.velocity
            return numpy.array(velocity).reshape(-1, dimension)

        if n == UNLOADED + 1:
            released = answer(0 * push)
        force = push if pushed and n >= UNLOADED else 0 * push
        repeated = answer(last)
        at_end = repeated if (force == last).all() else answer(force)
        s.send(surface_load=wire.SurfaceLoad(force=force.ravel()))
        ticks = max(1, round(orders.duration_s * 2**32))
        rows.append((ticks / 2**32, position, velocity, repeated, at_end, force))
        accounts.append(surface.account)
        last = force
    columns = [numpy.array(column) for column in zip(*rows)]
    return Life(dimension, mass, numpy.array(hello.surface.body), hello.account, accounts, *columns, released,
                numpy.array(first.normal).reshape(-1, dimension), numpy.array(first.area))


def _life(s):
    if "pushed" not in s.subject.lives:
        s.subject.lives["pushed"] = _lead(s, WINDOWS, True)
    return s.subject.lives["pushed"]


def _written(vector):
    return "(" + ", ".join(f"{value:.3g}" for value in vector) + ")"


def _fit(target, *columns):
    """Least squares over everything: the factor of each column, and the part of the target that is left."""
    matrix = numpy.column_stack([column.ravel() for column in columns])
    factors = numpy.linalg.lstsq(matrix, target.ravel(), rcond=None)[0]
    left = target.ravel() - matrix @ factors
    return factors, numpy.sqrt((left**2).sum() / max((target**2).sum(), 1e-300))


def sends_heartbeats(s):
    """sends heartbeats, so that a frozen coupler or a cut network is noticed"""
    s.start(relayed=True)
    if not s.relay.pinged.wait(HEARTBEAT_S):
        raise Breach("1.6", f"no heartbeat within {HEARTBEAT_S:g} s; ZMQ_HEARTBEAT_IVL must be 1 s, or a peer that freezes is not noticed")


def has_the_shape_of_the_case(s):
    """has the surface of the case's bodies at the start, with normals that point out of them"""
    life = _life(s)
    bodies, index = s.subject.scene["settings"]["structure"]["body"], life.body
    for number, body in enumerate(bodies):
        own = numpy.flatnonzero(index == number)
        if not len(own):
            continue
        x, n, shape = life.position[0][own], life.normal[own], body["shape"]
        distance = shapes.signed_distance(shape, x)
        limit = body["spacing"] + life.duration[0] * numpy.linalg.norm(life.velocity[0][own], axis=1)
        worst = int((abs(distance) - limit).argmax())
        if abs(distance[worst]) > limit[worst]:
            raise Breach("5.6", f"position[{own[worst]}] = {_written(x[worst])} is {abs(distance[worst]):.3g} m "
                         f"{'outside' if distance[worst] > 0 else 'inside'} the shape of the body '{body['name']}'; "
                         f"at the start it must lie on it to {limit[worst]:.3g} m")
        step = 0.01 * body["spacing"]
        cosine = (shapes.signed_distance(shape, x + step * n) - shapes.signed_distance(shape, x - step * n)) / (2 * step)
        worst = int(cosine.argmin())
        if cosine[worst] < -0.5:
            raise Breach("5.6", f"normal[{own[worst]}] = {_written(n[worst])} points into the body '{body['name']}'; "
                                "it must point out of it, into the fluid")
        low, high = shapes.bounds(shape)
        sides = high - low
        largest = 2 * sum(numpy.prod(numpy.delete(sides, axis)) for axis in range(s.dimension))  # of a box around it
        total = life.area[own].sum()
        if not 0.005 * largest <= total <= 2 * largest:
            raise Breach("5.6", f"the sum of area over the body '{body['name']}' is {total:.3g}; the box around its shape "
                                f"has {largest:.3g}")


def keeps_the_last_load(s):
    """ends a window under the last load it got for it"""
    life = _life(s)
    s.vanish()  # its address is needed once more
    with s.another_life() as second:
        unpushed = _lead(second, UNLOADED + 2, False)
    changed = abs(life.released - unpushed.released).max()
    size = abs(life.at_end[UNLOADED] - life.repeated[UNLOADED]).max()
    if changed <= 1e-3 * size:
        raise Breach("3.3.8", f"the last load of window {UNLOADED + 1} has no effect: in the window after it the surface answers "
                              f"as if that load had been 0 (to {changed:.3g} m/s; its trial had changed the velocity by {size:.3g} m/s)")


def answers_the_last_load_as_its_surface(s):
    """gives in Surface what it answers to a trial of the same load"""
    life = _life(s)
    difference = abs(life.velocity - life.repeated).max(axis=2)
    size = numpy.linalg.norm(life.velocity[1:] - life.at_end[:-1], axis=2).max()
    window, point = numpy.unravel_index(difference.argmax(), difference.shape)
    if difference[window, point] > 1e-3 * size + 1e-12:
        raise Breach("3.3.2", f"velocity of Surface at point {point} is {_written(life.velocity[window, point])} m/s in window "
                     f"{window + 1}, and SurfaceVelocity under the same load {_written(life.repeated[window, point])} m/s; both are of "
                     "the end of the window under the load of the window before")


def _moves(life):
    """Motions from one window's begin to the next, and what the velocities say; without the points that are held."""
    begin, _, carried = life.begin()
    return begin[1:] - begin[:-1], carried[:-1]


def goes_where_its_velocity_says(s):
    """goes where its velocity carries it, every point"""
    life = _life(s)
    moved, carried = _moves(life)
    free = life.mass < HELD
    way = numpy.linalg.norm(life.position[-1] - life.position[0], axis=1)
    still = free & (way <= TOO_LITTLE * way.max())
    if way.max() == 0 or still.any():
        point = int(still.argmax())
        raise Breach("4, Surface", f"position of point {point} does not move under the load while others move by up to {way.max():.3g} m; "
                                   f"a point that is held has a section_mass of {HELD:g}")
    # Of every point, over all windows; what is small beside the fastest point's motion is not looked at.
    wrong, size = ((values**2).sum(axis=(0, 2)) for values in (moved - carried, moved))
    size = size + (carried**2).sum(axis=(0, 2))
    excess = wrong / (0.25 * size + 1e-6 * size.max())
    point = int(excess.argmax())
    if excess[point] > 1:
        raise Breach("4, Surface", f"position and velocity of point {point} do not belong together: in {len(moved)} windows it moved by "
                     f"{_written(moved[:, point].sum(axis=0))} m, and its velocity carries it by "
                     f"{_written(carried[:, point].sum(axis=0))} m (window by window they differ by "
                     f"{numpy.sqrt(wrong[point] / size[point]):.2g} of their size)")
    (factor,), left = _fit(moved, carried)
    if not 0.75 < factor < 1.25 or left > 0.5:
        raise Breach("4, Surface", f"the surface moves {factor:.3g} times as far as its velocity says ({left:.2g} of its motion does not "
                                   "follow it at all); the factor must be between 0.75 and 1.25")
    # All the way from the begin: what a mixture of velocities leaves out in one window it makes up for in the next.
    (factor,), left = _fit(*(values.cumsum(axis=0) for values in (moved, carried)))
    if abs(factor - 1) > ASTRAY and left < STEADY:
        raise Breach("4, Surface", f"in {len(moved)} windows the surface moves {factor:.3g} times as far as its velocity carries it; the "
                                   f"factor must be within {ASTRAY:g} of 1. Is its window as long as BeginWindow says?")


def _moving_life(s):
    """The life, where positions and velocities belong together; without that nothing else that moves can be judged."""
    life = _life(s)
    try:
        goes_where_its_velocity_says(s)
    except Breach as breach:
        raise Breach(breach.paragraph, "not to be judged, because position and velocity do not belong together (the check "
                                       "motion)") from None
    return life


def is_halfway_through_the_window(s):
    """sends its position halfway through the window"""
    life = _moving_life(s)
    (factor, part), _ = life.fit(life.share)
    if not 0.25 < part < 0.75:
        where = "the begin" if part <= 0.25 else "the end"
        raise Breach("4, Surface", f"position is that of {where} of the window ({part:.2f} of the way through it, as windows of different "
                                   f"length show; the surface moves {factor:.2f} times as far as its velocity says); it must "
                                   "be halfway, 0.5")


def _displacement_gauges(s, life):
    """(name, what it told, motion of the surface beside it since then, trial's motion) of the displacement gauges near a surface point;
    the arrays have a row for every window and a column for every component."""
    settings, columns = s.subject.scene["settings"], s.subject.scene["account"]["structure"]["gauge"]
    names = [body["name"] for body in settings["structure"]["body"]]
    begin, trial, _ = life.begin()
    for gauge in settings.get("gauge", []):
        if gauge["kind"] != "displacement" or gauge.get("body", names[0]) not in names:
            continue
        number = names.index(gauge.get("body", names[0]))
        distance = numpy.linalg.norm(life.position[0] - numpy.array(gauge["at"]), axis=1)
        distance[life.body != number] = numpy.inf
        if distance.min() > 2 * settings["structure"]["body"][number]["spacing"]:
            continue
        near = distance <= 1.1 * distance.min()  # all that are the nearest: a tip turns as well
        axes = [axis for axis, letter in enumerate("xyz"[:s.dimension]) if f"{gauge['name']}.u{letter}_m" in columns]
        entries = [columns.index(f"{gauge['name']}.u{'xyz'[axis]}_m") for axis in axes]
        told = numpy.array([[account.gauge[entry] for entry in entries] for account in life.accounts[1:]])
        moved, ahead = ((values[:, near].mean(axis=1))[:, axes] for values in (begin - begin[0], trial - trial[0]))
        if axes and abs(moved).max() > 1e-3 * abs(begin - begin[0]).max():
            yield gauge["name"], told - told[0], moved, ahead


def accounts_for_the_begin(s):
    """accounts in Surface for the begin of the window"""
    life = _life(s)
    hello, first = life.hello, life.accounts[0]
    for field in ("energy", "gauge"):
        for entry, (said, again) in enumerate(zip(getattr(hello, field), getattr(first, field))):
            if abs(said - again) > 1e-9 * max(abs(said), abs(again)):
                raise Breach("4, Surface", f"account.{field}[{entry}] of the first window is {again:.9g}, and {said:.9g} in Hello; both "
                                           "are of t = 0: the account is that of the begin of the window, before the trial")
    for name, told, moved, ahead in _displacement_gauges(s, _moving_life(s)):
        (_, part), _ = _fit(*(numpy.diff(values, axis=0) for values in (told, moved, ahead)))
        if not -0.75 < part < 0.75:
            raise Breach("4, Surface", f"account.gauge of '{name}' is not that of the begin of the window but {part:.2f} of a window later")


def gauges_its_own_motion(s):
    """reports displacements that are those of the surface beside the gauge"""
    life = _moving_life(s)
    for name, told, moved, _ in _displacement_gauges(s, life):
        (factor,), _ = _fit(told, moved)
        if not 0.5 < factor < 2:
            raise Breach("4, Account", f"the gauge '{name}' changes by {_written(told[-1])} m where the surface beside it moves by "
                                       f"{_written(moved[-1])} m ({factor:.3g} times it, window by window)")
