"""Starts the real executables of TERN_BUILD on the small coupled scene, for the tests beside it."""

import json
import os
import re
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

from fake_build import ROOT, is_alive, wait_until

SCENE = ROOT / "tests" / "process" / "cases" / "small_plate"
ROLES = ("coupler", "fluid", "structure")


def build_directory():
    """The build under test, or a reason to skip: there is none."""
    directory = Path(os.environ.get("TERN_BUILD", ROOT / "build" / "release"))
    if not all(os.access(directory / f"tern-{role}", os.X_OK) for role in (*ROLES, "case")):
        raise unittest.SkipTest(f"{directory} holds no finished build")
    return directory.resolve()


def conform(build, role, command, *words):
    """Exit code and text of ./tern conform on a participant."""
    answer = subprocess.run([ROOT / "tern", "conform", role, command, *words], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            env=os.environ | {"TERN_BUILD": str(build)}, timeout=300, check=False)
    return answer.returncode, answer.stdout


def without_waits(errors):
    """What was said on standard error but that somebody waited for somebody: on a busy machine a start takes more than 5 s."""
    return "".join(line for line in errors.splitlines(keepends=True) if not re.search(r"warning: \w+ waits for ", line))


def find_damage(out):
    """What cannot be read of the results in `out`: whole lines in every table, frames that open, an index that parses."""
    import xml.etree.ElementTree

    import h5py
    damage = []
    for path in out.glob("*.csv"):
        lines = path.read_text().splitlines()
        if len({line.count(",") for line in lines}) > 1:
            damage.append(f"{path.name} has lines of different lengths")
    for path in out.glob("*.h5"):
        try:
            with h5py.File(path, "r") as file:
                if "frame_000000" in file and len(file["frame_000000/position"]) == 0:
                    damage.append(f"{path.name} has an empty frame")
        except OSError as error:
            damage.append(f"{path.name} does not open: {error}")
    for path in out.glob("*.xmf"):
        try:
            xml.etree.ElementTree.parse(path)
        except xml.etree.ElementTree.ParseError as error:
            damage.append(f"{path.name}: {error}")
    damage += [f"{path.name} is left" for path in out.iterdir() if path.suffix in (".tmp", ".sock")]
    damage += [f"{path.name} is left" for path in out.glob("report.*")]
    return damage


class RealRunTest(unittest.TestCase):
    """A temporary directory, ./tern run in it, and the process ids of the three."""

    def setUp(self):
        self.build = build_directory()
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.path = Path(directory.name)
        (self.path / "tmp").mkdir()
        self.out = self.path / "run"

    def start(self, *words, case=SCENE):
        environment = os.environ | {"TERN_BUILD": str(self.build), "TMPDIR": str(self.path / "tmp")}
        process = subprocess.Popen([ROOT / "tern", "run", case, "--out", self.out, *words], cwd=self.path, text=True,
                                   env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   start_new_session=True)
        self.addCleanup(self._end, process)
        return process

    @staticmethod
    def _end(process):
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=20)
        process.stdout.close()
        process.stderr.close()

    def wait_until_running(self, process, steps=20):
        """Waits until the run has done some steps; returns {role: process id} of the launcher's children."""
        path = self.out / "steps.csv"
        started = wait_until(lambda: process.poll() is not None
                             or (path.exists() and path.read_text().count("\n") > steps), 60)
        if process.poll() is not None or not started:
            self.fail(f"the run did not start: {process.communicate(timeout=20)}")
        return self.children(process)

    @staticmethod
    def children(process):
        """{role: process id} of the executables started by the launcher."""
        found = {}
        for entry in Path("/proc").glob("[0-9]*/stat"):
            try:
                head, tail = entry.read_text().rsplit(")", 1)
            except OSError:
                continue
            role = re.search(r"\(tern-(\w+)", head)
            if role and int(tail.split()[1]) == process.pid:
                found[role.group(1)] = int(head.split()[0])
        return found

    def contents(self):
        return json.loads((self.out / "run.json").read_text())

    def assert_readable(self):
        """Everything a run of some steps writes is there and can be read."""
        for name in ("gauges.csv", "steps.csv", "energy.csv", "fluid.h5", "structure.h5", "fluid.xmf", "structure.xmf"):
            self.assertTrue((self.out / name).exists(), name)
        self.assertEqual(find_damage(self.out), [])

    def assert_nothing_left(self, pids):
        self.assertTrue(wait_until(lambda: not any(is_alive(pid) for pid in pids), 2), "a process survived the run")
        self.assertEqual(list((self.path / "tmp").iterdir()), [])
