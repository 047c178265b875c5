#!/usr/bin/python3 -B
"""The verification cases, run by the real processes and held to their expected.toml by ./tern verify.

Seen to fail: dry_plate with structure.numerics.smoothing_length_ratio=1.0 (4.435 Hz), hydrostatic_tank and dam_break_plate
with fluid.numerics.density_relaxation=0 (pressure 1.1 % off; volume drift 3.9 %), neutral_block with patches of a body as long as the
fluid's spacing (it rises by 18 mm), twisting_column and both spinning bodies with pair
forces that leave out the stress of the diffusion's reconstruction. A band that expected.toml itself declares
missed (shortfall) does not stop the suite, but ./tern verify counts it as FAIL, and meeting it unannounced is an error here.
"""

import json
import os
import subprocess
import tempfile
import unittest

from real_run import ROOT, build_directory


class VerifyCasesTest(unittest.TestCase):
    def verify(self, name):
        environment = os.environ | {"TERN_BUILD": str(build_directory())}
        with tempfile.TemporaryDirectory(prefix="tern-test-") as directory:
            answer = subprocess.run([ROOT / "tern", "verify", name, "--json"], cwd=directory, env=environment,
                                    capture_output=True, text=True, check=False)
        self.assertIn(answer.returncode, (0, 3), answer.stderr)
        rows = json.loads(answer.stdout or "[{}]")[0].get("rows", [])
        self.assertTrue(rows, answer.stderr)
        failed = [f"{row['name']}: {row['value']} {row['why']}, band {row['band']}" for row in rows
                  if not row["passed"] and not row["shortfall"]]
        self.assertEqual(failed, [])
        overtaken = [row["name"] for row in rows if row["passed"] and row["shortfall"]]
        self.assertEqual(overtaken, [], "inside its band now: take the shortfall out of expected.toml")
        self.assertEqual(answer.returncode, 0 if all(row["passed"] for row in rows) else 3)

    def test_the_dry_plate_swings_with_its_own_frequency(self):
        self.verify("dry_plate")

    def test_the_floor_carries_ten_times_its_mass_of_water(self):
        self.verify("hydrostatic_plate")

    def test_a_block_of_the_density_of_water_stays_where_it_is(self):
        self.verify("neutral_block")

    def test_a_block_a_little_denser_sinks(self):
        self.verify("sinking_block")

    def test_the_plate_under_water_swings_in_two_modes(self):
        self.verify("submerged_plate_modes")

    def test_the_column_bends_over_and_back(self):
        self.verify("bending_column_2d")

    def test_the_bar_rings_at_its_wave_speed(self):
        self.verify("tensile_bar")

    def test_the_bar_resists_its_torsion(self):
        self.verify("twisted_bar")

    def test_the_cantilever_keeps_its_period_through_large_swings(self):
        self.verify("gray_cantilever")

    def test_the_plate_keeps_its_spin(self):
        self.verify("spinning_plate")

    def test_the_cube_keeps_its_spin(self):
        self.verify("spinning_cube")

    def test_the_column_winds_up_and_unwinds(self):
        self.verify("twisting_column")

    def test_the_beam_comes_to_rest_where_the_benchmark_has_it(self):
        self.verify("turek_hron_csm1")

    def test_the_beam_swings_as_the_benchmark_does(self):
        self.verify("turek_hron_csm3")

    def test_water_at_rest_stays_at_rest_with_hydrostatic_pressure(self):
        self.verify("hydrostatic_tank")

    def test_the_vortices_die_out_at_the_rate_of_their_viscosity(self):
        self.verify("taylor_green")

    def test_the_standing_wave_keeps_its_period_and_height(self):
        self.verify("standing_wave")

    def test_the_square_patch_keeps_its_spin(self):
        self.verify("rotating_square_patch")

    def test_the_dam_break_bends_the_plate_as_it_should(self):
        self.verify("dam_break_plate")


if __name__ == "__main__":
    unittest.main()
