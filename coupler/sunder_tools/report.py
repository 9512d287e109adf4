"""run.json: marking a run that could not end by itself, and the summary for people."""
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


def mark(folder: Path, status: str, kind: str, message: str) -> None:
    """Sets status and error of run.json, keeps all else, replaces the file atomically.

    Raises OSError where the folder cannot be written.
    """
    run = read_run(folder) or {"schema": 1}
    run["status"] = status
    if kind:
        run["error"] = {"kind": kind, "message": message}
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


def _number(value: Any, form: str) -> str:
    """A number in the given format, '-' if it is absent."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return "-"
    return format(value, form)


def summary(folder: Path, sheet: Path | None) -> str:
    """Some lines for the end of a run, all of it from run.json."""
    from . import models  # that module needs this one
    run = read_run(folder)

    def get(section: str, key: str) -> Any:
        part = run.get(section)
        return part.get(key) if isinstance(part, dict) else None

    status = str(run.get("status", "unknown"))
    message = get("error", "message")
    lines = [f"status           {status}" + (f": {message}" if message else "")]
    lines.append(f"simulated        {_number(get('time', 'simulated_s'), '.6g')} s in "
                 f"{_number(get('time', 'wall_s'), '.1f')} s")
    lines.append(f"fragments        {_number(get('counts', 'fragments'), 'd')}, handed to the engine "
                 f"{_number(get('counts', 'handed_off'), 'd')}")
    if isinstance(get("cracks", "taken_relative"), (int, float)):
        lines.append(f"cracks           {_number(get('cracks', 'length_m'), '.3g')} m, took "
                     f"{_number(get('cracks', 'taken_relative'), '.2f')} of G_f times their area")
    lines.append(f"ledger           linear {_number(get('ledger', 'linear_max'), '.1e')}, angular "
                 f"{_number(get('ledger', 'angular_max'), '.1e')} (relative to the impulses exchanged)")
    lines.append(f"energy residual  {_number(get('energy', 'residual_relative'), '.2%')}")
    active = models.in_words(run)
    if active:
        lines.append(f"active models    {active}")
    warnings = run.get("warnings")
    for warning in warnings if isinstance(warnings, list) else []:
        lines.append(f"warning          {warning}")
    lines.append(f"run folder       {folder}")
    if sheet is not None:
        lines.append(f"pictures         {sheet}")
    if (folder / "frames.pvd").exists():
        lines.append(f"frames           {folder / 'frames.pvd'} (ParaView; or: sunder view {folder})")
    return "\n".join(lines)
