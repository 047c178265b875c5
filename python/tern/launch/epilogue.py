"""What the guardian of a killed launcher does last: run.json says how the run ended, with the reports of its processes in it.

    python3 -m tern.launch.epilogue RUN
"""

import sys
from pathlib import Path

from tern.errors import PEER_LOST, STATUS, UnreadableRun
from tern.launch import process_state, spent
from tern.launch.record import write_json
from tern.results import report as run_report

SENTENCE = "The launcher was killed; its guardian ended the run."


def close(out):
    """Completes run.json of a run that says it is still running; does nothing to any other."""
    try:
        run = run_report.read(out)
    except UnreadableRun:
        return
    launcher = run.get("launcher")
    # A zombie (Z) has ended, and nobody has asked about it yet.
    if run.get("status") != "running" or launcher is None or process_state.of(launcher) not in (None, "Z", "X"):
        return
    reports = spent.reports_in(out)
    taken = spent.by_reports(run.pop("spent", {}), reports)
    for role, report in reports.items():
        report |= taken[role]
        if report.get("status") == "running":
            report["status"] = "killed"
    write_json(out / "run.json", run | {
        "status": STATUS[PEER_LOST], "exit_code": PEER_LOST, "first_cause": SENTENCE, "first_cause_role": "launcher",
        "exit_codes": {role: None if report.get("status") == "killed" else report.get("exit_code") for role, report in reports.items()},
        "wall_s": taken[spent.RUN]["wall_s"], "cpu_s": sum(report["cpu_s"] for report in reports.values()),
        "steps": max((report.get("steps") or 0 for report in reports.values()), default=0),
        "version": next((report.get("version", "") for report in reports.values()), ""),
        "git": next((report.get("git", "") for report in reports.values()), ""), "processes": reports})
    for left in [*out.glob("report.*.json"), *out.glob("*.tmp"), *out.glob("checkpoint/*.tmp")]:
        left.unlink(missing_ok=True)


if __name__ == "__main__":
    close(Path(sys.argv[1]))
