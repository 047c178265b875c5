#!/usr/bin/python3 -B
"""./tern check and explain: costs measured on the machine, and what another error or time takes."""

import json
import os
import subprocess
import tempfile
import unittest
import unittest.mock
from pathlib import Path

from fake_build import ROOT
from real_run import build_directory

from tern.launch import calibration
from tern.studies import advice, front, rows


def tern(*words):
    answer = subprocess.run([ROOT / "tern", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=200, check=False,
                            env=os.environ | {"TERN_BUILD": str(build_directory())})
    return answer.returncode, answer.stdout, answer.stderr


class CostsTest(unittest.TestCase):
    # Seen to fail: with the steps left out of window_s, and with one pass of the structure per window.
    def test_costs_are_cpu_seconds_per_particle_and_step(self):
        part = {f"compute.{name}": 1.0 + n for n, name in enumerate(calibration.PARTS)}
        contents = {"steps": 100, "processes": {
            "fluid": {"cpu_s": 4.0, "timing_s": part, "counts": {"particles": 2000}},
            "structure": {"cpu_s": 2.0, "timing_s": {}, "counts": {"particles": 50, "sub_steps": 1000}},
            "coupler": {"cpu_s": 0.5, "timing_s": {}, "counts": {}}}}
        costs = calibration._costs(contents)
        self.assertAlmostEqual(costs["fluid_s"], 2e-5)
        self.assertAlmostEqual(costs["structure_s"], 2e-5)
        self.assertAlmostEqual(costs["window_s"], 5e-3)
        self.assertAlmostEqual(sum(costs["fluid_parts"].values()), 1)

    def test_many_processes_are_reckoned_from_the_same_costs(self):
        code, output, errors = tern("explain", "dam_break_plate_3d", "--ranks", "8")
        self.assertEqual(code, 0, errors)
        table = output[output.index("In 8 ranks"):].splitlines()
        rows = [line.split() for line in table[2:6]]
        self.assertEqual([row[0] for row in rows], ["1", "2", "4", "8"])
        self.assertEqual(rows[0][-4:], ["100", "%", *rows[0][-2:]])
        costs = json.loads((build_directory() / "costs.json").read_text())
        particles, value, unit = float(rows[0][1]), float(rows[0][3]), rows[0][4]
        step = value * {"s": 1, "ms": 1e-3}[unit]
        self.assertTrue(3 * costs["fluid_s"] * particles * 0.99 < step < 3 * 1.5 * costs["fluid_s"] * particles, (step, particles))
        self.assertIn("Structure and coupler are one process each", table[6])

    def test_what_cannot_be_reckoned_is_refused(self):
        for words, sentence in ((["dry_plate", "--ranks", "4"], "has no fluid"), (["piston", "--cluster", "x"], "add --ranks"),
                                (["piston", "--ranks", "4", "--cluster", "/no/such/file"], "cannot be read")):
            code, _, errors = tern("explain", *words)
            self.assertEqual(code, 2)
            self.assertIn(sentence, errors)

    # Seen to fail: with the file written anew at every call.
    def test_they_are_measured_once_and_used(self):
        path = build_directory() / "costs.json"
        path.unlink(missing_ok=True)
        code, output, errors = tern("check", "dam_break_plate")
        self.assertEqual((code, errors), (0, "tern: measuring once what a step costs on this machine (some seconds)\n"))
        self.assertIn("measured on this machine", output)
        costs = json.loads(path.read_text())
        for cost in ("fluid_s", "structure_s", "window_s"):
            self.assertTrue(1e-9 < costs[cost] < 1e-1, costs)
        code, output, errors = tern("explain", "dam_break_plate")
        self.assertEqual((code, errors), (0, ""))
        self.assertIn(f"measured on this machine on {costs['measured']}", output)
        self.assertRegex(output, r"fluid +\d+ s +\d+ %  assembly \d+ %, boundary \d+ %")
        self.assertIn("For another error or time", output)

    def test_without_a_whole_build_typical_costs_have_to_do(self):
        with tempfile.TemporaryDirectory(prefix="tern-test-") as directory:
            self.assertIsNone(calibration.costs_file(Path(directory)))


class AdviceTest(unittest.TestCase):
    def case(self, name, *sides, **settings):
        return {"name": name, "has_fluid": "fluid" in sides, "has_structure": "structure" in sides,
                "settings": {side: {} for side in sides} | settings}

    # Seen to fail: with all scenes taken for like ones; with the speed-up in place of the share of the time.
    def test_it_comes_from_the_scene_itself_or_from_its_like(self):
        own = advice.text(self.case("gray_cantilever", "structure"))
        self.assertIn("measured in this scene", own)
        self.assertRegex(own, r"--preset draft +0\.0\d+ times the CPU time, error \+0\.\d+ %")
        like = advice.text(self.case("of_mine", "fluid", "structure"))
        self.assertIn("measured in dam_break_obstacle, dam_break_plate, hydrostatic_plate, ring_in_annulus;", like)
        self.assertRegex(like, r"--preset reference +[\d.]+ to [\d.]+ times the CPU time")
        self.assertIn("./tern study of_mine --error 1%", like)
        fluid = advice.text(self.case("of_mine", "fluid"))
        self.assertIn("measured in dam_break_3d, dam_break_front, hydrostatic_tank, standing_wave;", fluid)
        self.assertNotIn("coupling.", fluid)

    # On dam_break_plate the finest run is 1.9 % from the next finest: no parameter but the spacing is worth a line. Seen to fail: with no
    # doubt of the finest run (seven parameters "better" by 0.1 to 0.3 %).
    def test_what_is_less_than_the_finest_run_is_off_is_no_advice(self):
        own = advice.text(self.case("dam_break_plate", "fluid", "structure"))
        self.assertIn("--preset draft", own)
        self.assertNotIn("--set", own)

    # hydrostatic_plate stands at 0.005, the others at 0.1. There, as if it did no harm: a change to twice that is advised, elsewhere not.
    # Seen to fail: with the effects of all scenes.
    def test_a_change_is_advised_only_from_where_it_was_measured(self):
        point = "fluid.numerics.gravity_courant=0.01"
        tables = {path.stem: rows.read(path) for path in sorted((ROOT / "docs" / "trade").glob("*plate.csv"))}
        harmless = front.find(tables["hydrostatic_plate"], point)
        harmless.error = front.find(tables["hydrostatic_plate"], "standard").error
        with unittest.mock.patch.object(advice, "_tables", lambda case: (tables, False)):
            for value, advised in ((0.005, True), (0.1, False)):
                settings = {"fluid": {"numerics": {"gravity_courant": value}}, "structure": {}}
                self.assertEqual(f"--set {point}" in advice.text(self.case("of_mine", "fluid", "structure", **settings)), advised, value)



if __name__ == "__main__":
    unittest.main()
