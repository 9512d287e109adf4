"""Reading frames and drawing them."""
from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from PIL import Image

from sunder_tools.pictures import contact_sheet, modes_sheet
from sunder_tools.pictures.contact_sheet import GRIDS, WIDTH, ground_of, moment_text, stand, time_text, write_contact_sheet
from sunder_tools.pictures.crack_lines import Graph
from sunder_tools.pictures.flat import crack_pattern
from sunder_tools.pictures.frames import SHELL, Frame, choose_frames, list_frames
from sunder_tools.pictures.look import Look
from sunder_tools.pictures.meshes import Scene, Surface, _surface, load_scene
from sunder_tools.pictures.raster import orthographic_camera, perspective_camera, rasterise
from sunder_tools.pictures.plots import there
from sunder_tools.pictures.shadows import GLASS, LIGHT, SOLID, Shadows
from sunder_tools.pictures.views import _Shader, background, draw_scene
from sunder_tools.pictures.vtp import VtpError, read_vtp
from sunder_tools.report.appearance import PLASTER
from sunder_tools.report.scene_text import SCENE_COPY
from sunder_tools.places import BUILD_DIR_VARIABLE
from tests.validation.crack_pictures import _length_of_bar, draw_cracks, figure_of

from .synthetic import THICKNESS_M, SyntheticRun, write_vtp


PAGES = 4000


class InAFolder(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)


class CrackLines(InAFolder):
    @unittest.skipUnless(there(), "matplotlib is not installed; apt-get install python3-matplotlib")
    def test_are_grey_where_cut_and_have_the_colours_of_their_times(self) -> None:
        ends = np.array([[[0.0, 0.25], [1.0, 0.25]], [[0.0, 0.5], [1.0, 0.5]], [[0.0, 0.75], [1.0, 0.75]]])
        graph = Graph(ends, np.zeros((3, 2, 3)), np.arange(3), np.array([0.0, 1e-3, 2e-3]))
        rows = [[graph, None], [None, graph]]
        axes = figure_of(rows, (2.0, 1.0), size=80, names=("one", "two")).axes[0]
        frames, cuts, lines = axes.collections
        self.assertEqual(len(frames.get_segments()), 4)
        corners = np.array([[0.0, 1.0], [2.0, 0.0]])  # v is up, rows go down
        np.testing.assert_allclose(cuts.get_segments(), [ends[0] + corner for corner in corners])
        np.testing.assert_allclose(lines.get_segments(), [end + corner for corner in corners for end in ends[1:]])
        np.testing.assert_allclose(lines.get_array(), [0, 1, 0, 1])
        self.assertEqual([text.get_text() for text in axes.get_yticklabels()], ["one", "two"])
        np.testing.assert_allclose(axes.get_yticks(), [1.5, 0.5])
        self.assertIn("1 m", [text.get_text() for text in axes.texts])
        draw_cracks(self.folder / "lines.png", rows, (2.0, 1.0), size=80)
        with Image.open(self.folder / "lines.png") as image:
            self.assertGreater(image.width, 160)
        self.assertEqual([_length_of_bar(x) for x in (1.0, 0.03, 0.019, 0.07)], [1.0, 0.02, 0.01, 0.05])


    def test_without_matplotlib_it_is_said_and_all_else_goes_on(self) -> None:
        said = io.StringIO()
        with mock.patch("sunder_tools.pictures.plots.there", return_value=False), contextlib.redirect_stderr(said), \
                mock.patch.dict(os.environ, {BUILD_DIR_VARIABLE: str(self.folder)}):
            draw_cracks(self.folder / "lines.png", [[None]], (2.0, 1.0))
        self.assertIn("lines.png is not drawn: there is no matplotlib", said.getvalue())
        self.assertEqual(list(self.folder.iterdir()), [])


class VtpReader(InAFolder):
    def setUp(self) -> None:
        super().setUp()
        self.path = self.folder / "mesh.vtp"
        write_vtp(self.path, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 2, 3]],
                  point_data={"velocity": np.arange(12.0).reshape(4, 3)}, cell_data={"fragment": np.array([7, 8])})

    def test_reads_back_what_was_written(self) -> None:
        mesh = read_vtp(self.path)
        np.testing.assert_array_equal(mesh.points[3], [0, 0, 1])
        np.testing.assert_array_equal(mesh.triangles, [[0, 1, 2], [0, 2, 3]])
        np.testing.assert_array_equal(mesh.point_data["velocity"], np.arange(12.0).reshape(4, 3))
        np.testing.assert_array_equal(mesh.of_triangles("fragment", 0), [7, 8])

    def test_reads_lines_and_an_empty_mesh(self) -> None:
        write_vtp(self.path, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], segments=[[0, 1], [1, 2]])
        np.testing.assert_array_equal(read_vtp(self.path).segments(), [[0, 1], [1, 2]])
        write_vtp(self.path, [])
        self.assertEqual(len(read_vtp(self.path).points), 0)

    FIELDS = (b'<FieldData>\n<DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">2.5e-05</DataArray>\n'
              b'<Array type="String" Name="shell_name" NumberOfTuples="2" format="ascii">\n112 97 110 101 0\n195 164 0\n</Array>\n'
              b'<DataArray type="Float64" Name="shell_area_m2" NumberOfTuples="2" format="ascii">0.25 1 </DataArray>\n</FieldData>\n')

    def test_reads_time_names_and_areas_of_shells(self) -> None:
        self.assertEqual(read_vtp(self.path).field_data, {})
        whole = self.path.read_bytes()
        self.path.write_bytes(whole.replace(b"<Piece", self.FIELDS + b"<Piece"))
        fields = read_vtp(self.path).field_data
        self.assertEqual({name: values.tolist() for name, values in fields.items()},
                         {"TimeValue": [2.5e-5], "shell_name": ["pane", "\u00e4"], "shell_area_m2": [0.25, 1.0]})
        np.testing.assert_array_equal(read_vtp(self.path).triangles, [[0, 1, 2], [0, 2, 3]])
        for old, new in ((b'"2" format="ascii">0.25', b'"3" format="ascii">0.25'), (b">0.25", b">a.25"),
                         (b'Float64" Name="Time', b'Float63" Name="Time'), (b"112 ", b"512 "), (b"195 164 0", b"195 164 9"),
                         (b'"ascii">2.5', b'"binary">2.5')):
            self.assertIn(old, self.FIELDS)
            self.path.write_bytes(whole.replace(b"<Piece", self.FIELDS.replace(old, new) + b"<Piece"))
            with self.assertRaisesRegex(VtpError, "mesh.vtp: field '", msg=old.decode()):
                read_vtp(self.path)

    def test_rejects_every_truncation(self) -> None:
        whole = self.path.read_bytes()
        for length in range(len(whole) - 2):  # the last byte is a line feed
            self.path.write_bytes(whole[:length])
            with self.assertRaises(VtpError, msg=f"first {length} of {len(whole)} bytes"):
                read_vtp(self.path)

    def test_rejects_other_flavours(self) -> None:
        whole = self.path.read_bytes()
        for old, new in ((b"LittleEndian", b"BigEndian   "), (b"UInt64", b"UInt32"), (b"PolyData\" v", b"PolyDatx\" v"),
                         (b"Float32", b"Float16"), (b'"appended"', b'"binary"  '), (b'encoding="raw"', b'encoding="b64"'),
                         (b'NumberOfPoints="4"', b'NumberOfPoints="3"'), (b'NumberOfPolys="2"', b'NumberOfPolys="1"')):
            self.assertIn(old, whole)
            self.path.write_bytes(whole.replace(old, new))
            with self.assertRaises(VtpError, msg=old.decode()):
                read_vtp(self.path)

    def test_rejects_bad_values(self) -> None:
        for points, triangles in (([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]]),
                                  ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]]),
                                  ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, -1]])):
            write_vtp(self.path, points, triangles)
            with self.assertRaises(VtpError):
                read_vtp(self.path)


class Memory(unittest.TestCase):
    def test_an_array_gets_the_pages_of_the_one_before(self) -> None:
        without, with_ = (self.faults(first) for first in ("", "keep_memory()"))
        if without < PAGES:
            self.skipTest(f"the system counts {without} faults of {8 * PAGES} pages")
        self.assertLess(with_, without / 4)

    def faults(self, first: str) -> int:
        """Pages that a process takes for eight arrays one after another, after it has had two."""
        script = f"""if True:
            import resource
            import numpy as np
            from sunder_tools.pictures.memory import keep_memory
            {first}

            def taken(times):
                before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
                for _ in range(times):
                    np.ones({PAGES} * resource.getpagesize() // 8)
                return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

            taken(2)
            print(taken(8))"""
        done = subprocess.run([sys.executable, "-B", "-c", script], check=True, capture_output=True, text=True, env={
            **os.environ, "NUMPY_MADVISE_HUGEPAGE": "0", "PYTHONPATH": os.pathsep.join(sys.path)})
        return int(done.stdout)


class Rasteriser(unittest.TestCase):
    def test_nearest_triangle_wins_and_areas_are_right(self) -> None:
        pixels = np.array([[0, 0], [100, 0], [0, 100], [0, 0], [50, 0], [0, 50]], float)
        index, depth = rasterise(pixels, np.array([1.0, 1, 1, 2, 2, 2]), np.array([[0, 1, 2], [5, 4, 3]]), 120, 110)
        # half a pixel along the slanted edge: area ± its length in pixels
        self.assertAlmostEqual((index == 1).sum(), 1250, delta=50)
        self.assertAlmostEqual((index >= 0).sum(), 5000, delta=100)
        self.assertEqual(depth[index == 1].min(), 2.0)

    def test_unproject_is_the_inverse_of_project(self) -> None:
        points = np.random.default_rng(3).uniform(-0.4, 0.4, (50, 3))
        low, high = points.min(axis=0), points.max(axis=0)
        for camera in (perspective_camera(low, high, np.array([-0.4, 0.8, -0.5]), 400, 300),
                       orthographic_camera(low, np.array([0.0, 1, 0]), np.array([0.0, 0, 1]), 200.0, 900.0, 400, 300)):
            pixels, near = camera.project(points)
            np.testing.assert_allclose(camera.unproject(pixels, near), points, atol=1e-12)  # round-off

    def test_perspective_camera_has_the_box_in_view(self) -> None:
        low, high = np.array([-1.0, -0.5, 0.0]), np.array([0.5, 0.7, 0.8])
        camera = perspective_camera(low, high, np.array([-0.4, 0.8, -0.5]), 400, 300)
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        pixels, _ = camera.project(corners)
        self.assertTrue(((pixels > 0) & (pixels < [400, 300])).all())
        self.assertGreater((np.ptp(pixels, axis=0) / [400, 300]).max(), 0.9, "and fills it")


class ContactSheet(InAFolder):
    def synthetic(self, count: int) -> None:
        run = SyntheticRun(self.folder, elements=12, fragments=20, count=count)
        for k in range(count):
            run.write(k)

    def test_has_its_size_and_shows_something_everywhere(self) -> None:
        self.synthetic(20)
        path = write_contact_sheet(self.folder)
        self.assertEqual(path, self.folder / "contact_sheet.png")
        with Image.open(path) as image:
            self.assertEqual(image.size[0], WIDTH)
            picture = np.asarray(image.convert("L"), float)
        for row in range(3):
            for column in range(4):
                panel = picture[60 + row * 368:400 + row * 368, 20 + column * 488:470 + column * 488]
                self.assertGreater(panel.std(), 5.0, f"panel {row} {column} is blank")
        self.assertGreater(picture[1200:1500, 100:600].std(), 2.0, "crack pattern is blank")
        self.assertGreater(picture[1200:1500, 1000:1900].std(), 5.0, "side view is blank")
        self.assertEqual([p.name for p in self.folder.glob(".*")], [], "a temporary file is left")

    def test_rows_are_full_whatever_the_number_of_frames(self) -> None:
        for count in (1, 2, 3, 5, 7, 9):
            self.synthetic(max(count, 3))
            frames = list_frames(self.folder)[:count]
            with mock.patch.object(contact_sheet, "list_frames", lambda _: frames):
                path = write_contact_sheet(self.folder)
            panels = max(n for n in GRIDS if n <= count)
            columns = GRIDS[panels]
            self.assertEqual(panels % columns, 0)
            width = (WIDTH - 8) // columns - 8
            height = min(3 * width // 4, 640)
            with Image.open(path) as image:
                picture = np.asarray(image.convert("L"), float)
            for k in range(panels):
                top, left = 44 + k // columns * (height + 8), 8 + k % columns * (width + 8)
                self.assertGreater(picture[top:top + height, left:left + width].std(), 4.0, f"{k} of {count}")

    def test_the_title_has_scene_material_and_speed(self) -> None:
        self.synthetic(3)
        (self.folder / SCENE_COPY).write_text(
            'materials { name: "glass" density: 2500 } shells { name: "pane" material: "glass" thickness_m: 0.004 }'
            'bodies { name: "ball" material: "glass" sphere { radius_m: 0.02 } twist { linear { z: -8 } } }')
        run = {"status": "done", "scene": "pane_of_a_shop", "counts": {"fragments": 9, "handed_off": 4}}
        (self.folder / "run.json").write_text(json.dumps(run))
        with mock.patch.object(contact_sheet, "draw_text") as written:
            write_contact_sheet(self.folder)
        title = written.call_args_list[-1].args[2]
        self.assertEqual(title.split("     "), ["pane_of_a_shop", "glass 4 mm", "ball 8 m/s",
                                                "9 fragments, 4 handed to the rigid engine"])
        (self.folder / "run.json").write_text(json.dumps(run | {"counts": {"fragments": 1, "handed_off": 0}}))
        with mock.patch.object(contact_sheet, "draw_text") as written:
            write_contact_sheet(self.folder)
        self.assertEqual(written.call_args_list[-1].args[2].split("     ")[-1], "1 fragment, 0 handed to the rigid engine")
        (self.folder / "run.json").write_text(json.dumps({"status": "failed"}))
        with mock.patch.object(contact_sheet, "draw_text") as written:
            write_contact_sheet(self.folder)
        self.assertEqual(written.call_args_list[-1].args[2].split("     ")[:2], [self.folder.resolve().name, "failed"])

    def test_the_title_names_three_kinds_of_sheets_and_says_that_there_are_more(self) -> None:
        self.synthetic(3)
        for count, wanted in ((3, "a 1 mm, b 2 mm, c 3 mm"), (5, "a 1 mm, b 2 mm, c 3 mm, \u2026")):
            (self.folder / SCENE_COPY).write_text("".join(
                f'materials {{ name: "{name}" density: 2500 }} shells {{ name: "pane_{name}" material: "{name}" thickness_m: {k + 1}e-3 }}'
                for k, name in enumerate("abcde"[:count])))
            with mock.patch.object(contact_sheet, "draw_text") as written:
                write_contact_sheet(self.folder)
            self.assertIn(wanted, written.call_args_list[-1].args[2].split("     "))

    def test_modes_are_drawn_with_thickness_and_material(self) -> None:
        self.synthetic(20)
        (self.folder / SCENE_COPY).write_text('materials { name: "plaster" } shells { name: "pane" material: "plaster" thickness_m: 0.02 }')
        told = {"name": "pane", "drawn_amplitude_m": 1e-3, "modes": [{"mode": k + 1, "frequency_Hz": 10.0 * k} for k in range(2)]}
        (self.folder / modes_sheet.TABLE).write_text(json.dumps(told))
        with mock.patch.object(modes_sheet, "draw_scene", wraps=draw_scene) as drawn:
            path = modes_sheet.write_modes_sheet(self.folder)
        self.assertEqual(drawn.call_count, 2)
        for call in drawn.call_args_list:
            self.assertEqual(call.args[0].thickness_m, 0.02)
            base = call.args[0].solid.colours
            self.assertTrue((np.abs(base - PLASTER.colour).max(axis=1) < 0.06).any(), "no plaster")
        with Image.open(path) as image:
            self.assertGreater(np.asarray(image.convert("L"), float)[60:340, 20:400].std(), 8.0, "blank")

    def test_no_frames(self) -> None:
        self.synthetic(3)
        (self.folder / "frames.pvd").write_text("<VTKFile><Collection/></VTKFile>")
        with self.assertRaises(VtpError):
            write_contact_sheet(self.folder)

    def test_the_ground_is_the_floor_or_below_everything(self) -> None:
        self.synthetic(9)
        scenes = [load_scene(frame) for frame in list_frames(self.folder)[::4]]
        low, high = np.array([-0.3, -0.3, 0.0]), np.array([0.3, 0.3, 0.6])
        ground = ground_of(scenes, low, high)
        self.assertEqual(ground.z, 0.0)
        stand(scenes[0], ground)
        self.assertFalse(scenes[0].solid.is_floor.any(), "the floor is drawn twice")
        wide = ground_of(scenes[1:], 5.0 * low, 5.0 * high)  # the floor of 2 by 2 m ends in the picture
        self.assertLess(wide.z, 0.0)
        self.assertEqual(ground_of(scenes[1:], 5.0 * low, 5.0 * high, endless=True).z, 0.0)
        stand(scenes[1], wide)
        self.assertTrue(scenes[1].solid.is_floor.any())

    def test_pieces_throw_shadows_on_the_ground_and_on_pieces(self) -> None:
        self.synthetic(9)
        frame = list_frames(self.folder)[0]
        scene = load_scene(frame)
        shadows = Shadows(scene)
        pane = scene.glass.points[:, 2].mean()
        up = np.array([[0.0, 0.0, 1.0]])
        under = np.array([[-0.1, 0.1, pane]]) - 0.2 * LIGHT  # of the pane
        self.assertAlmostEqual(float(shadows.below(under)[0]), GLASS, places=6)
        self.assertAlmostEqual(float(shadows.on(under, up)[0]), GLASS, places=6)
        ball = scene.solid.round_centre[np.isfinite(scene.solid.round_centre[:, 0])][0]
        beneath = ball - (ball[2] - pane) / LIGHT[2] * LIGHT  # of the ball, on the pane
        self.assertAlmostEqual(float(shadows.on(beneath[None], up)[0]), SOLID, places=6)
        self.assertEqual(float(shadows.on(np.array([[0.2, -0.2, pane]]), up)[0]), 0.0, "the pane shades itself")
        self.assertEqual(float(shadows.below(np.array([[40.0, 0.0, 0.0]]))[0]), 0.0)

    def test_white_is_white_from_below(self) -> None:
        """A porcelain bowl's outside looks down; it was as dark as slate."""
        surface = _surface(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]), np.full((1, 3), 0.94))
        ends, corners = np.zeros((0, 2, 3)), np.zeros((0, 3))
        shader, shadows = _Shader(surface), Shadows(Scene(Surface(), surface, ends, ends, corners, corners, None))
        at, eye = np.full((1, 3), 0.2, np.float32) * [[1, 1, 0]], np.array([[0.0, 0.0, 1.0]])
        above, below = (float(shader.opaque(np.array([0]), at.astype(np.float32), (sign * eye).astype(np.float32), shadows)[0, 0])
                        for sign in (1.0, -1.0))
        self.assertGreater(below, 0.7)
        self.assertGreater(above, below + 0.1)

    def test_the_floor_shows_through_glass_and_its_edge_is_deep(self) -> None:
        self.synthetic(9)
        scene = load_scene(list_frames(self.folder)[0], Look(glass=(True,), thickness=(THICKNESS_M,)))
        self.assertEqual(scene.thickness_m, THICKNESS_M)
        middle = 0.5 * (scene.glass.points.min(axis=0) + scene.glass.points.max(axis=0))
        camera = perspective_camera(middle - 0.3, middle + 0.3, np.array([-0.3, 0.6, -0.7]), 400, 300)
        pixels, near = camera.project(scene.glass.points)
        pane, _ = rasterise(pixels, near, scene.glass.triangles, 400, 300)
        pictures = []
        for grey in (0.2, 0.9):
            scene.solid.colours = np.full_like(scene.solid.colours, grey)
            pictures.append(draw_scene(scene, camera, 400, 300).reshape(-1, 3))
        change = (pictures[1] - pictures[0]) / 0.7
        face = (pane >= 0) & ~scene.glass.edge[pane]
        edge = (pane >= 0) & scene.glass.edge[pane]
        self.assertGreater(face.sum(), 10_000)
        self.assertGreater(edge.sum(), 100)
        through = np.median(change[face], axis=0)
        self.assertGreater(through.min(), 0.6)
        self.assertLess(through[0], through[1])  # glass is greenish
        self.assertLess(np.median(change[edge], axis=0)[0], 0.5 * through[0])
        green = [float(np.median(picture[:, 1] / picture[:, 0])) for picture in (pictures[1][face], pictures[1][edge])]
        self.assertGreater(green[1] - 1.0, 2.0 * (green[0] - 1.0))  # an edge is seen along the sheet

    def test_pieces_that_have_left_are_in_the_pattern_where_they_were(self) -> None:
        self.synthetic(20)
        frames = list_frames(self.folder)
        shells = [frame for frame in frames if SHELL in frame.files]
        last, before = shells[-1].read(SHELL), shells[6].read(SHELL)
        assert last is not None and before is not None
        self.assertLess(len(last.triangles), len(before.triangles))
        births = np.array([0.5 * (shells[6].time_s + shells[7].time_s)])
        left_out = crack_pattern(frames, np.zeros(0), np.zeros(0), 300, 300)
        put_in = crack_pattern(frames, births, np.array([0.01]), 300, 300)
        assert left_out is not None and put_in is not None
        without, whole = left_out[0], put_in[0]
        new = (np.abs(whole - without) > 1e-9).any(axis=2)
        self.assertGreater(new.mean(), 0.05)
        empty = (without == background(300, 300).reshape(300, 300, 3)).all(axis=2)
        self.assertGreater((new & empty).sum() / new.sum(), 0.9)  # the last frame stays, but for lines of two pixels at its border

    def test_breaking_gets_more_panels_than_its_share_of_time(self) -> None:
        self.synthetic(60)
        frames = list_frames(self.folder)
        chosen = choose_frames(frames, 12)
        self.assertEqual(len(chosen), 12)
        self.assertEqual((chosen[0], chosen[-1]), (frames[0], frames[-1]))
        self.assertEqual([f.time_s for f in chosen], sorted({f.time_s for f in chosen}))
        self.assertGreaterEqual(sum(f.time_s < 2e-3 for f in chosen), 4)

    def test_times_read_well(self) -> None:
        self.assertEqual([time_text(t) for t in (0.0, 3.5e-4, 9.999e-4, 4.2e-3, 0.25, 1.25)],
                         ["0", "350 µs", "1 ms", "4.2 ms", "250 ms", "1.25 s"])
        self.assertEqual([moment_text(Frame(t, {}, step)) for t, step in ((2.0, False), (2.0, True), (1.125, True))],
                         ["2 s", "load step 2", "load step 1.125"])


if __name__ == "__main__":
    unittest.main()
