"""run.json: written so that a reader sees the old or the new one, and so that the end can be written on a full disk as well."""

import json
import os

ROOM = 1 << 15  # bytes that the first one takes, at least: what the end on a full disk has to fit into


def write_json(path, value, room=0):
    """Replaces the file as a whole; with `room` blanks fill it up to so many bytes."""
    temporary = path.with_suffix(".tmp")
    try:
        temporary.write_text((json.dumps(value, indent=1) + "\n").ljust(room - 1) + "\n" * (room > 0), encoding="utf-8")
        os.replace(temporary, path)
    except BaseException:  # Ctrl-C as well
        temporary.unlink(missing_ok=True)
        raise


def overwrite_json(path, value, less=()):
    """Writes into the blocks that the file has already: that takes no space. What does not fit loses the entries `less`, one by one."""
    room = path.stat().st_size
    for left_out in range(len(less) + 1):
        text = json.dumps({key: entry for key, entry in value.items() if key not in less[:left_out]}) + "\n"
        if len(text.encode()) <= room:
            break
    with open(path, "r+b", buffering=0) as file:
        file.write(text.encode().ljust(room))
