"""Messages that a participant in Python must refuse; python_participant_test.cpp runs it. Exits 1 naming what passed."""

import sys

from tern.participant.message_check import BadMessage, check_body
from tern.participant.schema import wire


def surface(**changes):
    return wire.Message(surface=wire.Surface(**{"position": [0, 0], "velocity": [0, 0], "normal": [0.6, 0.8], "area": [1]} | changes))


def load(**changes):
    return wire.Message(interface_condition=wire.InterfaceCondition(
        **{"force": [1, 2], "reference_pressure": [0], "lump": [0], "share": [1], "lump_mass": [1]} | changes))


for good in (surface(), load(), wire.Message(surface_load=wire.SurfaceLoad(force=[1, 2])),
             wire.Message(interface_force=wire.InterfaceForce(force=[1, 2])), wire.Message(finish=wire.Finish())):
    check_body(good, 2, 1, 1)
check_body(load(surface_velocity=[1, 2]), 2, 1, 1, projected=True)

for bad in (surface(position=[0]), surface(position=[0, float("inf")]), surface(normal=[0.6, 0.9]), surface(area=[0]),
            surface(area=[1, 1]), load(force=[1]), load(lump_mass=[-1]), load(lump=[1]), load(share=[-1]), load(lump=[0, 0]),
            load(reference_pressure=[float("nan")]), load(answer_tolerance=-0.01), load(answer_tolerance=2),
            load(lump_mass=[]), load(surface_velocity=[1, 2]), wire.Message(begin_window=wire.BeginWindow(duration_ticks=0)),
            wire.Message(surface_load=wire.SurfaceLoad(force=[1])),
            wire.Message(interface_force=wire.InterfaceForce(force=[1, float("nan")]))):
    try:
        check_body(bad, 2, 1, 1)
    except BadMessage:
        continue
    sys.exit(f"passed although bad: {bad}")
