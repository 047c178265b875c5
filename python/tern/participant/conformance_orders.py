"""What the stand-in of ./tern conform orders a participant to do. Loads and motions are small: the scene stays where it is."""

import numpy

from tern.participant.conformance_session import Breach
from tern.participant.schema import wire

class StructureOrders:
    """Windows for a structure: loads along the normals that would change the velocity by up to 1.5 cm/s, if nothing held the surface. On
    faces that look towards larger coordinates they are larger, as the same pressure all around a body that is rigid would not move it."""

    def __init__(self, session):
        self.session = session
        hello = session.start()
        session.welcome(len(hello.surface.body))
        self.duration_s = 2.0**-11
        self.mass = numpy.array(hello.surface.section_mass)

    def load(self, surface, factor):
        normal = numpy.array(surface.normal).reshape(-1, self.session.dimension)
        uneven = 1 + 0.5 * normal.sum(axis=1) / self.session.dimension**0.5
        pressure = factor * 0.01 * self.mass / self.duration_s * numpy.array(surface.area) * uneven
        return wire.SurfaceLoad(force=(-pressure[:, None] * normal).ravel())

    def begin(self, write_frame=False):
        self.session.begin(self.duration_s, write_frame)
        return self.session.receive("surface", paragraph="3.3.2").surface

    def first_message(self):
        """A window's begin, and the message that is due then."""
        return {"surface_load": self.load(self.begin(), 1.0)}

    def trial(self, surface, factor):
        load = self.load(surface, factor)
        load.trial = True
        self.session.send(surface_load=load)
        velocity = self.session.receive("surface_velocity", paragraph="3.3.6").surface_velocity.velocity
        return numpy.array(velocity).reshape(-1, self.session.dimension)

    def window(self, factor=1.0, trials=(), write_frame=False):
        """One window; returns its surface and the answers to the trials."""
        surface = self.begin(write_frame)
        answers = [self.trial(surface, trial) for trial in trials]
        self.session.send(surface_load=self.load(surface, factor))
        return surface, answers

    def state(self):
        """Something of the state at the begin of a window that is compared between two lives."""
        surface = self.begin()
        self.session.send(surface_load=self.load(surface, 0.0))
        return numpy.array(surface.position)

    def sense(self):
        """More load along a direction moves the surface more along it."""
        surface = self.begin()
        still, pressed = self.trial(surface, 0.0), self.trial(surface, 1.0)
        self.session.send(surface_load=self.load(surface, 0.0))
        force = numpy.array(self.load(surface, 1.0).force).reshape(-1, self.session.dimension)
        if not numpy.sum(force * (pressed - still)) > 0:
            raise Breach("4, SurfaceLoad", "a load along -normal does not move the surface along -normal")

    trial_tolerance = 1e-9
    trial_unit = "m/s"


class FluidOrders:
    """Windows for a fluid beside the surface that the case's own structure has at rest."""

    def __init__(self, session):
        self.session = session
        hello = session.start()
        self.duration_s = hello.proposed_step_s
        self.rest, self.mass = session.surface_at_rest
        session.welcome(len(self.rest.area))

    def begin(self, write_frame=False):
        self.session.begin(self.duration_s, write_frame)

    def first_message(self):
        self.begin()
        return {"surface": self.rest}

    def solve(self, velocity=None, repeats=True):
        points, dimension = len(self.rest.area), self.session.dimension
        load = wire.InterfaceCondition(force=[0.0] * (dimension * self.session.interface_particles), reference_pressure=[0.0] * points,
                                       lump=range(points), share=[1.0] * points, lump_mass=self.mass * numpy.array(self.rest.area),
                                       repeats=repeats)
        if velocity is not None:
            load.surface_velocity.extend(velocity * numpy.array(self.rest.normal))
        self.session.send(interface_condition=load)
        return numpy.array(self.session.receive("interface_pressure", paragraph="3.3.6").interface_pressure.pressure)

    def window(self, factor=1.0, trials=(), write_frame=False):
        """One window; `trials` are velocities of the surface along its normals [cm/s]."""
        del factor
        self.begin(write_frame)
        self.session.send(surface=self.rest)
        particles = self.session.receive("interface_particles", paragraph="3.3.4").interface_particles
        if not particles.id:
            raise Breach("4, InterfaceParticles", "no interface particle; the case must have fluid beside its structure")
        first = self.solve(repeats=bool(trials))
        answers = [self.solve(0.01 * trial) for trial in trials] or [first]
        self.session.send(interface_force=wire.InterfaceForce(force=[0.0] * len(particles.position)))
        self.end()
        return particles, answers

    def end(self):
        self.done = self.session.receive("window_done", paragraph="3.3.9").window_done
        self.duration_s = self.done.proposed_step_s

    def state(self):
        return numpy.array(self.window()[0].position)

    def sense(self):
        """A surface that moves into the fluid raises its pressure."""
        _, (still, pushed) = self.window(trials=(0.0, 1.0))
        if not numpy.sum(pushed - still) > 0:
            raise Breach("4, InterfaceCondition", "a surface that moves along its normal, into the fluid, does not raise the pressure")

    trial_tolerance = 1e-3  # a pressure is solved to a tolerance, from another first guess
    trial_unit = "Pa"


ORDERS = {"structure": StructureOrders, "fluid": FluidOrders}
