"""The rigid box on a spring of tern.participant, which fails in windows longer than --longest [s], and from half the run on in windows
longer than a quarter of that."""

import importlib.util
from pathlib import Path

import tern.participant
from tern.participant import NumericalFailure, run_structure

tern.participant.run_structure = lambda *_: None  # of the script that is read here
SCRIPT = Path(tern.participant.__file__).parent / "solvers" / "rigid_spring.py"
specification = importlib.util.spec_from_file_location("rigid_spring", SCRIPT)
rigid_spring = importlib.util.module_from_spec(specification)
specification.loader.exec_module(rigid_spring)


class ChoosySpring(rigid_spring.RigidSpring):
    def __init__(self, case, options):
        super().__init__(case, options)
        self.longest, self.half = options.longest, case.end_time / 2

    def advance(self, time_s, duration_s, force):
        longest = self.longest / (1 if time_s < self.half else 4)
        if duration_s > longest:
            raise NumericalFailure(f"A window of {duration_s:g} s is too long for this solver, which takes {longest:g} s.")
        super().advance(time_s, duration_s, force)


def options(parser):
    parser.add_argument("--stiffness", type=float, required=True)
    parser.add_argument("--longest", type=float, required=True)


run_structure(ChoosySpring, options)
