"""Files of meshes whose answers are known: what is written, and what is made of frequencies."""
from __future__ import annotations

import math
import unittest

import numpy as np

from sunder_tools.errors import CommandError
from tests.validation import mesh_files
from tests.validation.mesh_files import below_order, elastic, obj_text, order_of, quad_sphere, sphere, tube, tube_off


class MeshFiles(unittest.TestCase):
    def test_the_sphere_is_of_quads_only_each_edge_of_two(self) -> None:
        points, quads = quad_sphere(0.2, 4)
        self.assertEqual((len(points), len(quads)), (6 * 4 * 4 + 2, 6 * 4 * 4))
        lines = obj_text(points, quads).splitlines()
        self.assertEqual({len(line.split()) for line in lines if line.startswith("f ")}, {5})
        edges = [(face[k], face[(k + 1) % 4]) for face in quads for k in range(4)]
        self.assertEqual(len(edges), len(set(edges)))  # neighbours turn alike
        self.assertEqual({(b, a) for a, b in edges}, set(edges))
        self.assertTrue(np.allclose(np.linalg.norm(points, axis=1), 0.2, rtol=1e-14, atol=0.0))
        for face in quads:
            a, b, c = (points[k] for k in face[:3])
            self.assertGreater(float(np.cross(b - a, c - a) @ a), 0.0)

    def test_the_tube_is_open_and_turns_alike(self) -> None:
        lines = tube_off(0.2, 0.5, 12, 3).splitlines()
        self.assertEqual(lines[1], f"{12 * 4} {2 * 12 * 3} 0")
        faces = [[int(word) for word in line.split()[1:]] for line in lines[2 + 12 * 4:]]
        edges = [(face[k], face[(k + 1) % 3]) for face in faces for k in range(3)]
        self.assertEqual(len(edges), len(set(edges)))
        self.assertEqual(sum((b, a) not in set(edges) for a, b in edges), 2 * 12)

    def test_references_are_those_of_the_formulas(self) -> None:
        self.assertAlmostEqual(sphere().area, 0.16 * math.pi, places=14)
        # a ring of n = 2 in its plane: 6/sqrt(5) sqrt(E h^2/(12 rho (1 - nu^2)))/R^2
        speed = math.sqrt(2e11 * 1e-6 / (12.0 * 7800.0 * 0.91))
        self.assertAlmostEqual(tube().frequencies[0] / (6.0 / math.sqrt(5.0) * speed / 0.04 / (2.0 * math.pi)), 1.0, places=14)
        self.assertGreater(tube().frequencies[2], tube().frequencies[0])

    def test_the_order_of_a_sequence(self) -> None:
        self.assertAlmostEqual(order_of([1.0 + 0.08, 1.0 + 0.04, 1.0 + 0.02]), 2.0, places=12)
        self.assertAlmostEqual(order_of([1.0 - 0.08, 1.0 - 0.02, 1.0 - 0.005]), 4.0, places=12)
        self.assertTrue(math.isnan(order_of([2.0, 1.0, 1.0])))

    def test_an_order_is_asked_of_what_has_not_settled(self) -> None:
        self.assertEqual(below_order([100.08, 100.04, 100.02]), 0.0)  # of order 2
        self.assertAlmostEqual(below_order([100.4, 100.2, 100.0]), 1.75, places=9)  # of none
        self.assertGreater(below_order([100.0, 100.003, 100.02]), 1.75)  # it moves more and more
        self.assertEqual(below_order([100.0, 100.003, 100.009]), 0.0)  # so little that it has settled
        self.assertTrue(math.isnan(below_order([101.0, 100.0, 100.0])))

    def test_rigid_motions_and_unstable_modes_are_left_out(self) -> None:
        modes = [{"frequency_Hz": x} for x in (None, 1e-4, 0.02, 50.0, 51.0, 53.0, 52.0, 60.0)]
        self.assertEqual(elastic(modes, 50.0), [50.0, 51.0, 52.0, 53.0])
        with self.assertRaisesRegex(CommandError, "2 modes above a tenth of 50 Hz, 4 are needed"):
            elastic(modes[:5], 50.0)

    def test_spacings_are_finer_by_the_root_of_two(self) -> None:
        for exact, middle in ((sphere(), mesh_files.SPACING), (tube(), mesh_files.TUBE_SPACING)):
            self.assertAlmostEqual(exact.spacings[1], middle, places=15)
            for coarse, fine in zip(exact.spacings, exact.spacings[1:]):
                self.assertAlmostEqual(coarse / fine, math.sqrt(2.0), places=12)


if __name__ == "__main__":
    unittest.main()
