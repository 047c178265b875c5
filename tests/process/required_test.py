"""Only what the case asks for is modelled: what it leaves out is not evaluated, not sent and not started.

One module at a time is switched on in a scene that has none. Its evaluations (run.json, processes.ROLE.evaluations) rise above 0, those
of all others stay at 0. What is allocated: tests/fluid/allocation_test.cpp.
"""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

from fake_build import ROOT
from real_run import build_directory

SCENE = """
dimension = 2
end_time = 0.06
gravity = [0, -9.81]
[domain]
min = [-0.3, -0.3]
max = [0.7, 0.7]
"""
FLUID = """
[[wall]]
name = "tank"
container = { box = { min = [0, 0], max = [0.3, 0.3] } }
open = ["y_max"]
[fluid]
density = 1000
spacing = 0.01
[[fluid.body]]
shape = { box = { min = [0, 0], max = [0.1, 0.1] } }
[fluid.numerics]
density_relaxation = 0
noise_damping = 0
shifting = 0
"""
STRUCTURE = """
[[structure.body]]
name = "plate"
shape = { box = { min = [0.10, -0.02], max = [0.12, 0.08] } }
spacing = 0.005
density = 1200
young_modulus = 1e6
poisson_ratio = 0.4
clamp = [{ box = { min = [0.0, -0.03], max = [0.3, 0] } }]
[structure.numerics]
integrator = "explicit"
riemann_diffusion = 0
"""
COUPLING = """
[coupling]
max_iterations = 1
riemann_limiter = 0
"""
GATE = """
[[wall]]
name = "gate"
obstacle = { box = { min = [-0.2, 0.2], max = [-0.1, 0.3] } }
displacement = ["0", "0.1*t"]
"""
VEM = """
[coupling.vem]
coefficient = 1
"""
LOAD = """
[[structure.load]]
name = "wind"
body = "plate"
pressure = "10*t"
"""
CLAMP = """
[[structure.clamp]]
name = "foot"
body = "plate"
region = { box = { min = [0.0, -0.03], max = [0.3, -0.01] } }
displacement = ["0.001*t", "0"]
"""


def gauge(kind, more):
    return f'[[gauge]]\nkind = "{kind}"\nname = "g"\n{more}\n'


# Module: what it adds to the case, the options it sets, and where its evaluations are counted.
MODULES = {
    "viscosity": ("", ["fluid.viscosity=1"], "fluid", "viscosity"),
    "noise damping": ("", ["fluid.numerics.noise_damping=0.2"], "fluid", "noise_damping"),
    "density source": ("", ["fluid.numerics.density_relaxation=0.02"], "fluid", "density_source"),
    "shifting": ("", ["fluid.numerics.shifting=0.5"], "fluid", "shifting"),
    "gate": (GATE, [], "fluid", "moving_walls"),
    "Riemann dissipation": ("", ["coupling.riemann_limiter=3"], "coupler", "riemann_dissipation"),
    "VEM": (VEM, [], "coupler", "vem"),
    "repeated windows": ("", ["coupling.max_iterations=50", "coupling.tolerance=1e-4"], "coupler", "coupling_iterations"),
    "diffusion": ("", ["structure.numerics.riemann_diffusion=1"], "structure", "riemann_diffusion"),
    "load": (LOAD, [], "structure", "loads"),
    "moving clamp": (CLAMP, [], "structure", "moving_clamps"),
    "gauge of the front": (gauge("front", ""), [], "fluid", "gauges"),
    "gauge of a pressure": (gauge("pressure", "at = [0.05, 0.05]"), [], "fluid", "gauges"),
    "gauge of the elevation": (gauge("elevation", "at = [0.05, 0]"), [], "fluid", "gauges"),
    "gauge of a flux": (gauge("flux", "from = [0.05, 0]\nto = [0.05, 0.2]"), [], "fluid", "gauges"),
    "gauge of a wall's force": (gauge("force", 'wall = "tank"'), [], "fluid", "gauges"),
    "gauge of a wall's pressure": (gauge("wall_pressure", 'wall = "tank"\nat = [0, 0.03]'), [], "fluid", "gauges"),
    "gauge of a displacement": (gauge("displacement", 'body = "plate"\nat = [0.11, 0.08]'), [], "structure", "gauges"),
    "gauge of a reaction": (gauge("reaction", 'body = "plate"'), [], "structure", "gauges"),
    "gauge of the interface's force": (gauge("interface_force", 'body = "plate"'), [], "coupler", "gauges"),
}
ALWAYS = {"elastic_force", "pressure", "structure_surface"}


class RequiredTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.build = build_directory()
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        cls.addClassCleanup(directory.cleanup)
        cls.path = Path(directory.name)
        cls.runs = {}
        cls.bare = cls.run_case("bare", FLUID + STRUCTURE + COUPLING)

    @classmethod
    def run_case(cls, name, text, settings=()):
        """run.json of a run."""
        folder = cls.path / f"case-{len(cls.runs)}"
        folder.mkdir()
        (folder / "case.toml").write_text(SCENE + text)
        words = [part for setting in settings for part in ("--set", setting)]
        out = folder / "out"
        environment = os.environ | {"TERN_BUILD": str(cls.build)}
        done = subprocess.run([ROOT / "tern", "run", folder / "case.toml", "--out", out, "--quiet", *words], env=environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60, check=False)
        if done.returncode != 0:
            raise AssertionError(f"{name}: {done.stdout}")
        contents = json.loads((out / "run.json").read_text())
        cls.runs[name] = contents
        return contents

    @staticmethod
    def evaluations(contents):
        return {(role, term): count for role, process in contents["processes"].items()
                for term, count in process["evaluations"].items()}

    def test_what_is_left_out_is_never_evaluated(self):
        """Seen to fail: with the density source computed at a coefficient of 0, and the Riemann term at a limiter of 0."""
        for key, count in self.evaluations(self.bare).items():
            if key[1] in ALWAYS:
                self.assertGreater(count, 0, key)
            else:
                self.assertEqual(count, 0, key)

    def test_one_module_switched_on_is_evaluated_alone_and_sends_what_it_needs(self):
        """Seen to fail: with each count taken out of its term in turn; with the divergence sent without VEM."""
        for name, (text, settings, role, term) in MODULES.items():
            with self.subTest(name):
                contents = self.run_case(name, FLUID + STRUCTURE + COUPLING + text, settings)
                for key, count in self.evaluations(contents).items():
                    if key == (role, term):
                        self.assertGreater(count, 0, key)
                    elif key[1] not in ALWAYS:
                        self.assertEqual(count, 0, key)
        traffic = {name: self.runs[name]["processes"]["coupler"]["counts"]["bytes_received"] / self.runs[name]["steps"]
                   for name in ("bare", "VEM", "gauge of a displacement")}
        self.assertGreater(traffic["VEM"], traffic["bare"] + 8)
        self.assertGreater(traffic["gauge of a displacement"], traffic["bare"] + 8)

    def test_a_side_that_is_left_out_starts_no_process(self):
        """Seen to fail: with a coupler started all the same."""
        self.assertEqual(set(self.bare["processes"]), {"coupler", "fluid", "structure"})
        alone = self.run_case("fluid alone", FLUID)
        self.assertEqual(set(alone["processes"]), {"fluid"})
        self.assertEqual(self.evaluations(alone)["fluid", "structure_surface"], 0)
        dry = self.run_case("structure alone", STRUCTURE)
        self.assertEqual(set(dry["processes"]), {"structure"})
        for contents in (alone, dry):
            for process in contents["processes"].values():
                self.assertEqual(process["counts"].get("bytes_sent", 0), 0)
                self.assertEqual(process["timing_s"]["exchange"], 0)


if __name__ == "__main__":
    unittest.main()
