#!/usr/bin/python3 -B
"""The model of a fluid in many processes: what is counted, what it must tend to, and the description of a cluster.

Seen red: with the ghosts of a part that has neighbours on all sides (counted); with the imbalance left out of the seconds (parts); with
sums that take as long for all numbers of ranks (more ranks); with each check of read_cluster taken out.
"""

import tempfile
import unittest
from pathlib import Path

from tern import scale_model
from tern.errors import BAD_INPUT, Error

CLUSTER = scale_model.Cluster(32, 1.5e-6, 10e9)
# Ghosts over particles as run.json had them, from the table of docs/SCALE.md.
COUNTED = ((2, 3200, {2: 0.08, 4: 0.24, 8: 0.41}), (3, 21296, {2: 0.14, 4: 0.43, 8: 0.79}))


class ModelTest(unittest.TestCase):
    def test_ghosts_are_those_that_were_counted(self):
        for dimension, particles, counted in COUNTED:
            for ranks, share in counted.items():
                own = particles / ranks
                self.assertAlmostEqual(scale_model.ghosts(own, ranks, dimension) / own, share, delta=0.04)

    def test_one_rank_has_nothing_to_say(self):
        one = scale_model.step(1e5, 1, 3, 6e-6, CLUSTER)
        self.assertEqual((one.seconds, one.efficiency, one.ghosts), (1e5 * 6e-6, 1.0, 0.0))

    def test_a_step_is_the_sum_of_its_parts(self):
        step = scale_model.step(1e6, 64, 3, 6e-6, CLUSTER)
        parts = (step.compute_s, 0.05 * step.compute_s, step.exchange_s, step.collective_s, step.coarse_s)
        self.assertTrue(all(part > 0 for part in parts), parts)
        self.assertAlmostEqual(step.seconds, sum(parts), delta=1e-12)
        self.assertAlmostEqual(step.efficiency + step.communication, 1, delta=1e-12)

    def test_more_ranks_wait_longer_for_sums_and_a_better_network_waits_less(self):
        few, many = (scale_model.step(5e4 * ranks, ranks, 3, 6e-6, CLUSTER) for ranks in (64, 4096))
        self.assertAlmostEqual(few.compute_s, many.compute_s, delta=1e-9)
        self.assertGreater(many.collective_s, 2 * few.collective_s)
        self.assertLess(many.efficiency, few.efficiency)
        for better in (scale_model.Cluster(32, 1e-7, 10e9), scale_model.Cluster(32, 1.5e-6, 100e9)):
            self.assertLess(scale_model.step(3.2e6, 64, 3, 6e-6, better).seconds, few.seconds)

    def test_a_rank_holds_less_of_a_fluid_that_more_share(self):
        memory = [scale_model.step(1e6, ranks, 3, 6e-6, CLUSTER).memory for ranks in (1, 2, 8, 64)]
        self.assertEqual(memory, sorted(memory, reverse=True))

    def test_the_table_ends_with_the_ranks_asked_for(self):
        expected = {"fluid_particles": 21296, "steps": 460, "dimension": 3, "fluid_cpu_s": 59, "structure_cpu_s": 4, "coupler_cpu_s": 1}
        lines = scale_model.text(expected, 12, CLUSTER).splitlines()
        self.assertEqual([int(line.split()[0]) for line in lines[2:-2]], [1, 2, 4, 8, 12])
        self.assertIn("Structure and coupler are one process each: 10.9 ms", lines[-2])
        self.assertIn("times as fast", lines[-1])


class ClusterTest(unittest.TestCase):
    def read(self, text):
        with tempfile.TemporaryDirectory() as directory:
            path = Path(directory) / "cluster.toml"
            path.write_text(text, encoding="utf-8")
            return scale_model.read_cluster(path)

    def test_three_lines_describe_one(self):
        found = self.read("cores = 64\nlatency_us = 2\nbandwidth_gb_per_s = 25\n")
        self.assertEqual((found.cores, found.latency_s, found.bandwidth), (64, 2e-6, 25e9))

    def test_what_is_wrong_is_named(self):
        rest = "latency_us = 2\nbandwidth_gb_per_s = 25\n"
        for text, name in (("cores = 64\nlatency_us = 2\n", "bandwidth_gb_per_s = None"), (f"cores = 6.5\n{rest}", "not a whole number"),
                           ("cores = 64\nlatency = 2\n", "latency_us = None"), (f"cores = -6\n{rest}", "cores = -6"),
                           (f"cores = 64\n{rest}price = 3\n", "price = 3"), ("cores =", "cannot be read")):
            with self.assertRaises(Error) as refusal:
                self.read(text)
            self.assertEqual(refusal.exception.exit_code, BAD_INPUT)
            self.assertIn(name, str(refusal.exception))


if __name__ == "__main__":
    unittest.main()
