"""The settings of a run as a flat table, beside the defaults of docs/PARAMETERS.md."""

import json
import re

from tern import paths

SHAPES = {"box", "polygon", "ball", "ring", "line", "tube", "plate", "union", "difference"}
HEADING = re.compile(r"^## `\[+([a-z.]+)\]+`")
ROW = re.compile(r"^\| `(\w+)` \| ([^|]*) \| ([^|]*) \|")
NUMERICAL = ("fluid.numerics.", "structure.numerics.", "coupling.")
GIVEN = "given by the case"


def _is_leaf(value):
    if isinstance(value, dict):
        return bool(SHAPES & set(value))
    return not (isinstance(value, list) and value and all(isinstance(entry, dict) and not SHAPES & set(entry) for entry in value))


def flatten(settings, path=(), table=()):
    """{path as of --set: (table and key of the reference, value)}; elements of lists by name, else by position."""
    flat = {}
    for key, value in settings.items():
        if _is_leaf(value):
            flat[".".join((*path, key))] = (".".join((*table, key)), value)
        elif isinstance(value, dict):
            flat |= flatten(value, (*path, key), (*table, key))
        else:
            for position, element in enumerate(value):
                flat |= flatten(element, (*path, key, str(element.get("name", position))), (*table, key))
    return flat


def defaults():
    """{table and key: (unit, default)}; the default None where an absent key is one, GIVEN where there is none."""
    known, table = {}, ""
    for line in (paths.share() / "docs" / "PARAMETERS.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            heading = HEADING.match(line)
            table = heading.group(1) + "." if heading else "" if line == "## Top of the file" else None
        row = ROW.match(line)
        if row and table is not None:
            key, unit, default = (part.strip() for part in row.groups())
            value = GIVEN if default == "**required**" else None if default == "absent" else json.loads(default.strip("`"))
            known[table + key] = (unit, value)
    return known


def shown(value):
    """A value as the case file would have it, nearly: JSON."""
    return "" if value is None else value if isinstance(value, str) else json.dumps(value)


def rows(settings):
    """[(path, value, unit, default, whether the value differs from the default)] in the order of the settings.

    What describes the scene (a title, where a gauge is) has no default it could differ from, although it may be absent.
    """
    known = defaults()
    lines = []
    for path, (key, value) in flatten(settings).items():
        unit, default = known.get(key, ("", GIVEN))
        scene = key == "title" or default == GIVEN or (default is None and not key.startswith(NUMERICAL))
        lines.append((path, value, unit, "absent" if default is None else default, not scene and value != default))
    return lines
