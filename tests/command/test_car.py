"""The car and the tree: what their scripts make is what the scenes have, and what is wrong with a car is found."""
from __future__ import annotations

import dataclasses
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

from . import REPOSITORY

SCENES = REPOSITORY / "scenes"
sys.path.append(str(SCENES))
import make_car  # noqa: E402
import make_tree  # noqa: E402
from car_shape import SPANS, car  # noqa: E402
from splines import basis, open_knots, refined  # noqa: E402
from step_file import write_step  # noqa: E402

COARSE = dict(SPANS)
FINE = {chain: 3 * spans for chain, spans in SPANS.items()} | {"roof": 2 * SPANS["roof"]}


def faults(patches: list, counts: dict[str, int] = COARSE) -> str:
    return "\n".join(make_car.faults(patches, make_car.find_seams(patches, counts)))


def changed(name: str, net) -> list:
    """The car with another net, a function of its own, for one patch."""
    return [dataclasses.replace(p, net=net(p.net.copy())) if p.name == name else p for p in car()]


class Scenes(unittest.TestCase):
    def test_are_what_the_scripts_make(self) -> None:
        made = [p for p in sorted(SCENES.rglob("*.textproto")) if "# begin car" in p.read_text()]
        self.assertEqual([p.stem for p in made], ["falling_tree", "falling_tree_small", "impactor", "impactor_small", "fig01"])
        with tempfile.TemporaryDirectory() as folder:
            for scene in made:
                copy = Path(shutil.copy(scene, folder))
                (spacing,) = re.findall(r"^# begin car: made by make_car.py --spacing (\S+)$", scene.read_text(), re.M)
                # what stood there must not matter
                copy.write_text(re.sub(r"(?s)(# begin car).*?(# end car)", r"\1\n\2", copy.read_text()))
                subprocess.run([sys.executable, "-B", SCENES / "make_car.py", "--spacing", spacing, copy], check=True,
                               stdout=subprocess.DEVNULL)
                if "# begin tree" in scene.read_text():
                    (notch,) = re.findall(r"^# begin tree: made by make_tree.py(?: --notch (\S+))?$", scene.read_text(), re.M)
                    notch_deg = float(notch) if notch else None
                    make_tree.replace_part(copy, "tree", make_tree.made_by(notch_deg), make_tree.scene_text(notch_deg))
                self.assertEqual(copy.read_text(), scene.read_text(), f"{scene.name}: run its scripts again")
        for piece in make_tree.tree():
            for place in (SCENES, SCENES / "paper"):
                self.assertEqual((place / f"tree_{piece.name}.off").read_text(), make_tree.off_text(piece))

    def test_a_scene_without_a_place_for_the_car_is_left_alone(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder) / "scene.textproto"
            scene.write_text('name: "a"\n# end car\n# begin car\n')
            with self.assertRaisesRegex(ValueError, "'# begin car'"):
                make_car.replace_part(scene, "car", "", ["shells {}"])
            self.assertNotIn("shells", scene.read_text())


class Car(unittest.TestCase):
    def test_is_in_order_as_coarse_and_as_refined_unevenly(self) -> None:
        for counts in (COARSE, FINE):
            seams = make_car.find_seams(car(), counts)
            self.assertEqual(make_car.faults(car(), seams), [])
            self.assertEqual(len(seams), 21)
            self.assertEqual(sum(seam.smooth for seam in seams), 4)

    def test_is_as_large_as_a_car(self) -> None:
        points = np.concatenate([make_car.sampled(p, np.linspace(0, SPANS[p.chain_u], 50), np.linspace(
            0, SPANS[p.chain_v], 50))[0].reshape(-1, 3) for p in car()])
        length, width, height = np.ptp(points, axis=0)
        self.assertAlmostEqual(length, 4.2, delta=0.1)
        self.assertAlmostEqual(width, 1.75, delta=0.05)
        self.assertAlmostEqual(points[:, 2].max(), 1.45, delta=0.05)
        self.assertGreater(points[:, 2].min(), 0.15)  # clear of the ground, on which wheels would stand

    def test_left_is_left_of_who_drives_forwards(self) -> None:
        names = {patch.name: patch.net.reshape(-1, 3).mean(axis=0) for patch in car()}
        forwards = names["front_bumper"] - names["tailgate"]
        for part in ("wing", "side", "greenhouse"):
            to_the_left = names[f"left_{part}"] - names[f"right_{part}"]
            self.assertGreater(np.cross([0.0, 0.0, 1.0], forwards) @ to_the_left, 0.0)

    def test_a_missing_patch_is_noticed(self) -> None:
        self.assertIn("11 patches", faults(car()[1:]))

    def test_sides_that_part_are_noticed(self) -> None:
        def parted(net):
            net[3, 0] += [1e-9, 0.0, 0.0]
            return net
        self.assertIn("1e-09 m apart", faults(changed("roof", parted)))

    def test_corners_that_part_are_noticed(self) -> None:
        def moved(net):
            net[0, 0] += [1e-3, 0.0, 0.0]
            return net
        self.assertIn("do not meet fully", faults(changed("roof", moved)))

    def test_a_normal_that_points_inwards_is_noticed(self) -> None:
        self.assertIn("bonnet: the normal points into the car", faults(changed("bonnet", lambda net: net[::-1])))

    def test_a_smooth_seam_that_is_smooth_no_more_is_noticed(self) -> None:
        def bent(net):
            net[:, -2] += [0.0, 1e-4, 0.0]
            return net
        self.assertIn("is it meant to be smooth", faults(changed("left_wing", bent)))

    def test_sides_that_are_no_mirror_images_are_noticed(self) -> None:
        def swollen(net):
            net[3, 3] += [0.0, 0.01, 0.0]
            return net
        self.assertIn("mirror", faults(changed("left_side", swollen)))

    def test_a_collapsed_side_is_noticed(self) -> None:
        def collapsed(net):
            net[0] = net[0, 0]
            return net
        with np.errstate(invalid="ignore"):
            self.assertIn("parameter lines meet", faults(changed("windscreen", collapsed)))

    def test_step_file_has_each_face_edge_and_corner_once_and_is_the_same_again(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "car.step"
            write_step(file, car())
            text = file.read_text()
            count = {word: len(re.findall(rf"={word}\(", text)) for word in (
                "ADVANCED_FACE", "EDGE_CURVE", "ORIENTED_EDGE", "VERTEX_POINT")}
            self.assertEqual(count, {"ADVANCED_FACE": 12, "EDGE_CURVE": 27, "ORIENTED_EDGE": 48, "VERTEX_POINT": 16})
            defined = re.findall(r"^#(\d+)=", text, re.M)
            self.assertEqual(len(defined), len(set(defined)))
            self.assertLessEqual(set(re.findall(r"#(\d+)", text)), set(defined))
            write_step(file, car())
            self.assertEqual(file.read_text(), text)


class Splines(unittest.TestCase):
    def test_refining_leaves_a_curve_where_it_was(self) -> None:
        rows, at = np.random.default_rng(1).normal(size=(7, 3)), np.linspace(0.0, 5.0, 41)
        knots = open_knots(5)
        fine_knots, fine = refined(knots, rows, 13)  # 2.6 a span: three, so 15
        self.assertEqual(len(fine), 17)
        for coarse, new in zip(basis(knots, at), basis(fine_knots, at)):
            np.testing.assert_allclose(new @ fine, coarse @ rows, atol=1e-13)  # round-off of ten insertions


class Tree(unittest.TestCase):
    def test_a_prism_has_the_mass_of_a_prism(self) -> None:
        n, radius, length = make_tree.CORNERS, 0.2, 3.0
        piece = make_tree.Piece("log", np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.0 + length]), (radius, radius))
        mass, centre, second = piece.mass_properties()
        area = 0.5 * n * radius ** 2 * np.sin(2.0 * np.pi / n)
        self.assertAlmostEqual(mass / (make_tree.DENSITY * area * length), 1.0, places=5)  # corners to a micrometre
        np.testing.assert_allclose(centre, [1.0, 2.0, 4.5], atol=1e-6)
        self.assertAlmostEqual(second[2, 2] / mass - 4.5 ** 2, length ** 2 / 12.0, places=6)

    def test_every_part_starts_as_a_rigid_tree_that_turns_about_its_foot(self) -> None:
        text = "\n".join(make_tree.scene_text())
        rotation, axis, speed = make_tree.start()
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
        stem = rotation @ [0.0, 0.0, 1.0]
        towards = make_tree.TARGET - make_tree.FOOT[:2]
        self.assertAlmostEqual(np.degrees(np.arccos(stem[2])), make_tree.LEAN_DEG)
        np.testing.assert_allclose(stem[:2] / np.linalg.norm(stem[:2]), towards / np.linalg.norm(towards))
        self.assertGreater(np.cross(speed * axis, stem)[:2] @ towards, 0.0)  # falls on, not back
        w, x, y, z = make_tree.quaternion(rotation)
        turned = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
        np.testing.assert_allclose(turned, stem, atol=1e-12)
        self.assertEqual(text.count("bodies {"), len(make_tree.tree()))
        self.assertEqual(text.count("kind: FIXED"), len(make_tree.tree()) - 1)
        self.assertEqual(text.count("kind: HINGE"), 1)


if __name__ == "__main__":
    unittest.main()
