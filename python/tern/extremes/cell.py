"""One cell of the map: a small case, what is asked of it, and what its figures are measured in."""

import hashlib
from dataclasses import dataclass

GRAVITY, WATER = 9.81, 1000.0


@dataclass(frozen=True)
class Cell:
    """A case (the text of its file), how it is run, and the scales of its figures."""

    family: str
    name: str
    case: str                      # text of a case.toml
    speed: float                   # sqrt(g H), or what takes its place [m/s]
    energy: float                  # rho g H^2 L / 2, or what takes its place [J/m; in 3D J]
    options: tuple = ()            # KEY=VALUE of --set
    mass: float = 0.0              # of the elastic bodies [kg/m; in 3D kg]
    load: float = 0.0              # rho g H times the plate's length [N/m], in 3D its area [N]; 0: no plate, its unrest is not looked at
    until: float = 0.1             # of this the figures are made [s]; the run goes on a little
    allow_unstable: bool = False
    limits: tuple = (2.0, 0.05, 0.05)  # of speed, energy gained and volume lost, in the scales; see verdict.py
    row: str = ""                  # place in the picture of the family
    column: str = ""
    theory: str = ""

    def fingerprint(self, executables):
        """Changes with anything that changes the run or its verdict; `executables`: of build.digest()."""
        parts = (executables, self.case, self.options, self.until, self.allow_unstable, self.limits, self.speed, self.energy, self.load,
                 self.mass)
        return hashlib.sha256(repr(parts).encode()).hexdigest()[:12]
