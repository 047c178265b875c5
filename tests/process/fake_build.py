"""A build directory of stand-ins: small scripts named tern-case, tern-fluid ... that behave as a test tells them.

Each role's behaviour is a list of words in the environment variable FAKE_<ROLE>:
  sleep S            wait S seconds
  report CODE TEXT   leave a report with this exit code and cause, then exit with CODE
  blame CODE WORD    leave a report with this exit code and cause, and go on
  leave CODE         exit with CODE and touch no report
  exit CODE          leave a report without a cause, then exit with CODE
  lose N M           reports say that N particles went through a face and M left the domain
  kill N             end by signal N
  deaf               ignore SIGINT and SIGTERM from here on
  wait               sleep until a signal arrives: SIGINT or SIGTERM end with 130 and an "interrupted" report
Every stand-in writes its process id and command line to OUT/pid.<role>.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent

SCRIPT = r'''#!/usr/bin/python3 -IB
import json, os, signal, sys, time

role = os.path.basename(sys.argv[0]).removeprefix("tern-")
if role == "case":
    if os.environ.get("FAKE_CASE"):
        sys.stderr.write("tern-case: " + os.environ["FAKE_CASE"] + "\n")
        sys.exit(2)
    sides = os.environ.get("FAKE_SIDES", "fluid structure").split()
    if "--version" in sys.argv:
        print("tern-case 0.0 (stand-in)")
        sys.exit(0)
    print(json.dumps({"name": "pond", "path": sys.argv[2], "hash": "abc", "dimension": 2, "end_time": 1.0, "title": "",
                      "has_fluid": "fluid" in sides, "has_structure": "structure" in sides, "settings": {"title": ""}}))
    sys.exit(0)

out = sys.argv[sys.argv.index("--out") + 1]
if "--endpoint" in sys.argv:  # like a real socket file: something to clean up
    address = sys.argv[sys.argv.index("--endpoint") + 1].removeprefix("ipc://")
    open(address + "." + role, "w").close()
with open(f"{out}/pid.{role}.tmp", "w") as file:
    file.write(json.dumps({"pid": os.getpid(), "words": sys.argv[1:], "spins": os.environ.get("GOMP_SPINCOUNT"),
                           "blas_threads": os.environ.get("OPENBLAS_NUM_THREADS")}))
os.rename(f"{out}/pid.{role}.tmp", f"{out}/pid.{role}")

counts = {}

def report(code, cause):
    with open(f"{out}/report.{role}.json", "w") as file:
        json.dump({"role": role, "status": "failed" if code else "done", "exit_code": code, "cause": cause,
                   "cause_time": time.time() if cause else 0, "steps": 7, "time_s": 0.5, "wall_s": 2.0,
                   "timing_s": {"compute": 1.5, "wait": 0.5},
                   "measures": {"pressure_iterations_mean": 5.5, "volume_drift": 0.001} if role == "coupler" else {},
                   "counts": counts}, file)

def interrupted(number, frame):
    report(130, "interrupted")
    sys.exit(130)

signal.signal(signal.SIGINT, interrupted)
signal.signal(signal.SIGTERM, interrupted)
words = os.environ.get("FAKE_" + role.upper(), "exit 0").split()
while words:
    word = words.pop(0)
    if word == "sleep":
        time.sleep(float(words.pop(0)))
    elif word == "report":
        code = int(words.pop(0))
        report(code, " ".join(words))
        sys.exit(code)
    elif word == "blame":
        report(int(words.pop(0)), words.pop(0))
    elif word == "leave":
        sys.exit(int(words.pop(0)))
    elif word == "exit":
        code = int(words.pop(0))
        report(code, "")
        sys.exit(code)
    elif word == "kill":
        os.kill(os.getpid(), int(words.pop(0)))
    elif word == "lose":
        counts = {"particles_leaked": int(words.pop(0)), "particles_removed": int(words.pop(0)), "particles": 100}
    elif word == "deaf":
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    elif word == "wait":
        while True:
            signal.pause()
'''


class FakeBuild:
    """A temporary directory with the stand-ins, a case, and an environment for ./tern to use them."""

    def __enter__(self):
        self._directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.path = Path(self._directory.name)
        (self.path / "build").mkdir()
        for role in ("case", "fluid", "structure", "coupler"):
            script = self.path / "build" / f"tern-{role}"
            script.write_text(SCRIPT)
            script.chmod(0o755)
        (self.path / "pond").mkdir()
        (self.path / "pond" / "case.toml").write_text("title = 'pond'\n")
        (self.path / "tmp").mkdir()
        return self

    def __exit__(self, *_):
        self._directory.cleanup()

    def start(self, *words, case_name="pond", before=(), **behaviour):
        """./tern run pond WORDS in the temporary directory; behaviour: fluid="exit 3", sides="fluid" ...; `before`: a command around it."""
        environment = os.environ | {"TERN_BUILD": str(self.path / "build"), "TMPDIR": str(self.path / "tmp")}
        environment |= {f"FAKE_{name.upper()}": value for name, value in behaviour.items()}
        return subprocess.Popen([*before, ROOT / "tern", "run", case_name, *words], cwd=self.path, env=environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)

    def run(self, *words, case_name="pond", before=(), **behaviour):
        """The same, waited for: (exit code, standard output, standard error)."""
        process = self.start(*words, case_name=case_name, before=before, **behaviour)
        output, errors = process.communicate(timeout=60)
        return process.returncode, output, errors

    def temporary_files(self):
        """What is left in the directory for temporary files."""
        return sorted(path.name for path in (self.path / "tmp").iterdir())


def wait_until(condition, seconds):
    """Polls; returns whether the condition came true in time."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(0.02)
    return bool(condition())


def is_alive(pid):
    """Whether the process exists and is not a zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


if __name__ == "__main__":
    sys.exit("This module holds what the tests beside it share; run those.")
