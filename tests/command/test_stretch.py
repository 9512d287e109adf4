"""Stretch of a sheet from one frame of it."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import numpy as np
from PIL import Image

from sunder_tools.pictures.strain import principal_stretch
from sunder_tools.pictures.vtp import PolyData
from tests.validation import stretch

REST = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def moved(gradient: np.ndarray) -> stretch.Stretched:
    """A unit square, two triangles of it, under x = F X."""
    points = REST @ gradient.T
    mesh = PolyData(points=points, triangles=TRIANGLES)
    mesh.point_data["displacement"] = points - REST
    return stretch.Stretched(1.0, mesh, principal_stretch(mesh), 1.0)


class Stretch(unittest.TestCase):
    def test_is_the_largest_singular_value_however_the_sheet_is_turned(self) -> None:
        turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        for gradient in (np.eye(3), np.diag([0.5, 2.5, 1.0]), np.array([[1.0, 0.8, 0], [0, 1.3, 0], [0, 0, 1.0]])):
            known = np.linalg.svd(gradient[:2, :2], compute_uv=False)[0]
            np.testing.assert_allclose(moved(turn @ gradient).stretch, known, rtol=1e-7)  # root of a difference

    def test_area_beyond_and_slivers(self) -> None:
        one = moved(np.diag([1.5, 1.0, 1.0]))
        self.assertAlmostEqual(one.largest(), 1.5)
        self.assertAlmostEqual(one.beyond(1.3), 1.0)
        self.assertEqual(one.beyond(1.6), 0.0)
        self.assertFalse(stretch.Stretched(1.0, one.shell, one.stretch, 10.0).counted().any())

    def test_the_picture_is_red_where_it_is_stretched(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "stretch.png"
            stretch.write_stretched([("calm", moved(np.eye(3))), ("far", moved(np.diag([4.0, 1.0, 1.0])))], path)
            with Image.open(path) as image:
                self.assertEqual(image.width, 2 * (stretch.WIDTH + stretch.GAP) + stretch.GAP)
                pixels = np.asarray(image).reshape(-1, 3)
        for colour in (stretch.CALM, stretch.FAR):
            self.assertLess(np.abs(pixels - colour * 255).max(axis=1).min(), 1.5)


if __name__ == "__main__":
    unittest.main()
