#!/usr/bin/python3 -B
"""./tern run --record and the participants that play a record back.

How the tests were seen to fail is said in each.
"""

import signal
import unittest

from fake_build import ROOT
from real_run import RealRunTest, SCENE, without_waits

from tern.participant.recording import messages

PARTICIPANTS = ROOT / "python" / "tern" / "participant" / "solvers"
PISTON = ROOT / "tests" / "process" / "cases" / "rigid_piston"


class RecordingTest(RealRunTest):
    def run_in(self, name, *words, case=SCENE):
        self.out = self.path / name
        process = self.start("--quiet", *words, case=case)
        _, errors = process.communicate(timeout=120)
        return process.returncode, without_waits(errors)

    def play(self, role, name, *words):
        return self.run_in(name, f"--{role}", f"{PARTICIPANTS}/recorded_{role}.py --from {self.path}/first", *words)

    def record(self, *words):
        self.assertEqual(self.run_in("first", "--record", *words), (0, ""))

    def frames(self, name, role):
        import h5py
        with h5py.File(self.path / name / f"{role}.h5", "r") as file:
            return {f"{frame}/{field}": file[frame][field][()].tobytes() for frame in file for field in file[frame]}

    def assert_same(self, role):
        """The frames of the side that was computed, and all curves."""
        for table in ("gauges.csv", "energy.csv"):
            self.assertEqual(*((self.path / name / table).read_bytes() for name in ("first", "second")), table)
        self.assertTrue(self.frames("first", role) == self.frames("second", role), "the frames differ in their bits")

    # Seen to fail: with another first number in each InterfacePressure of recorded_fluid.py; with 1.001 times the velocities of each
    # Surface in recorded_structure.py.
    def test_a_side_that_is_played_back_gives_the_same_bits(self):
        self.record("--until", "0.15")
        for role, computed in (("fluid", "structure"), ("structure", "fluid")):
            self.assertEqual(self.play(role, "second", "--until", "0.15", "--force"), (0, ""))
            self.assert_same(computed)

    # Seen to fail: with the last answer not kept (the record is one message short of every window, and ends), and with the rest not
    # passed over (an InterfacePressure where a WindowDone is due).
    def test_the_trials_may_be_more_or_fewer_than_recorded(self):
        sides = {"fluid": f"{PARTICIPANTS}/column_fluid.py --step 2e-4", "structure": f"{PARTICIPANTS}/rigid_spring.py --stiffness 2e7"}

        def run(name, tolerance, *words, **changed):
            commands = [part for role, command in (sides | changed).items() for part in (f"--{role}", command)]
            result = self.run_in(name, "--until", "0.02", "--set", f"coupling.tolerance={tolerance}", *commands, *words, case=PISTON)
            self.assertEqual(result, (0, ""))
            return self.contents()["processes"]["coupler"]["measures"]["coupling_iterations_mean"]

        trials = run("first", 1e-4, "--record")
        for role, computed in (("fluid", "structure"), ("structure", "fluid")):
            again = {role: f"{PARTICIPANTS}/recorded_{role}.py --from {self.path}/first"}
            self.assertEqual(run("second", 1e-4, "--force", **again), trials)
            self.assert_same(computed)
            # What is played back no longer answers: the trials end when the answer stays the same.
            self.assertGreater(run("second", 1e-9, "--force", **again), trials)
            self.assertLess(run("second", 0.9, "--force", **again), trials)

    # Seen to fail: without the refusals of recording.py (a run of other windows goes on; a fluid of another density as well).
    def test_what_does_not_belong_to_the_record_is_refused(self):
        self.record("--until", "0.1")
        self.assertEqual(self.play("fluid", "second", "--until", "0.1", "--set", "structure.body.plate.young_modulus=2e6"), (0, ""))
        for sentence, words in ((r"was made with fluid.density = 1000.0, and this case has 900.0", ("--set", "fluid.density=900")),
                                (r"Window \d+ ends at t = .* can be played back only in the windows it was made in",
                                 ("--set", "output.frame_interval=0.03")),
                                (r"interface.record ends with window \d+; end this run there, with --until 0.1\b",
                                 ("--until", "60"))):
            code, errors = self.play("fluid", "second", "--until", "0.1", "--force", *words)
            self.assertEqual(code, 2, errors)
            self.assertRegex(errors, sentence)
        (self.path / "first" / "interface.record").unlink()
        code, errors = self.play("fluid", "second", "--force")
        self.assertEqual(code, 2, errors)
        self.assertIn("has no interface.record; make one with ./tern run CASE --record", errors)

    # Seen to fail: without the test of the stream in MessageRecord's constructor.
    def test_a_record_that_cannot_be_written_ends_the_run(self):
        (self.path / "first" / "interface.record").mkdir(parents=True)
        code, errors = self.run_in("first", "--record", "--until", "0.01")
        self.assertEqual(code, 5, errors)
        self.assertIn("interface.record: Is a directory; free space, choose another --out, or run without --record", errors)

    # Seen to fail: without the test for a message that is cut short in messages() (DecodeError).
    def test_an_interrupted_run_leaves_a_record_that_can_be_read(self):
        self.out = self.path / "first"
        process = self.start("--record", "--quiet")
        self.wait_until_running(process)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
        path = self.out / "interface.record"
        whole = list(messages(path))
        self.assertGreater(len(whole), 60)
        self.assertEqual([message.WhichOneof("body") for message in whole[:2]], ["hello", "hello"])
        path.write_bytes(path.read_bytes()[:-3])
        self.assertEqual(list(messages(path)), whole[:-1])


if __name__ == "__main__":
    unittest.main()
