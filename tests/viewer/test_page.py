"""The page of `sunder view` in Chromium with software WebGL: it draws every triangle, plays, grows, and stays at home."""
from __future__ import annotations

import http.server
import os
import tempfile
import threading
import unittest
from pathlib import Path

import numpy as np

from sunder_tools.launch.build import ensure_built
from sunder_tools.launch.run import launch_once
from sunder_tools.pictures.frames import BODIES, SHELL, list_frames
from sunder_tools.pictures.motion import body_velocity
from sunder_tools.pictures.palette import ramp
from sunder_tools.pictures.sheets import sheet_of
from sunder_tools.pictures.view import Server, packages
from sunder_tools.places import BUILD_DIR_VARIABLE
from sunder_tools.report.scene_text import scene_words
from tests import REPOSITORY
from tests.command.synthetic import SyntheticRun
from tests.viewer.browser import Browser, find_browser

COUNT, AT_FIRST = 15, 12  # frames in all, and those that are there when the page is opened
CANVAS = (slice(40, 560), slice(0, 840))  # of the screen, without the head and the controls


class InABrowser(unittest.TestCase):
    """Serves `folder` to `browser`."""
    folder: Path
    server: Server
    browser: Browser

    @classmethod
    def setUpClass(cls) -> None:
        program = find_browser()
        if program is None:
            raise unittest.SkipTest("no chromium; as root: apt-get install chromium")
        if not (packages() / "three" / "build" / "three.module.js").is_file():
            raise unittest.SkipTest("no three.js; 'sunder view' or 'sunder test' installs it")
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        cls.make_run()
        cls.server = Server(cls.folder)
        thread = threading.Thread(target=cls.server.serve_forever, args=(0.05,))
        thread.start()
        cls.addClassCleanup(cls.server.server_close)
        cls.addClassCleanup(thread.join)
        cls.addClassCleanup(cls.server.shutdown)
        cls.browser = Browser(program)
        cls.addClassCleanup(cls.browser.close)

    @classmethod
    def make_run(cls) -> None:
        """Fills the folder."""
        raise NotImplementedError

    def setUp(self) -> None:
        self.browser.requests.clear()
        self.browser.said.clear()
        self.browser.open(self.server.url)
        self.shown(0)
        self.drawn(0)

    def shown(self, k: int) -> None:
        self.browser.wait("document.body.dataset.frame", lambda frame: frame == str(k))

    def drawn(self, k: int) -> None:
        """Every triangle of the frame is handed to the graphics."""
        frame = list_frames(self.folder)[k]
        shell, bodies = frame.read(SHELL), frame.read(BODIES)
        wanted = len(bodies.triangles) if bodies is not None else 0
        if shell is not None:
            wanted += len(sheet_of(shell, scene_words(self.folder).thickness).triangles)
        self.assertGreater(wanted, 200)
        self.browser.wait("document.body.dataset.triangles", lambda triangles: triangles == str(wanted))

    def slide(self, k: int) -> None:
        self.browser.evaluate(f"(() => {{ const s = document.getElementById('slider'); s.value = {k}; "
                              "s.dispatchEvent(new Event('input')); })()")
        self.shown(k)


class RecordedRun(InABrowser):
    """A short run of the real programs, of SUNDER_BUILD_DIR: a pane that a cut parts."""

    @classmethod
    def make_run(cls) -> None:
        if not os.environ.get(BUILD_DIR_VARIABLE):
            raise unittest.SkipTest(f"{BUILD_DIR_VARIABLE} is not set; ctest sets it")
        launch_once(ensure_built(), REPOSITORY / "scenes" / "cut_pane.textproto", cls.folder, ["end_time_s=3e-3"])

    def test_is_shown_to_its_end(self) -> None:
        frames = list_frames(self.folder)
        self.assertGreater(len(frames), 4)
        self.assertEqual(self.browser.evaluate("document.getElementById('legend').textContent"), "pane")
        shell = frames[0].read(SHELL)
        assert shell is not None
        sheet = sheet_of(shell, scene_words(self.folder).thickness)  # `drawn` has counted these
        self.assertGreater(len(sheet.triangles), 2 * len(shell.triangles) + 100, "faces outside, inside and at the edge")
        self.assertGreater(sheet.thickness_m, 0.0)
        first = self.browser.picture()[CANVAS].astype(int)
        self.slide(len(frames) - 1)
        self.drawn(len(frames) - 1)
        self.assertGreater((np.abs(self.browser.picture()[CANVAS] - first).max(axis=2) > 12).sum(), 100)
        self.assertIn("energies [J]", self.browser.wait("[...document.querySelectorAll('.plot h2')].map(h => h.textContent)"))
        self.assertEqual(self.browser.said, [])


class Page(InABrowser):
    run_: SyntheticRun

    @classmethod
    def make_run(cls) -> None:
        cls.run_ = SyntheticRun(cls.folder, elements=10, fragments=12, count=COUNT)
        for k in range(AT_FIRST):
            cls.run_.write(k)
        cls.run_.write_run_json("running", AT_FIRST - 1)
        cls.write_series(AT_FIRST)

    @classmethod
    def write_series(cls, frames: int) -> None:
        rows = [f"{cls.run_.time_s(k)!r},{100.0 - k},{0.5 * k}" for k in range(frames)]
        (cls.folder / "series.csv").write_text("time [s],kinetic [J],cracks [m]\n" + "\n".join(rows) + "\n")
        rows = [f"{cls.run_.time_s(k)!r},0,0,{-20.0 + k}" for k in range(frames)]
        (cls.folder / "probes.csv").write_text(
            "time [s],ball_vx [m/s],ball_vy [m/s],ball_vz [m/s]\n" + "\n".join(rows) + "\n")

    def choose(self, control: str, value: str) -> None:
        key = "checked" if value in ("true", "false") else "value"
        text = value if key == "checked" else f"'{value}'"
        self.browser.evaluate(f"(() => {{ const c = document.getElementById('{control}'); c.{key} = {text}; "
                              "c.dispatchEvent(new Event('change')); })()")
        # two frames of the screen: drawing is put off to the next one
        self.browser.evaluate("new Promise(go => requestAnimationFrame(() => requestAnimationFrame(go)))")

    def picture(self) -> np.ndarray:
        return self.browser.picture()[CANVAS].astype(int)

    def differs(self, one: np.ndarray, other: np.ndarray) -> int:
        """Pixels that are plainly different."""
        return int((np.abs(one - other).max(axis=2) > 12).sum())

    def test_draws_and_the_slider_moves_it(self) -> None:
        first = self.picture()
        background = first[-1, -1]
        covered = (np.abs(first - background).max(axis=2) > 25).mean()
        self.assertGreater(covered, 0.1, "the shell and the floor fill a good part of the picture")
        self.assertEqual(self.browser.evaluate("document.getElementById('time').textContent"), f"0 s  (1/{AT_FIRST})")
        self.slide(AT_FIRST - 2)
        self.drawn(AT_FIRST - 2)
        self.assertGreater(self.differs(first, self.picture()), 3000)
        time_ms = self.run_.time_s(AT_FIRST - 2) * 1e3
        self.assertEqual(self.browser.evaluate("document.getElementById('time').textContent"),
                         f"{float(f'{time_ms:.4g}'):g} ms  ({AT_FIRST - 1}/{AT_FIRST})")
        self.slide(0)
        self.drawn(0)
        self.assertLess(self.differs(first, self.picture()), 50, "the same frame is the same picture")
        self.assertEqual(self.browser.said, [])

    def test_colours_and_switches_change_the_picture(self) -> None:
        self.slide(7)
        self.drawn(7)
        pictures = {"part": self.picture()}
        for by in ("damage", "fragment", "speed"):
            self.choose("colour", by)
            pictures[by] = self.picture()
            self.check_legend(by)
        names = list(pictures)
        for k, one in enumerate(names):
            for other in names[k + 1:]:
                self.assertGreater(self.differs(pictures[one], pictures[other]), 1000, f"{one} and {other} look alike")
        self.choose("lines", "false")
        self.assertGreater(self.differs(pictures["speed"], self.picture()), 200, "crack lines")
        sheet = list_frames(self.folder)[7].read(SHELL)
        assert sheet is not None
        shell = len(sheet.triangles)
        self.choose("bodies", "false")
        self.choose("static", "false")
        self.assertEqual(self.browser.evaluate("document.body.dataset.triangles"), str(shell))
        before = self.picture()
        self.choose("mesh", "true")
        self.assertGreater(self.differs(before, self.picture()), 1000)

    def check_legend(self, by: str) -> None:
        """A quantity has a bar with its colours in order, 0 and the largest value with its unit at the ends, in dark ink."""
        bars = self.browser.evaluate("document.querySelectorAll('#legend canvas').length")
        if by == "fragment":
            self.assertEqual(bars, 0)
            return
        self.assertEqual(bars, 1)
        ends = self.browser.evaluate("[...document.querySelectorAll('#legend .scale span')].map(s => s.textContent)")
        self.assertEqual((len(ends), ends[0]), (2, "0"))
        number, _, unit = ends[1].partition(" ")
        largest, asked = {"damage": (1.0, ""), "speed": (self.fastest(), "m/s")}[by]
        self.assertEqual(unit, asked)
        self.assertAlmostEqual(float(number) / largest, 1.0, delta=0.005)  # three digits
        colours = np.array(self.browser.evaluate(
            "(() => { const c = document.querySelector('#legend canvas'); "
            "return [...c.getContext('2d').getImageData(0, 0, c.width, 1).data]; })()")).reshape(-1, 4)
        self.assertEqual(len(colours), 180)
        np.testing.assert_allclose(colours[:, :3], 255.0 * ramp(np.arange(180) / 179.0), atol=1.5)
        self.assertTrue((colours[:, 3] == 255).all())
        where = self.browser.evaluate("(() => { const b = (s) => { const r = document.querySelector(s).getBoundingClientRect(); "
                                      "return [r.left, r.top, r.right, r.bottom]; }; "
                                      "return [...b('#legend canvas'), ...b('#legend .scale')]; })()")
        left, top, right, bottom = (round(x) for x in where[:4])
        self.assertEqual((round(where[4]), round(where[6])), (left, right), "the ends stand below the ends of the bar")
        screen = self.browser.picture().astype(int)
        shown = screen[(top + bottom) // 2, left + 2:right - 2]
        np.testing.assert_allclose(shown, colours[2:-2, :3], atol=6)
        words = screen[bottom:round(where[7]), left:right].max(axis=2)
        for ink in (words[:, :12], words[:, -12:]):
            self.assertLess(ink.min(), 120, "no ink at an end")

    def test_a_piece_keeps_its_colour_at_hand_off(self) -> None:
        """Piece 9 in the shell and as a shard, beside the whole pane 3 and what is left of it."""
        script = """import('./colours.js').then(m => {
            const shell = {arrays: {'shell.fragment': [3, 9, 4], 'shell.part': [0, 0, 0]}};
            const bodies = {arrays: {'bodies.kind': [3, 1, 1], 'bodies.body': [12, 9, 4], 'bodies.part': [0, 0, 0]}};
            const look = {whole: m.wholeIds(shell), partColour: () => m.GLASS, shardColour: () => m.GLASS};
            return ['part', 'fragment'].map(by => [m.shellColour(shell, by, 0, look), m.bodyColour(bodies, by, 0, look)]
              .map(of => [0, 1, 2].map(t => of(t, t)))); })"""
        for by, (before, after) in zip(("part", "fragment"), self.browser.evaluate(script)):
            self.assertEqual(before, after, by)
            self.assertGreater(np.abs(np.subtract(before[1], before[2])).max(), 0.01, by)

    def test_a_click_says_which_piece_it_is(self) -> None:
        k = 7  # some pieces are shards, others still of the shell
        self.slide(k)
        self.drawn(k)
        frame = list_frames(self.folder)[k]
        shell, bodies = frame.read(SHELL), frame.read(BODIES)
        assert shell is not None and bodies is not None
        known = {f"piece {n}" for n in shell.of_triangles("fragment", 0)}
        known |= {f"{'piece' if kind in (1, 3) else 'body'} {n}"
                  for n, kind in zip(bodies.of_triangles("body", 0), bodies.of_triangles("kind", 0))}
        click = """(() => { const c = document.querySelector('#picture'), r = c.getBoundingClientRect();
            const at = {clientX: r.left + %g * r.width, clientY: r.top + %g * r.height, bubbles: true};
            for (const what of ['pointerdown', 'pointerup']) c.dispatchEvent(new PointerEvent(what, at));
            return document.getElementById('picked').textContent; })()"""
        found = {self.browser.evaluate(click % (x, y)) for x in np.linspace(0.2, 0.8, 7) for y in np.linspace(0.2, 0.8, 7)}
        self.assertGreater(len({said for said in found if said.startswith("piece")}), 3, found)
        self.assertEqual(found - known - {""}, set())
        self.assertEqual(self.browser.evaluate(click % (0.999, 0.001)), "", "nothing is there")

    def fastest(self) -> float:
        """The largest speed [m/s] in the only frame that the page has coloured by speed."""
        return float(np.linalg.norm(body_velocity(list_frames(self.folder), 7), axis=1).max())

    def test_axes_have_whole_units(self) -> None:
        unit = "import('./plots.js').then(m => { const u = m.axisUnit(%s); return [u.label, u.by]; })"
        for asked, wanted in (("'m', 0.613", ["mm", 1e-3]), ("'Pa', 7e7", ["MPa", 1e6]), ("'m/s', 3", ["m/s", 1]),
                              ("'s', 4e-5", ["\u00b5s", 1e-6]), ("'rad/s', 4e4", ["rad/s", 1]), ("'', 1e-3", ["", 1]),
                              ("'J', 0", ["J", 1])):
            label, by = self.browser.evaluate(unit % asked)
            self.assertEqual(label, wanted[0])
            self.assertAlmostEqual(by / wanted[1], 1.0, places=12)

    def test_plots_stand_beside_it(self) -> None:
        titles = self.browser.wait("[...document.querySelectorAll('.plot h2')].map(h => h.textContent)")
        self.assertEqual(titles, ["energies [J]", "crack length [m]", "impulse per mass [m/s]", "probes: velocity [m/s]"])
        inked = "[...document.querySelectorAll('.plot canvas')].map(c => c.getContext('2d').getImageData(0, 0, c.width, "\
                "c.height).data.filter((v, i) => i % 4 === 3 && v > 0).length)"
        self.assertGreater(min(self.browser.evaluate(inked)), 300)
        keys = self.browser.evaluate("[...document.querySelectorAll('.plot')].map(p => [...p.querySelectorAll("
                                     "'.u-series .u-label')].map(l => l.textContent))")
        self.assertEqual(keys[0], ["time", "kinetic"])  # names and values of the curves, from uPlot
        plot = "(() => { const c = document.querySelector('.plot .u-over'); const r = c.getBoundingClientRect(); "\
               "c.dispatchEvent(new PointerEvent('pointerdown', {clientX: r.right - 8, clientY: r.top + 40})); })()"
        self.browser.evaluate(plot)
        self.shown(AT_FIRST - 1)  # a click into a plot goes there

    def test_plays_to_the_end_and_fetches_nothing_from_elsewhere(self) -> None:
        hits: list[str] = []

        class Elsewhere(http.server.BaseHTTPRequestHandler):
            def do_GET(self) -> None:  # noqa: N802: the base class's name
                hits.append(self.path)
                self.send_response(200)
                self.send_header("Access-Control-Allow-Origin", "*")
                self.end_headers()

            def log_message(self, *_: object) -> None:
                pass

        self.choose("rate", "50")
        self.browser.evaluate("document.getElementById('play').click()")
        self.shown(AT_FIRST - 1)
        self.drawn(AT_FIRST - 1)
        self.assertGreater(len(self.browser.requests), AT_FIRST)
        foreign = [url for url in self.browser.requests if not url.startswith((self.server.url, "data:", "blob:"))]
        self.assertEqual(foreign, [])
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Elsewhere) as elsewhere:
            thread = threading.Thread(target=elsewhere.serve_forever, args=(0.05,))
            thread.start()
            try:  # and the browser would not let it
                said = self.browser.evaluate(f"fetch('http://127.0.0.1:{elsewhere.server_port}/').then(() => 'came', "
                                             "() => 'refused')")
            finally:
                elsewhere.shutdown()
                thread.join()
        self.assertEqual((said, hits), ("refused", []))

    def test_a_broken_frame_is_told_and_the_others_go_on(self) -> None:
        path = self.folder / "frames" / "shell_000004.vtp"
        whole = path.read_bytes()
        path.write_bytes(whole[:-200])
        try:
            self.browser.open(self.server.url)
            self.shown(0)
            self.browser.evaluate("(() => { const s = document.getElementById('slider'); s.value = 4; "
                                  "s.dispatchEvent(new Event('input')); })()")
            self.browser.wait("document.getElementById('message').textContent", lambda text: "shell_000004.vtp" in text)
            self.slide(5)
            self.browser.wait("document.getElementById('message').textContent === ''")
        finally:
            path.write_bytes(whole)

    def test_zz_a_run_under_way_grows(self) -> None:
        """Last by its name: it ends the run that the others look at."""
        self.slide(AT_FIRST - 1)
        for k in range(AT_FIRST, COUNT):
            self.run_.write(k)
        self.write_series(COUNT)
        self.run_.write_run_json("done", COUNT - 1)
        self.shown(COUNT - 1)  # who looks at the newest frame keeps looking at the newest
        self.drawn(COUNT - 1)
        self.assertEqual(self.browser.evaluate("document.getElementById('slider').max"), str(COUNT - 1))
        self.assertEqual(self.browser.evaluate("document.getElementById('status').textContent"), "done")


if __name__ == "__main__":
    unittest.main()
