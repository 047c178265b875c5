#!/usr/bin/python3 -B
"""Deflection at rest and frequencies of the plate of this case, dry and under the water, from quadratic finite elements.

    cases/hydrostatic_plate/reference.py

Plane strain, both ends held over their whole height, elements of nine nodes. The water is incompressible, without viscosity, with p = 0 at
its surface: by the Fourier series of the tank, a motion cos(k x) of the floor has the added mass rho tanh(k H)/k per area, and the mean
motion rho H. Prints [m] and [Hz] for four meshes.
"""

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg

LENGTH, THICKNESS, MODULUS, POISSON, DENSITY = 1.0, 0.05, 67.5e9, 0.34, 2700.0
WATER, DEPTH, GRAVITY = 1000.0, 2.0, 9.81
TERMS = 60  # of the Fourier series


def shape(t):
    """The three quadratic functions of an edge and their derivatives at -1 <= t <= 1."""
    return np.array([t * (t - 1) / 2, 1 - t * t, t * (t + 1) / 2]), np.array([t - 0.5, -2 * t, t + 0.5])


def frequencies(stiffness, mass, added, factor, modes=6):
    """The lowest two of K v = omega^2 (M + A A^T) v by inverse iteration [Hz]."""
    vectors = np.random.RandomState(0).rand(mass.shape[0], modes)
    for _ in range(200):
        vectors = factor.solve(mass @ vectors + added @ (added.T @ vectors))
        reduced = vectors.T @ (mass @ vectors) + (added.T @ vectors).T @ (added.T @ vectors)
        squares, turn = scipy.linalg.eigh(vectors.T @ (stiffness @ vectors), reduced)
        vectors = vectors @ turn
    return np.sqrt(squares[:2]) / (2 * np.pi)


def plate(along, across):
    """Deflection of the middle [m], dry and wet frequencies [Hz] with so many elements."""
    rows, columns = 2 * across + 1, 2 * along + 1
    xs, ys = np.linspace(0, LENGTH, columns), np.linspace(-THICKNESS, 0, rows)
    lame, shear = MODULUS * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), MODULUS / 2 / (1 + POISSON)
    law = np.array([[lame + 2 * shear, lame, 0], [lame, lame + 2 * shear, 0], [0, 0, shear]])
    size, gauss = 2 * rows * columns, tuple(zip(np.sqrt(0.6) * np.array([-1, 0, 1]), np.array([5, 8, 5]) / 9))
    indices, stiffnesses, masses = [], [], []
    for ex in range(along):
        for ey in range(across):
            nodes = np.array([(2 * ex + a) * rows + 2 * ey + b for a in range(3) for b in range(3)])
            stiffness, mass = np.zeros((18, 18)), np.zeros((18, 18))
            for t, of_t in gauss:
                for s, of_s in gauss:
                    (nx, dnx), (ny, dny) = shape(t), shape(s)
                    jx, jy = dnx @ xs[2 * ex:2 * ex + 3], dny @ ys[2 * ey:2 * ey + 3]
                    n, dx, dy = (np.outer(a, b).ravel() for a, b in ((nx, ny), (dnx / jx, ny), (nx, dny / jy)))
                    strain = np.zeros((3, 18))
                    strain[0, 0::2], strain[1, 1::2], strain[2, 0::2], strain[2, 1::2] = dx, dy, dy, dx
                    stiffness += of_t * of_s * jx * jy * strain.T @ law @ strain
                    for d in (0, 1):
                        mass[d::2, d::2] += of_t * of_s * jx * jy * DENSITY * np.outer(n, n)
            indices.append((2 * nodes[:, None] + [0, 1]).ravel())
            stiffnesses.append(stiffness.ravel())
            masses.append(mass.ravel())
    places = np.concatenate([np.repeat(i, 18) for i in indices]), np.concatenate([np.tile(i, 18) for i in indices])
    stiffness, mass = (scipy.sparse.csc_matrix((np.concatenate(v), places), (size, size)) for v in (stiffnesses, masses))

    water, load = np.zeros((size, TERMS)), np.zeros(size)
    load[1::2] = -GRAVITY
    load = mass @ load
    k = np.pi / LENGTH * np.arange(TERMS)
    for ex in range(along):
        for t, weight in zip(*np.polynomial.legendre.leggauss(8)):
            nx, dnx = shape(t)
            x, jx = nx @ xs[2 * ex:2 * ex + 3], dnx @ xs[2 * ex:2 * ex + 3]
            for a in range(3):
                top = 2 * ((2 * ex + a) * rows + rows - 1) + 1
                water[top] += weight * jx * nx[a] * np.cos(k * x)
                load[top] -= weight * jx * nx[a] * WATER * GRAVITY * DEPTH
    per_term = np.append(WATER * DEPTH / LENGTH, 2 / LENGTH * WATER * np.tanh(k[1:] * DEPTH) / k[1:])
    held = np.concatenate([2 * (a * rows + np.arange(rows))[:, None] + [0, 1] for a in (0, columns - 1)]).ravel()
    free = np.setdiff1d(np.arange(size), held)
    stiffness, mass, water = stiffness[free][:, free], mass[free][:, free], water[free] * np.sqrt(per_term)
    factor = scipy.sparse.linalg.splu(stiffness.tocsc())
    deflection = np.zeros(size)
    deflection[free] = factor.solve(load[free])
    middle = 2 * (along * rows + across) + 1
    return deflection[middle], frequencies(stiffness, mass, 0 * water, factor), frequencies(stiffness, mass, water, factor)


if __name__ == "__main__":
    print("elements   deflection [m]   dry [Hz]        wet [Hz]")
    for count in ((20, 2), (40, 4), (80, 4), (80, 8)):
        middle_at, dry, wet = plate(*count)
        print(f"{count[0]:3} x {count[1]}    {middle_at:.4e}      {dry[0]:6.1f} {dry[1]:6.1f}   {wet[0]:6.2f} {wet[1]:6.1f}", flush=True)
