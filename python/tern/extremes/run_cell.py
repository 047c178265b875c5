"""Runs one cell with ./tern run, in a process of its own, so that nothing it does can end the map."""

import os
import re
import shutil
import signal
import subprocess
import time

from tern import paths
from tern.extremes import verdict

LONGEST_S = 300.0  # of a cell; hanging is one way to be wrong
GRACE_S = 10.0


def slug(text):
    """A folder name for a cell."""
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", text).strip("_")


def _end(process):
    """Ends a run that has not ended by itself."""
    process.send_signal(signal.SIGINT)
    try:
        process.communicate(timeout=GRACE_S)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def run_cell(cell, directory, build, longest=LONGEST_S):
    """The row of the cell: class, figures, message, wall time. What a wrong one has left stays in `directory`."""
    folder = directory / slug(cell.name)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "case.toml").write_text(cell.case, encoding="utf-8")
    command = [paths.command(), "run", folder, "--out", folder / "run", "--quiet", *(["--allow-unstable"] if cell.allow_unstable else [])]
    for option in cell.options:
        command += ["--set", option]
    began = time.monotonic()
    # A session of its own: Ctrl-C reaches the map, and the map ends the run.
    process = subprocess.Popen(command, env=os.environ | {"TERN_BUILD": str(build)}, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, text=True, errors="replace", start_new_session=True)
    try:
        _, errors = process.communicate(timeout=longest)
        code = process.returncode
    except subprocess.TimeoutExpired:
        _end(process)
        code, errors = None, ""
    except BaseException:
        _end(process)
        shutil.rmtree(folder, ignore_errors=True)
        raise
    row = verdict.classify(cell, folder / "run", code, errors) | {"wall_s": f"{time.monotonic() - began:.1f}"}
    if row["class"] != "wrong":
        shutil.rmtree(folder)
    return row
