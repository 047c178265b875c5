"""The part of a page that shows one run."""

import os
from pathlib import Path
from urllib.parse import quote

from tern.results import summary
from tern.verify import bands, expected
from tern.plot import curves, fields, scenes
from tern.report import markup, settings
from tern.report.markup import number, text

LARGEST_FILM = 3_000_000  # bytes; a larger one is linked to
PARTS = ("compute", "wait", "exchange", "output")


def status(run):
    """Status and first cause in one line of HTML."""
    state = run.contents.get("status", "unknown: there is no run.json")
    cause = run.contents.get("first_cause")
    role = run.contents.get("first_cause_role")
    blame = f" First cause{f' ({text(role)})' if role else ''}: {text(cause)}" if cause else ""
    return f'<p><span class="{"good" if state == "done" else "bad"}">{text(state)}</span>.{blame}</p>'


def overview(run):
    """When, how far, how long, with what."""
    contents = run.contents
    reached, end = reached_time(run), contents.get("settings", {}).get("end_time")
    return markup.pairs([
        ("case", text(contents.get("case_path") or run.name)),
        ("started", text(contents.get("started"))),
        ("reached", f"t = {number(reached)} s" + (f" of {number(end)} s" if end else "") if reached is not None else ""),
        ("wall time", f"{contents['wall_s']:.1f} s" if "wall_s" in contents else ""),
        ("CPU time", f"{contents['cpu_s']:.1f} s" if "cpu_s" in contents else ""),
        ("steps", number(contents.get("steps"))),
        ("options", text(" ".join(contents.get("options") or []))),
        ("in place of tern's own", text("; ".join(f"{role}: {command}" for role, command in contents.get("commands", {}).items()))),
        ("tern", text(" ".join(filter(None, (contents.get("version"), contents.get("git")))))),
        ("results in", text(run.directory)),
    ])


def reached_time(run):
    """The last time any process reports [s], None if none does."""
    times = [report.get("time_s") for report in run.contents.get("processes", {}).values()]
    return max((time for time in times if time is not None), default=None)


def judged(run):
    """(rows of bands.judge(), None), or (None, why there are none). An expected.toml that is wrong is an error."""
    path = Path(run.contents.get("case_path", "")).parent / "expected.toml"
    if not run.contents.get("case_path") or not path.is_file():
        return None, "The case has no expected.toml: there is nothing to hold its results against."
    if not (run.directory / "run.json").is_file():
        return None, "There is no run.json: the run cannot be judged."
    return bands.judge(run.directory, expected.read(path)), None


def verdict(row):
    return '<span class="good">passed</span>' if row["passed"] else '<span class="bad">failed</span>'


def quantities(run):
    """The quantities of expected.toml, as ./tern verify has them."""
    rows, reason = judged(run)
    if rows is None:
        return f'<p class="note">{reason}</p>'
    lines = []
    for row in rows:
        notes = [row["source"], row["why"], f"Known shortfall: {row['shortfall']}" if row["shortfall"] else ""]
        below = "".join(f'<span class="note">{text(note)}</span>' for note in notes if note)
        value = text(bands.number(row["value"]) or "none")
        lines.append([text(row["name"]), verdict(row), value, text(row["unit"]), text(bands.number(row["reference"])),
                      text(bands.number(row["error"])), text(bands.band(row["band"])), text(row["confidence"]) + below])
    passed = sum(row["passed"] for row in rows)
    head = f"<p>{passed} of {len(rows)} within their bands.</p>"
    if run.contents.get("status") != "done":
        head += "<p>The run did not end; what it never reached counts as failed.</p>"
    return head + markup.table(["quantity", "", "value", "unit", "reference", "error", "band", "confidence and source"], lines)


def gauges(runs):
    """All gauges with their reference curves, those of several runs over each other."""
    drawn = "".join(markup.drawing(figure, shown) for shown, figure in curves.each_gauge(runs))
    return f'<div class="pair">{drawn}</div>' if drawn else '<p class="note">There are no gauges.</p>'


def field_pictures(run, times):
    """Fields at the times asked for, or at four."""
    try:
        chosen = fields.choose_times(run, times)
        drawn = [scenes.figure(run, time) for time in chosen]
    except OSError as error:
        return f'<p class="note">The frames cannot be read: {text(error)}</p>'
    if not drawn:
        return '<p class="note">The run wrote no frames.</p>'
    shown = ("Particles", "shear stress") if run.dimension == 2 else ("Scene", "von Mises stress")
    return '<div class="pair">' + "".join(
        markup.drawing(figure, f"{shown[0]} at t = {time:.3f} s: fluid by pressure, structure by {shown[1]}", vector=False)
        for time, figure in drawn) + "</div>"


def films(run, page_folder):
    """Films of the run: small ones inside the page, others as links."""
    parts = []
    for path in sorted(run.directory.glob("film*.mp4")):
        if path.stat().st_size < LARGEST_FILM:
            source = markup.inline("video/mp4", path.read_bytes())
            parts.append(f'<figure><video controls loop muted playsinline preload="metadata" src="{source}" '
                         f'aria-label="Film of the run">{text(path.name)}</video><figcaption>{text(path.name)}</figcaption></figure>')
        else:
            link = quote(os.path.relpath(path.resolve(), page_folder.resolve()))
            parts.append(f'<p><a href="{text(link)}">{text(path.name)}</a>, {path.stat().st_size / 1e6:.0f} MB, beside this page</p>')
    return "".join(parts)


def whole_figure(figure, alt, otherwise):
    return markup.drawing(figure, alt) if figure is not None else f'<p class="note">{otherwise}</p>'


def timing(run):
    """Where the time of each process went: a table with a bar, and the parts of the computing."""
    processes = {role: report for role, report in run.contents.get("processes", {}).items() if report.get("timing_s")}
    if not processes:
        return '<p class="note">No process reported its times.</p>'
    names = [name for name in PARTS if any(name in report["timing_s"] for report in processes.values())]
    names += sorted({name for report in processes.values() for name in report["timing_s"] if "." not in name} - set(names))
    rows, inner = [], []
    for role, report in processes.items():
        times = report["timing_s"]
        wall = report.get("wall_s") or sum(times.get(name, 0) for name in names) or 1.0
        share = {name: 100 * times.get(name, 0) / wall for name in names}
        bar = "".join(f'<span class="part{place % 5}" style="width:{share[name]:.1f}%"></span>' for place, name in enumerate(names))
        rows.append([text(role), f"{report.get('cpu_s') or 0:.1f}", f"{wall:.1f}"]
                    + [f"{times.get(name, 0):.3g} ({share[name]:.0f} %)" for name in names]
                    + [f'<span class="bar" aria-hidden="true">{bar}</span>'])
        inner += [[text(role), text(name.replace(".", ": ", 1).replace("_", " ")), f"{value:.3g}", f"{100 * value / wall:.0f}"]
                  for name, value in sorted(times.items(), key=lambda item: -item[1]) if "." in name]
    keys = [f'<span class="key part{place % 5}" aria-hidden="true"></span>{text(name)} [s]' for place, name in enumerate(names)]
    whole = markup.table(["process", "CPU [s]", "wall [s]", *keys, "share of the wall time"], rows)
    return whole + (markup.table(["process", "part", "[s]", "% of wall"], inner) if inner else "")


def conservation(run):
    """What was kept, by name; everything else the processes counted is folded away below."""
    rows = [[label, form.format(value)] for name, label, form in summary.CONSERVATION
            if (value := summary.measure(run.contents, name)) is not None]
    everything = [[text(role), text(name.replace("_", " ")), number(value)]
                  for role, report in run.contents.get("processes", {}).items() for table in ("measures", "counts")
                  for name, value in report.get(table, {}).items()]
    if not everything:
        return '<p class="note">No process reported measures.</p>'
    head = markup.table(["quantity", "value"], [[text(label), text(value)] for label, value in rows]) if rows else ""
    return head + ("<details><summary>Everything the processes measured and counted</summary>"
                   + markup.table(["process", "measure", "value"], everything, sortable=True) + "</details>")


def setting_table(run):
    """The settings the run took; those that are not the default are marked."""
    lines = settings.rows(run.contents.get("settings", {}))
    if not lines:
        return '<p class="note">There is no run.json to tell the settings.</p>'
    rows = [[text(path), text(settings.shown(value)), text(unit), text(settings.shown(default)), "differs" if differs else ""]
            for path, value, unit, default, differs in lines]
    marked = {place for place, line in enumerate(lines) if line[4]}
    return (f"<p>{len(marked)} differ from their default.</p>"
            + markup.table(["setting", "value", "unit", "default", ""], rows, marked=marked))


def parts(run, times, page_folder):
    """[(title, HTML)] of everything there is to show of a run."""
    found = [("Overview", overview(run)), ("Quantities", quantities(run)), ("Gauges", gauges([run])),
             ("Fields", field_pictures(run, times))]
    film = films(run, page_folder)
    if film:
        found.append(("Film", film))
    return found + [
        ("Energies", whole_figure(curves.energies(run), "Curves over time of the energies of fluid and structure and of the work at the "
                                  "interface", "The run wrote no energies.")),
        ("Steps",
         whole_figure(curves.steps(run), "Step length, pressure iterations and wall time of every step", "The run wrote no steps.")),
        ("Time", timing(run)), ("Conservation", conservation(run)), ("Settings", setting_table(run))]
