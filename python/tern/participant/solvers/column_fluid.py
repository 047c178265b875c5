#!/usr/bin/python3 -B
"""A fluid in closed form: a column of water of constant height on the upper faces of the structure, which move up and down as one.

    ./tern run tests/process/cases/rigid_piston --fluid "column_fluid.py --step 5e-5" \\
        --structure "rigid_spring.py --stiffness 2e7"

The pressure on the faces is p = rho h (g + a), a being the acceleration of the column. Over a window the column takes on the
velocity w' of the faces, a = (w' - w)/dt. The faces have moved by u under the load phat of the coupler's trial and yield to a
pressure in excess of it, w' = u - dt (p - phat)/m_p, so that

    p (1 + rho h/m_p) = rho h (g + (u - w)/dt + phat/m_p).

What the coupler makes of interface particles: it carries the pressure of each to a face by the weight of the water between, and with
coupling.scheme "pi" (or "fsa") the load on the face is its area times the mean of what is carried, weighted by the kernel,
provided that the particles fill at least three quarters of the kernel before it. So any particles will do that fill it and whose
carried pressures are p: here one particle per face at half a spacing, p - rho g dx/2, with four times the volume of the layer it
stands for, since at the end of a row only half of the kernel is before it. "riemann" does not divide by the filling and is refused.
"""

import numpy as np

from tern.participant import InterfaceParticles, bad_input, run_fluid


class ColumnFluid:
    iterations = 0

    def __init__(self, case, options):
        fluid = case.settings["fluid"]
        boxes = [body["shape"].get("box") for body in fluid["body"]]
        if len(boxes) != 1 or not boxes[0] or case.dimension != 2 or case.gravity[0] != 0:
            raise bad_input(f"{case.path}: a column is one box of fluid in 2D, under gravity along y.")
        if case.settings["coupling"]["scheme"] == "riemann":
            raise bad_input(f"{case.path}: coupling.scheme is \"riemann\"; a column needs \"pi\" or \"fsa\", which give a face the mean "
                            "of the pressures before it.")
        low, high = (np.array(boxes[0][side]) for side in ("min", "max"))
        self.density, self.spacing, self.gravity, self.step = fluid["density"], fluid["spacing"], -case.gravity[1], options.step
        self.top, (self.width, self.height) = high[1], high - low
        along = np.arange(low[0] + self.spacing / 2, high[0], self.spacing)
        self.position = np.column_stack([along, np.full_like(along, low[1] + self.spacing / 2)])  # until the faces are known
        self.rise, self.velocity, self.pressure = 0.0, 0.0, self.density * self.gravity * self.height

    def propose_step(self):
        return self.step, "given"

    def begin_window(self, time_s, duration_s):
        self.duration = duration_s

    def see_surface(self, surface):
        self.wet = surface.normal[:, 1] > 0.5
        self.area, self.trial, self.normal = surface.area[self.wet], surface.velocity[self.wet], surface.normal[self.wet]
        self.position = surface.position[self.wet] + self.spacing / 2 * surface.normal[self.wet]
        volume = 4 * self.area * self.spacing
        return InterfaceParticles(np.arange(len(volume)), self.position, self.trial, self.density * volume, volume, np.zeros(len(volume)))

    def solve_pressure(self, load):
        if load.surface_velocity:
            self.trial = np.array(load.surface_velocity).reshape(-1, 2)[self.wet]
        self.dissipative = np.array(load.force).reshape(-1, 2)
        mean = lambda values: float((self.area * np.array(values)).sum() / self.area.sum())  # noqa: E731
        yielding = mean(self.faster_by(load, np.ones(len(self.area))))
        carried = mean(np.array(load.reference_pressure)[self.wet])
        mass = self.density * self.height
        self.pressure = mass * (self.gravity + (mean(self.trial[:, 1]) - self.velocity) / self.duration + yielding * carried)
        self.pressure /= 1 + mass * yielding
        return np.full(len(self.area), self.pressure - self.density * self.gravity * self.spacing / 2), self.trial

    def faster_by(self, load, pressure):
        """Into the body, along the normals of the wet faces, under these pressures for one second (THEORY, section 3) [m/s]."""
        if not load.lump:
            return np.zeros(len(pressure))
        lump = np.array(load.lump, int).reshape(len(self.wet), -1)[self.wet]
        share = np.array(load.share).reshape(len(self.wet), -1)[self.wet]
        motion = np.zeros((len(load.lump_mass), 2))
        force = (self.area * pressure)[:, None] * self.normal
        np.add.at(motion, lump, share[:, :, None] * force[:, None, :])
        motion /= np.array(load.lump_mass)[:, None]
        return ((share[:, :, None] * motion[lump]).sum(1) * self.normal).sum(1)

    def end_window(self, force):
        # The column takes the force it is given, so that no momentum is lost between the two sides.
        before, weight = self.velocity, self.density * self.height * self.width
        self.velocity += self.duration * ((force + self.dissipative)[:, 1].sum() / weight - self.gravity)
        self.rise += self.duration * (before + self.velocity) / 2

    def save(self):
        return {"rise": self.rise, "velocity": self.velocity, "pressure": self.pressure, "position": self.position}

    def restore(self, saved):
        self.rise, self.velocity, self.pressure = (float(saved[name]) for name in ("rise", "velocity", "pressure"))
        self.position = saved["position"]

    def energies(self):
        mass = self.density * self.height * self.width
        return mass * self.velocity**2 / 2, mass * self.gravity * self.rise

    def gauge(self, gauge):
        return [self.top + self.rise] if gauge["kind"] == "elevation" else None

    def fields(self):
        count = len(self.position)
        return {"position": self.position, "velocity": np.tile([0.0, self.velocity], (count, 1)), "pressure": np.full(count, self.pressure)}


run_fluid(ColumnFluid, lambda parser: parser.add_argument("--step", type=float, required=True, help="length of the windows [s]"))
