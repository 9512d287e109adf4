"""Asking an engine who it is: one that ends is not waited for, one that starts slowly is."""
from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any, cast
from unittest import mock

TOP = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ["SUNDER_BUILD_DIR"])
sys.path.insert(0, str(TOP / "coupler"))
from sunder_tools.errors import CommandError  # noqa: E402
from sunder_tools.launch import engines  # noqa: E402
from sunder_tools.launch.build import ensure_built  # noqa: E402


class Hello(unittest.TestCase):
    def engine(self, text: str) -> engines.Rigid:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        program = Path(folder.name) / "mine"
        program.write_text(f"#!/bin/sh\n{text}\n")
        program.chmod(0o755)
        return engines.resolve(str(program), ensure_built())

    def test_an_engine_that_ends_is_not_waited_for(self) -> None:
        """Who asks is killed. By itself it would wait far longer for a session that nobody binds, and then end."""
        started: list[subprocess.Popen[str]] = []
        real = subprocess.Popen

        def start(*arguments: Any, **options: Any) -> subprocess.Popen[str]:
            started.append(real(*arguments, **options))
            return started[-1]

        for text, says in (("echo 'the licence has expired' >&2; exit 7", "the licence has expired"),
                           ("exit 7", "it ended with status 7 without an answer"),
                           ("kill -KILL $$", "it was killed by SIGKILL without an answer")):
            engine, built = self.engine(text), ensure_built()
            started.clear()
            with mock.patch.object(engines.subprocess, "Popen", start), self.assertRaises(CommandError) as refused:
                engines.hello(engine, built)
            self.assertIn(says, str(refused.exception))
            _, asking = started
            self.assertIn("hello", cast("list[str]", asking.args))
            self.assertEqual(asking.returncode, -signal.SIGKILL)

    def test_an_engine_that_says_much_and_starts_slowly_is_waited_for(self) -> None:
        slow = f"head -c 300000 /dev/zero >&2; sleep 3; exec {BUILD}/rigid/sunder-rigid \"$@\" --engine freeflight"
        self.assertEqual(engines.hello(self.engine(slow), ensure_built())["name"], "freeflight")

    def test_what_an_engine_says_that_runs_on_is_not_the_reason(self) -> None:
        """It starts, says something, and never binds. Who asks has its reason, and comes first."""
        real = subprocess.Popen

        def start(command: list[str], **options: Any) -> subprocess.Popen[str]:
            asks = "hello" in command
            return real(["/bin/sh", "-c", "echo 'nothing answers' >&2; exit 3"] if asks else command, **options)

        engine, built = self.engine("echo 'warming up' >&2; exec sleep 600"), ensure_built()
        with mock.patch.object(engines.subprocess, "Popen", start), self.assertRaises(CommandError) as refused:
            engines.hello(engine, built)
        self.assertEqual(str(refused.exception), f"{engine.label}: nothing answers\nit said: warming up")


if __name__ == "__main__":
    unittest.main()
