#!/usr/bin/python3 -B
"""Why two particles across need more than a fit: stiffness of bars over that of beam theory.

    /usr/bin/python3 bench/two_layers.py          half a minute

Small motion, clamped by particles on the face of the clamp. It is a model of the method in a few lines, for studies of its sums alone.
Prints two Markdown tables. Two layers do not determine the second derivative through the thickness, zz. The columns and rows are

    first order    the fit of linear terms alone
    without zz     the fit of all terms but zz
    least energy   the same, with what the neighbours do not determine at the least energy of the strain gradient (tern's way)
    3, 4 across    the full fit
"""

import numpy as np

SMOOTHING = 1.1  # spacings, which are 1
FIRST_ORDER, WITHOUT, LEAST_ENERGY = range(3)


def weight(r):
    q = r / SMOOTHING
    return np.where(q < 2, (1 - q / 2) ** 4 * (2 * q + 1), 0)


class Energy:
    """Quadratic forms over the gradient (D x D) and over the second derivatives (D x pairs) of a displacement, E = 1."""

    def __init__(self, dimension, poisson):
        d = self.dimension = dimension
        self.pairs = [(a, b) for a in range(d) for b in range(a, d)]
        first, shear = poisson / ((1 + poisson) * (1 - 2 * poisson)), 1 / (2 * (1 + poisson))
        same = np.eye(d)
        hooke = (first * np.einsum("ij,kl", same, same)
                 + shear * (np.einsum("ik,jl->ijkl", same, same) + np.einsum("il,jk->ijkl", same, same))).reshape(d * d, d * d)
        self.gradient = hooke  # it takes the symmetric part by itself
        self.curvature = np.zeros((d * len(self.pairs),) * 2)
        for direction in range(d):
            strain = np.zeros((d, d, d, len(self.pairs)))
            for i in range(d):
                for j in range(d):
                    strain[i, j, i, self.pairs.index((min(direction, j), max(direction, j)))] = 1
            strain = strain.reshape(d * d, -1)
            self.curvature += strain.T @ hooke @ strain

    def of_particle(self, offsets, way):
        """Its derivatives over the displacements of its neighbours, and the quadratic form of its energy over all derivatives."""
        d, count = self.dimension, len(self.pairs)
        w = weight(np.sqrt((offsets ** 2).sum(axis=1)))
        quadratic = np.stack([offsets[:, a] * offsets[:, b] * (0.5 if a == b else 1) for a, b in self.pairs], 1)
        basis = np.concatenate([offsets, quadratic], 1)
        values, vectors = np.linalg.eigh((basis * w[:, None]).T @ basis)
        vanishing = vectors[:, values < 1e-9 * values[-1]]
        fields = vanishing.shape[1]
        full = np.eye(d * d + d * count)
        if way == FIRST_ORDER and fields:
            fit = np.zeros((d + count, len(offsets)))
            fit[:d] = np.linalg.solve((offsets * w[:, None]).T @ offsets, (offsets * w[:, None]).T)
        else:
            fit = vectors[:, fields:] / values[fields:] @ vectors[:, fields:].T @ (basis * w[:, None]).T
            if fields:
                curvature, triangle = np.linalg.qr(vanishing[d:])
                gradient = vanishing[:d] @ np.linalg.inv(triangle)
                fit = fit - np.concatenate([gradient, curvature]) @ (curvature.T @ fit[d:])
                if way == LEAST_ENERGY:
                    of_curvature, of_gradient = np.kron(np.eye(d), curvature), np.kron(np.eye(d), gradient)
                    amplitude = -np.linalg.solve(of_curvature.T @ self.curvature @ of_curvature, of_curvature.T @ self.curvature)
                    full[:d * d, d * d:] = of_gradient @ amplitude
                    full[d * d:, d * d:] += of_curvature @ amplitude
        energy = np.zeros((d * d + d * count,) * 2)
        energy[:d * d, :d * d] = self.gradient
        energy[d * d:, d * d:] = self.curvature / 12
        return fit, full.T @ energy @ full


def stiffness(points, held, poisson, way):
    d = points.shape[1]
    energy, known = Energy(d, poisson), {}
    matrix = np.zeros((points.size,) * 2)
    for i in range(held, len(points)):
        offsets = points - points[i]
        distance = np.sqrt((offsets ** 2).sum(axis=1))
        near = np.where((distance < 2 * SMOOTHING - 1e-9) & (distance > 0))[0]
        key = offsets[near].tobytes()
        if key not in known:
            known[key] = energy.of_particle(offsets[near], way)
        fit, form = known[key]
        fit = np.concatenate([fit, -fit.sum(axis=1, keepdims=True)], 1)
        rows = np.concatenate([np.kron(np.eye(d), fit[:d]), np.kron(np.eye(d), fit[d:])])  # over component, then particle
        unknowns = (np.append(near, i)[None, :] * d + np.arange(d)[:, None]).ravel()
        matrix[np.ix_(unknowns, unknowns)] += rows.T @ form @ rows
    return matrix[d * held:, d * held:]


def bar(length, *sections):
    """Points of a clamped bar, those on the face of the clamp first."""
    section = np.stack([x.ravel() for x in np.meshgrid(*[np.arange(n) + 0.5 for n in sections], indexing="ij")], 1)
    return np.concatenate([np.insert(section, 0, x, axis=1) for x in [0, *(np.arange(length) + 0.5)]]), len(section)


def frequency(layers, poisson, way):
    points, held = bar(10 * layers, layers)
    thin_plate = 1.875104**2 / (10 * layers)**2 * layers / np.sqrt(12 * (1 - poisson**2))
    return np.sqrt(np.linalg.eigvalsh(stiffness(points, held, poisson, way))[0]) / thin_plate


def tension_and_bending(length, sections, poisson, way):
    """Stiffness between a quarter and three quarters of the length, over E A, E I about one axis and E I about the other."""
    points, held = bar(length, *sections)
    matrix, result = stiffness(points, held, poisson, way), []
    at = [points[:, 0] == place + 0.5 for place in (length // 4, 3 * length // 4, length - 1)]
    for axis in (None, 2, 1):
        arm = np.ones(len(points)) if axis is None else points[:, axis] - sections[axis - 1] / 2
        load = np.zeros(points.shape)
        load[at[2], 0] = arm[at[2]] / (arm[at[2]]**2).sum()
        moved = np.concatenate([np.zeros(held * 3), np.linalg.solve(matrix, load.ravel()[held * 3:])]).reshape(-1, 3)[:, 0]
        low, high = ((moved[s] * arm[s]).sum() / (arm[s]**2).sum() for s in at[:2])
        inertia = np.prod(sections) * (1 if axis is None else sections[axis - 1]**2 / 12)
        result.append((3 * length // 4 - length // 4) / (high - low) / inertia)
    return result


def main():
    print("First frequency of a cantilever in plane strain over that of a thin plate, L/t = 10:\n")
    print("| Poisson's ratio | 2, first order | 2, without zz | 2, least energy | 3 across | 4 across |\n|" + "---|" * 6)
    for poisson in (0, 0.3, 0.45):
        values = [frequency(2, poisson, way) for way in range(3)] + [frequency(n, poisson, LEAST_ENERGY) for n in (3, 4)]
        print(f"| {poisson} | " + " | ".join(f"{value:.3f}" for value in values) + " |")
    print("\nBars in 3D, Poisson's ratio 0.3: stiffness over E A and E I:\n")
    print("| section | way | tension | bending about one axis | about the other |\n|" + "---|" * 5)
    for sections, way, name in (((2, 2), FIRST_ORDER, "first order"), ((2, 2), LEAST_ENERGY, "least energy"),
                                ((2, 6), FIRST_ORDER, "first order"), ((2, 6), LEAST_ENERGY, "least energy"),
                                ((3, 3), WITHOUT, "full fit")):
        values = tension_and_bending(20, sections, 0.3, way)
        print(f"| {sections[0]} x {sections[1]} | {name} | " + " | ".join(f"{value:.3f}" for value in values) + " |")


if __name__ == "__main__":
    main()
