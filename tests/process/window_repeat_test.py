#!/usr/bin/python3 -B
"""Windows that fail are taken back and repeated at half their length, and the record says so."""

import csv
import json
import subprocess
import tempfile
import unittest
from pathlib import Path

from fake_build import ROOT
from same_results import differences

# A vibrating ring round which the fluid begins in potential flow: nothing but the slow fluid limits the windows, and they are too long.
RING = ROOT / "tests" / "process" / "cases" / "ring_in_flow"


class WindowRepeatTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.path = Path(scratch.name)

    def run_case(self, case, out, *options):
        ended = subprocess.run([ROOT / "tern", "run", case, "--out", out, "--quiet", *options], capture_output=True, text=True, timeout=300,
                               check=False)
        contents = json.loads((out / "run.json").read_text(encoding="utf-8"))
        return ended.returncode, ended.stderr, contents

    # Seen to fail: without window_repeat.plan (exit code 3 after 8 windows).
    def test_windows_that_fail_are_repeated_at_half_their_length(self):
        out = self.path / "run"
        code, errors, contents = self.run_case(RING, out)
        self.assertEqual(code, 0, errors)
        repeats = contents["taken_back"]
        self.assertEqual((repeats[0]["step"], repeats[0]["time_s"], repeats[0]["halvings"]), (0, 0.0, 1))  # among the first windows
        later = [repeat for repeat in repeats if repeat["step"] > 0]  # from a state that was kept
        self.assertTrue(later, repeats)
        for repeat in later:
            self.assertLess(repeat["time_s"], repeat["failed_at_s"])
            self.assertIn(f"Windows are taken back to t = {repeat['time_s']:.6g} s and repeated, 1/{2**repeat['halvings']} as long", errors)
        with open(out / "steps.csv", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
        self.assertEqual(len(rows), contents["steps"])
        self.assertIn("repeated", {row["limit"] for row in rows})
        times = [0.0, *(float(row["t_s"]) for row in rows)]
        lengths = [float(row["dt_s"]) for row in rows]
        for before, after, length in zip(times, times[1:], lengths):  # no gap and no overlap where windows were taken back
            self.assertAlmostEqual(after - before, length, delta=1e-6)
        self.assertEqual(times[-1], 9.0)

        self.run_case(RING, self.path / "again")
        self.assertEqual(differences(out, self.path / "again"), [])

    # A failure that shorter windows cannot mend.
    def test_a_body_that_falls_on_the_floor_is_not_repeated(self):
        code, errors, contents = self.run_case(ROOT / "tests" / "process" / "cases" / "small_plate", self.path / "run", "--set",
                                               "structure.body.plate.velocity=[-3, 0]", "--set", "structure.body.plate.young_modulus=3e4",
                                               "--set", "coupling.algorithm=auto")
        self.assertEqual(code, 3, errors)
        self.assertIn("has entered", contents["first_cause"])
        self.assertNotIn("taken_back", contents)


if __name__ == "__main__":
    unittest.main()
