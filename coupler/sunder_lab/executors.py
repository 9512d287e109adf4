"""Executors of a series' members: processes of this machine, or a Slurm job array."""
from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Protocol

from sunder_tools.errors import CommandError
from sunder_tools.launch.build import build_dir
from sunder_tools.launch.logged import tail
from sunder_tools.places import BUILD_DIR_VARIABLE
from sunder_tools.words import quoted

from .member import DIE_WITH_PARENT, LOG_FILE, OUTCOME_FILE, is_done, outcome, read_json, write_atomically

COUPLER = Path(__file__).resolve().parents[1]
PYTHON = "/usr/bin/python3"  # this one has Debian's packages
LOOK_S = 0.05  # between two checks of local processes
SLURM_LOOK_S = 1.0  # between two checks of the queue, which others ask too
PATIENCE_S = 5.0  # wait for outcomes of an ended array, on a file system that shows them late
MOST_TASKS = 1000  # of one array: Slurm's MaxArraySize is 1001 by default
JOB_FILE = "slurm.json"

Ended = Callable[[Path], None]


class Executor(Protocol):
    """Runs members."""

    def run(self, folders: list[Path], ended: Ended) -> None:
        """Runs prepared members. Calls `ended` with each when it ends, in any order. What it raises ends the others."""


def default_jobs(threads: int) -> int:
    """Returns the number of jobs with `threads` threads each that the processors can run at once."""
    return max(1, len(os.sched_getaffinity(0)) // max(1, threads))


def _environment() -> dict[str, str]:
    """Makes members find this checkout's package and its finished build; they neither install nor build."""
    return {**os.environ, BUILD_DIR_VARIABLE: str(build_dir()), "PYTHONPATH": str(COUPLER),
            "PYTHONPYCACHEPREFIX": str(COUPLER.parent / "build" / "pycache")}


@dataclass
class Local:
    """Runs at most `jobs` processes at a time. They end with this process, also when it is killed."""
    jobs: int = 1

    def run(self, folders: list[Path], ended: Ended) -> None:
        waiting = list(folders)
        running: dict[subprocess.Popen[bytes], Path] = {}
        try:
            while waiting or running:
                while waiting and len(running) < self.jobs:
                    folder = waiting.pop(0)
                    running[self._start(folder)] = folder
                time.sleep(LOOK_S)
                for process in [p for p in running if p.poll() is not None]:
                    folder = running.pop(process)
                    _without_word(folder, f"the process ended with status {process.returncode}")
                    ended(folder)
        except BaseException:  # Ctrl-C, or `ended` refuses to go on
            for process in running:
                process.send_signal(signal.SIGINT)  # the run ends after its window
            raise
        finally:
            for process in running:
                try:
                    process.wait(timeout=10.0)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()

    @staticmethod
    def _start(folder: Path) -> "subprocess.Popen[bytes]":
        with (folder / LOG_FILE).open("wb") as log:
            # A session of its own: Ctrl-C reaches the member through this process, once.
            return subprocess.Popen([PYTHON, "-m", "sunder_lab.member", DIE_WITH_PARENT, str(os.getpid()), str(folder)],
                                    cwd=COUPLER, env=_environment(), stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                    start_new_session=True)


@dataclass
class Slurm:
    """Runs a job array in the folder's file system, which all nodes must share. `jobs` is the number of tasks at a
    time, 0: Slurm's default.

    `options` go to sbatch (`--partition=long`); so do SBATCH_... variables of the environment. A series that was killed
    leaves its array to Slurm, and waits for it when it goes on.
    """
    folder: Path
    threads: int = 1
    jobs: int = 0
    options: list[str] = field(default_factory=list)

    def run(self, folders: list[Path], ended: Ended) -> None:
        note = self.folder / JOB_FILE
        left = read_json(note).get("job")
        if left:
            print(f"sunder: Slurm job {left} of an earlier start is waited for", file=sys.stderr, flush=True)
            self._wait(str(left), [], ended)
        remaining = [folder for folder in folders if not is_done(folder)]
        for folder in folders:
            if folder not in remaining:
                ended(folder)
        for first in range(0, len(remaining), MOST_TASKS):
            part = remaining[first:first + MOST_TASKS]
            for folder in part:
                (folder / OUTCOME_FILE).unlink(missing_ok=True)
            job = self._submit(part)
            write_atomically(note, {"job": job})
            try:
                self._wait(job, part, ended)
            except BaseException:  # Ctrl-C, or `ended` refuses to go on
                _slurm(["scancel", job])
                note.unlink(missing_ok=True)
                raise
        note.unlink(missing_ok=True)

    def _submit(self, folders: list[Path]) -> str:
        """Submits the array and returns its number."""
        listed, script = self.folder / "slurm.list", self.folder / "slurm.sh"
        listed.write_text("".join(f"{folder}\n" for folder in folders))
        environment = _environment()
        exports = "\n".join(f"export {name}={quoted(environment[name])}"
                            for name in (BUILD_DIR_VARIABLE, "PYTHONPATH", "PYTHONPYCACHEPREFIX"))
        script.write_text(
            f'#!/bin/sh\n{exports}\nfolder=$(sed -n "$((SLURM_ARRAY_TASK_ID + 1))p" {quoted(str(listed))})\n'
            f'cd {quoted(str(COUPLER))} && exec {PYTHON} -m sunder_lab.member "$folder" >"$folder/{LOG_FILE}" 2>&1\n')
        limit = f"%{self.jobs}" if self.jobs else ""
        words = _slurm(["sbatch", "--parsable", f"--array=0-{len(folders) - 1}{limit}", f"--cpus-per-task={self.threads}",
                        "--job-name=sunder", f"--chdir={self.folder}", "--output=slurm.out", "--open-mode=append",
                        *self.options, str(script)])
        return words.strip().split(";")[0]

    def _wait(self, job: str, folders: list[Path], ended: Ended) -> None:
        """Waits until the queue has no task of `job` left and each member has its outcome."""
        open_ = list(folders)

        def look() -> None:
            for folder in [f for f in open_ if outcome(f)]:
                open_.remove(folder)
                ended(folder)

        while True:
            queued = _queued(job)
            look()
            if not queued:
                break
            time.sleep(SLURM_LOOK_S)
        end = time.monotonic() + PATIENCE_S
        while open_ and time.monotonic() < end:
            time.sleep(LOOK_S)
            look()
        for folder in open_:
            _without_word(folder, f"Slurm's task of job {job} ended without an outcome; see slurm.out")
            ended(folder)


def _queued(job: str) -> bool:
    """Tests whether Slurm has waiting or running tasks of this job. A job that Slurm has forgotten has none."""
    done = subprocess.run(["squeue", "--noheader", f"--jobs={job}", "--states=all", "--format=%T"], text=True,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    if done.returncode != 0:
        if re.search(r"Invalid job id", done.stderr):
            return False
        # The controller may be restarting; its silence does not mean the end of a job.
        print(f"sunder: squeue: {done.stderr.strip()}", file=sys.stderr, flush=True)
        return True
    over = {"COMPLETED", "CANCELLED", "FAILED", "TIMEOUT", "NODE_FAIL", "PREEMPTED", "BOOT_FAIL", "DEADLINE",
            "OUT_OF_MEMORY"}
    return any(state not in over for state in done.stdout.split())


def _slurm(command: list[str]) -> str:
    """Returns the output of a Slurm command. Raises CommandError with its message."""
    try:
        done = subprocess.run(command, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, check=False)
    except FileNotFoundError:
        raise CommandError(f"{command[0]} not found: there is no Slurm here; leave --executor slurm out") from None
    if done.returncode != 0:
        raise CommandError(f"{command[0]}: {done.stderr.strip() or f'ended with status {done.returncode}'}")
    return done.stdout


def _without_word(folder: Path, why: str) -> None:
    """Writes an outcome for a member whose process ended without one: killed, out of memory, or unable to start."""
    if outcome(folder):
        return
    log = folder / LOG_FILE
    words = tail(log, 3).strip() if log.is_file() else ""
    write_atomically(folder / "outcome.json", {"status": "failed", "exit": None, "error": f"{words}\n{why}".strip(),
                                               "wall_s": None, "host": "", "program": ""})
