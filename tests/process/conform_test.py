"""./tern conform: content with the real participants and with a small one, and not with one that breaks a rule."""

import os
import re
import socket
import subprocess
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fake_build import ROOT
from real_run import build_directory, conform

FAULTY = Path(__file__).with_name("faulty_structure.py")

# Every fault of faulty_structure.py, the check that must find it, and what the finding must say.
FAULTS = {
    "hash": ("hello", r"case_hash is 0; it must be [0-9a-f]{16}"),
    "account": ("hello", r"number of account.energy is 4; it must be 5"),
    "own exit code": ("abort", r"ended with exit code 1; it must be 3"),
    "sequence": ("order", r"sequence of surface is 5; it must be 2"),
    "normal": ("order", r"length of normal\[0\] is 1.1"),
    "short": ("order", r"position has 7 entries; it must have 8"),
    "not finite": ("order", r"velocity\[3\] is nan"),
    "talks": ("silence", r"surface_velocity came after the end of a window"),
    "forgets to restore": ("restore", r"the same trial got .* instead of"),
    "deaf": ("restore", r"the answer is the same whatever is tried"),
    "moves backwards": ("sense", r"does not move the surface along"),
    "stays": ("finish", r"no finished within"),
    "always content": ("finish interrupted", r"ended with exit code 0; it must be 130"),
    "silent interrupt": ("interrupt", r"ended with exit code 130 where abort was due"),
    "credulous": ("not finite", r"no abort within 2 s"),
}


class ConformTest(unittest.TestCase):
    def setUp(self):
        self.build = build_directory()

    def faulty(self, fault, *checks):
        words = [word for check in checks for word in ("--check", check)]
        return conform(self.build, "structure", f"/usr/bin/python3 {FAULTY} '{fault}'", *words)

    def test_our_own_participants_conform(self):
        for role in ("structure", "fluid"):
            code, text = conform(self.build, role, str(self.build / f"tern-{role}"))
            self.assertEqual(code, 0, text)
            self.assertRegex(text, r"(\d\d) of \1 checks hold")

    def test_a_small_participant_conforms(self):
        code, text = self.faulty("none")
        self.assertEqual(code, 0, text)

    # Seen to fail: with the same pressure on all faces ("the answer is the same whatever is tried").
    def test_a_rigid_body_that_nothing_holds_conforms(self):
        block = Path(__file__).with_name("free_block.py")
        checks = [word for check in ("restore", "sense", "faces", "work", "energy") for word in ("--check", check)]
        code, text = conform(self.build, "structure", f"/usr/bin/python3 {block}", *checks)
        self.assertEqual(code, 0, text)

    # Seen to fail: with the load of each point on the next one; with a window between that is as long as the others.
    def test_our_own_structure_makes_of_its_load_in_3d_what_it_accounts_for(self):
        checks = [word for check in ("motion", "faces", "work", "energy") for word in ("--check", check)]
        code, text = conform(self.build, "structure", str(self.build / "tern-structure"), "--case", "dam_break_plate_3d", *checks)
        self.assertEqual(code, 0, text)
        self.assertIn("4 of 4 checks hold", text)

    def test_every_fault_is_found_and_named(self):
        with ThreadPoolExecutor(2) as pool:
            answers = list(pool.map(lambda fault: self.faulty(fault, FAULTS[fault][0]), FAULTS))
        for (fault, (check, sentence)), (code, text) in zip(FAULTS.items(), answers):
            with self.subTest(fault):
                self.assertEqual(code, 3, text)
                self.assertTrue(re.search(rf"NO   {check}: .*{sentence}.*\[docs/PROTOCOL.md, \d", text), text)

    # Seen to fail: with the environment of the command left as it is.
    def test_a_script_somewhere_finds_the_library(self):
        with tempfile.TemporaryDirectory(prefix="tern-test-") as directory:
            script = Path(directory) / "mine.py"
            script.write_text(f"import runpy, sys\nfrom tern.participant import run_structure\n"
                              f"sys.argv[:1] = ['{FAULTY}', 'none']\nrunpy.run_path('{FAULTY}', run_name='__main__')\n")
            code, text = conform(self.build, "structure", f"/usr/bin/python3 {script}", "--check", "order")
            self.assertEqual(code, 0, text)

    # Seen to fail: with the first life of "trace" still at the address when the second begins.
    def test_a_participant_may_be_started_by_hand(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            address = f"tcp://127.0.0.1:{probe.getsockname()[1]}"
        environment = os.environ | {"TERN_BUILD": str(self.build)}
        answerer = subprocess.Popen([ROOT / "tern", "conform", "structure", address, "--check", "trace", "--check", "interrupt"],
                                    env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        started, lines = [], []
        for line in answerer.stdout:
            lines.append(line)
            if "start the structure now" in line:
                started.append(subprocess.Popen(["/usr/bin/python3", FAULTY, "none", ROOT / "cases" / "conformance", "--endpoint", address],
                                                env=environment, stderr=subprocess.DEVNULL))
        for process in started:
            process.wait(timeout=30)
        text = "".join(lines)
        self.assertEqual((answerer.wait(timeout=30), len(started)), (0, 2), text)
        answerer.stdout.close()
        self.assertIn("ok   trace", text)
        self.assertIn("interrupt: not checked, it needs a command", text)

    def test_what_cannot_be_tested_is_said_in_a_sentence(self):
        for words, sentence in ((["structure", "no-such-program"], "is neither a file nor a program on the PATH"),
                                (["structure", "/bin/true", "--check", "magic"], "There is no check 'magic'"),
                                (["structure", "/bin/true", "--case", "hydrostatic_tank"], "has no structure"),
                                (["structure", "/bin/true", "--set", "coupling.algorithm=explicit"], "Add --set coupling.algorithm=auto.")):
            code, text = conform(self.build, *words)
            self.assertEqual(code, 2, text)
            self.assertIn(sentence, text)


if __name__ == "__main__":
    unittest.main()
