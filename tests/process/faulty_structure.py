"""A structure that keeps the protocol, but for one fault: what ./tern conform is tried on. FAULT CASE --out ... as tern starts it.

Four points on a rigid vertical face that a spring holds.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from tern.participant import channel
from tern.participant.channel import Participant, RunEnded
from tern.participant.schema import wire

ROOT = Path(__file__).resolve().parents[2]
FAULT, CASE = sys.argv[1:3]
ENDPOINT = sys.argv[sys.argv.index("--endpoint") + 1]
POINTS, MASS, STIFFNESS = 4, 20.0, 1e4  # kg/m^2, Pa/m
AREA, PLACE = 0.015, 0.09  # of a point, and where the right face of the plate is [m]


class Face:
    """Position and velocity along x of the face, and the load of the window [N/m]."""

    def __init__(self):
        self.x = self.v = self.load = self.work = 0.0
        self.before = (0.0, 0.0)
        self.duration = 0.0

    def trial(self):
        if FAULT != "forgets to restore":
            self.x, self.v = self.before
        force = self.load if FAULT != "moves backwards" else -self.load
        if FAULT == "deaf":
            force = 0.0
        self.v += self.duration * (force / (POINTS * AREA) - STIFFNESS * self.x) / MASS
        self.x += self.duration * self.v

    def surface(self, account):
        normal = [1.0 if FAULT != "normal" else 1.1, 0.0] * POINTS
        velocity = [self.v, 0.0] * POINTS
        if FAULT == "not finite" and self.duration:
            velocity[3] = float("nan")
        x = PLACE + (self.before[0] + self.x) / 2  # halfway through the window
        position = [value for k in range(POINTS) for value in (x, AREA * (k + 0.5))]
        return wire.Surface(position=position[:-1] if FAULT == "short" else position, velocity=velocity, normal=normal,
                            area=[AREA] * POINTS, account=account)


def main():
    scene = json.loads(subprocess.run([Path(os.environ["TERN_BUILD"]) / "tern-case", "json", CASE], check=True,
                                      stdout=subprocess.PIPE).stdout)
    wanted = scene["account"]["structure"]
    gauges = len(wanted["gauge"])
    face = Face()

    def account():
        energy = [0.0, 0.0, 0.0, 0.0, face.work][FAULT == "account":]
        return wire.Account(energy=energy, gauge=[face.x] + [0.0] * (gauges - 1), undefined=[False] * gauges)

    with Participant(ENDPOINT, wire.STRUCTURE) as channel:
        def interrupted(*_):
            if FAULT != "silent interrupt":
                channel.abort(130, "interrupted")
            sys.exit(130)

        signal.signal(signal.SIGINT, interrupted)
        hello = wire.Hello(case_hash=scene["hash"] if FAULT != "hash" else "0", dimension=2, version="faulty", account=account())
        hello.surface.body.extend([0] * POINTS)
        for field in ("section_mass", "impedance", "least_mass"):
            getattr(hello.surface, field).extend([MASS] * POINTS)
        channel.handshake(hello)
        while True:
            message = channel.receive("begin_window", "finish")
            if message.WhichOneof("body") == "finish":
                break
            face.before = (face.x, face.v)
            face.duration = message.begin_window.duration_ticks / (1 << 32)
            at_begin = account()
            face.trial()
            if FAULT == "sequence":
                channel._sent += 3
            channel.send(surface=face.surface(at_begin))
            while True:
                load = channel.receive("surface_load").surface_load
                face.load = sum(load.force[0::2])
                face.trial()
                if not load.trial:
                    break
                channel.send(surface_velocity=wire.SurfaceVelocity(velocity=[face.v, 0.0] * POINTS))
            face.work += face.load * (face.x - face.before[0])
            if FAULT == "talks":
                channel.send(surface_velocity=wire.SurfaceVelocity(velocity=[face.v, 0.0] * POINTS))
        if FAULT == "stays":
            time.sleep(30)
        channel.send(finished=wire.Finished(account=account()))
    if message.finish.interrupted and FAULT != "always content":
        sys.exit(130)


if FAULT == "credulous":  # takes whatever comes
    channel.check_body = lambda *_: None
try:
    main()
except RunEnded as end:
    print(end, file=sys.stderr)
    sys.exit(end.exit_code if FAULT != "own exit code" else 1)
