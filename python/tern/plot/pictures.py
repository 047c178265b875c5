"""Pictures of runs: python3 plotting RUN... [--times T...]. Called by ./tern plot; needs numpy, matplotlib and h5py."""

import argparse
import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parent.parent)

import matplotlib  # noqa: E402

matplotlib.use("Agg")

from plotting import curves, fields, run_files, style  # noqa: E402


def save(figure, run, name):
    return None if figure is None else style.save(figure, run, name)


def plot(run, times):
    """All pictures of one run; returns their paths."""
    pictures = []
    for time in fields.choose_times(run, times):
        exact, figure = fields.figure(run, time)
        pictures.append(style.save(figure, run, f"field_{exact:.3f}s"))
    for name, figure in (("gauges", curves.gauges([run])), ("energies", curves.energies(run)), ("steps", curves.steps(run))):
        pictures.append(save(figure, run, name))
    return [picture for picture in pictures if picture is not None]


def main():
    parser = argparse.ArgumentParser(prog="tern plot")
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--times", nargs="+", type=float)
    arguments = parser.parse_args()
    style.apply()
    try:
        runs = [run_files.Run(directory) for directory in arguments.runs]
        pictures = [picture for run in runs for picture in plot(run, arguments.times)]
        if len(runs) > 1:
            pictures.append(save(curves.gauges(runs), runs[0], "comparison"))
    except run_files.UnreadableRun as error:
        print(f"tern: {error}", file=sys.stderr)
        return 2
    for picture in pictures:
        if picture is not None:
            print(picture)
    return 0


sys.exit(main())
