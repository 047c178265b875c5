"""The structure's side of a run: the loop of docs/PROTOCOL.md around a solver that only has to move a surface under a load.

    run_structure(MySolver)            # MySolver(case, options): case is side.Case, options the command line

A solver has
    state                              everything that changes; advance() puts another object in its place and leaves the old one alone
    properties()                       dict of body, section_mass, impedance, least_mass: one entry per surface point (Hello)
    surface()                          Surface of the present state
    advance(time_s, duration_s, force) to the end of the window that begins at time_s, under one force per surface point
                                       [N/m^(3-D)] that is constant over the window
    energies()                         dict of kinetic, strain, potential [J/m^(3-D)], and what it knows of diffusion and,
                                       in a case with loads, damping, load_work, clamp_work
    gauge(gauge)                       values of a displacement or reaction gauge of the case, None if it has none
    fields()                           dict for a frame: position, displacement, velocity of its points, and scalars of any name
and may have, if nothing holds one of its bodies,
    free_motions()                     of each body, in the present state: (centre of mass [m], its velocity [m/s], angular velocity
                                       [rad/s]) of the rigid body that has its momentum and angular momentum; None for a body that is
                                       held. The angular velocity is a number in 2D, a vector in 3D. The fluid is given that motion as
                                       it is at the end of a window; what else moves is followed by its mean (docs/THEORY.md, section 3)
and, so that a run with it can be continued from a checkpoint (./tern resume),
    save()                             dict of arrays by name from which it goes on after the present window, with the same bits
    restore(saved)                     goes back to what save() has given, in a solver that was just made
"""

import sys
from dataclasses import dataclass

import numpy

from tern.participant.frames import FrameWriter
from tern.participant.schema import wire
from tern.participant.side import TICKS_PER_SECOND, bad_input, finite, run_participant

_SURFACE = ("position", "velocity", "normal", "area")
SLACK = 0.05  # of faces that are cut evenly, and of a spacing that is stretched a little to fill the boxes of the fluid
LEFT = 0.2  # of a motion that windows do not resolve, from one to the next: see followed_velocity()


@dataclass
class Surface:
    """Points on the true faces of the bodies, one row each; the normal points out of the body and has length 1."""

    position: numpy.ndarray
    velocity: numpy.ndarray
    normal: numpy.ndarray
    area: numpy.ndarray


def cut_box(low, high, spacing, clamps=()):
    """(position, normal, area, thickness, wet faces) of the faces of a box in 2D, cut evenly into pieces of about `spacing`, but
    for what lies in the boxes `clamps`. Wet faces: 1 where the opposite face is clamped, else 2. Beside a fluid `spacing` is
    case.face_length(body)."""
    def held(x):
        return any(((a <= x) & (x <= b)).all() for a, b in clamps)

    rows = []
    for axis in (0, 1):
        across = 1 - axis
        count = max(1, round((high[across] - low[across]) / spacing))
        for side, corner in ((-1.0, low), (1.0, high)):
            for k in range(count):
                x, normal = numpy.array(corner, dtype=float), numpy.zeros(2)
                x[across] = low[across] + (k + 0.5) / count * (high[across] - low[across])
                normal[axis] = side
                thickness = high[axis] - low[axis]
                # A hair inside the opposite face: on it, whether a clamp contains the point would be a matter of round-off.
                if not held(x):
                    rows.append((x, normal, (high[across] - low[across]) / count, thickness,
                                 1 if held(x - (thickness - 1e-3 * spacing) * normal) else 2))
    if not rows:
        raise bad_input("No part of the body is free: its clamps contain all of its faces.")
    return tuple(numpy.array(column) for column in zip(*rows))


def followed_velocity(mean, given, own, ratio):
    """Velocity of the surface for the fluid at the end of a window, and the one of which the mean over the next window is made, from the
    mean in this window, those two at its begin, and the ratio of its length to that of the last one: the generalised-alpha method. A
    vibration that the window does not resolve may end it moving against the load; its mean velocity never does, so that the coupling is
    stable for every stiffness and mass
    (structure/coupled_structure.hpp, docs/THEORY.md section 3)."""
    alpha_m, alpha_f = (3 - LEFT) / (2 + 2 * LEFT), 1 / (1 + LEFT)
    gamma = 0.5 + alpha_m - alpha_f
    own = given + ratio * (own - given)
    new = (mean - (1 - gamma) * own) / gamma
    return ((1 - alpha_m) * own + alpha_m * new - (1 - alpha_f) * given) / alpha_f, new


def _rotation(spin):
    """W of an angular velocity: W x = spin x x."""
    if numpy.ndim(spin) == 0:
        return numpy.array([[0.0, -spin], [spin, 0.0]])
    x, y, z = spin
    return numpy.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


class _Coupled:
    """A predicted surface, then the load of the window: structure/coupled_structure.hpp."""

    def __init__(self, solver, explicit):
        self.solver, self._explicit = solver, explicit
        self._begin, self._state = solver.surface(), solver.state
        self._shape = numpy.shape(self._begin.position)
        self._check(self._begin)
        self._own_velocity, self._last_s = self._begin.velocity, 0.0  # length of the last window; 0: there was none
        self._body = numpy.asarray(solver.properties()["body"])
        self._free_motions = self._find_free_motions()
        self.load = numpy.zeros_like(self._begin.position)
        self.interface_work = 0.0

    def save(self):
        begin = {f"begin.{name}": getattr(self._begin, name) for name in _SURFACE}
        own = {f"solver.{name}": values for name, values in self.solver.save().items()}
        return begin | own | {"own_velocity": self._own_velocity, "last_s": self._last_s, "load": self.load,
                              "interface_work": self.interface_work}

    def restore(self, saved):
        self.solver.restore({name.removeprefix("solver."): values for name, values in saved.items() if name.startswith("solver.")})
        self._begin, self._state = Surface(*(saved[f"begin.{name}"] for name in _SURFACE)), self.solver.state
        self._own_velocity, self._last_s = saved["own_velocity"], float(saved["last_s"])
        self.load, self.interface_work = saved["load"], float(saved["interface_work"])
        self._free_motions = self._find_free_motions()

    def predict(self, begin_s, duration_s):
        """Halfway to the state under the load of the last window, with the velocity at its end. Explicit: the present surface moved
        on for half a window."""
        self._window = begin_s, duration_s
        begin = self._begin
        if self._explicit:
            return Surface(begin.position + 0.5 * duration_s * begin.velocity, begin.velocity, begin.normal, begin.area)
        end = self._advance(self.load)
        normal = begin.normal + end.normal
        return Surface(0.5 * (begin.position + end.position), self._followed(end)[0],
                       normal / numpy.linalg.norm(normal, axis=1)[:, None], 0.5 * (begin.area + end.area))

    def respond(self, load):
        """Implicit coupling: velocities at the end of the window under this load."""
        return self._followed(self._advance(load))[0]

    def apply(self, load):
        """Brings the solver to the end of the window under this load."""
        end = self._advance(load)
        self.interface_work += float((load * (end.position - self._begin.position)).sum())
        if not self._explicit:
            end.velocity, self._own_velocity = self._followed(end)
        self._begin, self._state, self.load, self._last_s = end, self.solver.state, load, self._window[1]
        self._free_motions = self._find_free_motions()

    def _advance(self, load):
        self.solver.state = self._state
        self.solver.advance(*self._window, load)
        end = self.solver.surface()
        self._check(end)
        return end

    def _check(self, surface):
        """Every array of a Surface has one row per point, and the points stay the same all along."""
        for name in _SURFACE:
            found, wanted = numpy.shape(getattr(surface, name)), self._shape[:1] if name == "area" else self._shape
            if found != wanted:
                raise bad_input(f"surface() gives {name} of shape {found}, but it has to be {wanted}: a row for each of the "
                                f"{self._shape[0]} points that it had at the start.")

    def _find_free_motions(self):
        """Of each body (centre, velocity, W with velocities W (x - centre) about it), or None; empty if the solver does not say."""
        motions = self.solver.free_motions() if hasattr(self.solver, "free_motions") else []
        return [motion and (*map(numpy.asarray, motion[:2]), _rotation(motion[2])) for motion in motions]

    def _followed(self, end):
        begin, duration_s = self._begin, self._window[1]
        mean, free_mean, free_begin, free_end = ((end.position - begin.position) / duration_s, *numpy.zeros((3, *self._shape)))
        for body, motions in enumerate(zip(self._free_motions, self._find_free_motions())):
            if None in motions:
                continue
            (centre, velocity, turn), (end_centre, end_velocity, end_turn) = motions
            of = self._body == body
            arm, end_arm = begin.position[of] - centre, end.position[of] - end_centre
            free_begin[of], free_end[of] = velocity + arm @ turn.T, end_velocity + end_arm @ end_turn.T
            free_mean[of] = (end_centre - centre) / duration_s + (arm + end_arm) @ (turn + end_turn).T / 4
        ratio = duration_s / self._last_s if self._last_s > 0 else 1.0
        given, own = followed_velocity(mean - free_mean, begin.velocity - free_begin, self._own_velocity - free_begin, ratio)
        return given + free_end, own + free_end


def _say_long_faces(run, surface):
    """Warns of faces that are longer than the particles of the fluid take for even (Case.face_length())."""
    case = run.case
    longest = max(surface.area) ** (1 / (case.dimension - 1))
    wanted = 0.5 * case.settings["fluid"]["spacing"]
    if longest > wanted * (1 + SLACK):
        run.warn(f"its largest face is {longest:.3g} m long, more than half a spacing of the fluid, {wanted:.3g} m: to the particles "
                 "that is no even face, and its load is noisy; cut_box() with case.face_length(body) makes shorter ones.")


def _has_loads(settings):
    """Whether energy.csv has the columns of loads, moving clamps and damping (scene/gauges.cpp)."""
    moving = ("displacement", "rotation", "motion_file")
    return bool(settings.get("load") or any(body.get("mass_damping", 0) > 0 for body in settings["body"])
                or any(key in clamp for clamp in settings.get("clamp", []) for key in moving))


def _obey(run, make_solver):
    case = run.case
    with run.timed("compute"):
        solver = make_solver(case, run.options)
        coupled = _Coupled(solver, case.settings["coupling"]["algorithm"] == "explicit")
    columns = ["kinetic", "strain", "potential", "diffusion", "interface_work"]
    columns += ["damping", "load_work", "clamp_work"] if _has_loads(case.settings["structure"]) else []
    frames = FrameWriter(run.options.out, "structure", case.dimension, anew=not run.resumes)
    written = -1
    saves = hasattr(solver, "save") and hasattr(solver, "restore")

    def account():
        energies = solver.energies() | {"interface_work": coupled.interface_work}
        return run.account({column: energies.get(column, 0.0) for column in columns}, solver.gauge)

    def write_frame():
        nonlocal written
        if written != run.report.steps:
            with run.timed("output"):
                frames.write(run.report.time_s, run.report.steps, solver.fields(),
                             {"surface_position": solver.surface().position, "surface_force": coupled.load})
            written = run.report.steps

    def flat(name, values):
        return finite(f"{name} of the surface", values, run.channel.step)

    def keep():
        return coupled.save() | {"frames": frames.mark(), "written": written}

    _say_long_faces(run, solver.surface())
    if not run.resumes:
        write_frame()
    properties = wire.SurfaceProperties(**{name: list(values) for name, values in solver.properties().items()})
    welcome = run.handshake(wire.Hello(particles=len(solver.fields()["position"]), account=account(), surface=properties), saves)
    if run.resumes:
        kept = run.restored(welcome)
        coupled.restore(kept)
        frames.go_back(kept["frames"])
        written = int(kept["written"])
    while (order := run.next_order(keep if saves else None)).WhichOneof("body") == "begin_window":
        window = order.begin_window
        with run.timed("compute"):
            at_begin = account()
            surface = coupled.predict(window.begin_ticks / TICKS_PER_SECOND, window.duration_ticks / TICKS_PER_SECOND)
        run.send(surface=wire.Surface(position=flat("position", surface.position), velocity=flat("velocity", surface.velocity),
                                      normal=flat("normal", surface.normal), area=flat("area", surface.area), account=at_begin))
        while (answer := run.receive("surface_load").surface_load).trial:
            with run.timed("compute"):
                velocity = coupled.respond(numpy.array(answer.force).reshape(-1, case.dimension))
            run.send(surface_velocity=wire.SurfaceVelocity(velocity=flat("velocity", velocity)))
        with run.timed("compute"):
            coupled.apply(numpy.array(answer.force).reshape(-1, case.dimension))
        run.step_done(order)
        if window.write_frame:
            write_frame()
    write_frame()
    run.finish(order, account())


def run_structure(make_solver, add_options=None):
    """The whole main() of a structure: ends the process. `add_options(parser)` may add options of the solver's own."""
    sys.exit(run_participant("structure", lambda run: _obey(run, make_solver), add_options))
