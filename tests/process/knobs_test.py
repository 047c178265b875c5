#!/usr/bin/python3 -B
"""Every numerical key of a case changes the result of a tiny scene, in its direction where its meaning gives one.

The scenes are those of cases/knobs/: water at rest, water running against a wall, a plate that swings, water thrown against a plate.
A key that `tern-case parameters` lists and this file does not know fails. The program prints by how much each result changed.
"""

import functools
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from real_run import ROOT, build_directory

from tern.results.run import Run

SCENES = ROOT / "tests" / "process" / "cases" / "knobs"
SECTIONS = ("[fluid.numerics]", "[structure.numerics]", "[coupling]", "[coupling.vem]")
ROUND_OFF = 1e-9  # of the largest value of a curve
FLUID, STRUCTURE, COUPLING = "fluid.numerics.", "structure.numerics.", "coupling."
VEM = COUPLING + "vem.coefficient=1"


def table_of_keys(build):
    """The numerical keys that the table of `tern-case parameters` has, as of --set."""
    text = subprocess.run([build / "tern-case", "parameters"], stdout=subprocess.PIPE, text=True, check=True).stdout
    keys = {"preset"}
    for section in text.split("\n## ")[1:]:
        name = section.partition("\n")[0].strip("`")
        if name in SECTIONS:
            keys |= {f"{name.strip('[]')}.{key}" for key in re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE)}
    return keys


class Result:
    """What one run has written."""

    def __init__(self, directory):
        run = Run(directory)
        reports = run.contents.get("processes") or {role: json.loads((directory / f"report.{role}.json").read_text())
                                                    for role in ("fluid", "structure") if (directory / f"report.{role}.json").exists()}
        self.figures = {name: value for report in reports.values() for table in ("measures", "counts")
                        for name, value in report.get(table, {}).items()}
        self.energy, self.gauges, self.steps = run.energies, run.gauges, run.steps
        self.step_count = len(self.steps["t_s"])
        self.limits = set(self.steps["limit"]) - {"output"}
        if (directory / "fluid.h5").exists():
            with h5py.File(directory / "fluid.h5", "r") as file:
                last = file[max(name for name in file if name.startswith("frame_"))]
                self.position, self.velocity = (last[name][:][:, :2] for name in ("position", "velocity"))

    def lost(self):
        """Energy of the fluid that is gone [J/m]."""
        total = self.energy["fluid_kinetic_J"] + self.energy["fluid_potential_J"]
        return total[0] - total[-1]

    def unevenness(self):
        """Scatter of the distance to the nearest particle, over its mean. A drop that flies alone is left out: it would decide."""
        distance = np.linalg.norm(self.position[:, None] - self.position[None], axis=2)
        np.fill_diagonal(distance, np.inf)
        nearest = distance.min(axis=1)
        nearest = nearest[nearest < 2 * np.median(nearest)]
        return float(np.std(nearest) / np.mean(nearest))

    def wall_distance(self):
        """Of the particle that is nearest to a side of the tank, which is a box from 0 to 0.4 m [m]."""
        return float(min(self.position.min(), (0.4 - self.position[:, 0]).min()))

    def noise(self):
        """Root mean square of the velocity less the mean of the six nearest particles [m/s]."""
        distance = np.linalg.norm(self.position[:, None] - self.position[None], axis=2)
        near = np.argsort(distance, axis=1)[:, 1:7]
        return float(np.sqrt(np.mean(np.sum((self.velocity - self.velocity[near].mean(axis=1)) ** 2, axis=1))))

    def change(self, other, share=1.0):
        """Largest difference of any curve of energy.csv or gauges.csv at common times, over the largest value of the curve; of the first
        `share` of the run.
        """
        largest = 0.0
        for one, two in ((self.energy, other.energy), (self.gauges, other.gauges)):
            end = min(one["t_s"][-1], two["t_s"][-1])
            times = np.linspace(0, share * end, 101)
            for name in set(one) & set(two) - {"t_s"}:
                a, b = (np.interp(times, table["t_s"], np.nan_to_num(table[name])) for table in (one, two))
                scale = max(np.abs(a).max(), np.abs(b).max())
                largest = max(largest, np.abs(a - b).max() / scale if scale > 1e-12 else 0.0)
        return largest


class KnobsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.build = build_directory()
        cls.path = Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="tern-test-")))

    @classmethod
    @functools.cache
    def run_scene(cls, scene, *settings):
        """The result of a scene with these KEY=VALUE."""
        out = cls.path / re.sub(r"\W+", "_", "-".join((scene, *settings)))
        options = [word for setting in settings for word in ("--set", setting)]
        if scene == "impact":
            command = [ROOT / "tern", "run", SCENES / "impact.toml", "--allow-unstable"]
        else:
            command = [cls.build / ("tern-structure" if scene == "swing" else "tern-fluid"), SCENES / f"{scene}.toml"]
        answer = subprocess.run([*command, "--out", out, "--quiet", *options], capture_output=True, text=True, check=False, timeout=60,
                                env=os.environ | {"TERN_BUILD": str(cls.build)})
        assert answer.returncode == 0, f"{scene} {settings}: {answer.stderr}"
        return Result(out)

    def pair(self, scene, setting, *common):
        """The scene as it is and with one setting; the result has changed by more than round-off."""
        default, other = self.run_scene(scene, *common), self.run_scene(scene, *common, setting)
        change = default.change(other)
        print(f"  {setting:52} {scene:8} {change:.1e}", file=sys.stderr)
        self.assertGreater(change, ROUND_OFF, f"{setting} changes nothing in {scene}")
        return default, other

    def assert_steps(self, scene, setting, limit, factor, *common):
        """One limit binds in every step, and the number of steps grows by the factor."""
        default, other = self.pair(scene, setting, *common)
        self.assertEqual((default.limits, other.limits), ({limit}, {limit}))
        print(f"  {'':52} steps: {default.step_count} -> {other.step_count}", file=sys.stderr)
        self.assertAlmostEqual(other.step_count / default.step_count, factor, delta=0.1 * factor)

    def assert_more(self, more, less, what):
        print(f"  {'':52} {what}: {more:.4g} > {less:.4g}", file=sys.stderr)
        self.assertGreater(more, less + 1e-6 * abs(less), what)

    # Fluid.

    def test_fluid_numerics_courant(self):
        """Until the water has run up the wall: how fast single drops are then is another matter."""
        self.assert_steps("surge", FLUID + "courant=0.2", "velocity", 2.0, FLUID + "gravity_courant=0.5", "end_time=0.1")

    def test_fluid_numerics_gravity_courant(self):
        self.assert_steps("rest", FLUID + "gravity_courant=0.05", "gravity", 2.0, FLUID + "courant=0.5")

    def test_fluid_numerics_viscous_courant(self):
        self.assert_steps("rest", FLUID + "viscous_courant=0.0625", "viscosity", 2.0, "fluid.viscosity=50")

    def test_fluid_numerics_smoothing_length_ratio(self):
        """The viscous step goes with the square of the smoothing length."""
        self.assert_steps("rest", FLUID + "smoothing_length_ratio=1.2", "viscosity", (1.5 / 1.2) ** 2, "fluid.viscosity=50")

    def test_fluid_numerics_gradient(self):
        self.pair("surge", FLUID + "gradient=sum")

    def test_fluid_numerics_blend_theta(self):
        self.pair("surge", FLUID + "blend_theta=0")

    def test_fluid_numerics_density_relaxation(self):
        """The stronger, the less the volume ever drifts, in the time of some runs to and fro."""
        longer = "end_time=0.8"
        default, other = self.pair("surge", FLUID + "density_relaxation=0", longer)
        stronger = self.run_scene("surge", longer, FLUID + "density_relaxation=0.1")
        drift, of_other, of_stronger = (abs(run.figures["volume_drift_largest"]) for run in (default, other, stronger))
        self.assert_more(of_other, drift, "largest volume drift")
        self.assert_more(drift, of_stronger, "largest volume drift")

    def test_fluid_numerics_shifting(self):
        default, other = self.pair("surge", FLUID + "shifting=0")
        self.assert_more(other.unevenness(), default.unevenness(), "unevenness")

    def test_fluid_numerics_noise_damping(self):
        """Without it the velocities are rougher, and less energy is lost."""
        default, other = self.pair("surge", FLUID + "noise_damping=0")
        self.assert_more(other.noise(), default.noise(), "noise")
        self.assert_more(default.lost(), other.lost(), "lost energy")

    def test_fluid_numerics_contact_distance(self):
        """Without it particles come closer to the walls than a quarter of their spacing."""
        default, other = self.pair("surge", FLUID + "contact_distance=0")
        self.assert_more(default.wall_distance(), other.wall_distance(), "distance to the nearest wall")

    def test_fluid_numerics_pressure_tolerance(self):
        """A loose solve takes fewer iterations, and a tight one is nearer to one that is nearly exact, as long as the flow remembers. From
        1e-6 on the correction for what the solve leaves behind is solved to a tenth, whatever the key, and outweighs it.
        """
        default, other = self.pair("surge", FLUID + "pressure_tolerance=1e-2")
        tight, exact = (self.run_scene("surge", FLUID + f"pressure_tolerance={tolerance}") for tolerance in ("1e-8", "1e-12"))
        self.assert_more(default.figures["pressure_iterations_mean"], other.figures["pressure_iterations_mean"], "iterations")
        self.assert_more(default.change(exact, 0.4), tight.change(exact, 0.4), "distance from the exact solve")

    # Structure.

    def test_structure_numerics_courant(self):
        default, other = self.pair("swing", STRUCTURE + "courant=0.15")
        self.assertAlmostEqual(other.figures["sub_steps"] / default.figures["sub_steps"], 2, delta=0.1)
        # Between outputs that are far apart sub-steps limit the windows. Seen to fail: with "output" for every window's limit.
        self.assertEqual((default.limits, self.run_scene("swing", "output.gauge_interval=0.001").limits), ({"sub-step"}, set()))

    def test_structure_numerics_integrator(self):
        """Implicit steps have no diffusion, and swing like the explicit ones."""
        default, other = self.pair("swing", STRUCTURE + "integrator=implicit")
        self.assertEqual(np.abs(other.energy["structure_diffusion_J"]).max(), 0)
        self.assert_more(default.energy["structure_diffusion_J"].max(), 0, "diffused energy")
        tips = [np.interp(np.linspace(0, 0.02, 50), result.gauges["t_s"], result.gauges["tip.ux_m"]) for result in (default, other)]
        self.assertLess(np.abs(tips[0] - tips[1]).max(), 0.05 * np.abs(tips[0]).max())

    def test_structure_numerics_smoothing_length_ratio(self):
        self.pair("swing", STRUCTURE + "smoothing_length_ratio=1.5")

    def test_structure_numerics_riemann_diffusion(self):
        """Half the coefficient diffuses less, none nothing."""
        default, other = self.pair("swing", STRUCTURE + "riemann_diffusion=0.5")
        none = self.run_scene("swing", STRUCTURE + "riemann_diffusion=0")
        self.assert_more(default.energy["structure_diffusion_J"][-1], other.energy["structure_diffusion_J"][-1], "diffused energy")
        self.assertEqual(none.energy["structure_diffusion_J"][-1], 0)

    # Coupling.

    def test_coupling_algorithm(self):
        """The explicit coupling has nothing to repeat."""
        default, other = self.pair("impact", COUPLING + "algorithm=explicit", "end_time=0.01")
        self.assertGreaterEqual(default.figures["coupling_iterations_mean"], 1)
        self.assertNotIn("coupling_iterations_mean", other.figures)

    def test_coupling_max_iterations(self):
        default, other = self.pair("impact", COUPLING + "max_iterations=1")
        self.assertGreater(default.figures["coupling_iterations_mean"], 1)
        self.assertEqual(other.figures["coupling_iterations_max"], 1)

    def test_coupling_tolerance(self):
        default, other = self.pair("impact", COUPLING + "tolerance=1e-2", COUPLING + "tolerance=1e-4")
        self.assert_more(default.figures["coupling_iterations_mean"], other.figures["coupling_iterations_mean"], "trials")

    def test_coupling_scheme(self):
        """The three schemes give three loads; the Riemann dissipation is of one only."""
        results = [self.run_scene("impact"), self.pair("impact", COUPLING + "scheme=pi")[1],
                   self.pair("impact", COUPLING + "scheme=fsa")[1]]
        self.assertGreater(results[1].change(results[2]), ROUND_OFF)
        dissipation = [np.abs(result.energy["riemann_dissipation_J"]).max() for result in results]
        self.assertTrue(dissipation[0] > 0 and dissipation[1:] == [0, 0], dissipation)

    def test_coupling_riemann_limiter(self):
        default, other = self.pair("impact", COUPLING + "riemann_limiter=0")
        self.assertGreater(default.energy["riemann_dissipation_J"][-1], 0)
        self.assertEqual(np.abs(other.energy["riemann_dissipation_J"]).max(), 0)

    def test_coupling_robin_mass_factor(self):
        self.pair("impact", COUPLING + "robin_mass_factor=0.5")

    def test_coupling_vem_coefficient(self):
        """A stronger term dissipates more where the water comes in."""
        default, other = self.pair("impact", COUPLING + "vem.coefficient=5", VEM)
        self.assertEqual(np.abs(self.run_scene("impact").energy["vem_dissipation_J"]).max(), 0)
        self.assert_more(other.energy["vem_dissipation_J"].max(), default.energy["vem_dissipation_J"].max(), "dissipation")

    def test_coupling_vem_form(self):
        """The published form does not conserve momentum, the other two do."""
        default, other = self.pair("impact", COUPLING + "vem.form=seed", VEM)
        pulls = self.pair("impact", COUPLING + "vem.form=sum", VEM)[1]
        audits = [result.figures["momentum_audit_max"] for result in (default, pulls, other)]
        self.assertTrue(max(audits[:2]) < 1e-12 < 1e-6 < audits[2], audits)

    def test_preset(self):
        """The preset is the same, to the bit, as the settings it stands for."""
        start = "end_time=0.01", FLUID + "courant=0.3"  # explicit staggering of this plate is stopped soon after
        _, other = self.pair("impact", "preset=paper", *start)
        spelt_out = self.run_scene("impact", *start, COUPLING + "algorithm=explicit", COUPLING + "scheme=riemann",
                                   COUPLING + "vem.coefficient=5", COUPLING + "vem.form=seed")
        self.assertEqual(other.change(spelt_out), 0)

    def test_every_key_of_the_table_has_a_test_here(self):
        # Seen to fail: with the test of courant renamed; and each other test with its --set not handed over in run_scene().
        tested = {name.removeprefix("test_") for name in dir(self)}
        keys = table_of_keys(self.build)
        self.assertGreater(len(keys), 20)
        self.assertEqual(sorted(key for key in keys if key.replace(".", "_") not in tested), [])


if __name__ == "__main__":
    unittest.main()
