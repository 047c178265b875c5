"""The CSV tables of a run or of a reference: one line of names, a row per time, empty cells undefined, comments after #."""

import contextlib
import csv
import math
import re
from collections.abc import Mapping

from tern.errors import UnreadableRun

# The last part of a column's name: `P.ux_m`, `plate.Fx_N_per_m`, `fluid_kinetic_J`.
UNIT = re.compile(r"_((?:Nm|N|J|Pa|ms|m|s)\d?(?:_per_(?:m|s)\d?)?)$")
REMEDY = "Restore the file from a copy, or correct that line."
MOST_SHOWN = 40  # characters of a cell that is no number


def _lines(file, numbers):
    """The lines that are neither empty nor comments; their numbers are added to `numbers`."""
    for number, line in enumerate(file, 1):
        if line.strip() and not line.startswith("#"):
            numbers.append((number, line.endswith(("\n", "\r"))))
            yield line


def _rows(path):
    """(number of its first line, whether it is more than a last line without an end, cells) of every row, that of the names included."""
    with open(path, encoding="utf-8", errors="replace", newline="") as file:  # a damaged byte is a damaged cell
        numbers = []
        rows = csv.reader(_lines(file, numbers))
        try:
            for row in rows:
                yield numbers[0][0], len(numbers) > 1 or numbers[0][1], row
                numbers.clear()
        except csv.Error as error:
            raise UnreadableRun(f"{path}, line {numbers[0][0]}: {error}. {REMEDY}") from None


def _check_length(path, line, cells, header):
    if len(cells) != len(header):
        raise UnreadableRun(f"{path}, line {line}: it has {len(cells)} cells, and there are {len(header)} columns. {REMEDY}")


def read_cells(path):
    """(names, [(number of the line, cells)]). A last line that is still being written, or was never finished, is left out.

    UnreadableRun where another line has more or fewer cells than there are names.
    """
    header, rows = [], []
    for line, finished, cells in _rows(path):
        if not header and finished:
            header = [name.strip() for name in cells]
            _check_names(path, line, header)
        elif finished or (len(cells) == len(header) and _is_number(cells[-1])):
            _check_length(path, line, cells, header)
            rows.append((line, cells))
    return header, rows


def _check_names(path, line, header):
    for column, name in enumerate(header, 1):
        if not name.isprintable() or "\N{REPLACEMENT CHARACTER}" in name:
            raise UnreadableRun(f"{path}, line {line}: the name of column {column}, {_shown(name)}, is no text. It was changed: restore "
                                "it from a copy, or run the case again.")


def _shown(cell):
    text = ascii(cell)
    return text if len(text) <= MOST_SHOWN else text[:MOST_SHOWN] + " ..."


def _is_number(cell):
    try:
        float(cell)
    except ValueError:
        return False
    return True


def number(path, line, column, cell):
    """The number in a cell, NaN in an empty one. UnreadableRun where there is something else."""
    try:
        return float(cell) if cell.strip() else math.nan
    except ValueError:
        raise UnreadableRun(f"{path}, line {line}, column {column}: {_shown(cell)} is no number. {REMEDY}") from None


def _column(path, name, rows, place):
    """The numbers of a column; a column without unit and without any number is one of text."""
    said = [row[place] for _, row in rows if row[place].strip()]
    if said and unit(name) == "1" and not any(map(_is_number, said)):
        return [row[place] for _, row in rows]
    return [number(path, line, name, row[place]) for line, row in rows]


def read_columns(path):
    """{column: list} of a CSV file; undefined cells are NaN, columns of text lists of strings. UnreadableRun where it is damaged."""
    header, rows = read_cells(path)
    return {name: _column(path, name, rows, place) for place, name in enumerate(header)}


def _as_far_as_possible(rows):
    with contextlib.suppress(UnreadableRun):
        yield from rows


def check(path, until):
    """Raises UnreadableRun where a table is damaged before a row of the time `until` [s] or earlier. What follows the last of these rows
    may be of any kind: a machine that was lost may have left it."""
    rows = _as_far_as_possible(_rows(path))
    _, _, header = next(rows, (1, True, []))
    _demand(path, header, ["t_s"])
    measured = [(place, name) for place, name in enumerate(header) if unit(name) != "1"]
    fault = None
    for line, _, cells in rows:
        try:
            _check_length(path, line, cells, header)
            values = {name: number(path, line, name, cells[place]) for place, name in measured}
        except UnreadableRun as error:
            fault = fault or error
            continue
        if fault and values["t_s"] <= until:
            raise fault


def _demand(path, header, needed):
    if missing := [column for column in needed if column not in header]:
        raise UnreadableRun(f"{path}: its first line, which has the names of the columns, lacks {' and '.join(missing)}. It was changed: "
                            "restore it from a copy, or run the case again.")


def read_table(path):
    """The same as arrays."""
    import numpy as np  # a run by itself needs no arrays
    return {name: np.array(values) for name, values in read_columns(path).items()}


def unit(column):
    """The unit in a column's name, `N/m` of `plate.Fx_N_per_m`; "1" for a number without one."""
    found = UNIT.search(column)
    return found.group(1).replace("_per_", "/") if found else "1"


class Table(Mapping):
    """Columns of a CSV file by name, each an array with one value per row; empty if there is no such file.

    `per_depth`: a table of a 2D run whose energies are those of one metre of depth, [J/m] although the columns are called `_J`.
    `needed`: columns that have to be there, as soon as there is any. UnreadableRun where they are not, or where the file is damaged.
    """

    def __init__(self, path, per_depth=False, needed=()):
        self._columns = read_table(path) if path.exists() else {}
        if self._columns:
            _demand(path, self._columns, needed)
        self._per_depth = per_depth

    def __getitem__(self, column):
        try:
            return self._columns[column]
        except KeyError:
            raise KeyError(f"there is no column {column}; there are {', '.join(self) or 'none'}") from None

    def __iter__(self):
        return iter(self._columns)

    def __len__(self):
        return len(self._columns)

    def __repr__(self):
        return f"<{len(self)} columns: {', '.join(self)}>"

    def unit(self, column):
        """The unit of a column as text, `m`, `N/m`, ...; "1" for a number without one."""
        self[column]  # an unknown name is an error here, too
        return "J/m" if self._per_depth and unit(column) == "J" else unit(column)
