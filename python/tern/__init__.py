"""tern in Python: what ./tern does, and the same for scripts and notebooks.

    import tern

    run = tern.run("dam_break_plate", {"fluid.spacing": 0.008}, until=0.3)    # as ./tern run; raises tern.RunFailed
    run = tern.Run("runs/dam_break_plate")                                    # the results of an earlier run
    run.gauges["P.ux_m"], run.gauges["t_s"]                                   # arrays [m], [s], a value per row
    run.frames[-1].fluid["pressure"]                                          # array [Pa], a value per particle
    rows = tern.study("hydrostatic_tank", ["fluid.spacing"], budget=5)        # as ./tern study

help(tern.run), help(tern.Run) and help(tern.study) say the rest; docs/tern.ipynb shows it. `./tern python my_script.py` finds this package,
as does any Python with python/ of the clone on its PYTHONPATH. A fluid or a structure in Python begins with tern.participant.

The package has layers. A part imports what stands above it in this list, and of that only what is named:

    errors, paths, expression   nothing (paths and expression: errors)
    scale_model                 errors
    results                     errors
    participant                 errors, paths, expression, results
    launch                      errors, paths, results, participant
    verify                      errors, expression, results, launch
    plot                        errors, results
    studies                     errors, paths, results, launch, verify, plot
    extremes                    errors, paths, results, launch
    report                      errors, paths, results, verify, plot
    api, command_line, this module   everything

A run needs the standard library only: errors, paths, expression, scale_model, results, launch, verify, api and command_line import
numpy, h5py, matplotlib and zmq where arrays, frames, pictures or messages are asked for, never when they are imported themselves.
tests/python/layers_test.py holds all of this.
"""

import importlib

_PLACES = {
    "api": ("run", "study"),
    "results.run": ("Run",),
    "errors": ("Error", "RunFailed", "UnreadableRun"),
}
_HOMES = {name: module for module, names in _PLACES.items() for name in names}
__all__ = list(_HOMES)


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__():
    return [*globals(), *__all__]
