"""Quantities of an impact, where they are known exactly; tables, means and the median of ballistic limits."""
from __future__ import annotations

import csv
import math
import re
import sqlite3
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import sunder
from sunder_lab.impact import mass_of
from sunder_lab.member import write_atomically
from sunder_lab.table import write_sqlite
from sunder_lab.v50 import judged, median_interval
from sunder_tools.pictures.plots import Panel, there, write_panels

from .made_up import FALL, FORCE, sunder_mass, write_dents, write_pieces, write_run


class InFolder(unittest.TestCase):
    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.here = Path(self._folder.name)


class Columns(unittest.TestCase):
    def test_the_page_lists_the_columns_of_every_measure(self) -> None:
        page = (Path(__file__).resolve().parents[2] / "coupler" / "experiments" / "README.md").read_text(encoding="utf-8")
        for begins, measure in (('| `sunder.impact("pellet")`', sunder.impact("pellet")), ("| `sunder.fragments()`", sunder.fragments()),
                                ("| `sunder.radial_cracks(...)`", sunder.radial_cracks((0.0, 0.0), 1.0)),
                                ('| `sunder.dent("sheet")`', sunder.dent("sheet"))):
            row, = [line for line in page.splitlines() if line.startswith(begins)]
            told = set(re.findall(r"`([a-z_A-Z0-9]+)`", row.split("|")[2])) - {"energy_NAME_J", "energy_taken"}
            self.assertEqual(told, {name for name in measure.columns if not name.startswith("energy_")})


class Masses(unittest.TestCase):
    def test_a_body_of_a_preset_has_its_density(self) -> None:
        scene = sunder.Scene.load(Path(__file__).resolve().parents[2] / "scenes" / "struck_glass.textproto")
        ball = scene.message.bodies[0]
        ball.material = "glass"
        volume = 4.0 / 3.0 * math.pi * ball.sphere.radius_m ** 3
        self.assertAlmostEqual(mass_of(scene.message, ball), 2500.0 * volume, places=12)
        self.assertEqual(scene["materials[glass].youngs_modulus"], 70e9)
        scene["materials[glass].density"] = 2400.0  # its own
        self.assertEqual(scene["materials[glass].density"], 2400.0)
        self.assertAlmostEqual(mass_of(scene.message, ball), 2400.0 * volume, places=12)


class Motions(InFolder):
    def test_force_and_impulse_are_those_that_acted(self) -> None:
        one = sunder.motion(write_run(self.here))
        self.assertAlmostEqual(one.mass, sunder_mass(), places=15)
        for over, count in ((1e-9, 20), (3e-4, 6)):  # the last two rows make no whole interval
            time, force = one.force(over)
            self.assertEqual(len(time), count)
            np.testing.assert_allclose(force, np.tile([0.0, 0.0, FORCE], (count, 1)), rtol=1e-9)
        np.testing.assert_allclose(one.impulse[:, 2], FORCE * one.time, rtol=1e-9, atol=1e-15)
        self.assertEqual(one.contact_until, one.time[-1])
        self.assertFalse(one.settled)
        self.assertTrue(sunder.motion(write_run(self.here / "left", until=5)).settled)
        free = replace(one, velocity=one.velocity[:1] + one.gravity * one.time[:, None] + 1e-9 * np.sin(np.arange(len(one.time)))[:, None])
        self.assertEqual((free.contact_until, free.settled), (0.0, False))  # it has touched nothing
        self.assertEqual(sunder.motion(write_run(self.here / "short", until=5)).contact_until, one.time[5])

    def test_largest_mean_force_is_the_impulse_over_its_interval(self) -> None:
        short = sunder.motion(write_run(self.here, until=8))  # a force for 0.8 ms, rows each 0.1 ms
        for interval, share in ((4e-4, 1.0), (5.5e-4, 1.0), (8e-4, 1.0), (1.6e-3, 0.5), (2e-3, 0.4)):
            self.assertAlmostEqual(short.largest_mean_force(interval), share * FORCE, delta=1e-8 * FORCE)
        for interval, words in ((3e-4, "rows are 0.0001 s apart; give at least 0.0004"), (3e-3, "cover 0.002 s only"),
                                (0.0, "interval_s is 0.0"), (math.nan, "interval_s is nan")):
            with self.assertRaisesRegex(sunder.Error, words):
                short.largest_mean_force(interval)
        # rows that are far apart elsewhere matter only where their impulse might be larger
        kept = np.r_[0:9, 20]
        later = replace(short, time=short.time[kept], position=short.position[kept], velocity=short.velocity[kept])
        self.assertAlmostEqual(later.largest_mean_force(4e-4), FORCE, delta=1e-8 * FORCE)
        struck = later.velocity.copy()
        struck[-1] += [0.0, 0.0, 5e-4 * FORCE / short.mass]
        with self.assertRaisesRegex(sunder.Error, "rows are 0.0012 s apart; give at least 0.0048"):
            replace(later, velocity=struck).largest_mean_force(4e-4)

    def test_energy_lost_is_the_work_of_the_force(self) -> None:
        one = sunder.motion(write_run(self.here))
        way = one.position[-1, 2] - one.position[0, 2]
        self.assertAlmostEqual(one.energy_lost, -FORCE * way, delta=1e-9 * abs(FORCE * way))
        self.assertAlmostEqual(one.residual_velocity, 40.0 - (FORCE / sunder_mass() - FALL) * 2e-3, places=9)

    def test_energy_is_split_without_a_rest_that_is_hidden(self) -> None:
        found = sunder.energy_taken(write_run(self.here))
        self.assertAlmostEqual(found["motion"], 0.5, places=12)
        self.assertEqual((found["elastic"], found["fracture"], found["contact"]), (1.0, 2.0, 4.0))
        self.assertAlmostEqual(found["missing"], found["lost"] + 0.25 - 7.5, places=12)

    def test_perforation(self) -> None:
        cases: list[tuple[str, dict[str, Any], bool | None]] = [
            ("through", dict(start=-40.0, force=6.0, until=10), True),  # slowed for 1 ms, then flies on
            ("bounced", dict(start=-5.0), False), ("still pushed", dict(start=-40.0, force=5.0), None),
            ("not there yet", dict(start=-1.0, force=0.0), None)]
        for name, how, expected in cases:
            with self.subTest(name):
                self.assertIs(sunder.perforated(write_run(self.here / name.replace(" ", "_"), **how)), expected)
        with self.assertRaisesRegex(sunder.Error, "with supports"):
            sunder.perforated(write_run(self.here / "free", supports=False))

    def test_what_is_not_there_is_named(self) -> None:
        results = write_run(self.here)
        for body, words in (("ball", "no body 'ball'; there are pellet"),):
            with self.assertRaisesRegex(sunder.Error, words):
                sunder.motion(results, body)
        with self.assertRaisesRegex(sunder.Error, "no column 'depth'; there are: time"):
            results.probes["depth"]
        self.assertTrue(math.isnan(results.probes["reaction_x"][-1]))
        self.assertEqual(results.probes.units["pellet_vz"], "m/s")
        scene = results.scene.message
        scene.output.probes.add(name="contact", body="pellet", shell=scene.shells[0].name)  # is no probe of its motion
        self.assertEqual(sunder.motion(results).contact_until, sunder.motion(results, "pellet").contact_until)
        del scene.output.probes[0]
        with self.assertRaisesRegex(sunder.Error, "no probe of 'pellet'; add output"):
            sunder.motion(results, "pellet")
        del scene.output.probes[:]
        with self.assertRaisesRegex(sunder.Error, "no probe of 'pellet'; add output"):
            sunder.motion(results, "pellet")
        scene.bodies[0].mesh.path = "x.obj"
        scene.output.probes.add(name="pellet", body="pellet")
        with self.assertRaisesRegex(sunder.Error, "give mass="):
            sunder.motion(results)
        self.assertEqual(sunder.motion(results, mass=2.0).mass, 2.0)


class Forces(InFolder):
    def test_the_mean_force_over_an_interval_does_not_depend_on_the_window(self) -> None:
        # The first touch is at 8 us. Windows of these lengths begin there, and their substeps are of three lengths.
        found = [self.pushed(window) for window in (4e-6, 2e-6, 1.6e-6, 1e-6)]
        forces = [one.largest_mean_force(1.6e-5) for one in found]
        self.assertGreater(forces[-1], 100.0)
        self.assertLess(max(forces) - min(forces), 5e-3 * forces[-1], forces)
        # the pellet's first impulse falls into one window, so its force over a window has no limit
        first, second, _, third = (float(np.linalg.norm(one.force(one.time[1] - one.time[0])[1], axis=1).max()) for one in found)
        self.assertTrue(second > 1.5 * first and third > 1.5 * second, found)
        # Windows of other lengths begin before the first touch. Its impulse is spread over the window, and up to a window
        # of the interval is lost.
        for window in (3e-6, 2.5e-6, 1.8e-6):
            lost = 1.0 - self.pushed(window).largest_mean_force(1.6e-5) / forces[-1]
            self.assertTrue(-5e-3 < lost < window / 1.6e-5, (window, lost))

    def pushed(self, window: float) -> sunder.Motion:
        """The pellet's motion as it hits an acrylic plate that does not break."""
        scene = sunder.Scene.load(sunder.SCENES / "acrylic.textproto").set({
            "shells[plate].plate.elements_x": 24, "shells[plate].plate.elements_y": 24, "window_s": window,
            "end_time_s": 1.2e-4, "bodies[pellet].twist.linear.z": -20, "output.frame_interval_s": 1})
        scene.message.ClearField("fracture")
        for name in ("strength", "fracture_energy", "weibull_modulus", "flaw_spacing_m"):
            scene.message.materials[0].ClearField(name)
        return sunder.motion(scene.run(self.here / f"{window:g}"))


class Fragments(InFolder):
    def test_pieces_off_and_standing(self) -> None:
        found = sunder.pieces(write_pieces(self.here))
        np.testing.assert_allclose(found.off, [1.5, 0.5])
        np.testing.assert_allclose(found.standing, [6.0, 1.0, 1.0], rtol=1e-6)
        self.assertAlmostEqual(found.whole, 10.0, places=5)
        np.testing.assert_allclose(found.counted(0.1), [6.0, 1.5, 1.0, 1.0], rtol=1e-6)
        self.assertAlmostEqual(found.mean_size(), (36 + 2.25 + 2 + 0.25) / 10, places=5)

    def test_what_a_frozen_shell_keeps_is_one(self) -> None:
        np.testing.assert_allclose(sunder.pieces(write_pieces(self.here, frozen=True)).standing, [8.0], rtol=1e-6)

    def test_a_missing_last_frame_is_told(self) -> None:
        results = write_pieces(self.here)
        (self.here / "frames/shell_1.vtp").unlink()
        with self.assertRaisesRegex(sunder.Error, "last frame is of 0 s"):
            sunder.pieces(results)


class Dents(InFolder):
    def test_volume_and_depth_of_each_shell(self) -> None:
        results = write_dents(self.here)
        found = sunder.dents(results)
        self.assertEqual(list(found), ["hit", "whole"])
        hit = found["hit"]
        # what is linear between vertices, and positions are single precision
        np.testing.assert_allclose([hit.area, hit.pushed_in, hit.pushed_out, hit.deepest, hit.time],
                                   [10.0, 8.0, 18.0, math.hypot(6.0, 0.1), 0.5], rtol=1e-6)
        self.assertEqual([found["whole"].pushed_in, found["whole"].pushed_out, found["whole"].deepest], [0.0, 0.0, 0.0])
        self.assertEqual(sunder.dent("hit")(results), {"dent_in_m3": hit.pushed_in, "dent_out_m3": hit.pushed_out,
                                                      "deepest_m": hit.deepest})
        with self.assertRaisesRegex(sunder.Error, "no shell 'bonnet' in the last frame; there are: hit, whole"):
            sunder.dent("bonnet")(results)

    def test_frames_that_are_gone_are_told(self) -> None:
        results = write_dents(self.here)
        (self.here / "frames/shell_0.vtp").unlink()
        with self.assertRaisesRegex(sunder.Error, "no frame of the shell"):
            sunder.dents(results)


class Tables(InFolder):
    TABLE = sunder.Table([{"speed": 10, "x": 1.0}, {"speed": 10, "x": 3.0, "ok": True}, {"speed": 20, "x": 0.1 + 0.2},
                          {"speed": 20, "error": "a,\n\"b\""}])

    def test_csv_and_sqlite_hold_the_same_to_the_bit(self) -> None:
        self.TABLE.write_csv(self.here / "t.csv")
        write_sqlite(self.here / "t.sqlite", {"t": self.TABLE})
        with (self.here / "t.csv").open(newline="") as source:
            rows = list(csv.reader(source))
        self.assertEqual(rows[0], ["speed", "x", "ok", "error"])
        base = sqlite3.connect(self.here / "t.sqlite")
        self.addCleanup(base.close)
        found = base.execute("select * from t").fetchall()
        self.assertEqual(found[2], (20, 0.1 + 0.2, None, None))
        self.assertEqual([float(r[1]) if r[1] else None for r in rows[1:]], [f[1] for f in found])
        self.assertEqual(rows[4][3], 'a, "b"')

    def test_names_that_differ_in_case_only_do_not_lose_a_table(self) -> None:
        write_sqlite(self.here / "t.sqlite", {"t": sunder.Table([{"Area": 1, "area": 2, "AREA": 3, "area_2": 4}])})
        base = sqlite3.connect(self.here / "t.sqlite")
        self.addCleanup(base.close)
        found = base.execute("select * from t")
        self.assertEqual([name for name, *_ in found.description], ["Area", "area_2", "AREA_3", "area_2_2"])
        self.assertEqual(found.fetchall(), [(1, 2, 3, 4)])

    def test_what_cannot_be_written_leaves_no_file(self) -> None:
        class Unprintable:
            def __repr__(self) -> str:
                raise ValueError("no words")
        table = sunder.Table([{"x": 1}])
        table.rows[0]["x"] = Unprintable()
        for write in (lambda: table.write_csv(self.here / "t.csv"), lambda: write_sqlite(self.here / "t.sqlite", {"t": table}),
                      lambda: write_atomically(self.here / "t.json", Unprintable())):
            with self.assertRaises((ValueError, TypeError, sqlite3.Error)):
                write()
        if there():
            with mock.patch("matplotlib.figure.Figure.savefig", side_effect=OSError), self.assertRaises(OSError):
                write_panels([Panel("", "", "", [])], self.here / "t.png")
        self.assertEqual(list(self.here.iterdir()), [])

    def test_what_was_written_is_read_back(self) -> None:
        table = sunder.Table([
            {"member": "1234567890123456", "speed": 10, "x": 0.1 + 0.2, "law": "TIPS", "error": None},
            {"member": "00e5", "speed": -3, "x": 1e-300, "law": "a, \"b\"", "error": "bad 1"},
            {"member": "ab", "speed": 2, "x": math.inf, "law": "5e", "error": None}, {"member": "cd", "speed": 2, "x": 1e22}])
        table.write_csv(self.here / "t.csv")
        again = sunder.Table.read(self.here / "t.csv")
        self.assertEqual((again.columns, again.rows), (table.columns, table.rows))
        self.assertEqual(again.where(law="TIPS")["x"].tolist(), [0.1 + 0.2])
        sunder.Table([]).write_csv(self.here / "t.csv")
        for text, words in (("", "is no table"), ("a,b\n1\n", "as many cells in every row"), (None, "cannot be read")):
            (self.here / "t.csv").unlink()
            if text is not None:
                (self.here / "t.csv").write_text(text)
            else:
                (self.here / "t.csv").mkdir()
            with self.assertRaisesRegex(sunder.Error, words):
                sunder.Table.read(self.here / "t.csv")

    def test_a_part_of_a_table_has_its_columns(self) -> None:
        self.assertEqual(self.TABLE.where(speed=99).columns, self.TABLE.columns)
        self.assertEqual(len(self.TABLE.where(x=math.nan)), sum(row["x"] is None for row in self.TABLE))
        self.assertEqual(len(sunder.Table([{"self": 1}]).where(self=1)), 1)

    def test_means_with_their_interval(self) -> None:
        first, second = self.TABLE.means("x", ["speed"])
        self.assertEqual((first.key, first.count, first.mean), ({"speed": 10}, 2, 2.0))
        # Student's t for one degree of freedom is 12.706; the deviation is sqrt(2), over sqrt(2).
        self.assertAlmostEqual(first.half, 12.706, places=3)
        self.assertEqual((second.count, second.mean), (1, 0.1 + 0.2))
        self.assertTrue(math.isnan(second.half))
        with self.assertRaisesRegex(sunder.Error, "no column 'y'"):
            self.TABLE.means("y", ["speed"])


class Plots(InFolder):
    def test_a_panel_has_means_intervals_and_every_run(self) -> None:
        table = sunder.Table([{"speed": v, "thick": t, "x": v * t + d} for v in (1, 2) for t in (1, 3) for d in (-1.0, 1.0)])
        panel = sunder.Plot("speed", "x", by="thick").panel(table)
        self.assertEqual([line.name for line in panel.lines], ["thick 1", "thick 3"])
        self.assertEqual(panel.name, "x over speed")
        self.assertEqual((panel.lines[1].x, panel.lines[1].y), ([1, 2], [3.0, 6.0]))
        self.assertAlmostEqual(panel.lines[1].half[0], 12.706, places=3)  # as above: t for one degree of freedom
        self.assertEqual(panel.lines[1].dots, [(1.0, 2.0), (1.0, 4.0), (2.0, 5.0), (2.0, 7.0)])
        with self.assertRaisesRegex(sunder.Error, "no column 'y'"):
            sunder.Plot("speed", "y").panel(table)

    def test_a_panel_says_what_its_bars_are_and_where_they_end(self) -> None:
        rows = [{"speed": v, "pieces": 1 + k, "mean_force_N": 0.5 * k, "height_m": 0.5 + k, "change": k - 1} for v in (1, 2) for k in range(2)]
        for table, bars in ((sunder.Table(rows), "mean ± 95 % interval, 2 runs a point: take 4 or more"), (sunder.Table(rows[::2]), ""),
                            (sunder.Table([*rows, rows[0]]), "mean ± 95 % interval, 2 to 3 runs a point: take 4 or more"),
                            (sunder.Table(rows * 2), "mean ± 95 % interval, 4 runs a point")):
            self.assertEqual(sunder.Plot("speed", "pieces").panel(table).bars, bars)
        forces = sunder.Table([{"speed": 1.0, "mean_force_N": 2.0, "mean_force_interval_s": 2e-4}, {"speed": 2.0, "mean_force_N": 3.0,
                                                                                                 "mean_force_interval_s": 2e-4}])
        self.assertEqual(sunder.Plot("speed", "mean_force_N").panel(forces).bars, "mean over 200 µs")
        ends = {name: sunder.Plot("speed", name).panel(sunder.Table(rows)).least for name in ("pieces", "mean_force_N", "height_m", "change")}
        self.assertEqual(ends, {"pieces": 0.0, "mean_force_N": 0.0, "height_m": None, "change": None})
        self.assertEqual(sunder.Plot("speed", "height_m", least=0.5).panel(sunder.Table(rows)).least, 0.5)
        for name, lowest, least in (("energy_lost_J", 0.1, 0.0), ("energy_motion_J", -1e-18, 0.0),  # round-off is no energy
                                    ("energy_lost_J", -0.1, None), ("energy_missing_J", 0.1, None)):
            with self.subTest(name, lowest=lowest):
                table = sunder.Table([{"speed": 1, name: value} for value in (lowest, 1.0, None)])
                self.assertEqual(sunder.Plot("speed", name).panel(table).least, least)

    def test_runs_that_have_not_settled_are_hollow(self) -> None:
        rows = [{"speed": v, "x": v + d, "settled": float(v != 2 or d > 0)} for v in (1, 2) for d in (-1.0, 1.0)]
        line, = sunder.Plot("speed", "x").panel(sunder.Table(rows)).lines
        self.assertEqual((line.dots, line.hollow_dots), ([(1.0, 0.0), (1.0, 2.0), (2.0, 3.0)], [(2.0, 1.0)]))
        self.assertEqual(line.hollow, [False, True])
        panel = sunder.Plot("speed", "x").panel(sunder.Table(rows[::2]))  # one run a point: the points are the runs
        self.assertEqual((panel.lines[0].hollow, panel.lines[0].hollow_dots), ([False, True], []))
        self.assertIn("hollow", panel.hollow)


class Limits(unittest.TestCase):
    def test_the_interval_of_the_median_is_the_tabled_one(self) -> None:
        # Tables of the sign test: 6: 1st and 6th, 96.9 %; 9: 2nd and 8th, 96.1 %; 20: 6th and 15th, 95.9 %.
        for count, k, chance in ((5, 0, 1.0), (6, 1, 0.969), (9, 2, 0.961), (20, 6, 0.959)):
            found = median_interval(count)
            self.assertEqual(found[0], k)
            self.assertAlmostEqual(found[1], chance, places=3)

    def test_the_interval_holds_the_median_as_often_as_it_says(self) -> None:
        chance = np.random.default_rng(5)
        draws = [judged([float(v) for v in chance.exponential(10.0, 9)], 0.0) for _ in range(2000)]
        held = float(np.mean([d.low <= 10.0 * math.log(2.0) <= d.high for d in draws]))
        self.assertAlmostEqual(held, 0.961, delta=4 * math.sqrt(0.961 * 0.039 / 2000))  # four deviations of a share

    def test_panes_that_never_or_always_break_count(self) -> None:
        found = judged([math.inf, 30.0, 20.0, math.inf, 10.0], 0.5)
        self.assertEqual((found.v50, found.low, found.high), (30.0, 0.0, math.inf))
        self.assertEqual(judged([0.0, 30.0, 40.0, math.inf], 0.5).v50, 35.0)
        self.assertEqual(judged([math.inf] * 3, 0.5).v50, math.inf)
        with self.assertRaisesRegex(sunder.Error, "no pane was decided"):
            judged([], 0.5)


if __name__ == "__main__":
    unittest.main()
