"""extremes.csv: a row per cell, appended as cells finish; what is there already is not run again."""

import csv
import os

COLUMNS = ("family", "cell", "class", "speed", "energy", "volume", "unrest", "windows", "exit_code", "theory", "wall_s", "message",
           "fingerprint")


class Table:
    """The rows of a map by family and cell."""

    def __init__(self, path, executables=""):
        self.path, self.executables = path, executables
        self.rows = {}
        if path.is_file():
            with open(path, encoding="utf-8", newline="") as file:
                for row in csv.DictReader(file):
                    if row.get("fingerprint") and None not in row:  # a line cut off by a crash has no last column
                        self.rows[row["family"], row["cell"]] = row
        self._write_all()

    def _write_all(self):
        temporary = self.path.with_suffix(".tmp")
        with open(temporary, "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(self.rows.values())
        os.replace(temporary, self.path)

    def known(self, cell):
        """The row of this cell if it has been run as it is asked for now."""
        row = self.rows.get((cell.family, cell.name))
        return row if row and row["fingerprint"] == cell.fingerprint(self.executables) else None

    def add(self, cell, row):
        """Appends the row of a cell that has just been run."""
        whole = {name: str(row.get(name, "")) for name in COLUMNS}
        whole |= {"family": cell.family, "cell": cell.name, "theory": cell.theory, "fingerprint": cell.fingerprint(self.executables)}
        replaced = (cell.family, cell.name) in self.rows
        self.rows[cell.family, cell.name] = whole
        if replaced:
            self._write_all()
        else:
            with open(self.path, "a", encoding="utf-8", newline="") as file:
                csv.DictWriter(file, COLUMNS).writerow(whole)
        return whole
