"""Point caches of a run: bytes read back by another reader, the same things in the same places as in the animated glTF."""
from __future__ import annotations

import contextlib
import csv
import io
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from sunder_tools.pictures import one_file
from sunder_tools.pictures.frames import list_frames
from sunder_tools.pictures.pc2 import COLUMNS, caches_of
from sunder_tools.pictures.story import Thing, story_of

from .mesh_files import Animated, read_obj, read_pc2
from .synthetic import BALL_RADIUS_M, HEIGHT_M
from .test_animated import SCENE, SINGLE, Parting
from .test_render import OfARun


class Folder:
    """What an export has written."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with (folder / "objects.csv").open(newline="") as file:
            self.rows = list(csv.DictReader(file))
        self.meshes = {row["object"]: read_obj((folder / f"{row['object']}.obj").read_text()) for row in self.rows}
        self.caches = {row["object"]: read_pc2((folder / f"{row['object']}.pc2").read_bytes()) for row in self.rows}

    def points(self, name: str, frame: int) -> np.ndarray:
        """Points (n, 3) of an object in a frame, as a reader has them that holds the first and the last sample; z up."""
        start, rate, samples = self.caches[name]
        assert rate == 1.0
        return samples[int(np.clip(frame - start, 0, len(samples) - 1))][:, [0, 2, 1]] * [1, -1, 1]

    def seen(self, thing: str, frame: int) -> dict[str, np.ndarray]:
        """Corners (m, 3, 3) of a thing by material, of the objects that are not drawn together into a point."""
        found: dict[str, list[np.ndarray]] = {}
        for row in self.rows:
            points = self.points(row["object"], frame)
            if row["name"] == thing and np.ptp(points, axis=0).any():
                for material, triangles in self.meshes[row["object"]]["f"].items():
                    found.setdefault(material, []).append(points[triangles])
        return {material: np.concatenate(parts) for material, parts in found.items()}


class Written(Parting):
    """The caches of a plate from which a piece parts."""

    def setUp(self) -> None:
        super().setUp()
        (self.folder / "run.json").write_text('{"schema": 1}')
        (self.folder / "scene_as_run.textproto").write_text(SCENE)
        self.written = self.export("caches")

    def export(self, name: str) -> Folder:
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(one_file.export_one(self.folder, "pc2", self.folder / name, None, None, None, False), 0)
        return Folder(self.folder / name)


class HandOff(Written):
    def test_things_are_where_the_animated_file_has_them(self) -> None:
        """Also those that are not there yet or any more."""
        for name in ("pane_piece_1", "pane_piece_2"):
            for k in range(6):
                mine, wanted = self.written.seen(name, k), self.film.seen(name, float(k))
                self.assertEqual(set(mine), set(wanted), f"{name} in frame {k}")
                for material, corners in wanted.items():
                    np.testing.assert_allclose(mine[material], corners, atol=SINGLE)
        self.assertEqual(self.film.seen("pane_piece_2", 1.0), {})  # it begins with frame 2

    def test_the_table_names_every_object(self) -> None:
        rows = {row["object"]: row for row in self.written.rows}
        self.assertEqual(list(rows), [f"pane_piece_{p}_shape_{s}" for p, s in ((1, 0), (1, 1), (2, 0), (2, 1))])
        self.assertEqual({row["shell"] for row in rows.values()}, {"pane"})
        body = rows["pane_piece_2_shape_1"]  # the shard: there from frame 3 to the last, and drawn together in frame 2
        self.assertEqual([body[c] for c in ("name", "start", "samples", "first_frame", "last_frame", "points", "triangles")],
                         ["pane_piece_2", "2", "4", "3", "5", "36", "12"])
        for name, row in rows.items():
            start, _, samples = self.written.caches[name]
            self.assertEqual([int(start), *samples.shape[:2]], [int(row[column]) for column in ("start", "samples", "points")])
            self.assertEqual(sum(map(len, self.written.meshes[name]["f"].values())), int(row["triangles"]))

    def test_a_mesh_is_a_sample_of_its_cache(self) -> None:
        for row in self.written.rows:
            mesh, (start, _, samples) = self.written.meshes[row["object"]], self.written.caches[row["object"]]
            self.assertEqual((mesh["name"], mesh["mtllib"]), (row["object"], "materials.mtl"))
            np.testing.assert_array_equal(mesh["v"].astype("f4"), samples[int(row["first_frame"]) - int(start)].astype("f4"))
            np.testing.assert_allclose(np.linalg.norm(mesh["vn"], axis=1), 1.0, atol=1e-5)
            outside = mesh["f"]["glass_outside"]
            np.testing.assert_allclose(mesh["vn"][outside.ravel()], [[0, 1, 0]] * outside.size, atol=1e-5)  # the plate lies flat
        said = (self.written.folder / "materials.mtl").read_text()
        for material in ("glass_outside", "glass_inside", "glass_edge"):
            self.assertRegex(said, rf"newmtl {material}\nKd [\d. ]+\nd 0\.5\n")

    def test_long_shapes_are_not_cut(self) -> None:
        """Morph targets have a limit, caches have none."""
        with mock.patch.object(one_file, "MOST_STEPS", 1):
            self.assertEqual(self.export("more").rows, self.written.rows)
        cut = story_of(self.frames, self.words, {}, most_steps=1)
        self.assertGreater(sum(len(thing.shapes) for thing in cut), len(self.written.rows))

    def test_names_suit_every_file_system(self) -> None:
        shape = story_of(self.frames, self.words, {})[0].shapes[0]
        things = [Thing(name, "", [0, 1], [np.zeros(3)] * 2, [np.array([0, 0, 0, 1.0])] * 2, [shape]) for name in (
            "ball", "Ball", "../ball", "2 balls")]
        self.assertEqual([cache.name for cache in caches_of(things, 6)], ["ball", "Ball_2", "___ball", "_2_balls"])


class WholeRuns(OfARun):
    def caches(self, *arguments: str) -> Folder:
        status, said = self.sunder("export", "--pc2", str(self.folder / "caches"), *arguments)
        self.assertEqual((status, said.strip()), (0, str(self.folder / "caches")))
        return Folder(self.folder / "caches")

    def test_bodies_have_one_object_and_what_rests_one_sample(self) -> None:
        written, count = self.caches(), len(list_frames(self.folder))
        rows = {row["object"]: row for row in written.rows}
        self.assertEqual(rows["body_1"]["samples"], "1")  # the floor
        for k, frame in enumerate(list_frames(self.folder)):
            height = max(BALL_RADIUS_M, HEIGHT_M + BALL_RADIUS_M + 0.003 - 20 * frame.time_s)
            points = written.points("body_0", k)[:, 2]
            self.assertAlmostEqual(0.5 * (points.min() + points.max()), height, places=6)
        self.assertEqual(int(rows["body_0"]["last_frame"]), count - 1)  # it lies there from the last sample on
        self.assertLess(int(rows["body_0"]["samples"]), count)
        self.sunder("export", "--gltf", str(self.folder / "run.glb"))
        nodes = {name for name in Animated((self.folder / "run.glb").read_bytes()).names if "_shape_" not in name}
        self.assertEqual({row["name"] for row in written.rows}, nodes - {"pane"})
        self.assertGreater(len(nodes), 10)
        self.assertEqual(sorted(p.stem for p in written.folder.glob("*.pc2")), sorted(rows))

    def test_speed_resamples_in_time(self) -> None:
        frames = list_frames(self.folder)
        written = self.caches("--fps", "30", "--speed", "0.5")
        rows = {row["object"]: row for row in written.rows}
        self.assertEqual(int(rows["body_0"]["last_frame"]), int(frames[-1].time_s * 60))
        rest = [k for k in range(int(rows["body_0"]["samples"])) if k / 60 < frames[1].time_s + 0.02]
        height = [written.points("body_0", k)[:, 2].mean() for k in rest]
        self.assertGreater(len(rest), 1)
        self.assertLess(height[1], height[0])

    def test_what_an_earlier_export_left_is_removed(self) -> None:
        self.caches()
        (self.folder / "caches" / "mine.obj").write_text("of the user's")
        written = self.caches("--frames", "0,1")
        self.assertEqual(sorted(p.name for p in written.folder.iterdir()), sorted(
            ["mine.obj", "materials.mtl", "objects.csv", *(row["object"] + e for row in written.rows for e in (".obj", ".pc2"))]))

    def test_a_foreign_table_removes_nothing(self) -> None:
        (self.folder / "caches").mkdir()
        (self.folder / "kept.obj").write_text("of the user's")
        for text in ("object\nkept\n", ",".join(COLUMNS) + "\n../kept,,,,,,,,\n"):
            (self.folder / "caches" / "objects.csv").write_text(text)
            (self.folder / "caches" / "kept.obj").write_text("of the user's")
            self.caches("--frames", "0")
            self.assertTrue((self.folder / "kept.obj").is_file())
            self.assertTrue((self.folder / "caches" / "kept.obj").is_file())

    def test_what_is_refused(self) -> None:
        (self.folder / "file").write_text("")
        for arguments, words in ((("--pc2", str(self.folder / "file")), "is a file; name a folder"),
                                 (("--pc2", str(self.folder / "c"), "--out", "x"), "leave --out out"),
                                 (("--pc2", str(self.folder / "c"), "--speed", "1e-12"), "take a higher --speed")):
            status, said = self.sunder("export", *arguments)
            self.assertEqual(status, 2)
            self.assertRegex(said, words)


if __name__ == "__main__":
    unittest.main()
