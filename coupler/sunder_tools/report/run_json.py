"""run.json: reading it, and marking a run that could not end by itself."""
from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

ENDED = ("done", "failed", "interrupted")


def read_run(folder: Path) -> dict[str, Any]:
    """run.json as a dictionary, {} if it is missing or unreadable."""
    try:
        run = json.loads((folder / "run.json").read_text())
    except (OSError, ValueError):
        return {}
    return run if isinstance(run, dict) else {}


def load_steps(run: dict[str, Any]) -> int:
    """The number of load steps that were tried, 0 where things move: a time is then the number of a step."""
    told = run.get("equilibrium")
    steps = [e.get("step") for e in told if isinstance(e, dict)] if isinstance(told, list) else []
    return max((s for s in steps if isinstance(s, int)), default=0)


def mark(folder: Path, status: str, kind: str, message: str) -> None:
    """Sets status and error of run.json, keeps all else, replaces the file atomically.

    Raises OSError where the folder cannot be written.
    """
    run = read_run(folder) or {"schema": 2}
    run["status"] = status
    if kind:
        run["error"] = {"kind": kind, "message": message}
    _replace(folder, run)


def extend_message(folder: Path, more: str) -> None:
    """Adds a sentence to the message of the error, where there is one. Raises OSError as `mark` does."""
    run = read_run(folder)
    if run.get("error", {}).get("message"):
        run["error"]["message"] += f"; {more}"
        _replace(folder, run)


def _replace(folder: Path, run: dict[str, Any]) -> None:
    target = folder / "run.json"
    temporary = folder / f".run.json.{os.getpid()}"
    try:
        with temporary.open("w") as sink:
            json.dump(run, sink, indent=2)
            sink.write("\n")
            sink.flush()
            os.fsync(sink.fileno())
        os.replace(temporary, target)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
