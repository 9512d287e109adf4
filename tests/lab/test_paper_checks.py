"""What the figures' runs must hold: ratios are those of the books, and the command ends with status 1 where one fails."""
from __future__ import annotations

import argparse
import contextlib
import io
import json
import math
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from tests.command.synthetic import write_vtp

from sunder_lab.paper import checks, command
from sunder_lab.paper.catalogue import CASES
from sunder_lab.paper.checks import Check, Known, books_of, crack_lengths, fracture_energy, missing, said, verdict
from sunder_lab.paper.runs import RECORD, Runs
from sunder_tools.errors import CHECK_FAILED, DONE

SERIES = "time [s],kinetic [J],elastic [J]\n0.1,40,2\n0.2,45,5\n0.3,1,0.5\n"  # 50 J at most


def run_of(residual: float, window: float, length: float, resistance: float = 0.0, impulses: float = 1e-14) -> dict[str, Any]:
    """What the checks read of run.json."""
    return {"status": "done", "ledger": {"linear_max": 1e-15, "angular_max": impulses},
            "energy": {"residual_relative": residual, "window_gap": window},
            "cracks": {"length_m": length, "resistance": resistance}, "counts": {"patches": 1}}


class Books(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "series.csv").write_text(SERIES)

    def scene(self, case: str) -> Any:
        return CASES[case].made("small").message

    def cracks(self, shell: list[int], born: list[float]) -> None:
        """A frame of edges of 1, 2, 3, ... m."""
        (self.folder / "frames").mkdir()
        ends = np.array([[[0.0, k, 0.0], [k + 1.0, k, 0.0]] for k in range(len(shell))]).reshape(-1, 3)
        moved = np.full((len(ends), 3), 0.25)
        write_vtp(self.folder / "frames" / "cracks.vtp", ends + moved, segments=np.arange(len(ends)).reshape(-1, 2), floats="f8",
                  point_data={"displacement": moved, "parameter": ends},
                  cell_data={"shell": np.array(shell), "crack": np.zeros(len(shell), int), "time": np.array(born)})
        (self.folder / "frames.pvd").write_text('<VTKFile><Collection><DataSet timestep="0.3" part="1" file="frames/cracks.vtp"/>'
                                                "</Collection></VTKFile>")

    def test_what_is_missing_is_over_the_fracture_energy_of_the_cracks(self) -> None:
        self.cracks([0, 0, 0], [0.1, 0.1, 0.0])  # 3 m, and a cut of 3 m
        scene, run = self.scene("fig14_even"), run_of(-2e-3, -0.05, 6.0)
        end, window, needed = missing(self.folder, run, scene)
        self.assertAlmostEqual(needed, 250.0 * 5e-3 * 3.0)      # J/m2 times m times m
        self.assertAlmostEqual(end, 2e-3 * 50.0 / 3.75)         # of the largest energy, in J
        self.assertAlmostEqual(window, 0.05 / 3.75)
        by_name = {check.name: check for check in books_of("fig14_even", self.folder, run, scene)}
        self.assertEqual(list(by_name), ["fig14_even_impulses", "fig14_even_missing", "fig14_even_window"])
        self.assertEqual(by_name["fig14_even_impulses"].value, 1e-14)
        self.assertIn("3.75 J", by_name["fig14_even_missing"].words)

    def test_cracks_that_run_by_themselves_have_a_book(self) -> None:
        self.assertEqual(fracture_energy(self.folder, run_of(0.0, 0.0, 3.0, 2.5), self.scene("fig01")), 2.5)

    def test_without_cracks_the_largest_energy_counts(self) -> None:
        self.assertEqual(missing(self.folder, run_of(2e-3, 0.1, 2.0), self.scene("fig13")), (2e-3, 2e-3, 0.0))  # a cut, no strength
        self.assertIn("as there are no crack lines", books_of("fig13", self.folder, run_of(0.0, 0.0, 2.0), self.scene("fig13"))[1].words)

    def test_several_materials_are_summed_shell_by_shell(self) -> None:
        scene = self.scene("fig01")
        names = [shell.name for shell in scene.shells]
        bumper, screen, rear = (names.index(name) for name in ("front_bumper", "windscreen", "rear_window"))
        self.cracks([screen, bumper, rear, bumper], [0.1, 0.2, 0.1, 0.0])  # the last one is a cut
        lengths = crack_lengths(self.folder, len(names))
        assert lengths is not None
        np.testing.assert_allclose(lengths[[screen, bumper, rear]], [1.0, 2.0, 3.0], atol=1e-12)
        wanted = 220.0 * 8e-3 * 1.0 + 1200.0 * 8e-3 * 2.0 + 220.0 * 1e-2 * 3.0  # two plies of 4 mm beside an interlayer
        self.assertAlmostEqual(fracture_energy(self.folder, run_of(0.0, 0.0, 6.0), scene), wanted)
        self.assertIsNone(crack_lengths(self.folder, screen))  # fewer shells than there are numbers
        with mock.patch.object(checks, "crack_lengths", lambda folder, shells: None):
            self.assertTrue(math.isnan(fracture_energy(self.folder, run_of(0.0, 0.0, 6.0), scene)))

    def test_a_run_that_is_not_done_or_has_no_curves_does_not_pass(self) -> None:
        self.assertEqual(books_of("fig13", self.folder, {"status": "failed"}, self.scene("fig13")), [])
        (self.folder / "series.csv").unlink()
        self.cracks([0, 0], [0.1, 0.1])
        books = books_of("fig14_even", self.folder, run_of(0.0, 0.0, 3.0), self.scene("fig14_even"))
        self.assertEqual([verdict(check, "full") for check in books], ["held", "failed", "held"])


class Verdict(unittest.TestCase):
    def test_is_known_up_to_a_limit_and_in_one_size(self) -> None:
        with mock.patch.dict(checks.KNOWN, {("small", "a_missing"): Known(0.03, "a reason")}, clear=True):
            def of(value: float, size: str = "small") -> str:
                return verdict(Check("a_missing", value, 0.01, "a"), size)
            self.assertEqual([of(0.01), of(0.03), of(0.031), of(math.nan), of(0.02, "full")],
                             ["held", "known", "failed", "failed", "failed"])
            self.assertIn("Known up to 0.03: a reason.", said(Check("a_missing", 0.02, 0.01, "a"), "small"))
            self.assertEqual(said(Check("a_missing", 0.02, 0.01, "a"), "full"), "a: 0.02, above the limit of 0.01.")

    def test_every_known_one_is_a_check_that_there_is(self) -> None:
        names = {f"{case}_{what}" for case in CASES for what in ("impulses", "missing", "window")} | {"fig16_depth"}
        for (size, name), gap in checks.KNOWN.items():
            self.assertIn(size, ("small", "full"))
            self.assertIn(name, names)
            self.assertGreater(gap.largest, 0.005 if name == "fig16_depth" else checks.MOST_MISSING, name)
            self.assertNotIn("impulses", name)


class Status(unittest.TestCase):
    """The command on a figure whose run and pictures are there."""

    def ends(self, residual: float, depth: float = 0.0) -> tuple[int, str, str]:
        """Exit status, what was said, and the page."""
        with tempfile.TemporaryDirectory() as name:
            runs = Runs(Path(name), "small", "1", True)
            folder = runs.place("fig13")
            folder.mkdir(parents=True)
            (folder / "run.json").write_text(json.dumps(run_of(residual, 0.0, 2.0)))
            (folder / "series.csv").write_text(SERIES)
            (runs.folder / "fig13.png").write_text("")
            identity = runs.identity("fig13")
            (runs.folder / RECORD).write_text(json.dumps({
                "cases": {"fig13": {"identity": identity, "wall_s": 1.0, "failed": ""}},
                "figures": {"13": {"of": {"fig13": identity}, "pictures": [["fig13.png", "a picture"]], "found": [],
                                   "checks": [["fig13_depth", depth, 0.5, "a depth"]]}}}))
            told = io.StringIO()
            with contextlib.redirect_stderr(told), contextlib.redirect_stdout(told):
                status = command.paper(argparse.Namespace(figures=[13], out=Path(name), size="small", threads="1", quiet=True))
            return status, told.getvalue(), (runs.folder / "index.html").read_text()

    def setUp(self) -> None:
        # Figure 13 asked for by its number would be drawn anew; its picture is kept here.
        draw = command.draw
        patch = mock.patch.object(command, "draw", lambda runs, figure, again: draw(runs, figure, False))
        patch.start()
        self.addCleanup(patch.stop)

    def test_is_0_where_all_checks_hold(self) -> None:
        status, told, page = self.ends(5e-3)
        self.assertEqual(status, DONE, told)
        self.assertIn("0.005", page)
        self.assertNotIn("Checks that fail", page)

    def test_is_1_where_energy_is_missing(self) -> None:
        status, told, page = self.ends(2e-2)
        self.assertEqual(status, CHECK_FAILED, told)
        self.assertIn("figure 13: fig13: energy that is missing at the end, of the largest energy of the run", told)
        self.assertIn("above the limit of 0.01", page)
        self.assertIn("Checks that fail", page)

    def test_is_1_where_a_drawing_measures_too_much(self) -> None:
        status, told, page = self.ends(0.0, 0.6)
        self.assertEqual(status, CHECK_FAILED, told)
        self.assertIn("a depth: 0.6, above the limit of 0.5.", told)
        self.assertIn("a depth", page)


if __name__ == "__main__":
    unittest.main()
