"""Windows that have failed are taken back to a state from ten to twenty windows before, and repeated at half their length."""

from dataclasses import dataclass

from tern.errors import NUMERICAL_FAILURE

MOST_HALVINGS = 4  # a failure that windows of a sixteenth do not mend has another cause
FIRST_WINDOWS = 20  # a failure among these begins the run anew: nothing from well before it has been kept


@dataclass
class Repeat:
    """How a run goes on after a numerical failure: from the newest checkpoint or anew, with windows 2^-halvings as long up to a time."""

    anew: bool
    halvings: int
    until: float      # when longer windows have failed [s]
    taken_back: list  # all that was repeated so far, for run.json

    @property
    def note(self):
        return f"Windows are taken back to t = {self.taken_back[-1]['time_s']:.6g} s and repeated, 1/{2**self.halvings} as long."


def plan(contents, cause, checkpoints):
    """The Repeat after the end of a run, from its run.json, its cause and its checkpoints, newest first; None where there is none."""
    if cause.exit_code != NUMERICAL_FAILURE or not contents["processes"].get(cause.role, {}).get("shorter_windows_may_help"):
        return None
    if contents["launch"]["only"] or contents["launch"]["allow_unstable"]:
        return None
    if "coupler" in contents["processes"] and contents["settings"]["coupling"]["algorithm"] in ("explicit", "semi-implicit"):
        return None  # one pass that was asked for by name is to be seen as it is
    timekeeper = contents["processes"].get("coupler") or contents["processes"].get("fluid") or {}
    halvings = timekeeper.get("counts", {}).get("window_halvings", 0) + 1
    anew = "resumed" not in contents and contents["steps"] < FIRST_WINDOWS
    if halvings > MOST_HALVINGS or not (anew or checkpoints):
        return None
    at = {"step": 0, "time_s": 0.0} if anew else checkpoints[0]
    failed_at = max(report.get("time_s") or 0.0 for report in contents["processes"].values())
    entry = {**at, "failed_at_s": failed_at, "halvings": halvings, "cause": cause.sentence}
    return Repeat(anew, halvings, failed_at, [*contents.get("taken_back", []), entry])


def history(taken_back):
    """What is added to the cause of a failure that shorter windows have not mended."""
    shortest = max(entry["halvings"] for entry in taken_back)
    times = "once" if len(taken_back) == 1 else f"{len(taken_back)} times"
    return f" Windows were taken back {times} and repeated, at the shortest 1/{2**shortest} as long."
