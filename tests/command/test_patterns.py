"""Numbers out of crack patterns: against patterns drawn by hand and tables of the distributions."""
from __future__ import annotations

import math
import unittest

import numpy as np

from sunder_lab.crossings import radial_crossings
from sunder_lab.statistics import beta_share, student
from tests.validation import patterns


def star(arms: int, phase: float = 0.0, length: float = 1.0, edges: int = 7) -> np.ndarray:
    """Straight cracks from the origin, each of several edges."""
    r = np.linspace(0.0, length, edges + 1)
    angle = phase + 2.0 * np.pi * np.arange(arms) / arms
    way = np.stack([np.cos(angle), np.sin(angle)], -1)
    points = r[None, :, None] * way[:, None, :]
    return np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 2)


def ring(radius: float, edges: int = 60) -> np.ndarray:
    angle = 2.0 * np.pi * np.arange(edges + 1) / edges
    points = radius * np.stack([np.cos(angle), np.sin(angle)], -1)
    return np.stack([points[:-1], points[1:]], axis=1)


class Harmonic(unittest.TestCase):
    def test_axes_diagonals_and_rings(self) -> None:
        self.assertAlmostEqual(patterns.harmonic(star(4)), 1.0)
        self.assertAlmostEqual(patterns.harmonic(star(4, math.pi / 4)), -1.0)
        self.assertAlmostEqual(abs(patterns.harmonic(star(5))), 0.0)
        self.assertAlmostEqual(abs(patterns.harmonic(ring(1.0))), 0.0)

    def test_a_turn_multiplies_the_phase(self) -> None:
        found = patterns.harmonic(star(4), turn=math.radians(15))
        self.assertAlmostEqual(found, np.exp(1j * math.radians(60)))

    def test_the_sense_of_an_edge_does_not_matter_and_length_does(self) -> None:
        ends = np.concatenate([star(1, edges=1), star(1, math.pi / 4, length=3.0, edges=1)[:, ::-1]])
        self.assertAlmostEqual(patterns.harmonic(ends), (1.0 - 3.0) / 4.0)

    def test_nothing_has_no_direction(self) -> None:
        self.assertTrue(math.isnan(patterns.harmonic(np.zeros((0, 2, 2))).real))

    def test_edges_of_the_circle_are_told_apart(self) -> None:
        ends = np.concatenate([star(3, length=0.9), ring(1.0)])
        self.assertEqual(int(patterns.off_circle(ends, np.zeros(2), 1.0, 0.02).sum()), 21)


class Radials(unittest.TestCase):
    def test_arms_are_counted_at_their_angles(self) -> None:
        centre = np.array([0.3, -0.2])
        found = radial_crossings(star(5, 0.1) + centre, centre, 0.5)
        self.assertTrue(np.allclose(np.diff(found), 2.0 * np.pi / 5))
        self.assertAlmostEqual(float(np.abs(found - 0.1).min()), 0.0)

    def test_rings_short_arms_and_arms_that_run_across_are_not(self) -> None:
        across = np.array([[[0.45, -0.3], [0.45, 0.3]]])
        ends = np.concatenate([star(5, length=0.4), ring(0.5), across])
        self.assertEqual(len(radial_crossings(ends, np.zeros(2), 0.5)), 0)

    def test_a_vertex_on_the_circle_counts_once(self) -> None:
        self.assertEqual(len(radial_crossings(star(1, edges=8), np.zeros(2), 0.5)), 1)


class Statistics(unittest.TestCase):
    def test_the_distribution_of_f(self) -> None:
        # tables: P(F > 2.92) with 3 and 30 degrees is 0.05, P(F > 4.51) is 0.01
        for f, chance in ((2.922, 0.05), (4.510, 0.01)):
            self.assertAlmostEqual(beta_share(30.0 / (30.0 + 3.0 * f), 15.0, 1.5), chance, places=4)

    def test_the_distribution_of_t(self) -> None:
        self.assertAlmostEqual(student(0.95, 10), 2.2281, places=3)
        self.assertAlmostEqual(student(0.95, 1), 12.706, places=2)

    def test_anova_by_hand(self) -> None:
        # means 2, 4, 6, squares within 6, between 24: F = 12 / 1
        f, chance = patterns.anova([np.array([1, 2, 3]), np.array([3, 4, 5]), np.array([5, 6, 7])])
        self.assertAlmostEqual(f, 12.0)
        self.assertAlmostEqual(chance, 0.008, places=4)  # (1 + 2 F / 6)^-3

    def test_anova_of_like_and_unlike_groups(self) -> None:
        random = np.random.default_rng(3)
        draw = random.normal(size=(4, 8)) + 1j * random.normal(size=(4, 8))
        self.assertGreater(patterns.anova(list(draw))[1], 0.01)
        draw[0] += 4.0
        self.assertLess(patterns.anova(list(draw))[1], 1e-4)

    def test_chances_are_even_where_nothing_differs(self) -> None:
        random = np.random.default_rng(4)
        chances = [patterns.anova(list(random.normal(size=(4, 8))))[1] for _ in range(400)]
        self.assertAlmostEqual(float(np.mean(np.array(chances) < 0.1)), 0.1, delta=0.05)  # 3 standard errors

    def test_anova_refuses_what_it_cannot_judge(self) -> None:
        with self.assertRaises(ValueError):
            patterns.anova([np.array([1.0]), np.array([2.0])])
        self.assertEqual(patterns.anova([np.ones(3), np.ones(3)]), (0.0, 1.0))
        self.assertEqual(patterns.anova([np.ones(3), np.zeros(3)]), (math.inf, 0.0))

    def test_the_bound_holds_the_mean_and_rejects_a_preference(self) -> None:
        random = np.random.default_rng(5)
        phase = np.exp(2j * np.pi * random.random(32))
        self.assertLess(patterns.upper_bound(0.6 * phase), 0.3)
        self.assertGreater(patterns.upper_bound(0.6 * phase - 0.4), 0.3)

    def test_the_distance_of_distributions_by_hand(self) -> None:
        self.assertEqual(patterns.distance(np.array([1.0, 2.0]), np.array([3.0, 4.0])), 1.0)
        self.assertEqual(patterns.distance(np.array([2.0, 1.0]), np.array([1.0, 2.0])), 0.0)
        self.assertAlmostEqual(patterns.distance(np.array([1.0, 2.0, 3.0, 4.0]), np.array([2.5, 3.0])), 0.5)

    def test_the_chance_of_a_distance_is_that_of_whole_runs(self) -> None:
        # two runs of each kind: of the 6 ways to deal them out, 2 are as far apart as what is found
        one, other = [np.array([1.0]), np.array([2.0])], [np.array([3.0]), np.array([4.0])]
        self.assertAlmostEqual(patterns.chance_of_distance(one, other), 1.0 / 3.0, delta=0.03)  # 4 standard errors
        # a run of equal numbers is one number: a hundred of them prove no more
        many = [[np.repeat(run, 100) for run in side] for side in (one, other)]
        self.assertAlmostEqual(patterns.chance_of_distance(*many), 1.0 / 3.0, delta=0.03)
        random = np.random.default_rng(6)
        like, unlike = ([scale * random.exponential(size=20) for _ in range(8)] for scale in (1.0, 3.0))
        self.assertLess(patterns.chance_of_distance(like, unlike), 0.01)
        with self.assertRaises(ValueError):
            patterns.chance_of_distance(like, [np.zeros(0)])

    def test_a_quantile_lies_within_its_bounds_which_narrow_with_runs(self) -> None:
        random = np.random.default_rng(7)
        runs = [random.random(30) for _ in range(64)]
        middle, low, high = patterns.quantile_bounds(runs, 0.5)
        self.assertTrue(low < middle < high)
        self.assertTrue(low < 0.5 < high)
        of_few = [patterns.quantile_bounds(runs[k:k + 8], 0.5) for k in range(0, 64, 8)]
        # narrower by the root of 8; the mean of eight intervals is sure to a tenth
        self.assertAlmostEqual((high - low) / float(np.mean([b - a for _, a, b in of_few])), 8.0 ** -0.5, delta=0.12)

    def test_a_power_law_is_found_with_its_interval(self) -> None:
        x = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
        exact = patterns.power_law(x, 3.0 * np.sqrt(x))
        self.assertAlmostEqual(exact.exponent, 0.5)
        self.assertAlmostEqual(exact.factor, 3.0)
        self.assertLess(exact.half, 1e-9)
        rough = patterns.power_law(x, 3.0 * np.sqrt(x) * np.array([1.1, 0.9, 1.1, 0.9, 1.1]))
        self.assertGreater(rough.half, abs(rough.exponent - 0.5))
        with self.assertRaises(ValueError):
            patterns.power_law(x, np.zeros(5))


if __name__ == "__main__":
    unittest.main()
