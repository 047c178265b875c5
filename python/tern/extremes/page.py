"""The map as a section of a Markdown page, between two marker comments."""

import re
import shutil

from tern.errors import BAD_INPUT, Error
from tern.extremes import families

BEGIN, END = "<!-- extremes: written by ./tern extremes -->", "<!-- extremes: end -->"
CLASSES = ("bounded", "stopped", "wrong")


def counted(rows):
    """`12 cells: 10 bounded, 2 stopped, 0 wrong`."""
    return f"{len(rows)} cells: " + ", ".join(f"{sum(row['class'] == name for row in rows)} {name}" for name in CLASSES)


def outcome(row):
    """One cell of a table: figures of what is bounded, windows until a stop, why it is wrong."""
    if row["class"] == "stopped":
        return f"stopped after {row['windows']}" if int(row["windows"] or 0) else "refused"
    if row["class"] == "wrong":
        return "**wrong**: " + _short(row["message"])
    return ", ".join(f"{float(row[name]):.2g}" for name in ("speed", "unrest") if row[name])


def _short(message):
    # Where the map was made does not matter: of a path the name of the file is left.
    sentence = re.sub(r"(?<!\S)/\S*/", "", message.split(". ")[0]).replace("|", "\\|")
    return sentence if len(sentence) < 220 else sentence[:217] + "..."


def plates_table(rows):
    """The plates with a coupling per column."""
    by_name = {row["cell"]: row for row in rows if row["family"] == "plates"}
    lines = ["| plate | " + " | ".join(families.COUPLINGS) + " |", "|---|" + "---|" * len(families.COUPLINGS)]
    for cell in dict.fromkeys(name.rsplit(", ", 1)[0] for name in by_name):
        rows_of = [by_name.get(f"{cell}, {coupling}") for coupling in families.COUPLINGS]
        lines.append(f"| {cell} | " + " | ".join(outcome(row) if row else "" for row in rows_of) + " |")
    counts = [f"* {coupling}: {counted([row for name, row in by_name.items() if name.endswith(', ' + coupling)])}."
              for coupling in families.COUPLINGS]
    return [*lines, "", *counts]


def family_table(rows):
    """Everything of a family: class, figures, or what it said."""
    lines = ["| cell | class | speed | energy | volume | unrest | it says |", "|---|---|---|---|---|---|---|"]
    for row in rows:
        figures = " | ".join(f"{float(row[name]):.2g}" if row[name] else "" for name in ("speed", "energy", "volume", "unrest"))
        outcome_class = "**wrong**" if row["class"] == "wrong" else row["class"]
        lines.append(f"| {row['cell']} | {outcome_class} | {figures} | {_short(row['message'])} |")
    return lines


def text(rows, found):
    """The section: counts by family, boundaries, plates, and the others."""
    names = list(dict.fromkeys(row["family"] for row in rows if row["family"] != "boundary"))
    lines = ["| family | cells | bounded | stopped | wrong |", "|---|---|---|---|---|"]
    for name in names:
        own = [row for row in rows if row["family"] == name]
        lines.append(f"| {name} | {len(own)} | " + " | ".join(str(sum(row["class"] == c for row in own)) for c in CLASSES) + " |")
    lines += ["", counted(rows) + "."]
    if found:
        lines += ["", "### Boundaries", "", "| what | found by bisection | unit | theory |", "|---|---|---|---|"]
        lines += [f"| {boundary.name} | {value} | {boundary.unit} | {boundary.theory} |" for boundary, value in found]
    if "plates" in names:
        lines += ["", "### Plates", "", *plates_table(rows)]
    for name in names:
        if name != "plates":
            lines += ["", f"### {name.capitalize()}", "", *family_table([row for row in rows if row["family"] == name])]
    return "\n".join(lines) + "\n"


def check(path):
    """The page with its markers; Error where there is none."""
    try:
        whole = path.read_text(encoding="utf-8")
    except OSError as error:
        raise Error(BAD_INPUT, f"--page {path} cannot be read: {error.strerror}.") from error
    if whole.count(BEGIN) != 1 or whole.count(END) != 1 or whole.index(BEGIN) > whole.index(END):
        raise Error(BAD_INPUT, f"--page {path}: the page needs the lines {BEGIN} and {END}, once each and in this order.")
    return whole


def insert(path, section, pictures):
    """Puts the section between the markers of a page, and the pictures into the folder `pictures` beside it."""
    whole = check(path)
    before, rest = whole.split(BEGIN)
    links = ""
    for picture in pictures:
        target = path.parent / "pictures" / f"extremes_{picture.name}"
        target.parent.mkdir(exist_ok=True)
        shutil.copyfile(picture, target)
        links += f"![{target.stem.replace('_', ': ')}](pictures/{target.name})\n\n"
    path.write_text(before + BEGIN + "\n" + links + section + END + rest.split(END)[1], encoding="utf-8")
