"""`validate` and `bench`: what is handed to the programs, what is made of their numbers."""
from __future__ import annotations

import contextlib
import io
import json
import os
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from . import REPOSITORY  # noqa: F401: puts coupler/ on the path
from .fakes import write_executables
from sunder_tools import build, command

NUMBERS = {"cases": [{"name": "a", "computed": 1.0, "reference": 1.0, "error": 0.0, "tolerance": 0.1, "pass": True,
                      "seconds": 0.0}],
           "curves": [{"name": "order", "x_label": "elements", "y_label": "error", "logarithmic": True,
                       "x": [4, 8, 16, 0], "y": [0.1, 0.02, 0.005, 1.0]}]}


class Measuring(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        write_executables(self.folder / "build")
        self.said = io.StringIO()
        environment = mock.patch.dict(os.environ, {build.BUILD_DIR_VARIABLE: str(self.folder / "build")})
        for context in (environment, contextlib.redirect_stderr(self.said), contextlib.redirect_stdout(io.StringIO())):
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)

    def program(self, name: str, body: str) -> None:
        path = self.folder / "build" / "tests" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"#!/usr/bin/python3\nimport sys\n{body}\n")
        path.chmod(0o755)

    def validator(self, status: int) -> None:
        self.program("sunder-validate", "out = sys.argv[sys.argv.index('--json') + 1]\n"
                     f"open(out, 'w').write({json.dumps(json.dumps(NUMBERS))})\n"
                     f"open({str(self.folder / 'arguments')!r}, 'w').write(' '.join(sys.argv[1:]))\nsys.exit({status})")

    def test_the_table_and_the_plots_are_written_and_the_status_handed_on(self) -> None:
        for status in (0, 1):
            self.validator(status)
            table, plots = self.folder / "table.json", self.folder / "plots.png"
            self.assertEqual(command.main(["validate", "shells", "--case", "roof", "--json", str(table),
                                           "--plots", str(plots)]), status)
            self.assertEqual(json.loads(table.read_text()), {"cases": NUMBERS["cases"]})
            self.assertTrue(plots.read_bytes().startswith(b"\x89PNG"))
            self.assertIn("--case roof", (self.folder / "arguments").read_text())

    def test_what_cannot_be_validated_or_written_is_refused(self) -> None:
        self.validator(0)
        self.assertEqual(command.main(["validate", "cheese"]), 2)
        self.assertIn("there is shells", self.said.getvalue())
        self.assertEqual(command.main(["validate", "shells", "--json", str(self.folder / "no" / "table.json")]), 2)
        self.assertEqual(command.main(["validate", "shells", "--plots", str(self.folder / "plots.cheese")]), 2)
        self.assertEqual(command.main(["bench", "--json", str(self.folder / "no" / "bench.json")]), 2)

    def test_a_program_that_is_missing_or_dies_is_named(self) -> None:
        self.assertEqual(command.main(["validate", "shells"]), 2)
        self.assertIn("sunder-validate", self.said.getvalue())
        self.program("sunder-bench", "import os, signal\nos.kill(os.getpid(), signal.SIGKILL)")
        self.assertEqual(command.main(["bench"]), 3)
        self.assertIn("sunder-bench", self.said.getvalue())


if __name__ == "__main__":
    unittest.main()
