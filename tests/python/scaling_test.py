#!/usr/bin/python3 -B
"""The model of a fluid in many processes: what it has to be whatever figures go in.

Seen red: with sums that know no latency; with grids divided down to the last; with one rank that has neighbours.
"""

import unittest
from dataclasses import replace

from tern.launch import scaling

CLUSTER = scaling.Cluster()


class Model(unittest.TestCase):
    def test_one_rank_costs_what_one_process_does(self):
        for fluid in scaling.MEASURED.values():
            self.assertEqual(scaling.efficiency(fluid, CLUSTER, 1, 50000), 1)

    def test_grids_are_divided_until_their_next_one_is_small(self):
        divided, whole = scaling.grids(3, 21296)
        self.assertEqual(divided, [2662, 332.75])
        self.assertLess(whole, scaling.COARSEST)

    def test_many_ranks_and_small_parts_cost_more(self):
        for fluid in scaling.MEASURED.values():
            of_ranks = [scaling.efficiency(fluid, CLUSTER, ranks, 50000) for ranks in (1, 8, 64, 1000, 10000)]
            self.assertEqual(of_ranks, sorted(of_ranks, reverse=True))
            self.assertLess(scaling.efficiency(fluid, CLUSTER, 1000, 5000), scaling.efficiency(fluid, CLUSTER, 1000, 50000))

    def test_a_slow_network_costs_in_messages_and_sums_alone(self):
        fluid = scaling.MEASURED[3]
        quick, slow = (scaling.costs(fluid, cluster, 1000, 50000) for cluster in (CLUSTER, replace(CLUSTER, latency_s=1e-3)))
        self.assertEqual({part for part in quick if slow[part] > quick[part]}, {"messages", "sums over all", "cuts", "imbalance"})


if __name__ == "__main__":
    unittest.main()
