"""./tern status, beside a run whose fluid is stuck at its third pressure solve."""

import os
import re
import subprocess
import unittest

from fake_build import ROOT, wait_until
from real_run import RealRunTest


class StatusTest(RealRunTest):
    def status(self, directory):
        answer = subprocess.run([ROOT / "tern", "status", directory], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                timeout=30, check=False)
        return answer.returncode, answer.stdout

    # Seen to fail: with the log not read.
    def test_it_says_how_far_who_lives_and_who_waits_for_whom(self):
        library = self.build / "tests" / "libfault_injection.so"
        environment = {"LD_PRELOAD": str(library), "ASAN_OPTIONS": "verify_asan_link_order=0", "TERN_FAULT_PROCESS": "tern-fluid",
                       "TERN_FAULT_AT": "send:16:3",
                       "TERN_FAULT_DO": "stuck"}
        os.environ.update(environment)
        self.addCleanup(lambda: [os.environ.pop(name, None) for name in environment])
        process = self.start("--quiet", "--deadline", "15", case=ROOT / "cases" / "conformance")
        self.assertTrue(wait_until(lambda: "waits for fluid" in self.status(self.out)[1], 20), self.status(self.out)[1])
        code, text = self.status(self.out)
        self.assertEqual(code, 0, text)
        self.assertRegex(text, r"running since 2\d\d\d-\d\d-\d\d \d\d:\d\d:\d\d")
        for role in ("coupler", "fluid", "structure"):
            self.assertRegex(text, rf"{role} +process \d+ +running")
        self.assertRegex(text, r"coupler waits for fluid since step \d \(\d+ s\)")
        process.communicate(timeout=60)
        self.assertRegex(self.status(self.out)[1], r"peer lost: The coupler process waited 1\d(\.\d+)? s for fluid at step")

    # Seen to fail: with the role looked for in the command line of the process.
    def test_a_foreign_participant_lives_as_well(self):
        foreign = ROOT / "python" / "tern" / "participant" / "solvers" / "rigid_spring.py"
        process = self.start("--quiet", "--structure", f"{foreign} --stiffness 1e6", case=ROOT / "cases" / "conformance")
        self.assertTrue(wait_until(lambda: re.search(r"structure +process \d+ +running", self.status(self.out)[1]), 20),
                        self.status(self.out)[1])
        self.assertIsNone(process.poll())

    def test_a_directory_without_a_run_is_refused(self):
        code, text = self.status(self.path)
        self.assertEqual(code, 2, text)
        self.assertIn("holds no run", text)


if __name__ == "__main__":
    unittest.main()
