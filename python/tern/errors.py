"""Exit codes of tern, the same for ./tern and the three processes, and the exceptions that carry one."""

import errno
import os

DONE = 0
BAD_INPUT = 2
NUMERICAL_FAILURE = 3
PEER_LOST = 4
INPUT_OUTPUT = 5
INTERRUPTED = 130

STATUS = {
    DONE: "done",
    BAD_INPUT: "bad input",
    NUMERICAL_FAILURE: "numerical failure",
    PEER_LOST: "peer lost",
    INPUT_OUTPUT: "input/output failure",
    INTERRUPTED: "interrupted",
}

TOLD_TO_FINISH = "The run was interrupted; results up to here are kept."  # a participant whom the coupler has told so (participant.hpp)

# What helps against an error of the system, whatever was to be done when it came.
_REMEDIES = {
    errno.EMFILE: "raise the limit of open files of a process (ulimit -n), and start again",
    errno.ENFILE: "all programs of this machine have too many files open; end some, and start again",
}


def in_words(error, remedy=None):
    """An OSError in words, and what to do about it: `remedy`, unless the system's error has a remedy of its own."""
    said = os.strerror(error.errno) if error.errno else str(error)
    remedy = _REMEDIES.get(error.errno, remedy)
    return f"{said}; {remedy}" if remedy else said


def refusal(error):
    """The same after the name of the file or program that it is about, where it has one."""
    return f"{error.filename}: {in_words(error)}" if error.filename else in_words(error)


class Error(Exception):
    """An error for the user: one full sentence (what, where, remedy) and the exit code of the command line."""

    def __init__(self, exit_code, sentence):
        super().__init__(sentence)
        self.exit_code = exit_code


class RunFailed(Error):
    """A run that ended early. `first_cause`: one sentence; `role`: the process it happened to; `directory`: the results up to there."""

    def __init__(self, exit_code, first_cause, role, directory):
        super().__init__(exit_code, f"{first_cause} (exit code {exit_code}; what was computed is in {directory})")
        self.first_cause, self.role, self.directory = first_cause, role, directory


class UnreadableRun(Error):
    """The directory does not hold what was asked of it; one sentence."""

    def __init__(self, sentence):
        super().__init__(BAD_INPUT, sentence)


class ReductionError(Exception):
    """A quantity could not be computed; the sentence says why. It counts as failed, not as passed."""
