"""The frames of a run: what fluid.h5 and structure.h5 hold, read when it is asked for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

INDEX = "connectivity"  # for ParaView; no field
DIGITS = 9  # of times [s] that are the same: participants may write them differently


def _opened(path):
    """The file, to be read. OSError that names it where it is damaged, or not complete yet."""
    import h5py
    try:
        return h5py.File(path, "r")
    except OSError as error:
        if error.errno is not None:
            raise
        raise OSError(f"{path} cannot be read ({error})") from error


class Fields(Mapping):
    """The fields of one process in one frame: {name: array}, a row per particle; a vector has three columns, in 2D too."""

    def __init__(self, path, group, time_s, step):
        self._path, self._group = path, group
        self.time, self.step = time_s, step

    def _open(self):
        return _opened(self._path)

    def __getitem__(self, name):
        import h5py
        with self._open() as file:
            data = file[self._group].get(name)
            if not isinstance(data, h5py.Dataset):
                raise KeyError(f"{self._path.name} has no field {name}; it has {', '.join(self)}")
            return data[()]

    def __iter__(self):
        import h5py
        with self._open() as file:
            return iter([name for name, data in file[self._group].items() if isinstance(data, h5py.Dataset) and name != INDEX])

    def __len__(self):
        return len(list(iter(self)))

    def unit(self, name):
        """The unit of a field as text, from the attribute of its dataset; "1" where it has none."""
        with self._open() as file:
            if name not in file[self._group]:
                raise KeyError(f"{self._path.name} has no field {name}; it has {', '.join(self)}")
            text = file[self._group][name].attrs.get("unit", "1")
        return text.decode() if isinstance(text, bytes) else str(text)


def read(path):
    """[Fields] of all frames of one process in order of time; none where there is no such file."""
    if not path.exists():
        return []
    with _opened(path) as file:
        found = [Fields(path, name, float(group.attrs["time_s"]), int(group.attrs.get("step", 0))) for name, group in file.items()
                 if name.startswith("frame_")]
    return sorted(found, key=lambda fields: fields.time)


def nearest(frames, time):
    """Of a list of frames, in order of time, the one nearest to `time` [s]; None of none."""
    return min(frames, key=lambda frame: abs(frame.time - time), default=None)


@dataclass
class Frame:
    """One time of a run: the fields of fluid and structure, None for a side that has no frame at this time."""

    time: float  # s
    fluid: Fields | None = None
    structure: Fields | None = None


class Frames(Sequence):
    """The frames of a run in order of time: frames[0], frames[-1], frames[2:5]; len() of them."""

    def __init__(self, fluid, structure):
        known = {}
        for side, frames in (("fluid", fluid), ("structure", structure)):
            for fields in frames:
                setattr(known.setdefault(round(fields.time, DIGITS), Frame(fields.time)), side, fields)
        self._frames = [known[time] for time in sorted(known)]

    def __getitem__(self, place):
        return self._frames[place]

    def __len__(self):
        return len(self._frames)

    @property
    def times(self):
        """The times of all frames [s]."""
        return [frame.time for frame in self]

    def at(self, time):
        """The frame nearest to `time` [s]."""
        if not self._frames:
            raise IndexError("the run wrote no frame")
        return nearest(self._frames, time)
