#!/usr/bin/python3 -B
"""tern.Run on small made-up results: columns with units, undefined values, frames of both sides, what came of the run."""

import itertools
import math
import tempfile
import unittest
from pathlib import Path

import h5py
import made_up_run
import numpy as np

import tern
from tern.results import summary, tables


class RunTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.path = Path(directory.name)

    def made_up(self, **sides):
        made_up_run.write_sides(self.path, **sides)
        made_up_run.write_tables(self.path)
        made_up_run.write_case(self.path)
        return tern.Run(self.path)

    # Seen to fail: with empty cells read as 0.
    def test_columns_are_arrays_and_undefined_values_nan(self):
        run = self.made_up()
        self.assertEqual(list(run.gauges), ["t_s", "P.ux_m", "front_m"])
        np.testing.assert_array_equal(run.gauges["front_m"], [np.nan, 0.2, 0.3])
        self.assertEqual(run.steps["limit"].tolist(), ["gravity", "velocity"])
        self.assertEqual(len(run.energies["t_s"]), 2)
        with self.assertRaisesRegex(KeyError, "no column P.uy_m; there are t_s, P.ux_m, front_m"):
            run.gauges["P.uy_m"]

    # Seen to fail: with the unit of an energy left at J in 2D; with everything behind the first underscore taken for the unit.
    def test_units_stand_in_the_names_of_columns(self):
        units = {"t_s": "s", "P.ux_m": "m", "plate.Fx_N_per_m": "N/m", "wall.Fz_N": "N", "load.Mz_Nm_per_m": "Nm/m",
                 "weir.Q_m2_per_s": "m2/s", "S1.p_Pa": "Pa", "wall_ms": "ms", "pressure_iterations": "1", "limit": "1", "gauge_s.ux_m": "m"}
        self.assertEqual({column: tables.unit(column) for column in units}, units)
        run = self.made_up()
        self.assertEqual((run.gauges.unit("P.ux_m"), run.energies.unit("fluid_kinetic_J"), run.energies.unit("t_s")), ("m", "J/m", "s"))
        with self.assertRaises(KeyError):
            run.energies.unit("fluid_kinetic")

    # Seen to fail: with frames of the two sides side by side instead of joined by their time.
    def test_a_frame_has_the_fields_of_both_sides(self):
        run = self.made_up()
        with h5py.File(self.path / "fluid.h5", "a") as file:
            file["frame_000002/pressure"].attrs["unit"] = "Pa"
        self.assertEqual(run.frames.times, [0.0, 0.1, 0.2])
        last = run.frames[-1]
        self.assertEqual(last.fluid["velocity"].shape, (200, 3))
        self.assertEqual((last.fluid.unit("pressure"), last.fluid.unit("velocity")), ("Pa", "1"))
        self.assertAlmostEqual(last.structure["position"][0, 0] - run.frames[0].structure["position"][0, 0], 0.02)
        self.assertIs(run.frames.at(0.12), run.frames[1])
        self.assertEqual(len(run.frames[1:]), 2)
        with self.assertRaisesRegex(KeyError, "no field density; it has position"):
            last.fluid["density"]

    # Seen to fail: with the frames of the fluid taken for granted.
    def test_a_side_that_is_missing_is_none(self):
        run = self.made_up(fluid=False)
        self.assertEqual((len(run.frames), run.frames[0].fluid), (3, None))
        self.assertIn("clamped", run.frames[0].structure)
        (self.path / "structure.h5").unlink()
        run = tern.Run(self.path)
        self.assertEqual(list(run.frames), [])
        with self.assertRaisesRegex(IndexError, "wrote no frame"):
            run.frames.at(0)

    # Seen to fail: with conservation of what nobody reports.
    def test_what_came_of_it(self):
        run = self.made_up()
        self.assertEqual((run.status, run.first_cause, run.wall_s, run.cpu_s, run.dimension), ("done", "", 3.0, 2.5, 2))
        self.assertEqual(run.settings["fluid"]["numerics"]["courant"], 0.1)
        self.assertEqual(run.conservation, {"volume_drift": 0.001})
        self.assertEqual(run.timings["fluid"]["wait"], 0.7)
        self.assertIn("volume drift of the fluid: +0.100%", run.summary())

    # Seen to fail: with the last work on the structure in place of all that went to and fro.
    def test_the_summary_says_what_the_coupling_has_made(self):
        contents = {"case": "c", "status": "done", "wall_s": 1.0, "cpu_s": 1.0, "steps": 2,
                    "processes": {"coupler": {"exit_code": 0, "settings": {"dimension": 2}}}}
        for made, advised in ((0.6, True), (0.2, False)):
            (self.path / "energy.csv").write_text("t_s,interface_work_on_structure_J,interface_staggering_J\n"
                                                  f"0,0,0\n0.1,2,0.1\n0.2,1,{made}\n")
            text = summary.text(contents, self.path)
            self.assertIn(f"the coupling has made: +{made} J/m, {made / 3:.1%} of what went through the interface", text)
            self.assertEqual("half the windows" in text, advised)
        (self.path / "energy.csv").write_text("t_s,fluid_kinetic_J\n0,0\n0.1,1\n")
        self.assertNotIn("has made", summary.text(contents, self.path))

    # Seen to fail: without NEGLIGIBLE, with the potential energy itself in place of its change, and with the last kinetic energy in place
    # of the largest.
    def test_next_to_nothing_that_the_coupling_has_made_is_no_alarm(self):
        contents = {"case": "c", "status": "done", "wall_s": 1.0, "cpu_s": 1.0, "steps": 2,
                    "processes": {"coupler": {"exit_code": 0, "settings": {"dimension": 2}}}}
        for made, kinetic, potential, negligible in ((2e-10, 1e-4, -5e-3, True), (2e-6, 1e-4, -5e-3, True), (2e-6, 5e-3, 0, True),
                                                     (2e-6, 1e-4, 0, False), (6e-6, 1e-4, -5e-3, False)):
            (self.path / "energy.csv").write_text("t_s,fluid_kinetic_J,fluid_potential_J,interface_work_on_structure_J,"
                                                  f"interface_staggering_J\n0,0,100,0,0\n0.1,{kinetic},{100 + potential},{made / 2},0\n"
                                                  f"0.2,0,{100 + potential},{made / 2},{made}\n")
            line = next(line for line in summary.text(contents, self.path).splitlines() if "has made" in line)
            self.assertEqual("200.0% of what went" in line and "half the windows" in line, not negligible, line)
            self.assertEqual(line.endswith(f"+{made:.3g} J/m, less than 0.1% of what the run has moved"), negligible, line)

    # Seen to fail: with the last row in place of the steps from row to row (works that drift apart); without the bound of
    # how much they go together (works that do not); without the question whether the structure is foreign; with 5 rows.
    def test_a_foreign_structure_whose_work_is_not_that_of_the_coupler_is_named(self):
        steps = [math.sin(0.7 * n) for n in range(30)]
        other = [math.cos(1.9 * n) for n in range(30)]
        header = "t_s,interface_work_on_structure_J,interface_work_on_fluid_J\n0,0,0\n"
        twice = [2 * a for a in steps]
        for command, told, found, factor in (("my beam.py", twice, steps, "2"), (None, twice, steps, None),
                                             ("my beam.py", [-a for a in steps], steps, "-1"), ("my beam.py", other, steps, None),
                                             ("my beam.py", [1.2 * a for a in steps], steps, None),
                                             ("my beam.py", twice[:10], steps[:10], None),
                                             ("my beam.py", steps, [a + 0.1 for a in steps], None)):
            sums = zip(itertools.accumulate(told), itertools.accumulate(found))
            (self.path / "energy.csv").write_text(header + "".join(f"{n},{a},{-b}\n" for n, (a, b) in enumerate(sums, 1)))
            contents = {"commands": {"structure": command} if command else {},
                        "processes": {"coupler": {"settings": {"dimension": 2}}}}
            said = summary.warnings(contents, self.path)
            self.assertEqual(len(said), 1 if factor else 0, said)
            if factor:
                self.assertIn(f"tells of {sum(told):.3g} J/m of work", said[0])
                self.assertIn(f"of {sum(found):.3g} J/m that the fluid has lost to it; from row to row of energy.csv the first is {factor} "
                              "times the second.", said[0])
                self.assertIn("./tern conform structure 'my beam.py'", said[0])

    # Seen to fail: with a plain exception.
    def test_a_directory_without_results_is_an_error_of_tern(self):
        for directory, sentence in ((self.path, "holds no results"), (self.path / "nowhere", "There is no directory")):
            with self.assertRaisesRegex(tern.Error, sentence) as caught:
                tern.Run(directory)
            self.assertEqual(caught.exception.exit_code, 2)


if __name__ == "__main__":
    unittest.main()
