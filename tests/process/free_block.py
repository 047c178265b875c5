#!/usr/bin/python3 -B
"""A rigid block that nothing holds and that does not turn: the same pressure all around it does not move it."""

import numpy as np

from tern.participant import Surface, cut_box, run_structure


class FreeBlock:
    def __init__(self, case, options):
        body, (low, high) = case.only_body(), case.body_box()
        self.position, self.normal, self.area, thickness, wet = cut_box(low, high, case.face_length(body), [])
        self.section_mass, self.least_mass = body["density"] * thickness / wet, body["density"] * body["spacing"]
        self.mass = body["density"] * np.prod(np.array(high) - np.array(low))
        self.state = (np.zeros(2), np.zeros(2))  # displacement, velocity

    def properties(self):
        return {"body": [0] * len(self.area), "section_mass": self.section_mass, "impedance": np.full(len(self.area), 1e12),
                "least_mass": np.full(len(self.area), self.least_mass)}

    def surface(self):
        shift, velocity = self.state
        return Surface(self.position + shift, np.tile(velocity, (len(self.area), 1)), self.normal, self.area)

    def free_motions(self):
        surface = self.surface()
        return [(surface.position.mean(axis=0), self.state[1], 0.0)]

    def advance(self, time_s, duration_s, force):
        acceleration, (shift, velocity) = force.sum(axis=0) / self.mass, self.state
        self.state = (shift + velocity * duration_s + acceleration * duration_s**2 / 2, velocity + acceleration * duration_s)

    def energies(self):
        return {"kinetic": self.mass * self.state[1] @ self.state[1] / 2, "strain": 0.0, "potential": 0.0}

    def gauge(self, gauge):
        return list(self.state[0]) if gauge["kind"] == "displacement" else None

    def fields(self):
        surface = self.surface()
        return {"position": surface.position, "displacement": surface.position - self.position, "velocity": surface.velocity}


run_structure(FreeBlock)
