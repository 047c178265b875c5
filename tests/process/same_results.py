"""What differs between the results of two runs that should be the same, but for times, dates and process ids."""

import json

OF_THE_CLOCK = ("process_id", "launcher", "wall_s", "cpu_s", "timing_s", "started", "resumed", "cause_time")
OF_THE_START = ("launch", "overrides", "options", "case_hash", "end_time_s", "settings", "threads")  # --until and --set may be others


def _without_clock(value):
    if isinstance(value, dict):
        return {key: _without_clock(entry) for key, entry in value.items() if key not in OF_THE_CLOCK + OF_THE_START}
    return value


def _flat(value, prefix=""):
    if not isinstance(value, dict):
        return {prefix: value}
    found = {}
    for key, entry in value.items():
        found |= _flat(entry, f"{prefix}.{key}")
    return found


def _bytes(path):
    """Of a file of results; of steps.csv without its last column, the wall time."""
    text = path.read_bytes()
    return b"\n".join(line.rpartition(b",")[0] for line in text.split(b"\n")) if path.name == "steps.csv" else text


def differences(one, other, but=()):
    """Sentences; none where every table, frame, index, record and entry of run.json is the same. `but`: names that are not compared."""
    found = []
    names = [{path.name for path in run.iterdir() if path.suffix in (".csv", ".h5", ".xmf", ".record", ".tmp") and path.name not in but}
             for run in (one, other)]
    found += [f"only one has {name}" for name in sorted(names[0] ^ names[1])]
    found += [f"{name} differs" for name in sorted(names[0] & names[1]) if _bytes(one / name) != _bytes(other / name)]
    reports = [_flat(_without_clock(json.loads((run / "run.json").read_text(encoding="utf-8")))) for run in (one, other)]
    keys = sorted(reports[0].keys() | reports[1].keys())
    found += [f"run.json: {key} is {reports[0].get(key)} and {reports[1].get(key)}" for key in keys
              if reports[0].get(key) != reports[1].get(key)]
    return found
