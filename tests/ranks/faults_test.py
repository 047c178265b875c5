"""How a fluid in many processes meets what goes wrong, and who else may take part: stopped ranks, ranks without memory, full disks, windows
that are taken back, solvers of others.

Seen red: with the processes that are looked at for SIGSTOP those of the launcher alone (a stopped rank); with one stopped process taken for
a frozen run (a pause); with a launcher that does not read what one rank says, and, in one of three runs, with a first rank that ends as if
all had failed (memory); with SIGINT to mpirun in place of the first rank (the protocol).
"""

import json
import os
import resource
import signal
import subprocess
import time
import unittest

from network_run import NetworkRun, make_keys
from ranks_run import OVERSUBSCRIBED, ROOT, RanksTest, alive, children_of, numbers_of

CASES = ROOT / "tests" / "process" / "cases"
TWO = ["--ranks", "2", *OVERSUBSCRIBED]
LONG = ["--set", "fluid.spacing=0.002"]
SPRING = "rigid_spring.py --stiffness 2e7"
# A blow far from the others' water, too short to be foreseen: gravity is looked at every 5 ms of the second.
PULLED = """
title = "Two waters, one of which is torn away"
dimension = 2
end_time = 1
gravity = ["1e9*(x > 0.5)*(t > 0.0051)*(t < 0.0099)", -9.81]

[[wall]]
name = "tank"
container = { box = { min = [0, 0], max = [1, 1] } }
open = ["y_max"]

[fluid]
density = 1000
spacing = 0.01

[[fluid.body]]
shape = { box = { min = [0, 0], max = [0.2, 0.2] } }

[[fluid.body]]
shape = { box = { min = [0.7, 0], max = [0.9, 0.2] } }
"""


class FaultsTest(RanksTest):
    def begun(self, name, *words, **more):
        process = self.start(name, *words, **more)
        return process, numbers_of(self.wait_for_ranks(process, 2, name))

    def frames_are_readable(self, name):
        self.assertIn("frame_000000/position", self.frames(name))


class Failures(FaultsTest):
    def test_a_stopped_rank_is_named_within_ten_seconds(self):
        for victim in (0, 1):
            with self.subTest(victim=victim):
                name = f"stopped{victim}"
                process, ranks = self.begun(name, *TWO, *LONG)
                below = [pid for pid, _ in children_of(process.pid)]
                os.kill(ranks[victim], signal.SIGSTOP)
                stopped_at = time.monotonic()
                process.communicate(timeout=60)
                self.assertLess(time.monotonic() - stopped_at, 14, "ten seconds, two to end, and two for a loaded machine")
                self.assertEqual(process.returncode, 4)
                self.assertIn(f"Rank {victim} of tern-fluid was stopped (SIGSTOP)", self.contents(name)["first_cause"])
                self.assertEqual([pid for pid in below if alive(pid)], [])
                self.frames_are_readable(name)

    def test_a_pause_of_all_is_none(self):
        process, ranks = self.begun("paused", *TWO, *LONG)
        for pid in ranks.values():
            os.kill(pid, signal.SIGSTOP)
        time.sleep(11)
        self.assertIsNone(process.poll())
        for pid in ranks.values():
            os.kill(pid, signal.SIGCONT)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130)

    def test_the_failure_of_one_rank_has_its_sentence(self):
        case = self.directory / "case.toml"
        case.write_text(PULLED, encoding="utf-8")
        code, errors = self.run_case("failed", *TWO, case=case)
        self.assertEqual(code, 3, errors)
        self.assertIn("The speed of fluid particle", self.contents("failed")["first_cause"])
        place = float(self.contents("failed")["first_cause"].split("(")[1].split(",")[0])
        self.assertGreater(place, 0.5)

    def test_a_rank_without_memory_is_named(self):
        # Not the first: it may be about to open a file, and HDF5 does not survive that without memory.
        process, ranks = self.begun("memory", *TWO, *LONG)
        below = [pid for pid, _ in children_of(process.pid)]
        resource.prlimit(ranks[1], resource.RLIMIT_DATA, (1 << 20, 1 << 20))
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 3, errors)
        self.assertIn("Rank 1 of tern-fluid: It ran out of memory as one of 2 ranks", self.contents("memory")["first_cause"])
        self.assertEqual([pid for pid in below if alive(pid)], [])

    def test_a_full_disk_is_named(self):
        process, ranks = self.begun("full", *TWO, *LONG, "--set", "output.frame_interval=0.001")
        size = (self.directory / "full" / "fluid.h5").stat().st_size + 300000
        resource.prlimit(ranks[0], resource.RLIMIT_FSIZE, (size, size))
        below = [pid for pid, _ in children_of(process.pid)]
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 5)
        self.assertIn("fluid.h5", self.contents("full")["first_cause"])
        self.assertEqual([pid for pid in below if alive(pid)], [])
        self.frames_are_readable("full")

    def test_windows_that_fail_are_taken_back(self):
        structure = f"/usr/bin/python3 {ROOT}/tests/process/choosy_structure.py --stiffness 2e7 --longest 1.2e-3"
        code, errors = self.run_case("taken", *TWO, "--structure", structure, "--set", "output.checkpoint_interval=0.02", "--until", "0.03",
                                     case=CASES / "rigid_piston")
        self.assertEqual(code, 0, errors)
        contents = self.contents("taken")
        self.assertTrue(contents["taken_back"])
        self.assertEqual(contents["processes"]["fluid"]["counts"]["ranks"], 2)


class Others(FaultsTest):
    """Solvers that are not tern's, beside ranks."""

    UNTIL = ["--until", "0.005"]

    def test_a_foreign_structure_joins_a_fluid_of_ranks(self):
        case = ROOT / "cases" / "piston"
        self.assertEqual(self.run_case("local", *TWO, *self.UNTIL, "--structure", SPRING, case=case), (0, ""))
        (self.directory / "keys").mkdir()
        make_keys(self.directory / "keys")
        with NetworkRun(self.directory, os.environ["TERN_BUILD"], case, self.UNTIL, self.directory / "keys") as run:
            port = run.start_coupler()
            run.join("fluid", f"tcp://127.0.0.1:{port}", *TWO)
            run.join("structure", f"tcp://127.0.0.1:{port}", "--command", SPRING)
            self.assertEqual(run.codes(120), {"coupler": 0, "fluid": 0, "structure": 0}, run.everything_said())
        for name in ("gauges.csv", "energy.csv"):
            self.assertEqual((self.directory / "local" / name).read_bytes(), (self.directory / "out-coupler" / name).read_bytes())

    def test_a_record_of_ranks_is_played_back_with_the_same_bits(self):
        case, until = CASES / "small_plate", ["--until", "0.05"]
        self.assertEqual(self.run_case("recorded", *TWO, *until, "--record", case=case)[0], 0)
        record = self.directory / "recorded"
        self.assertEqual(self.run_case("structure", *TWO, *until, "--structure", f"recorded_structure.py --from {record}", case=case)[0], 0)
        self.assertEqual(self.run_case("fluid", *until, "--fluid", f"recorded_fluid.py --from {record}", case=case)[0], 0)
        expected = self.frames("recorded")
        for path, values in self.frames("structure").items():
            self.assertEqual(values.tobytes(), expected[path].tobytes(), path)
        self.assertEqual((self.directory / "recorded" / "gauges.csv").read_text(encoding="utf-8").count("\n"),
                         (self.directory / "fluid" / "gauges.csv").read_text(encoding="utf-8").count("\n"))

    def test_a_fluid_of_ranks_keeps_the_protocol(self):
        command = f"{ROOT}/tern run --only fluid --quiet --ranks 2 --oversubscribe"
        answer = subprocess.run([ROOT / "tern", "conform", "fluid", command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                timeout=400, check=False)
        self.assertEqual(answer.returncode, 0, answer.stdout)
        self.assertIn("28 of 28 checks hold", answer.stdout)


class Account(FaultsTest):
    """What is said of each rank."""

    def test_status_and_run_json_have_what_each_rank_does_and_spends(self):
        process, _ = self.begun("run", *TWO, *LONG)
        report = self.directory / "run" / "report.fluid.json"
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and "ranks" not in json.loads(report.read_text(encoding="utf-8")):
            time.sleep(0.2)
        said = subprocess.run([ROOT / "tern", "status", self.directory / "run"], capture_output=True, text=True, check=True).stdout
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        rows = self.contents("run")["processes"]["fluid"]["ranks"]
        self.assertEqual(len(rows), 2)
        self.assertEqual(sum(row["particles"] for row in rows), self.contents("run")["processes"]["fluid"]["counts"]["particles"])
        for row in rows:
            self.assertEqual(row["machine"], os.uname().nodename)
            self.assertGreater(row["ghosts"], 0)
            self.assertGreater(row["cpu_s"], 0)
            self.assertGreater(row["waiting_s"], 0)
            self.assertGreater(row["peak_memory_bytes"], 2e6)
        self.assertRegex(said, r"rank  particles    ghosts     CPU s  waiting s    MiB  machine\n\s+0 +\d+ +\d+")

    def test_a_short_run_has_it_too_and_says_it(self):
        with subprocess.Popen([ROOT / "tern", "run", "dam_break_front", "--out", self.directory / "run", "--until", "0.01", *TWO],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            said, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, errors)
        self.assertRegex(said, r"2 ranks: \d+ to \d+ particles \(1\.\d\d times the mean\), \d+% ghosts, waiting")

    def test_a_fluid_in_one_process_says_nothing_of_ranks(self):
        self.assertEqual(self.run_case("run", "--until", "0.002"), (0, ""))
        self.assertNotIn("ranks", self.contents("run")["processes"]["fluid"])


if __name__ == "__main__":
    unittest.main()
