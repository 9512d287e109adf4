"""Why shells that seams join share a step: what local steps across a common node do to energy and momentum."""
from __future__ import annotations

import unittest

import numpy as np

from .step_ratios import Bar, growth, growths, of_impulses, of_nodes

ROUND_OFF = 1e-6  # the radius of a multiple eigenvalue 1 is that of its Jordan block, the root of round-off
SHARES = np.linspace(0.5, 0.98, 13, dtype=np.float64)


class AcrossANode(unittest.TestCase):
    def test_one_step_for_all_is_stable_up_to_the_stable_step_and_not_beyond(self) -> None:
        bar = Bar(5, 13, 4)
        step = bar.stable_step(bar.stiffness(0, 18))
        for share in SHARES:
            self.assertLess(growth(of_impulses(bar, share * step, 1)), ROUND_OFF)
        self.assertGreater(growth(of_impulses(bar, 1.02 * step, 1)), 0.1)

    def test_impulses_conserve_momentum_and_are_unstable_near_the_coarse_parts_limit(self) -> None:
        bar = Bar(5, 13, 4)
        period, mass = of_impulses(bar, 0.1, 4), bar.masses()
        momentum = np.concatenate([np.zeros(len(mass)), mass])
        np.testing.assert_allclose(momentum @ period, momentum, atol=1e-13)
        for m in (2, 4, 8):
            found = growths("impulses", m, m, SHARES)
            self.assertGreater(sum(g > ROUND_OFF for g in found), len(found) // 4, m)
            self.assertGreater(max(found), 0.02, m)
        self.assertLess(max(growths("impulses", 16, 2, SHARES)), ROUND_OFF)  # an eighth of its limit: nothing is gained

    def test_impulses_at_every_second_step_are_stable_below_their_bound_and_at_every_fourth_they_are_not(self) -> None:
        below = np.linspace(0.5, 0.999, 9)
        for ratio in (1, 2, 3, 4, 16):
            for coarse, fine in ((5, 13), (16, 12)):
                bar = Bar(coarse, fine, ratio)
                longest = bar.longest_second_step()
                for share in below:
                    self.assertLess(growth(of_impulses(bar, share * longest, 2)), ROUND_OFF, (ratio, share))
                if ratio in (2, 3):
                    self.assertGreater(max(growth(of_impulses(bar, share * longest, 4)) for share in below), 1e-3, ratio)
        same = Bar(8, 8, 1)  # elements of one size: the bound is sharp
        self.assertGreater(growth(of_impulses(same, 1.01 * same.longest_second_step(), 2)), 0.1)

    def test_a_partition_by_nodes_loses_momentum_and_handing_it_over_later_makes_it_grow(self) -> None:
        bar = Bar(5, 13, 4)
        mass = bar.masses()
        momentum = np.concatenate([np.zeros(len(mass)), mass, np.zeros(len(mass))])
        self.assertGreater(np.abs(momentum @ of_nodes(bar, 0.1, 4, False) - momentum).max(), 1e-3)
        found = growths("nodes", 4, 4, SHARES)
        self.assertLess(sum(g > ROUND_OFF for g in found), len(found) // 4)  # bands, but narrow ones
        self.assertGreater(max(found), 1e-4)
        later = momentum + np.concatenate([np.zeros(2 * len(mass)), (np.arange(len(mass)) < 5) * 1.0])
        period = of_nodes(bar, 0.1, 4, True)
        np.testing.assert_allclose(later @ period, later, atol=1e-13)
        for m in (2, 4, 8):
            self.assertGreater(min(growths("carry", m, m, SHARES)), 1e-4, m)


if __name__ == "__main__":
    unittest.main()
