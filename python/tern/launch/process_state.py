"""What the kernel says of a process of this machine."""

from pathlib import Path


def of(number):
    """The letter of its state, as in ps: R, S, D, T, t, Z ...; None where there is no such process."""
    try:
        return Path(f"/proc/{number}/stat").read_text(encoding="utf-8", errors="replace").rsplit(")", 1)[1].split()[0]
    except (OSError, IndexError):
        return None
