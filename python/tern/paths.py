"""Where tern's own files are: in a clone of the repository, or where an installation has put them.

An installation says so by a module tern/_installed.py beside this one, with three places, absolute or from the folder of this module:

    EXECUTABLES = "../../../libexec/tern"  # tern-case, tern-fluid, tern-structure, tern-coupler
    SHARE = "../../../share/tern"          # cases/, docs/ (PARAMETERS.md, trade/) and tern.proto
    COMMAND = "../../../bin/tern"          # what starts this package

Then nothing is built, and what needs the sources says that it does.
"""

import functools
import importlib
from pathlib import Path

from tern.errors import BAD_INPUT, Error

PACKAGE = Path(__file__).resolve().parent
SCHEMA = "proto/wire/tern.proto"  # in the sources


@functools.cache
def _installed(name):
    """A place of tern/_installed.py; None in a clone."""
    try:
        return (PACKAGE / getattr(importlib.import_module("tern._installed"), name)).resolve()
    except ModuleNotFoundError:
        return None


def installed():
    """Whether tern runs from an installation, without sources."""
    return _installed("SHARE") is not None


def source():
    """The root of the sources."""
    if installed():
        raise Error(BAD_INPUT, "This needs the sources of tern, and this is an installed one: clone the repository and use its ./tern.")
    return PACKAGE.parent.parent


def build(preset="release"):
    """The directory of tern-case, tern-fluid, tern-structure and tern-coupler; in a clone it may not exist yet."""
    return _installed("EXECUTABLES") or source() / "build" / preset


def share():
    """What comes with tern: cases/ and docs/."""
    return _installed("SHARE") or source()


def cases():
    """The directories in which a case is found by its name, the user's own first."""
    return [Path("cases"), share() / "cases"]


def schema():
    """The messages of the protocol, a .proto file."""
    return share() / Path(SCHEMA).name if installed() else source() / SCHEMA


def command():
    """What a user types as ./tern."""
    return _installed("COMMAND") or source() / "tern"


def python():
    """The directory that has to be on PYTHONPATH for `import tern`."""
    return PACKAGE.parent


def old_names():
    """What `import side` and the like find: the names of tern.participant one version ago."""
    return PACKAGE / "participant" / "old_names"


def solvers():
    """The participants in Python that come with tern."""
    return PACKAGE / "participant" / "solvers"
