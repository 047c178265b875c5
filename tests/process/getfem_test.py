#!/usr/bin/python3 -B
"""The finite elements of GetFEM as a structure: by themselves against known answers, and in the place of tern-structure.

How the tests were seen to fail is said in each.
"""

import json
import subprocess
import types
import unittest

import numpy as np
from fake_build import ROOT
from real_run import RealRunTest, build_directory, without_waits

from tern.participant.side import Case
from tern.results import series

GETFEM = ROOT / "python" / "tern" / "participant" / "solvers" / "getfem_structure.py"
try:
    from tern.participant.solvers import getfem_structure
except ImportError as error:
    if "getfem" not in str(error) and "scipy" not in str(error):
        raise
    getfem_structure = None


def setUpModule():
    if getfem_structure is None:
        raise unittest.SkipTest("needs python3-getfem and python3-scipy")


def structure(name, across=2):
    answer = subprocess.run([build_directory() / "tern-case", "json", ROOT / "cases" / name], capture_output=True, text=True, check=True)
    return getfem_structure.GetfemStructure(Case(json.loads(answer.stdout)), types.SimpleNamespace(across=across))


class SolidTest(unittest.TestCase):
    def at_rest(self, plate, force):
        """Deflection in the middle under this load and the plate's own weight: one step so long that inertia is nothing."""
        load = (plate.middle.T @ force.ravel() + plate.weight)[plate.solid.free]
        start = np.zeros(plate.solid.space.nbdof())
        u = plate._solve(start, start[plate.solid.free], load, 1e6)
        plate.state = (u, u)
        self.assertAlmostEqual(plate.energies()["strain"] / (0.5 * load @ u[plate.solid.free]), 1, delta=1e-3)
        return (plate.gauges["middle"] @ u)[1]

    # Seen to fail: with lambda = 0 (half as much again), with 3 in place of 2 in the strain energy.
    def test_the_floor_bends_under_two_metres_of_water_as_other_finite_elements_do(self):
        errors = {}
        for across in (2, 4):
            plate = structure("hydrostatic_plate", across)
            top, x, half = plate.normal[:, 1] > 0.5, plate.position[:, 0], plate.area / 2
            force = np.zeros((len(top), 2))
            force[top, 1] = -1000 * 9.81 * 2 * plate.area[top]
            self.assertAlmostEqual(force[:, 1].sum(), -19620, places=6)
            whole = self.at_rest(plate, force)
            errors[across] = abs(whole / -7.06e-5 - 1)
            # The load that the particles of the fluid do not bring to the corners is next to the clamps, where it bends nothing.
            lost = 0.28 * 0.025
            force[:, 1] *= np.clip((x + half - lost) / plate.area, 0, 1) * np.clip((1 - lost - x + half) / plate.area, 0, 1)
            self.assertAlmostEqual(force[:, 1].sum() / -19620, 0.986, delta=1e-3)
            self.assertLess(abs(self.at_rest(plate, force) / whole - 1), 1e-4)
        self.assertLess(errors[2], 0.005)
        self.assertLess(errors[4], 0.001)

    # Seen to fail: with half the density (1.41 times the frequency), with b of the second stage 0.9 of what it is.
    def test_the_plate_of_the_dam_break_swings_with_the_frequency_of_other_finite_elements(self):
        plate = structure("dam_break_plate")
        plate.weight[:] = 0
        nudge, nothing = np.zeros((len(plate.area), 2)), np.zeros((len(plate.area), 2))
        nudge[:, 0] = 1e-3 * plate.area
        for _ in range(50):
            plate.advance(0, 1e-3, nudge)
        before = plate.energies()
        history = []
        for _ in range(300):
            plate.advance(0, 2e-3, nothing)
            history.append(plate.gauge({"name": "P"})[0])
        after = plate.energies()
        x = np.array(history)
        k = np.flatnonzero(x[:-1] * x[1:] < 0)
        crossings = 2e-3 * (k + x[k] / (x[k] - x[k + 1]))
        self.assertAlmostEqual((len(crossings) - 1) / 2 / (crossings[-1] - crossings[0]) / 4.950, 1, delta=0.01)
        kept = (after["kinetic"] + after["strain"]) / (before["kinetic"] + before["strain"])
        self.assertLess(kept, 1)
        self.assertGreater(kept, 0.97)

    # Seen to fail: with the normal pointing inward; with the area of the undeformed piece.
    def test_the_surface_follows_large_rotations_and_stretches(self):
        plate = structure("dam_break_plate")
        nodes = plate.solid.space.basic_dof_nodes()[:, ::2].T
        angle, stretch = 1.1, np.diag([1.3, 0.8])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        plate.state = ((nodes @ (turn @ stretch).T - nodes).ravel(), np.zeros(nodes.size))
        surface = plate.surface()
        cofactor = np.linalg.det(stretch) * np.linalg.inv(turn @ stretch).T
        expected = plate.area[:, None] * (plate.normal @ cofactor.T)
        self.assertLess(abs(surface.area[:, None] * surface.normal - expected).max(), 1e-12)
        self.assertLess(abs(surface.position - plate.position @ (turn @ stretch).T).max(), 1e-12)


class CoupledTest(RealRunTest):
    # Eight particles across differ from the elements by 6.5 % of the largest deflection, where the fluid has 5 mm; with 10 mm by 11 %, in
    # the splashes at the end. Seen to fail: with 0.8 of the load.
    def test_it_bends_with_the_particles_of_tern_structure(self):
        tips = {}
        for name, words in (("particles", []), ("elements", ["--structure", GETFEM])):
            self.out = self.path / name
            process = self.start("--quiet", "--until", "0.3", "--set", "structure.body.plate.spacing=0.0025", "--set",
                                 "fluid.spacing=0.005", *words)
            _, errors = process.communicate(timeout=120)
            self.assertEqual((process.returncode, without_waits(errors)), (0, ""))
            self.assertLess(self.contents()["processes"]["coupler"]["measures"]["momentum_audit_max"], 1e-10)
            self.assert_readable()
            tips[name] = np.array(series.read(self.out / "gauges.csv", "tip.ux_m")).T
        t = np.linspace(0, 0.3, 301)
        particles, elements = (np.interp(t, *tips[name]) for name in ("particles", "elements"))
        self.assertGreater(abs(particles).max(), 1e-4)
        self.assertLess(abs(particles - elements).max(), 0.1 * abs(particles).max())

    # Seen to fail: with the refusals of GetfemStructure taken out.
    def test_what_it_cannot_take_is_refused_in_a_sentence(self):
        for setting, sentence in (("structure.body.plate.material=st_venant_kirchhoff", "the material is st_venant_kirchhoff"),
                                  ("structure.body.plate.plane=stress", "it is in plane stress")):
            process = self.start("--structure", GETFEM, "--force", "--quiet", "--set", setting)
            _, errors = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 2, errors)
            self.assertIn(f"this solver cannot take the case, for {sentence}", errors)


if __name__ == "__main__":
    unittest.main()
