"""The results of one run as arrays: CSV tables, HDF5 frames, run.json, and the references its expected.toml names."""

import csv
import functools
import json
import tomllib
from pathlib import Path

import h5py
import numpy as np


class UnreadableRun(Exception):
    """The directory does not hold what a picture needs; one sentence."""


def read_table(path):
    """{column: array} of a CSV file; undefined cells are NaN, text columns arrays of strings."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(line for line in file if line.strip() and not line.startswith("#")))
    if not rows:
        return {}
    header, rows = rows[0], [row for row in rows[1:] if len(row) == len(rows[0])]
    table = {}
    for number, name in enumerate(header):
        cells = [row[number] for row in rows]
        try:
            table[name.strip()] = np.array([float(cell) if cell.strip() else np.nan for cell in cells])
        except ValueError:
            table[name.strip()] = np.array(cells)
    return table


def distinguish(runs):
    """Gives runs whose directories are called alike their whole path as a label."""
    names = [run.directory.resolve().name for run in runs]
    for run, name in zip(runs, names):
        if names.count(name) > 1:
            run.legend = str(run.directory)


class Run:
    """One results directory. Whatever is missing reads as empty: a fluid alone, a structure alone, a run cut short."""

    def __init__(self, directory):
        self.directory = Path(directory)
        if not self.directory.is_dir():
            raise UnreadableRun(f"There is no directory {directory}; give the directory a run has written, e.g. "
                                f"runs/dam_break_plate.")
        path = self.directory / "run.json"
        self.contents = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        self.name = self.contents.get("case", self.directory.name)
        self.legend = self.directory.resolve().name
        self.title = self.contents.get("title") or self.name
        if not any((self.directory / name).exists() for name in ("gauges.csv", "fluid.h5", "structure.h5", "steps.csv")):
            raise UnreadableRun(f"{directory} holds no results (gauges.csv, steps.csv, fluid.h5, structure.h5): it is not "
                                f"the directory of a run.")

    def label(self):
        """How a legend calls this run: its directory, or what distinguish() made of it."""
        return self.legend

    def table(self, name):
        path = self.directory / name
        return read_table(path) if path.exists() else {}

    def frame_times(self, process):
        """[(time, group name)] in order of time."""
        path = self.directory / f"{process}.h5"
        if not path.exists():
            return []
        with h5py.File(path, "r") as file:
            return sorted((float(group.attrs["time_s"]), name) for name, group in file.items()
                          if name.startswith("frame_"))

    def frame(self, process, time):
        """(time, {field: array}) of the frame nearest to `time`, or None if the process wrote none."""
        times = self.frame_times(process)
        if not times:
            return None
        nearest, name = min(times, key=lambda entry: abs(entry[0] - time))
        with h5py.File(self.directory / f"{process}.h5", "r") as file:
            return nearest, {field: np.asarray(data) for field, data in file[name].items()
                             if isinstance(data, h5py.Dataset)}

    @functools.cache
    def spacing(self, process):
        """Particle spacing [m], from the first frame: the median distance to the nearest neighbour."""
        times = self.frame_times(process)
        if not times:
            return None
        position = self.frame(process, times[0][0])[1]["position"]
        sample = position[:: max(1, len(position) // 150)]
        distance = np.linalg.norm(sample[:, None, :] - position[None, :, :], axis=2)
        distance[distance == 0] = np.inf
        return float(np.median(distance.min(axis=1)))

    def wall_boxes(self):
        """[(min, max, open faces)] of the fixed rigid walls that are boxes."""
        boxes = []
        for wall in self.contents.get("settings", {}).get("wall", []):
            shape = wall.get("container") or wall.get("obstacle") or {}
            if "box" in shape and not {"displacement", "rotation", "motion_file"} & set(wall):
                boxes.append((shape["box"]["min"], shape["box"]["max"], set(wall.get("open", []))))
        return boxes

    def references(self):
        """{gauge column: [(label, t, value)]} of the CSV references named in the expected.toml of the case."""
        path = Path(self.contents.get("case_path", "")).parent / "expected.toml"
        if not path.is_file():
            return {}
        curves = {}
        for quantity in tomllib.loads(path.read_text(encoding="utf-8")).get("quantity", []):
            reference = path.parent / quantity.get("csv", "")
            if "csv" not in quantity or isinstance(quantity["column"], list) or not reference.is_file():
                continue
            entries = curves.setdefault(quantity["column"], {})
            table = read_table(reference)
            label = quantity["source"].split(",")[0].split(";")[0]
            entries[(reference, quantity["csv_column"])] = (label, table["t_s"], table[quantity["csv_column"]])
        return {column: list(entries.values()) for column, entries in curves.items()}
