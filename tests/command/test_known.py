"""What validation is known not to reach: rows that fail as known, by more, or no longer."""
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

from sunder_tools import errors
from sunder_tools.launch import build
from sunder_tools.places import BUILD_DIR_VARIABLE
from tests.validation import experiments, known, measure
from tests.validation.results import FIRST_USE

from . import sunder
from .fakes import write_executables


def row(name: str, error: float | None, tolerance: float) -> dict[str, object]:
    return {"name": name, "error": error, "tolerance": tolerance, "pass": error is not None and error <= tolerance}


GAPS = {"share": known.Gap(0.6, "coarse grid")}


class Lists(unittest.TestCase):
    def read(self, text: str) -> dict[str, known.Gap]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "known.txt"
            path.write_text(text)
            return known.read_known(path)

    def test_a_list_is_read(self) -> None:
        self.assertEqual(self.read("# why\n\nshare 0.6 coarse grid\n"), GAPS)
        self.assertEqual(known.read_known(Path("/nowhere/known.txt")), {})

    def test_a_bad_line_is_refused_with_its_place_and_value(self) -> None:
        for line, word in (("share", "no error or no reason"), ("share 0.6", "no reason"), ("share much coarse", "'much'"),
                           ("share nan coarse", "'nan'"), ("share inf coarse", "'inf'"), ("share -1 coarse", "'-1'"),
                           ("share 0 coarse", "'0'"), ("share 0.6 a\nshare 0.7 b", "twice")):
            with self.assertRaises(errors.CommandError, msg=line) as caught:
                self.read("# list\n" + line + "\n")
            self.assertIn(word, str(caught.exception))
            self.assertIn(f"known.txt:{3 if word == 'twice' else 2}: 'share'", str(caught.exception))

    def test_what_is_no_text_is_refused(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "known.txt"
            path.write_bytes(b"share 0.6 \xff\n")
            for bad in (path, Path(folder)):
                with self.assertRaises(errors.CommandError) as caught:
                    known.read_known(bad)
                self.assertIn(f"{bad}: cannot be read as UTF-8 text", str(caught.exception))

    def test_the_lists_of_the_repository_can_be_read_and_name_a_kind(self) -> None:
        lists = sorted(known.KNOWN.glob("*"))
        self.assertIn("cracks.txt", [path.name for path in lists])
        for path in lists:
            self.assertIn(path.stem, (*measure.VALIDATIONS, FIRST_USE))
            self.assertTrue(known.read_known(path), path)


class Judging(unittest.TestCase):
    def test_a_row_may_fail_as_far_as_it_is_known_to(self) -> None:
        rows = [row("share", 0.5, 0.15), row("books", 0.001, 0.01)]
        good, lines = known.judge(rows, GAPS, every=True)
        self.assertTrue(good)
        self.assertEqual(rows[0]["known"], "coarse grid")
        self.assertNotIn("known", rows[1])
        self.assertEqual(len(lines), 1)
        self.assertIn("coarse grid", lines[0])

    def test_beyond_that_without_a_number_and_unlisted_it_fails(self) -> None:
        cases: list[dict[str, object]] = [
            {**row("share", None, 0.0), "tolerance": None}, row("share", 0.61, 0.15), row("share", None, 0.15),
            row("share", float("nan"), 0.15), row("other", 0.5, 0.15)]
        for bad in cases:
            good, lines = known.judge([bad], GAPS, every=False)
            self.assertFalse(good, bad)
            self.assertNotIn("known", bad)
            self.assertTrue(lines[0].startswith(f"FAILED    {bad['name']}"), lines)

    def test_what_is_reached_is_told_and_a_row_that_is_gone_is_wrong(self) -> None:
        good, lines = known.judge([row("share", 0.1, 0.15)], GAPS, every=True)
        self.assertTrue(good)
        self.assertIn("reached   share", lines[0])
        self.assertEqual(known.judge([row("books", 0.0, 0.1)], GAPS, every=False), (True, []))
        self.assertFalse(known.judge([row("books", 0.0, 0.1)], GAPS, every=True)[0])


class Command(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        write_executables(self.folder / "build")
        (self.folder / "shells.txt").write_text("share 0.6 coarse grid\n")
        self.said, self.told = io.StringIO(), io.StringIO()
        contexts: tuple[contextlib.AbstractContextManager[Any], ...] = (
            mock.patch.dict(os.environ, {BUILD_DIR_VARIABLE: str(self.folder / "build")}),
            mock.patch.object(measure, "KNOWN", self.folder),
            contextlib.redirect_stderr(self.said), contextlib.redirect_stdout(self.told))
        for context in contexts:
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)

    def validate(self, share: float, *arguments: str) -> int:
        def run(table: experiments.Table, executables: build.Executables) -> None:
            del executables
            table.add("share", share, 0.0, 0.15, 0.0)

        with mock.patch.dict(experiments.EXPERIMENTS, {"shells": (experiments.Experiment("cost", "share", run),)}):
            return sunder(["validate", "shells", "--case", "cost", *arguments])

    def test_a_goal_that_is_missed_as_known_fails_but_where_the_known_is_asked_for(self) -> None:
        table = self.folder / "table.json"
        self.assertEqual([self.validate(0.5), self.validate(0.5, "--known", "--json", str(table))], [1, 0])
        self.assertEqual(json.loads(table.read_text())["cases"][0]["known"], "coarse grid")
        self.assertEqual([self.validate(0.7), self.validate(0.7, "--known")], [1, 1])
        self.assertEqual([self.validate(0.1), self.validate(0.1, "--known")], [0, 0])
        self.assertIn("known     share: off by 0.5, by 0.6 at most: coarse grid", self.told.getvalue())

    def test_kinds_without_a_list_refuse_it(self) -> None:
        for kind in ("engines", "extremes"):
            self.assertEqual(sunder(["validate", kind, "--known"]), 2)
            self.assertIn(f"not with 'validate {kind}'", self.said.getvalue())


if __name__ == "__main__":
    unittest.main()
