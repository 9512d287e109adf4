"""The summary that `sunder run` prints at its end."""
from __future__ import annotations

from pathlib import Path
from typing import Any

from ..words import own_command
from .models import in_words
from .run_json import load_steps, read_run


def _number(value: Any, form: str) -> str:
    """A number in the given format, '-' if it is absent."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return "-"
    return format(value, form)


def summary(folder: Path, sheet: Path | None) -> str:
    """Some lines for the end of a run, all of it from run.json."""
    run = read_run(folder)

    def get(section: str, key: str) -> Any:
        part = run.get(section)
        return part.get(key) if isinstance(part, dict) else None

    status = str(run.get("status", "unknown"))
    message = get("error", "message")
    lines = [f"status           {status}" + (f": {message}" if message else "")]
    steps = load_steps(run)
    if steps:
        lines.append(f"load steps       {steps} in {_number(get('time', 'wall_s'), '.1f')} s")
    else:
        lines.append(f"simulated        {_number(get('time', 'simulated_s'), '.6g')} s in "
                     f"{_number(get('time', 'wall_s'), '.1f')} s")
    lines.append(f"fragments        {_number(get('counts', 'fragments'), 'd')}, handed to the engine "
                 f"{_number(get('counts', 'handed_off'), 'd')}{_more_parts(run)}")
    if isinstance(get("cracks", "taken_relative"), (int, float)):
        lines.append(f"cracks           {_number(get('cracks', 'length_m'), '.3g')} m, took "
                     f"{_number(get('cracks', 'taken_relative'), '.2f')} of the fracture energy of their area")
    lines.append(f"ledger           linear {_number(get('ledger', 'linear_max'), '.1e')}, angular "
                 f"{_number(get('ledger', 'angular_max'), '.1e')} (relative to the impulses exchanged)")
    lines.append(f"energy residual  {_number(get('energy', 'residual_relative'), '.2%')}")
    active = in_words(run)
    if active:
        lines.append(f"active models    {active}")
    warnings = run.get("warnings")
    for warning in warnings if isinstance(warnings, list) else []:
        lines.append(f"warning          {warning}")
    lines.append(f"run folder       {folder}")
    if sheet is not None:
        lines.append(f"pictures         {sheet}")
    if (folder / "frames.pvd").exists():
        lines.append(f"frames           {folder / 'frames.pvd'} (ParaView; or: {own_command('view', folder)})")
    return "\n".join(lines)


def _more_parts(run: dict[str, Any]) -> str:
    """What to add where forces hold more parts together than cracks alone divide the shells into: damage parts them too."""
    surface, counts = run.get("surface"), run.get("counts")
    if not isinstance(surface, dict) or not isinstance(surface.get("held_together_m2"), list) or not isinstance(counts, dict):
        return ""
    held = len(surface["held_together_m2"])
    by_cracks = int(counts.get("fragments") or 0) - int(counts.get("handed_off") or 0)  # 0 where nothing has cracked
    return f"; damage parts the shells into {held}" if held > max(by_cracks, int(surface.get("parts_at_rest") or 1)) else ""
