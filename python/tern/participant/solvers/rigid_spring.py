#!/usr/bin/python3 -B
"""A structure that is a rigid box on a spring, free to move along gravity: the worked example of docs/PARTICIPANTS.md.

    ./tern run cases/piston --structure "rigid_spring.py --stiffness 2e7"

m a = sum of the forces of the fluid + m g - k A d per metre of depth, with the mass m of the free part of the body, its area A
across the spring and the stiffness k per area [N/m^3]. The load is constant over a window, so the motion in it is a cosine.
"""

import numpy as np

from tern.participant import Surface, cut_box, run_structure


class RigidSpring:
    def __init__(self, case, options):
        body, (low, high) = case.only_body(), case.body_box()
        self.clamps = [(np.array(c["box"]["min"]), np.array(c["box"]["max"])) for c in body["clamp"]]
        low[1] = max([low[1]] + [top[1] for _, top in self.clamps])  # what a clamp holds is the ground, not the body
        self.position, self.normal, self.area, thickness, wet = cut_box(low, high, case.face_length(body), self.clamps)
        self.section_mass, self.density, self.spacing = body["density"] * thickness / wet, body["density"], body["spacing"]
        self.gravity, width = case.gravity[1], high[0] - low[0]
        self.mass, self.stiffness = body["density"] * width * (high[1] - low[1]), options.stiffness * width
        self.state = (0.0, 0.0)  # displacement, velocity

    def properties(self):
        # Rigid: however short a window, a pressure moves the whole section behind the point.
        return {"body": [0] * len(self.area), "section_mass": self.section_mass, "impedance": np.full(len(self.area), 1e12),
                "least_mass": np.full(len(self.area), self.density * self.spacing)}

    def surface(self):
        d, v = (np.array([0.0, component]) for component in self.state)
        return Surface(self.position + d, np.tile(v, (len(self.area), 1)), self.normal, self.area)

    def advance(self, time_s, duration_s, force):
        omega, rest = np.sqrt(self.stiffness / self.mass), (force[:, 1].sum() + self.mass * self.gravity) / self.stiffness
        c, s, (d, v) = np.cos(omega * duration_s), np.sin(omega * duration_s), self.state
        self.state = (rest + (d - rest) * c + v / omega * s, v * c - (d - rest) * omega * s)

    def save(self):
        return {"state": self.state}

    def restore(self, saved):
        self.state = tuple(saved["state"])

    def energies(self):
        d, v = self.state
        return {"kinetic": self.mass * v**2 / 2, "strain": self.stiffness * d**2 / 2, "potential": -self.mass * self.gravity * d}

    def gauge(self, gauge):
        return [0.0, self.state[0]] if gauge["kind"] == "displacement" else None

    def fields(self):
        surface = self.surface()
        return {"position": surface.position, "displacement": surface.position - self.position, "velocity": surface.velocity}


run_structure(RigidSpring, lambda parser: parser.add_argument("--stiffness", type=float, required=True, help="[N/m^3]"))
