#!/usr/bin/python3 -B
"""The fluid of an earlier run, played back: the same messages in the same order, whatever the structure does.

    ./tern run CASE --record --out runs/yesterday
    ./tern run CASE --fluid "recorded_fluid.py --from runs/yesterday" --structure "..."

The record holds for the windows it was made in. Where the implicit coupling asks for more iterations than there were, the last pressure of
the window is played again; where for fewer, the rest is passed over.
"""

import sys

from tern.participant import play_back, wire


def answer(run, record, _account):
    run.receive("surface")
    # A window that was passed over without a surface has no interface particles. It is not offered to pass it over again: another
    # may be nearer.
    run.send(interface_particles=record.take_or("interface_particles", wire.InterfaceParticles()))
    run.receive("interface_condition")
    pressure = record.take_or("interface_pressure", wire.InterfacePressure())
    run.send(interface_pressure=pressure)
    while run.receive("interface_condition", "interface_force").WhichOneof("body") == "interface_condition":
        pressure = record.take_or("interface_pressure", pressure)
        run.send(interface_pressure=pressure)
    record.pass_over("interface_pressure")
    done = record.take("window_done")
    done.ClearField("extent")
    run.send(window_done=done)
    return done.account


sys.exit(play_back("fluid", answer))
