#!/usr/bin/python3 -B
"""What ./tern does before a run: packages are installed by one command at a time, and a build says how far it is."""

import io
import os
import subprocess
import sys
import tempfile
import unittest
from contextlib import redirect_stderr
from pathlib import Path
from unittest import mock

from tern.errors import Error
from tern.launch import build, packages

ENSURE = "from tern.launch import packages; packages.ensure(['made-up'])"
APT = """#!/bin/sh
echo "begin $*" >> "$FAKES/log"
for word; do
  case "$word" in
    update) if [ ! -e "$FAKES/tried" ]; then touch "$FAKES/tried"; echo "E: Could not get lock /var/lib/apt/lists/lock."; exit 100; fi ;;
    install) sleep 0.5; touch "$FAKES/installed" ;;
  esac
done
"""
DPKG = """#!/bin/sh
[ -e "$FAKES/installed" ] && echo "made-up installed" || exit 1
"""


class PackagesTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.path = Path(directory.name)
        for name, text in (("apt-get", APT), ("dpkg-query", DPKG), ("sudo", '#!/bin/sh\nexec "$@"\n')):
            (self.path / name).write_text(text)
            (self.path / name).chmod(0o755)
        self.environment = os.environ | {"FAKES": str(self.path), "PATH": f"{self.path}:{os.environ['PATH']}", "TMPDIR": str(self.path)}

    # Seen to fail: without _alone() (two installations); without the second look at what is missing; without the repetition in _apt().
    def test_two_commands_at_once_install_one_after_the_other(self):
        both = [subprocess.Popen([sys.executable, "-B", "-c", ENSURE], env=self.environment, stderr=subprocess.PIPE, text=True)
                for _ in range(2)]
        said = [process.communicate(timeout=60)[1] for process in both]
        self.assertEqual([process.returncode for process in both], [0, 0], said)
        self.assertEqual(sorted("installing 1 missing Debian package" in text for text in said), [False, True], said)
        self.assertEqual(sum("waiting for another ./tern" in text for text in said), 1, said)
        self.assertEqual(sum("waiting for another apt" in text for text in said), 1, said)
        words = [line.split() for line in (self.path / "log").read_text().splitlines()]
        self.assertEqual([next(word for word in line if word in ("update", "install")) for line in words], ["update", "update", "install"])
        self.assertTrue(all(f"DPkg::Lock::Timeout={packages.APT_WAITS_S}" in line for line in words))

    # Seen to fail: with the exit code of apt-get left aside.
    def test_an_installation_that_fails_names_the_packages(self):
        (self.path / "apt-get").write_text("#!/bin/sh\necho broken\nexit 100\n")
        answer = subprocess.run([sys.executable, "-B", "-c", ENSURE], env=self.environment, capture_output=True, text=True, check=False)
        self.assertIn("broken", answer.stderr)
        self.assertIn("install by hand: apt-get install made-up", answer.stderr)


class ProgressTest(unittest.TestCase):
    def said(self, script):
        with redirect_stderr(io.StringIO()) as errors, mock.patch.object(build, "PROGRESS_INTERVAL_S", 0.2):
            try:
                build._quietly(["sh", "-c", script], "building (release)")
            except Error as error:
                print(error, file=errors)
        return errors.getvalue().splitlines()

    # Seen to fail: with the first line only; with a line for every step.
    def test_a_build_says_how_far_it_is_where_nobody_sees_a_terminal(self):
        said = self.said("echo '[1/4] a'; echo '[2/4] b'; sleep 0.4; echo '[3/4] c'; echo note; echo '[4/4] d'")
        self.assertEqual(said, ["tern: building (release), 1 of 4", "tern: building (release), 3 of 4"])

    # Seen to fail: with the output left out.
    def test_a_build_that_fails_shows_everything(self):
        said = self.said("echo '[1/4] a'; echo 'a.cpp:1: error'; exit 1")
        self.assertEqual(said[:3], ["tern: building (release), 1 of 4", "[1/4] a", "a.cpp:1: error"])
        self.assertIn("building (release) failed", said[3])


if __name__ == "__main__":
    unittest.main()
