"""report.ROLE.json, what a process of a run says of itself; a foreign program may write anything there."""

import json

NUMBERS = ("cause_time", "cpu_s", "end_time_s", "exit_code", "process_id", "steps", "time_s", "wall_s")
TEXTS = ("cause", "git", "status", "version")


def read(path):
    """The report in a file without entries of another type than theirs; empty where there is none that can be read."""
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    if not isinstance(report, dict):
        return {}
    types = dict.fromkeys(NUMBERS, (int, float)) | dict.fromkeys(TEXTS, str)
    return {key: value for key, value in report.items()
            if value is None or isinstance(value, types.get(key, object)) and not (key in NUMBERS and isinstance(value, bool))}
