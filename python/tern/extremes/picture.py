"""The map as coloured grids: what is bounded, stopped, wrong."""

import matplotlib.pyplot as plt
from matplotlib.patches import Patch

from tern.extremes import families

COLOURS = {"bounded": "#56b4e9", "stopped": "#e69f00", "wrong": "#d00000"}  # told apart with any colour vision


def _number(name):
    """The order of columns: by value where they are numbers, as they come elsewhere."""
    try:
        return float(name)
    except ValueError:
        return 0.0


def _grid(axes, cells, rows):
    """One grid; a cell shows its largest speed, or after how many windows it stopped."""
    row_names = list(dict.fromkeys(cell.row for cell in cells))
    column_names = sorted(dict.fromkeys(cell.column for cell in cells), key=_number)
    for cell in cells:
        row = rows.get((cell.family, cell.name))
        if row is None:
            continue
        x, y = column_names.index(cell.column), row_names.index(cell.row)
        axes.add_patch(plt.Rectangle((x, y), 1, 1, facecolor=COLOURS[row["class"]], edgecolor="white", linewidth=2))
        note = {"bounded": f"{float(row['speed'] or 0):.2g}", "stopped": row["windows"] or "refused", "wrong": "!"}[row["class"]]
        axes.text(x + 0.5, y + 0.5, note, ha="center", va="center", fontsize=8)
    axes.set_xlim(0, len(column_names))
    axes.set_ylim(len(row_names), 0)
    axes.set_xticks([x + 0.5 for x in range(len(column_names))], column_names, rotation=35 if max(map(len, column_names)) > 6 else 0,
                    fontsize=8,
                    ha="right" if max(map(len, column_names)) > 6 else "center")
    axes.set_yticks([y + 0.5 for y in range(len(row_names))], row_names, fontsize=8)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)


def _save(figure, path):
    figure.legend(handles=[Patch(color=colour, label=name) for name, colour in COLOURS.items()], loc="lower center", ncols=3, frameon=False)
    figure.savefig(path, dpi=130, bbox_inches="tight")
    plt.close(figure)
    return path


def draw(all_rows, out):
    """plates.png and families.png in `out`, of what has been run; their paths."""
    rows = {(row["family"], row["cell"]): row for row in all_rows}
    pictures = []
    if any(row["family"] == "plates" for row in all_rows):
        cells = list(families.plates())
        figure, grids = plt.subplots(1, 3, figsize=(15, 6), sharey=True)
        for axes, coupling in zip(grids, families.COUPLINGS):
            _grid(axes, [cell for cell in cells if cell.name.endswith(", " + coupling)], rows)
            axes.set_title(coupling)
            axes.set_xlabel("Young's modulus [Pa], wet faces")
        grids[0].set_ylabel("density over that of water, particles across")
        figure.suptitle("Plate in a tank: largest speed over sqrt(g H), or windows until it stopped")
        figure.subplots_adjust(bottom=0.22, wspace=0.05)
        pictures.append(_save(figure, out / "plates.png"))
    others = [name for name in families.FAMILIES if name != "plates" and any(row["family"] == name for row in all_rows)]
    if others:
        figure, grids = plt.subplots(-(-len(others) // 2), 2, figsize=(15, 2.2 * -(-len(others) // 2)), squeeze=False)
        for axes in grids.flat[len(others):]:
            axes.set_visible(False)
        for axes, name in zip(grids.flat, others):
            _grid(axes, list(families.FAMILIES[name]()), rows)
            axes.set_title(name)
        figure.subplots_adjust(hspace=0.8, wspace=0.35, bottom=0.08)
        pictures.append(_save(figure, out / "families.png"))
    return pictures
