"""Files on a disk that may be full: the sentence about it, and HDF5 files that stay whole."""

import contextlib
import os

import h5py

from tern.errors import INPUT_OUTPUT, in_words
from tern.participant.channel import RunEnded


@contextlib.contextmanager
def writing(path):
    """What the system refuses while `path` is written ends the run with exit code 5 and the remedy."""
    try:
        yield
    except OSError as error:
        why = in_words(error, "free space or choose another --out")
        raise RunEnded(INPUT_OUTPUT, f"Cannot write {path}: {why} (frames written before are kept).") from error


def put(descriptor, content, offset):
    """Writes all of it."""
    while content:
        done = os.pwrite(descriptor, content, offset)
        content, offset = content[done:], offset + done


class _Image:
    """What HDF5 sees as a file. What it writes is kept until commit(): on a full disk it can neither close the file nor end
    without a crash, and leaves the frames before unreadable."""

    def __init__(self, descriptor):
        self._descriptor, self._place, self._writes = descriptor, 0, []
        self._end = self._before = os.fstat(descriptor).st_size

    def seek(self, offset, whence=os.SEEK_SET):
        self._place = offset + (self._end if whence == os.SEEK_END else self._place if whence == os.SEEK_CUR else 0)
        return self._place

    def tell(self):
        return self._place

    def read(self, count):
        """By which h5py knows a file."""
        content = bytearray(count)
        self.readinto(content)
        return bytes(content)

    def readinto(self, buffer):
        """The bytes of the file with all that was written since; nothing is a zero."""
        begin, count = self._place, len(buffer)
        content = bytearray(os.pread(self._descriptor, count, begin).ljust(count, b"\0"))
        for offset, written in self._writes:
            first, last = max(begin, offset), min(begin + count, offset + len(written))
            if first < last:
                content[first - begin:last - begin] = written[first - offset:last - offset]
        buffer[:] = content
        self._place += count
        return count

    def write(self, content):
        self._writes.append((self._place, bytes(content)))
        self._place += len(content)
        self._end = max(self._end, self._place)
        return len(content)

    def truncate(self, size):
        self._end = size

    def flush(self):
        """All is written in commit()."""

    def commit(self):
        """What lengthens the file comes first: when there is no room for it the file stays as it was. The rest has its room."""
        try:
            for offset, content in self._writes:
                put(self._descriptor, content[max(0, self._before - offset):], max(offset, self._before))
            os.ftruncate(self._descriptor, max(self._end, self._before))
        except OSError:
            os.ftruncate(self._descriptor, self._before)
            raise
        for offset, content in self._writes:
            put(self._descriptor, content[:max(0, self._before - offset)], offset)
        os.ftruncate(self._descriptor, self._end)


@contextlib.contextmanager
def hdf5_file(path, anew=False):
    """An h5py.File to write to, which is on the disk as a whole afterwards, or not at all."""
    with writing(path), open(path, "w+b" if anew else "r+b", buffering=0) as file:
        image = _Image(file.fileno())
        with h5py.File(image, "w" if anew else "r+") as contents:
            yield contents
        image.commit()
