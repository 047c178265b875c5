"""What a fluid or a structure written in Python needs to take part in a run (docs/PARTICIPANTS.md).

    from tern.participant import Surface, cut_box, run_structure

Needs numpy, h5py, zmq, protobuf and protoc; ./tern run installs them for the participants that come with tern.
"""

import importlib

_PLACES = {
    "structure_side": ("Surface", "cut_box", "run_structure"),
    "fluid_side": ("InterfaceParticles", "run_fluid"),
    "side": ("Case", "Run", "bad_input", "finite", "run_participant"),
    "channel": ("NumericalFailure", "Participant", "RunEnded"),
    "recording": ("Recording", "play_back"),
    "schema": ("wire",),
}
_HOMES = {name: module for module, names in _PLACES.items() for name in names}
__all__ = list(_HOMES)


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
