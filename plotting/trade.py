"""Error against CPU time of all points of a study, the front marked, the presets named."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from launcher.study import front  # noqa: E402
from plotting import style  # noqa: E402

PRESET_COLOURS = {"draft": style.RUN_COLOURS[4], "standard": style.RUN_COLOURS[0], "reference": style.RUN_COLOURS[1]}


def _error(row):
    return max(100 * front.error_of(row), 1e-6)  # a logarithm has no place for 0


def picture(case, rows, path):
    """Writes the picture; nothing without a finished point."""
    known = front.measured(rows)
    if not known:
        return
    style.apply()
    figure, axes = plt.subplots(figsize=(8.5, 5.5))
    best = front.pareto(rows)
    others = [row for row in known if row not in best]
    axes.plot([row.cpu_s for row in others], [_error(row) for row in others], "o", color="0.65", markersize=5, label="points of the study")
    axes.plot([row.cpu_s for row in best], [_error(row) for row in best], "-o", color=style.RUN_COLOURS[2], markersize=6, label="front: none is cheaper and closer")
    for name, colour in PRESET_COLOURS.items():
        row = front.find(rows, name)
        if row and row in known:
            axes.plot(row.cpu_s, _error(row), "D", color=colour, markersize=9, label=f"preset {name}", zorder=4)
            axes.annotate(name, (row.cpu_s, _error(row)), xytext=(8, 8), textcoords="offset points", color=colour, weight="bold", zorder=5)
    _name_front(axes, [row for row in best if row.point not in PRESET_COLOURS])
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("CPU time [s]")
    kind = "error against the reference" if any(row.error is not None for row in rows) else "distance to the finest run"
    axes.set_ylabel(f"{kind} [%]")
    axes.set_title(f"{case}: what accuracy costs")
    axes.margins(x=0.15, y=0.12)
    axes.legend(loc="best")
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)


def _name_front(axes, best):
    """Names beside the points of the front, in turn above and below so that neighbours do not touch."""
    for number, row in enumerate(best):
        label = f"{row.knob.rpartition('.')[2] or row.point} {row.value}".strip()
        below = number % 2 == 0
        axes.annotate(label, (row.cpu_s, _error(row)), xytext=(-4, -14 if below else 10), textcoords="offset points", fontsize=8,
                      ha="right" if below else "left", color="0.25")
