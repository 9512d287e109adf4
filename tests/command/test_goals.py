"""Goals of benchmarks: each is of a number that the program promises."""
from __future__ import annotations

import subprocess
import unittest

from tests.benchmarks import goals
from tests.validation import results
from tests.validation.programs import program


class Goals(unittest.TestCase):
    def test_every_goal_is_of_a_number_that_the_program_promises(self) -> None:
        told = subprocess.run([str(program("sunder-bench")), "--list"], stdout=subprocess.PIPE, text=True, check=True).stdout
        promised = {line.partition(": ")[2] for line in told.splitlines() if ": " in line}
        self.assertEqual(promised, {goals.RATIOS[key][0] if key in goals.RATIOS else key for key in goals.BENCH_GOALS})

    def test_a_status_line_tells_how_numbers_stand_to_their_goals(self) -> None:
        numbers: dict[str, object] = {"share_of_fma_peak": 0.2, "absent_time_ratio": 1.0, "trimmed_point_ratio": 1.52, "memory_gb_per_s": 15.0}
        found = results.result_of("bench", numbers, 60.0, {"commit": "abc", "date": "2026-01-01"})
        self.assertEqual(found.in_words(3), "4 numbers: 1 met, 1 missed, 1 beyond the limit (share_of_fma_peak)")
        self.assertIn("| bench | 4 numbers: 1 met, 1 missed, 1 beyond the limit (share_of_fma_peak) |", results.status([found]))
        table = results.page("Results of benchmarks", [found])
        for row in ("| share_of_fma_peak | 0.2 | ≥ 0.35 | ≥ 0.22 | beyond the limit |", "| trimmed_point_ratio | 1.52 | ≤ 1.5 | ≤ 1.55 | missed |",
                    "| absent_time_ratio | 1 | ≤ 1.02 | ≤ 1.27 | met |", "| memory_gb_per_s | 15 |  |  |  |"):
            self.assertIn(row, table)
        self.assertEqual(goals.standing("absent_time_ratio", float("nan")), goals.BEYOND)
        self.assertEqual(goals.standing("absent_time_ratio", None), goals.BEYOND)


if __name__ == "__main__":
    unittest.main()
