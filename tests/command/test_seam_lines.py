"""Pictures have no line where a shell goes on as another, though the points of their borders do not match."""
from __future__ import annotations

import unittest

import numpy as np

from sunder_tools.pictures.meshes import fragment_edges
from sunder_tools.pictures.vtp import PolyData

HEIGHT = 1.0
ARC = 20.0  # radius of the seam [m]


def seam(y: np.ndarray) -> np.ndarray:
    """x of the seam at the height y: both shells follow it with their own chords."""
    return ARC - np.sqrt(ARC * ARC - (y - 0.5 * HEIGHT) ** 2)


class SeamLines(unittest.TestCase):
    """A shell of 7 rows to the left of a curved seam, and one of 10 or 7 rows to its right."""

    def mesh(self, fragments: tuple[int, int] = (0, 0), shells: tuple[int, int] = (0, 1), apart: float = 0.0,
             right: int = 10, slivers: int = 0) -> PolyData:
        points: list[np.ndarray] = []
        triangles: list[np.ndarray] = []
        count: list[int] = []
        for rows, far in ((7, -0.1), (right, 0.1)):
            y, first = np.linspace(0.0, HEIGHT, rows + 1), sum(map(len, points))
            points += [np.column_stack([x, y, 0.0 * y]) for x in (np.full(rows + 1, far), seam(y))]
            k = first + np.arange(rows)
            triangles += [np.stack([k, k + rows + 1, k + 1], axis=1), np.stack([k + 1, k + rows + 1, k + rows + 2], axis=1)]
            count.append(2 * rows)
        for sliver in range(slivers):  # small pieces of the first shell, far off, of which each has three lines
            first = sum(map(len, points))
            points.append(np.array([[5.0 + sliver, 0, 0], [5.001 + sliver, 0, 0], [5.0 + sliver, 0.001, 0]]))
            triangles.append(np.array([[first, first + 1, first + 2]]))
        rest = np.concatenate(points)
        moved = np.zeros_like(rest)
        moved[16:16 + 2 * (right + 1), 0] = apart
        return PolyData(rest + moved, triangles=np.concatenate(triangles), point_data={"displacement": moved}, cell_data={
            "fragment": np.concatenate([np.repeat(fragments, count), 50 + np.arange(slivers)]),
            "shell": np.concatenate([np.repeat(shells, count), np.full(slivers, shells[0])])})

    def seam_lines(self, mesh: PolyData, right: int = 10, slivers: int = 0) -> int:
        """Number of lines drawn along the seam; all other borders have to be there."""
        ends = (mesh.points - mesh.point_data["displacement"])[fragment_edges(mesh)]
        along = (np.abs(ends[:, :, 0]) < 0.05).all(axis=1)
        self.assertEqual(int((~along).sum()), 7 + right + 4 + 3 * slivers)
        return int(along.sum())

    def test_a_seam_that_holds_is_not_drawn(self) -> None:
        for right in (7, 10):  # points that match, and points that do not
            self.assertEqual(self.seam_lines(self.mesh(right=right), right), 0)

    def test_small_pieces_elsewhere_change_nothing(self) -> None:
        self.assertEqual(self.seam_lines(self.mesh(slivers=40), slivers=40), 0)

    def test_a_seam_that_has_opened_is_drawn_on_both_sides(self) -> None:
        for right in (7, 10):
            for apart in (0.02, 0.5):  # lines are 0.1 and 0.14 m long
                self.assertEqual(self.seam_lines(self.mesh(apart=apart, right=right), right), 7 + right)

    def test_a_border_of_fragments_is_drawn(self) -> None:
        self.assertEqual(self.seam_lines(self.mesh(fragments=(3, 4))), 7 + 10)

    def test_a_crack_within_a_shell_is_drawn(self) -> None:
        self.assertEqual(self.seam_lines(self.mesh(shells=(2, 2))), 7 + 10)


if __name__ == "__main__":
    unittest.main()
