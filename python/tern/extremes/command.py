"""./tern extremes: the map, cell by cell; its table, page and pictures."""

import random
import time
from pathlib import Path

from tern.launch import build
from tern.errors import BAD_INPUT, DONE, NUMERICAL_FAILURE, Error
from tern.extremes import bisection, families, page, random_scenes
from tern.extremes.run_cell import run_cell
from tern.extremes.table import Table


class Progress:
    """A line per cell with what is left."""

    def __init__(self, cells, quiet):
        self.total, self.quiet = cells, quiet
        self.done, self.run = 0, 0
        self.began = time.monotonic()

    def cell(self, row, fresh):
        self.done += 1
        self.run += fresh
        left = (time.monotonic() - self.began) / max(self.run, 1) * max(self.total - self.done, 0)
        if not self.quiet and (fresh or row["class"] == "wrong"):
            note = f": {row['message']}" if row["class"] == "wrong" else ""
            print(f"[{self.done}/{self.total}] {row['class']:<8} {row['cell']}{note}  ({row['wall_s']} s; {_duration(left)} left)",
                  flush=True)


def _duration(seconds):
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


class Map:
    """Runs what the table does not hold yet."""

    def __init__(self, out, directory, progress):
        self.table, self.out, self.directory, self.progress = Table(out / "extremes.csv", build.digest(directory)), out, directory, progress
        self.rows = []

    def row(self, cell):
        known = self.table.known(cell)
        row = known or self.table.add(cell, run_cell(cell, self.out / "cells", self.directory))
        self.rows.append(row)
        self.progress.cell(row, known is None)
        return row

    def boundary(self, boundary):
        """(boundary, what was found) by a few runs."""
        found = bisection.find(boundary.bounded, boundary.beyond, lambda value: self.row(boundary.make(value))["class"] == "bounded")
        return boundary, bisection.text(*found)


def _random(count, seed):
    """The cells of so many random scenes; the seed is said, so that they can be asked for again."""
    if count < 1:
        raise Error(BAD_INPUT, f"--random {count}: give the number of scenes, at least 1.")
    seed = random.SystemRandom().randrange(10**6) if seed is None else seed
    print(f"random scenes 1 to {count} of --seed {seed}", flush=True)
    return [random_scenes.scene(seed, number) for number in range(1, count + 1)], []


def _chosen(only, quick):
    """(cells, boundaries) that were asked for."""
    names = list(families.FAMILIES)
    if only and only not in (*names, "boundary"):
        raise Error(BAD_INPUT, f"--only {only}: there is no such family; the families are {', '.join([*names, 'boundary'])}.")
    cells = [cell for name in names if only in (None, name) for cell in families.FAMILIES[name]()]
    if quick:
        return [cell for cell in cells if cell.name in families.QUICK], []
    return cells, list(families.boundaries()) if only in (None, "boundary") else []


def extremes(arguments):
    """The map or a part of it; DONE when nothing of it is wrong."""
    chosen = _random(arguments.random, arguments.seed) if arguments.random is not None else _chosen(arguments.only, arguments.quick)
    cells, boundaries = chosen
    if arguments.page:
        page.check(Path(arguments.page))
    directory = build.ensure(arguments.build)
    out = Path(arguments.out or "runs/extremes")
    out.mkdir(parents=True, exist_ok=True)
    progress = Progress(len(cells) + 7 * len(boundaries), arguments.quiet)
    whole = Map(out, directory, progress)
    for cell in cells:
        whole.row(cell)
    found = [whole.boundary(boundary) for boundary in boundaries]
    text = page.text(whole.rows, found)
    (out / "extremes.md").write_text(text, encoding="utf-8")
    from tern.extremes import picture
    pictures = picture.draw(whole.rows, out)
    if arguments.page:
        page.insert(Path(arguments.page), text, pictures)
    wrong = [row for row in whole.rows if row["class"] == "wrong"]
    if not arguments.quiet:
        print(page.counted(whole.rows) + f"; table, page and {len(pictures)} pictures in {out}", flush=True)
    for row in wrong:
        print(f"wrong: {row['family']}: {row['cell']}: {row['message']}", flush=True)
    return NUMERICAL_FAILURE if wrong else DONE
