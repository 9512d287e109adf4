"""Shards as they are drawn: shading, centre of mass, and crack lines that lie where the shell is."""
from __future__ import annotations

import unittest

import numpy as np

from sunder_lab.scene import Results
from sunder_lab.tracks import tracks
from sunder_tools.pictures.meshes import _shaded_shards, lines_in_place
from sunder_tools.pictures.rigid import centre_of, centre_of_mass
from sunder_tools.pictures.thick import sheet_points, sheet_topology
from sunder_tools.pictures.vtp import PolyData

from .synthetic import write_vtp
from .test_view import InAFolder


def arc(angle: float, parts: int = 24, radius: float = 0.05, thickness: float = 0.004) -> tuple[np.ndarray, np.ndarray]:
    """A thick strip of a tube as the shell process writes it: points in pairs, inside before outside."""
    turn = np.linspace(-0.5 * angle, 0.5 * angle, parts + 1)
    middle = np.concatenate([np.stack([radius * np.sin(turn), np.full_like(turn, y), radius * np.cos(turn)], 1)
                             for y in (0.0, 0.02)])
    a = np.arange(parts)
    triangles = np.concatenate([np.stack([a, a + 1, a + parts + 2], 1), np.stack([a, a + parts + 2, a + parts + 1], 1)])
    return sheet_points(middle, triangles, np.full(len(middle), thickness)), sheet_topology(triangles)[0]


class Shards(unittest.TestCase):
    def test_both_faces_are_smooth_and_the_edge_is_flat(self) -> None:
        points, triangles = arc(1.5)
        other = len(points)
        both = np.concatenate([points, points + np.array([1.0, 0.0, 0.0])])
        body = np.repeat([7, 9], len(triangles))
        drawn, corners, smooth, _ = _shaded_shards(both, np.concatenate([triangles, triangles + other]), body)
        self.assertTrue(np.array_equal(drawn[corners], both[np.concatenate([triangles, triangles + other])]))
        odd = (np.concatenate([triangles, triangles]) % 2).sum(axis=1)
        outside, inside, edge = smooth[corners[odd == 3]], smooth[corners[odd == 0]], smooth[corners[(odd == 1) | (odd == 2)]]
        self.assertFalse(edge.any())
        for normals, where, sign in ((outside, odd == 3, 1.0), (inside, odd == 0, -1.0)):
            radial = drawn[corners[where]] - np.where(body[where] == 9, 1.0, 0.0)[:, None, None] * np.array([1.0, 0.0, 0.0])
            radial[:, :, 1] = 0.0
            radial /= np.linalg.norm(radial, axis=2, keepdims=True)
            self.assertGreater((sign * normals * radial).sum(axis=2).min(), 0.998)

    def test_a_fold_stays_sharp(self) -> None:
        points, triangles = arc(3.0, parts=2)  # two flat halves that turn by 86 degrees
        _, corners, smooth, _ = _shaded_shards(points, triangles, np.zeros(len(triangles), int))
        self.assertFalse(smooth[corners].any())

    def test_the_mass_lies_on_the_middle_surface(self) -> None:
        points, triangles = arc(1.5)
        wanted = 0.05 * np.sin(0.75) / 0.75  # of the mean of the radius times the cosine
        self.assertAlmostEqual(centre_of_mass(points, triangles)[2], wanted, delta=1e-3 * wanted)
        self.assertGreater(centre_of(points, triangles)[2] - centre_of_mass(points, triangles)[2], 1e-5)  # h^2 / (12 R)
        flat, faces = points * np.array([1.0, 1.0, 0.0]), triangles  # without inside: the mean of its points
        self.assertTrue(np.isfinite(centre_of_mass(flat, faces)).all())


class Tracks(InAFolder):
    def test_a_track_is_at_the_centre_of_mass(self) -> None:
        """As shards.csv has it, whichever body stands first in the frame; the floor is no piece."""
        points, triangles = arc(1.5)
        floor, square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]), np.array([[0, 1, 2], [0, 2, 3]])
        (self.folder / "frames").mkdir()
        (self.folder / "run.json").write_text('{"schema": 2, "status": "done"}')
        bodies = [(7, 1, points + [0.3, 0, 0], triangles), (1, 2, floor, square), (9, 3, points + [0.6, 0, 0], triangles)]
        start = np.cumsum([0, *(len(p) for _, _, p, _ in bodies)])
        write_vtp(self.folder / "frames/bodies.vtp", np.concatenate([p for _, _, p, _ in bodies]),
                  np.concatenate([t + at for (_, _, _, t), at in zip(bodies, start)]), floats="f8", cell_data={
                      name: np.concatenate([np.full(len(body[3]), float(body[k])) for body in bodies]) for k, name in enumerate(("body", "kind"))})
        (self.folder / "frames.pvd").write_text(
            '<VTKFile><Collection><DataSet timestep="0.5" part="2" file="frames/bodies.vtp"/></Collection></VTKFile>')
        found = tracks(Results(self.folder))
        self.assertEqual(set(found), {7, 9})
        for one, x in ((7, 0.3), (9, 0.6)):
            self.assertEqual((found[one].time, len(found[one].area)), ([0.5], 1))
            np.testing.assert_allclose(found[one].centre[0], centre_of_mass(points, triangles) + [x, 0, 0], atol=1e-12)
            self.assertGreater(float(np.linalg.norm(found[one].centre[0] - centre_of(points, triangles) - [x, 0, 0])), 1e-5)


class Lines(unittest.TestCase):
    def lines(self, carried: float = 0.0) -> PolyData:
        return PolyData(np.zeros((6, 3)), line_points=np.arange(6), line_bounds=np.array([0, 2, 4, 6]),
                        point_data={"displacement": np.full((6, 3), carried)},
                        cell_data={"shell": np.array([0.0, 1.0, 2.0])})

    def shell(self) -> PolyData:  # shell 0 has moved, shell 1 is at rest, and shell 2 is gone
        displacement = np.zeros((6, 3))
        displacement[1, 2] = 1e-3
        return PolyData(np.zeros((6, 3)), triangles=np.array([[0, 1, 2], [3, 4, 5]]),
                        point_data={"displacement": displacement}, cell_data={"shell": np.array([0.0, 1.0])})

    def test_those_of_a_shell_that_has_moved_are_left_out(self) -> None:
        self.assertEqual(lines_in_place(self.lines(), self.shell()).tolist(), [[2, 3]])

    def test_those_that_move_with_their_shell_stay(self) -> None:
        self.assertEqual(len(lines_in_place(self.lines(1e-6), self.shell())), 3)

    def test_without_a_shell_they_stay(self) -> None:
        self.assertEqual(len(lines_in_place(self.lines(), None)), 3)


if __name__ == "__main__":
    unittest.main()
