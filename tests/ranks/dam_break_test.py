"""Water that breaks, in one, four and eight processes: the front until it meets the wall, energies, volume, particles through walls.

Seen red: with ghosts within half the support (with 8 ranks the front is 0.27 spacings apart).
"""

import csv
import unittest

import numpy

from ranks_run import COARSE, OVERSUBSCRIBED, RanksTest

SPACING, WALL = 0.0073, 1.2


class DamBreak(RanksTest):
    def table(self, name, file):
        with open(self.directory / name / file, encoding="utf-8") as rows:
            names, *values = csv.reader(rows)
        return dict(zip(names, numpy.array(values, dtype=float).T))

    def test_all_numbers_of_ranks_see_the_same_flow(self):
        for count in (1, 4, 8):
            self.assertEqual(self.run_case(f"n{count}", "--until", "0.5", "--ranks", str(count), *OVERSUBSCRIBED, *COARSE), (0, ""))
        one, energies = (self.table("n1", name) for name in ("gauges.csv", "energy.csv"))
        before = one["t_s"] < one["t_s"][numpy.argmax(one["front.x_m"] > WALL - 2 * SPACING)]
        self.assertGreater(before.sum(), 100)
        for count in (4, 8):
            with self.subTest(ranks=count):
                many = self.table(f"n{count}", "gauges.csv")
                front = numpy.interp(one["t_s"], many["t_s"], many["front.x_m"])
                self.assertLess(numpy.abs(front - one["front.x_m"])[before].max(), SPACING / 4)
                of_many = self.table(f"n{count}", "energy.csv")
                for name in ("fluid_kinetic_J", "fluid_potential_J"):
                    apart = numpy.abs(numpy.interp(energies["t_s"], of_many["t_s"], of_many[name]) - energies[name]).max()
                    self.assertLess(apart, 0.005 * numpy.abs(energies[name]).max(), name)
                fluid, alone = (self.contents(f"n{n}")["processes"]["fluid"] for n in (count, 1))
                self.assertEqual(fluid["counts"]["particles_leaked"], 0)
                self.assertAlmostEqual(fluid["measures"]["volume_drift"], alone["measures"]["volume_drift"], delta=1e-3)


if __name__ == "__main__":
    unittest.main()
