"""Mutated files for the readers of surfaces: each is read or refused, and none may end the process.

`fuzz_replay` mutates the corpus of a target. It runs in batches of their own seeds, so that a crash costs one batch only and
can be repeated.
"""
from __future__ import annotations

import math
import os
import subprocess
import tempfile
import time
from pathlib import Path

from sunder_tools.errors import BAD_INPUT, CommandError, how_it_ended
from sunder_tools.launch.build import Executables
from sunder_tools.places import REPOSITORY

from .programs import program
from .trials import Missing, Table

CORPUS = REPOSITORY / "tests" / "fuzz" / "corpus"
# Inputs of a target, of a short run and of a million. OpenCASCADE reads CAD files in a process of its own, a hundred times as
# slowly as meshes are read.
SHORT = {"surface": 20_000, "mesh": 20_000, "cad": 200}
MILLION = {"surface": 495_000, "mesh": 495_000, "cad": 10_000}
BATCH = {"surface": 5_000, "mesh": 5_000, "cad": 100}
SLOWEST_S = 1.0  # of an input, as a mean over a batch: one that does not end is a finding as well


def mutated(table: Table, executables: Executables) -> None:
    """Adds rows of some thousand inputs."""
    _run_all(table, SHORT)


def mutated_million(table: Table, executables: Executables) -> None:
    """Adds rows of a million inputs in all."""
    _run_all(table, MILLION)


def _run_all(table: Table, inputs: dict[str, int]) -> None:
    replay = program("fuzz_replay")
    for target, count in inputs.items():
        try:
            run_target(table, replay, target, count)
        except Missing as missing:
            table.skip(f"mutated_{target}", str(missing))


def run_target(table: Table, replay: Path, target: str, count: int) -> None:
    """Adds the row of the inputs that were read or refused, and the row of the batches that ended otherwise. Raises
    Missing where the build has no such target."""
    start, done, findings = time.monotonic(), 0, list[str]()
    batches = math.ceil(count / BATCH[target])
    for seed in range(1, batches + 1):
        size = min(BATCH[target], count - (seed - 1) * BATCH[target])
        said = batch(replay, target, size, seed)
        if said is None:
            done += size
        else:
            findings.append(f"fuzz_replay {CORPUS.relative_to(REPOSITORY)} {target} {size} {seed}: {said}")
    table.add(f"mutated_{target}_inputs", done, count, 0.0, time.monotonic() - start, note=f"seeds 1 to {batches}")
    table.add(f"mutated_{target}_crashes", len(findings), 0.0, 0.0, 0.0, note="; ".join(findings[:3]))


def batch(replay: Path, target: str, size: int, seed: int) -> str | None:
    """Runs a batch. Returns how it ended where it ended badly. Raises Missing, and CommandError where it ran other than
    it was asked to."""
    memory = Path("/dev/shm")
    # files of some hundred bytes, by the million: they must not wear out a disk
    with tempfile.TemporaryDirectory(dir=memory if os.access(memory, os.W_OK) else None) as temporary:
        try:
            ended = subprocess.run([str(replay), str(CORPUS), target, str(size), str(seed)], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True, errors="replace", check=False,
                                   timeout=60.0 + SLOWEST_S * size, env={**os.environ, "TMPDIR": temporary})
        except subprocess.TimeoutExpired as expired:
            return f"did not end within {expired.timeout:g} s"
    if ended.returncode == BAD_INPUT:
        raise Missing(ended.stderr.strip()[-300:])
    if ended.returncode != 0:
        return f"{how_it_ended(ended.returncode)}: {ended.stderr.strip()[-300:]}"
    if f"{target}: {size} mutations" not in ended.stdout.splitlines():
        raise CommandError(f"fuzz_replay did not say that it ran {size} mutations of {target}: {ended.stdout[-300:]}")
    return None
