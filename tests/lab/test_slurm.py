"""Series as Slurm job arrays, on a cluster of one node that the test brings up."""
from __future__ import annotations

import json
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from . import sweeps
from sunder_lab import executors
from sunder_tools.errors import CommandError
from .slurm_node import SlurmNode, why_not

SPEEDS = [50, 70, 1e9]  # [m/s]; at the last one the run is refused: a row of the same words in both


@unittest.skipIf(why_not(), why_not())
class Arrays(unittest.TestCase):
    local: bytes
    node: SlurmNode

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        here = Path(folder.name)
        sweeps.sweep(str(sweeps.write_file(here / "some.py", SPEEDS)), "--out", str(here / "local"), "--jobs", "2")
        cls.local = (here / "local" / "results.csv").read_bytes()
        cls.node = SlurmNode()
        cls.node.__enter__()
        cls.addClassCleanup(cls.node.__exit__)

    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.here = Path(self._folder.name)
        self.file = sweeps.write_file(self.here / "some.py", SPEEDS)

    def slurm(self, out: Path, *more: str) -> subprocess.Popen[str]:
        return sweeps.start(str(self.file), "--out", str(out), "--executor", "slurm", *more,
                            SLURM_CONF=self.node.environment["SLURM_CONF"])

    def test_the_table_is_that_of_local_processes(self) -> None:
        process = self.slurm(self.here / "slurm")
        out, err = process.communicate(timeout=1800)
        self.assertEqual(process.returncode, 1, err)
        self.assertIn("4 of 6 runs done", out)
        self.assertEqual((self.here / "slurm" / "results.csv").read_bytes(), self.local)
        self.assertFalse((self.here / "slurm" / "slurm.json").exists())

    def test_killed_half_way_it_waits_for_its_array_and_ends_the_same(self) -> None:
        out = self.here / "slurm"
        process = self.slurm(out, "--jobs", "1")
        done = sweeps.kill_half_way(process, out, 2)
        self.assertLess(len(done), 4)
        job = json.loads((out / "slurm.json").read_text())["job"]
        process = self.slurm(out, "--jobs", "1")
        _, err = process.communicate(timeout=1800)
        self.assertEqual(process.returncode, 1, err)
        self.assertIn(f"Slurm job {job} of an earlier start is waited for", err)
        self.assertTrue(set(done.items()) <= set(sweeps.outcomes(out).items()), "a member that was done ran again")
        self.assertEqual((out / "results.csv").read_bytes(), self.local)

    def test_a_task_that_is_cancelled_is_a_failed_member(self) -> None:
        out = self.here / "slurm"
        sweeps.write_file(self.file, [30], end="5e-3")
        process = self.slurm(out, "--jobs", "1")
        end = time.monotonic() + 1800
        while not list(out.glob("members/*/run/shell.log")):
            self.assertTrue(process.poll() is None and time.monotonic() < end)
            time.sleep(0.05)
        job = json.loads((out / "slurm.json").read_text())["job"]
        self.node.command("scancel", "--signal=KILL", "--full", job)
        self.node.command("scancel", job)
        text, err = process.communicate(timeout=1800)
        self.assertEqual(process.returncode, 1, err)
        self.assertIn("0 of 2 runs done", text)
        self.assertIn(f"Slurm's task of job {job} ended without an outcome", text)

    def test_what_sbatch_refuses_is_said(self) -> None:
        process = self.slurm(self.here / "slurm", "--sbatch=--partition=moon")
        _, err = process.communicate(timeout=1800)
        self.assertEqual(process.returncode, 2)
        self.assertIn("invalid partition", err)


class Without(unittest.TestCase):
    def test_no_slurm_is_said(self) -> None:
        with self.assertRaisesRegex(CommandError, "squeue-of-none not found: there is no Slurm here"):
            executors._slurm(["squeue-of-none"])


if __name__ == "__main__":
    unittest.main()
