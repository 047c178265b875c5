"""tern in Python: what ./tern does, and the same for scripts and notebooks.

The package has layers. A part imports what stands above it in this list, and of that only what is named:

    errors, paths, expression   nothing (paths and expression: errors)
    results                     errors
    participant                 errors, paths, expression
    launch                      errors, paths, results, participant
    verify                      errors, expression, results, launch
    plot                        errors, results
    studies                     errors, paths, results, launch, verify, plot
    extremes                    errors, paths, results, launch
    report                      errors, paths, results, verify, plot
    command_line, this module   everything

A run needs the standard library only: errors, paths, expression, results, launch, verify and command_line import numpy, h5py, matplotlib
and zmq where arrays, frames, pictures or messages are asked for, never when they are imported themselves. tests/python/layers_test.py
holds all of this.
"""
