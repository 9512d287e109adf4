"""Ids of pieces, with the real programs: one number follows a shard from the shell to the end, in frames, shards.csv and
exports."""
from __future__ import annotations

import csv
import json
import os
import re
import shutil
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

import sunder
from sunder_tools.pictures.frames import BODIES, SHELL, list_frames
from sunder_tools.pictures.vtp import PolyData
from tests.command.mesh_files import Animated

TOP = Path(__file__).resolve().parents[2]
BUILD = os.environ["SUNDER_BUILD_DIR"]
GLASS = TOP / "scenes" / "glass.textproto"  # a pane, a ball (1) and a floor (2)
SETTINGS = ("shells[pane].plate.elements_x=40", "shells[pane].plate.elements_y=40", "end_time_s=1.2e-3",
            "fracture.latest_freeze_s=1e-3", "bodies[ball].twist.linear.z=-20",
            "materials[glass].toughening=0", "materials[glass].branch_drive=2", "materials[glass].fracture_energy=3",  # many shards
            "output.checkpoint_interval_s=4e-4",
            "output.frame_interval_s=5e-5")
EVERY_WINDOW, ONE_IN_FOUR = "output.shell_frame_interval_s=5e-5", "output.shell_frame_interval_s=2e-4"
# Two sewn plates; a cut at 0.2 ms takes a strip off the left one. Ids begin at 1, since there are no bodies.
SEWN = """name: "sewn"
end_time_s: 6e-4
window_s: 5e-5
gravity {}
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }
shells {
  name: "left"
  material: "glass"
  thickness_m: 0.004
  plate { size_x_m: 0.1 size_y_m: 0.1 elements_x: 10 elements_y: 10 pose { position { x: -0.05 } } }
  cuts { points { u: 0.03 v: 0 } points { u: 0.03 v: 0.1 } time_s: 2e-4 }
}
shells {
  name: "right"
  material: "glass"
  thickness_m: 0.004
  plate { size_x_m: 0.1 size_y_m: 0.1 elements_x: 10 elements_y: 10 pose { position { x: 0.05 } } }
}
fracture { mode: CUTS }
seams {}
output { frame_interval_s: 1e-4 shell_frame_interval_s: 1e-4 }
"""
# Places of all empties in all frames of Blender.
IN_BLENDER = """
import json, sys
sys.dont_write_bytecode = True
sys.path.insert(0, {addon!r})
import bpy
import sunder_run
empties, frames, scene = sunder_run.load({folder!r}), [], bpy.context.scene
for frame in range(scene.frame_start, scene.frame_end + 1):
    scene.frame_set(frame)
    frames.append({{thing.name: list(thing.matrix_world.translation) for thing in empties}})
open({out!r}, "w").write(json.dumps(frames))
"""
FOLLOWED = 20
# Share of all pieces that frames draw at least: they draw back from cracks, which takes 1 - 0.99^2. They also omit
# torn triangles, which are few.
DRAWN, DRAWN_OF_EACH = 0.97, 0.94
# Most that the drawn area of a piece grows where a new crack divides the triangles beside an old one, by share. Frames draw
# each corner back by a hundredth of its way to the centre of the triangles around it; new triangles may be so small that they
# draw nothing back.
GROWS = 1.0 / 0.99**2
PANE, RELATIVE = 0.5, 1e-6  # [m] side of the pane; error of a place, of single precision
ONE_WINDOW = 5e-5  # [s]


def run(folder: Path, *arguments: str) -> None:
    done = subprocess.run([TOP / "coupler" / "sunder", *arguments], cwd=folder.parent, capture_output=True, text=True,
                          env={**os.environ, "SUNDER_BUILD_DIR": BUILD}, check=False)
    if done.returncode:
        raise AssertionError(done.stderr)


def broken(folder: Path, frames: str, *more: str) -> Path:
    words = [word for setting in (*SETTINGS, frames) for word in ("--set", setting)]
    run(folder, "run", str(GLASS), *words, "--quiet", "--no-pictures", "--out", str(folder), *more)
    return folder


def shards(folder: Path) -> dict[int, dict[str, float]]:
    with (folder / "shards.csv").open() as file:
        return {int(row["id"]): {name: float(value) for name, value in row.items()} for row in csv.DictReader(file)}


def ids_of(mesh: PolyData | None, array: str) -> set[int]:
    return set() if mesh is None else {int(k) for k in mesh.of_triangles(array, 0)}


def glb_values(content: bytes, attribute: str) -> list[float]:
    """Numbers of an attribute with three equal ones per vertex, over all meshes."""
    size = struct.unpack_from("<I", content, 12)[0]
    told, blob = json.loads(content[20:20 + size]), content[28 + size:]
    found: list[float] = []
    for mesh in told["meshes"]:
        accessor = told["accessors"][mesh["primitives"][0]["attributes"][attribute]]
        offset = told["bufferViews"][accessor["bufferView"]]["byteOffset"]
        found += map(float, np.frombuffer(blob, "<f4", 3 * accessor["count"], offset))
    return found


class Ids(unittest.TestCase):
    folder: Path

    @classmethod
    def setUpClass(cls) -> None:
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.folder = broken(Path(holder.name) / "run", EVERY_WINDOW)

    def test_shards_are_followed_by_their_id_over_all_frames(self) -> None:
        results = sunder.Results(self.folder)
        rows, frames, tracks = shards(self.folder), results.frames, sunder.tracks(results)
        told = json.loads((self.folder / "run.json").read_text())["shards"]["larger_than"]
        self.assertEqual(len(told), 5)
        for larger in told:
            self.assertEqual(larger["count"], sum(row["area [m^2]"] > larger["area_m2"] for row in rows.values()))
        self.assertGreater(told[0]["count"], 0)
        for frame in frames:
            pieces, bodies = ids_of(frame.read(SHELL), "fragment"), ids_of(frame.read(BODIES), "body")
            self.assertEqual(pieces & bodies, set(), f"{frame.time_s} s: a number for two things")
            self.assertLessEqual({1, 2}, bodies)  # those of the scene
        times = [frame.time_s for frame in frames]
        self.assertGreaterEqual(sum(np.isfinite(tracks[i].area[0]) for i in rows), FOLLOWED)
        went_on, drawn, whole = 0, 0.0, 0.0
        for i, row in rows.items():
            track = tracks[i]
            self.assertEqual(track.time, times[-len(track.time):], f"shard {i} is missing in a frame, or twice in one")
            born = int(np.isnan(track.area).argmax())
            self.assertAlmostEqual(track.time[born], row["birth [s]"], delta=1e-9)
            self.assertTrue(np.isnan(track.area[born:]).all(), f"shard {i} is in the shell again")
            end = np.array([row[f"{axis} [m]"] for axis in "xyz"])
            np.testing.assert_allclose(track.centre[-1], end, atol=1e-6, err_msg=f"shard {i}")
            if born == 0:
                continue  # a splinter
            # a piece loses area where parts of it break off, and never gains any but what is drawn beside a crack
            self.assertTrue(all(after <= before * GROWS for before, after in zip(track.area[:born], track.area[1:born])),
                            f"shard {i}: {track.area}")
            self.assertGreater(track.area[born - 1], DRAWN_OF_EACH * row["area [m^2]"])
            drawn += min(track.area[born - 1], row["area [m^2]"])
            whole += row["area [m^2]"]
            self.assertAlmostEqual(track.time[born] - track.time[born - 1], ONE_WINDOW, delta=1e-9)
            if track.area[born - 1] > row["area [m^2]"]:
                continue  # a part broke off in the same window, which moves its centre
            # it goes on from where it was, as far as it flies in the window
            self.assertLess(float(np.linalg.norm(track.centre[born] - track.centre[born - 1])),
                            1.5 * ONE_WINDOW * row["speed at birth [m/s]"] + 0.05 * np.sqrt(row["area [m^2]"]))
            went_on += 1
        self.assertGreaterEqual(went_on, FOLLOWED)
        self.assertGreater(drawn, DRAWN * whole)

    def test_shards_are_followed_by_name_in_the_animated_file(self) -> None:
        rows, tracks = shards(self.folder), sunder.tracks(sunder.Results(self.folder))
        with tempfile.TemporaryDirectory() as name:
            run(self.folder, "export", str(self.folder), "--gltf", f"{name}/run.glb")
            film = Animated((Path(name) / "run.glb").read_bytes())
        times, seen = film.times, film.json["extras"]["times_s"]  # a picture a frame
        self.assertEqual(seen, [frame.time_s for frame in list_frames(self.folder)])
        self.assertEqual(len(times), len(seen))
        self.assertGreaterEqual(len(rows), FOLLOWED)
        for i, row in rows.items():
            node, track = f"pane_piece_{i}", tracks[i]
            for time, centre in zip(track.time, track.centre):  # over all keyframes, in the shell and after it
                np.testing.assert_allclose(film.centre(node, float(times[seen.index(time)])), centre, rtol=0.0,
                                           atol=RELATIVE * PANE, err_msg=f"shard {i}, {time} s")
            end = np.array([row[f"{axis} [m]"] for axis in "xyz"])
            np.testing.assert_allclose(film.centre(node, float(times[-1])), end, rtol=0.0, atol=RELATIVE * PANE, err_msg=f"shard {i}")
            self.assertTrue(film.seen(node, float(times[-1])))
            if track.time[0] > 0.0:
                self.assertEqual(film.seen(node, float(times[seen.index(track.time[0])]) - 1e-4), {}, f"shard {i} is seen before it exists")

    @unittest.skipUnless(shutil.which("blender"), "Blender is not installed; apt-get install --no-install-recommends blender")
    def test_shards_are_followed_by_name_in_blender(self) -> None:
        rows, tracks = shards(self.folder), sunder.tracks(sunder.Results(self.folder))
        with tempfile.TemporaryDirectory() as name:
            script, out = Path(name) / "script.py", Path(name) / "told.json"
            script.write_text(IN_BLENDER.format(addon=str(TOP / "coupler" / "blender"), folder=str(self.folder), out=str(out)))
            done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python", str(script)],
                                  stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout[-2000:])
            frames = json.loads(out.read_text())
        times = [frame.time_s for frame in list_frames(self.folder)]
        self.assertEqual(len(frames), len(times))
        self.assertGreaterEqual(len(rows), FOLLOWED)
        for i, row in rows.items():
            for time, centre in zip(tracks[i].time, tracks[i].centre):
                np.testing.assert_allclose(frames[times.index(time)][f"pane_piece_{i}"], centre, rtol=0.0, atol=RELATIVE * PANE)
            end = np.array([row[f"{axis} [m]"] for axis in "xyz"])
            np.testing.assert_allclose(frames[-1][f"pane_piece_{i}"], end, rtol=0.0, atol=RELATIVE * PANE, err_msg=f"shard {i}")

    def test_sewn_plates_are_one_piece_and_the_larger_part_keeps_its_id(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            scene, out = Path(name) / "sewn.textproto", Path(name) / "sewn"
            scene.write_text(SEWN)
            run(out, "run", str(scene), "--quiet", "--no-pictures", "--out", str(out))
            seen = []
            for frame in list_frames(out):
                shell = frame.read(SHELL)
                pairs = set() if shell is None else set(zip(shell.of_triangles("fragment", 0).astype(int).tolist(),
                                                            shell.of_triangles("shell", 0).astype(int).tolist()))
                seen.append((round(frame.time_s, 9), pairs, ids_of(frame.read(BODIES), "body")))
            whole, cut = {(1, 0), (1, 1)}, {(1, 0), (1, 1), (2, 0)}
            self.assertEqual(seen, [(0.0, whole, set()), (1e-4, whole, set()), (2e-4, cut, set()), (3e-4, cut, set()),
                                    (4e-4, set(), {1, 2}), (5e-4, set(), {1, 2}), (6e-4, set(), {1, 2})])
            area = {i: row["area [m^2]"] for i, row in shards(out).items()}
            self.assertEqual(set(area), {1, 2})
            self.assertAlmostEqual(area[1], 0.017, places=9)
            self.assertAlmostEqual(area[2], 0.003, places=9)

    def test_the_frozen_part_keeps_its_id_too(self) -> None:
        frames = list_frames(self.folder)
        last = [shell for frame in frames if (shell := frame.read(SHELL)) is not None][-1]
        ids, which = np.unique(last.of_triangles("fragment", 0).astype(int), return_inverse=True)
        corners = last.points[last.triangles]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        area = np.bincount(which, weights=areas)
        bodies = frames[-1].read(BODIES)
        assert bodies is not None
        frozen = set(bodies.of_triangles("body", 0)[bodies.of_triangles("kind", 0) == 3].astype(int))
        self.assertEqual(len(frozen), 1)  # all that supports hold is one body, named by its largest part
        self.assertGreater(area[ids == frozen.pop()].sum(), 0.95 * area.max())  # in mass of control points, a row more or less

    def test_frames_that_are_written_change_no_id(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            seldom = broken(Path(name) / "seldom", ONE_IN_FOUR)
            self.assertEqual((seldom / "shards.csv").read_bytes(), (self.folder / "shards.csv").read_bytes())
            of_time = {round(frame.time_s, 9): frame for frame in list_frames(self.folder)}
            for frame in list_frames(seldom):
                self.assertEqual(ids_of(frame.read(SHELL), "fragment"),
                                 ids_of(of_time[round(frame.time_s, 9)].read(SHELL), "fragment"))

    def test_a_run_that_resumes_gives_the_same_ids(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            part = broken(Path(name) / "part", EVERY_WINDOW, "--until", "7e-4")
            self.assertTrue((part / "checkpoint" / "state").is_file())
            run(part, "run", "--resume", str(part), "--until", "1.2e-3", "--quiet", "--no-pictures")
            self.assertEqual((part / "shards.csv").read_bytes(), (self.folder / "shards.csv").read_bytes())
            for mine, whole in zip(list_frames(part), list_frames(self.folder), strict=True):
                self.assertEqual(ids_of(mine.read(SHELL), "fragment"), ids_of(whole.read(SHELL), "fragment"))

    def test_exports_and_run_json_have_the_ids(self) -> None:
        rows = shards(self.folder)
        self.assertIn(json.loads((self.folder / "run.json").read_text())["shards"]["fastest_id"], rows)
        with tempfile.TemporaryDirectory() as name:
            run(self.folder, "export", str(self.folder), "--frames", "0,last", "--out", name)
            for file, whole in (("frame_000000.ply", 1), (sorted(p.name for p in Path(name).glob("*.ply"))[-1], 1 + len(rows))):
                head, body = (Path(name) / file).read_bytes().split(b"end_header\n")
                vertices, faces = (int(found) for what in ("vertex", "face") for found in re.findall(rf"element {what} (\d+)".encode(), head))
                face = np.frombuffer(body[vertices * 32:], [("n", "u1"), ("v", "<i4", 3), ("fragment", "<i4"), ("damage", "<f4"),
                                                            ("part", "<i4"), ("body", "<i4"), ("kind", "<i4"), ("side", "<i4")], faces)
                broke = face["fragment"][(face["part"] >= 0) | np.isin(face["kind"], (1, 3))]
                self.assertEqual(len(set(broke.tolist())), whole)
                self.assertEqual(set(broke.tolist()) & {1, 2}, set())
                if whole > 1:
                    self.assertLessEqual(set(rows), set(broke.tolist()))
            run(self.folder, "export", str(self.folder), "--format", "gltf", "--frames", "last", "--out", name)
            self.assertEqual(set(glb_values(next(Path(name).glob("*.glb")).read_bytes(), "_FRAGMENT")),
                             set(face["fragment"].tolist()))


if __name__ == "__main__":
    unittest.main()
