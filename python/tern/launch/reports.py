"""report.ROLE.json, what a process of a run says of itself; a foreign program may write anything there."""

import json

from tern.results.entries import wrong
from tern.results.report import PROCESS


def read(path):
    """The report in a file without entries of another type than theirs; empty where there is none that can be read."""
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    if not isinstance(report, dict):
        return {}
    return {key: value for key, value in report.items() if not wrong(value, PROCESS.entries.get(key))}
