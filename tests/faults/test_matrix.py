"""Every fault at every phase on both sides, but those of the disk; see test_disk.py."""
from __future__ import annotations

import unittest

from .faults import DISK, FAULTS, PHASES, Cell
from .matrix import play_matrix, used_again
from .relay import BOTH
from .session import Outcome


class Matrix(unittest.TestCase):
    outcomes: dict[Cell, Outcome]

    @classmethod
    def setUpClass(cls) -> None:
        cls.outcomes = play_matrix([name for name in FAULTS if name not in DISK])

    def test_every_cell_ends_as_it_has_to(self) -> None:
        for cell, outcome in self.outcomes.items():
            with self.subTest(cell=str(cell)):
                self.assertEqual(outcome.wrong, [], outcome.said)
                self.assertEqual(outcome.skipped, "")

    def test_the_matrix_is_whole(self) -> None:
        for fault in FAULTS.values():
            if fault.name in DISK:
                continue
            for side in BOTH:
                for phase in PHASES:
                    there = Cell(fault.name, side, phase) in self.outcomes
                    self.assertTrue(there or fault.elsewhere, f"{fault.name}, {side}, {phase}: left out without a reason")

    def test_folders_are_used_again(self) -> None:
        again = {cell for cell, outcome in self.outcomes.items() if outcome.rerun}
        self.assertEqual(again, {cell for cell in self.outcomes if used_again(cell)})
        self.assertEqual({(cell.fault, cell.side) for cell in again},
                         {(cell.fault, cell.side) for cell in self.outcomes})


if __name__ == "__main__":
    unittest.main()
