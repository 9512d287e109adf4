"""`sunder bench --against DIR`: two builds measured in turns, and the ratio of each number.

A round runs the benchmarks of both builds, one after the other; the order changes from round to round, so that neither
always follows a rest. The ratio of a key is that of its least values over the rounds for times, and of its largest ones for
rates. The spread is the least and the largest ratio within one round: what the machine did beside it.
"""
from __future__ import annotations

import json
import math
import os
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

from sunder_tools.errors import BAD_INPUT, CHECK_FAILED, DONE, INTERRUPTED, CommandError
from sunder_tools.words import command_line

from ..validation.programs import run_program

PROGRAM = Path("tests") / "sunder-bench"
ROUNDS = 5
KERNELS = re.compile(r"force_ns_|step_ms_")  # keys of times that a change of the code may not raise
SLOWER = 0.02  # of a kernel's time: beyond it, the kernel is slower
RATES = re.compile(r"_gflops$|_per_s$|speedup|^share_of_")  # keys of which more is better

Numbers = dict[str, float]


@dataclass(frozen=True)
class Compared:
    """One key of both builds: this one's value over the other's."""
    name: str
    here: float
    there: float
    ratio: float
    spread: tuple[float, float]  # least and largest ratio of one round

    @property
    def judged(self) -> bool:
        """Whether it is a kernel's time."""
        return KERNELS.match(self.name) is not None

    @property
    def good(self) -> bool:
        """Whether it is no kernel that is slower. NaN fails."""
        return not self.judged or self.ratio <= 1.0 + SLOWER

    @property
    def line(self) -> str:
        """A line of the table."""
        verdict = "" if not self.judged else "ok" if self.good else "SLOWER"
        spread = f"{self.spread[0]:.3f}–{self.spread[1]:.3f}"
        return f"{self.name:<54} {self.here:>11.6g} {self.there:>11.6g} {self.ratio:>8.3f} {spread:>13}  {verdict}".rstrip()

    @property
    def row(self) -> dict[str, object]:
        """The same as a row of a validation."""
        return {"name": self.name, "computed": self.ratio, "reference": 1.0, "error": max(self.ratio - 1.0, 0.0),
                "tolerance": SLOWER if self.judged else None, "pass": self.good, "here": self.here, "there": self.there,
                "spread": list(self.spread)}


def other_program(folder: Path) -> Path:
    """The benchmarks of another build folder. Raises CommandError."""
    path = folder.absolute() / PROGRAM
    if not os.access(path, os.X_OK):
        raise CommandError(f"--against {folder}: has no program {PROGRAM}; name a build folder, such as build/release of another "
                           f"checkout, and build it there: {command_line(['cmake', '--build', folder, '--target', PROGRAM.name])}",
                           BAD_INPUT)
    return path


def measure(here: Path, there: Path, pattern: str | None, rounds: int) -> tuple[list[tuple[Numbers, Numbers]], int]:
    """Runs both programs in turns. Returns the numbers of both for each whole round, and the exit status: that of a program
    that fails or is interrupted."""
    found: list[tuple[Numbers, Numbers]] = []
    for number in range(rounds):
        print(f"sunder: round {number + 1} of {rounds}", flush=True)
        both: dict[str, Numbers] = {}
        sides = [("here", here), ("there", there)]
        for side, path in sides if number % 2 == 0 else sides[::-1]:
            with tempfile.TemporaryDirectory() as folder:
                kept = Path(folder) / "bench.json"
                status = run_program([str(path), *(["--filter", pattern] if pattern else []), "--json", str(kept)])
                if status != DONE:
                    return found, status
                both[side] = {key: math.nan if value is None else float(value) for key, value in json.loads(kept.read_text()).items()}
        found.append((both["here"], both["there"]))
    return found, DONE


def compared(rounds: list[tuple[Numbers, Numbers]]) -> list[Compared]:
    """Returns the keys that both builds measure in every round, by name."""
    out = []
    for name in sorted(set.intersection(*(set(numbers) for both in rounds for numbers in both))) if rounds else ():
        best = max if RATES.search(name) else min
        here, there = best(one[name] for one, _ in rounds), best(other[name] for _, other in rounds)
        ratios = [_ratio(one[name], other[name]) for one, other in rounds]
        out.append(Compared(name, here, there, _ratio(here, there), (min(ratios), max(ratios))))
    return out


def _ratio(here: float, there: float) -> float:
    return 1.0 if here == there else here / there if there != 0.0 else math.inf


def bench_against(here: Path, folder: Path, pattern: str | None, rounds: int) -> tuple[list[Compared], int]:
    """Measures and prints the table. Returns it, and the exit status: 1 where a kernel is slower. Raises CommandError."""
    found, status = measure(here, other_program(folder), pattern, rounds)
    table = compared(found)
    print(f"{'key':<54} {'here':>11} {'there':>11} {'ratio':>8} {'spread':>13}")
    print("\n".join(one.line for one in table), flush=True)
    for side, names in zip(("here", "there"), _alone(found)):
        if names:
            print(f"only {side}: {', '.join(names)}")
    if status == INTERRUPTED:
        print(f"interrupted: {len(found)} of {rounds} rounds", flush=True)
    slower = [one.name for one in table if not one.good]
    judged = sum(one.judged for one in table)
    if status == DONE:
        print(f"slower than {100.0 * SLOWER:.0f} %: {', '.join(slower) if slower else 'no kernel'}, of {judged}", flush=True)
        if slower or not judged and not pattern:
            status = CHECK_FAILED
    return table, status


def _alone(rounds: list[tuple[Numbers, Numbers]]) -> tuple[list[str], list[str]]:
    """Keys that only this build has, and those that only the other one has."""
    here, there = ({key for both in rounds for key in both[side]} for side in (0, 1))
    return sorted(here - there), sorted(there - here)
