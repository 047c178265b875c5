"""The part of a page that holds several runs beside each other."""

from tern.results import summary
from tern.verify import bands
from tern.report import markup, run as one_run, settings
from tern.report.markup import number, text


def setting_table(runs):
    """The settings in which the runs differ."""
    flat = [settings.flatten(run.contents.get("settings", {})) for run in runs]
    paths = list(dict.fromkeys(path for values in flat for path in values))
    rows = []
    for path in paths:
        values = [values.get(path, (None, None))[1] for values in flat]
        if any(value != values[0] for value in values):
            rows.append([text(path), *(text(settings.shown(value)) or "absent" for value in values)])
    if not rows:
        return "<p>The runs have the same settings.</p>"
    return markup.table(["setting", *(text(run.label()) for run in runs)], rows)


def costs(runs):
    """Status, times and iterations of each run."""
    def line(name, value):
        return [name, *(value(run) for run in runs)]

    def measured(name, form):
        return lambda run: "" if (value := summary.measure(run.contents, name)) is None else form.format(value)

    def cpu(role):
        def value(run):
            seconds = run.contents.get("processes", {}).get(role, {}).get("cpu_s")
            return "" if seconds is None else f"{seconds:.1f}"
        return value

    rows = [line("status", lambda run: text(run.contents.get("status", "unknown"))),
            line("first cause", lambda run: text(run.contents.get("first_cause"))),
            line("reached t [s]", lambda run: number(one_run.reached_time(run))),
            line("wall time [s]", lambda run: f"{run.contents['wall_s']:.1f}" if "wall_s" in run.contents else ""),
            line("CPU time [s]", lambda run: f"{run.contents['cpu_s']:.1f}" if "cpu_s" in run.contents else ""),
            *(line(f"CPU time of the {role} [s]", cpu(role)) for role in ("fluid", "structure", "coupler")),
            line("steps", lambda run: number(run.contents.get("steps"))),
            line("pressure iterations, mean", measured("pressure_iterations_mean", "{:.1f}")),
            line("sub-steps of the structure, mean", measured("sub_steps_mean", "{:.1f}")),
            line("coupling iterations per window, mean", measured("coupling_iterations_mean", "{:.2f}")),
            *(line(text(label), measured(name, form)) for name, label, form in summary.CONSERVATION),
            line("tern", lambda run: text(" ".join(filter(None, (run.contents.get("version"), run.contents.get("git"))))))]
    return markup.table(["", *(text(run.label()) for run in runs)], [row for row in rows if any(row[1:])])


def quantities(runs):
    """Value and verdict of every quantity of every run; what two cases hold to different bands takes two rows."""
    judged = [{(row["name"], row["reference"], *row["band"]): row for row in one_run.judged(run)[0] or []} for run in runs]
    kinds = {kind: row for rows in judged for kind, row in rows.items()}
    if not kinds:
        return '<p class="note">None of the cases has an expected.toml.</p>'
    lines = []
    for kind, any_row in sorted(kinds.items(), key=lambda item: [name for name, *_ in kinds].index(item[0][0])):
        values = [rows.get(kind) for rows in judged]
        lines.append([text(any_row["name"]), text(any_row["unit"]), text(bands.number(any_row["reference"])),
                      text(bands.band(any_row["band"])),
                      *("" if row is None else f"{text(bands.number(row['value']) or 'none')} {one_run.verdict(row)}" for row in values)])
    return markup.table(["quantity", "unit", "reference", "band", *(text(run.label()) for run in runs)], lines)


def parts(runs):
    """[(title, HTML)] of the comparison."""
    return [("Gauges of all", one_run.gauges(runs)), ("Quantities of all", quantities(runs)), ("Costs and conservation", costs(runs)),
            ("Settings that differ", setting_table(runs))]
