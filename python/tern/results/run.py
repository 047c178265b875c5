"""The results of one run: tables, frames, run.json. Whoever shows, judges or compares a run reads it here."""

import functools
from pathlib import Path

from tern.errors import UnreadableRun
from tern.results import frames, report, summary
from tern.results.tables import Table


def distinguish(runs):
    """Gives runs whose directories are called alike their whole path as a label."""
    names = [run.directory.resolve().name for run in runs]
    for run, name in zip(runs, names):
        if names.count(name) > 1:
            run.legend = str(run.directory)


class Run:
    """One results directory. Whatever is missing reads as empty: a fluid alone, a structure alone, a run cut short.

        run = tern.Run("runs/dam_break_plate")
        run.gauges["P.ux_m"]               array [m], a value per row; NaN where the gauge had none
        run.gauges.unit("P.ux_m")          "m"
        run.frames[-1].fluid["pressure"]   array [Pa], a value per particle

    Tables and frames are read when they are first asked for and kept; of a run that is still going on, make a new Run to see more.
    Raises UnreadableRun (an Error) for a directory without results.
    """

    def __init__(self, directory):
        self.directory = Path(directory)
        if not self.directory.is_dir():
            raise UnreadableRun(f"There is no directory {directory}; give the directory a run has written, e.g. "
                                f"runs/dam_break_plate.")
        #: run.json as it is; empty where there is none.
        self.contents = report.read(self.directory) if (self.directory / "run.json").exists() else {}
        self.name = self.contents.get("case", self.directory.name)
        self.legend = self.directory.resolve().name
        self.title = self.contents.get("title") or self.name
        if not any((self.directory / name).exists() for name in ("gauges.csv", "fluid.h5", "structure.h5", "steps.csv")):
            raise UnreadableRun(f"{directory} holds no results (gauges.csv, steps.csv, fluid.h5, structure.h5): it is not "
                                f"the directory of a run.")

    def __repr__(self):
        return f"<tern.Run {self.directory}: {self.name}, {self.status}>"

    # What came of it.

    @property
    def status(self):
        """"done", "running", or what ended it: "bad input", "numerical failure", "peer lost", "interrupted" ...; "unknown" without
        run.json."""
        return self.contents.get("status", "unknown")

    @property
    def first_cause(self):
        """Why the run ended early, one sentence; empty for a run that is done."""
        return self.contents.get("first_cause", "")

    @property
    def settings(self):
        """The effective settings, nested as in the case file, with every default filled in (docs/PARAMETERS.md)."""
        return self.contents.get("settings", {})

    @property
    def dimension(self):
        """2 or 3."""
        return self.settings.get("dimension", 2)

    def measure(self, name):
        """A measure or count that a process reports, e.g. "pressure_iterations_mean"; None if nobody does."""
        return summary.measure(self.contents, name)

    @property
    def conservation(self):
        """What should be kept, {measure: value}: volume drift [1], momentum audit [1], added-mass ratio [1], particles lost."""
        return {name: value for name, _, _ in summary.CONSERVATION if (value := self.measure(name)) is not None}

    @property
    def timings(self):
        """{process: {activity: wall time [s]}}: compute, wait, exchange, output, and parts such as compute.pressure_solve."""
        return {role: report.get("timing_s", {}) for role, report in self.contents.get("processes", {}).items()}

    @property
    def wall_s(self):
        """Wall time of the whole run [s]; None while it goes on."""
        return self.contents.get("wall_s")

    @property
    def cpu_s(self):
        """CPU time of all processes [s]; None while the run goes on."""
        return self.contents.get("cpu_s")

    def summary(self):
        """What ./tern run prints at the end, as text."""
        return summary.text(self.contents, self.directory).lstrip("\n")

    # Curves over time.

    def table(self, name, needed=()):
        """A table by the name of its file; `needed`: columns that have to be there. UnreadableRun where it is damaged."""
        return Table(self.directory / name, per_depth=self.dimension == 2, needed=needed)

    @functools.cached_property
    def gauges(self):
        """gauges.csv: "t_s" and a column per component of each gauge."""
        return self.table("gauges.csv", ["t_s"])

    @functools.cached_property
    def energies(self):
        """energy.csv: "t_s", the energies of both sides, work and dissipation [J; in 2D J/m]."""
        return self.table("energy.csv", ["t_s"])

    @functools.cached_property
    def steps(self):
        """steps.csv: a row per step (window of a coupled run): "t_s", "dt_s", "limit" (text), "pressure_iterations", "wall_ms"."""
        return self.table("steps.csv", ["t_s", "dt_s"])

    # Fields.

    @functools.cache
    def frames_of(self, process):
        """[Fields] of one process, "fluid" or "structure", in order of time."""
        return frames.read(self.directory / f"{process}.h5")

    @functools.cached_property
    def frames(self):
        """The frames in order of time; each has `.time` [s] and `.fluid`, `.structure`, mappings of a field's name to its array."""
        return frames.Frames(self.frames_of("fluid"), self.frames_of("structure"))

    @functools.cache
    def spacings(self, process):
        """{number of a body: its particle spacing [m]}, from the first frame: the median distance to the nearest neighbour in the body.

        The fluid is body 0, and so is all of a structure whose frames do not name bodies. None without frames.
        """
        if not self.frames_of(process):
            return None
        import numpy as np
        frame = self.frames_of(process)[0]
        number = frame["body"] if "body" in frame else np.zeros(len(frame["position"]), dtype=int)

        def of_body(position):
            sample = position[:: max(1, len(position) // 150)]
            distance = np.linalg.norm(sample[:, None, :] - position[None, :, :], axis=2)
            distance[distance == 0] = np.inf
            return float(np.median(distance.min(axis=1)))
        return {int(body): of_body(frame["position"][number == body]) for body in np.unique(number)}

    def spacing(self, process):
        """Particle spacing [m], of the coarsest body; None without frames."""
        return max(self.spacings(process).values(), default=None) if self.frames_of(process) else None

    # For pictures.

    def label(self):
        """How a legend calls this run: its directory, or what distinguish() made of it."""
        return self.legend
