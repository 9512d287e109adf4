"""The run folder on a small disk that fills up. Needs the right to mount one, and says so where that is missing."""
from __future__ import annotations

import unittest

from .faults import DISK
from .matrix import play_matrix


class Disk(unittest.TestCase):
    def test_every_cell_ends_as_it_has_to(self) -> None:
        outcomes = play_matrix(list(DISK))
        reasons = {outcome.skipped for outcome in outcomes.values()} - {""}
        if reasons:
            self.skipTest(", ".join(reasons))
        for cell, outcome in outcomes.items():
            with self.subTest(cell=str(cell)):
                self.assertEqual(outcome.wrong, [], outcome.said)


if __name__ == "__main__":
    unittest.main()
