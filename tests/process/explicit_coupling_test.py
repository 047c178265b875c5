"""Explicit coupling is refused where the added mass predicts that it fails, and can be asked for all the same."""

import unittest

from real_run import RealRunTest

RATIO = 1000 * 0.08 / 1.875104 / (0.5 * 1200 * 0.02)  # small_plate: 80 mm free, 20 mm thick, both faces exposed


class ExplicitCouplingTest(RealRunTest):
    def finish(self, process):
        output, errors = process.communicate(timeout=120)
        return process.returncode, output, errors

    # Seen to fail with the limit at 80.
    def test_it_is_refused_with_the_figure_and_the_remedy(self):
        code, _, errors = self.finish(self.start("--set", "coupling.algorithm=explicit", "--until", "0.02"))
        self.assertEqual(code, 2, errors)
        for part in (f"m_a/m_s = {RATIO:.3g} for 'plate'", "0.8", "auto", "--allow-unstable"):
            self.assertIn(part, errors)
        contents = self.contents()
        self.assertEqual((contents["status"], contents["steps"]), ("bad input", 0))

    # Seen to fail with the option not passed on to the coupler.
    def test_it_runs_when_asked_for_and_where_the_ratio_is_small(self):
        for words in (["--allow-unstable"], ["--set", "structure.body.plate.density=60000"]):
            code, _, errors = self.finish(self.start("--set", "coupling.algorithm=explicit", "--until", "0.005", "--force", *words))
            self.assertEqual(code, 0, errors)

    # Seen to fail with the measure left out of the report.
    def test_the_ratio_is_reported(self):
        code, output, errors = self.finish(self.start("--until", "0.005"))
        self.assertEqual(code, 0, errors)
        measured = self.contents()["processes"]["coupler"]["measures"]["added_mass_ratio_predicted"]
        self.assertAlmostEqual(measured, RATIO, places=6)
        self.assertIn(f"added-mass ratio, predicted: {RATIO:.3g}", output)


if __name__ == "__main__":
    unittest.main()
