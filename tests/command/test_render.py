"""Stills, films and mesh sequences: what is drawn, what other programs would read, and what is refused."""
from __future__ import annotations

import contextlib
import errno
import io
import json
import shutil
import struct
import subprocess
import tracemalloc
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
from PIL import Image

from sunder_tools.command.main import main
from sunder_tools.errors import CommandError
from sunder_tools.launch.folder import RunFolder
from sunder_tools.pictures import contact_sheet as contact_sheets, lettering, raster, render as rendering, views
from sunder_tools.pictures.contact_sheet import boxes
from sunder_tools.pictures.export import glb_bytes
from sunder_tools.pictures.frames import list_frames
from sunder_tools.pictures.look import Look, origins
from sunder_tools.pictures.mesh import mesh_of
from sunder_tools.pictures.meshes import Scene, load_scene
from sunder_tools.pictures.motion import body_velocity
from sunder_tools.pictures.palette import STOPS, ramp
from sunder_tools.pictures.raster import Camera, perspective_camera
from sunder_tools.pictures.render import parse_view
from sunder_tools.report.scene_text import SCENE_COPY, Words, parse_text, words_of

from .mesh_files import read_glb
from .synthetic import write_vtp
from .test_view import InAFolder

SIZE = "160x96"


class OfARun(InAFolder):
    def setUp(self) -> None:
        super().setUp()
        self.synthetic(9)
        # no thickness: shells are middle surfaces
        (self.folder / SCENE_COPY).write_text('shells { name: "pane" material: "glass" }')

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

    def test_pictures_are_made_in_memory_that_is_kept(self) -> None:
        """Giving it back and getting it again for each picture took half of a film's processor time."""
        for module, arguments in ((rendering, ("--frames", "4")), (contact_sheets, ("--sheet",))):
            with mock.patch.object(module, "keep_memory") as kept:
                status, said = self.sunder("render", *arguments, *(("--size", SIZE, "--jobs", "1") if module is rendering else ()))
            self.assertEqual(status, 0, said)
            kept.assert_called_once_with()

    def test_an_azimuth_may_be_negative(self) -> None:
        pictures = [self.render(*a) for a in (("--view", "-90,20"), ("--view=-90,20",), ("--view", "270,20"))]
        np.testing.assert_array_equal(pictures[0], pictures[1])
        np.testing.assert_array_equal(pictures[0], pictures[2])
        for value, wrong in (("-2", "is out of range: 0.001 to 1000"), ("-inf", "is out of range: 0.001 to 1000"),
                             ("-nan", "is not a number of 0.001 to 1000")):
            self.assertEqual(self.sunder("render", "--zoom", value), (
                2, f"sunder: argument --zoom: '{value}' {wrong}; see 'sunder render --help'\n"))
        status, said = self.sunder("render", "--film", "-1")  # a switch
        self.assertEqual(status, 2)
        self.assertNotIn("--film=-1", said)
        self.assertNotIn("ignored explicit argument", said)

    def test_colours_of_a_quantity_have_a_bar_with_title_unit_and_ends(self) -> None:
        words: list[str] = []
        bars: list[tuple[str, ...]] = []

        def write(image: Image.Image, at: tuple[int, int], text: str, size: int) -> None:
            words.append(text)
            self.assertTrue(0 <= at[0] and at[0] + lettering.text_width(text, size) <= image.width and at[1] + size <= image.height,
                            f"{text} is cut off")
            plain(image, at, text, size)

        plain = lettering.draw_text
        for colour, ends in (("damage", ["damage [-]", "0", "1"]), ("speed", ["speed [m/s]", "0", f"{self.fastest():.3g}"])):
            words.clear()
            with mock.patch.object(lettering, "draw_text", write):
                picture = self.render("--colour", colour)
            self.assertEqual(words, ends)
            left, top, right, bottom = lettering.bar_box(Image.new("RGB", (160, 96)))
            bar = picture[(top + bottom) // 2, left:right]
            np.testing.assert_allclose(bar[[0, -1]], 255.0 * STOPS[[0, -1]], atol=1.0)
            np.testing.assert_allclose(bar, 255.0 * ramp(np.linspace(0.0, 1.0, right - left)), atol=1.0)
            bars.append(tuple(words))
        self.assertNotEqual(*bars)
        words.clear()
        with mock.patch.object(lettering, "draw_text", write):
            for arguments in (("--colour", "part"), ("--colour", "fragment"), ("--colour", "speed", "--no-caption")):
                self.render(*arguments)
        self.assertEqual(words, [])

    def fastest(self) -> float:
        """The largest speed [m/s] in the frame that is drawn."""
        return float(np.linalg.norm(body_velocity(list_frames(self.folder), 4), axis=1).max())

    def scene(self) -> tuple[Scene, Camera]:
        frame = list_frames(self.folder)[4]
        scene = load_scene(frame)
        self.assertTrue(scene.solid.is_floor.any() and len(scene.glass.triangles))
        low, high = boxes(frame, [scene])[1]
        return scene, perspective_camera(low, high, np.array([1.0, 0.4, -0.5]), 400, 240)

    def test_most_shards_are_in_the_picture_and_none_that_flies_far_makes_it_small(self) -> None:
        """Twenty shards spread over twice the pane, late only; another one flies away."""
        frame = list_frames(self.folder)[4]
        scene = load_scene(frame)
        shell = frame.read(0)
        assert shell is not None
        middle, size = 0.5 * (shell.points.min(axis=0) + shell.points.max(axis=0)), float(np.ptp(shell.points, axis=0).max())
        turn = np.arange(20) * 0.1 * np.pi
        corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]) * size
        places = middle + size * np.stack([2.0 * np.cos(turn), 2.0 * np.sin(turn), 0.5 * np.cos(3 * turn)], 1)
        shards = (places[:, None] + corners).reshape(-1, 3)
        for far, reach in ((0.0, 2.1), (50.0, 2.1)):
            away = middle + [far * size, 0, far * size] + corners
            late = replace(scene, shards=np.concatenate([away, shards]), shard_of=np.repeat(np.arange(21), 4))
            for scenes in ([scene, late], [scene, late, scene]):
                low, high = boxes(frame, scenes)[1]
                self.assertTrue(((shards >= low) & (shards <= high)).all(), "a shard is cut off")
                self.assertLess(float(np.abs(np.array([low, high])[:, :2] - middle[:2]).max()), (reach + 0.1) * size)
        for far, seen in ((2.5, True), (4.0, False)):  # where most of them are far away
            late = replace(scene, shards=middle + [far * size, 0, 0] + corners, shard_of=np.zeros(4, int))
            self.assertEqual(boxes(frame, [scene, late])[1][1][0] > middle[0] + 2.0 * size, seen)

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
                mock.patch.object(views, "Shadows", lambda *_: mock.Mock(**{name: lambda points, *_: np.zeros(len(points))
                                                                           for name in ("on", "below")})):
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
        np.testing.assert_array_equal(nodes["window"]["_DAMAGE"], np.repeat([0, 0, 0, 1, 1, 1], 3).reshape(-1, 3))
        # Blender 4.3 keeps attributes apart only where all of them are alike
        self.assertEqual({values.shape[1] for node in nodes.values() for name, values in node.items() if name.startswith("_")}, {3})
        np.testing.assert_array_equal(nodes["bumper"]["POSITION"][2], [1, 0, -1])  # y up

    def materials(self, scene: str, part_of: dict[int, int]) -> dict[str, tuple[str, bool]]:
        """Material of each node of the exported frame, and whether light goes through it."""
        frames = list_frames(self.folder)
        raw = glb_bytes(mesh_of(frames, 0), 0.0, words_of(parse_text(scene), []) if scene else Words(), part_of)
        content = json.loads(raw[20:20 + struct.unpack_from("<I", raw, 12)[0]])
        names = [material["name"] for material in content["materials"]]
        self.assertEqual(len(names), len(set(names)), "each once")
        used = {node["name"]: content["materials"][content["meshes"][node["mesh"]]["primitives"][0]["material"]]
                for node in content["nodes"]}
        self.assertEqual({material["alphaMode"] for material in content["materials"]}, {"OPAQUE"})
        clear = {material["name"] for material in content["materials"] if "KHR_materials_transmission" in material.get("extensions", {})}
        self.assertEqual("KHR_materials_transmission" in content.get("extensionsUsed", []), bool(clear))
        return {name: (material["name"], material["name"] in clear) for name, material in used.items()}

    def test_gltf_has_the_materials_of_the_scene(self) -> None:
        self.assertEqual(self.materials(self.SCENE, {4: 0, 5: 1}), {
            "bumper": ("plastic", False), "window": ("window_glass", True), "shards_of_bumper": ("plastic", False),
            "shards_of_window": ("window_glass", True)})
        self.assertEqual(self.materials(self.SCENE.replace("window_glass", "plastic"), {}), {
            "bumper": ("plastic", False), "window": ("plastic", False), "shards": ("plastic", False)})
        self.assertEqual(self.materials("", {}), {"shell_0": ("shell_0", False), "shell_1": ("shell_1", False),
                                                  "shards": ("shards", False)})

    def test_a_lone_shell_is_of_its_material_too(self) -> None:
        write_vtp(self.folder / "frames/shell.vtp", [[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2]],
                  cell_data={"fragment": np.zeros(1), "damage": np.zeros(1), "shell": np.zeros(1)}, floats="f8")
        write_vtp(self.folder / "frames/bodies.vtp", [[0, 0, -1], [1, 0, -1], [0, 1, -1]], [[0, 1, 2], [0, 2, 1]],
                  cell_data={"body": np.array([1.0, 5]), "kind": np.array([0.0, 1])}, floats="f8")
        frame, = list_frames(self.folder)
        for material, clear in (("plaster", False), ("clear_acrylic", True), ("glass", True)):
            scene = f"""materials {{ name: "{material}" density: 500 strength: 1 }}
                shells {{ name: "wall" material: "{material}" thickness_m: 0.008 }} bodies {{ name: "ball" material: "lead" }}"""
            self.assertEqual(self.materials(scene, {}), {"wall": (material, clear), "shards": (material, clear),
                                                         "ball": ("lead", False)})
            drawn = load_scene(frame, Look(glass=words_of(parse_text(scene), []).glass))
            self.assertEqual(len(drawn.glass.triangles), 2 if clear else 0)


if __name__ == "__main__":
    unittest.main()
