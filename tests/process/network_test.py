#!/usr/bin/python3 -B
"""Runs over TCP with keys: the same bits as on one machine, delays, a link that is cut, strangers on the port.

Seen to fail: see each test.
"""

import os
import resource
import socket
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from fake_build import ROOT, wait_until
from network_run import NetworkRun, local_results, make_keys
from real_run import SCENE, build_directory
from relay import Relay

BITS = ROOT / "tests" / "process" / "cases" / "splash_plate"


class NetworkTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.build = build_directory()
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        cls.addClassCleanup(directory.cleanup)
        cls.all_keys = Path(directory.name) / "keys"
        cls.all_keys.mkdir()
        make_keys(cls.all_keys)
        local = Path(directory.name) / "local"
        subprocess.run([ROOT / "tern", "run", BITS, "--out", local, "--quiet"], check=True,
                       env=os.environ | {"TERN_BUILD": str(cls.build)})
        cls.local = local_results(local)

    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.path = Path(directory.name)

    def run_of(self, case, *options, keys=True):
        run = NetworkRun(self.path, self.build, case, options, self.all_keys if keys else None)
        self.addCleanup(run.__exit__)
        return run

    def relay(self, port, **words):
        relay = Relay(port, **words)
        relay.__enter__()
        self.addCleanup(relay.__exit__)
        return relay

    def assert_same_bits(self, run):
        self.assertEqual(run.codes(60), {role: 0 for role in run.processes}, run.everything_said())
        found = run.results()
        self.assertGreater(len(found), 10)
        self.assertEqual([name for name in self.local if found.get(name) != self.local[name]], [])
        self.assertEqual(set(found), set(self.local))

    # Seen to fail with the local run ended at 0.099 s instead of 0.1 s. The participant that is first waits, and says for whom;
    # seen to fail without speak_after() in participant_channel.cpp.
    def test_three_commands_over_tcp_with_keys_give_the_bits_of_the_local_run(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        run = self.run_of(BITS)
        run.join("fluid", f"tcp://localhost:{port}")
        self.assertTrue(wait_until(lambda:
                                   f"fluid waits for a coupler at tcp://localhost:{port}, where nobody answers" in run.said("fluid"), 20),
                        run.said("fluid"))
        run.start_coupler(f"tcp://localhost:{port}")
        run.join("structure", f"tcp://127.0.0.1:{port}")
        self.assert_same_bits(run)
        self.assertFalse((run.out("fluid") / "gauges.csv").exists())
        self.assertEqual(run.contents("structure")["exit_codes"], {"structure": 0})
        self.assertIn("for the 2 keys of", (run.out("coupler") / "coupler.log").read_text())

    # Seen to fail (exit code 4) with longest_silence_s = 1.
    def test_a_link_that_is_cut_for_two_seconds_delays_the_run_and_changes_no_bit(self):
        run = self.run_of(BITS)
        port = run.start_coupler()
        relay = self.relay(port, delay_s=0.010)
        run.join("fluid", f"tcp://127.0.0.1:{relay.port}")
        run.join("structure", f"tcp://127.0.0.1:{port}")
        self.assertTrue(run.wait_for_step(3))
        relay.cut()
        time.sleep(0.3)  # what was on its way has arrived
        before = (run.out("coupler") / "steps.csv").read_text()
        time.sleep(1.7)
        self.assertFalse(run.ended(), run.everything_said())
        self.assertEqual((run.out("coupler") / "steps.csv").read_text(), before)
        relay.heal()
        self.assert_same_bits(run)

    # Seen to fail (nobody ends) without looking at silences.
    def test_a_link_that_is_cut_for_good_ends_both_sides_with_the_cause(self):
        run = self.run_of(SCENE)
        port = run.start_coupler()
        relay = self.relay(port)
        run.join("fluid", f"tcp://127.0.0.1:{port}")
        run.join("structure", f"tcp://127.0.0.1:{relay.port}")
        self.assertTrue(run.wait_for_step(5))
        relay.cut()
        began = time.monotonic()
        codes = run.codes(15)
        self.assertEqual(codes, {role: 4 for role in codes}, run.everything_said())
        self.assertLess(time.monotonic() - began, 10)
        self.assertRegex(run.contents("coupler")["first_cause"], r"^The structure process .*was lost at step .*network to it was cut")
        self.assertRegex(run.contents("structure")["first_cause"], r"^The coupler process was lost at step .*network to it was cut")
        self.assertRegex(run.contents("fluid")["first_cause"], r"^The coupler process stopped .*The structure process .*was lost")
        for role in ("fluid", "structure"):
            self.assertGreater((run.out(role) / f"{role}.h5").stat().st_size, 0)

    # Seen to fail without raise_descriptor_limit() ("Too many open files" ends the coupler with exit code 5), and without the
    # rate of Refusals (over 100 lines).
    def test_a_flood_of_strangers_does_not_disturb_a_run(self):
        def few_descriptors():
            resource.setrlimit(resource.RLIMIT_NOFILE, (100, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
        run = self.run_of(BITS)
        port = run.start_coupler(preparation=few_descriptors)
        relay = self.relay(port, delay_s=0.010)  # long enough for a flood during the run
        strangers = []
        self.addCleanup(lambda: [stranger.close() for stranger in strangers])

        def flood(count):
            for number in range(count):
                strangers.append(socket.create_connection(("127.0.0.1", port), timeout=5))
                if number % 3:
                    strangers[-1].sendall(b"GET / HTTP/1.1\r\n\r\n" if number % 3 == 1 else b"\xff" * 200)
        flood(300)
        run.join("fluid", f"tcp://127.0.0.1:{relay.port}")
        run.join("structure", f"tcp://127.0.0.1:{port}")
        self.assertTrue(run.wait_for_step(2), run.everything_said())
        flood(300)
        self.assertFalse(run.ended(), run.everything_said())
        self.assert_same_bits(run)
        told = run.said("coupler").count("warning:")
        self.assertTrue(1 <= told <= 10, run.said("coupler"))

    # Seen to fail with the check of --bind left out of command_line.py.
    def test_what_cannot_work_ends_with_2_and_the_remedy(self):
        environment = os.environ | {"TERN_BUILD": str(self.build)}

        def refused(*words):
            answer = subprocess.run([ROOT / "tern", *words], cwd=self.path, env=environment, capture_output=True, text=True, timeout=30,
                                    check=False)
            self.assertEqual(answer.returncode, 2, answer.stderr)
            return answer.stderr
        self.assertRegex(refused("run", BITS, "--only", "coupler", "--bind", "tcp://0.0.0.0:0"), "--keys DIR.*--insecure")
        self.assertRegex(refused("join", "fluid", "tcp://no such host:5555", BITS), "cannot be found")
        self.assertRegex(refused("run", BITS, "--bind", "tcp://127.0.0.1:0"), "--only coupler")
        self.assertRegex(refused("keys", self.all_keys / "all"), "coupler.secret.*never overwritten")

    # Seen to fail with mode 644 for the secret keys.
    def test_secret_keys_are_private(self):
        for path in (self.all_keys / "all").iterdir():
            self.assertEqual(path.stat().st_mode & 0o777, 0o600 if path.suffix == ".secret" else 0o644, path)

    # Seen to fail without the warning of keys_for().
    def test_insecure_says_so_on_both_ends(self):
        run = self.run_of(BITS, "--insecure", "--until", "0.002", keys=False)
        port = run.start_coupler("tcp://0.0.0.0:*")
        # An address of this machine that is not a loopback one, if there is one: else the loopback address, without a warning.
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(("192.0.2.1", 9))
                here = probe.getsockname()[0]
            except OSError:
                here = "127.0.0.1"
        for role in ("fluid", "structure"):
            run.join(role, f"tcp://{here}:{port}")
        codes = run.codes(60)
        self.assertEqual(codes, {role: 0 for role in codes}, run.everything_said())
        for role in codes:
            if role == "coupler" or here != "127.0.0.1":
                self.assertIn("warning: --insecure: messages at", run.said(role))


if __name__ == "__main__":
    unittest.main()
