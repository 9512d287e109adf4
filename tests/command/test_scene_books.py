"""`validate coupling --case scenes`: what counts as closed, and that no scene is left out."""
from __future__ import annotations

import contextlib
import io
import math
import re
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from sunder_tools.errors import BAD_INPUT, CommandError
from sunder_tools.launch.shipped import shipped
from tests.validation import scene_books, trials
from tests.validation.scene_books import REPEATED, SHIPPED, Shortened, books_of


def run_of(linear: float = 2e-15, angular: float = 1e-15, mass: float = 3e-15, spin: float = 4e-15, pieces: int = 2) -> dict:
    return {"ledger": {"linear_max": linear, "angular_max": angular}, "counts": {"handed_off": pieces},
            "handoff": {"mass_error_max": mass, "momentum_error_max": 1e-16, "angular_momentum_error_max": spin},
            "time": {"windows": 7}}


class Books(unittest.TestCase):
    PANE = Shortened("pane", 1e-3, True, True)

    def test_the_largest_counts(self) -> None:
        self.assertEqual(books_of(run_of(), self.PANE), (2e-15, 4e-15))
        self.assertEqual(books_of(run_of(angular=1e-3, mass=1e-5), self.PANE), (1e-3, 1e-5))

    def test_what_has_not_happened_is_not_closed(self) -> None:
        self.assertTrue(math.isnan(books_of(run_of(linear=0.0, angular=0.0), self.PANE)[0]))
        self.assertTrue(math.isnan(books_of(run_of(pieces=0), self.PANE)[1]))

    def test_no_scene_with_bodies_is_left_out(self) -> None:
        # books of the paper's scenes are checked as its figures are drawn
        there = {scene.name for scene in shipped() if not scene.name.startswith("paper/")
                 and re.search(r"^bodies\b", scene.path.read_text(), re.M)}
        self.assertEqual(sorted(there), sorted((*REPEATED, *(wanted.scene for wanted in SHIPPED))))


class Rows(unittest.TestCase):
    """With every run made up: which rows pass, which fail."""

    def rows(self, launch: object, words: list[str]) -> trials.Table:
        table = trials.Table()
        with tempfile.TemporaryDirectory() as folder, \
                mock.patch.object(scene_books, "SHIPPED", (Shortened("glass", 1e-3, True, True),)), \
                mock.patch.object(scene_books, "launch_once", side_effect=launch), \
                mock.patch.object(trials.engines, "names", return_value=["made_up"]), \
                mock.patch.object(trials.engines, "resolve"), \
                mock.patch.object(trials.engines, "hello", return_value={"capabilities": words}), \
                contextlib.redirect_stdout(io.StringIO()):
            scene_books.scenes(table, mock.Mock(folder=Path(folder)))
        return table

    def test_a_cad_scene_has_a_build_that_reads_it(self) -> None:
        with mock.patch.object(scene_books, "launch_once", return_value=run_of()) as launched, \
                mock.patch.object(scene_books, "ensure_built") as built, contextlib.redirect_stdout(io.StringIO()):
            table = trials.Table()
            for scene in ("glass", "cad/windscreen"):
                scene_books._one(table, mock.sentinel.plain, "made_up", [], Shortened(scene, 1e-3, True, False))
        built.assert_called_once_with(cad=True)
        self.assertEqual([call.args[0] for call in launched.call_args_list], [mock.sentinel.plain, built.return_value])
        self.assertIn("cad_windscreen_made_up_impulse", [row["name"] for row in table.rows])

    def test_a_run_that_closes(self) -> None:
        table = self.rows(lambda *_: run_of(), ["double_precision"])
        self.assertEqual([(row["name"], row["pass"]) for row in table.rows],
                         [("glass_made_up_impulse", True), ("glass_made_up_birth", True)])

    def test_one_that_does_not(self) -> None:
        table = self.rows(lambda *_: run_of(linear=2e-12, spin=2e-10), [])
        self.assertEqual([row["pass"] for row in table.rows], [False, False])
        self.assertIn("declares no double precision", table.lines[0])

    def test_a_run_that_fails_is_a_failed_row(self) -> None:
        table = self.rows(CommandError("ledger: window 3"), [])
        self.assertEqual([row["pass"] for row in table.rows], [False])
        self.assertIn("ledger: window 3", table.lines[-1])

    def test_only_what_an_engine_does_not_declare_is_left_out(self) -> None:
        refused = CommandError("the engine 'made_up' cannot do 'joints', which the scene needs", BAD_INPUT)
        self.assertEqual(self.rows(refused, ["contact"]).rows, [])
        self.assertEqual([row["pass"] for row in self.rows(refused, ["contact", "joints"]).rows], [False])

    def test_an_engine_that_does_not_answer_fails_and_one_that_cannot_be_installed_does_not(self) -> None:
        silent = CommandError("made_up: no answer within 30 s")
        with mock.patch.object(trials.engines, "hello", side_effect=silent), \
                mock.patch.object(trials.engines, "names", return_value=["made_up"]), \
                contextlib.redirect_stdout(io.StringIO()):
            for resolved, rows in ((None, [("scenes_made_up_answers", False)]), (CommandError("no package"), [])):
                table = trials.Table()
                with mock.patch.object(trials.engines, "resolve", side_effect=resolved):
                    scene_books.scenes(table, mock.Mock())
                self.assertEqual([(row["name"], row["pass"]) for row in table.rows], rows)
                self.assertEqual(len(table.lines), 1)


if __name__ == "__main__":
    unittest.main()
