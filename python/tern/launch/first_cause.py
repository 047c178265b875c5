"""Why a run ended: the first cause among the ends of its processes and the reports they left."""

import re
import signal
from dataclasses import dataclass

from tern.errors import DONE, INPUT_OUTPUT, INTERRUPTED, PEER_LOST, STATUS, TOLD_TO_FINISH

SAME_MOMENT_S = 1.0
ASKS_TO_END = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # what interrupts the launcher


@dataclass
class Cause:
    """What went wrong first: exit code of the launcher, one sentence, the role it happened to."""

    exit_code: int = DONE
    sentence: str = ""
    role: str = ""


def _candidate(process, report):
    """(unix seconds, Cause) of one failed process: its own report, if it is about a failure, else its exit status."""
    code = process.exit_code
    if process.ranks and process.ranks.killed:
        rank, number, machine = process.ranks.killed
        name = signal.Signals(number).name if number in signal.valid_signals() else "unknown"
        on = f" on {machine}" if machine else ""
        return process.ended_at, Cause(PEER_LOST, f"Rank {rank} of {process.program}{on} was killed by signal {number} ({name}).",
                                       process.role)
    if code < 0:
        name = signal.Signals(-code).name if -code in signal.valid_signals() else "unknown"
        return process.ended_at, Cause(PEER_LOST, f"{process.program} was killed by signal {-code} ({name}).",
                                       process.role)
    when = report.get("cause_time") or process.ended_at
    sentence = report.get("cause") or (process.ranks and process.ranks.alone) or (
        f"{process.program} ended with exit code {code} and left no report of the cause"
        + ("; its message is above: is the disk full?" if code == INPUT_OUTPUT else "."))
    if process.never_joined and not report.get("cause"):
        sentence = (f"{process.program}, the {process.role} of this run, ended with exit code {code} before it had joined the coupler; "
                    "what it printed is above.")
    return min(when, process.ended_at), Cause(code if code in STATUS and code != DONE else PEER_LOST, sentence, process.role)


def _lost(role):
    """What the others say of a process that they have lost (session.cpp); "a message was lost" is another thing."""
    return re.compile(rf"The {role} process( \([^)]*\))? was lost")


def _is_echo(process, told, reports):
    """Whether a process without a word of its own has only done what an Abort asks for, and ended with the exit code of another one's
    cause: that one is known at that time, or is being written down. Who was lost by the others has not heard an Abort."""
    return process.exit_code > 0 and not reports.get(process.role, {}).get("cause") and any(
        process.exit_code == reports[other.role].get("exit_code", cause.exit_code) and when < process.ended_at + SAME_MOMENT_S
        and not _lost(process.role).search(cause.sentence) for other, (when, cause) in told)


def without_missing_logs(sentence, processes, out):
    """The sentence about a lost process (session.cpp) points to its log, which a foreign program need not write into `out`."""
    for process in processes:
        log = f"{process.role}.log"
        if process.foreign and not (out / log).exists():
            sentence = sentence.replace(f"Its own messages and {log} in the output directory may", "Its own messages may")
    return sentence


def by_user():
    """The cause of a run that the user has ended."""
    return Cause(INTERRUPTED, "The run was interrupted by the user; the results up to there are readable.")


def find(processes, reports, interrupted):
    """The first cause of a run that has ended; an empty one (exit code 0) when every process is done.

    Order: time. Four kinds of echo are passed over: a lost peer (code 4) when another process was killed or failed by
    itself, the end of a participant that the coupler has told to finish when the coupler has something to say, the end of
    a program without a report that got an Abort (_is_echo), and a
    sentence that only repeats another one with the name of who said it. What the launcher ended itself is
    no cause, unless nothing else is (`interrupted`: the user ended the run). Neither is the end of a process that a
    signal to all has reached before it could answer. A program that ends with 0 before the run does leaves no cause of its own.
    """
    for process in processes:
        if process.frozen:
            whose = f"Rank {process.stopped_ranks[0]} of " if process.stopped_ranks else ""
            return Cause(PEER_LOST, f"{whose}{process.program} was stopped (SIGSTOP) and did not go on; the launcher ended the run.",
                         process.role)
    failed = [(process, _candidate(process, reports.get(process.role, {})))
              for process in processes
              if (process.exit_code != DONE or process.never_joined) and not process.ended_by_launcher
              and not (interrupted and -process.exit_code in ASKS_TO_END)]
    # Who could not write a report (the disk is full) has told the others.
    told = [entry for entry in failed if reports.get(entry[0].role, {}).get("cause")]
    failed = [entry for entry in failed if entry in told
              or not (any(f"The {entry[0].role} process stopped" in cause.sentence for _, (_, cause) in told)
                      or _is_echo(entry[0], told, reports))]
    failed = [entry for entry in failed if entry[1][1].sentence != TOLD_TO_FINISH] or failed
    if not failed:
        if interrupted and any(process.exit_code != DONE for process in processes):
            return by_user()
        for process in processes:
            if process.exit_code != DONE:
                return Cause(PEER_LOST, f"{process.program} did not end after the others had ended, and was ended by "
                                        f"the launcher.", process.role)
        return Cause()
    for process in processes:
        lost = _lost(process.role)
        is_missed = any(lost.search(cause.sentence) for _, (_, cause) in failed)
        if is_missed and process.exit_code == DONE and reports.get(process.role, {}).get("status") != "done":
            return Cause(PEER_LOST, f"{process.program} ended with exit code 0 in the middle of the run, and without a word.", process.role)
    origins = [entry for entry in failed if entry[0].exit_code != PEER_LOST]
    first_time, first = min((candidate for _, candidate in origins or failed), key=lambda candidate: candidate[0])
    for _, (when, cause) in failed:
        if (cause.role != first.role and when - first_time < SAME_MOMENT_S and len(cause.sentence) < len(first.sentence)
                and cause.sentence.rstrip(".") in first.sentence):
            first = cause
    if first.exit_code == INTERRUPTED and not interrupted:
        # A signal from elsewhere: who has got it says so, the others only that the run was interrupted, or that the launcher's has come.
        for process in sorted(processes, key=lambda process: process.ended_by_launcher):
            sentence = reports.get(process.role, {}).get("cause") or ""
            if sentence.startswith("Interrupted by"):
                return Cause(INTERRUPTED, f"{process.program} was told to end. {sentence}", process.role)
    return first
