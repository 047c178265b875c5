"""What cases/dam_break_plate/compare_schemes.py measures in the fields, on fields whose answer is known."""

import importlib.util
import unittest

import numpy as np

from fake_build import ROOT

SPACING = 0.004


def comparison():
    path = ROOT / "cases" / "dam_break_plate" / "compare_schemes.py"
    spec = importlib.util.spec_from_file_location("compare_schemes", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def scene():
    """A plate of 4 mm x 90 mm at x = 0 with water on a lattice on both sides."""
    y = np.arange(0.0005, 0.09, 0.001)
    faces = [np.column_stack([np.full(len(y), x), y, 0 * y]) for x in (-0.002, 0.002)]
    tip = np.array([[x, 0.09, 0.0] for x in (-0.0015, -0.0005, 0.0005, 0.0015)])
    structure = {"surface_position": np.concatenate([*faces, tip]), "position": np.concatenate([*faces, tip])}
    x = np.concatenate([-0.002 - SPACING * (np.arange(20) + 0.5), 0.002 + SPACING * (np.arange(20) + 0.5)])
    lattice = np.stack(np.meshgrid(x, SPACING * (np.arange(20) + 0.5)), axis=-1).reshape(-1, 2)
    fluid = {"position": np.column_stack([lattice, np.zeros(len(lattice))])}
    return fluid, structure


class SchemesComparisonTest(unittest.TestCase):
    def setUp(self):
        self.measures = comparison()
        self.fluid, self.structure = scene()

    # Seen to fail with the particles of both sides in one fit.
    def test_a_linear_pressure_on_either_side_has_no_roughness(self):
        x, y = self.fluid["position"][:, 0], self.fluid["position"][:, 1]
        side = self.measures.sides(self.structure)
        self.fluid["pressure"] = 1000 - 9810 * y + np.where(x > 0, 500 + 2000 * x, -300 * x)
        self.assertLess(self.measures.roughness(self.fluid, self.structure, side, SPACING), 1e-9)
        self.fluid["pressure"] += 100 * (-1.0) ** np.round(y / SPACING - 0.5)
        self.assertAlmostEqual(self.measures.roughness(self.fluid, self.structure, side, SPACING), 100, delta=15)

    # Seen to fail with half the spacing as the distance that counts as void.
    def test_a_void_is_as_large_as_what_is_missing(self):
        self.assertEqual(self.measures.void(self.fluid, self.structure, SPACING), 0)
        position = self.fluid["position"]
        missing = (np.abs(position[:, 0] - 0.002 - 4 * SPACING) < 2.1 * SPACING) & (position[:, 1] < 4.1 * SPACING)
        self.fluid["position"] = position[~missing]
        # 4 x 4 particles are missing; what lies within one spacing of the face or of a particle does not count.
        void = self.measures.void(self.fluid, self.structure, SPACING) / SPACING**2
        self.assertGreater(void, 2.5 * 3.5)
        self.assertLess(void, 3 * 4)


if __name__ == "__main__":
    unittest.main()
