#!/usr/bin/python3 -B
"""The three real processes when one of them is killed, frozen or the user ends the run: noticed in time, no survivor.

Seen to fail: killed fluid and coupler, without the monitors' DISCONNECTED event (5 s instead of 1); frozen, without
heartbeats (no end within 60 s); frozen together, with ZeroMQ's own limit of silence (exit code 4); Ctrl-C, with
interrupted() always false (the three have to be killed); killed launcher, without the guardian; threads, with an OpenMP
reduction in the dot product of the conjugate gradients.
"""

import os
import signal
import subprocess
import time
import unittest

from fake_build import ROOT
from real_run import ROLES, RealRunTest


class LostProcessTest(RealRunTest):
    def lose(self, role, number, limit_s, cause):
        process = self.start()
        pids = self.wait_until_running(process)
        self.assertEqual(sorted(pids), sorted(ROLES))
        began = time.monotonic()
        os.kill(pids[role], number)
        _, errors = process.communicate(timeout=60)
        took = time.monotonic() - began
        self.assertEqual(process.returncode, 4, errors)
        self.assertLess(took, limit_s, errors)
        contents = self.contents()
        self.assertEqual((contents["status"], contents["exit_code"]), ("peer lost", 4))
        self.assertRegex(contents["first_cause"], cause)
        self.assertEqual(sorted(contents["processes"]), sorted(ROLES))
        self.assert_nothing_left(pids.values())
        self.assert_readable()

    def test_a_killed_fluid_ends_the_run_within_a_second(self):
        self.lose("fluid", signal.SIGKILL, 2.0, r"tern-fluid was killed by signal 9 \(SIGKILL\)")

    def test_a_killed_structure_ends_the_run_within_a_second(self):
        self.lose("structure", signal.SIGKILL, 2.0, r"tern-structure was killed by signal 9 \(SIGKILL\)")

    def test_a_killed_coupler_ends_the_run_within_a_second(self):
        self.lose("coupler", signal.SIGKILL, 2.0, r"tern-coupler was killed by signal 9 \(SIGKILL\)")

    def test_a_frozen_fluid_is_noticed_within_ten_seconds(self):
        self.lose("fluid", signal.SIGSTOP, 13.0, "fluid")

    def test_a_frozen_structure_is_noticed_within_ten_seconds(self):
        self.lose("structure", signal.SIGSTOP, 13.0, "structure")

    def test_a_frozen_coupler_is_noticed_within_ten_seconds(self):
        self.lose("coupler", signal.SIGSTOP, 13.0, "coupler")


class FrozenTogetherTest(RealRunTest):
    """A machine that stands still for a while, by stopping everybody. The structure first, so that no message is under way."""

    def freeze_for_a_while(self, *words, **case):
        process = self.start("--quiet", *words, **case)
        own = self.wait_until_running(process)
        structure = own.pop("structure", None) or self.foreign(process)
        for number, pids, pause_s in ((signal.SIGSTOP, [structure], 2.5), (signal.SIGSTOP, own.values(), 12),
                                      (signal.SIGCONT, [*own.values(), structure], 0)):
            for pid in pids:
                os.kill(pid, number)
            time.sleep(pause_s)
        _, errors = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, errors)
        self.assertEqual(self.contents()["status"], "done")

    @staticmethod
    def foreign(process):
        """The process id of a participant in Python."""
        words = ["pgrep", "--parent", str(process.pid), "--full", "rigid_spring"]
        return int(subprocess.run(words, capture_output=True, text=True, check=True).stdout)

    def test_all_three_go_on_after_twelve_seconds(self):
        self.freeze_for_a_while("--until", "8")

    def test_a_structure_in_python_goes_on_after_twelve_seconds(self):
        self.freeze_for_a_while("--structure", "rigid_spring.py --stiffness 1e6", "--set", "end_time=3",
                                case=ROOT / "cases" / "conformance")

    def test_a_structure_in_python_notices_a_frozen_coupler(self):
        process = self.start("--quiet", "--structure", "rigid_spring.py --stiffness 1e6", "--set", "end_time=100",
                             case=ROOT / "cases" / "conformance")
        own = self.wait_until_running(process)
        os.kill(own["coupler"], signal.SIGSTOP)
        process.communicate(timeout=60)
        self.assertRegex(self.contents()["processes"]["structure"]["cause"], "The coupler process was lost at step")


class EndedByTheUserTest(RealRunTest):
    def test_ctrl_c_ends_all_three_within_two_seconds_with_readable_results(self):
        process = self.start()
        pids = self.wait_until_running(process)
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=20)
        self.assertLess(time.monotonic() - began, 2.0)
        self.assertEqual(process.returncode, 130, errors)
        contents = self.contents()
        self.assertEqual(contents["status"], "interrupted")
        self.assertEqual(set(contents["exit_codes"].values()), {130}, "each ended by itself, none had to be killed")
        self.assert_nothing_left(pids.values())
        self.assert_readable()

    def test_a_killed_launcher_takes_its_processes_with_it(self):
        process = self.start()
        pids = self.wait_until_running(process)
        process.kill()
        process.communicate(timeout=20)
        time.sleep(2.5)  # the guardian lets them write, then kills
        for role, pid in pids.items():
            self.assertFalse(os.path.exists(f"/proc/{pid}") and "Z" not in open(f"/proc/{pid}/stat").read().split()[2],
                             f"tern-{role} survived its launcher")
        self.assertEqual(list((self.path / "tmp").iterdir()), [])


class OneRunTest(RealRunTest):
    def test_a_short_run_ends_with_0_and_one_run_json(self):
        process = self.start("--until", "0.05")
        output, errors = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, errors)
        contents = self.contents()
        self.assertEqual(set(contents["exit_codes"].values()), {0})
        self.assertGreater(contents["steps"], 5)
        self.assertLessEqual(contents["processes"]["coupler"]["measures"]["momentum_audit_max"], 1e-10)
        self.assertIn("pictures: ./tern plot", output)
        self.assert_nothing_left([])
        self.assert_readable()

    def test_the_same_run_gives_the_same_bits_for_one_and_two_threads(self):
        import h5py
        positions = []
        for threads in ("1", "2"):
            self.out = self.path / f"run{threads}"
            # Fine enough for several blocks per sum and for parallel loops.
            process = self.start("--until", "0.05", "--threads", threads, "--quiet", "--set", "fluid.spacing=0.003")
            _, errors = process.communicate(timeout=300)
            self.assertEqual(process.returncode, 0, errors)
            last = []
            for role in ("fluid", "structure"):
                with h5py.File(self.out / f"{role}.h5", "r") as file:
                    frame = sorted(name for name in file if name.startswith("frame_"))[-1]
                    self.assertAlmostEqual(file[frame].attrs["time_s"], 0.05, 6)
                    last.append(file[frame]["position"][:].tobytes())
            positions.append(last)
        self.assertTrue(positions[0] == positions[1], "the positions differ in their bits")


if __name__ == "__main__":
    unittest.main()
