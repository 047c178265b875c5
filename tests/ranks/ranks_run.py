"""Runs of ./tern with ranks, for the tests beside it."""

import ipaddress
import json
import os
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import h5py
import numpy

ROOT = Path(__file__).resolve().parents[2]
CASE = ROOT / "cases" / "dam_break_front"
COARSE = ["--set", "fluid.spacing=0.0073"]
OVERSUBSCRIBED = ["--oversubscribe"]


def alive(pid):
    """Whether it runs; a zombie does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def children_of(pid):
    """All processes below one."""
    answer = subprocess.run(["ps", "-e", "-o", "pid=,ppid=,comm="], stdout=subprocess.PIPE, text=True, check=True).stdout
    rows = [line.split() for line in answer.splitlines()]
    found, todo = [], [str(pid)]
    while todo:
        parent = todo.pop()
        for row in rows:
            if row[1] == parent:
                todo.append(row[0])
                found.append((int(row[0]), row[2]))
    return found


def numbers_of(ranks):
    """Process ids by the number of the rank."""
    return {int(Path(f"/proc/{pid}/environ").read_bytes().split(b"OMPI_COMM_WORLD_RANK=")[1].split(b"\0")[0]): pid for pid in ranks}


def place(address):
    """An address as the kernel's tables have it: words of four bytes, each the wrong way round."""
    words = [bytes.fromhex(address[k:k + 8])[::-1] for k in range(0, len(address), 8)]
    return str(ipaddress.ip_address(b"".join(words)))


def listeners(pids):
    """(address, port) of every TCP socket at which one of these processes listens."""
    own = set()
    for pid in pids:
        try:
            own |= {os.readlink(path) for path in Path(f"/proc/{pid}/fd").iterdir()}
        except OSError:
            continue
    found = set()
    for pid in pids:
        for table in ("tcp", "tcp6"):
            try:
                rows = [line.split() for line in Path(f"/proc/{pid}/net/{table}").read_text(encoding="utf-8").splitlines()[1:]]
            except OSError:
                continue
            for row in rows:
                if row[3] == "0A" and f"socket:[{row[9]}]" in own:
                    address, port = row[1].split(":")
                    found.add((place(address), int(port, 16)))
    return found


class RanksTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-ranks-")
        self.addCleanup(directory.cleanup)
        self.directory = Path(directory.name)

    def start(self, name, *words, case=CASE):
        process = subprocess.Popen([ROOT / "tern", "run", case, "--quiet", "--out", self.directory / name, *words], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.leave_nothing_of, process)
        return process

    @staticmethod
    def leave_nothing_of(process):
        """Of a test that has failed: the guardian ends what a killed launcher leaves."""
        if process.poll() is None:
            process.kill()
            process.communicate()

    def run_case(self, name, *words, case=CASE):
        with self.start(name, *words, case=case) as process:
            _, errors = process.communicate(timeout=600)
        return process.returncode, errors

    def contents(self, name):
        return json.loads((self.directory / name / "run.json").read_text(encoding="utf-8"))

    def frames(self, name):
        """All datasets of all frames."""
        datasets = {}
        with h5py.File(self.directory / name / "fluid.h5") as file:
            file.visititems(lambda path, item: datasets.__setitem__(path, item[()]) if isinstance(item, h5py.Dataset) else None)
        return datasets

    def wait_for_ranks(self, process, count, name="*"):
        """Process ids of the ranks, once the run into `name` has begun."""
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            ranks = [pid for pid, program in children_of(process.pid) if program == "tern-fluid"]
            steps = list(self.directory.glob(f"{name}/steps.csv"))
            if len(ranks) == count and steps and steps[0].read_text(encoding="utf-8").count("\n") > 3:
                return ranks
            time.sleep(0.1)
        process.send_signal(signal.SIGTERM)
        self.fail(f"the run did not begin: {process.communicate()}")

    def assert_the_same_results(self, one, other):
        """The same bytes of gauges and energies, and the same frames."""
        for name in ("gauges.csv", "energy.csv"):
            self.assertEqual((self.directory / one / name).read_bytes(), (self.directory / other / name).read_bytes())
        expected, found = self.frames(one), self.frames(other)
        self.assertEqual(expected.keys(), found.keys())
        for path, values in expected.items():
            self.assertTrue(numpy.array_equal(values, found[path]), path)
