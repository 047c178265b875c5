#!/usr/bin/python3 -B
"""A structure that moves as told, whatever the load: a rigid box displaced by expressions in t.

    ./tern run CASE --structure "prescribed_motion.py --y '0.002*sin(50*t)'"

It answers no pressure, so it reports a mass beyond all fluid: the coupler then tells the fluid that the faces do not yield.
"""

import numpy as np

from tern.errors import ReductionError
from tern.expression import compile_expression
from tern.participant import Surface, bad_input, cut_box, run_structure


class PrescribedMotion:
    def __init__(self, case, options):
        low, high = case.body_box()
        self.position, self.normal, self.area, _, _ = cut_box(low, high, case.face_length(case.only_body()))
        try:
            self.components = [compile_expression(text) for text in (options.x, options.y)]
            self.state = (self.displacement(0.0), np.zeros(2))
        except ReductionError as error:
            raise bad_input(f"--x or --y: {error}.") from error
        if self.state[0].any():
            raise bad_input(f"--x and --y give {self.state[0]} at t = 0; the body has to start where the case has it.")

    def displacement(self, time_s):
        return np.array([float(component({"t": time_s})) for component in self.components])

    def properties(self):
        immovable = np.full(len(self.area), 1e12)
        return {"body": [0] * len(self.area), "section_mass": immovable, "impedance": immovable, "least_mass": immovable}

    def surface(self):
        displacement, velocity = self.state
        return Surface(self.position + displacement, np.tile(velocity, (len(self.area), 1)), self.normal, self.area)

    def advance(self, time_s, duration_s, force):
        end = self.displacement(time_s + duration_s)
        self.state = (end, (end - self.state[0]) / duration_s)

    def energies(self):
        return {"kinetic": 0.0, "strain": 0.0, "potential": 0.0}  # whatever moves it keeps that account

    def gauge(self, gauge):
        return list(self.state[0]) if gauge["kind"] == "displacement" else None

    def fields(self):
        surface = self.surface()
        return {"position": surface.position, "displacement": surface.position - self.position, "velocity": surface.velocity}


def add_options(parser):
    for axis in ("x", "y"):
        parser.add_argument(f"--{axis}", metavar="EXPRESSION", default="0", help=f"displacement along {axis} [m], of t [s]")


run_structure(PrescribedMotion, add_options)
