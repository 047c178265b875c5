"""Error against CPU time of all points of a study, the front marked, the presets named."""

import matplotlib.pyplot as plt
from matplotlib.ticker import LogLocator

from tern.studies import front
from tern.plot import style

PRESET_COLOURS = {"draft": style.RUN_COLOURS[4], "standard": style.RUN_COLOURS[0], "reference": style.RUN_COLOURS[1]}


def _error(row):
    return max(100 * front.error_of(row), 1e-6)  # a logarithm has no place for 0


def _panel(axes, case, rows, named):
    """One study; `named`: the points of the front get their names."""
    known, best = front.measured(rows), front.pareto(rows)
    others = [row for row in known if row not in best and row.point not in PRESET_COLOURS]
    axes.plot([row.cpu_s for row in others], [_error(row) for row in others], "o", color="0.7", markersize=4, label="points of the study")
    axes.plot([row.cpu_s for row in best], [_error(row) for row in best], "-o", color=style.RUN_COLOURS[2], markersize=5,
              label="front: none is cheaper and closer")
    for name, colour in PRESET_COLOURS.items():
        row = front.find(rows, name)
        if row and row in known:
            axes.plot(row.cpu_s, _error(row), "D", color=colour, markersize=9, label=f"preset {name}", zorder=4)
    if named:
        _name_front(axes, best)
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(_plain)
        axis.set_minor_formatter(_plain)
        axis.set_minor_locator(LogLocator(subs=(2, 5)))
    axes.set_xlabel("CPU time [s]")
    axes.set_ylabel("error against the reference [%]" if front.by_reference(rows) else "distance to the finest run [%]")
    axes.set_title(case)
    axes.margins(x=0.12, y=0.12)
    axes.grid(True, which="both", alpha=0.25)


def _plain(value, _=None):
    return f"{value:g}"


def _name_front(axes, best):
    """A number at each point of the front, and beside the picture what it stands for."""
    names = []
    for number, row in enumerate(best, 1):
        axes.annotate(str(number), (row.cpu_s, _error(row)), xytext=(-6, -13), textcoords="offset points", fontsize=9, ha="center")
        names.append(f"{number}  {row.point if row.parameter in ('', 'preset') else row.parameter.rpartition('.')[2] + ' ' + row.value}")
    axes.text(1.02, 1.0, "the front\n" + "\n".join(names), transform=axes.transAxes, va="top", fontsize=9)


def draw(case, rows, path):
    """Writes the picture of one study; nothing without a finished point."""
    if not front.measured(rows):
        return
    style.apply()
    figure, axes = plt.subplots(figsize=(8.5, 5.5))
    _panel(axes, f"{case}: what accuracy costs", rows, True)
    axes.legend(loc="upper right")
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)


def panels(tables, path):
    """Writes one picture of several studies, {case: rows}, with one legend."""
    style.apply()
    tables = {case: rows for case, rows in tables.items() if front.measured(rows)}
    columns = min(3, len(tables))
    lines = -(-len(tables) // columns)
    figure, grid = plt.subplots(lines, columns, figsize=(4.6 * columns, 3.9 * lines), squeeze=False, layout="constrained")
    for axes, (case, rows) in zip(grid.flat, tables.items()):
        _panel(axes, case, rows, False)
    for axes in list(grid.flat)[len(tables):]:
        axes.set_visible(False)
    handles, labels = grid.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0), ncols=len(labels))
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)
