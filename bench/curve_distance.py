#!/usr/bin/python3 -B
"""How far the curves of two runs are apart.

    bench/curve_distance.py RUN REFERENCE [--columns P.ux_m P.uy_m] [--from T] [--to T]

Prints for each column of gauges.csv (all that both have, unless told) the root mean square over time of the difference, and the largest,
in the unit of the column. Between rows values are linear.
"""

import argparse
from pathlib import Path

import numpy as np


def curves(folder):
    rows = np.genfromtxt(Path(folder) / "gauges.csv", delimiter=",", names=True, deletechars="", replace_space=" ")
    return {name: rows[name] for name in rows.dtype.names}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run")
    parser.add_argument("reference")
    parser.add_argument("--columns", nargs="+")
    parser.add_argument("--from", dest="begin", type=float, default=0.0, help="s")
    parser.add_argument("--to", dest="end", type=float, help="s; the earlier of both ends unless told")
    words = parser.parse_args()
    run, reference = curves(words.run), curves(words.reference)
    end = min(run["t_s"][-1], reference["t_s"][-1]) if words.end is None else words.end
    t = np.linspace(words.begin, end, 1000)
    for name in words.columns or [name for name in run if name in reference and name != "t_s"]:
        difference = np.interp(t, run["t_s"], run[name]) - np.interp(t, reference["t_s"], reference[name])
        print(f"{name}: {np.sqrt(np.mean(difference**2)):.4g} (largest {np.abs(difference).max():.4g})")


if __name__ == "__main__":
    main()
