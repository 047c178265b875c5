"""Frames of one side for ParaView and ./tern plot: NAME.h5 with a group per frame, and its index NAME.xmf (docs/ARCHITECTURE.md)."""

import os
from pathlib import Path

import h5py
import numpy

from tern.participant.disk import hdf5_file, put, writing

_HEAD = ('<?xml version="1.0" ?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n<Xdmf Version="3.0">\n<Domain>\n'
         '<Grid Name="frames" GridType="Collection" CollectionType="Temporal">\n')
_TAIL = "</Grid>\n</Domain>\n</Xdmf>\n"
_UNITS = {"position": "m", "displacement": "m", "velocity": "m/s", "pressure": "Pa", "surface_position": "m",
          "stress_xx": "Pa", "stress_xy": "Pa", "stress_yy": "Pa"}
_EXACT = {"position": numpy.float64, "surface_position": numpy.float64, "surface_force": numpy.float64}


def _item(rows, columns, name, source, kind="Float", precision=4):
    size = f"{rows} {columns}" if columns else str(rows)
    return f'<DataItem Format="HDF" Dimensions="{size}" NumberType="{kind}" Precision="{precision}">{source}/{name}</DataItem>'


class FrameWriter:
    """Writes frames of points. The file is open only while a frame is written, so that it can be read at any time."""

    def __init__(self, directory, name, dimension, anew=True):
        """Not `anew`: the files are there, and go_back() follows."""
        self._data, self._index = Path(directory) / f"{name}.h5", Path(directory) / f"{name}.xmf"
        self._units = _UNITS | {"surface_force": "N/m" if dimension == 2 else "N"}
        self._end, self.frames = len(_HEAD), 0  # of the index [bytes]
        if anew:
            with hdf5_file(self._data, anew=True):
                pass
            with writing(self._index):
                self._index.write_text(_HEAD + _TAIL, encoding="utf-8")

    def mark(self):
        """Where the files are, for go_back()."""
        return [self.frames, self._end]

    def go_back(self, mark):
        """Makes both files what they were at mark(), byte for byte: those with more frames are written anew, for HDF5 does not give back
        the room of what is removed."""
        self.frames, self._end = (int(entry) for entry in mark)
        kept = [f"frame_{n:06d}" for n in range(self.frames)]
        with h5py.File(self._data, "r") as file:
            more = set(file) - set(kept)
        if more:
            anew = self._data.with_suffix(".h5.tmp")
            with hdf5_file(anew, anew=True):
                pass
            with h5py.File(self._data, "r") as file:
                for name in kept:
                    frame = file[name]
                    self._put(anew, name, dict(frame.attrs), {field: (frame[field][()], frame[field].attrs.get("unit")) for field in frame})
            os.replace(anew, self._data)
        self._append("")

    @staticmethod
    def _put(path, name, numbers, datasets):
        """Adds a frame: {name: number}, {name: (array, unit or None)}. In the order of names, in which HDF5 gives them back."""
        with hdf5_file(path) as file:
            group = file.create_group(name + ".unfinished")
            for key in sorted(numbers):
                group.attrs[key] = numbers[key]
            for field in sorted(datasets):
                array, unit = datasets[field]
                dataset = group.create_dataset(field, data=array)
                if unit is not None:
                    dataset.attrs["unit"] = unit
            file.move(name + ".unfinished", name)  # a frame that could not be finished is no frame

    def write(self, time_s, step, fields, beside=None):
        """`fields`: name -> one scalar or vector per point, "position" among them; `beside`: points of another number."""
        name = f"frame_{self.frames:06d}"
        arrays = {field: self._array(field, values) for field, values in (fields | (beside or {})).items()}
        rows = len(arrays["position"])
        datasets = {field: (array, self._units.get(field, "1")) for field, array in arrays.items()}
        self._put(self._data, name, {"time_s": time_s, "step": step},
                  datasets | {"connectivity": (numpy.arange(rows, dtype=numpy.int32), None)})
        source = f"{self._data.name}:/{name}"
        grid = (f'<Grid Name="{name}" GridType="Uniform">\n<Time Value="{time_s:.17g}"/>\n<Topology TopologyType="Polyvertex" '
                        f'NumberOfElements="{rows}" NodesPerElement="1">{_item(rows, 0, "connectivity", source, "Int")}</Topology>\n'
                        f'<Geometry GeometryType="XYZ">{_item(rows, 3, "position", source, precision=8)}</Geometry>\n')
        for field in fields:
            if field != "position":
                vector = arrays[field].ndim == 2
                grid += (f'<Attribute Name="{field}" AttributeType="{"Vector" if vector else "Scalar"}" Center="Node">'
                                f'{_item(rows, 3 if vector else 0, field, source)}</Attribute>\n')
        self._append(grid + "</Grid>\n")
        self.frames += 1

    @staticmethod
    def _array(field, values):
        array = numpy.asarray(values, dtype=_EXACT.get(field, numpy.float32))
        if array.ndim == 2 and array.shape[1] == 2:
            array = numpy.column_stack([array, numpy.zeros(len(array), array.dtype)])
        return array

    def _append(self, text):
        """Puts text before the end of the index, which on a full disk stays as it was."""
        content, tail = text.encode(), _TAIL.encode()
        with writing(self._index), open(self._index, "r+b", buffering=0) as file:
            try:
                put(file.fileno(), content + tail, self._end)
            except OSError:
                put(file.fileno(), tail, self._end)
                file.truncate(self._end + len(tail))
                raise
            file.truncate(self._end + len(content) + len(tail))
        self._end += len(content)
