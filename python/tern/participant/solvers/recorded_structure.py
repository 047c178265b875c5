#!/usr/bin/python3 -B
"""The structure of an earlier run, played back: the same messages in the same order, whatever the load.

    ./tern run CASE --record --out runs/yesterday
    ./tern run CASE --structure "recorded_structure.py --from runs/yesterday"

The record holds for the windows it was made in. Where the implicit coupling asks for more iterations than there were, the last velocities
of the window are played again; where for fewer, the rest is passed over.
"""

import sys

from tern.participant import play_back, wire


def answer(run, record, account):
    surface = record.take("surface")
    run.send(surface=surface)
    velocity = wire.SurfaceVelocity(velocity=surface.velocity)
    while run.receive("surface_load").surface_load.trial:
        velocity = record.take_or("surface_velocity", velocity)
        run.send(surface_velocity=velocity)
    record.pass_over("surface_velocity")
    # The state at the end of a window is reported with the next surface, or with the end of the run.
    for kind in ("surface", "finished"):
        account = record.peek(kind).account if record.is_next(kind) else account
    return account


sys.exit(play_back("structure", answer))
