"""What a step costs on this machine: measured once per build by a run of some seconds, used by ./tern check and explain."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

from tern import paths
from tern.errors import UnreadableRun
from tern.results import report

SCENE = Path(__file__).with_name("calibration.toml")
PARTS = ("neighbours", "boundary", "assembly", "pressure_solve", "correction")


def _costs(contents):
    """Costs of one particle, sub-step and window [CPU s] from the run.json of the scene."""
    processes = contents["processes"]
    fluid, structure, coupler = (processes[role] for role in ("fluid", "structure", "coupler"))
    steps = contents["steps"]
    # Shares by the clock, costs by CPU time: that is what is left alone by other programs on the machine.
    seconds = {part: fluid["timing_s"][f"compute.{part}"] for part in PARTS}
    return {
        "measured": date.today().isoformat(),
        "fluid_s": fluid["cpu_s"] / (fluid["counts"]["particles"] * steps),
        "fluid_parts": {part: value / sum(seconds.values()) for part, value in seconds.items()},
        # Two passes of every window: the trial, and the window under the new load.
        "structure_s": structure["cpu_s"] / (2 * structure["counts"]["particles"] * structure["counts"]["sub_steps"]),
        "window_s": coupler["cpu_s"] / steps,
    }


def costs_file(directory):
    """The costs of the build in `directory` as a file, measured now if they are missing; None where tern is not built yet or the
    measurement fails: then typical costs have to do."""
    programs = [directory / f"tern-{role}" for role in ("fluid", "structure", "coupler")]
    if not all(program.is_file() for program in programs):
        return None
    path = directory / "costs.json"
    if not os.access(directory, os.W_OK):  # a build that belongs to somebody else
        return path if path.is_file() else None
    if path.is_file() and path.stat().st_mtime >= max(program.stat().st_mtime for program in programs):
        return path
    print("tern: measuring once what a step costs on this machine (some seconds)", file=sys.stderr, flush=True)
    with tempfile.TemporaryDirectory(prefix="tern-costs-") as folder:
        out = Path(folder) / "run"
        process = subprocess.Popen([paths.command(), "run", SCENE, "--out", out, "--quiet", "--threads", "1"], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=os.environ | {"TERN_BUILD": str(directory)})
        try:
            if process.wait(timeout=300) != 0:
                return None
            costs = _costs(report.read(out))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)  # the launcher ends the three
            process.wait()
            return None
        except (UnreadableRun, KeyError, ZeroDivisionError):
            return None
    path.write_text(json.dumps(costs, indent=1) + "\n", encoding="utf-8")
    return path
