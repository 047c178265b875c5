"""The CSV tables of a run or of a reference: one line of names, a row per time, empty cells undefined, comments after #."""

import csv
import re
from collections.abc import Mapping

# The last part of a column's name: `P.ux_m`, `plate.Fx_N_per_m`, `fluid_kinetic_J`.
UNIT = re.compile(r"_((?:Nm|N|J|Pa|ms|m|s)\d?(?:_per_(?:m|s)\d?)?)$")


def read_cells(path):
    """(names, [cells of a row]); a last line that is still being written, or was never finished, is left out."""
    with open(path, encoding="utf-8", errors="replace", newline="") as file:  # a damaged byte is a damaged cell
        rows = csv.reader(line for line in file if line.strip() and not line.startswith("#"))
        header = [name.strip() for name in next(rows, [])]
        return header, [row for row in rows if len(row) == len(header)]


def read_table(path):
    """{column: array} of a CSV file; undefined cells are NaN, columns of text arrays of strings."""
    import numpy as np  # a run by itself needs no arrays
    header, rows = read_cells(path)
    table = {}
    for number, name in enumerate(header):
        cells = [row[number] for row in rows]
        try:
            table[name] = np.array([float(cell) if cell.strip() else np.nan for cell in cells])
        except ValueError:
            table[name] = np.array(cells)
    return table


def unit(column):
    """The unit in a column's name, `N/m` of `plate.Fx_N_per_m`; "1" for a number without one."""
    found = UNIT.search(column)
    return found.group(1).replace("_per_", "/") if found else "1"


class Table(Mapping):
    """Columns of a CSV file by name, each an array with one value per row; empty if there is no such file.

    `per_depth`: a table of a 2D run whose energies are those of one metre of depth, [J/m] although the columns are called `_J`.
    """

    def __init__(self, path, per_depth=False):
        self._columns = read_table(path) if path.exists() else {}
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
