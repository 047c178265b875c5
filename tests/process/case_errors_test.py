"""Bad case files end every executable with exit code 2 and one sentence that names place, value and remedy, before anything runs."""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

from fake_build import ROOT

BUILD = pathlib.Path(os.environ.get("TERN_BUILD", ROOT / "build" / "release"))
CASE = ROOT / "cases" / "dam_break_plate" / "case.toml"


def run(program, *arguments):
    return subprocess.run([BUILD / program, *arguments], capture_output=True, text=True, timeout=60, check=False)


class CaseErrors(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name) / "case.toml"

    def write(self, old, new):
        """The dam break with one piece of its text replaced."""
        text = CASE.read_text()
        self.assertIn(old, text)
        self.path.write_text(text.replace(old, new, 1))

    def line_of(self, text):
        return next(number for number, line in enumerate(self.path.read_text().splitlines(), 1) if text in line)

    def expect_refused(self, answer, *parts):
        self.assertEqual(answer.returncode, 2, answer.stderr)
        self.assertEqual(answer.stdout, "")
        lines = answer.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, answer.stderr)
        for part in parts:
            self.assertIn(part, lines[0])

    # Seen to fail with the place of the table instead of the key's given for an unknown key.
    def test_unknown_key_names_its_place_and_the_nearest_key(self):
        self.write("spacing = 0.004", "spacings = 0.004")
        line = self.line_of("spacings")
        self.expect_refused(run("tern-case", "check", self.path), f"{self.path}:{line}:1", "'spacings'", "did you mean 'spacing'?")

    # Seen to fail with toml++'s exception let through: the exit code was 3.
    def test_duplicate_key_is_not_valid(self):
        self.write("density = 997", "density = 997\ndensity = 998")
        self.expect_refused(run("tern-case", "check", self.path), f"{self.path}:{self.line_of('density = 998')}:", "density")

    # Seen to fail with the range left out of the sentence.
    def test_value_out_of_range_names_table_key_unit_and_range(self):
        answer = run("tern-case", "check", CASE, "--set", "fluid.density=-3")
        self.expect_refused(answer, "--set fluid.density", "density [kg/m^3] of [fluid]", "-3", "from 1e-09 to 1e+09")

    # Seen to fail with the check of the placement left out: the plate hung below the floor.
    def test_plate_outside_the_tank(self):
        answer = run("tern-case", "check", CASE, "--set", "structure.body.plate.clamp=[]")
        self.expect_refused(answer, "'plate' stands outside the container", "clamp")

    # Seen to fail with the overlap check left out.
    def test_water_over_the_plate(self):
        answer = run("tern-case", "check", CASE, "--set", "fluid.body.0.shape.box.max=[0.7, 0.4]")
        self.expect_refused(answer, "overlap", "plate")

    # Seen to fail with the position counted from 0.
    def test_bad_expression_names_the_position(self):
        answer = run("tern-case", "check", CASE, "--set", 'gravity=[0, "-9.81*q"]')
        self.expect_refused(answer, "'-9.81*q'", "position 7")

    # Seen to fail with CLI11's own exit code (106) returned.
    def test_bad_options(self):
        self.expect_refused(run("tern-case", "check", CASE, "--sett", "a=b"), "--sett")
        self.expect_refused(run("tern-case", "check"), "CASE")
        self.expect_refused(run("tern-case"), "subcommand")
        self.expect_refused(run("tern-case", "check", CASE, "--set", "fluid.density"), "table.key=value")
        self.expect_refused(run("tern-case", "check", self.path.parent / "nowhere"), "There is no case")

    # Seen to fail with a valid case in place of the bad one.
    def test_processes_refuse_a_bad_case_before_they_leave_anything(self):
        self.write("spacing = 0.004", "spacing = -0.004")
        out = pathlib.Path(self.folder.name) / "out"
        for program in ("tern-fluid", "tern-structure", "tern-coupler"):
            endpoint = f"ipc://{self.folder.name}/tern.sock"
            answer = run(program, self.path, "--out", out, "--endpoint", endpoint)
            self.expect_refused(answer, f"{self.path}:{self.line_of('spacing = -0.004')}:1", "from 1e-09 to 1e+09")
            self.assertFalse(out.exists(), program)

    # Seen to fail with the overrides left out.
    def test_json_holds_the_effective_settings(self):
        answer = run("tern-case", "json", CASE, "--set", "fluid.spacing=0.008")
        self.assertEqual(answer.returncode, 0, answer.stderr)
        read = json.loads(answer.stdout)
        self.assertEqual(read["settings"]["fluid"]["spacing"], 0.008)
        self.assertEqual(read["settings"]["fluid"]["numerics"]["courant"], 0.4)
        self.assertEqual((read["name"], read["dimension"], read["has_fluid"], read["has_structure"]),
                         ("dam_break_plate", 2, True, True))
        other = json.loads(run("tern-case", "json", CASE).stdout)
        self.assertNotEqual(read["hash"], other["hash"])

    # Seen to fail with a case whose plate was moved out of the tank.
    def test_all_cases_of_the_project_are_valid(self):
        for case in sorted((ROOT / "cases").glob("*/case.toml")):
            for tool in ("check", "explain", "json"):
                answer = run("tern-case", tool, case)
                self.assertEqual(answer.returncode, 0, f"{case}: {answer.stderr}")


if __name__ == "__main__":
    unittest.main()
