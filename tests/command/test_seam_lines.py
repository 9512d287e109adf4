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
    """A shell of 7 rows to the left of a curved seam, and one of 10 rows to its right."""

    def mesh(self, fragments: tuple[int, int] = (0, 0), shells: tuple[int, int] = (0, 1), apart: float = 0.0) -> PolyData:
        y = {rows: np.linspace(0.0, HEIGHT, rows + 1) for rows in (7, 10)}
        parts = []
        for rows, far in ((7, -0.1), (10, 0.1)):
            border = np.column_stack([np.full(rows + 1, far), y[rows], np.zeros(rows + 1)])
            parts.append(np.concatenate([border, np.column_stack([seam(y[rows]), y[rows], np.zeros(rows + 1)])]))
        triangles = []
        for rows, first in ((7, 0), (10, 16)):
            k = first + np.arange(rows)
            triangles.append(np.concatenate([np.stack([k, k + rows + 1, k + 1], axis=1),
                                             np.stack([k + 1, k + rows + 1, k + rows + 2], axis=1)]))
        rest = np.concatenate(parts)
        moved = np.concatenate([np.zeros((16, 3)), np.tile([apart, 0.0, 0.0], (22, 1))])
        return PolyData(rest + moved, triangles=np.concatenate(triangles), point_data={"displacement": moved},
                        cell_data={"fragment": np.repeat(fragments, (14, 20)), "shell": np.repeat(shells, (14, 20))})

    def seam_lines(self, mesh: PolyData) -> int:
        """Number of lines drawn along the seam; all other borders have to be there."""
        ends = (mesh.points - mesh.point_data["displacement"])[fragment_edges(mesh)]
        along = (np.abs(ends[:, :, 0]) < 0.05).all(axis=1)
        self.assertEqual(int((~along).sum()), 7 + 10 + 4)
        return int(along.sum())

    def test_a_seam_that_holds_is_not_drawn(self) -> None:
        self.assertEqual(self.seam_lines(self.mesh()), 0)

    def test_a_seam_that_has_opened_is_drawn_on_both_sides(self) -> None:
        self.assertEqual(self.seam_lines(self.mesh(apart=0.05)), 7 + 10)

    def test_a_border_of_fragments_is_drawn(self) -> None:
        self.assertEqual(self.seam_lines(self.mesh(fragments=(3, 4))), 7 + 10)

    def test_a_crack_within_a_shell_is_drawn(self) -> None:
        self.assertEqual(self.seam_lines(self.mesh(shells=(2, 2))), 7 + 10)


if __name__ == "__main__":
    unittest.main()
