"""Active models of runs: which share a stage, what is told of them, and what is no run."""
from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path
from typing import Any

from sunder_tools.errors import CommandError
from sunder_tools.report import models
from sunder_tools.report.summary import summary


RUN: dict[str, Any] = {"schema": 1, "status": "done", "scene": "car", "models": [
    {"name": "plane_stress", "why": "the scene has a shell", "share": 0.9}, {"name": "contact", "why": "bodies meet", "share": 0.004},
    {"name": "seams", "why": "shells hang together", "share": 0.9}, {"name": "cuts", "why": "a shell has cuts", "share": 0.0},
    {"name": "damage", "why": "the mode is DAMAGE", "share": 0.0}, {"name": "engine", "why": "bodies meet", "share": 0.05}]}


class Models(unittest.TestCase):
    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.here = Path(self._folder.name)
        (self.here / "run.json").write_text(json.dumps(RUN))

    def test_a_stage_s_share_is_told_once(self) -> None:
        self.assertEqual(models.grouped(RUN), [(["plane_stress", "seams"], 0.9), (["engine"], 0.05), (["contact"], 0.004),
                                               (["cuts"], 0.0), (["damage"], 0.0)])
        self.assertEqual(models.in_words(RUN), "plane_stress + seams 90 %, engine 5 %, contact < 1 %, cuts < 1 %, damage < 1 %")

    def test_the_table_has_a_line_a_run_and_the_reasons(self) -> None:
        lines = models.table([self.here, self.here]).splitlines()
        self.assertEqual(lines[2], lines[3])
        self.assertTrue(lines[2].startswith(f"| `car` ({self.here}) | plane_stress + seams 90 %"))
        self.assertIn("contact, engine: bodies meet", lines)

    def test_the_summary_of_a_run_names_them(self) -> None:
        self.assertIn("active models    plane_stress + seams 90 %", summary(self.here, None))

    def test_the_summary_says_what_damage_parts_that_no_crack_does(self) -> None:
        for held, loose, wanted in (([0.5, 0.3, 0.1], 1, "; damage parts the shells into 3"), ([0.5, 0.3, 0.1], 3, ""),
                                    ([0.9], 1, ""), ([0.5, 0.4], 1, ""), (None, 1, "")):
            with self.subTest(held=held, loose=loose):
                run = {**RUN, "counts": {"fragments": 5, "handed_off": 3},
                       "surface": {} if held is None else {"held_together_m2": held, "parts_at_rest": loose}}
                (self.here / "run.json").write_text(json.dumps(run))
                line = next(t for t in summary(self.here, None).splitlines() if t.startswith("fragments"))
                self.assertEqual(line, "fragments        5, handed to the engine 3" + wanted)

    def test_the_summary_says_what_cracks_took_where_any_ran(self) -> None:
        self.assertNotIn("cracks ", summary(self.here, None))
        for taken, said in ((1.25, ["cracks           0.0745 m, took 1.25 of the fracture energy of their area"]), (None, [])):
            run = {**RUN, "cracks": {"length_m": 0.0745, "resistance": 0.026, "taken_relative": taken}}
            (self.here / "run.json").write_text(json.dumps(run))
            lines = summary(self.here, None).splitlines()
            self.assertEqual([line for line in lines if line.startswith("cracks")], said)

    def test_what_says_nothing_of_models_is_refused_or_left_out(self) -> None:
        for run in ({}, {"schema": 1, "models": "many"}, {"schema": 1, "models": [3]}):
            (self.here / "run.json").write_text(json.dumps(run))
            with self.assertRaisesRegex(CommandError, "holds no run.json with models"):
                models.table([self.here])
            self.assertNotIn("active models", summary(self.here, None))


if __name__ == "__main__":
    unittest.main()
