"""What the scripts that compare runs of one case share: runs done once, values of curves."""

import subprocess
import sys

import numpy as np

from tern import paths
from tern.results.run import Run


def run_or_reuse(label, case, out, until, settings, commands=None):
    """The run of `case` with these KEY=VALUE settings in directory `out`, done now unless it is there and reaches `until` [s].

    `commands`: programs in place of tern's own, {"structure": "..."}. Ends the program when there is no result at all; a run that
    stops early is returned with a word to stderr.
    """
    commands = commands or {}
    options = [part for setting in settings for part in ("--set", setting)]
    if out.is_dir():
        found = Run(out)
        reached = found.gauges.get("t_s", np.zeros(1))[-1]
        if (found.contents.get("status") == "done" and reached >= until - 2e-3 and found.contents.get("options") == options
                and found.contents.get("commands", {}) == commands):
            return found
    foreign = [part for role, command in commands.items() for part in (f"--{role}", command)]
    command = [paths.command(), "run", case, "--out", out, "--force", "--until", repr(until), "--quiet", *options, *foreign]
    code = subprocess.run(command, check=False).returncode
    if not out.is_dir():
        sys.exit(code)
    if code != 0:
        print(f"{label}: the run ended with exit code {code}; what it reached is shown.", file=sys.stderr)
    return Run(out)


def at(table, column, time):
    """Value at a time, NaN beyond the end of the run (rows are 1 ms apart, the last up to 1 ms before the end)."""
    t = table["t_s"]
    return float(np.interp(time, t, table[column])) if t[-1] >= time - 2e-3 else float("nan")
