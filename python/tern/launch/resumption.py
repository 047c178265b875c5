"""./tern resume: whether a run can go on, from where, and what it was asked for."""

import json
from pathlib import Path

from tern.errors import BAD_INPUT, INPUT_OUTPUT, Error
from tern.launch import cases, status
from tern.results import report, summary, tables

MAY_CHANGE = ("end_time", "output.frame_interval", "output.gauge_interval", "output.checkpoint_interval")
TABLES = ("gauges.csv", "energy.csv", "steps.csv")
NEEDED = ("case_hash", "case_path", "commands", "launch", "options", "settings")  # of run.json
IN_WORDS = f"{', '.join(MAY_CHANGE)} may change, and gauges be added"


def flat(settings, prefix=""):
    """{"fluid.spacing": 0.004, "wall.tank.shape...": ...} of nested settings; entries of lists by their name or number."""
    if isinstance(settings, list) and all(isinstance(entry, dict) for entry in settings):
        settings = {str(entry.get("name", number)): entry for number, entry in enumerate(settings)}
    if not isinstance(settings, dict):
        return {prefix: settings}
    found = {}
    for key, value in settings.items():
        found |= flat(value, f"{prefix}.{key}" if prefix else key)
    return found


def differences(then, now):
    """Sentences about what has changed in the settings and must not."""
    gauges = {gauge["name"] for gauge in then.get("gauge", [])}
    now = now | {"gauge": [gauge for gauge in now.get("gauge", []) if gauge["name"] in gauges]}  # more of them may be there
    then, now = flat(then), flat(now)
    return [f"{key} was {then.get(key, 'absent')} and is {now.get(key, 'absent')}" for key in sorted(then.keys() | now.keys())
            if then.get(key) != now.get(key) and key not in MAY_CHANGE]


def manifests(directory):
    """The manifests of a run's checkpoints, newest first; the processes look whether they are sound."""
    found = []
    for path in sorted((directory / "checkpoint").glob("manifest.*.json"), reverse=True):
        try:
            contents = json.loads(path.read_text(encoding="utf-8"))
            found.append({"step": int(contents["step"]), "time_s": float(contents["time_s"])})
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return found


def _why_no_checkpoint(contents, directory):
    there = sorted((directory / "checkpoint").glob("*.*"))
    if damaged := [path.name for path in there if path.name.startswith("manifest.")]:
        return f"{' and '.join('checkpoint/' + name for name in damaged)} cannot be read; it was cut short or changed"
    if there:
        return f"checkpoint/ has {there[0].name}, but no manifest, which says what belongs together"
    interval = contents.get("settings", {}).get("output", {}).get("checkpoint_interval", 0)
    if interval == 0:
        return "it was run with output.checkpoint_interval = 0"
    foreign = contents.get("commands", {})
    if foreign:
        return f"{' and '.join(foreign.values())} may keep no checkpoints (docs/PARTICIPANTS.md), or it ended before the first one"
    if contents.get("exit_code") == INPUT_OUTPUT:
        return (f"it ended before the first one, after {interval:g} s ([output] checkpoint_interval), and could not write one at its end: "
                f"{contents.get('first_cause', '').rstrip('.')}")
    return f"it ended before the first one, after {interval:g} s ([output] checkpoint_interval)"


def newest(directory):
    """run.json of a run that can go on, and its newest checkpoint {"step", "time_s"}. Raises Error where it cannot, with the reason."""
    contents = report.read(directory)
    living = [process for process in status.living(directory) if contents.get("status") == "running"]
    if living:
        raise Error(BAD_INPUT, f"{summary.shown(directory)} is still running ({', '.join(living)}); end it first.")
    if "launch" not in contents:
        raise Error(BAD_INPUT, f"{summary.shown(directory)} is the run of an older version, which kept no checkpoints; begin anew.")
    found = manifests(directory)
    if contents["launch"].get("only") in (None, "coupler") and not found:
        raise Error(BAD_INPUT, f"{summary.shown(directory)} has no checkpoint to go on from: {_why_no_checkpoint(contents, directory)}.")
    report.demand(directory, contents, NEEDED)
    return contents, found[0] if found else None


def check_tables(directory, checkpoint):
    """Raises Error where a table is damaged in the rows that a run goes on from. That it is as long as at the checkpoint, and there, is
    looked at by the process that writes it."""
    for name in TABLES:
        if (directory / name).exists():
            tables.check(directory / name, checkpoint["time_s"])


def can_go_on(name, asked):
    """The directory of an earlier run of this case with checkpoints, for --resume auto; None where there is none."""
    directory = Path(asked) if asked else Path("runs") / name
    if not cases.is_run(directory):
        return None
    try:
        newest(directory.resolve())
    except Error:
        return None
    return directory.resolve()
