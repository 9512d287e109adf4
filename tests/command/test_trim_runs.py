"""Cracks over tied trims: means over heights of the notch, and what a crack that does not arrive makes of them."""
from __future__ import annotations

import contextlib
import io
import math
import unittest
from unittest import mock

import numpy as np

from tests.validation import trim_runs
from tests.validation.trials import Table
from tests.validation.trim_runs import INSETS, NOTCHES, SPACING, mean_and_error, pulled_text


class TrimCracks(unittest.TestCase):
    def test_the_mean_and_its_standard_error(self) -> None:
        mean, error = mean_and_error([1.0, 2.0, 3.0])
        self.assertEqual(mean, 2.0)
        self.assertAlmostEqual(error, 1.0 / math.sqrt(3.0), places=15)
        self.assertTrue(all(math.isnan(x) for x in mean_and_error([1.0, math.nan])))

    def test_heights_are_of_one_spacing_and_in_the_scene(self) -> None:
        self.assertEqual(len(set(NOTCHES)), len(NOTCHES))
        self.assertLess(max(NOTCHES) - min(NOTCHES), SPACING)
        for notch in NOTCHES:
            self.assertIn(f"v: {notch!r} }} points", pulled_text(INSETS[0], notch))

    def rows(self, late: float) -> dict[object, dict[str, object]]:
        """Rows of made-up runs; the last height of a piece let in is `late` [s]."""
        def pulled(_: object, __: object, inset: object, notch: float, planes: np.ndarray) -> tuple:
            when = np.linspace(1.0, 2.0, len(planes))
            when[-1] += late if inset is not None and notch == NOTCHES[-1] else 0.0
            return np.full(len(planes), notch), when, 0.0, 1.0

        table = Table(headed=True)
        with mock.patch.object(trim_runs, "_pulled", pulled), contextlib.redirect_stdout(io.StringIO()):
            trim_runs.trim_crack(table, mock.Mock())
        return {row["name"]: row for row in table.rows}

    def test_rows_are_of_the_middle_height_and_means(self) -> None:
        rows = self.rows(0.2)
        self.assertAlmostEqual(float(str(rows["trim_crack_turned_mean_arrival"]["computed"])), 1.04, places=12)
        self.assertIn("standard error 0.04", str(rows["trim_crack_turned_mean_arrival"]["note"]))
        self.assertTrue(all(row["pass"] for row in rows.values()))
        late = self.rows(0.3)
        self.assertFalse(late["trim_crack_curved_mean_arrival"]["pass"])
        self.assertTrue(late["trim_crack_curved_arrival"]["pass"], "is of the middle height alone")

    def test_a_crack_that_does_not_arrive_fails(self) -> None:
        self.assertFalse(self.rows(math.nan)["trim_crack_straight_mean_arrival"]["pass"])


if __name__ == "__main__":
    unittest.main()
