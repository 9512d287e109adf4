"""Programs of the build that measure: where they are, and how they end."""
from __future__ import annotations

import os
import subprocess
from pathlib import Path

from sunder_tools.errors import BAD_INPUT, PEER_LOST, CommandError, how_it_ended
from sunder_tools.launch.build import build_dir, ensure_built


def program(name: str) -> Path:
    """A program of the build folder tests/; builds it as far as needed. Raises CommandError."""
    ensure_built(targets=(name,))
    path = build_dir() / "tests" / name
    if not os.access(path, os.X_OK):
        raise CommandError(f"{path} is not an executable; build the target {name}", BAD_INPUT)
    return path


def run_program(command: list[str]) -> int:
    """Exit status of a program of the build. Raises CommandError where it dies."""
    status = subprocess.run(command, check=False).returncode
    if status < 0:
        raise CommandError(f"{Path(command[0]).name} {how_it_ended(status)}", PEER_LOST)
    return status
