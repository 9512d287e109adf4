"""`fuzz`: what is launched, and what is made of its end."""
from __future__ import annotations

import contextlib
import io
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools import errors
from tests.fuzz import fuzzers as fuzz

from . import REPOSITORY, sunder


class Fuzz(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.top = Path(temporary.name)
        (self.top / "proto").symlink_to(REPOSITORY / "proto")
        self.said = io.StringIO()
        self.program("fuzz_seeds", "pass")
        contexts: tuple[contextlib.AbstractContextManager[Any], ...] = (
            mock.patch.object(fuzz, "REPOSITORY", self.top), mock.patch.object(fuzz, "_build"),
            mock.patch.object(fuzz, "ensure_installed"), contextlib.redirect_stdout(self.said),
            contextlib.redirect_stderr(self.said))
        for context in contexts:
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)

    def program(self, name: str, body: str) -> None:
        path = self.top / "build" / "fuzz" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"#!/usr/bin/python3\nimport sys\n{body}\n")
        path.chmod(0o755)

    def test_nothing_found(self) -> None:
        self.program("fuzz_pgm", "assert '-runs=7' in sys.argv\nprint('stat::number_of_executed_units: 7')")
        self.assertEqual(sunder(["fuzz", "--target", "pgm", "--runs", "7"]), errors.DONE)
        self.assertRegex(self.said.getvalue(), r"pgm +7 inputs, nothing found")

    def test_a_finding_is_told_and_kept(self) -> None:
        self.program("fuzz_scene", "print('finding: status 4')\nprint('Test unit written to /x/scene-crash')\nsys.exit(77)")
        self.assertEqual(sunder(["fuzz", "--target", "scene"]), errors.CHECK_FAILED)
        for words in ("finding: status 4", "/x/scene-crash", "scene.log"):
            self.assertIn(words, self.said.getvalue())

    def test_every_target_is_run_and_one_finding_is_enough(self) -> None:
        for name in fuzz.TARGETS:
            self.program(f"fuzz_{name}", "sys.exit(1)" if name == "replies" else "pass")
        self.assertEqual(sunder(["fuzz"]), errors.CHECK_FAILED)
        self.assertEqual(self.said.getvalue().count("nothing found"), len(fuzz.TARGETS) - 1)

    def test_refused(self) -> None:
        for arguments in (["--target", "nonesuch"], ["--runs", "0"]):
            self.assertEqual(sunder(["fuzz", *arguments]), errors.BAD_INPUT)
        self.assertIn("there are session", self.said.getvalue())

    def test_targets_are_those_that_are_built(self) -> None:
        text = (REPOSITORY / "tests" / "fuzz" / "CMakeLists.txt").read_text()
        self.assertIn(f"foreach(target {' '.join(sorted(fuzz.TARGETS))})", text)

    def test_what_is_fuzzed_is_complete(self) -> None:
        """The fuzzers have a list of rooms and packages of their own: what a room comes to need must be found there."""
        done = subprocess.run(["cmake", "-S", str(REPOSITORY / "tests" / "fuzz"), "-B", str(self.top / "configured"), "-G", "Ninja"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_words_of_scenes(self) -> None:
        words = fuzz._dictionary(self.top / "dict").read_text().splitlines()
        self.assertIn('"thickness_m"', words)
        self.assertIn('"CLAMPED"', words)


if __name__ == "__main__":
    unittest.main()
