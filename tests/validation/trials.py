"""Tools for validation by whole runs: the table of rows, and runs of the repository's scenes."""
from __future__ import annotations

import csv
import math
import tempfile
import time
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Iterator

from sunder_tools.errors import CommandError
from sunder_tools.launch import engines
from sunder_tools.launch.build import Executables
from sunder_tools.launch.run import launch_once
from sunder_tools.places import REPOSITORY
from sunder_tools.report.run_json import read_run

from .known import SKIPPED

SCENES = REPOSITORY / "scenes"
MOST_INJECTED = 0.01  # share of the fracture energy that insertions of edges may add
MOST_MISSING = 0.01  # share of the largest energy that no book has; a run warns at twice that
ROUND_OFF = 1e-12  # of impulses and of what pieces carry: sums of 10^4 terms


class Missing(CommandError):
    """What a case needs is not on this machine: the case is skipped."""


@dataclass
class Table:
    """Collects rows as `sunder-validate` prints and writes them."""
    rows: list[dict[str, object]] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    curves: list[dict[str, object]] = field(default_factory=list)
    headed: bool = False  # the head of the table has been printed
    pictures: Path | None = None  # an existing folder for them
    ran: dict[str, int] = field(default_factory=dict)  # number of rows of each case that has run

    def add(self, name: str, computed: float, reference: float, tolerance: float, seconds: float, note: str = "") -> None:
        """Adds a row and prints it at once. The error is relative, or absolute where the reference is zero. `note` is said
        beside it in a report."""
        computed, reference, tolerance = float(computed), float(reference), float(tolerance)  # JSON knows no numpy
        error = abs(computed / reference - 1.0) if reference != 0.0 else abs(computed)
        good = error <= tolerance  # NaN fails
        self.rows.append({"name": name, "computed": computed, "reference": reference, "error": error,
                          "tolerance": tolerance, "pass": good, "seconds": round(seconds, 3)} | ({"note": note} if note else {}))
        print(f"{name:<34} {computed:>13.6g} {reference:>13.6g} {error:>10.2e} {tolerance:>9.1e} {seconds:>8.1f}  "
              f"{'ok' if good else 'FAILED'}" + (f"\n  {note}" if note else ""), flush=True)

    def skip(self, name: str, why: str) -> None:
        """Adds a row without numbers, which neither passes nor fails, and prints it at once."""
        self.rows.append({"name": name, "computed": math.nan, "reference": math.nan, "error": math.nan, "tolerance": math.nan,
                          "pass": False, "verdict": SKIPPED, "seconds": 0.0, "note": why})
        print(f"{name:<34} {SKIPPED}\n  {why}", flush=True)


def run_scene(executables: Executables, scene: str, settings: list[str]) -> tuple[dict, list[list[str]], float]:
    """Runs a scene of the repository. Returns run.json, the rows of probes.csv and the seconds of the run."""
    with kept_run(executables, scene, settings) as (folder, seconds):
        probes = folder / "probes.csv"
        rows = list(csv.reader(probes.open())) if probes.is_file() else []
        return read_run(folder), rows, seconds


def answering(table: Table, case: str, executables: Executables) -> Iterator[tuple[str, list[str]]]:
    """Returns the engines that come with the project, with their capabilities. An engine without its environment is
    left out with the reason. An installed engine that does not answer becomes a failed row."""
    for name in engines.names(executables):
        try:
            rigid = engines.resolve(name, executables)
        except CommandError as error:
            table.lines.append(f"{case} {name}: left out: {error}")
            continue
        try:
            words = engines.hello(rigid, executables)["capabilities"]
        except CommandError as error:
            table.add(f"{case}_{name}_answers", math.nan, 0.0, 0.0, 0.0)
            table.lines.append(f"{case} {name}: {error}")
            continue
        assert isinstance(words, list)
        yield name, words


@contextmanager
def kept_run(executables: Executables, scene: str, settings: list[str]) -> Iterator[tuple[Path, float]]:
    """Runs a scene of the repository. Yields its run folder, which exists within the context, and the seconds of the
    run."""
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="validate-sunder-") as folder:
        launch_once(executables, SCENES / scene, Path(folder), settings)
        yield Path(folder), time.monotonic() - start


def injected(run: dict[str, Any]) -> float:
    """Returns the energy that insertions of edges have added over the fracture energy; NaN without cracks."""
    energy = run["energy"]
    taken = energy["dissipated_fracture"]
    return energy["crack_injected"] / taken if taken > 0.0 else math.nan


def add_books(table: Table, name: str, run: dict[str, Any], seconds: float = 0.0) -> None:
    """Adds rows NAME_injected and NAME_energy, the missing share of the largest energy."""
    table.add(f"{name}_injected", injected(run), 0.0, MOST_INJECTED, seconds)
    table.add(f"{name}_energy", run["energy"]["residual_relative"], 0.0, MOST_MISSING, 0.0)


def add_momentum(table: Table, name: str, run: dict[str, Any]) -> None:
    """Adds rows NAME_impulses, of windows, and NAME_handoffs, of births: errors of momentum and angular momentum."""
    ledger, handoff = run["ledger"], run["handoff"]
    table.add(f"{name}_impulses", max(ledger["linear_max"], ledger["angular_max"]), 0.0, ROUND_OFF, 0.0)
    births = max(handoff[f"{what}_error_max"] for what in ("mass", "momentum", "angular_momentum"))
    table.add(f"{name}_handoffs", births, 0.0, ROUND_OFF, 0.0)
