"""The figures of the paper: their scenes have its values, one is run and drawn whole, nothing is run twice."""
from __future__ import annotations

import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from PIL import Image

from . import REPOSITORY
from sunder_lab.paper import skeleton
from sunder_lab.paper.catalogue import CASES, CORES, SIZES, TABLE_2, scaled
from sunder_lab.paper.depth import outside
from sunder_lab.paper.figures import FIGURES
from sunder_lab.paper.page import command, measured, state, table
from sunder_lab.paper.panels import GAP, HEAD, shell_frames
from sunder_lab.paper.runs import Record, Runs, about, left
from sunder_lab.paper.views import TALL, _off_body, figure_16, hanging_together
from sunder_lab.scene import SCENES, Scene
from sunder_tools.command import paper as subcommand
from sunder_tools.errors import DONE, CommandError
from sunder_tools.launch.run import COMMAND_FILE, USAGE_FILE, Job, run_scene
from sunder_tools.pictures.crack_lines import Graph, within
from sunder_tools.pictures.frames import BODIES, SHELL
from sunder_tools.pictures.vtp import PolyData
from sunder_tools.report.run_json import read_run
from sunder_tools.report.summary import summary

PAPER = SCENES / "paper"
sys.path.append(str(PAPER))
import make_bunnies  # noqa: E402
import make_garment  # noqa: E402
import make_mannequin  # noqa: E402

SUNDER = str(REPOSITORY / "coupler" / "sunder")
# Table 2: density, Young's modulus, Poisson's ratio, strength (0: none).
VALUES = {("fig01", "bumper_plastic"): (500, 3.2e8, 0.3, 6.5e6), ("fig01", "painted_steel"): (500, 3.2e8, 0.3, 6.5e6),
          ("fig01", "window_glass"): (300, 2.8e9, 0.3, 8.2e6),
          ("fig04_healing", "rubber"): (500, 3.2e5, 0.3, 4.5e4), ("fig09_ours", "film"): (100, 3.2e3, 0.3, 1.5e2),
          ("fig12", "metal"): (1e3, 3.2e5, 0.33, 8e4), ("fig13", "rubber"): (1000, 4.2e5, 0.3, 0),
          ("fig14_even", "cloth"): (100, 2.8e5, 0.3, 5.5e4), ("fig15", "cloth"): (20, 3.2e3, 0.3, 5e2),
          ("fig16", "cloth"): (20, 3.2e3, 0.3, 5e2),
          ("fig17", "glass"): (4e3, 3.2e10, 0.18, 2.2e7)}
POINTS = 0.2  # share by which a full size may miss the points of Table 2


def read_obj(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles, which count from 0."""
    words = [line.split() for line in path.read_text().splitlines()]
    return (np.array([[float(x) for x in w[1:]] for w in words if w[0] == "v"]),
            np.array([[int(i) - 1 for i in w[1:]] for w in words if w[0] == "f"]))


def sunder(*arguments: str) -> tuple[int, str]:
    """Exit status, and what was said."""
    done = subprocess.run([SUNDER, "paper", *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)
    return done.returncode, done.stdout


class Catalogue(unittest.TestCase):
    def test_all_figures_are_there_and_all_cases_are_drawn(self) -> None:
        self.assertEqual(list(FIGURES), list(range(1, subcommand.FIGURES + 1)))
        used = {case for figure in FIGURES.values() for case in figure.cases}
        self.assertEqual(used, set(CASES))
        for figure in FIGURES.values():
            self.assertEqual(figure.draw is not None, bool(figure.cases), figure.number)
            self.assertEqual(bool(figure.differs), figure.draw is not None, figure.number)

    def test_scenes_have_the_values_of_table_2(self) -> None:
        for (case, name), wanted in VALUES.items():
            m = CASES[case].made("full").find(f"materials[{name}]")
            self.assertEqual((m.density, m.youngs_modulus, m.poisson_ratio, m.strength), wanted, case)
        factor = CASES["fig14_weakened"].made("full").find("shells[cloth].strength_regions[0]").factor
        self.assertAlmostEqual(factor * 5.5e4, 8e3, delta=1e-6)
        self.assertEqual(CASES["fig14_even"].made("full").find("shells[cloth].strength_regions[0]").factor, 1.0)

    def test_every_case_is_accepted_and_full_ones_have_the_points_of_table_2(self) -> None:
        points = {row.case: row.points for row in TABLE_2}
        for name, case in CASES.items():
            report = case.made("small").check()
            self.assertIn("substeps", report, name)
            if name in points:
                found = sum(int(n) for n in re.findall(r"^layer points\s+(\d+)$", case.made("full").check(), re.MULTILINE))
                self.assertAlmostEqual(found / points[name], 1.0, delta=POINTS, msg=name)

    def test_a_command_line_makes_the_scene_of_the_case(self) -> None:
        for size in SIZES:
            for name in CASES:
                self.assertIn(CASES[name].file(), command(name, size))
                self.assertTrue((REPOSITORY / CASES[name].file()).is_file())
        self.assertIn("--set 'shells[sheet].stress_model=JGT17'", command("fig09_jgt17", "small"))

    def assert_same_scene(self, made: str, kept: str, message: str) -> None:
        """Texts are the same but for the last of six decimals, which libraries of linear algebra round either way."""
        number = re.compile(r"-?[0-9]+\.[0-9]{1,6}(?![0-9e])")
        self.assertEqual(number.sub("#", made), number.sub("#", kept), message)
        for one, other in zip(number.findall(made), number.findall(kept), strict=True):
            self.assertLessEqual(abs(float(one) - float(other)), 1.01e-6, message)

    def test_scenes_are_what_the_scripts_make(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for name, part, note, lines in (
                    ("fig14", "bunnies", "made by make_bunnies.py", make_bunnies.scene_text()),
                    ("fig15", "garment", make_garment.made_by(make_garment.SPACING_M), make_garment.scene_text(make_garment.SPACING_M)),
                    ("fig16", "dress", make_mannequin.made_by(make_mannequin.SPACING_M),
                     make_mannequin.scene_text(make_mannequin.SPACING_M))):
                scene = PAPER / f"{name}.textproto"
                copy = Path(shutil.copy(scene, folder))
                copy.write_text(re.sub(rf"(?s)(# begin {part}).*?(# end {part})", r"\1\n\2", copy.read_text()))
                make_bunnies.replace_part(copy, part, note, lines)
                self.assert_same_scene(copy.read_text(), scene.read_text(), f"{name}: run its script again")
        for piece in make_bunnies.PARTS:
            self.assertEqual((PAPER / f"bunny_{piece.name}.off").read_text(), make_bunnies.off_text(piece))

    def test_panels_meet_to_round_off(self) -> None:
        for panels in (make_garment.panels(), make_mannequin.panels()):
            by_name = {p.name: p.net for p in panels}
            for where in ("front", "back"):
                row = [f"{where}_{name}" for name in (make_garment.NAMES if where == "back" else make_garment.NAMES[::-1])]
                for one, other in zip(row, row[1:]):
                    np.testing.assert_allclose(by_name[one][:, -1], by_name[other][:, 0], atol=1e-12)
            for side in ("left", "right"):
                np.testing.assert_array_equal(by_name[f"shoulder_{side}"][0], by_name[f"front_strap_{side}"][-1])
                np.testing.assert_array_equal(by_name[f"shoulder_{side}"][-1], by_name[f"back_strap_{side}"][-1][::-1])

    def test_the_mannequin_is_what_its_script_makes_and_swells_everywhere(self) -> None:
        points, triangles = make_mannequin.figure()
        rest, swollen = read_obj(PAPER / "mannequin.obj"), read_obj(PAPER / "mannequin_inflated.obj")
        np.testing.assert_allclose(rest[0], points, atol=1e-5)
        np.testing.assert_allclose(swollen[0], make_mannequin.inflated(points), atol=1e-5)
        for mesh in (rest, swollen):
            np.testing.assert_array_equal(mesh[1], triangles)
        self.assertLess(np.abs(make_mannequin.distance(points)).max(), 1e-3)
        volume = [np.einsum("ij,ij->i", p[triangles[:, 0]], np.cross(p[triangles[:, 1]], p[triangles[:, 2]])).sum() / 6.0
                  for p in (points, make_mannequin.inflated(points))]
        self.assertGreater(volume[0], 0.02)  # faces look outwards
        self.assertGreater(volume[1], 1.5 * volume[0])
        trunk = (np.abs(points[:, 0]) < 0.15) & (points[:, 2] > 0.0) & (points[:, 2] < 0.7)  # arms move aside
        out = outside(make_mannequin.inflated(points)[trunk], points, triangles)
        self.assertGreater(out.min(), -2e-3)  # where faces of the one cut corners of the other
        self.assertGreater(out.max(), 0.06)


class Skeleton(unittest.TestCase):
    def test_of_a_bar_is_its_middle_line_and_of_a_ring_a_ring(self) -> None:
        bar = np.zeros((21, 60), bool)
        bar[8:13, 5:55] = True
        line = skeleton.thinned(bar)
        self.assertLessEqual(set(np.nonzero(line)[0]), {9, 10, 11})
        self.assertGreater(line.sum(), 40)
        self.assertLessEqual(line.sum(axis=0).max(), 2)
        y, x = np.mgrid[-20:21, -20:21]
        ring = np.abs(np.hypot(x, y) - 12.0) < 3.0
        line = skeleton.thinned(ring)
        self.assertFalse(line[20, 20])
        self.assertGreater(line.sum(), 2 * 3.14 * 12 * 0.7)
        self.assertTrue((np.abs(np.hypot(x, y)[line] - 12.0) < 2.0).all())

    def test_cracks_are_measured_against_a_box(self) -> None:
        ends = np.array([[[0.1, 0.1], [0.4, 0.5]], [[0.4, 0.5], [0.4, 1.5]], [[0.4, 1.5], [0.4, 2.0]]])
        graph = Graph(ends, np.zeros((3, 2, 3)), np.zeros(3, int), np.array([2.0, 1.0, 3.0]))
        found = within(graph, np.array([0.0, 0.0]), np.array([1.0, 0.9]))
        self.assertAlmostEqual(found.length, 2.0)
        self.assertAlmostEqual(found.share, 0.25)
        self.assertFalse(found.first)
        self.assertTrue(within(graph, np.array([0.0, 0.0]), np.array([1.0, 1.1])).first)
        self.assertTrue(math.isnan(within(graph.some(graph.born < 0.0), np.zeros(2), np.ones(2)).share))

    def test_what_has_moved_is_counted(self) -> None:
        one = np.zeros((20, 20), bool)
        one[5] = True
        other = np.roll(one, 2, axis=0)
        self.assertEqual(skeleton.moved(one, other, 2), 0.0)
        self.assertEqual(skeleton.moved(one, other, 1), 1.0)
        other[7, 10:] = False
        self.assertAlmostEqual(skeleton.moved(one, other, 2), 0.4)  # two pixels more by the reach


class Depth(unittest.TestCase):
    def test_of_a_cube_is_that_to_its_faces_edges_and_corners(self) -> None:
        corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
        points = np.array([[0.5, 0.4, 1.2], [0.3, 0.1, 0.4], [1.1, 0.5, 1.1], [-0.3, -0.3, -0.3], [0.9, 0.2, 0.7]])
        np.testing.assert_allclose(outside(points, corners, triangles), [0.2, -0.1, 0.02 ** 0.5, 0.27 ** 0.5, -0.1], atol=1e-12)

    def test_points_without_a_face_do_not_count(self) -> None:
        corners = np.array([[9.0, 9.0, 9.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        self.assertAlmostEqual(float(outside(np.array([[0.2, 0.2, 0.5]]), corners, np.array([[1, 2, 3]]))[0]), 0.5)


class Pieces(unittest.TestCase):
    def test_hang_together_by_points_at_one_place(self) -> None:
        rows = [np.array([[k, 0.0, 0.0], [k + 1, 0.0, 0.0], [k, 1.0, 0.0], [k + 1, 1.0, 0.0]]) for k in (0, 1, 2, 5, 6)]
        points = np.concatenate(rows)  # five squares: three in a row, then two; each has points of its own
        squares = [4 * k + np.array([[0, 1, 2], [1, 3, 2]]) for k in (3, 0, 4, 2, 1)]
        found = hanging_together(PolyData(points, triangles=np.concatenate(squares)))
        self.assertEqual(len(set(found)), 2)
        self.assertEqual([found[2 * k] == found[0] for k in range(5)], [True, False, True, False, False])
        np.testing.assert_array_equal(found[0::2], found[1::2])


class Mannequin(unittest.TestCase):
    """Figure 16 of a run with few elements, until the dress tears."""

    def test_dress_pieces_and_depths_are_those_of_the_run(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            runs = Runs(Path(name), "small", "1", True)
            runs.open()
            scene = PAPER / "fig16.textproto"
            settings = (*scaled(Scene.load(scene), 0.1), "end_time_s=0.36", "output.frame_interval_s=0.04")
            folder = runs.place("fig16")
            self.assertEqual(run_scene(Job(scene, settings=settings, threads="1"), folder, quiet=True), DONE)
            drawn = figure_16(runs)
            self.assertEqual([picture for picture, _ in drawn.pictures], ["fig16.png"])
            with Image.open(runs.folder / "fig16.png") as image:
                width, height = TALL[0] + GAP, TALL[1] + HEAD + GAP
                self.assertEqual(image.size, (6 * width + GAP, 2 * height + GAP))
                panels = [[np.asarray(image.convert("RGB").crop((GAP + k * width, GAP + HEAD + row * height, (k + 1) * width,
                                                                 (row + 1) * height)), float) for k in range(6)] for row in (0, 1)]
            spread = [[np.ptp(panel, axis=2).max() for panel in row] for row in panels]
            for row in spread:
                self.assertGreater(row[0], 25.0)  # patches have colours; body, sky and ground are grey
            self.assertGreater(np.abs(panels[0][4] - panels[0][5]).max(), 40.0)  # by patch, by piece
            self.assertGreater(np.abs(panels[0][0] - panels[1][0]).max(), 40.0)  # from the front, from behind
            run, frames = read_run(folder), shell_frames(folder)
            self.assertGreater(run["cracks"]["length_m"], 0.1)
            self.assertIn(f"{run['cracks']['length_m']:.2f} m long", drawn.found[0])
            told = re.match(r"(\d+) pieces of a hundredth of the cloth or more; cracks in (\d+) of 12 patches", drawn.found[0])
            assert told is not None, drawn.found
            self.assertGreaterEqual(int(told[1]), 1)
            self.assertLessEqual(int(told[2]), 12)
            depth = re.search(r"deepest point of the dress is (-?[\d.]+) mm in the body.* at ([\d.]+) s", drawn.found[1])
            assert depth is not None, drawn.found
            half = 0.5 * Scene.load(scene).message.shells[0].thickness_m
            deepest, deepest_s = float(depth[1]), float(depth[2])
            at = min(frames, key=lambda frame: abs(frame.time_s - deepest_s))
            shell, bodies = at.read(SHELL), at.read(BODIES)
            assert shell is not None and bodies is not None
            far = outside(shell.points[np.unique(shell.triangles)], bodies.points, bodies.triangles)
            self.assertAlmostEqual(deepest, 1e3 * (half - far.min()), delta=0.06)
            self.assertGreater(_off_body(frames[0]).min(), half)  # the dress starts off the body
            self.assertEqual([(check.name, check.most) for check in drawn.checks], [("fig16_depth", half)])
            self.assertAlmostEqual(drawn.checks[0].value, half - far.min(), delta=6e-5)


class Garment(unittest.TestCase):
    """Figure 15 in its small size: "bifurcate at patch borders and leave three fragments", says the paper."""

    def test_straps_tear_off_and_leave_three_parts(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            case = CASES["fig15"]
            folder = Path(name) / "run"
            job = Job(REPOSITORY / case.file(), settings=tuple(case.all_settings("small")), threads="2")
            self.assertEqual(run_scene(job, folder, quiet=True), DONE)
            run = read_run(folder)
            held, rest = run["surface"]["held_together_m2"], run["surface"]["rest_m2"]
            self.assertEqual((len(held), run["surface"]["parts_at_rest"]), (3, 1))
            self.assertGreater(held[0], 0.9 * rest)           # the garment, and two straps that are alike
            self.assertLess(held[1] - held[2], 0.2 * held[1])
            self.assertLess(abs(run["energy"]["residual_relative"]), 0.01)
            self.assertIn("; damage parts the shells into 3", summary(folder, None))


class Told(unittest.TestCase):
    def test_time_left_follows_the_run_once_it_is_under_way(self) -> None:
        self.assertEqual(left(10.0, 0.0, 60.0), 50.0)
        self.assertEqual(left(10.0, 0.25, 60.0), 30.0)
        self.assertEqual(left(100.0, 0.05, 60.0), 10.0)
        self.assertEqual([about(s) for s in (0.0, 40.0, 300.0, 9000.0)],
                         ["about 1 s", "about 40 s", "about 5 min", "about 2.5 h"])

    def test_ratios_are_of_core_seconds(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            runs = Runs(Path(name), "small", "1", True)
            folder = runs.place("fig13")
            folder.mkdir(parents=True)
            (folder / "run.json").write_text(json.dumps({"status": "done", "counts": {"layer_points": 16000},
                                                         "time": {"substeps": 1000, "wall_s": 2.0}}))
            (folder / USAGE_FILE).write_text(json.dumps({"processor_s": 3.0, "wall_s": 2.5}))
            (folder / COMMAND_FILE).write_text(json.dumps({"threads": "2"}))
            found = measured(runs, "fig13")
            self.assertEqual(found, {"points": 16000.0, "steps": 1000.0, "step_s": 2e-3, "threads": 2.0, "core_s": 3e-3})
            rows = [re.findall(r"<td>(.*?)</td>", line) for line in table(runs) if line.startswith("<tr><td>13<")]
            self.assertEqual(rows[0][7:10], [f"{CORES * 1.23 * 8000:,.0f}", "3", f"{CORES * 1.23 * 8000 / 3.0:,.0f}"])  # in all
            self.assertEqual(rows[0][-4], f"{CORES * 1.23 / 3e-3:,.0f}")          # a step
            self.assertEqual(rows[0][-1], f"{CORES * 1.23 / 160e3 / (3e-3 / 16e3):,.0f}")  # a step and point
            self.assertEqual(measured(runs, "fig12"), {})
            (folder / "run.json").write_text('{"status": "failed"}')
            self.assertEqual(measured(runs, "fig13"), {})

    def test_a_scene_that_is_edited_while_it_runs_is_run_again(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            runs = Runs(Path(name), "small", "1", True)
            runs.open()
            scene = ["as it ran"]

            def edited(_: Runs, case: str) -> tuple[int, str]:
                scene[0] += ", edited"
                return DONE, ""

            with mock.patch.object(Runs, "identity", lambda self, case: scene[0]):
                with mock.patch.object(Runs, "_one", edited):
                    self.assertTrue(runs.run(("fig13",)))
                self.assertEqual(runs.record.cases["fig13"]["identity"], "as it ran")
                self.assertFalse(runs.done("fig13"))

    def test_a_record_that_cannot_be_read_is_begun_anew(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            (Path(name) / "paper.json").write_text("[1, 2")
            self.assertEqual(Record.read(Path(name)), Record(Path(name)))


class Refused(unittest.TestCase):
    def test_figures_that_there_are_not(self) -> None:
        for figure in ("0", "19", "-1", "four", "1.5"):
            status, said = sunder("--figure", figure)
            self.assertEqual(status, 2, said)
            self.assertIn("1 to 18" if not figure.startswith("-") else "--figure", said)
        self.assertEqual(sunder("--size", "huge")[0], 2)

    def test_a_folder_that_cannot_be_written(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            (Path(name) / "file").write_text("")
            status, said = sunder("--figure", "9", "--out", str(Path(name) / "file" / "out"))
            self.assertEqual(status, 2, said)
            self.assertIn("cannot be written", said)
            self.assertEqual([p.name for p in Path(name).iterdir()], ["file"])

    def test_a_drawing_of_the_method_is_said_to_be_one(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            status, said = sunder("--figure", "6", "--out", name)
            self.assertEqual(status, 0)
            self.assertIn("figure 6: A drawing of the method", said)


class Whole(unittest.TestCase):
    """Figure 9 from the command line: four runs."""
    out: Path
    status: int
    said: str

    @classmethod
    def setUpClass(cls) -> None:
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.out = Path(temporary.name)
        cls.status, cls.said = sunder("--figure", "9", "--threads", "1", "--out", str(cls.out))

    def test_a_figure_is_run_drawn_and_on_the_page(self) -> None:
        self.assertEqual(self.status, 0, self.said)
        self.assertRegex(self.said, r"fig09_ours, run 1 of 4: 0 %, about \d+ (s|min) left of all")
        page = (self.out / "small" / "index.html").read_text()
        self.assertNotRegex(page, r"https?://|//cdn|<script")
        for name in re.findall(r"<img src='([^']+)'", page):
            self.assertTrue((self.out / "small" / name).is_file(), name)
        self.assertIn("<img src='fig09.png'", page)
        area = re.search(r"the paper&#x27;s projection: ([\d.]+) m2 in 2 pieces", page)
        assert area is not None, page[:4000]
        self.assertAlmostEqual(float(area[1]), 1.0, delta=0.02)  # torn in two and come back; the paper: 0.994
        row = re.search(r"<tr><td>9</td>.*?</tr>", page)
        assert row is not None
        self.assertIn("<td>28,800</td>", row[0])
        runs = Runs(self.out, "small", None, True)
        self.assertEqual((state(runs, FIGURES[9]), state(runs, FIGURES[12]), state(runs, FIGURES[2])),
                         ("drawn", "not run", "a drawing"))

    def test_nothing_is_run_twice_and_a_changed_scene_is(self) -> None:
        places = [self.out / "small" / "runs" / case / "run.json" for case in FIGURES[9].cases]
        before = [place.stat().st_mtime_ns for place in places]
        self.assertEqual(sunder("--figure", "9", "--threads", "1", "--out", str(self.out), "--quiet")[0], 0)
        self.assertEqual([place.stat().st_mtime_ns for place in places], before)
        kept = self.out / "small" / "paper.json"
        told = json.loads(kept.read_text())
        told["cases"]["fig09_ghf18"]["identity"] = "of another scene"
        kept.write_text(json.dumps(told))
        status, said = sunder("--figure", "9", "--threads", "1", "--out", str(self.out))
        self.assertEqual(status, 0, said)
        self.assertIn("fig09_ghf18, run 1 of 1", said)
        self.assertEqual([place.stat().st_mtime_ns for place in places][:3], before[:3])
        self.assertNotEqual(places[3].stat().st_mtime_ns, before[3])

    def test_a_run_that_fails_is_on_the_page_with_status_1(self) -> None:
        build = self.out / "build"
        for name in ("shell/sunder-shell", "rigid/sunder-rigid"):  # checks pass, runs end at once
            (build / name).parent.mkdir(parents=True, exist_ok=True)
            (build / name).write_text("#!/bin/sh\ncase \"$*\" in *--check*) exit 0;; esac\necho no luck >&2\nexit 4\n")
            (build / name).chmod(0o755)
        done = subprocess.run([SUNDER, "paper", "--figure", "12", "--out", str(self.out / "failed")], text=True, check=False,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              env={**os.environ, "SUNDER_BUILD_DIR": str(build)})
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("fig12 failed", done.stdout)
        self.assertIn("fig12 failed", (self.out / "failed" / "small" / "index.html").read_text())


class Stopped(unittest.TestCase):
    def test_it_goes_on_with_the_run_that_was_stopped(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            out = Path(name)
            process = subprocess.Popen([SUNDER, "paper", "--figure", "12", "--threads", "1", "--out", name], text=True,
                                       stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            try:
                while process.poll() is None and not (out / "small" / "runs" / "fig12" / "run.json").is_file():
                    time.sleep(0.1)
                process.send_signal(signal.SIGINT)
                said = process.communicate()[0]
            finally:
                process.kill()
                process.wait()
            self.assertEqual(process.returncode, 130, said)
            self.assertIn("Not run yet", (out / "small" / "index.html").read_text())
            runs = Runs(out, "small", None, True)
            self.assertFalse(runs.done("fig12"))
            self.assertEqual(runs.failure("fig12"), "")


class Folder(unittest.TestCase):
    def test_that_others_write_to_is_refused(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            runs = Runs(Path(name), "small", None, True)
            runs.open()
            (runs.folder / "paper.json").mkdir()
            with self.assertRaisesRegex(CommandError, "cannot write .*paper.json"):
                runs.record.write()
            runs.close()

    def test_belongs_to_one_process_at_a_time(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            first, second, other = (Runs(Path(name), size, None, True) for size in ("small", "small", "full"))
            first.open()
            with self.assertRaisesRegex(CommandError, "another 'paper' is at work on the small size there; wait for it"):
                second.open()
            other.open()
            first.record.cases["fig12"] = {"identity": "x"}
            first.record.write()
            first.close()
            second.open()
            self.assertIn("fig12", second.record.cases)  # what the first one wrote meanwhile
            for runs in (second, other):
                runs.close()


if __name__ == "__main__":
    unittest.main()
