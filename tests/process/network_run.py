"""One run as three commands, as if on three machines: coupler, fluid and structure, each with its own launcher, keys and results."""

import json
import os
import re
import signal
import subprocess
import time
from pathlib import Path

from fake_build import ROOT, wait_until

ROLES = ("coupler", "fluid", "structure")


def make_keys(path):
    """`./tern keys` into `path`, then each role's own files into path/<role>, as they would be copied to its machine."""
    answer = subprocess.run([ROOT / "tern", "keys", path / "all"], capture_output=True, text=True, check=False)
    if answer.returncode != 0:
        raise RuntimeError(answer.stderr)
    for role in ROLES:
        (path / role).mkdir()
        for name in (f"{role}.secret", "participants.allowed" if role == "coupler" else "coupler.public"):
            os.link(path / "all" / name, path / role / name)


class NetworkRun:
    """Starts the three, in any order; ends what is left. `keys`: directory of make_keys; `inside`: role -> words before a command."""

    def __init__(self, path, build, case, options=(), keys=None, inside=None):
        self.path, self.keys, self.inside = Path(path), keys, inside or {}
        self._case, self._options = case, [str(word) for word in options]
        self._environment = os.environ | {"TERN_BUILD": str(build)}
        self.processes = {}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.processes.values():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in self.processes.values():
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()

    def out(self, role):
        return self.path / f"out-{role}"

    def said(self, role):
        """Both streams of a command so far."""
        return (self.path / f"{role}.said").read_text()

    def _start(self, role, words, options, preparation=None):
        keys = ["--keys", str(self.keys / role)] if self.keys else []
        command = [*self.inside.get(role, []), str(ROOT / "tern"), *words, "--out", str(self.out(role)), *keys, *options]
        with open(self.path / f"{role}.said", "w", encoding="utf-8") as file:
            self.processes[role] = subprocess.Popen(command, cwd=self.path, env=self._environment, stdin=subprocess.DEVNULL,
                                                    stdout=file, stderr=subprocess.STDOUT, start_new_session=True,
                                                    preexec_fn=preparation)

    def start_coupler(self, bind="tcp://127.0.0.1:*", preparation=None):
        """Starts the coupler and returns its port."""
        self._start("coupler", ["run", str(self._case), "--only", "coupler", "--bind", bind], self._options, preparation)
        pattern = re.compile(r"listens at tcp://\S+:(\d+) ")
        wait_until(lambda: pattern.search(self.said("coupler")) or self.processes["coupler"].poll() is not None, 20)
        found = pattern.search(self.said("coupler"))
        if not found:
            raise RuntimeError("the coupler does not listen: " + self.said("coupler"))
        return int(found.group(1))

    def join(self, role, address, *own):
        """Options that shape the case are the same for all; `own` are those of this one."""
        self._start(role, ["join", role, address, str(self._case)], [*self._options, *own])

    def wait_for_step(self, step, seconds=60):
        """Until the coupler has done so many windows."""
        path = self.out("coupler") / "steps.csv"
        return wait_until(lambda: (path.exists() and path.read_text().count("\n") > step) or self.ended(), seconds)

    def ended(self):
        return any(process.poll() is not None for process in self.processes.values())

    def codes(self, seconds):
        """Waits for all; {role: exit code}, None where one is still running after `seconds`."""
        deadline = time.monotonic() + seconds
        codes = {}
        for role, process in self.processes.items():
            try:
                codes[role] = process.wait(timeout=max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                codes[role] = None
        return codes

    def contents(self, role):
        return json.loads((self.out(role) / "run.json").read_text())

    def everything_said(self):
        return "\n".join(f"--- {role}\n{self.said(role)}" for role in self.processes)

    def results(self):
        """{name: bytes} of all that a run computes: every dataset of every frame, and the gauges."""
        import h5py
        found = {name: (self.out("coupler") / name).read_bytes() for name in ("gauges.csv", "energy.csv")}
        return found | frames(h5py, {role: self.out(role) / f"{role}.h5" for role in ("fluid", "structure")})


def frames(h5py, paths):
    found = {}
    for role, path in paths.items():
        with h5py.File(path, "r") as file:
            file.visititems(lambda name, item, role=role: found.update({f"{role}/{name}": item[()].tobytes()})
                            if isinstance(item, h5py.Dataset) else None)
    return found


def local_results(out):
    """The same of a run of one command."""
    import h5py
    found = {name: (out / name).read_bytes() for name in ("gauges.csv", "energy.csv")}
    return found | frames(h5py, {role: out / f"{role}.h5" for role in ("fluid", "structure")})
