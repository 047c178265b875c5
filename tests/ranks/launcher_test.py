"""./tern run --ranks: results, refusals, and how such a run ends.

Seen red: with another number of ranks in one of the ten launches (Results); with cuts and shares that a checkpoint does not hold
(Continued); with a first_cause that does not ask which rank was killed, and with the second that mpirun gives ranks to end (Ends).
"""

import json
import os
import signal
import subprocess
import time
import unittest

import numpy

from ranks_run import COARSE, OVERSUBSCRIBED, ROOT, RanksTest, alive, children_of, numbers_of

FALLING = """
title = "Water that falls out of its domain"
dimension = 2
end_time = 1
gravity = [0, -9.81]

[domain]
min = [0, 0]
max = [1, 1]

[fluid]
density = 1000
spacing = 0.01

[[fluid.body]]
shape = { box = { min = [0.4, 0], max = [0.6, 0.1] } }
"""


class Results(RanksTest):
    def test_one_rank_is_the_fluid_without_ranks(self):
        self.assertEqual(self.run_case("alone", "--until", "0.02", *COARSE)[0], 0)
        self.assertEqual(self.run_case("one", "--until", "0.02", "--ranks", "1", *COARSE), (0, ""))
        self.assert_the_same_results("alone", "one")

    def test_three_ranks_have_the_files_of_one(self):
        for count in (1, 3):
            self.assertEqual(self.run_case(f"n{count}", "--until", "0.05", "--ranks", str(count), *OVERSUBSCRIBED, *COARSE), (0, ""))
        one, three = self.frames("n1"), self.frames("n3")
        self.assertEqual(one.keys(), three.keys())
        for path, values in one.items():
            self.assertEqual((values.shape, values.dtype), (three[path].shape, three[path].dtype), path)
            if path.endswith("/id"):
                self.assertTrue(numpy.array_equal(values, three[path]))
            if path.endswith("/position"):
                self.assertLess(numpy.abs(values - three[path]).max(), 0.1 * 0.0073, path)
        fluid = self.contents("n3")["processes"]["fluid"]
        text = json.dumps(fluid)
        for name in ("ranks", "rank_imbalance", "ghost_share"):
            self.assertIn(f'"{name}"', text)

    def test_ten_launches_have_the_same_bits(self):
        for count in ("2", "3"):
            for launch in range(10):
                with self.subTest(ranks=count, launch=launch):
                    ended = self.run_case(f"n{count}-{launch}", "--until", "0.13", "--ranks", count, *OVERSUBSCRIBED, *COARSE)
                    self.assertEqual(ended, (0, ""))
                    self.assert_the_same_results(f"n{count}-0", f"n{count}-{launch}")
            self.assertGreaterEqual(self.contents(f"n{count}-0")["steps"], 50)


class Coupled(RanksTest):
    def test_one_rank_is_the_run_without_ranks(self):
        self.assertEqual(self.run_case("alone", "--until", "0.02", case="submerged_block")[0], 0)
        self.assertEqual(self.run_case("one", "--until", "0.02", "--ranks", "1", case="submerged_block")[0], 0)
        self.assert_the_same_results("alone", "one")

    def test_three_ranks_load_the_block_as_one_does(self):
        for count in (1, 3):
            self.assertEqual(self.run_case(f"n{count}", "--until", "0.1", "--ranks", str(count), *OVERSUBSCRIBED, case="submerged_block"),
                             (0, ""))
        rows = {}
        for count in (1, 3):
            with open(self.directory / f"n{count}" / "gauges.csv", encoding="utf-8") as file:
                names = file.readline().strip().split(",")
                rows[count] = [dict(zip(names, line.strip().split(","))) for line in file]
        self.assertEqual(len(rows[1]), len(rows[3]))
        for name in ("clamp.Fy_N_per_m", "water.Fy_N_per_m"):
            # The load is not known at the start.
            one, three = (numpy.array([float(row[name]) for row in rows[count][1:]]) for count in (1, 3))
            self.assertGreater(numpy.abs(one).max(), 400)
            self.assertLess(numpy.abs(one - three).max(), 1e-4 * numpy.abs(one).max(), name)
        one, three = (self.contents(f"n{count}")["processes"] for count in (1, 3))
        self.assertLessEqual(three["fluid"]["measures"]["pressure_iterations_mean"],
                             one["fluid"]["measures"]["pressure_iterations_mean"] + 2)
        self.assertEqual(three["fluid"]["evaluations"]["structure_surface"], one["fluid"]["evaluations"]["structure_surface"])


class Continued(RanksTest):
    SHORT_WINDOWS = ["--set", "fluid.numerics.gravity_courant=0.02"]  # so many that a quiet machine is not done before the interrupt
    UNTIL = ["--until", "0.3", *SHORT_WINDOWS]

    def interrupted(self, name, *words):
        process = self.start(name, *self.UNTIL, *words, case="submerged_block")
        steps = self.directory / name / "steps.csv"
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and not (steps.exists() and len(steps.read_text(encoding="utf-8").splitlines()) > 6):
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130)

    def go_on(self, name, *words):
        return subprocess.run([ROOT / "tern", "resume", self.directory / name, "--quiet", *words], stderr=subprocess.PIPE, text=True,
                              timeout=200, check=False).returncode

    def test_as_many_ranks_go_on_with_the_same_bits(self):
        self.assertEqual(self.run_case("whole", *self.UNTIL, "--ranks", "2", *OVERSUBSCRIBED, case="submerged_block")[0], 0)
        self.interrupted("part", "--ranks", "2", *OVERSUBSCRIBED)
        self.assertEqual(self.go_on("part"), 0)
        self.assert_the_same_results("whole", "part")

    def test_more_ranks_or_fewer_go_on_as_well(self):
        self.assertEqual(self.run_case("whole", "--until", "0.35", *self.SHORT_WINDOWS, case="submerged_block")[0], 0)
        self.interrupted("part", "--ranks", "2", *OVERSUBSCRIBED)
        self.assertEqual(self.go_on("part", "--ranks", "3"), 0)
        self.assertEqual(self.contents("part")["processes"]["fluid"]["counts"]["ranks"], 3)
        self.assertEqual(self.go_on("part", "--ranks", "1", "--until", "0.35"), 0)
        rows = [line.split(",") for line in (self.directory / "part" / "energy.csv").read_text(encoding="utf-8").splitlines()]
        self.assertAlmostEqual(float(rows[-1][0]), 0.35, places=6)
        last = {name: (self.directory / name / "energy.csv").read_text(encoding="utf-8").splitlines()[-1].split(",")
                for name in ("whole", "part")}
        self.assertAlmostEqual(float(last["part"][2]) / float(last["whole"][2]), 1, places=2)  # potential energy of the fluid


class Refusals(RanksTest):
    def test_names_what_several_ranks_cannot_compute(self):
        for words, what in ((["--only", "structure", "--endpoint", "ipc:///tmp/none.sock"], "structure alone"),
                            (["--fluid", "true"], "--fluid")):
            code, errors = self.run_case("refused", "--ranks", "2", *OVERSUBSCRIBED, *words, case="dam_break_plate")
            self.assertEqual(code, 2, errors)
            self.assertIn(what, errors)
            self.assertIn("ot with --ranks", errors)

    def test_more_ranks_than_cores(self):
        code, errors = self.run_case("many", "--ranks", "4096")
        self.assertEqual(code, 2)
        self.assertIn("--oversubscribe", errors)


class Ends(RanksTest):
    def test_an_interrupt_ends_all_with_readable_results(self):
        process = self.start("run", "--ranks", "2", *OVERSUBSCRIBED, "--set", "fluid.spacing=0.002")
        ranks = self.wait_for_ranks(process, 2)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130)
        self.assertFalse([pid for pid in ranks if alive(pid)])
        self.assertIn("frame_000000/position", self.frames("run"))
        self.assertEqual(self.contents("run")["status"], "interrupted")

    def test_a_killed_rank_is_named_and_no_other_is_left(self):
        for victim in (0, 1):
            with self.subTest(victim=victim):
                name = f"killed{victim}"
                process = self.start(name, "--ranks", "2", *OVERSUBSCRIBED, "--set", "fluid.spacing=0.002")
                ranks = self.wait_for_ranks(process, 2)
                os.kill(numbers_of(ranks)[victim], signal.SIGKILL)
                process.communicate(timeout=60)
                self.assertEqual(process.returncode, 4)
                self.assertIn(f"Rank {victim} of tern-fluid was killed by signal 9", self.contents(name)["first_cause"])
                self.assertFalse([pid for pid in ranks if alive(pid)])
                self.assertIn("frame_000000/position", self.frames(name))
                for path in self.directory.glob("*/steps.csv"):
                    path.unlink()

    def test_a_failure_has_its_sentence(self):
        case = self.directory / "case.toml"
        case.write_text(FALLING, encoding="utf-8")
        code, errors = self.run_case("failed", "--ranks", "2", *OVERSUBSCRIBED, case=case)
        self.assertEqual(code, 3, errors)
        self.assertIn("All fluid has left the domain", self.contents("failed")["first_cause"])

    def test_a_killed_process_of_a_coupled_run_is_named_within_a_second(self):
        for victim in ("rank 0", "rank 1", "tern-structure", "tern-coupler"):
            with self.subTest(victim=victim):
                name = victim.replace(" ", "")
                process = self.start(name, "--ranks", "2", *OVERSUBSCRIBED, "--set", "fluid.spacing=0.002", case="submerged_block")
                ranks = self.wait_for_ranks(process, 2)
                number = numbers_of(ranks)
                pid = number[int(victim[-1])] if "rank" in victim else dict(map(reversed, children_of(process.pid)))[victim]
                others = [other for other, program in children_of(process.pid) if program.startswith("tern-")]
                os.kill(pid, signal.SIGKILL)
                killed_at = time.monotonic()
                process.communicate(timeout=60)
                self.assertLess(time.monotonic() - killed_at, 2, "one second, and one for a loaded machine")
                self.assertEqual(process.returncode, 4)
                contents = self.contents(name)
                self.assertIn(f"{victim.capitalize()} of tern-fluid" if "rank" in victim else victim, contents["first_cause"])
                self.assertIn("killed by signal 9", contents["first_cause"])
                self.assertFalse([other for other in others if alive(other)])
                for path in self.directory.glob("*/steps.csv"):
                    path.unlink()


if __name__ == "__main__":
    unittest.main()
