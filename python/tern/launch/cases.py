"""From what the user typed to a case: its folder, its settings, and the directory a run of it writes to."""

import difflib
import errno
import json
import os
import subprocess
from pathlib import Path

from tern import paths
from tern.errors import BAD_INPUT, INPUT_OUTPUT, Error, in_words

ROLES = ("fluid", "structure", "coupler")


def named(file):
    """The names of all cases that have this file, e.g. case.toml."""
    return sorted({path.parent.name for directory in paths.cases() for path in directory.glob(f"*/{file}")})


def find(name_or_path):
    """The case.toml meant by a path of it, of its folder, or by a name under ./cases or among the cases that come with tern."""
    for candidate in (Path(name_or_path), *(directory / name_or_path for directory in paths.cases())):
        if candidate.is_dir() and (candidate / "case.toml").is_file():
            return (candidate / "case.toml").resolve()
        if candidate.is_file():
            return candidate.resolve()
    known = named("case.toml")
    near = difflib.get_close_matches(Path(name_or_path).name, known, n=1)
    hint = f"did you mean {near[0]}?" if near else f"known cases: {', '.join(known) or 'none'}."
    raise Error(BAD_INPUT, f"There is no case {name_or_path} (neither a file, nor a folder with a case.toml, "
                                   f"nor a name under {' or '.join(map(str, paths.cases()))}); {hint}")


def read(build, path, options):
    """Validates the case with tern-case and returns what it says: name, hash, has_fluid, has_structure, settings ..."""
    return _answer(build, "json", path, options)


def scene(build, path, options, most_particles):
    """Where everything is before the first step (scene/scene_at_start.hpp); the particles if they are at most so many."""
    return _answer(build, "scene", path, [*options, "--most", str(most_particles)])


def _answer(build, tool, path, options):
    answer = subprocess.run([build / "tern-case", tool, path, *options], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, errors="replace", check=False)
    if answer.returncode != 0:
        sentence = answer.stderr.strip().removeprefix("tern-case:").strip()
        raise Error(answer.returncode if answer.returncode in (BAD_INPUT, INPUT_OUTPUT) else BAD_INPUT,
                            sentence or f"tern-case could not read {path} (exit code {answer.returncode}).")
    try:
        return json.loads(answer.stdout)
    except json.JSONDecodeError as error:
        raise Error(INPUT_OUTPUT, f"tern-case {tool} {path} did not answer with JSON ({error}).") from error


def is_run(directory):
    """Whether results of a run are in `directory`."""
    return (directory / "run.json").exists() or any(directory.glob("report.*.json"))


def results_in(directory, roles=ROLES):
    """The files that these processes of a run write, as far as they are in `directory`."""
    names = ["run.json"] if roles == ROLES else []
    if "coupler" in roles:
        names += ["gauges.csv", "energy.csv", "steps.csv", "interface.record"]
    for role in roles:
        names += [f"report.{role}.json", f"{role}.h5", f"{role}.xmf", f"{role}.log"]
    kept = ("",) if roles == ROLES else (*roles, *(("manifest",) if "coupler" in roles else ()))
    return ([directory / name for name in names if (directory / name).exists()]
            + sorted(path for path in (directory / "checkpoint").glob("*.*") if path.name.startswith(kept)))


def make_out_directory(case_name, asked, force, roles=ROLES):
    """A directory for a new run. An earlier run is never overwritten unless forced: the name gets -2, -3, ...

    `asked` is None for the default runs/<case>; with `force` the results of `roles` in an existing directory are removed.
    """
    base = Path(asked) if asked else Path("runs") / case_name
    try:
        base.parent.mkdir(parents=True, exist_ok=True)
        directory, number = base, 1
        while True:
            try:
                directory.mkdir()
                break
            except FileExistsError:
                if number == 1 and not directory.is_dir():
                    raise Error(BAD_INPUT, f"{base} is a file, not a folder; choose a new or an empty folder with --out, for example "
                                           f"{Path('runs') / case_name}-2.") from None
                if directory.is_dir() and ((force and is_run(directory)) or not any(directory.iterdir())):
                    for result in results_in(directory, roles):
                        result.unlink()
                    break
                if directory.is_dir() and not is_run(directory) and asked and number == 1:
                    if not set(directory.iterdir()) - set(results_in(directory)) - {directory / "checkpoint"}:
                        break  # what a run has left that did not begin
                    raise Error(BAD_INPUT, f"{base} is a folder that holds other things than a run; choose a new or an empty one "
                                           f"with --out, for example {base / case_name}.") from None
                number += 1
                directory = base.with_name(f"{base.name}-{number}")
        if not os.access(directory, os.W_OK):
            raise OSError(errno.EACCES, os.strerror(errno.EACCES))
    except OSError as error:
        raise Error(INPUT_OUTPUT, f"The output directory {base} cannot be written: "
                                  f"{in_words(error, 'choose another one with --out')}.") from error
    return directory.resolve()
