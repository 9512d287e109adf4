"""Measures of stars of cracks: arms, their curvature, and double lines along a border."""
from __future__ import annotations

import math
import unittest

import numpy as np

from sunder_tools.pictures.crack_lines import Graph
from tests.validation.stars import Star, arms, curvatures, doubled, measure

PANE = Star("pane", "pane", (), 1, 0.05, 0.05, 0.001)
DISC = Star("disc", "disc", (), 1, 0.05, 0.05, 0.001, True)


def graph(*lines: np.ndarray) -> Graph:
    """Cracks, one a polyline (n, 2)."""
    ends = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    crack = np.concatenate([np.full(len(line) - 1, k) for k, line in enumerate(lines)])
    return Graph(ends, np.zeros((len(ends), 2, 3)), crack, np.ones(len(ends)))


def straight(start: tuple[float, float], end: tuple[float, float], edges: int) -> np.ndarray:
    return np.linspace(start, end, edges + 1)


class Arms(unittest.TestCase):
    def test_a_crack_is_one_line_and_a_fork_parts_it(self) -> None:
        stem, arm = straight((0.01, 0.05), (0.05, 0.05), 40), straight((0.05, 0.05), (0.07, 0.07), 20)
        self.assertEqual([len(line) for line in arms(graph(stem, arm))], [41, 21])
        one = graph(stem, arm, straight((0.05, 0.05), (0.07, 0.03), 20))
        forked = Graph(one.ends, one.rest, np.zeros(len(one), int), one.born)  # all three are one crack
        self.assertEqual(sorted(len(line) for line in arms(forked)), [21, 21, 41])

    def test_edges_in_any_order_make_the_same_line(self) -> None:
        line = straight((0.01, 0.02), (0.05, 0.06), 12)
        mixed = graph(line)
        order = np.random.default_rng(1).permutation(len(mixed))
        ends = mixed.ends[order]
        ends[::2] = ends[::2, ::-1]
        found = arms(Graph(ends, mixed.rest, mixed.crack, mixed.born))
        self.assertEqual(len(found), 1)
        self.assertTrue(np.array_equal(found[0], line) or np.array_equal(found[0], line[::-1]))

    def test_a_ring_is_one_line(self) -> None:
        angle = 2.0 * math.pi * np.arange(31) / 30
        ring = 0.05 + 0.02 * np.column_stack([np.cos(angle), np.sin(angle)])
        ring[-1] = ring[0]
        self.assertEqual([len(line) for line in arms(graph(ring))], [31])

    def test_curvature_is_that_of_a_circle_and_of_a_line(self) -> None:
        angle = np.linspace(0.0, 2.0, 400)
        circle = 0.04 * np.column_stack([np.cos(angle), np.sin(angle)])
        np.testing.assert_allclose(curvatures(circle, 0.005), 25.0, rtol=1e-3)  # 1/R
        np.testing.assert_allclose(curvatures(straight((0, 0), (0.03, 0.04), 50), 0.005), 0.0, atol=1e-9)
        self.assertEqual(len(curvatures(straight((0, 0), (0.004, 0), 4), 0.005)), 0)

    def test_short_arms_do_not_count(self) -> None:
        found, number, _ = measure(graph(straight((0.02, 0.05), (0.029, 0.05), 9), straight((0.05, 0.05), (0.05, 0.08), 30)),
                                   PANE)
        self.assertEqual(number, 1)
        np.testing.assert_allclose(found, 0.0, atol=1e-9)


class Doubled(unittest.TestCase):
    def test_two_lines_along_a_border_are_double_and_others_are_not(self) -> None:
        outer, inner = straight((0.02, 0.002), (0.06, 0.002), 40), straight((0.02, 0.004), (0.06, 0.004), 40)
        across = straight((0.08, 0.0), (0.08, 0.04), 40)
        self.assertAlmostEqual(doubled(graph(outer, inner, across), PANE), 2.0 / 3.0, places=6)
        self.assertEqual(doubled(graph(outer, across), PANE), 0.0)
        far = straight((0.02, 0.0052), (0.06, 0.0052), 40)  # 3.2 spacings beside it
        self.assertEqual(doubled(graph(outer, far), PANE), 0.0)
        inside = [straight((0.02, y), (0.06, y), 40) for y in (0.05, 0.052)]
        self.assertEqual(doubled(graph(*inside), PANE), 0.0)

    def test_the_border_of_a_disc_is_its_circle(self) -> None:
        angle = np.linspace(0.0, 1.0, 50)
        ring = np.column_stack([np.cos(angle), np.sin(angle)])
        self.assertEqual(doubled(graph(0.05 + 0.048 * ring, 0.05 + 0.046 * ring), DISC), 1.0)
        radial = straight((0.05, 0.05), (0.098, 0.05), 48)
        self.assertEqual(doubled(graph(radial, radial + np.array([0.0, 0.002])), DISC), 0.0)


if __name__ == "__main__":
    unittest.main()
