#!/usr/bin/python3 -B
"""./tern plot on small made-up results: coupled, one side alone, cut short, and a folder that is no run."""

import json
import subprocess
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent


def write_frames(path, position, **fields):
    with h5py.File(path, "w") as file:
        for number in range(3):
            group = file.create_group(f"frame_{number:06d}")
            group.attrs["time_s"], group.attrs["step"] = 0.1 * number, number
            group["position"] = position
            for name, values in fields.items():
                group[name] = values


def block(x, y, width, height, spacing):
    grid = np.mgrid[x:x + width:spacing, y:y + height:spacing].reshape(2, -1).T + 0.5 * spacing
    return np.column_stack([grid, np.zeros(len(grid))])


class PlotTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.run_directory = Path(directory.name) / "made_up"
        self.run_directory.mkdir()

    def write(self, fluid=True, structure=True, tables=True):
        if fluid:
            water = block(0, 0, 0.2, 0.1, 0.01)
            write_frames(self.run_directory / "fluid.h5", water, pressure=9810 * (0.1 - water[:, 1]),
                         velocity=0 * water)
        if structure:
            plate = block(0.3, -0.01, 0.008, 0.06, 0.002)
            write_frames(self.run_directory / "structure.h5", plate, stress_xy=1e3 * plate[:, 1],
                         clamped=(plate[:, 1] < 0).astype(np.int32), surface_position=block(0.299, 0, 0.001, 0.05, 0.002))
        if tables:
            (self.run_directory / "gauges.csv").write_text("t_s,P.ux_m,front_m\n0,0,\n0.1,0.01,0.2\n0.2,0.02,0.3\n")
            (self.run_directory / "energy.csv").write_text("t_s,fluid_kinetic_J,fluid_potential_J\n0,0,5\n0.1,1,4\n")
            (self.run_directory / "steps.csv").write_text("t_s,dt_s,limit,pressure_iterations,wall_ms\n"
                                                         "0.1,0.1,gravity,5,2\n0.2,0.1,velocity,,3\n")

    def plot(self, *words):
        answer = subprocess.run([ROOT / "tern", "plot", self.run_directory, *words], capture_output=True, text=True,
                                check=False)
        return answer.returncode, {Path(line).name for line in answer.stdout.splitlines()}, answer.stderr

    def test_a_coupled_run_gives_fields_gauges_energies_and_steps(self):
        # Seen to fail: with curves.energies() left out of plot().
        self.write()
        (self.run_directory / "run.json").write_text(json.dumps({
            "case": "made_up", "case_path": str(self.run_directory / "case.toml"), "settings": {
                "dimension": 2, "wall": [{"container": {"box": {"min": [0, 0], "max": [0.4, 0.2]}}, "open": ["y_max"]}]}}))
        code, pictures, errors = self.plot("--times", "0.09")
        self.assertEqual((code, errors), (0, ""))
        self.assertEqual(pictures, {"field_0.100s.png", "gauges.png", "energies.png", "steps.png"})
        for picture in pictures:
            content = (self.run_directory / "plots" / picture).read_bytes()
            self.assertTrue(content.startswith(b"\x89PNG") and len(content) > 5000, picture)

    def test_either_side_alone_and_a_run_without_run_json_can_be_drawn(self):
        # Seen to fail: with _limits() and _foot() taking both sides for granted.
        for sides in ({"structure": False}, {"fluid": False, "tables": False}):
            for file in self.run_directory.glob("*.*"):
                file.unlink()
            self.write(**sides)
            code, pictures, errors = self.plot()
            self.assertEqual((code, errors), (0, ""))
            self.assertIn("field_0.200s.png", pictures)

    def test_several_runs_are_compared(self):
        # Seen to fail: without the comparison in main().
        self.write(fluid=False, structure=False)
        code, pictures, _ = self.plot(str(self.run_directory))
        self.assertEqual(code, 0)
        self.assertIn("comparison.png", pictures)

    def test_the_reference_named_in_expected_toml_is_drawn(self):
        # Seen to fail: with references() returning {}.
        self.write(fluid=False, structure=False)
        (self.run_directory / "expected.toml").write_text(
            '[[quantity]]\nkind = "max_difference"\ncolumn = "P.ux_m"\ncsv = "r.csv"\ncsv_column = "u_m"\nsource = "S, x"\n')
        (self.run_directory / "r.csv").write_text("# source\nt_s,u_m\n0,0\n1,9\n")
        (self.run_directory / "run.json").write_text(json.dumps({"case_path": str(self.run_directory / "case.toml")}))
        self.plot()
        with_reference = (self.run_directory / "plots" / "gauges.png").read_bytes()
        (self.run_directory / "expected.toml").unlink()
        self.plot()
        self.assertNotEqual(with_reference, (self.run_directory / "plots" / "gauges.png").read_bytes())

    def test_a_folder_that_is_no_run_is_refused_with_2(self):
        # Seen to fail: without the check in Run.__init__().
        code, pictures, errors = self.plot()
        self.assertEqual((code, pictures), (2, set()))
        self.assertIn("holds no results", errors)


if __name__ == "__main__":
    unittest.main()
