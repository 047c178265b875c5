"""Configuring and building, quiet unless it fails.

TERN_BUILD names a finished build directory to use as it is; TERN_WERROR=ON makes compiler warnings errors (CI).
"""

import fcntl
import hashlib
import os
import re
import subprocess
import sys
import time
from pathlib import Path

from tern import paths
from tern.errors import BAD_INPUT, INPUT_OUTPUT, Error
from tern.launch import packages

PROGRESS_INTERVAL_S = 10.0  # where standard error is no terminal
EXECUTABLES = ("tern-case", "tern-fluid", "tern-structure", "tern-coupler")
PRESETS = ("release", "ranks", "debug", "asan", "tsan")
FUZZERS = ("fuzz-message", "fuzz-case")  # of the preset fuzz


def ensure(preset="release", targets=EXECUTABLES):
    """Returns the directory of an up-to-date build; installs packages, configures and compiles what is needed."""
    given = os.environ.get("TERN_BUILD")
    if given:
        absent = [name for name in EXECUTABLES if not os.access(Path(given) / name, os.X_OK)]
        if absent:
            raise Error(BAD_INPUT, f"TERN_BUILD names {given}, which has no executable {', '.join(absent)}; "
                                           f"build there first or unset TERN_BUILD.")
        return Path(given).resolve()
    if paths.installed():
        if preset != "release":
            raise Error(BAD_INPUT, f"--build {preset}: an installed tern is one build; the others are made from its sources.")
        return paths.build()
    packages.ensure([*packages.BUILD, *(packages.RANKS if preset == "ranks" else [])])
    directory = paths.build(preset)
    directory.mkdir(parents=True, exist_ok=True)
    with open(directory / ".tern-lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two launchers in one clone take turns
        warnings_are_errors = os.environ.get("TERN_WERROR")
        if warnings_are_errors or not (directory / "build.ninja").exists():
            option = [f"-DTERN_WERROR={warnings_are_errors}"] if warnings_are_errors else []
            _quietly(["cmake", "--preset", preset, *option], f"configuring ({preset})")
        _quietly(["cmake", "--build", str(directory), "--target", *(targets or ["all"])], f"building ({preset})")
    return directory


def version(directory):
    """Version and commit of the build in `directory`."""
    answer = subprocess.run([directory / "tern-case", "--version"], stdout=subprocess.PIPE, text=True, check=False)
    return answer.stdout.strip().removeprefix("tern-case ")


def digest(directory):
    """Changes with the executables in `directory`."""
    whole = hashlib.sha256()
    for name in EXECUTABLES:
        whole.update((directory / name).read_bytes())
    return whole.hexdigest()[:12]


def _quietly(command, activity):
    """Runs `command` in the clone; shows how many of its steps are done, and its whole output only if it fails.

    On a terminal one line counts them, elsewhere a line says so every few seconds.
    """
    terminal = sys.stderr.isatty()
    announced = None  # when, in monotonic seconds
    output = []
    with subprocess.Popen(command, cwd=paths.source(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace") as process:
        for line in process.stdout:
            output.append(line)
            progress = re.match(r"\[(\d+)/(\d+)\]", line)
            if progress is None or progress.group(1) == "0":  # 0: it looks whether there is anything to do
                continue
            said = f"tern: {activity}, {progress.group(1)} of {progress.group(2)}"
            if terminal:
                sys.stderr.write(f"\r{said} \x1b[K")
                sys.stderr.flush()
                announced = True
            elif announced is None or time.monotonic() - announced >= PROGRESS_INTERVAL_S:
                print(said, file=sys.stderr, flush=True)
                announced = time.monotonic()
    if terminal and announced:
        sys.stderr.write("\r\x1b[K")
    if process.returncode != 0:
        sys.stderr.write("".join(output))
        raise Error(INPUT_OUTPUT, f"{activity} failed; the command was: {' '.join(command)}; its output is above.")
