"""Windows that have failed are taken back to a state from ten to twenty windows before, and repeated at half their length."""

from dataclasses import dataclass

from tern.errors import NUMERICAL_FAILURE, UnreadableRun
from tern.results import tables

MOST_HALVINGS = 4  # a failure that windows of a sixteenth do not mend has another cause
FIRST_WINDOWS = 20  # a failure among these begins the run anew: nothing from well before it has been kept


@dataclass
class Repeat:
    """How a run goes on after a numerical failure: from the newest checkpoint or anew, with shorter windows up to a time."""

    anew: bool
    halvings: int
    until: float      # [s]
    longest: float    # window [s]
    taken_back: list  # all that was repeated so far, for run.json
    case_hash: str    # of the case whose windows they are

    @property
    def note(self):
        return (f"Windows are taken back to t = {self.taken_back[-1]['time_s']:.6g} s and repeated, 1/{2**self.halvings} as long "
                f"({self.longest:.3g} s). The run goes on so by itself: no setting has to be changed for it.")


def _longest_window(out, since, last):
    """The longest of those that ended after the time `since` (from steps.csv) and the `last` one, which has failed [s]."""
    try:
        steps = tables.read_columns(out / "steps.csv")
    except (FileNotFoundError, UnreadableRun):
        return last
    return max([length for t, length in zip(steps.get("t_s", []), steps.get("dt_s", [])) if t > since] + [last])


def may_help(contents, cause):
    """Whether the same windows may go well when they are shorter: the process that failed has said so."""
    return cause.exit_code == NUMERICAL_FAILURE and bool(contents["processes"].get(cause.role, {}).get("shorter_windows_may_help"))


def plan(out, contents, cause, checkpoints):
    """The Repeat after the end of the run in `out`, from its run.json, its cause and its checkpoints, newest first; None where there is
    none."""
    if not may_help(contents, cause) or contents["launch"]["only"] or contents["launch"]["allow_unstable"]:
        return None
    coupling = contents["settings"].get("coupling", {})
    if "coupler" in contents["processes"] and (coupling["algorithm"] == "explicit" or coupling["max_iterations"] == 1):
        return None  # one pass that was asked for is to be seen as it is
    timekeeper = contents["processes"].get("coupler") or contents["processes"].get("fluid")
    if not timekeeper:
        return None  # a structure alone: its sub-steps are not the windows' business
    failed_at = max(report.get("time_s") or 0.0 for report in contents["processes"].values())
    before = contents.get("taken_back", [])
    halvings = timekeeper.get("counts", {}).get("window_halvings", 0) + 1
    if before and failed_at <= before[-1]["failed_at_s"]:
        halvings = max(halvings, before[-1]["halvings"] + 1)
    anew = contents["steps"] < FIRST_WINDOWS and not any(repeat["step"] for repeat in before)
    if halvings > MOST_HALVINGS or not (anew or checkpoints):
        return None
    at = {"step": 0, "time_s": 0.0} if anew else checkpoints[0]
    longest = _longest_window(out, at["time_s"], timekeeper.get("measures", {}).get("window_s", 0.0)) / 2
    if halvings > 1 and before:  # those that failed were short already
        longest = min(longest, before[-1]["window_s"] * 2.0 ** (before[-1]["halvings"] - halvings))
    if longest == 0:
        return None  # it has failed before the first window
    # What fails again later is left in peace for twice as long each time.
    last = before[-1]["failed_at_s"] if before else failed_at
    until = max(failed_at, last) + max(failed_at - last, 0.0)
    entry = {**at, "failed_at_s": failed_at, "until_s": until, "halvings": halvings, "window_s": longest, "cause": cause.sentence}
    return Repeat(anew, halvings, until, longest, [*before, entry], contents["case_hash"])


def again(contents, checkpoints):
    """The last Repeat once more, when the run has lost a process before it had a checkpoint of the repeated windows; else None."""
    last = contents["taken_back"][-1] if contents.get("taken_back") else None
    if not last or not checkpoints or checkpoints[0]["step"] != last["step"]:
        return None
    return Repeat(False, last["halvings"], last["until_s"], last["window_s"], contents["taken_back"], contents["case_hash"])


def history(taken_back):
    """What is added to the cause of a failure that shorter windows have not mended."""
    times = "once" if len(taken_back) == 1 else f"{len(taken_back)} times"
    return f" Windows were taken back {times} and repeated, the last ones with at most {taken_back[-1]['window_s']:.3g} s."
