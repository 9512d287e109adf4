"""Skeletons, the stages of a crack's growth, and the validation case that uses them."""
from __future__ import annotations

import contextlib
import io
import json
import math
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from PIL import Image

from sunder_tools.launch import build
from sunder_tools.pictures.vtp import VtpError
from tests.validation import experiments, stages, trials
from tests.validation.thinning import closed, grown, share_outside, thinned

from . import sunder
from .crack_history import STAGES, history, write_history


class Thinning(unittest.TestCase):
    def test_a_bar_becomes_its_middle_line(self) -> None:
        bar = np.zeros((40, 80), bool)
        bar[15:24, 10:70] = True
        line = thinned(bar)
        rows, columns = np.nonzero(line)
        self.assertLessEqual(float(np.ptp(rows[(columns > 16) & (columns < 63)])), 1)  # its ends may fork
        self.assertTrue(set(range(16, 63)) <= set(columns))
        self.assertAlmostEqual(float(np.median(rows)), 19.0, delta=1.0)

    def test_what_hangs_together_stays_together_and_a_ring_stays_a_ring(self) -> None:
        y, x = np.mgrid[-30:31, -30:31]
        radius = np.hypot(x, y)
        line = thinned((radius > 12) & (radius < 24))
        self.assertTrue(line.any())
        self.assertLess(np.abs(radius[line] - 18.0).max(), 2.0)
        outside = np.zeros_like(line)
        outside[0, 0] = True
        for _ in range(line.size):  # what can be reached from the corner does not reach the middle
            more = grown(outside, 1.0) & ~line
            if (more == outside).all():
                break
            outside = more
        self.assertFalse(outside[30, 30])

    def test_nothing_stays_nothing_and_a_single_pixel_stays(self) -> None:
        self.assertFalse(thinned(np.zeros((5, 5), bool)).any())
        one = np.zeros((5, 5), bool)
        one[0, 4] = True
        np.testing.assert_array_equal(thinned(one), one)

    def test_holes_of_a_pixel_are_closed_and_larger_ones_stay(self) -> None:
        image = np.ones((20, 20), bool)
        image[5, 5] = False
        image[10:16, 10:16] = False
        self.assertEqual(int((~closed(image)).sum()), 36)

    def test_what_is_within_a_radius_is_a_disc(self) -> None:
        image = np.zeros((21, 25), bool)
        image[10, 12] = image[0, 24] = True
        y, x = np.mgrid[:21, :25]
        for radius in (0.0, 1.0, 1.5, 4.2):
            disc = (np.hypot(y - 10, x - 12) <= radius) | (np.hypot(y, x - 24) <= radius)
            np.testing.assert_array_equal(grown(image, radius), disc)

    def test_the_share_outside_counts_what_is_further_than_the_radius(self) -> None:
        line, other = np.zeros((30, 30), bool), np.zeros((30, 30), bool)
        line[10, 5:25] = True
        other[12, 5:15] = True
        self.assertEqual(share_outside(line, line, 0.0), 0.0)
        self.assertEqual(share_outside(line, other, 1.0), 1.0)
        self.assertAlmostEqual(share_outside(line, other, 2.0), 0.5)
        self.assertTrue(math.isnan(share_outside(np.zeros((3, 3), bool), np.ones((3, 3), bool), 1.0)))


class InAFolder(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)


class StagesOfARun(InAFolder):
    def test_three_stages_are_found_and_drawn(self) -> None:
        write_history(self.folder, history())
        found = stages.find_stages(self.folder)
        self.assertEqual([(s.time_s, len(s.cracks)) for s in found.stages], [(2.0, 4), (3.0, 7), (4.0, 8)])
        for stage, later in zip(found.stages, found.stages[1:]):
            self.assertFalse((stage.region & ~later.region).any())
            self.assertTrue(stage.skeleton.any())
        self.assertLessEqual(found.share_moved(), found.share_moved(stages.FINE))
        stages.write_stages(found, self.folder / "stages.png")
        with Image.open(self.folder / "stages.png") as image:
            self.assertEqual(image.width, 2 * stages.WIDTH + 3 * stages.GAP)
            seen = set(map(tuple, np.asarray(image).reshape(-1, 3)))
        for colour in (*stages.STAGE, stages.REGION):
            self.assertIn(tuple(int(255 * c + 0.5) for c in colour), seen)

    def test_a_run_whose_cracks_do_not_grow_is_refused(self) -> None:
        write_history(self.folder, [history()[0], *((t, STAGES[1][1]) for t in (1.0, 2.0, 3.0))])
        with self.assertRaisesRegex(VtpError, "no crack grows"):
            stages.find_stages(self.folder)


class Consistency(InAFolder):
    injected = 0.0  # [J]

    def validate(self, frames: list, *arguments: str) -> tuple[int, dict[str, object]]:
        """`validate cracks --case consistency` on made-up runs; status, and what each row computed."""
        def launch(executables: object, scene: Path, folder: Path, settings: list[str]) -> dict[str, object]:
            del executables, scene, settings
            write_history(folder, frames)
            energy = {"crack_injected": self.injected, "dissipated_fracture": 2.0}
            (folder / "run.json").write_text(json.dumps({"energy": energy}))
            return {}

        report = self.folder / "table.json"
        self.said = io.StringIO()
        nothing = build.Executables(Path("shell"), Path("rigid"), Path("single"))
        with mock.patch.object(trials, "launch_once", launch), \
                mock.patch.object(experiments, "ensure_built", lambda: nothing), \
                contextlib.redirect_stdout(self.said), contextlib.redirect_stderr(self.said):
            status = sunder(["validate", "cracks", "--case", "consistency", "--json", str(report), *arguments])
        return status, {row["name"]: row["computed"] for row in json.loads(report.read_text())["cases"]}

    def test_a_sound_history_passes_and_is_drawn(self) -> None:
        pictures = self.folder / "new" / "pictures"
        with mock.patch.object(experiments, "FEWEST_GROWING", 4):
            status, rows = self.validate(history(), "--pictures", str(pictures))
        self.assertEqual((status, set(rows.values())), (0, {0}), self.said.getvalue())
        self.assertIn("of the middle line", self.said.getvalue())
        self.assertTrue((pictures / "crack_stages.png").is_file())

    def test_a_fault_fails_and_so_does_a_run_that_proves_nothing(self) -> None:
        frames = history()
        del frames[3][1][1]
        with mock.patch.object(experiments, "FEWEST_GROWING", 4):
            status, rows = self.validate(frames)
        self.assertEqual((status, rows["glass_cracks_lost"], rows["torn_sheet_cracks_gaps"]), (1, 2, 0))
        self.injected = 0.1
        with mock.patch.object(experiments, "FEWEST_GROWING", 4):
            status, rows = self.validate(history())
        self.assertEqual((status, rows["torn_sheet_injected"], rows["torn_sheet_cracks_lost"]), (1, 0.05, 0))
        status, rows = self.validate(history())  # four frames with new edges
        self.assertEqual((status, set(rows.values())), (1, {None}))

    def test_a_folder_for_pictures_that_cannot_be_is_refused(self) -> None:
        (self.folder / "file").write_text("")
        with contextlib.redirect_stderr(io.StringIO()) as said:
            self.assertEqual(sunder(["validate", "cracks", "--pictures", str(self.folder / "file" / "x")]), 2)
        self.assertIn("cannot write into", said.getvalue())


if __name__ == "__main__":
    unittest.main()
