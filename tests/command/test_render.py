"""Stills, films and mesh sequences: what is drawn, what other programs would read, and what is refused."""
from __future__ import annotations

import contextlib
import errno
import io
import json
import re
import shutil
import struct
import subprocess
import tracemalloc
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from PIL import Image

from sunder_tools.command.main import main
from sunder_tools.errors import CommandError
from sunder_tools.launch.folder import RunFolder
from sunder_tools.pictures import raster, render as rendering, views
from sunder_tools.pictures.contact_sheet import boxes
from sunder_tools.pictures.export import glb_bytes, mesh_of
from sunder_tools.pictures.frames import BODIES, SHELL, list_frames
from sunder_tools.pictures.look import Look, origins
from sunder_tools.pictures.meshes import Scene, load_scene
from sunder_tools.pictures.raster import Camera, perspective_camera
from sunder_tools.pictures.render import parse_view, pick
from sunder_tools.report.scene_text import Words, parse_text, words_of

from .synthetic import write_vtp
from .test_view import InAFolder

SIZE = "160x96"


def read_ply(raw: bytes) -> dict[str, np.ndarray]:
    """An independent reader: header by words, then records by struct."""
    head, _, body = raw.partition(b"end_header\n")
    lines = [line.split() for line in head.decode("ascii").splitlines()]
    assert lines[0] == ["ply"] and lines[1] == ["format", "binary_little_endian", "1.0"]
    sizes, out, at = {"float": "f", "int": "i", "uchar": "B"}, {}, 0
    elements: list[tuple[str, int, list[list[str]]]] = []
    for line in lines[2:]:
        if line[0] == "element":
            elements.append((line[1], int(line[2]), []))
        elif line[0] == "property":
            elements[-1][2].append(line[1:])
    for name, count, properties in elements:
        for _ in range(count):
            for words in properties:
                if words[0] == "list":
                    n, = struct.unpack_from("<" + sizes[words[1]], body, at)
                    at += struct.calcsize(sizes[words[1]])
                    value = struct.unpack_from(f"<{n}{sizes[words[2]]}", body, at)
                    at += struct.calcsize(f"<{n}{sizes[words[2]]}")
                else:
                    value, = struct.unpack_from("<" + sizes[words[0]], body, at)
                    at += struct.calcsize(sizes[words[0]])
                out.setdefault(f"{name}.{words[-1]}", []).append(value)
    assert at == len(body), "bytes are left"
    return {key: np.array(values) for key, values in out.items()}


def read_glb(raw: bytes) -> dict[str, dict[str, np.ndarray]]:
    """An independent reader: {node: {attribute: values}}."""
    magic, version, length = struct.unpack_from("<4sII", raw)
    assert (magic, version, length) == (b"glTF", 2, len(raw))
    size, kind = struct.unpack_from("<I4s", raw, 12)
    assert kind == b"JSON" and size % 4 == 0
    content = json.loads(raw[20:20 + size])
    blob = raw[28 + size:]
    assert struct.unpack_from("<I4s", raw, 20 + size) == (len(blob), b"BIN\0")
    assert content["buffers"] == [{"byteLength": len(blob)}]

    def values(number: int) -> np.ndarray:
        accessor = content["accessors"][number]
        view = content["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        array = np.frombuffer(blob, {5126: "<f4", 5125: "<u4"}[accessor["componentType"]], accessor["count"] * width,
                              view["byteOffset"])
        assert array.nbytes == view["byteLength"] and view["byteOffset"] % 4 == 0
        array = array.reshape(-1, width)
        if "min" in accessor:
            np.testing.assert_allclose(array.min(axis=0), accessor["min"], rtol=1e-6)
            np.testing.assert_allclose(array.max(axis=0), accessor["max"], rtol=1e-6)
        return array

    found = {}
    for number in content["scenes"][content["scene"]]["nodes"]:
        node = content["nodes"][number]
        primitive, = content["meshes"][node["mesh"]]["primitives"]
        found[node["name"]] = {n: values(k) for n, k in primitive["attributes"].items()} | {"index": values(primitive["indices"])}
    return found


class OfARun(InAFolder):
    def setUp(self) -> None:
        super().setUp()
        self.synthetic(9)

    def sunder(self, *arguments: str) -> tuple[int, str]:
        """Exit status, and what was said."""
        said = io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            status = main([arguments[0], str(self.folder), *arguments[1:]])
        return status, said.getvalue()


class Stills(OfARun):
    def render(self, *arguments: str) -> np.ndarray:
        status, said = self.sunder("render", "--size", SIZE, "--jobs", "1", "--frames", "4", *arguments)
        self.assertEqual(status, 0, said)
        with Image.open(self.folder / "stills" / "still_000004.png") as image:
            self.assertEqual(image.size, (160, 96))
            return np.asarray(image.convert("RGB"), int)

    def test_colours_views_and_zoom_give_other_pictures(self) -> None:
        pictures = [self.render(*a) for a in ((), ("--colour", "damage"), ("--colour", "fragment"), ("--colour", "speed"),
                                              ("--view", "top"), ("--view", "30,10"), ("--zoom", "2"), ("--close",))]
        for k, one in enumerate(pictures):
            self.assertGreater(one.std(), 8.0, "blank")
            for other in pictures[k + 1:]:
                self.assertGreater((np.abs(one - other).max(axis=2) > 10).mean(), 0.01)
        self.assertEqual([p.name for p in (self.folder / "stills").iterdir()], ["still_000004.png"])

    def scene(self) -> tuple[Scene, Camera]:
        frame = list_frames(self.folder)[4]
        scene = load_scene(frame)
        self.assertTrue(scene.solid.is_floor.any() and len(scene.glass.triangles))
        low, high = boxes(frame, [scene])[1]
        return scene, perspective_camera(low, high, np.array([1.0, 0.4, -0.5]), 400, 240)

    def test_bands_do_not_show(self) -> None:
        scene, camera = self.scene()
        whole = views.draw_scene(scene, camera, 400, 240)
        for band in (1 << 20, 400, 999):
            with mock.patch.object(views, "BAND", band):
                np.testing.assert_array_equal(views.draw_scene(scene, camera, 400, 240), whole)

    def test_no_array_of_a_whole_picture_is_made_in_between(self) -> None:
        """A picture takes its colours, and a triangle and a nearness a pixel for solid and glass. Arrays of that size beside
        them cost more than what is done with them, in pages that the system makes."""
        scene, camera = self.scene()
        with mock.patch.object(views, "BAND", 1000), mock.patch.object(raster, "CANDIDATES", 1000), \
                mock.patch.object(views, "_Shadows", lambda *_: mock.Mock(at=lambda points: np.zeros(len(points)))):
            views.draw_scene(scene, camera, 400, 240)
            tracemalloc.start()
            self.addCleanup(tracemalloc.stop)
            before = tracemalloc.get_traced_memory()[0]
            views.draw_scene(scene, camera, 400, 240)
            used = (tracemalloc.get_traced_memory()[1] - before) / (400 * 240)
        self.assertLess(used, 3 * 4 + 2 * (8 + 8) + 20)  # [bytes a pixel]; a further array of colours is 24

    def test_without_a_place_for_locks_pictures_are_drawn_one_by_one(self) -> None:
        refused = OSError(errno.EROFS, "Read-only file system")
        with mock.patch("multiprocessing.pool.Pool.__init__", side_effect=refused):
            status, said = self.sunder("render", "--size", SIZE, "--jobs", "2", "--frames", "0,3")
        self.assertEqual(status, 0, said)
        self.assertIn("one after another: /dev/shm: Read-only file system", said)
        self.assertEqual(len(list((self.folder / "stills").iterdir())), 2)

    def test_several_processes_draw_the_same(self) -> None:
        for jobs, name in (("1", "a"), ("2", "b")):
            status, said = self.sunder("render", "--size", SIZE, "--jobs", jobs, "--frames", "0,3,8", "--out",
                                       str(self.folder / name))
            self.assertEqual(status, 0, said)
        for path in sorted((self.folder / "a").iterdir()):
            self.assertEqual(path.read_bytes(), (self.folder / "b" / path.name).read_bytes())

    def test_frames_that_are_asked_for(self) -> None:
        self.assertEqual(pick("0,5,7-last", 10), [0, 5, 7, 8, 9])
        self.assertEqual(pick("all", 3), [0, 1, 2])
        for spec, why in (("10", "not among the frames 0 to 9"), ("5-3", "not among"), ("x", "is no frame"), ("", "is no frame"),
                          ("-1", "is no frame"), ("1-2-3", "is no frame")):
            with self.assertRaisesRegex(CommandError, why):
                pick(spec, 10)

    def test_what_is_refused(self) -> None:
        for arguments, why in ((("--size", "0x5"), "is no size"), (("--size", "100"), "is no size"), (("--view", "0,95"), "no view"),
                               (("--view", "inside"), "no view"), (("--zoom", "nan"), "not a number"),
                               (("--sheet", "--film"), "--sheet goes with none"),
                               (("--film", "--out", "film.avi"), "a film is one of .mp4"),
                               (("--film", "--size", "161x96"), "needs even numbers")):
            status, said = self.sunder("render", *arguments)
            self.assertEqual(status, 2)
            self.assertIn(why, said)
        self.assertIsNotNone(parse_view("-720,89"))

    def test_frames_that_are_missing_or_broken(self) -> None:
        path = self.folder / "frames" / "shell_000003.vtp"
        path.write_bytes(path.read_bytes()[:700])
        status, said = self.sunder("render", "--frames", "3")
        self.assertEqual(status, 2)
        self.assertRegex(said, "a frame cannot be read: .*shell_000003.vtp")
        shutil.rmtree(self.folder / "frames")
        for command in ("render", "export"):
            status, said = self.sunder(command)
            self.assertEqual(status, 2)
            self.assertIn("no frame of it is there", said)
        (self.folder / "frames.pvd").unlink()
        (self.folder / "run.json").unlink()
        for command in ("render", "export"):
            self.assertIn("holds neither run.json nor frames.pvd", self.sunder(command)[1])

    def test_a_full_disk_leaves_no_half_picture(self) -> None:
        def full(self: Image.Image, path: Path, **_: object) -> None:
            Path(path).write_bytes(b"half")
            raise OSError(28, "No space left on device", str(path))

        with mock.patch.object(Image.Image, "save", full):
            for arguments in (("--frames", "0"), ("--film", "--out", str(self.folder / "film.gif"))):
                status, said = self.sunder("render", "--size", SIZE, "--jobs", "1", *arguments)
                self.assertEqual(status, 2)
                self.assertRegex(said, "cannot write .*No space left on device.*free some space")
        self.assertEqual([p for p in self.folder.rglob("*") if p.suffix in (".png", ".gif")], [])

    def test_a_new_run_in_the_folder_removes_them(self) -> None:
        self.render()
        self.sunder("export", "--frames", "0")
        note = self.folder / "stills" / "note.txt"
        note.write_text("mine")
        run = RunFolder(self.folder, [])
        run.clear()
        run.close()
        self.assertEqual([p.relative_to(self.folder) for p in self.folder.rglob("*") if p.is_file()],
                         [note.relative_to(self.folder)])


class Film(OfARun):
    def film(self, name: str) -> Path:
        path = self.folder / name
        status, said = self.sunder("render", "--film", "--size", SIZE, "--jobs", "1", "--out", str(path), "--rate", "10")
        self.assertEqual(status, 0, said)
        return path

    def test_animated_pictures_have_a_picture_a_frame(self) -> None:
        for name in ("film.gif", "film.png"):
            with Image.open(self.film(name)) as image:
                self.assertEqual((image.n_frames, image.size), (9, (160, 96)))
                first = np.asarray(image.convert("RGB"), int)
                image.seek(8)
                self.assertEqual(image.info["duration"], 100)
                self.assertGreater(np.abs(np.asarray(image.convert("RGB"), int) - first).mean(), 1.0)

    @unittest.skipUnless(shutil.which("ffmpeg") and shutil.which("ffprobe"), "no ffmpeg; 'sunder render --film' installs it")
    def test_a_video_can_be_played(self) -> None:
        said = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries",
                               "stream=codec_name,width,height,nb_read_frames", "-of", "csv=p=0", self.film("film.mp4")],
                              check=True, capture_output=True, text=True).stdout.strip()
        self.assertEqual(said, "h264,160,96,9")

    def test_an_encoder_that_fails_is_told(self) -> None:
        tool = self.folder / "bin" / "ffmpeg"
        tool.parent.mkdir()
        tool.write_text("#!/bin/sh\necho it is ill >&2\nexit 3\n")
        tool.chmod(0o755)
        with mock.patch.dict("os.environ", {"PATH": f"{tool.parent}:/usr/bin:/bin"}):
            status, said = self.sunder("render", "--film", "--size", SIZE, "--jobs", "1")
        self.assertEqual(status, 2)
        self.assertIn("ffmpeg failed with status 3: it is ill", said)
        self.assertEqual([p.name for p in self.folder.glob("*film*")], [])

    def test_without_ffmpeg_it_is_a_gif(self) -> None:
        def cannot(*_: object) -> None:
            raise CommandError("no right to install")

        with mock.patch.object(rendering.shutil, "which", lambda _: None), mock.patch.object(rendering, "ensure_installed", cannot):
            status, said = self.sunder("render", "--film", "--size", SIZE, "--jobs", "1", "--frames", "0-2")
            self.assertEqual(status, 0, said)
            self.assertIn("so the film is an animated GIF", said)
            self.assertTrue((self.folder / "film.gif").is_file())
            status, said = self.sunder("render", "--film", "--size", SIZE, "--out", str(self.folder / "f.mp4"))
            self.assertEqual(status, 2)
            self.assertIn("--out with .gif", said)


class SeveralShells(InAFolder):
    SCENE = """materials { name: "plastic" density: 500 strength: 1 } materials { name: "window_glass" density: 300 strength: 1 }
        shells { name: "bumper" material: "plastic" thickness_m: 0.008 }
        shells { name: "window" material: "window_glass" thickness_m: 0.01 }"""

    def setUp(self) -> None:
        super().setUp()
        (self.folder / "frames").mkdir()
        points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]]
        write_vtp(self.folder / "frames/shell.vtp", points, [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]],
                  cell_data={"fragment": np.zeros(4), "damage": np.array([0.0, 0.5, 0, 1]), "shell": np.array([0.0, 0, 1, 1])},
                  floats="f8")
        write_vtp(self.folder / "frames/bodies.vtp", [[0, 0, -1], [1, 0, -1], [0, 1, -1]], [[0, 1, 2], [0, 2, 1]],
                  cell_data={"body": np.array([4.0, 5]), "kind": np.array([1.0, 1])}, floats="f8")
        (self.folder / "frames.pvd").write_text('<VTKFile><Collection><DataSet timestep="0" part="0" file="frames/shell.vtp"/>'
                                                '<DataSet timestep="0" part="2" file="frames/bodies.vtp"/></Collection></VTKFile>')
        (self.folder / "shards.csv").write_text("id,birth [s],area [m^2],mass [kg]\n4,0,0.5,2\n5,0,0.25,0.75\n6,0,1,9\n")
        self.words = words_of(parse_text(self.SCENE), [])

    def test_shards_are_known_by_their_mass(self) -> None:
        self.assertEqual(origins(self.folder, self.words), {4: 0, 5: 1})
        self.assertEqual(origins(self.folder, Words()), {})

    def test_glass_is_seen_through_and_the_rest_is_not(self) -> None:
        frame, = list_frames(self.folder)
        scene = load_scene(frame, Look(glass=self.words.glass, part_of=origins(self.folder, self.words)))
        self.assertEqual((len(scene.glass.triangles), len(scene.solid.triangles)), (3, 3))  # two of the shell, one shard
        plain = load_scene(frame)  # nothing known of the scene: parts differ all the same, and are opaque
        self.assertEqual((len(plain.glass.triangles), len(plain.solid.triangles)), (0, 6))
        self.assertGreater(np.abs(plain.solid.colours[0] - plain.solid.colours[2]).max(), 0.1)
        self.assertLess(np.abs(plain.solid.colours[0] - plain.solid.colours[1]).max(), 1e-12)

    def test_gltf_names_the_parts(self) -> None:
        frames = list_frames(self.folder)
        nodes = read_glb(glb_bytes(mesh_of(frames, 0), 0.0, self.words, origins(self.folder, self.words)))
        self.assertEqual(list(nodes), ["bumper", "window", "shards_of_bumper", "shards_of_window"])
        np.testing.assert_array_equal(nodes["window"]["_DAMAGE"].ravel(), [0, 0, 0, 1, 1, 1])
        np.testing.assert_array_equal(nodes["bumper"]["POSITION"][2], [1, 0, -1])  # y up

    def materials(self, scene: str, part_of: dict[int, int]) -> dict[str, tuple[str, str]]:
        """Material and alpha mode of each node of the exported frame."""
        frames = list_frames(self.folder)
        raw = glb_bytes(mesh_of(frames, 0), 0.0, words_of(parse_text(scene), []) if scene else Words(), part_of)
        content = json.loads(raw[20:20 + struct.unpack_from("<I", raw, 12)[0]])
        names = [material["name"] for material in content["materials"]]
        self.assertEqual(len(names), len(set(names)), "each once")
        used = {node["name"]: content["materials"][content["meshes"][node["mesh"]]["primitives"][0]["material"]]
                for node in content["nodes"]}
        return {name: (material["name"], material["alphaMode"]) for name, material in used.items()}

    def test_gltf_has_the_materials_of_the_scene(self) -> None:
        self.assertEqual(self.materials(self.SCENE, {4: 0, 5: 1}), {
            "bumper": ("plastic", "OPAQUE"), "window": ("window_glass", "BLEND"), "shards_of_bumper": ("plastic", "OPAQUE"),
            "shards_of_window": ("window_glass", "BLEND")})
        self.assertEqual(self.materials(self.SCENE.replace("window_glass", "plastic"), {}), {
            "bumper": ("plastic", "OPAQUE"), "window": ("plastic", "OPAQUE"), "shards": ("plastic", "OPAQUE")})
        self.assertEqual(self.materials("", {}), {"shell_0": ("shell_0", "OPAQUE"), "shell_1": ("shell_1", "OPAQUE"),
                                                  "shards": ("shards", "OPAQUE")})

    def test_a_lone_shell_is_of_its_material_too(self) -> None:
        write_vtp(self.folder / "frames/shell.vtp", [[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2]],
                  cell_data={"fragment": np.zeros(1), "damage": np.zeros(1), "shell": np.zeros(1)}, floats="f8")
        write_vtp(self.folder / "frames/bodies.vtp", [[0, 0, -1], [1, 0, -1], [0, 1, -1]], [[0, 1, 2], [0, 2, 1]],
                  cell_data={"body": np.array([1.0, 5]), "kind": np.array([0.0, 1])}, floats="f8")
        frame, = list_frames(self.folder)
        for material, mode in (("plaster", "OPAQUE"), ("clear_acrylic", "BLEND"), ("glass", "BLEND")):
            scene = f"""materials {{ name: "{material}" density: 500 strength: 1 }}
                shells {{ name: "wall" material: "{material}" thickness_m: 0.008 }} bodies {{ name: "ball" material: "lead" }}"""
            self.assertEqual(self.materials(scene, {}), {"wall": (material, mode), "shards": (material, mode),
                                                         "ball": ("lead", "OPAQUE")})
            drawn = load_scene(frame, Look(glass=words_of(parse_text(scene), []).glass))
            self.assertEqual(len(drawn.glass.triangles), 2 if mode == "BLEND" else 0)


class Export(OfARun):
    def test_ply_has_what_the_frames_have(self) -> None:
        status, said = self.sunder("export")
        self.assertEqual(status, 0, said)
        frames = list_frames(self.folder)
        folder = self.folder / "export"
        self.assertEqual(len(list(folder.glob("*.ply"))), 9)
        times = (folder / "frame_times.csv").read_text().splitlines()
        self.assertEqual([float(row.split(",")[1]) for row in times[1:]], [f.time_s for f in frames])
        for k in (0, 4, 8):
            ply = read_ply((folder / f"frame_{k:06d}.ply").read_bytes())
            shell, bodies = frames[k].read(SHELL), frames[k].read(BODIES)
            n, m = (len(shell.points), len(shell.triangles)) if shell is not None else (0, 0)
            points = np.stack([ply[f"vertex.{a}"] for a in "xyz"], axis=1)
            np.testing.assert_allclose(points[n:], bodies.points, atol=1e-7)  # single precision
            np.testing.assert_array_equal(ply["face.vertex_indices"][m:] - n, bodies.triangles)
            np.testing.assert_array_equal(ply["face.kind"][m:], bodies.of_triangles("kind", 0))
            np.testing.assert_array_equal(ply["face.part"][m:], -1)
            if shell is not None:
                np.testing.assert_allclose(points[:n], shell.points, atol=1e-7)
                np.testing.assert_array_equal(ply["face.vertex_indices"][:m], shell.triangles)
                np.testing.assert_array_equal(ply["face.fragment"][:m], shell.of_triangles("fragment", 0))
                np.testing.assert_allclose(ply["face.damage"][:m], shell.of_triangles("damage", 0), rtol=1e-6)
        ball = read_ply((folder / "frame_000002.ply").read_bytes())
        mine = np.unique(ball["face.vertex_indices"][(ball["face.body"] == 0) & (ball["face.kind"] == 0)])
        np.testing.assert_allclose(ball["vertex.vz"][mine], -20.0, rtol=1e-5)

    def test_gltf_has_what_the_frames_have(self) -> None:
        status, said = self.sunder("export", "--format", "gltf", "--frames", "4,last")
        self.assertEqual(status, 0, said)
        frames = list_frames(self.folder)
        for k in (4, 8):
            nodes = read_glb((self.folder / "export" / f"frame_{k:06d}.glb").read_bytes())
            mesh = mesh_of(frames, k)
            corners = np.concatenate([node["POSITION"][node["index"].ravel()] for node in nodes.values()])
            wanted = mesh.points[mesh.triangles].reshape(-1, 3)[:, [0, 2, 1]] * [1, 1, -1]
            self.assertEqual(corners.shape, wanted.shape)
            self.assertEqual("shards" in nodes, k > 3)
            order = [np.lexsort(a.round(5).T) for a in (corners, wanted)]
            np.testing.assert_allclose(corners[order[0]], wanted[order[1]], atol=2e-5)

    def test_nothing_but_air(self) -> None:
        write_vtp(self.folder / "frames/shell_000000.vtp", [])
        write_vtp(self.folder / "frames/bodies_000000.vtp", [])
        for kind in ("ply", "gltf"):
            self.assertEqual(self.sunder("export", "--format", kind, "--frames", "0")[0], 0)
        ply = (self.folder / "export" / "frame_000000.ply").read_bytes()
        self.assertTrue(re.search(rb"element face 0\n", ply) and ply.endswith(b"end_header\n"))

    def test_where_it_cannot_write_it_says_so(self) -> None:
        (self.folder / "taken").write_text("a file")
        status, said = self.sunder("export", "--out", str(self.folder / "taken"))
        self.assertEqual(status, 2)
        self.assertRegex(said, "cannot write .*taken")


if __name__ == "__main__":
    unittest.main()
