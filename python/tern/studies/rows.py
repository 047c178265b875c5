"""cost_accuracy.csv: one row per point of a study, appended as points finish."""

import csv
import os
from dataclasses import dataclass, field

from tern.errors import BAD_INPUT, Error

_PERCENT = ("error", "distance_to_finest", "distance_to_standard", "distance_in_parameter")
_NUMBERS = {"exit_code": int, "end_time_s": float, "cpu_s": float, "wall_s": float, "steps": int, "pressure_iterations": float}
_TEXTS = ("point", "parameter", "value", "options", "status", "cause", "judged_by", "base", "version")
_OLD_NAMES = {"knob": "parameter", "distance_in_knob_percent": "distance_in_parameter_percent"}  # one version ago
_OF = "error_percent of "


@dataclass
class Row:
    """One point. Errors and distances are shares of 1 here and per cent in the file; None = undefined, an empty cell."""

    point: str
    parameter: str = ""
    value: str = ""
    options: str = ""
    status: str = ""
    exit_code: int = 0
    cause: str = ""
    end_time_s: float = 0.0
    cpu_s: float | None = None
    wall_s: float | None = None
    steps: int | None = None
    pressure_iterations: float | None = None  # of the whole run
    error: float | None = None
    distance_to_finest: float | None = None  # of the finest: its uncertainty, the distance of the next finest
    distance_to_standard: float | None = None
    distance_in_parameter: float | None = None
    quantities: dict = field(default_factory=dict)  # name: error
    judged_by: str = "reference"                    # or "finest": the reference is another code, or there is none
    settings: dict = field(default_factory=dict)    # key with unit: effective value
    base: str = ""     # hash of the case as it stands
    version: str = ""  # of the executables

    @property
    def done(self):
        return self.status == "done"


def _cells(row):
    cells = {name: getattr(row, name) for name in ("point", "parameter", "value", "options", "status", "exit_code", "cause", "end_time_s",
                                                    "cpu_s", "wall_s", "steps", "pressure_iterations")}
    cells |= {f"{name}_percent": None if getattr(row, name) is None else 100 * getattr(row, name) for name in _PERCENT}
    cells["judged_by"] = row.judged_by
    cells |= {_OF + name: 100 * value for name, value in row.quantities.items()}
    cells |= row.settings | {"base": row.base, "version": row.version}
    return {name: "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
            for name, value in cells.items()}


def header(quantities, settings):
    """The columns of a study."""
    row = Row("", quantities=dict.fromkeys(quantities, 0.0), settings=dict.fromkeys(settings, ""))
    return list(_cells(row))


def _row(cells):
    row = Row(cells["point"])
    for written, cell in cells.items():
        name = _OLD_NAMES.get(written, written)
        if name in _TEXTS:
            setattr(row, name, cell)
        elif name in _NUMBERS:
            setattr(row, name, _NUMBERS[name](cell) if cell else None)
        elif name.removesuffix("_percent") in _PERCENT:
            setattr(row, name.removesuffix("_percent"), float(cell) / 100 if cell else None)
        elif name.startswith(_OF):
            row.quantities |= {name.removeprefix(_OF): float(cell) / 100} if cell else {}
        else:
            row.settings[name] = cell
    return row


def read(path):
    """All whole rows of the file; none if there is no file."""
    if not path.is_file():
        return []
    with open(path, encoding="utf-8", newline="") as file:
        table = list(csv.reader(file))
    try:
        return [_row(dict(zip(table[0], line))) for line in table[1:] if len(line) == len(table[0])]
    except (KeyError, ValueError) as error:
        raise Error(BAD_INPUT, f"{path} is not a table of a study ({error}); move it away or choose another --out.") from error


def append(path, row, columns):
    """Adds one row; a file with other columns (other gauges, other parameters) is written anew around it."""
    earlier = read(path)
    known = path.is_file() and path.read_text(encoding="utf-8").splitlines()[:1] == [_line(columns)]
    if not known:
        write(path, [*earlier, row], columns)
        return
    with open(path, "a", encoding="utf-8", newline="") as file:
        csv.DictWriter(file, columns, extrasaction="ignore", restval="", lineterminator="\n").writerow(_cells(row))


def _line(columns):
    return ",".join(f'"{column}"' if "," in column else column for column in columns)


def write(path, rows, columns):
    """Writes the whole file so that a reader sees the old or the new one."""
    temporary = path.with_suffix(".tmp")
    with open(temporary, "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore", restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(_cells(row) for row in rows)
    os.replace(temporary, path)
