"""Before a series runs: its scenes are checked, refusals and warnings are told once, and the time that it may take."""
from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

from . import sweeps
import sunder
from sunder_lab.forecast import MOST_CHECKED, corners, duration, forecast, kinds, read_report
from sunder_lab.sweep import sweep

REPORT = "scene  x\ntime           at most 0.5 min on one thread, uncracked (measured now: 1 ms a substep)\n"
WARNED = REPORT + "warning        1.5 m is thick\n"


def plate(height: float = 0.00251) -> sunder.Scene:
    return sunder.Scene.load(sunder.SCENES / "acrylic.textproto").set({
        "shells[plate].plate.elements_x": 24, "shells[plate].plate.elements_y": 24, "end_time_s": 4e-6,
        "bodies[pellet].pose.position.z": height})


def thick(*values: float, height: float = 0.00251, speeds: tuple[float, ...] = (20.0, 30.0)) -> sunder.Experiment:
    return sunder.Experiment("thick", plate(height), {
        "thickness_m": sunder.Parameter(values, "shells[plate].thickness_m"),
        "speed": sunder.Parameter(speeds, {"bodies[pellet].twist.linear.z": lambda speed: -speed})}, seeds=[1, 2, 3])


class Forecasts(unittest.TestCase):
    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.out = Path(self._folder.name) / "out"
        self.settings = sunder.Settings(self.out, jobs=2)

    def told(self, series: "sunder.Experiment | sunder.V50") -> str:
        """What is printed before the first run."""
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            series.announce(self.settings)
        return said.getvalue()

    def test_what_is_refused_whatever_the_values_is_not_run(self) -> None:
        with self.assertRaises(sunder.Error) as raised:
            thick(2e-3, 3e-3).run(self.settings)
        self.assertIn("thick: nothing was run\nrefused by 'sunder check', all 4 scenes:\nthickness_m 0.002, speed 20.0: ",
                      str(raised.exception))
        self.assertEqual(str(raised.exception).count("inside shell 'plate', whose faces"), 1)  # other depths, same words
        self.assertEqual(raised.exception.status, 2)
        self.assertFalse(self.out.exists())

    def test_what_some_scenes_are_refused_or_warned_for_is_told_once(self) -> None:
        told = self.told(thick(1e-3, 2e-3))
        self.assertRegex(told, r"thick: 4 scenes checked in \S+ s; 12 runs take at most about \S+ m?i?n?s? ?on one thread")
        self.assertRegex(told, r"refused: 2 of 4 scenes, first thickness_m 0.002, speed 20.0: .*inside shell 'plate'")
        self.assertNotIn("warning", told)
        told = self.told(thick(1.0, 1.5, height=0.8))  # millimetres taken for metres
        self.assertRegex(told, r"warning: 4 of 4 scenes, first thickness_m 1.0, speed 20.0: .*thickness_m is 1 m, and the plate is "
                               r"0.06 m wide; 1 mm are 0.001")
        self.assertEqual(told.count("warning: "), 2)  # of its unit, and of thick plates

    def test_each_scene_is_asked_once_and_its_time_counts_for_all_its_runs(self) -> None:
        with mock.patch.object(sunder.Scene, "check", return_value=WARNED) as check:
            found = forecast("thick", thick(1e-3, 2e-3).plan(), self.settings)
            assert found is not None
            self.assertEqual((check.call_count, found.runs, found.minutes), (4, 12, 6.0))
            self.assertIn("12 runs take at most about 6 min on one thread", found.lines(self.settings)[0])
            self.assertIn("2 runs at a time: 3 min", found.lines(self.settings)[0])
            many = replace(self.settings, jobs=16)
            self.assertIn("12 runs at a time: 30 s", found.lines(many)[0])  # no more than there are, and not less than one takes
            self.assertNotIn("at a time", replace(found, side_by_side=1).lines(many)[0])
            self.assertIn("2 runs at a time: 5 min", replace(found, side_by_side=2, longest=5.0).lines(many)[0])
            self.assertEqual(found.troubles(), ["warning: 4 of 4 scenes, first thickness_m 0.001, speed 20.0: 1.5 m is thick"])
            limit = sunder.V50("limit", plate(), {"bodies[pellet].twist.linear.z": lambda v: -v}, 20.0, 40.0, [1, 2],
                               tolerance=3.0, through=lambda _: None)
            self.assertIn("2 scenes checked", told := self.told(limit))
            self.assertIn("2 runs at a time: 2.5 min", told)
            self.assertIn("10 runs take at most about 5 min", told)  # both ends and three halvings, of two panes

    def test_of_many_scenes_the_ends_are_asked_and_all_where_those_are_refused(self) -> None:
        many = thick(*(1e-3 + 1e-5 * k for k in range(9)), speeds=(10.0, 20.0, 30.0, 40.0))
        self.assertGreater(9 * 4, MOST_CHECKED)
        seen: list[float] = []

        def check(scene: sunder.Scene) -> str:
            seen.append(float(scene["shells[plate].thickness_m"]))
            if len(seen) < refused:
                raise sunder.Error("bad_scene: no")
            return REPORT

        for refused, asked in ((1, 4), (5, 5), (99, 36)):
            seen.clear()
            with mock.patch.object(sunder.Scene, "check", check):
                if refused == 99:
                    with self.assertRaisesRegex(sunder.Error, "all 36 scenes:"):
                        forecast("thick", many.plan(), self.settings)
                else:
                    found = forecast("thick", many.plan(), self.settings)
                    assert found is not None
                    self.assertIn(f"{asked} scenes of 36, with the smallest and largest", found.lines(self.settings)[0])
                    # refused ones take no time; of the others, those that were not asked take what the one did
                    self.assertAlmostEqual(found.minutes, 0.5 * 3 * (36 - min(refused - 1, 4)))
            self.assertEqual(len(seen), asked)
            self.assertEqual(set(seen[:4]), {1e-3, 1.08e-3})
        law = sunder.Experiment("law", plate(), {"fracture.mode": ["CUTS", "TIPS"], "window_s": [1e-6, 2e-6, 4e-6]})
        groups = {str(p.columns): [p] for p in law.plan()}
        self.assertEqual(len(corners(groups)), 4)  # texts have no ends

    def test_a_series_that_is_done_asks_nothing(self) -> None:
        planned = thick(1e-3).plan()
        for p in planned[:-1]:
            place = self.out / "members" / p.member.identity()
            place.mkdir(parents=True)
            (place / "outcome.json").write_text('{"status": "done"}')
        with mock.patch.object(sunder.Scene, "check", side_effect=sunder.Error("no")) as check:
            found = forecast("thick", planned, self.settings)  # not all are refused: some are done
            assert found is not None
            self.assertEqual((check.call_count, found.runs, found.minutes), (1, 1, 0.0))
            self.assertRegex(found.lines(self.settings)[0], r"^1 scene checked in \S+ s$")  # no time is known
            self.assertIsNone(forecast("thick", planned[:-1], self.settings))
            self.assertEqual(check.call_count, 1)

    def test_no_series_of_a_file_runs_where_one_is_refused(self) -> None:
        file = sweeps.write_file(Path(self._folder.name) / "two.py", [], parameters='{"shells[plate].thickness_m": [1e-3]}')
        file.write_text(file.read_text().replace('"speed", "crack', '"shells[plate].thickness_m", "crack') + """
import copy
later = copy.copy(experiment)
later.name, later.parameters = "later", {"shells[plate].thickness_m": [2e-3]}
""")
        with self.assertRaisesRegex(sunder.Error, "later: nothing was run\nrefused by 'sunder check', all 1 scene:"), contextlib.redirect_stderr(io.StringIO()):
            sweep(file, self.settings)
        self.assertFalse(self.out.exists())

    def test_words(self) -> None:
        self.assertEqual([duration(m) for m in (0.01, 0.99, 1.0, 119.0, 150.0, 6000.0)],
                         ["0.6 s", "59 s", "1 min", "119 min", "2.5 h", "100 h"])
        self.assertEqual(kinds([(1, "a 2 m"), (2, "b"), (3, "a 1e-3 m")]), [[(1, "a 2 m"), (3, "a 1e-3 m")], [(2, "b")]])
        found = read_report("x", WARNED)
        self.assertEqual((found.minutes, found.warnings), (0.5, ("1.5 m is thick",)))


if __name__ == "__main__":
    unittest.main()
