"""Fonts, colours and saving, the same for every picture."""

import matplotlib.pyplot as plt

RUN_COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"]  # told apart with any colour vision
REFERENCE = {"color": "0.25", "linestyle": (0, (4, 2)), "linewidth": 1.3}


def apply():
    """Sets readable defaults."""
    plt.rcParams.update({
        "font.size": 11, "axes.titlesize": 12, "axes.labelsize": 11, "legend.fontsize": 9, "figure.dpi": 100,
        "savefig.dpi": 160, "axes.grid": True, "grid.alpha": 0.3, "axes.spines.top": False, "axes.spines.right": False,
        "lines.linewidth": 1.5, "axes.axisbelow": True,
    })


def plain(text):
    """Text that comes from a file, as it stands: matplotlib takes what is between two dollar signs for a formula."""
    return text.replace("$", r"\$")


def save(figure, run, name):
    """Writes RUN/plots/<name>.png and returns its path."""
    directory = run.directory / "plots"
    directory.mkdir(exist_ok=True)
    path = directory / f"{name}.png"
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)
    return path
