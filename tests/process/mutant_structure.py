"""A structure that keeps every rule of the protocol's form, but says one thing that is wrong: what ./tern conform and the coupler are
tried on.    mutant_structure.py --mutant NAME CASE --out ... as tern starts it

One bending and one stretching motion of a box that stands in a clamp: a cantilever's, growing with the square of the height.
"""

import sys

import numpy as np
import zmq

from tern.participant import cut_box, run_structure, structure_side
from tern.participant.schema import wire
from tern.participant.side import Run
from tern.participant.structure_side import Surface

MUTANT = sys.argv[sys.argv.index("--mutant") + 1]
INSIDE = " inside"  # of a mutant: the load is misused where the account does not see it
MISUSES = {"load doubled": lambda f, normal: 2 * f, "components exchanged": lambda f, normal: f[:, ::-1],
           "points reversed": lambda f, normal: f[::-1], "one face ignored": lambda f, normal: f * (normal[:, :1] > -0.5)}
SOLVER = {}  # the one there is


class Cantilever:
    def __init__(self, case, options):
        body, (low, high) = case.only_body(), case.body_box()
        clamps = [(np.array(c["box"]["min"]), np.array(c["box"]["max"])) for c in body["clamp"]]
        low[1] = max([low[1]] + [top[1] for _, top in clamps])
        self.position, self.normal, self.area, thickness, wet = cut_box(low, high, case.face_length(body), clamps)
        self.mode = (((self.position[:, 1] - low[1]) / (high[1] - low[1]))**2)[:, None]
        self.density, self.spacing, self.section_mass = body["density"], body["spacing"], body["density"] * thickness / wet
        self.mass = body["density"] * np.prod(high - low) / 5  # of the square of the mode
        self.frequency = np.array([200.0, 600.0])  # of bending and of stretching [1/s]
        self.weight = self.mass * 5 / 3 * case.gravity
        self.misuse = MISUSES.get(MUTANT.removesuffix(INSIDE), lambda f, normal: f)
        self.state = np.zeros((2, 2))  # displacement of the top, and its velocity
        SOLVER["it"] = self

    def properties(self):
        first = 1 if MUTANT == "body base 1" else 0
        return {"body": [first] * len(self.area), "section_mass": self.section_mass, "impedance": np.full(len(self.area), 1e12),
                "least_mass": np.full(len(self.area), self.density * self.spacing)}

    def surface(self):
        u, v = self.state
        position, velocity = self.position + self.mode * u, self.mode * v
        if MUTANT == "one point frozen":
            position[7], velocity[7] = self.position[7], 0
        return Surface(position, velocity, self.normal, self.area)

    def advance(self, time_s, duration_s, force):
        force = self.misuse(force, self.normal) if MUTANT.endswith(INSIDE) else force
        rest = ((self.mode * force).sum(axis=0) + self.weight) / (self.mass * self.frequency**2)
        c, s, (u, v) = np.cos(self.frequency * duration_s), np.sin(self.frequency * duration_s), self.state
        self.state = np.array([rest + (u - rest) * c + v / self.frequency * s, v * c - (u - rest) * self.frequency * s])

    def energies(self):
        u, v = self.state
        stretched = self.frequency * u
        return {"kinetic": self.mass * (v @ v) / 2, "strain": self.mass * (stretched @ stretched) / 2, "potential": -self.weight @ u}

    def gauge(self, gauge):
        return list((-1 if MUTANT == "gauge sign" else 1) * self.state[0]) if gauge["kind"] == "displacement" else None

    def fields(self):
        surface = self.surface()
        return {"position": surface.position, "displacement": surface.position - self.position, "velocity": surface.velocity}


class Coupled(structure_side._Coupled):
    """What is done wrong in the course of a window."""

    def misused(self, load):
        return load if MUTANT.endswith(INSIDE) else self.solver.misuse(load, self.solver.normal)

    def predict(self, begin_s, duration_s):
        duration_s *= 1.2 if MUTANT == "clock 20 % fast" else 1
        begin = self._begin
        surface = super().predict(begin_s, duration_s)
        if MUTANT == "position at the begin":
            surface.position = begin.position
        if MUTANT == "position at the end":
            surface.position = self.solver.surface().position
        if MUTANT == "velocity of the begin":
            surface.velocity = begin.velocity
        return surface

    def respond(self, load):
        answer = super().respond(self.misused(load))
        if MUTANT == "trial not undone":
            self._state = self.solver.state
        return answer

    def apply(self, load):
        load, work = self.misused(load), self.interface_work
        if MUTANT == "last load ignored":
            last = self.load
            super().apply(last)
            self.load = load
        else:
            super().apply(load)
        if MUTANT.startswith("work times "):
            self.interface_work = work + float(MUTANT.split()[-1]) * (self.interface_work - work)
        if MUTANT == "work sign":
            self.interface_work = 2 * work - self.interface_work


structure_side._Coupled = Coupled
SHAPES = {"shifted by 5 cm": lambda x: x + [0.05, 0], "scaled by 2": lambda x: 2 * x, "mirrored": lambda x: x * [-1, 1],
          "millimetres": lambda x: 1000 * x}
sent = {"surfaces": 0, "before": None}
send, make_account = Run.send, Run.account


def not_interleaved(vectors):
    return np.array(vectors).reshape(-1, 2).T.ravel()


def send_wrongly(run, **body):
    kind, message = next(iter(body.items()))
    if kind == "surface":
        sent["surfaces"] += 1
        position = np.array(message.position).reshape(-1, 2)
        if MUTANT == "account of the end":
            energies = SOLVER["it"].energies()
            energies = {name: energies[name] for name in ("kinetic", "strain", "potential")}
            rest = {str(n): value for n, value in enumerate(message.account.energy[3:])}
            message.account.CopyFrom(run.account(energies | rest, SOLVER["it"].gauge))
        if MUTANT in SHAPES:
            message.position[:] = SHAPES[MUTANT](position).ravel()
        if MUTANT == "normals inward":
            message.normal[:] = -np.array(message.normal)
        if MUTANT == "permuted" and sent["surfaces"] % 2 == 0:
            message.position[:] = position[::-1].ravel()
        if MUTANT == "one window late":
            copy = wire.Surface()
            copy.CopyFrom(message)
            late = sent["before"] or copy
            for field in ("position", "velocity", "normal", "area"):
                getattr(message, field)[:] = getattr(late, field)
            sent["before"] = copy
    if kind in ("surface", "surface_velocity"):
        if MUTANT == "not interleaved":
            message.velocity[:] = not_interleaved(message.velocity)
        if MUTANT == "velocity in mm/s":
            message.velocity[:] = 1000 * np.array(message.velocity)
        if MUTANT == "velocity sign":
            message.velocity[:] = -np.array(message.velocity)
    send(run, **body)


Run.send = send_wrongly
if MUTANT == "no heartbeat":
    setsockopt = zmq.Socket.setsockopt
    heartbeats = (zmq.HEARTBEAT_IVL, zmq.HEARTBEAT_TIMEOUT, zmq.HEARTBEAT_TTL)
    zmq.Socket.setsockopt = lambda socket, option, value: None if option in heartbeats else setsockopt(socket, option, value)

run_structure(Cantilever, lambda parser: parser.add_argument("--mutant", required=True))
