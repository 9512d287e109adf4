"""Goals of benchmarks: each is of a number that the program promises."""
from __future__ import annotations

import subprocess
import unittest

from tests.benchmarks import goals
from tests.validation.programs import program


class Goals(unittest.TestCase):
    def test_every_goal_is_of_a_number_that_the_program_promises(self) -> None:
        told = subprocess.run([str(program("sunder-bench")), "--list"], stdout=subprocess.PIPE, text=True, check=True).stdout
        promised = {line.partition(": ")[2] for line in told.splitlines() if ": " in line}
        self.assertEqual(promised, {goals.RATIOS[key][0] if key in goals.RATIOS else key for key in goals.BENCH_GOALS})


if __name__ == "__main__":
    unittest.main()
