#!/usr/bin/python3 -B
"""How fast particles leave the line of a symmetric flow on which they close in on each other (docs/THEORY.md, shifting).

    bench/shift_growth.py

A square lattice is compressed to s along y and stretched to 1/s along x, as a flow does that keeps its volume. The shift, with its
largest share 1/2, makes of a displacement xi(k) of the particles (1 - A(k)/2) xi. Printed is its largest eigenvalue over all k, and the
growth from s = 1 to 0.45 as exp(b/a), with the strain a of a window.
"""

import numpy as np

H, DIMENSION = 1.5, 2  # smoothing length, in spacings
SHARE = 0.5


def kernel(r):
    return 7 / (4 * np.pi * H**2) * (1 - r / (2 * H)) ** 4 * (2 * r / H + 1)


def slope(r):
    """Of the kernel, with the term that keeps pairs apart."""
    return -35 / (4 * np.pi * H**4) * r * (1 - r / (2 * H)) ** 3 * (1 + 0.2 * (kernel(r) / kernel(1.0)) ** 4)


def second_derivatives(x, y):
    r, step = np.hypot(x, y), 1e-6
    along = (slope(r + step) - slope(r - step)) / (2 * step)
    n = np.array([x, y]) / r
    square = np.einsum("i...,j...->ij...", n, n)
    return along * square + slope(r) / r * (np.eye(DIMENSION)[:, :, None] - square)


def growth(s):
    column, row = (a.ravel() for a in np.meshgrid(np.arange(-8, 9), np.arange(-8, 9)))
    x, y = column / s, row * s
    near = (np.hypot(x, y) < 2 * H) & ((column != 0) | (row != 0))
    column, row, second = column[near], row[near], second_derivatives(x[near], y[near])
    waves = [(a, b) for a in np.linspace(-np.pi, np.pi, 49) for b in np.linspace(0, np.pi, 25)]
    return max(np.linalg.eigvalsh(np.eye(DIMENSION) - SHARE * H**2 * (second * (1 - np.cos(a * column + b * row))).sum(-1)).max()
               for a, b in waves)


def main():
    steps = np.array([1, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5, 0.45])
    values = np.array([growth(s) for s in steps])
    for s, value in zip(steps, values):
        print(f"s = {s:.2f}: {value:.2f} times in a window")
    logarithm, path = np.log(values), -np.log(steps)
    b = ((logarithm[1:] + logarithm[:-1]) / 2 * np.diff(path)).sum()
    print(f"to s = {steps[-1]}: exp({b:.2f}/a)")
    for a in (0.038, 0.05, 0.063, 0.12):
        print(f"a = {a}: {0.3 / np.exp(b / a):.0e} dx become 0.3 dx")


if __name__ == "__main__":
    main()
