"""Curves over time: gauges with their references, energies, and the history of steps and solver."""

import matplotlib.pyplot as plt
import numpy as np

from tern.plot import references, style
from tern.results import tables

PANELS_OF_A_PAGE = 24
QUANTITIES = {"ux": "displacement x", "uy": "displacement y", "uz": "displacement z", "Fx": "force x", "Fy": "force y",
              "Fz": "force z", "Mx": "moment x", "My": "moment y", "Mz": "moment z", "Q": "flux", "p": "pressure",
              "eta": "surface elevation", "x": "position x"}


def split_column(column):
    """`plate.Fx_N_per_m` as (plate, force x, N/m): gauge before the last dot, quantity before its unit."""
    gauge, _, rest = column.rpartition(".")
    quantity = tables.UNIT.sub("", rest)
    return gauge or quantity, QUANTITIES.get(quantity, quantity), tables.unit(column)


def _panels(runs):
    """[(gauge, quantity, unit, [(run, column, table)])]: every column any of the runs has, those with a reference first."""
    panels = {}
    for run in runs:
        table = run.gauges
        for column in table:
            if column != "t_s" and np.isfinite(table[column]).any():
                gauge, quantity, unit = split_column(column)
                panels.setdefault(column, (gauge, quantity, unit, []))[3].append((run, column, table))
    referenced = {column for run in runs for column in references.of(run)}
    return sorted(panels.values(), key=lambda panel: panel[3][0][1] not in referenced)  # stable: file order otherwise


def _draw_panel(axis, runs, gauge, quantity, unit, curves):
    """One quantity of all runs that have it, its references dashed, each once; returns their labels."""
    drawn = {}
    for run, column, table in curves:
        for label, t, value in references.of(run).get(column, []):
            if any(np.array_equal(value, known) for known in drawn.values()):
                continue
            label = f"{label} ({run.name})" if label in drawn else label  # two cases, two curves of one source
            axis.plot(t, value, label=style.plain(label), **style.REFERENCE)
            drawn[label] = value
    for run, column, table in curves:
        axis.plot(table["t_s"], table[column], color=style.RUN_COLOURS[runs.index(run) % len(style.RUN_COLOURS)],
                  label=style.plain(run.label()) if len(runs) > 1 else "tern")
    axis.set_title(style.plain(f"{gauge}: {quantity}" if gauge != quantity else gauge), loc="left")
    axis.set_ylabel(style.plain(quantity if unit == "1" else f"{quantity} [{unit}]"))
    if drawn or len(runs) > 1:
        axis.legend()
    return drawn


def gauges(runs):
    """Figures of all gauges of one run with their references, or of the gauges of several runs over each other, so many quantities on
    each that it can be read."""
    panels = _panels(runs)
    for begin in range(0, len(panels), PANELS_OF_A_PAGE):
        yield _page(runs, panels[begin:begin + PANELS_OF_A_PAGE])


def _page(runs, panels):
    columns = 2 if len(panels) > 3 else 1
    rows = -(-len(panels) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(7.5 * columns, 2.9 * rows), squeeze=False, sharex=True,
                                layout="constrained")
    for axis, panel in zip(axes.flat, panels):
        _draw_panel(axis, runs, *panel)
    for axis in axes.flat[len(panels):]:
        axis.set_visible(False)
    for axis in axes.flat[max(0, len(panels) - columns):len(panels)]:
        axis.set_xlabel("t [s]")
        axis.tick_params(labelbottom=True)
    figure.suptitle("Comparison of gauges" if len(runs) > 1 else f"{style.plain(runs[0].title)}: gauges")
    return figure


def each_gauge(runs):
    """The same as one figure per quantity, one after the other: (what it shows, figure). Who takes it closes it."""
    for panel in _panels(runs):
        figure, axis = plt.subplots(figsize=(6.5, 3.4), layout="constrained")
        references = _draw_panel(axis, runs, *panel)
        axis.set_xlabel("t [s]")
        shown = " and ".join(run.label() for run, _, _ in panel[3]) if len(runs) > 1 else "this run"
        against = f" against {', '.join(sorted(references))} (dashed)" if references else ""
        yield f"{panel[3][0][1]} over time, {shown}{against}", figure


def energies(run):
    """Figure of every column of energy.csv: each side by itself, since the structure has little beside the fluid, and the interface."""
    table = run.energies
    if len(table.get("t_s", [])) < 2:
        return None
    work = [name for name in table if "_work_" in name or name.endswith("_dissipation_J")]
    change = " (potential: change since the start)"  # a potential energy has no natural zero
    groups = [(side + change, [name for name in table if name.startswith(side) and name not in work])
              for side in ("fluid", "structure")] + [("interface: work and dissipation, accumulated", work)]
    groups = [(title, names) for title, names in groups
              if any(np.nanmax(np.abs(table[name]), initial=0) > 0 for name in names)]
    if not groups:
        return None
    figure, axes = plt.subplots(len(groups), 1, figsize=(9, 3.0 * len(groups)), squeeze=False, sharex=True,
                                layout="constrained")
    for axis, (title, names) in zip(axes.flat, groups):
        for name in names:
            value = table[name] - (table[name][0] if "potential" in name else 0.0)
            axis.plot(table["t_s"], value, label=name.removesuffix("_J").replace("_", " "))
        axis.set_title(title, loc="left")
        axis.set_ylabel(f"energy [{table.unit(names[0])}]")
        axis.legend(ncols=2)
    axes[-1, 0].set_xlabel("t [s]")
    figure.suptitle(f"{style.plain(run.title)}: energy account")
    return figure


def steps(run):
    """Figure of step length and what limits it, pressure iterations, wall time per step."""
    table = run.steps
    if len(table.get("t_s", [])) < 2:
        return None
    names = [name for name in ("dt_s", "pressure_iterations", "wall_ms") if np.isfinite(table.get(name, [np.nan])).any()]
    figure, axes = plt.subplots(len(names), 1, figsize=(9, 2.7 * len(names)), squeeze=False, sharex=True,
                                layout="constrained")
    scale = {"dt_s": 1e3}
    titles = {"dt_s": "step length [ms]", "pressure_iterations": "pressure iterations", "wall_ms": "wall time of the step [ms]"}
    for axis, name in zip(axes.flat, names):
        value = scale.get(name, 1) * table[name]
        if name == "dt_s" and "limit" in table:
            limits = table["limit"].astype(str)
            for limit in sorted(set(limits)):
                chosen = limits == limit
                axis.plot(table["t_s"][chosen], value[chosen], ".", markersize=2.5, label=limit, rasterized=True)
            axis.legend(title="limited by", markerscale=4, loc="lower right")
        else:
            axis.plot(table["t_s"], value, ".", markersize=2, rasterized=True)
        axis.set_ylim(bottom=0)
        axis.set_ylabel(titles[name])
    axes[-1, 0].set_xlabel("t [s]")
    figure.suptitle(f"{style.plain(run.title)}: steps")
    return figure
