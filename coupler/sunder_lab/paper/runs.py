"""Runs the cases of the paper's figures, each once: what is done with the same scene and size stays."""
from __future__ import annotations

import fcntl
import json
import os
import re
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sunder_tools.errors import DONE, INTERRUPTED, CommandError
from sunder_tools.launch.run import Job, run_scene
from sunder_tools.replacing import replacing
from sunder_tools.report.run_json import read_run

from ..scene import SCENES
from .catalogue import CASES, Case

RECORD = "paper.json"
LOOK_S = 1.0               # between two looks at a run's progress
TOLD_S = (2.0, 30.0)       # between two lines of progress: on a terminal, elsewhere
CRACKED = 3.0              # a run that cracks takes up to so many times what 'check' estimates for the uncracked shell
DONE_AT_ONCE_S = 1.0       # what reading, writing and starting take


@dataclass
class Record:
    """What paper.json keeps: of each case the identity of its scene and its seconds; of each figure what was drawn."""
    folder: Path
    cases: dict[str, dict[str, Any]] = field(default_factory=dict)
    figures: dict[str, dict[str, Any]] = field(default_factory=dict)

    @staticmethod
    def read(folder: Path) -> "Record":
        """The record of a folder; an empty one where there is none or it cannot be read."""
        try:
            kept = json.loads((folder / RECORD).read_text(encoding="utf-8"))
            return Record(folder, dict(kept["cases"]), dict(kept["figures"]))
        except (OSError, ValueError, KeyError, TypeError):
            return Record(folder)

    def write(self) -> None:
        """Replaces paper.json. Raises CommandError where that cannot be written."""
        try:
            with replacing(self.folder / RECORD) as part:
                part.write_text(json.dumps({"schema": 1, "cases": self.cases, "figures": self.figures}, indent=1) + "\n",
                                encoding="utf-8")
        except OSError as error:
            raise CommandError(f"cannot write {self.folder / RECORD}: {error.strerror}; free some space there, or name "
                               "another --out") from None


class Runs:
    """The runs of one size below OUT/SIZE."""

    def __init__(self, out: Path, size: str, threads: str | None, quiet: bool) -> None:
        self.folder, self.size = out / size, size
        self._threads, self._quiet = threads, quiet
        self.record = Record.read(self.folder)
        self._expected: dict[str, float] = {}  # seconds of the runs that are still to be made
        self._number = 0                       # of the present run
        self._lock = -1                        # descriptor of the folder, which this process holds

    def open(self) -> None:
        """Makes the folder and holds it until close(). Raises CommandError where it cannot be made or written to, or
        another process holds it."""
        probe = self.folder / f".{RECORD}.probe"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            probe.write_text("")
            probe.unlink()
        except OSError as error:
            raise CommandError(f"--out {self.folder.parent}: cannot be written: {error.strerror}; name a folder that you may "
                               "write to") from None
        self._lock = os.open(self.folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            raise CommandError(f"--out {self.folder.parent}: another 'paper' is at work on the {self.size} size there; wait "
                               "for it, or name another folder") from None
        self.record = Record.read(self.folder)  # it may have been written since

    def close(self) -> None:
        """Releases the folder."""
        if self._lock >= 0:
            os.close(self._lock)
        self._lock = -1

    def place(self, name: str) -> Path:
        """The run folder of a case."""
        return self.folder / "runs" / name

    def identity(self, name: str) -> str:
        """SHA-256 of a case's scene in this size and of the files that it names. Raises CommandError."""
        return CASES[name].made(self.size).identity()

    def done(self, name: str) -> bool:
        """Whether the case was run to its end with the same scene. One that failed with it is run again."""
        kept = self.record.cases.get(name, {})
        return kept.get("identity") == self.identity(name) and read_run(self.place(name)).get("status") == "done"

    def failure(self, name: str) -> str:
        """Why the case's last run failed, '' where it did not."""
        return str(self.record.cases.get(name, {}).get("failed") or "")

    def plan(self, names: list[str]) -> None:
        """Says what is to be run in all, for numbers and time left in the progress. Raises CommandError."""
        wanted = [name for name in dict.fromkeys(names) if not self.done(name)]
        self._expected = {name: self._expected_s(CASES[name]) for name in wanted}
        self._number = 0

    def run(self, names: tuple[str, ...]) -> bool:
        """Runs those of the cases that are not done; returns False where the user stopped them. A run that fails is kept in
        the record. Raises CommandError where nothing can be written."""
        for name in names:
            if self.done(name):
                self._expected.pop(name, None)
                continue
            self._number += 1
            in_all = self._number + len(self._expected) - (name in self._expected)
            expected_s = self._expected.pop(name, 0.0)
            told = _Progress(f"{name}, run {self._number} of {in_all}", self.place(name), CASES[name].made(self.size), expected_s,
                             sum(self._expected.values()), self._quiet)
            identity = self.identity(name)  # before the run: its scene may be edited meanwhile
            with told:
                start = time.monotonic()
                status, failure = self._one(name)
                wall_s = time.monotonic() - start
            if status == INTERRUPTED:
                return False
            if failure:
                print(f"sunder: {name} failed: {failure}", file=sys.stderr, flush=True)
            self.record.cases[name] = {"identity": identity, "wall_s": wall_s, "failed": failure}
            self.record.write()
        return True

    def _one(self, name: str) -> tuple[int, str]:
        """Exit status of a run, and why it failed."""
        job = Job(SCENES / f"{CASES[name].scene}.textproto", settings=tuple(CASES[name].all_settings(self.size)),
                  threads=self._threads)
        try:
            status = run_scene(job, self.place(name), quiet=True)
        except CommandError as error:
            return error.status, str(error)
        if status == DONE:
            return status, ""
        told = (read_run(self.place(name)).get("error") or {}).get("message")
        return status, str(told or f"ended with status {status}")

    def _expected_s(self, case: Case) -> float:
        """Seconds that a run takes: those of the last one, else what 'check' estimates, cracks counted. 0: not known."""
        kept = self.record.cases.get(case.name, {})
        if kept.get("wall_s") and not kept.get("failed"):
            return float(kept["wall_s"])
        try:
            found = re.search(r"^time\s+(?:at most )?([\d.e+-]+) min", case.made(self.size).check(), re.MULTILINE)
        except CommandError:
            return 0.0  # the run will say why
        return DONE_AT_ONCE_S + CRACKED * 60.0 * float(found[1]) if found else 0.0


class _Progress:
    """Context: tells on stderr how far a run is, and how long all of them have to go."""

    def __init__(self, name: str, folder: Path, scene: Any, expected_s: float, later_s: float, quiet: bool) -> None:
        self._name, self._folder, self._later_s, self._expected_s = name, folder, later_s, expected_s
        self._end_s, self._quiet = float(scene.message.end_time_s) or 1.0, quiet
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._start = time.monotonic()

    def __enter__(self) -> None:
        if not self._quiet:
            self._tell(0.0)
            self._thread.start()

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()
        if not self._quiet:
            end = "\n" if sys.stderr.isatty() else ""
            print(f"{end}sunder: {self._name}: {time.monotonic() - self._start:.0f} s", file=sys.stderr, flush=True)

    def _watch(self) -> None:
        told = time.monotonic()
        while not self._stop.wait(LOOK_S):
            if time.monotonic() - told >= TOLD_S[0 if sys.stderr.isatty() else 1]:
                told = time.monotonic()
                simulated = (read_run(self._folder).get("time") or {}).get("simulated_s") or 0.0
                self._tell(min(float(simulated) / self._end_s, 1.0))

    def _tell(self, share: float) -> None:
        elapsed = time.monotonic() - self._start
        left_s = self._later_s + left(elapsed, share, self._expected_s)
        begin, end = ("\r\033[K", "") if sys.stderr.isatty() else ("", "\n")
        print(f"{begin}sunder: {self._name}: {100.0 * share:.0f} %, {about(left_s)} left of all", end=end, file=sys.stderr,
              flush=True)


def left(elapsed_s: float, share: float, expected_s: float) -> float:
    """Seconds that a run has still to go: by its own pace, before a tenth of it by what was expected, at least a tenth
    of what it has had."""
    if share >= 0.1:
        return elapsed_s * (1.0 - share) / share
    return max(expected_s - elapsed_s, 0.1 * elapsed_s)


def about(seconds: float) -> str:
    """'about 40 s', 'about 5 min', 'about 2.5 h'."""
    if seconds < 90.0:
        return f"about {max(round(seconds), 1)} s"
    return f"about {seconds / 60.0:.0f} min" if seconds < 5400.0 else f"about {seconds / 3600.0:.1f} h"
