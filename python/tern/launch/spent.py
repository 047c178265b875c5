"""What a run has taken: wall and CPU time of all its parts, those of windows that were computed in vain as well."""

from tern.launch import reports

RUN = "run"  # the launcher's own wall time, beside those of the processes


def together(earlier, part):
    """{role: {"wall_s", "cpu_s"}} of what was spent before and of one part more."""
    return {role: {key: (earlier.get(role, {}).get(key) or 0.0) + (part.get(role, {}).get(key) or 0.0) for key in ("wall_s", "cpu_s")}
            for role in earlier.keys() | part.keys()}


def by_reports(earlier, reports):
    """The same of a part whose launcher has not lived to its end."""
    wall_s = max((report.get("wall_s") or 0.0 for report in reports.values()), default=0.0)
    return together(earlier, reports | {RUN: {"wall_s": wall_s}})


def reports_in(out):
    """report.ROLE.json of a run that has not ended well, by role."""
    found = {path.name.split(".")[1]: reports.read(path) for path in sorted(out.glob("report.*.json"))}
    return {role: report for role, report in found.items() if report}


def until_now(run, out):
    """What all parts have taken that are in the run.json `run`."""
    if run.get("status") == "running":
        return by_reports(run.get("spent", {}), reports_in(out))
    return together(run.get("processes", {}), {RUN: {"wall_s": run.get("wall_s")}})
