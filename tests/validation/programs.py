"""Measuring programs of the build: their paths, and how they end."""
from __future__ import annotations

import os
import subprocess
from pathlib import Path

from sunder_tools.errors import BAD_INPUT, INTERRUPTED, PEER_LOST, CommandError, Interrupted, how_it_ended
from sunder_tools.launch.build import build_dir, by_cmake, ensure_built


def program(name: str) -> Path:
    """Returns the path of a program in the build folder tests/, and builds it where needed. Raises CommandError."""
    ensure_built(targets=(name,))
    path = build_dir() / "tests" / name
    if not os.access(path, os.X_OK):
        raise CommandError(f"{path} is not an executable; build it: {by_cmake(build_dir(), [name])}", BAD_INPUT)
    return path


def run_program(command: list[str]) -> int:
    """Runs a program of the build and returns its exit status, INTERRUPTED where the user ends it. Raises CommandError where
    another signal does."""
    try:
        status = subprocess.run(command, check=False).returncode
    except (Interrupted, KeyboardInterrupt):
        return INTERRUPTED
    if status < 0:
        raise CommandError(f"{Path(command[0]).name} {how_it_ended(status)}", PEER_LOST)
    return status


def interrupted_after(ran: int, left: int, what: str = "case") -> str:
    """A line for the end of a table, as 'interrupted: 2 cases ran, 13 are left'."""
    return f"interrupted: {ran} {what}{'' if ran == 1 else 's'} ran, {left} {'is' if left == 1 else 'are'} left"
