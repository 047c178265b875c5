"""Pieces of HTML. Whatever comes from a file passes through text(); what these functions return is HTML already."""

import base64
import hashlib
import html
import io
from pathlib import Path
from string import Template

FOLDER = Path(__file__).resolve().parent
WIDEST_PICTURE = 1600  # pixels; a screen shows no more


def text(value):
    """A value as text of the page."""
    return html.escape("" if value is None else str(value))


def number(value):
    """A number as people read it; other things as text."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return text(value)
    return f"{value:d}" if isinstance(value, int) else f"{value:.4g}"


def cell(value, heading=False):
    if heading:
        return f'<th scope="row">{value}</th>'
    plain = html.unescape(value).strip()
    try:
        float(plain.split(" ")[0] if plain.endswith(" %)") else plain)
    except ValueError:
        return f'<td class="long">{value}</td>' if len(plain) > 25 and "<" not in value else f"<td>{value}</td>"
    return f'<td class="number">{value}</td>'


def table(head, rows, caption="", sortable=False, marked=()):
    """A table that scrolls by itself when the screen is narrow. Cells are HTML; the first of a row is its heading.

    `marked`: numbers of rows that stand out.
    """
    titles = "".join(f'<th scope="col">{f"<button>{title}</button>" if sortable else title}</th>' for title in head)
    lines = [f"<tr{' class=differs' if line in marked else ''}>" + "".join(cell(value, place == 0) for place, value in enumerate(row))
             + "</tr>" for line, row in enumerate(rows)]
    heading = f"<caption>{caption}</caption>" if caption else ""
    return (f'<div class="scroll" tabindex="0"><table>{heading}<thead><tr>{titles}</tr></thead>\n<tbody>'
            + "\n".join(lines) + "</tbody></table></div>")


def pairs(entries):
    """A short list of names and values."""
    return "<dl>" + "".join(f"<dt>{name}</dt><dd>{value}</dd>" for name, value in entries if value not in (None, "")) + "</dl>"


def inline(kind, content):
    """Bytes as an address that needs no network."""
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def drawing(figure, alt, vector=True):
    """A matplotlib figure, closed afterwards: curves as SVG, fields of thousands of particles as PNG at screen resolution."""
    import matplotlib.pyplot as plt
    content = io.BytesIO()
    if vector:
        with plt.rc_context({"svg.hashsalt": "tern"}):
            figure.savefig(content, format="svg", dpi=110, bbox_inches="tight", metadata={"Date": None, "Creator": None})
    else:
        figure.savefig(content, format="png", dpi=110, bbox_inches="tight")
        content = fewer_colours(content)
    plt.close(figure)
    return picture(inline("image/svg+xml" if vector else "image/png", content.getvalue()), alt)


def fewer_colours(content):
    """A PNG with the 256 colours that suit it best: a third of the size, and nobody sees it."""
    from PIL import Image
    smaller = io.BytesIO()
    with Image.open(content) as image:
        image.convert("RGB").quantize(256, dither=Image.Dither.NONE).save(smaller, "png", optimize=True)
    return smaller


def picture(source, alt, caption=None):
    """A figure whose source is an inline address; `alt` says what it shows to who does not see it."""
    below = f"<figcaption>{text(caption)}</figcaption>" if caption else ""
    return f'<figure><img src="{source}" alt="{text(alt)}">{below}</figure>'


def png_source(path):
    """The inline address of a PNG file, no wider than a screen."""
    from PIL import Image
    with Image.open(path) as image:
        if image.width <= WIDEST_PICTURE:
            return inline("image/png", path.read_bytes())
        smaller = image.convert("RGB").resize((WIDEST_PICTURE, round(image.height * WIDEST_PICTURE / image.width)))
        content = io.BytesIO()
        smaller.save(content, "png", optimize=True)
        return inline("image/png", content.getvalue())


def section(title, body, name, level=2):
    return f'<section aria-labelledby="{name}"><h{level} id="{name}">{title}</h{level}>\n{body}\n</section>'


def page(title, head, sections, sources):
    """The whole page. `sections`: [(name, title, HTML)]. Its policy forbids every request, and every script but its own."""
    script = (FOLDER / "page.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    policy = (f"default-src 'none'; img-src data:; media-src data:; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; "
              "base-uri 'none'; form-action 'none'")
    contents = "\n".join(f'<li><a href="#{name}">{label}</a></li>' for name, label, _ in sections)
    return Template((FOLDER / "page.html").read_text(encoding="utf-8")).substitute(
        title=text(title), head=head, contents=contents, policy=policy, script=script, sources=text(sources),
        style=(FOLDER / "page.css").read_text(encoding="utf-8"), body="\n".join(body for _, _, body in sections))
