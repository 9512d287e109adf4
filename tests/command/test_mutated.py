"""Mutated files of `validate surfaces`: what is counted, and what is a finding."""
from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools.errors import CommandError
from tests.fuzz.fuzzers import TARGETS
from tests.validation import mutated
from tests.validation.known import SKIPPED
from tests.validation.trials import Missing, Table


class Mutated(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.replay = Path(folder.name) / "fuzz_replay"
        contexts: tuple[contextlib.AbstractContextManager[Any], ...] = (
            contextlib.redirect_stdout(io.StringIO()), mock.patch.object(mutated, "BATCH", {"surface": 100, "cad": 10}),
            mock.patch.object(mutated, "program", lambda name: self.replay))
        for context in contexts:
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)
        self.good()

    def good(self, before: str = "") -> None:
        """A replay that says what it was asked to do; `before` is run first and sees `seed`."""
        self.replay.write_text("#!/usr/bin/python3\nimport os, sys, time\ncorpus, target, count, seed = sys.argv[1:]\n"
                               f"{before}\nprint(f'{{target}}: {{count}} mutations')\n")
        self.replay.chmod(0o755)

    def rows(self, count: int = 250) -> dict[object, dict[str, object]]:
        table = Table(headed=True)
        mutated.run_target(table, self.replay, "surface", count)
        return {row["name"]: row for row in table.rows}

    def test_every_input_is_counted_in_batches_of_their_own_seeds(self) -> None:
        log = self.replay.with_name("log")
        self.good(f"open({str(log)!r}, 'a').write(f'{{count}} {{seed}};')")
        rows = self.rows()
        self.assertEqual(log.read_text(), "100 1;100 2;50 3;")
        self.assertEqual(rows["mutated_surface_inputs"]["computed"], 250)
        self.assertTrue(all(row["pass"] for row in rows.values()))

    def test_a_crash_is_told_with_the_command_that_repeats_it(self) -> None:
        self.good("if seed == '2': sys.stderr.write('finding: a gap'), sys.stderr.flush(), os.abort()")
        rows = self.rows()
        self.assertEqual((rows["mutated_surface_inputs"]["computed"], rows["mutated_surface_crashes"]["computed"]), (150, 1))
        self.assertFalse(rows["mutated_surface_inputs"]["pass"] or rows["mutated_surface_crashes"]["pass"])
        for part in ("fuzz_replay tests/fuzz/corpus surface 100 2: ", "SIGABRT", "finding: a gap"):
            self.assertIn(part, str(rows["mutated_surface_crashes"]["note"]))

    def test_an_input_that_does_not_end_is_a_finding(self) -> None:
        self.good("time.sleep(60)")
        with mock.patch.object(mutated.subprocess, "run", side_effect=mutated.subprocess.TimeoutExpired("x", 61.0)):
            self.assertIn("did not end within 61 s", str(self.rows(1)["mutated_surface_crashes"]["note"]))

    def test_what_did_not_mutate_is_no_success(self) -> None:
        self.good("count = '3'")
        with self.assertRaisesRegex(CommandError, "did not say that it ran 100 mutations of surface"):
            self.rows()

    def test_a_build_without_cad_skips_it(self) -> None:
        self.good("if target == 'cad': sys.stderr.write('has no target cad'), sys.exit(2)")
        with self.assertRaisesRegex(Missing, "has no target cad"):
            mutated.batch(self.replay, "cad", 1, 1)
        table = Table(headed=True)
        with mock.patch.object(mutated, "SHORT", {"cad": 1, "surface": 1}):
            mutated.mutated(table, mock.Mock())
        self.assertEqual([row.get("verdict") for row in table.rows], [SKIPPED, None, None])

    def test_a_million_is_one(self) -> None:
        self.assertEqual(sum(mutated.MILLION.values()), 1_000_000)
        for counts in (mutated.SHORT, mutated.MILLION):
            self.assertLessEqual({*counts} - {"cad"}, {*TARGETS})
            self.assertTrue(all((mutated.CORPUS / target).is_dir() for target in counts))


if __name__ == "__main__":
    unittest.main()
