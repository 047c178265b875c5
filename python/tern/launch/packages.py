"""Debian packages tern needs, and their installation when some are missing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from tern import paths
from tern.errors import INPUT_OUTPUT, Error

BUILD = (
    "g++ cmake ninja-build pkg-config git libeigen3-dev libsuitesparse-dev libopenblas-dev libzmq3-dev cppzmq-dev "
    "libprotobuf-dev protobuf-compiler libhdf5-dev libtomlplusplus-dev libcli11-dev libspdlog-dev libfmt-dev "
    "libmuparser-dev nlohmann-json3-dev libgtest-dev libgmock-dev"
).split()
TESTS = "iproute2 chromium".split()  # network namespaces; pages are looked at
REPORT = ["python3-markdown", "python3-pil"]
FILM = ["ffmpeg"]
FUZZ = "clang libclang-rt-dev libomp-dev".split()
PYTHON = "python3-numpy python3-matplotlib python3-h5py python3-zmq python3-protobuf".split()
# Of single participants of tern/participant/solvers, beyond those of all.
PARTICIPANTS = {"getfem_structure.py": "python3-getfem python3-scipy".split()}


def ensure_for(command):
    """Installs what a participant of this repository needs; a stranger's program is its owner's business."""
    for word in command:
        if os.path.isfile(word) and paths.solvers() in Path(word).resolve().parents:
            ensure(["protobuf-compiler", *PYTHON, *PARTICIPANTS.get(Path(word).name, [])])


def missing(packages):
    """Those of `packages` that dpkg does not report as installed; none where there is no dpkg."""
    if shutil.which("dpkg-query") is None:
        return []
    answer = subprocess.run(["dpkg-query", "-W", "-f", "${Package} ${db:Status-Status}\n", *packages],
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    installed = {line.split()[0] for line in answer.stdout.splitlines() if line.endswith(" installed")}
    return [package for package in packages if package not in installed]


def ensure(packages):
    """Installs what is missing of `packages` through apt-get, with sudo unless root, and says so first."""
    absent = missing(packages)
    if not absent:
        return
    sudo = [] if os.geteuid() == 0 else ["sudo"]
    names = " ".join(absent)
    if sudo and shutil.which("sudo") is None:
        raise Error(INPUT_OUTPUT, f"Debian packages are missing and there is no sudo to install them: as root, "
                                          f"run apt-get install {names}, then start tern again.")
    print(f"tern: installing {len(absent)} missing Debian packages with {' '.join(sudo + ['apt-get'])}: {names}",
          file=sys.stderr, flush=True)
    quiet = [*sudo, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq", "-o", "Dpkg::Use-Pty=0"]
    for step in (["update"], ["install", "-y", "--no-install-recommends", *absent]):
        # stdin stays the terminal: sudo may ask for the password.
        answer = subprocess.run([*quiet, *step], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if answer.returncode != 0:
            sys.stderr.write(answer.stdout)
            raise Error(INPUT_OUTPUT, f"apt-get {step[0]} failed (its output is above); install by hand: "
                                              f"apt-get install {names}, then start tern again.")
