"""Gaps between borders that `sunder inspect` lists, and its picture of them."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from sunder_tools.command.inspect import gap_lines
from sunder_tools.errors import BAD_INPUT, CommandError
from sunder_tools.pictures.inspected import GAP, draw_inspected
from sunder_tools.report.gaps import gap_of_borders, gaps_of_edges


def edge(faces: list[int], points: list[list[float]]) -> dict[str, Any]:
    """An edge as sunder-shell lists it."""
    line = np.array(points)
    return {"faces": faces, "points_m": points, "tolerance_m": 0.0,
            "length_m": float(np.linalg.norm(line[1:] - line[:-1], axis=1).sum())}


class Gaps(unittest.TestCase):
    """Edges that run beside one another, and those that do not."""

    def test_free_edges_that_run_beside_one_another_are_a_gap_of_their_largest_distance(self) -> None:
        edges = [edge([0], [[0, 0, 0], [1, 0, 0]]), edge([1], [[0, 0.002, 0], [0.5, 0.003, 0], [1, 0.001, 0]]),
                 edge([2], [[0, 0.2, 0], [1, 0.2, 0]]), edge([0, 3], [[0, 0.001, 0], [1, 0.001, 0]]),
                 edge([4], [[0, 0, 0], [0, 0.001, 0]])]
        found = gaps_of_edges(edges, 0.01)
        assert found is not None
        self.assertEqual([gap.faces for gap in found], [(0, 1)])
        self.assertAlmostEqual(found[0].width_m, 0.003)
        self.assertAlmostEqual(found[0].at_m[0], 0.5)
        self.assertEqual(gaps_of_edges(edges, 0.0005), [])
        self.assertIsNone(gaps_of_edges(edges[:1] * 2001, 0.01))

    def test_a_longer_edge_beside_a_shorter_one_is_a_gap_too(self) -> None:
        edges = [edge([0], [[0, 0, 0], [3, 0, 0]]), edge([1], [[1, 0.01, 0], [2, 0.01, 0]])]
        found = gaps_of_edges(edges, 0.1)
        assert found is not None
        self.assertAlmostEqual(found[0].width_m, 0.01)

    def test_two_borders_of_a_mesh_are_a_gap_and_one_is_none(self) -> None:
        row = [[[k / 10, y, 0.0], [(k + 1) / 10, y, 0.0]] for y in (0.0,) for k in range(10)]
        beside = [[[k / 10, 0.004, 0.0], [(k + 1) / 10, 0.004, 0.0]] for k in range(10)]
        self.assertEqual(gap_of_borders(row), (0, None))
        found = gap_of_borders(row + beside)
        assert found is not None and found[1] is not None
        self.assertEqual(found[0], 22)
        self.assertAlmostEqual(found[1].width_m, 0.004)
        self.assertEqual(gap_of_borders([]), (0, None))

    def test_weld_is_offered_where_points_lie_opposite_points(self) -> None:
        def rows(shift: float, count: int = 10) -> list[list[list[float]]]:
            other = [shift + k / count for k in range(count + 1)]
            return [[[k / 10, 0.0, 0.0], [(k + 1) / 10, 0.0, 0.0]] for k in range(10)] + [
                [[a, 0.004, 0.0], [b, 0.004, 0.0]] for a, b in zip(other, other[1:])]

        def said(borders: list[list[list[float]]]) -> str:
            return gap_lines({"charts": [], "borders_m": borders})[0]

        self.assertIn("up to 0.004 m off", said(rows(0.0)))
        self.assertIn("--weld 0.0044 joins points that are so near", said(rows(0.0)))
        self.assertIn("--weld 0.0047", said(rows(0.0015)))
        shifted = said(rows(0.05))
        self.assertNotIn("--weld 0", shifted)
        self.assertIn("their points are up to 0.0502 m apart, so --weld does not join them: close it in the program that made the mesh",
                      shifted)
        self.assertNotIn("--weld 0", said(rows(0.0, 20)), "every second point has none opposite")

    def test_the_report_says_what_joins_them(self) -> None:
        told: dict[str, Any] = {"element_m": 0.02, "faces": [{"face": 0, "refused": None}, {"face": 1, "refused": None}],
                "edges": {"list": [edge([0], [[0, 0, 0], [1, 0, 0]]), edge([1], [[0, 0.002, 0], [1, 0.002, 0]])]}}
        self.assertIn("faces 0 and 1 nearly meet, up to 0.002 m apart", gap_lines(told)[0])
        self.assertIn("tolerance_m: 0.0022", gap_lines(told)[0])
        with tempfile.TemporaryDirectory() as folder:
            target = Path(folder) / "a.png"
            found = gaps_of_edges(told["edges"]["list"], 0.01)
            assert found is not None
            draw_inspected(Path(folder), told, found, target)
            shown = np.asarray(Image.open(target).convert("RGB")).reshape(-1, 3).astype(int)
        self.assertTrue((np.abs(shown - np.array(GAP)).max(axis=1) < 8).any())

    def test_a_closed_mesh_that_is_refused_leaves_nothing_to_draw(self) -> None:
        told = {"charts": [], "borders_m": [], "refused": "it is closed"}
        with tempfile.TemporaryDirectory() as folder:
            target = Path(folder) / "a.png"
            with self.assertRaisesRegex(CommandError, "a.png: there is nothing to draw.*leave --picture out") as refused:
                draw_inspected(Path(folder), told, [], target)
            self.assertFalse(target.exists())
        self.assertEqual(refused.exception.status, BAD_INPUT)


if __name__ == "__main__":
    unittest.main()
