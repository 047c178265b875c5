#!/usr/bin/python3 -B
"""./tern check --picture: what is drawn is what the processes take, with all that the case describes."""

import subprocess
import tempfile
import unittest
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import pyplot as plt

import real_run
import tern
from tern.launch import cases
from tern.plot import at_start

matplotlib.use("Agg")

SCENE = """
title = "A gate and a plate"
dimension = 2
end_time = 0.001
gravity = [0, -9.81]
[[wall]]
name = "tank"
container = { box = { min = [0, 0], max = [0.4, 0.4] } }
open = ["y_max"]
[[wall]]
name = "gate"
obstacle = { box = { min = [0.2, 0], max = [0.22, 0.3] } }
displacement = [0, "50*t"]
[fluid]
density = 1000
spacing = 0.01
[[fluid.body]]
shape = { box = { min = [0, 0], max = [0.2, 0.1] } }
velocity = ["2*y", 0]
[[structure.body]]
name = "plate"
shape = { box = { min = [0.3, -0.02], max = [0.32, 0.1] } }
spacing = 0.005
density = 1100
young_modulus = 1e6
poisson_ratio = 0.4
clamp = [{ box = { min = [0.29, -0.03], max = [0.33, 0] } }]
[[gauge]]
kind = "displacement"
name = "tip"
body = "plate"
at = [0.31, 0.0975]
[[gauge]]
kind = "interface_force"
name = "push"
body = "plate"
"""


class CasePictureTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.directory = Path(directory.name)
        self.case = self.directory / "case.toml"
        self.case.write_text(SCENE)
        self.build = real_run.build_directory()

    def check(self, *words):
        answer = subprocess.run([real_run.ROOT / "tern", "check", self.case, *words], capture_output=True, text=True, check=False)
        # The first check of a build also says that it measures the machine.
        errors = "".join(line for line in answer.stderr.splitlines(keepends=True) if "measuring once" not in line)
        return answer.returncode, answer.stdout, errors

    def said(self, most=10 ** 6):
        return cases.read(self.build, self.case, []), cases.scene(self.build, self.case, [], most)

    def test_the_particles_and_walls_are_those_of_the_processes(self):
        # Seen to fail: with fill_lattice in place of fill_with_fluid in scene_at_start.cpp.
        self.case.write_text(SCENE.replace("max = [0.2, 0.1] } }\nvelocity", "max = [0.2, 0.095] } }\nvelocity"))
        case, start = self.said()
        fluid, plate = at_start.bodies_of(case["settings"], start)
        tern.run(self.case, out=self.directory / "out", quiet=True)
        run = tern.Run(self.directory / "out")
        first = run.frames_of("structure")[0]
        free, held = (first["position"][(first["clamped"] != 0) == clamped, :2] for clamped in (False, True))
        kept = {tuple(point) for point in plate.clamped}
        shown = np.array([point for point in plate.points if tuple(point) not in kept])
        # What is held lies on the lattice in the picture; the structure puts the last row onto the face of the clamp.
        for points, there, most in ((fluid.points, run.frames_of("fluid")[0]["position"][:, :2], 1e-12), (shown, free, 1e-12),
                                    (plate.clamped, held, 0.0025 + 1e-12)):
            self.assertEqual(len(points), len(there))
            distance = np.linalg.norm(points[:, None] - there[None], axis=2)
            self.assertLess(max(distance.min(axis=0).max(), distance.min(axis=1).max()), most)
        path = start["walls"][1]["path"]
        for entry, frame in ((path[0], run.frames_of("fluid")[0]), (path[-1], run.frames_of("fluid")[-1])):
            np.testing.assert_allclose(entry["place"], frame["wall_place"][:, :2], atol=1e-9)

    def test_a_case_without_a_title_is_named_by_its_file_or_folder(self):
        # Seen to fail: with the title alone.
        self.case.write_text(SCENE.replace('title = "A gate and a plate"\n', ""))
        case, start = self.said()
        figure = at_start.figure_of(case, start)
        self.addCleanup(plt.close, figure)
        self.assertTrue(any(axis.get_title(loc="left").startswith(f"{self.directory.name}, before the first step") for axis in figure.axes))

    def test_the_picture_names_what_the_case_describes(self):
        # Seen to fail: with the gate drawn where it is farthest away.
        case, start = self.said()
        figure = at_start.figure_of(case, start)
        self.addCleanup(plt.close, figure)
        axis = next(axis for axis in figure.axes if axis.get_legend())
        legend = "\n".join(text.get_text() for text in axis.get_legend().get_texts())
        for part in ("fluid: 200 particles, spacing 0.01 m", "plate: 96 particles, spacing 0.005 m", "held: 16 particles",
                     "walls: tank (open: y_max), gate", "gate: its middle moves by up to 0.05 m", "gauges: tip",
                     "gauges not drawn: push (interface force)", "velocity at the start, up to 0.19 m/s"):
            self.assertIn(part, legend)
        self.assertIn("gravity 9.81", axis.get_title(loc="left"))
        gate = np.concatenate([np.reshape(lines.get_segments(), (-1, 2)) for lines in axis.collections
                               if hasattr(lines, "get_segments") and np.allclose(lines.get_linewidths(), 1.5)
                               and matplotlib.colors.to_hex(lines.get_colors()[0]) == at_start.MOVING])
        np.testing.assert_allclose([gate.min(axis=0), gate.max(axis=0)], [[0.2, 0], [0.22, 0.3]])

    def test_of_too_many_particles_the_outlines_are_drawn(self):
        # Seen to fail: without the sentence in figure_of().
        case, start = self.said(most=100)
        self.assertNotIn("rows", start["bodies"][0])
        figure = at_start.figure_of(case, start)
        self.addCleanup(plt.close, figure)
        self.assertTrue(any("outlines only: of 296 particles" in axis.get_title(loc="left") for axis in figure.axes))

    def test_every_case_can_be_described(self):
        # Seen to fail: with the path of moving walls left out of scene_at_start().
        for name in cases.named("case.toml"):
            path = cases.find(name)
            case, start = cases.read(self.build, path, []), cases.scene(self.build, path, [], at_start.MOST_PARTICLES)
            bodies = at_start.bodies_of(case["settings"], start)
            for body in bodies:
                self.assertEqual(len(body.points), body.count, name)
            motions = at_start.motions_of(case["settings"], start)
            self.assertEqual(len(motions), sum(bool({"displacement", "rotation", "motion_file"} & set(part)) for part in
                                               case["settings"].get("wall", []) + case["settings"].get("structure", {}).get("clamp", [])))
            self.assertTrue(at_start.legend_of(case["settings"], start, bodies, motions, case["gauge_places"]))

    def test_the_command_writes_the_file_and_refuses_as_check_does(self):
        # Seen to fail: without the check of the suffix, and with the picture drawn whatever the exit code.
        file = self.directory / "new" / "scene.png"
        code, output, errors = self.check("--picture", file)
        self.assertEqual((code, errors), (0, ""))
        self.assertIn(f"picture: {file}", output)
        self.assertTrue(file.read_bytes().startswith(b"\x89PNG"))
        other = self.directory / "other.png"
        for words, reason in ((("--picture", other, "--set", "fluid.spacing=-1"), "spacing"), (("--picture", "scene.gif"), ".png"),
                              (("--clip", "z=0"), "add --picture"), (("--picture", other, "--camera", "1,2"), "is for 3D cases")):
            code, _, errors = self.check(*words)
            self.assertEqual(code, 2)
            self.assertIn(reason, errors)
            self.assertEqual(len(errors.splitlines()), 1, errors)
            self.assertFalse(other.exists())


if __name__ == "__main__":
    unittest.main()
