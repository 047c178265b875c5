"""run.json: what ./tern run leaves, with the reports of all processes in it."""

import json

from tern.errors import UnreadableRun, in_words
from tern.results.entries import MOMENT, NUMBER, TEXT, TRUTH, List, Table, maybe, wrong

#: What a process says of itself: report.ROLE.json, and in run.json an entry of `processes`.
PROCESS = Table({
    **dict.fromkeys(("cause_time", "cpu_s", "end_time_s", "exit_code", "process_id", "steps", "time_s", "wall_s"), maybe(NUMBER)),
    **dict.fromkeys(("cause", "git", "role", "status", "version"), maybe(TEXT)),
    **dict.fromkeys(("counts", "evaluations", "measures"), Table(others=maybe(NUMBER))), "timing_s": Table(others=NUMBER),
    "ranks": List(Table(dict.fromkeys(("particles", "ghosts", "cpu_s", "waiting_s", "peak_memory_bytes"), NUMBER) | {"machine": TEXT},
                        needed=("particles", "ghosts", "cpu_s", "waiting_s", "peak_memory_bytes", "machine"))),
    "resumed": Table({"step": NUMBER, "time_s": NUMBER}),
})

_NAMED = List(Table({"name": TEXT}, needed=("name",)))
_PLACES = List(Table({"name": TEXT, "diameter": NUMBER} | dict.fromkeys(("at", "from", "to"), List(NUMBER)), needed=("name",)))
_SIDE = Table({"body": List(Table())})
_SETTINGS = Table({
    "dimension": NUMBER, "end_time": NUMBER, "gravity": List(None), "output": Table(others=NUMBER), "gauge": _NAMED,
    "wall": List(Table({"name": TEXT, "container": Table(), "obstacle": Table(), "open": List(TEXT)})), "fluid": _SIDE, "structure": _SIDE,
    "coupling": Table()})
_LAUNCH = Table({
    **dict.fromkeys(("until", "threads", "ranks", "deadline"), maybe(NUMBER)),
    **dict.fromkeys(("hosts", "interface", "ports", "only", "endpoint"), maybe(TEXT)),
    **dict.fromkeys(("oversubscribe", "record", "allow_unstable"), TRUTH), "network_options": List(TEXT)})
_REPEATED = ("step", "time_s", "failed_at_s", "until_s", "halvings", "window_s")
_SPENT = Table(others=Table({"wall_s": maybe(NUMBER), "cpu_s": maybe(NUMBER)}))

RUN = Table({
    **dict.fromkeys(("case", "case_path", "title", "case_hash", "status", "first_cause", "first_cause_role", "version", "git"), TEXT),
    **dict.fromkeys(("exit_code", "launcher", "wall_s", "cpu_s", "steps"), NUMBER),
    "started": MOMENT, "settings": _SETTINGS, "gauge_places": _PLACES, "options": List(TEXT), "warnings": List(TEXT),
    "commands": Table({"fluid": TEXT, "structure": TEXT}), "launch": _LAUNCH, "spent": _SPENT, "exit_codes": Table(others=maybe(NUMBER)),
    "processes": Table(others=PROCESS), "resumed": List(Table({"date": TEXT, "step": NUMBER, "time_s": NUMBER})),
    "taken_back": List(Table(dict.fromkeys(_REPEATED, NUMBER), needed=_REPEATED)),
}, needed=("status",))

REMEDY = "It was cut short or changed: restore it from a copy, or run the case again."


def read(directory):
    """The contents of run.json, each entry of the type that its readers take for granted.

    UnreadableRun where there is no such file, or where it is damaged: it says which entry, why, and what to do.
    """
    path = directory / "run.json"
    try:
        contents = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UnreadableRun(f"{directory} holds no run: there is no run.json in it.") from None
    except OSError as error:
        raise UnreadableRun(f"{path} cannot be read: {in_words(error)}.") from None
    except (ValueError, RecursionError) as error:
        raise UnreadableRun(f"{path} is no JSON: {error}. {REMEDY}") from None
    _refuse(path, wrong(contents, RUN))
    return contents


def demand(directory, contents, needed):
    """Raises UnreadableRun unless these entries are in the contents of run.json."""
    _refuse(directory / "run.json", wrong(contents, Table(needed=needed)))


def _refuse(path, fault):
    if fault:
        raise UnreadableRun(f"{path}: {fault}. {REMEDY}")
