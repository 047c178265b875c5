"""Debian packages tern needs, and their installation when some are missing."""

import contextlib
import fcntl
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tern import paths
from tern.errors import INPUT_OUTPUT, Error

BUILD = (
    "g++ cmake ninja-build pkg-config git libeigen3-dev libsuitesparse-dev libopenblas-dev libzmq3-dev cppzmq-dev "
    "libprotobuf-dev protobuf-compiler libhdf5-dev libtomlplusplus-dev libcli11-dev libspdlog-dev libfmt-dev "
    "libmuparser-dev nlohmann-json3-dev libgtest-dev libgmock-dev"
).split()
RANKS = "libopenmpi-dev openmpi-bin iproute2".split()  # of a fluid in many processes
TESTS = "iproute2 chromium".split()  # network namespaces; pages are looked at
REPORT = ["python3-markdown", "python3-pil"]
FILM = ["ffmpeg"]
RENDER = ["python3-vtk9", "xvfb"]  # of 3D scenes, where none may have a display; 250 MB on the disk
FUZZ = "clang libclang-rt-dev libomp-dev".split()
PICTURES = "python3-numpy python3-matplotlib python3-h5py".split()
PYTHON = [*PICTURES, *"python3-zmq python3-protobuf".split()]  # with a participant
# Of single participants of tern/participant/solvers, beyond those of all.
PARTICIPANTS = {"getfem_structure.py": "python3-getfem python3-scipy".split()}

APT_WAITS_S = 600  # for another apt, which may be in the middle of an upgrade


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
    if missing(packages):
        with _alone():
            _install(missing(packages))  # another ./tern may have done it meanwhile


@contextlib.contextmanager
def _alone():
    """One installation of this user at a time: apt waits for the lock of dpkg, but not for that of its lists."""
    path = Path(tempfile.gettempdir()) / f"tern-packages-{os.getuid()}.lock"
    with open(os.open(path, os.O_RDWR | os.O_CREAT, 0o600), "w", encoding="utf-8") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("tern: waiting for another ./tern that is installing packages", file=sys.stderr, flush=True)
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _apt(command):
    """Runs apt-get, again while another apt has a lock for which this one does not wait (that of the lists)."""
    give_up_at, told = time.monotonic() + APT_WAITS_S, False
    while True:
        # stdin stays the terminal: sudo may ask for the password.
        answer = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if answer.returncode == 0 or "Could not get lock" not in answer.stdout or time.monotonic() > give_up_at:
            return answer
        if not told:
            print("tern: waiting for another apt that is at work", file=sys.stderr, flush=True)
        told = True
        time.sleep(1)


def _install(absent):
    """Lists, then packages; an Error that names them when apt cannot."""
    if not absent:
        return
    sudo = [] if os.geteuid() == 0 else ["sudo"]
    names = " ".join(absent)
    if sudo and shutil.which("sudo") is None:
        raise Error(INPUT_OUTPUT, f"Debian packages are missing and there is no sudo to install them: as root, "
                                  f"run apt-get install {names}, then start tern again.")
    print(f"tern: installing {len(absent)} missing Debian packages with {' '.join(sudo + ['apt-get'])}: {names}",
          file=sys.stderr, flush=True)
    quiet = [*sudo, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq", "-o", "Dpkg::Use-Pty=0",
             "-o", f"DPkg::Lock::Timeout={APT_WAITS_S}"]
    for step in (["update"], ["install", "-y", "--no-install-recommends", *absent]):
        answer = _apt([*quiet, *step])
        if answer.returncode != 0:
            sys.stderr.write(answer.stdout)
            raise Error(INPUT_OUTPUT, f"apt-get {step[0]} failed (its output is above); install by hand: "
                                              f"apt-get install {names}, then start tern again.")
