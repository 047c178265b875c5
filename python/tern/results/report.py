"""run.json: what ./tern run leaves, with the reports of all processes in it."""

import json

from tern.errors import UnreadableRun


def read(directory):
    """The contents of run.json; UnreadableRun where there is none or it cannot be read."""
    path = directory / "run.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UnreadableRun(f"{directory} holds no run: there is no run.json in it.") from None
    except (OSError, ValueError) as error:
        raise UnreadableRun(f"{path} cannot be read: {error}.") from None
