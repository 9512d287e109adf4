"""Soft bodies in pictures and exported meshes: balls on the particles at the surface."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import numpy as np

from sunder_tools.pictures.frames import SOFT, Frame
from sunder_tools.pictures.look import Look
from sunder_tools.pictures.meshes import load_scene
from sunder_tools.pictures.raster import perspective_camera
from sunder_tools.pictures.soft import FIRST, OVERLAP, balls, with_soft
from sunder_tools.pictures.views import draw_scene

from .synthetic import write_vtp


class Soft(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        path = Path(temporary.name) / "soft.vtp"
        points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1], [0.1, 0.0, 0.1]])  # the first lies within
        write_vtp(path, points, point_data={
            "velocity": np.array([[0.0, 0, 0], [0, 0, 2], [0, 0, 4]]), "radius": np.full(3, 0.05), "J": np.ones(3),
            "surface": np.array([0.0, 1.0, 1.0]), "normal": np.array([[0.0, 0, 0], [0, 0, 2], [1, 0, 1]]),
            "soft_body": np.array([0.0, 0.0, 1.0])}, floats="f8")
        self.frame = Frame(0.0, {SOFT: path})

    def test_particles_at_the_surface_become_balls(self) -> None:
        mesh = self.frame.read(SOFT)
        assert mesh is not None
        points, triangles, particle, normals = balls(mesh)
        self.assertEqual((len(points), len(triangles)), (24, 40))
        self.assertEqual(set(particle), {1, 2})
        np.testing.assert_allclose(np.linalg.norm(points[:12] - mesh.points[1], axis=1), OVERLAP * 0.05)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
        corner = points[triangles]
        outward = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        self.assertTrue((np.einsum("ij,ij->i", outward, corner.mean(axis=1) - mesh.points[particle]) > 0.0).all())

    def test_they_are_in_the_picture(self) -> None:
        scene = load_scene(self.frame, Look())
        self.assertEqual(len(scene.moving), 24)
        camera = perspective_camera(scene.moving.min(axis=0), scene.moving.max(axis=0), np.array([0.0, 1.0, -0.2]), 80, 60)
        picture = draw_scene(scene, camera, 80, 60)
        empty = draw_scene(load_scene(Frame(0.0, {}), Look()), camera, 80, 60)
        self.assertGreater((np.abs(picture - empty).max(axis=2) > 0.1).mean(), 0.2)

    def test_they_are_exported_as_bodies_that_move(self) -> None:
        bodies, velocity = with_soft(self.frame, None, np.zeros((0, 3)))
        assert bodies is not None
        self.assertEqual(set(bodies.of_triangles("body", 0)), {FIRST, FIRST + 1})
        np.testing.assert_array_equal(velocity[[0, 23]], [[0, 0, 2], [0, 0, 4]])
        more, velocity = with_soft(self.frame, bodies, velocity)
        assert more is not None
        self.assertEqual((len(more.points), len(more.triangles), len(velocity)), (48, 80, 48))


if __name__ == "__main__":
    unittest.main()
