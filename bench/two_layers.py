#!/usr/bin/python3 -B
"""Why two particles across are too few: first frequency of a cantilever in 2D over that of a thin plate.

    /usr/bin/python3 bench/two_layers.py          half a minute

Plane strain, L/t = 10, small motion, clamped by particles on the face of the clamp. It is a model of the method in a few lines, for studies
of its sums alone. Prints a Markdown table. Two layers do not determine the second derivative through the thickness, zz. The columns are

    first order   the fit of linear terms alone, which is what tern takes where the quadratic ones are not determined
    without zz    the fit of all terms but zz
    stretch       the same, and in each column of two particles one number more: u_z,zz, which takes the least energy
    3, 4 across   the full fit
"""

import numpy as np

LENGTH = 10  # over the thickness
SMOOTHING = 1.1  # spacings, which are 1


def weight(r):
    q = r / SMOOTHING
    return np.where(q < 2, (1 - q / 2) ** 4 * (2 * q + 1), 0)


def frequency(layers, poisson, terms, stretch=False):
    columns = LENGTH * layers
    points = np.array([(0, k + 0.5) for k in range(layers)] + [(i + 0.5, k + 0.5) for i in range(columns) for k in range(layers)])
    held, unknowns = layers, 2 * len(points)
    first, shear = poisson / ((1 + poisson) * (1 - 2 * poisson)), 1 / (2 * (1 + poisson))
    hooke = np.array([[first + 2 * shear, first, 0], [first, first + 2 * shear, 0], [0, 0, shear]])
    stiffness = np.zeros((unknowns + columns * stretch,) * 2)

    def strain(along, across):
        rows = np.zeros((3, len(stiffness)))
        rows[0, 0:unknowns:2], rows[1, 1:unknowns:2] = along, across
        rows[2, 0:unknowns:2], rows[2, 1:unknowns:2] = across, along
        return rows

    for i in range(held, len(points)):
        offset = points - points[i]
        distance = np.hypot(*offset.T)
        near = np.where((distance < 2 * SMOOTHING - 1e-9) & (distance > 0))[0]
        x, z = offset[near].T
        basis = np.stack([x, z, x * x, x * z, z * z][:terms], 1)
        weighted = (basis * weight(distance[near])[:, None]).T
        fit = np.linalg.solve(weighted @ basis, weighted)
        rows = np.zeros((5, len(points)))
        rows[:terms, near] = fit * np.array([1, 1, 2, 1, 2])[:terms, None]
        rows[:, i] = -rows.sum(axis=1)
        middle, along, across = strain(rows[0], rows[1]), strain(rows[2], rows[3]), strain(rows[3], rows[4])
        if stretch:
            column = unknowns + int(points[i, 0])
            middle[1, column] = 0.5 if points[i, 1] > 1 else -0.5
            across[1, column] = 1
        stiffness += middle.T @ hooke @ middle + (along.T @ hooke @ along + across.T @ hooke @ across) / 12
    free = stiffness[2 * held:, 2 * held:]
    if stretch:
        motions, own = unknowns - 2 * held, free[unknowns - 2 * held:, unknowns - 2 * held:]
        free = free[:motions, :motions] - free[:motions, motions:] @ np.linalg.solve(own, free[motions:, :motions])
    thin_plate = 1.875104**2 / columns**2 * layers / np.sqrt(12 * (1 - poisson**2))
    return np.sqrt(np.linalg.eigvalsh(free)[0]) / thin_plate


def main():
    print("| Poisson's ratio | 2, first order | 2, without zz | 2, stretch | 3 across | 4 across |\n|" + "---|" * 6)
    for poisson in (0, 0.3, 0.45):
        values = [frequency(2, poisson, 2), frequency(2, poisson, 4), frequency(2, poisson, 4, stretch=True),
                  frequency(3, poisson, 5), frequency(4, poisson, 5)]
        print(f"| {poisson} | " + " | ".join(f"{value:.3f}" for value in values) + " |")


if __name__ == "__main__":
    main()
