"""write_page(): the report of runs, studies and maps as one HTML file."""

import os
from pathlib import Path

from tern.plot import style
from tern.results import summary
from tern.results.run import Run, distinguish
from tern.report import comparison, folder, markup, run as one_run

RUN_FILES = ("run.json", "gauges.csv", "fluid.h5", "structure.h5", "steps.csv")


def _read(directory):
    """The Run in a directory, or the directory itself where it holds other results."""
    if directory.is_dir() and not any((directory / name).exists() for name in RUN_FILES) and folder.is_folder(directory):
        return directory
    return Run(directory)


def _sections(prefix, parts, level):
    """[(name, title, HTML)] from [(title, HTML)]."""
    return [(f"{prefix}{place}", title, markup.section(title, body, f"{prefix}{place}", level)) for place, (title, body) in
            enumerate(parts, 1)]


def _chapter(name, title, head, parts):
    """One of several runs or directories: a section of sections."""
    inner = "".join(body for _, _, body in _sections(name + "-", parts, 3))
    return name, title, markup.section(title, head + inner, name)


def _common(directories):
    """The one directory, or the innermost that holds all of them."""
    whole = [Path(directory).resolve() for directory in directories]
    if len(whole) == 1:
        return Path(directories[0])
    return Path(summary.shown(os.path.commonpath([path.parent for path in whole])))


def write_page(directories, out=None, times=None):
    """Writes the page about `directories` (of runs, studies, maps of extremes) and returns its path.

    `out`: default report.html in the one directory, or for several in the directory that holds them. `times` [s]: of the field pictures.
    """
    style.apply()
    shown = [_read(Path(directory)) for directory in directories]
    path = Path(out) if out else _common(directories) / "report.html"
    runs = [entry for entry in shown if isinstance(entry, Run)]
    distinguish(runs)
    if len(shown) == 1:
        if runs:
            title, head, parts = runs[0].title, one_run.status(runs[0]), one_run.parts(runs[0], times, path.parent)
        else:
            title, head, parts = shown[0].resolve().name, "", folder.parts(shown[0])
        sections = _sections("part", parts, 2)
    else:
        names = [entry.label() if entry in runs else entry.resolve().name for entry in shown]
        title, head = ("Comparison: " if len(runs) == len(shown) else "") + ", ".join(names), ""
        sections = _sections("all", comparison.parts(runs), 2) if len(runs) > 1 else []
        for place, (entry, name) in enumerate(zip(shown, names), 1):
            is_run = entry in runs
            parts = one_run.parts(entry, times, path.parent) if is_run else folder.parts(entry)
            above = f"<p>{markup.text(entry.title)}</p>{one_run.status(entry)}" if is_run else ""
            sections.append(_chapter(f"result{place}", markup.text(name), above, parts))
    page = markup.page(title, head, sections, ", ".join(map(str, directories)))
    temporary = path.with_name(path.name + ".tmp")
    temporary.write_text(page, encoding="utf-8")
    os.replace(temporary, path)
    return path
