"""`bench --against`: two made-up programs in turns; how fast anything is decides nothing here."""
from __future__ import annotations

import contextlib
import io
import json
import os
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools.places import BUILD_DIR_VARIABLE
from tests.benchmarks import against

from . import sunder
from .fakes import write_executables


class Against(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        write_executables(self.folder / "here")
        self.said, self.told = io.StringIO(), io.StringIO()
        environment = mock.patch.dict(os.environ, {BUILD_DIR_VARIABLE: str(self.folder / "here")})
        contexts: tuple[contextlib.AbstractContextManager[Any], ...] = (
            environment, contextlib.redirect_stderr(self.said), contextlib.redirect_stdout(self.told))
        for context in contexts:
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)

    def program(self, side: str, *rounds: dict[str, float | None], last: int = 0) -> None:
        """A program that writes these numbers in turn, notes its name and arguments, and ends its last run with that status."""
        path = self.folder / side / "tests" / "sunder-bench"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"""#!/usr/bin/python3
import sys
calls = {str(self.folder / 'calls')!r}
with open(calls, "a") as out:
    out.write({side!r} + " " + " ".join(sys.argv[1:-1]) + chr(10))
rounds = {[json.dumps(one) for one in rounds]!r}
number = sum(line.startswith({side!r}) for line in open(calls)) - 1
open(sys.argv[-1], "w").write(rounds[number])
sys.exit({last} if number == len(rounds) - 1 else 0)
""")
        path.chmod(0o755)

    def calls(self) -> list[str]:
        return (self.folder / "calls").read_text().splitlines()

    def against(self, *options: str) -> int:
        return sunder(["bench", "--against", str(self.folder / "there"), *options])

    def test_rounds_take_turns_and_the_least_times_decide(self) -> None:
        self.program("here", {"force_ns_per_layer_point": 8.0, "fma_peak_gflops": 50.0}, {"force_ns_per_layer_point": 12.0, "fma_peak_gflops": 60.0})
        self.program("there", {"force_ns_per_layer_point": 10.0, "fma_peak_gflops": 60.0}, {"force_ns_per_layer_point": 8.0, "fma_peak_gflops": 40.0})
        table = self.folder / "table.json"
        self.assertEqual(self.against("--rounds", "2", "--filter", "force", "--json", str(table)), 0)
        self.assertEqual(self.calls(), [f"{side} --filter force --json" for side in ("here", "there", "there", "here")])
        peak, force = json.loads(table.read_text())["cases"]
        self.assertEqual(force, {"name": "force_ns_per_layer_point", "computed": 1.0, "reference": 1.0, "error": 0.0, "tolerance": 0.02,
                                 "pass": True, "here": 8.0, "there": 8.0, "spread": [0.8, 1.5]})
        self.assertEqual((peak["computed"], peak["tolerance"], peak["here"], peak["there"]), (1.0, None, 60.0, 60.0))
        self.assertIn("slower than 2 %: no kernel, of 1\n", self.told.getvalue())
        self.assertRegex(self.told.getvalue(), r"force_ns_per_layer_point +8 +8 +1\.000 +0\.800–1\.500  ok\n")

    def test_a_kernel_beyond_the_limit_fails_and_another_number_does_not(self) -> None:
        for time, status in ((10.19, 0), (10.21, 1)):
            (self.folder / "calls").unlink(missing_ok=True)
            self.program("here", {"step_ms_160k_layer_points": time, "window_roundtrip_us_4k_p50": 90.0})
            self.program("there", {"step_ms_160k_layer_points": 10.0, "window_roundtrip_us_4k_p50": 50.0})
            self.assertEqual(self.against("--rounds", "1"), status)
        self.assertIn("SLOWER\n", self.told.getvalue())
        self.assertIn("slower than 2 %: step_ms_160k_layer_points, of 1\n", self.told.getvalue())

    def test_a_number_that_is_none_is_slower(self) -> None:
        self.program("here", {"force_ns_per_layer_point": None})
        self.program("there", {"force_ns_per_layer_point": 1.0})
        self.assertEqual(self.against("--rounds", "1"), 1)

    def test_keys_of_one_build_are_named(self) -> None:
        self.program("here", {"force_ns_a": 1.0, "new": 2.0})
        self.program("there", {"force_ns_a": 1.0, "old": 2.0})
        self.assertEqual(self.against("--rounds", "1"), 0)
        self.assertIn("only here: new\nonly there: old\n", self.told.getvalue())

    def test_no_kernel_at_all_is_no_proof(self) -> None:
        cases: list[tuple[list[str], int]] = [([], 1), (["--filter", "window"], 0)]
        for options, status in cases:
            (self.folder / "calls").unlink(missing_ok=True)
            self.program("here", {"a": 1.0})
            self.program("there", {"b": 1.0})
            self.assertEqual(self.against("--rounds", "1", *options), status)

    def test_an_interruption_keeps_whole_rounds(self) -> None:
        self.program("here", {"force_ns_a": 1.0}, {"force_ns_a": 3.0}, last=130)
        self.program("there", {"force_ns_a": 1.0}, {"force_ns_a": 2.0})
        table = self.folder / "table.json"
        self.assertEqual(self.against("--rounds", "3", "--json", str(table)), 130)
        self.assertIn("interrupted: 1 of 3 rounds\n", self.told.getvalue())
        self.assertEqual([row["computed"] for row in json.loads(table.read_text())["cases"]], [1.0])

    def test_refused(self) -> None:
        self.program("here", {"a": 1.0})
        self.assertEqual(self.against(), 2)
        self.assertRegex(self.said.getvalue(), r"--against .*/there: has no program tests/sunder-bench; name a build folder, .*: "
                         r"cmake --build .*/there --target sunder-bench")
        for options, words in ((["--against", "x", "--runs"], "leave --runs out"),
                               (["--against", "x", "--profile", "p.png"], "leave --profile out"),
                               (["--rounds", "3"], "goes with --against DIR"),
                               (["--against", "x", "--rounds", "0"], "--rounds 0: takes a number from 1 on")):
            self.assertEqual(sunder(["bench", *options]), 2)
            self.assertIn(words, self.said.getvalue())
        self.assertFalse((self.folder / "calls").exists())

    def test_no_ratio_is_lost_at_zero(self) -> None:
        rows = against.compared([({"a": 0.0, "b": 1.0}, {"a": 0.0, "b": 0.0})])
        self.assertEqual([row.ratio for row in rows], [1.0, float("inf")])


if __name__ == "__main__":
    unittest.main()
