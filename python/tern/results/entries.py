"""What the entries of a JSON file may hold, and which one holds something else: a file may be damaged, or of a foreign program."""

import json
import sys
from dataclasses import dataclass, field
from datetime import datetime

MOST_SHOWN = 40  # characters of a wrong value


@dataclass(frozen=True)
class Kind:
    """A single value: its name in an error, and which values are of this kind."""

    name: str
    holds: object


@dataclass(frozen=True)
class Table:
    """Entries by name, each of its kind. Those in `needed` have to be there. What `entries` does not name is of the kind `others`."""

    entries: dict = field(default_factory=dict)
    needed: tuple = ()
    others: object = None


@dataclass(frozen=True)
class List:
    """Any number of values of one kind."""

    of: object


def _is_number(value):
    """A whole number may have more digits than a float has room for."""
    return isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool) and abs(value) <= sys.float_info.max)


def _is_moment(value):
    try:
        datetime.fromisoformat(value)
    except (TypeError, ValueError):
        return False
    return True


NUMBER = Kind("a number", _is_number)
TEXT = Kind("text", lambda value: isinstance(value, str))
TRUTH = Kind("true or false", lambda value: isinstance(value, bool))
MOMENT = Kind("a date with a time", _is_moment)


def maybe(kind):
    """A single value of this kind, or null."""
    return Kind(f"{kind.name} or null", lambda value: value is None or kind.holds(value))


def _name(kind):
    return "a table" if isinstance(kind, Table) else "a list" if isinstance(kind, List) else kind.name


def _shown(value):
    """A value as it stands in the file; long ones are cut, and of tables and lists it is enough to say what they are."""
    if isinstance(value, (dict, list)):
        return "a table" if isinstance(value, dict) else "a list"
    if isinstance(value, int) and not _is_number(value) and not isinstance(value, bool):
        return "a number of too many digits"
    text = json.dumps(value)
    return text if len(text) <= MOST_SHOWN else text[:MOST_SHOWN] + " ..."


def wrong(value, kind, name=""):
    """Which entry of `value`, itself called `name`, is not of its kind, in words; None where all are. The kind None is any value."""
    if kind is None or (isinstance(kind, Kind) and kind.holds(value)):
        return None
    if isinstance(kind, Table) and isinstance(value, dict):
        return _wrong_in_table(value, kind, f"{name}." if name else "")
    if isinstance(kind, List) and isinstance(value, list):
        return next((found for place, entry in enumerate(value) if (found := wrong(entry, kind.of, f"{name}[{place}]"))), None)
    return f"{name or 'it'} is {_shown(value)}, not {_name(kind)}"


def _wrong_in_table(value, kind, before):
    if missing := [before + key for key in kind.needed if key not in value]:
        return f"there is no {' and no '.join(missing)}"
    return next((found for key, entry in value.items() if (found := wrong(entry, kind.entries.get(key, kind.others), before + key))), None)
