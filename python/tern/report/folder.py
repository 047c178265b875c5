"""The part of a page that shows a directory of tables, pictures and text, whatever they are about: a study, a map of extremes."""

import csv
from urllib.parse import unquote, urlsplit

import markdown
from markdown.extensions import Extension
from markdown.treeprocessors import Treeprocessor

from tern.report import markup
from tern.report.markup import text

MOST_ROWS = 2000


def is_folder(directory):
    """Whether there is anything to show."""
    return any(next(directory.glob(pattern), None) for pattern in ("*.csv", "*.md", "*.png"))


class _Local(Treeprocessor):
    """Pictures of the directory become part of the page; of anything else only its text and, where it is harmless, its link stays."""

    def __init__(self, parser, directory, used):
        super().__init__(parser)
        self.directory, self.used = directory.resolve(), used

    def run(self, root):
        for image in root.iter("img"):
            path = (self.directory / unquote(image.get("src", ""))).resolve()
            if path.suffix == ".png" and path.is_file() and self.directory in path.parents:
                image.set("src", markup.png_source(path))
                self.used.add(path)
            else:
                image.tag, image.text = "em", image.get("alt") or image.get("src")
                image.attrib.clear()
        for link in root.iter("a"):
            if urlsplit(link.get("href", "").strip()).scheme not in ("", "http", "https", "mailto"):
                del link.attrib["href"]


class _Safe(Extension):
    """Markdown without raw HTML, which shows as text."""

    def __init__(self, directory, used):
        super().__init__()
        self.directory, self.used = directory, used

    def extendMarkdown(self, md):
        md.preprocessors.deregister("html_block")
        md.inlinePatterns.deregister("html")
        md.treeprocessors.register(_Local(md, self.directory, self.used), "local", 0)


def prose(path, used):
    """A Markdown file as HTML, its headings below those of the page; pictures it shows are added to `used`."""
    html = markdown.markdown(path.read_text(encoding="utf-8"), extensions=["tables", "fenced_code", _Safe(path.parent, used)])
    for level in range(4, 0, -1):
        html = html.replace(f"<h{level}>", f"<h{level + 2}>").replace(f"</h{level}>", f"</h{level + 2}>")
    return html.replace("<table>", '<div class="scroll" tabindex="0"><table>').replace("</table>", "</table></div>")


def sheet(path):
    """A CSV file as a table that can be sorted, its comments as the caption."""
    with open(path, encoding="utf-8", newline="") as file:
        lines = [line for line in file if line.strip()]
    comments = [line[1:].strip() for line in lines if line.startswith("#")]
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    if not rows:
        return f'<p class="note">{text(path.name)} is empty.</p>'
    caption = ". ".join([text(path.name), *map(text, comments)])
    if len(rows) - 1 > MOST_ROWS:
        caption += f": the first {MOST_ROWS} of {len(rows) - 1} rows"
    return markup.table(map(text, rows[0]), [list(map(text, row)) for row in rows[1:MOST_ROWS + 1]], caption, sortable=True)


def parts(directory):
    """[(title, HTML)]: the text, then the pictures it does not show itself, then the tables."""
    found, used = [], set()
    for path in sorted(directory.glob("*.md")):
        found.append((text(path.name), prose(path, used)))
    pictures = [path for path in sorted(directory.glob("*.png")) if path.resolve() not in used]
    if pictures:
        found.append(("Pictures", "".join(
            markup.picture(markup.png_source(path), f"Picture {path.stem.replace('_', ' ')}", path.name) for path in pictures)))
    return found + [(text(path.name), sheet(path)) for path in sorted(directory.glob("*.csv"))]
