"""study.md and the sentences of ./tern study, from the rows."""

from tern.studies import front
from tern.studies.parameters import PARAMETERS

PRESETS = ("draft", "standard", "reference")


def percent(share):
    """Three significant digits of a share of 1, in per cent; a dash for none."""
    return "-" if share is None else f"{100 * share:.3g} %"


def points(share):
    """A difference of two errors, in percentage points; what rounds to nothing is nothing."""
    text = f"{100 * share:+.2f} %"
    return "0" if text.strip("+-0. %") == "" else text


def span(values, form, between=" .. "):
    """The least and the largest with `between` between them, or one value where they read the same; a dash for none."""
    values = [value for value in values if value is not None]
    if not values:
        return "-"
    low, high = form(min(values)), form(max(values))
    return low if low == high else f"{low}{between}{high}"


def seconds(value):
    return "-" if value is None else f"{value:.3g} s"


def table(head, lines):
    """A Markdown table."""
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in [head, ["---"] * len(head), *lines])


def options_of(row):
    return f"`{row.options}`" if row.options else "the case as it stands"


def _ratio(row, cost):
    return "-" if not (row.cpu_s and cost) else f"{row.cpu_s / cost:.3g}"


def row_cells(row, cost):
    """Name, what to type, errors and costs of one finished point."""
    return [row.point if not row.parameter else f"{row.parameter} {row.value}".strip() if row.parameter != "preset" else row.point,
            percent(row.error), percent(row.distance_to_finest), seconds(row.cpu_s), _ratio(row, cost), seconds(row.wall_s),
            row.steps, "-" if row.pressure_iterations is None else f"{row.pressure_iterations:.0f}"]


HEAD = ["point", "error", "from the finest", "CPU", "over standard", "wall", "steps", "pressure iterations"]


def front_table(rows):
    """The points no other beats."""
    cost, _ = front.standard_cost(rows)
    return table(HEAD, [row_cells(row, cost) for row in front.pareto(rows)])


def preset_table(rows):
    cost, _ = front.standard_cost(rows)
    return table(HEAD, [row_cells(row, cost) for row in (front.find(rows, name) for name in PRESETS) if row])


def parameter_table(rows):
    """What every value of every parameter saves, and what it does to the error and to the curves."""
    cost, scatter = front.standard_cost(rows)
    standard = front.find(rows, "standard")
    lines = []
    for row in rows:
        if not row.parameter or row.parameter == "preset" or not row.done or not cost:
            continue
        speed_up = cost / row.cpu_s
        same = max(speed_up, 1 / speed_up) < 1 + max(scatter, 0.03)
        added = None if row.error is None or not standard or standard.error is None else row.error - standard.error
        lines.append([row.parameter, _value_text(row), f"{speed_up:.2f}" + (" (as much)" if same else ""),
                      "-" if added is None else points(added), percent(row.distance_to_standard), percent(row.distance_to_finest),
                      *(_over(getattr(row, name), getattr(standard, name)) for name in ("steps", "pressure_iterations"))])
    order = {parameter.key: number for number, parameter in enumerate(PARAMETERS)}
    lines.sort(key=lambda line: order.get(line[0], 99))
    return table(["parameter", "value", "speed-up", "error added", "moves the curves by", "from the finest", "steps",
                  "pressure iterations"], lines)


def _over(value, other):
    """Ratio to the standard."""
    return f"{value / other:.2f} x" if value and other else "-"


def _value_text(row):
    parameter = next((parameter for parameter in PARAMETERS if parameter.key == row.parameter), None)
    extra = f" (with {', '.join(parameter.with_)})" if parameter and parameter.with_ else ""
    return row.value + (f" {parameter.unit}" if parameter and parameter.unit else "") + extra


def failures(rows):
    """One line per point that did not end; nothing if all did."""
    lines = [[f"{row.parameter} {row.value}", row.status, row.cause.replace("|", "/")] for row in rows if not row.done]
    return table(["point", "status", "first cause"], lines) if lines else ""


def order_lines(rows):
    """Observed orders of the parameters that refine, one line each."""
    lines = []
    for one in front.orders(rows, [parameter.key for parameter in PARAMETERS if parameter.refines]):
        if all(row.distance_to_standard == 0 for _, row in one.entries):
            lines.append(f"* `{one.parameter}`: changes nothing here, something else binds.")
            continue
        steps = " -> ".join(f"{value:.3g}: {percent(row.error if row.error is not None else row.distance_to_finest)}"
                            for value, row in one.entries)
        text = f"* `{one.parameter}`: error {steps}"
        if any(found is not None for found in one.against_reference):
            text += "; order " + ", ".join("-" if found is None else f"{found:.2g}" for found in one.against_reference)
        if one.plateau is not None:
            text += f"; no better below {one.plateau:.3g} (plateau)"
        text += "; the curves converge to each other with order " + (f"{one.of_itself:.2g}." if one.of_itself else "none that fits.")
        lines.append(text)
    return "\n".join(lines) or "None: no parameter that refines has three finished values."


def finest_sentence(rows):
    """Which run is the finest and how far it can be trusted."""
    best, coarser = front.finest(rows), front.next_finest(rows)
    if not best:
        return "No run has finished."
    if not coarser:
        return f"Finest run: {best.point}; there is no coarser one to tell its own uncertainty."
    return (f"Finest run: {best.point}; the next finest, {coarser.point}, is {percent(coarser.distance_to_finest)} from it, which is "
            "taken as its own uncertainty.")


def quantity_lines(rows):
    """The quantities of the error with their share at the standard and at the finest spacing."""
    standard, best = front.find(rows, "standard"), front.finest(rows)
    if not standard or not standard.quantities:
        return "The case has no reference: the error is the distance to the finest run, over all gauges."
    lines = [[name, percent(value), percent(best.quantities.get(name)) if best else "-"] for name, value in standard.quantities.items()]
    note = "" if front.by_reference(rows) else (
        "The reference is another code or an experiment: shown, but not what runs are judged by; that is the distance from the "
        "finest run.\n\n")
    return note + table(["error of (over its scale)", "standard", f"finest ({best.point})" if best else "finest"], lines)


def wish_line(case, row, base_options=""):
    """The command to copy."""
    return " ".join(part for part in ("./tern run", case, base_options, row.options) if part)


def answer(case, rows, error=None, time_s=None, base_options=""):
    """The settings for a wanted error or wall time, in words."""
    lines = []
    kind = "error against the reference" if front.by_reference(rows) else "distance to the finest run"
    for wanted, pick, what in ((error, front.best_for_error, lambda: f"an {kind} of at most {percent(error)}" if front.by_reference(rows)
                                else f"a {kind} of at most {percent(error)}"),
                               (time_s, front.best_for_time, lambda: f"at most {seconds(time_s)} of wall time")):
        if wanted is None:
            continue
        row, met = pick(rows, wanted)
        if row is None:
            lines.append(f"No point of the study has a known {kind}; nothing can be said about {what()}.")
            continue
        lines.append(f"For {what()}, measured to t = {row.end_time_s:g} s:" if met else
                     f"No point of the study reaches {what()}; the nearest is:")
        lines.append(f"  {wish_line(case, row, base_options)}")
        lines.append(f"  {kind} {percent(front.error_of(row))}, {percent(row.distance_to_finest)} from the finest run, CPU "
                     f"{seconds(row.cpu_s)}, wall {seconds(row.wall_s)}")
        best = front.finest(rows)
        if (row.judged_by == "finest" and best and row.distance_to_finest and best.distance_to_finest
                and row.distance_to_finest < best.distance_to_finest):
            lines.append(f"  (the finest run itself is uncertain by {percent(best.distance_to_finest)}: smaller distances say little)")
    return "\n".join(lines)


def text(case, rows, left_out, quantities_left_out):
    """study.md."""
    cost, scatter = front.standard_cost(rows)
    version = next((row.version for row in rows), "")
    versions = sorted({row.version for row in rows})
    end = next((row.end_time_s for row in rows), 0.0)
    parts = [f"# What accuracy costs: {case}", "",
             f"`./tern study {case}`, {', '.join(versions) or version}, to t = {end:g} s, one run at a time. The case as it stands takes "
             f"{seconds(cost)} of CPU; its runs at begin and end differ by {percent(scatter)}." if cost else
             f"`./tern study {case}`: the case as it stands has not finished.", "",
             quantity_lines(rows), "", finest_sentence(rows), ""]
    if quantities_left_out:
        parts += [f"Not counted, because they need a later end: {', '.join(quantities_left_out)}.", ""]
    parts += ["![error against cost](trade.png)", "", "## The front", "", front_table(rows), "", "## Presets", "", preset_table(rows), "",
              "## Observed orders", "", order_lines(rows), "", "## Parameters", "", parameter_table(rows), ""]
    if failures(rows):
        parts += ["## Did not end", "", failures(rows), ""]
    if left_out:
        parts += ["## Left out for the budget", "", ", ".join(point.point.name for point in left_out), ""]
    return "\n".join(parts)
