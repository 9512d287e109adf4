"""The table of models that go together: each cell is what a run of that pair does."""
from __future__ import annotations

import unittest

from tests.docs.pairs import BEGIN, END, MODELS, PAGE, RUNS, parts_of, table
from sunder_tools.launch.build import ensure_built


class Pairs(unittest.TestCase):
    def test_each_cell_is_what_a_run_says(self) -> None:
        written = parts_of(PAGE.read_text())[1].splitlines()
        made = table(ensure_built().single).splitlines()
        for line, other in zip(made, written):
            self.assertEqual(line, other, "run tests/docs/pairs.py again")
        self.assertEqual(len(made), len(written))
        cells = [cell for row in made[2:2 + len(MODELS)] for cell in row.split(" | ")]
        self.assertGreater(cells.count(RUNS), len(cells) // 2)

    def test_a_page_without_the_marks_is_refused(self) -> None:
        self.assertEqual(parts_of(f"a\n{BEGIN}\nb\n{END}\nc"), (f"a\n{BEGIN}\n", "b", f"\n{END}\nc"))
        with self.assertRaisesRegex(ValueError, "needs the lines"):
            parts_of(f"a\n{BEGIN}\nb")


if __name__ == "__main__":
    unittest.main()
