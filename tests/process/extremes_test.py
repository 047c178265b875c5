#!/usr/bin/python3 -B
"""./tern extremes: the quick map by real runs, and how cells are judged, boundaries found and maps resumed."""

import csv
import json
import os
import re
import signal
import subprocess
import tempfile
import time
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

from fake_build import ROOT, FakeBuild, wait_until
from real_run import build_directory

from tern.errors import Error
from tern.extremes import bisection, families, page, random_scenes, run_cell, scenes, verdict
from tern.extremes.table import Table

EXPECTED = {
    "density ratio 0.1, 4 across, E 1e+07 Pa, one face wet, explicit": ("stopped", "The interface has made"),
    "density ratio 0.1, 4 across, E 1e+07 Pa, one face wet, repeated": ("bounded", ""),
    "density ratio 0.01, 4 across, E 1e+09 Pa, both faces wet, repeated": ("bounded", ""),
    "density ratio 10, 2 across, E 1e+07 Pa, both faces wet, explicit": ("stopped", "turns round from window to window"),
    "density ratio 1, 4 across, E 1e+07 Pa, both faces wet, one pass": ("bounded", ""),
    "plate under water, Poisson's ratio 0.49999": ("bounded", ""),
    "plate of 20 mm, 1 across, both faces wet": ("stopped", "needs at least 2"),
    "structure over fluid 0.25, 20 mm, both faces wet": ("bounded", ""),
    "column that breaks, courant 0.6": ("stopped", r"from 0 \(excluded\) to 0\.5"),
    "plate, pressure solved to 1e-2": ("bounded", ""),
    "full tank with a plate in it, density ratio 1": ("bounded", ""),
    "drop at 10 m/s on a pool": ("bounded", ""),
    # Which of the two the collapsing columns show first is round-off: they are symmetric, and another processor breaks them elsewhere.
    "neo_hookean squeezed to 0.1 of its height": ("stopped", "J = det F|passed through each other"),
    "st_venant_kirchhoff squeezed to 0.1 of its height": ("stopped", "J = det F|passed through each other"),
    "water at rest without gravity": ("bounded", ""),
    "floor under water at rest for 20 sqrt(H/g)": ("bounded", ""),
    "structure over fluid 4, four across, one face wet": ("bounded", ""),
    "light and loosely solved: density ratio 0.1, tolerance 1e-2": ("bounded", ""),
    "standing plate in 3D, density ratio 1": ("bounded", ""),
    "floor in 3D, density ratio 0.1, one pass": ("bounded", ""),
}


class QuickMapTest(unittest.TestCase):
    # Seen to fail before these checks were there: the first cell by the structure at 2 km/s, the cell of the floor at rest (particles fell
    # through it), that of a structure four times as coarse as the fluid.
    def test_every_cell_has_the_class_it_should_have(self):
        self.assertEqual(set(EXPECTED), families.QUICK)
        with tempfile.TemporaryDirectory(prefix="tern-test-") as directory:
            answer = subprocess.run([ROOT / "tern", "extremes", "--quick", "--out", directory], capture_output=True, text=True, check=False,
                                    env=os.environ | {"TERN_BUILD": str(build_directory())}, timeout=300)
            with open(Path(directory) / "extremes.csv", encoding="utf-8", newline="") as file:
                rows = {row["cell"]: row for row in csv.DictReader(file)}
            self.assertGreater((Path(directory) / "families.png").stat().st_size, 20000)
        found = {name: row["class"] for name, row in rows.items()}
        self.assertEqual(found, {name: expected for name, (expected, _) in EXPECTED.items()}, answer.stdout)
        for name, (_, part) in EXPECTED.items():
            self.assertTrue(re.search(part, rows[name]["message"]), (name, rows[name]["message"]))
        self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)
        self.assertEqual(answer.stderr, "")


def results(directory, *, fluid=(0, 0, 0), staggering=0.0, loads=None, drift=0.001, speed=1.0,
            load_columns="load.Fx_N_per_m,load.Fy_N_per_m"):
    """A run that ended, by its files: three rows of the account, a load per window, the measures."""
    directory.mkdir(exist_ok=True)
    (directory / "run.json").write_text(json.dumps({"status": "done", "steps": 40, "first_cause": "", "processes": {"fluid": {
        "measures": {"largest_speed_of_run_m_per_s": speed, "volume_drift_largest": drift},
        "counts": {"particles": 100, "particles_leaked": 0}}}}))
    (directory / "energy.csv").write_text("t_s,fluid_kinetic_J,fluid_potential_J,interface_staggering_J\n"
                                          + "".join(f"{0.01 * n},{value},0,{staggering}\n" for n, value in enumerate(fluid)))
    (directory / "gauges.csv").write_text(f"t_s,{load_columns}\n"
                                          + "".join(f"{0.001 * (n + 1)},{'0,' * load_columns.count(',')}{value}\n" for n,
                                                    value in enumerate(loads or [0] * 40)))


class VerdictTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.path = Path(directory.name)
        self.cell = replace(scenes.plate("plates", "a plate"), speed=1.0, energy=10.0, load=1.0)

    def judged(self, code=0, **contents):
        results(self.path, **contents)
        return verdict.classify(self.cell, self.path, code)

    # Seen to fail with each limit left out in turn.
    def test_what_ended_is_bounded_within_its_limits_only(self):
        self.assertEqual(self.judged()["class"], "bounded")
        for contents, word in (({"speed": 2.1}, "speed"), ({"fluid": (0, 0.6, 0)}, "energy"), ({"drift": -0.06}, "volume"),
                               ({"loads": [0] * 20 + [0, 1] * 10}, "unrest")):
            row = self.judged(**contents)
            self.assertEqual((row["class"], word in row["message"]), ("wrong", True), row)
        self.assertEqual(self.judged(loads=[0, 1] * 10 + [0] * 20)["class"], "bounded")  # it dies out

    # Seen to fail with the columns of 2D alone.
    def test_the_load_of_three_dimensions_is_judged_like_that_of_two(self):
        ringing = [0] * 20 + [0, 1] * 10
        self.assertIn("unrest", self.judged(loads=ringing, load_columns="load.Fx_N,load.Fy_N,load.Fz_N")["message"])
        self.assertIn("no load", self.judged(loads=ringing, load_columns="other.Fx_N,other.Fy_N")["message"])

    def test_what_is_not_finite_is_wrong(self):
        self.assertEqual(self.judged(fluid=(0, float("nan"), 0))["class"], "wrong")
        self.assertEqual(self.judged(speed=float("nan"))["class"], "wrong")

    # Seen to fail with every message taken for right.
    def test_a_stop_needs_a_code_and_a_message_that_can_be_acted_upon(self):
        right = "It burst at t = 0.1 s: use a smaller fluid.numerics.courant."
        for code, sentence, expected in ((3, right, "stopped"), (2, "case.toml:3: courant of [fluid.numerics] is 7.", "stopped"),
                                         (3, "It burst at t = 0.1 s.", "wrong"), (3, "Use a smaller fluid.numerics.courant.", "wrong"),
                                         (4, right, "wrong"), (5, right, "wrong"), (1, right, "wrong"), (-11, right, "wrong")):
            (self.path / "run.json").write_text(json.dumps({"status": "", "first_cause": sentence, "steps": 3}))
            self.assertEqual(verdict.classify(self.cell, self.path, code)["class"], expected, (code, sentence))

    def test_a_run_that_does_not_end_is_wrong_and_is_ended(self):
        with FakeBuild() as fake, mock.patch.dict(os.environ, {"FAKE_COUPLER": "wait", "FAKE_FLUID": "wait", "FAKE_STRUCTURE": "wait",
                                                               "TMPDIR": str(fake.path / "tmp")}):
            row = run_cell.run_cell(self.cell, fake.path / "cells", fake.path / "build", longest=1.5)
            self.assertEqual((row["class"], row["message"]), ("wrong", "the run did not end in time"))
            self.assertTrue(wait_until(lambda: fake.temporary_files() == [], 5), fake.temporary_files())

    def test_a_killed_process_is_wrong_and_its_results_are_kept(self):
        with FakeBuild() as fake, mock.patch.dict(os.environ,
                                                  {"FAKE_FLUID": "kill 9", "FAKE_STRUCTURE": "exit 0", "FAKE_COUPLER": "exit 0"}):
            row = run_cell.run_cell(self.cell, fake.path / "cells", fake.path / "build")
            self.assertEqual((row["class"], row["exit_code"]), ("wrong", 4))
            self.assertIn("SIGKILL", row["message"])
            self.assertTrue((fake.path / "cells" / "a_plate" / "case.toml").is_file())


class RandomTest(unittest.TestCase):
    # Seen to fail: with one generator of random numbers for all scenes, and with a polygon written in another form.
    def test_a_seed_and_a_number_make_a_scene_that_check_knows(self):
        self.assertEqual(random_scenes.scene(3, 5), random_scenes.scene(3, 5))
        self.assertNotEqual(random_scenes.scene(3, 5).case, random_scenes.scene(4, 5).case)
        valid = 0
        with tempfile.TemporaryDirectory(prefix="tern-test-") as directory:
            for number in range(1, 41):
                (case := Path(directory) / "case.toml").write_text(random_scenes.scene(1, number).case)
                answer = subprocess.run([build_directory() / "tern-case", "check", case], capture_output=True, text=True)
                valid += answer.returncode == 0
                if answer.returncode:
                    self.assertRegex(answer.stderr, "mass than its shape|outside the container|particles across|reaches out")
        self.assertGreater(valid, 20)

    def test_scenes_run_with_all_defaults(self):
        with tempfile.TemporaryDirectory(prefix="tern-test-") as directory:
            answer = subprocess.run([ROOT / "tern", "extremes", "--random", "3", "--seed", "1", "--out", directory], capture_output=True,
                                    text=True, env=os.environ | {"TERN_BUILD": str(build_directory())})
            self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)
            self.assertIn("random scenes 1 to 3 of --seed 1", answer.stdout)
            self.assertEqual(len((Path(directory) / "extremes.csv").read_text().splitlines()), 4)


class BisectionTest(unittest.TestCase):
    # Seen to fail with a bounded middle taken for one beyond.
    def test_the_boundary_is_closed_in_on_from_both_sides(self):
        for low, high, limit in ((0.1, 10, 1.3), (10, 0.1, 1.3)):
            asked = []
            last, first = bisection.find(low, high, lambda v, up=low < high: asked.append(v) or (v < limit) == up, runs=6)
            self.assertTrue(min(last, first) <= limit <= max(last, first))
            self.assertLess(max(last, first) / min(last, first), 1.08)
            self.assertEqual(len(asked), 8)

    def test_a_range_without_a_boundary_says_so(self):
        self.assertEqual(bisection.text(*bisection.find(1, 2, lambda _: True)), "none up to 2")
        self.assertEqual(bisection.text(*bisection.find(1, 2, lambda _: False)), "not bounded at 1 either")


class ResumeTest(unittest.TestCase):
    # Seen to fail with the fingerprint left out of known().
    def test_what_has_been_run_is_not_run_again_unless_it_has_changed(self):
        with tempfile.TemporaryDirectory(prefix="tern-test-") as directory:
            path = Path(directory) / "extremes.csv"
            cell = scenes.tank("rest", "water, at rest")
            Table(path).add(cell, {"class": "bounded", "speed": 0.1})
            self.assertEqual(Table(path).known(cell)["class"], "bounded")
            self.assertIsNone(Table(path).known(replace(cell, options=("fluid.numerics.courant=0.1",))))
            with open(path, "a", encoding="utf-8") as file:
                file.write("rest,half a li")  # of a map that was killed
            table = Table(path)
            self.assertEqual(list(table.rows), [("rest", "water, at rest")])
            table.add(cell, {"class": "stopped"})
            self.assertEqual([row["class"] for row in Table(path).rows.values()], ["stopped"])

    def test_ctrl_c_ends_the_map_at_once_and_keeps_its_rows(self):
        with FakeBuild() as fake:
            environment = os.environ | {"TERN_BUILD": str(fake.path / "build"), "FAKE_COUPLER": "wait", "FAKE_FLUID": "wait",
                                        "FAKE_STRUCTURE": "wait", "TMPDIR": str(fake.path / "tmp")}
            process = subprocess.Popen([ROOT / "tern", "extremes", "--only", "pairs", "--out", fake.path / "map"], env=environment,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
            self.assertTrue(wait_until(lambda: list((fake.path / "map").glob("cells/*/run/pid.fluid")), 20))
            began = time.monotonic()
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=20)
            self.assertEqual((process.returncode, errors.strip()), (130, "tern: interrupted."))
            self.assertLess(time.monotonic() - began, 8)
            self.assertTrue((fake.path / "map" / "extremes.csv").is_file())
            self.assertTrue(wait_until(lambda: fake.temporary_files() == [], 5), fake.temporary_files())

    def test_an_unknown_family_is_refused_with_the_known_ones(self):
        with FakeBuild() as fake:
            answer = subprocess.run([ROOT / "tern", "extremes", "--only", "sprays"], cwd=fake.path, capture_output=True, text=True,
                                    check=False)
            self.assertEqual(answer.returncode, 2)
            for name in (*families.FAMILIES, "boundary"):
                self.assertIn(name, answer.stderr)


class PageTest(unittest.TestCase):
    def test_no_path_of_the_machine_gets_into_the_page(self):
        row = {"class": "wrong",
               "message": "/home/somebody/runs/cells/thin/case.toml:17:1: 'plate' is 1 particles across; 2 m/s is too fast."}
        self.assertEqual(page.outcome(row), "**wrong**: case.toml:17:1: 'plate' is 1 particles across; 2 m/s is too fast.")

    def test_the_section_is_replaced_and_the_rest_of_the_page_stays(self):
        with tempfile.TemporaryDirectory(prefix="tern-test-") as directory:
            path = Path(directory) / "page.md"
            path.write_text(f"before\n{page.BEGIN}\nold\n{page.END}\nafter\n")
            (path.parent / "map.png").write_bytes(b"a picture")
            page.insert(path, "new\n", [path.parent / "map.png"])
            self.assertEqual(path.read_text(),
                             f"before\n{page.BEGIN}\n![extremes: map](pictures/extremes_map.png)\n\nnew\n{page.END}\nafter\n")
            self.assertTrue((path.parent / "pictures" / "extremes_map.png").is_file())
            path.write_text("a page without markers\n")
            self.assertRaises(Error, page.insert, path, "new\n", [])


if __name__ == "__main__":
    unittest.main()
