"""Exit codes of tern, the same for the launcher and the three processes, and the exception that carries one."""

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


class LauncherError(Exception):
    """An error for the user: one full sentence (what, where, remedy) and the exit code of the launcher."""

    def __init__(self, exit_code, sentence):
        super().__init__(sentence)
        self.exit_code = exit_code
