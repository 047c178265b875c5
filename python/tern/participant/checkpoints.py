"""Checkpoints of a participant in Python: DIR/checkpoint/ROLE.STEP.npz, arrays by name. The last two are kept."""

import hashlib
import io
import os
import re
from pathlib import Path

import numpy

from tern.errors import BAD_INPUT
from tern.participant.channel import RunEnded
from tern.participant.disk import writing

KEPT = 2


class Checkpoints:
    """Those of one role of the run in `directory`."""

    def __init__(self, directory, role):
        self._folder, self._role = Path(directory) / "checkpoint", role

    def _paths(self):
        """{step: path}, newest first."""
        found = {int(match.group(1)): path for path in self._folder.glob(f"{self._role}.*.npz")
                 if (match := re.fullmatch(rf"{self._role}\.(\d+)\.npz", path.name))}
        return dict(sorted(found.items(), reverse=True))

    def clear(self):
        """Removes them all: a run begins anew."""
        for path in self._paths().values():
            path.unlink(missing_ok=True)

    def files(self):
        """[(step, hash)] of those that can be read."""
        found = []
        for step, path in self._paths().items():
            try:
                found.append((step, hashlib.sha256(path.read_bytes()).hexdigest()))
            except OSError:
                continue
        return found

    def save(self, step, arrays):
        """Keeps `arrays`, name -> array, for this step; returns the hash."""
        with writing(self._folder):
            self._folder.mkdir(parents=True, exist_ok=True)
        content = io.BytesIO()
        numpy.savez(content, **arrays)
        temporary, path = self._folder / f"{self._role}.npz.tmp", self._folder / f"{self._role}.{step:09d}.npz"
        try:
            with writing(path), open(temporary, "wb") as file:
                file.write(content.getbuffer())
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        except (OSError, RunEnded):
            temporary.unlink(missing_ok=True)
            raise
        older = [other for other in self._paths() if other < step]
        for other, old in self._paths().items():
            if other > step or other in older[KEPT - 1:]:
                old.unlink(missing_ok=True)
        return hashlib.sha256(content.getbuffer()).hexdigest()

    def load(self, step):
        """The arrays of this step by name."""
        path = self._folder / f"{self._role}.{step:09d}.npz"
        try:
            with numpy.load(path, allow_pickle=False) as file:
                return {name: file[name] for name in file.files}
        except (OSError, ValueError) as error:
            raise RunEnded(BAD_INPUT, f"{path} cannot be read: {error}.") from error
