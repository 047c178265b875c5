#!/usr/bin/python3 -B
"""The model of a fluid in many processes: what is counted, what it must tend to, and the description of a cluster.

Seen red: with the ghosts of a part that has neighbours on all sides (counted); with sums that know no latency; with grids divided down to
the last; with one rank that has neighbours; with each check of read_cluster taken out.
"""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

from tern import scale_model
from tern.errors import BAD_INPUT, Error

CLUSTER = scale_model.Cluster()
# Ghosts over particles as run.json had them, from the table of docs/SCALE.md.
COUNTED = ((2, 3200, {2: 0.08, 4: 0.24, 8: 0.41}), (3, 21296, {2: 0.14, 4: 0.43, 8: 0.79}))


class ModelTest(unittest.TestCase):
    def test_one_rank_costs_what_one_process_does(self):
        for fluid in scale_model.MEASURED.values():
            self.assertEqual(scale_model.efficiency(fluid, CLUSTER, 1, 50000), 1)
            self.assertEqual(str(scale_model.around(50000, 1, fluid.dimension, scale_model.SUPPORT)), "0.0")  # not -0, not rounding

    def test_grids_are_divided_until_their_next_one_is_small(self):
        divided, whole = scale_model.grids(3, 21296)
        self.assertEqual(divided, [2662, 332.75])
        self.assertLess(whole, scale_model.COARSEST)

    def test_many_ranks_and_small_parts_cost_more(self):
        for fluid in scale_model.MEASURED.values():
            of_ranks = [scale_model.efficiency(fluid, CLUSTER, ranks, 50000) for ranks in (1, 8, 64, 1000, 10000)]
            self.assertEqual(of_ranks, sorted(of_ranks, reverse=True))
            self.assertLess(scale_model.efficiency(fluid, CLUSTER, 1000, 5000), scale_model.efficiency(fluid, CLUSTER, 1000, 50000))

    def test_a_slow_network_costs_in_messages_and_sums_alone(self):
        fluid = scale_model.MEASURED[3]
        quick, slow = (scale_model.costs(fluid, cluster, 1000, 50000) for cluster in (CLUSTER, replace(CLUSTER, latency_s=1e-3)))
        self.assertEqual({part for part in quick if slow[part] > quick[part]}, {"messages", "sums over all", "cuts", "imbalance"})

    def test_ghosts_are_those_that_were_counted(self):
        for dimension, particles, counted in COUNTED:
            for ranks, share in counted.items():
                own = particles / ranks
                self.assertAlmostEqual(scale_model.around(own, ranks, dimension, scale_model.SUPPORT) / own, share, delta=0.04)

    def test_a_rank_holds_less_of_a_fluid_that_more_share(self):
        memory = [scale_model.memory(3, ranks, 1e6 / ranks) for ranks in (1, 2, 8, 64)]
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
        self.assertEqual((found.cores, found.latency_s, found.machine_bytes_per_s), (64, 2e-6, 25e9))

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
