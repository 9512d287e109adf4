"""Which models a run had active, why, and what share of its time each took: from run.json, which has one entry a model."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Sequence

from ..errors import CommandError
from .run_json import read_run


def grouped(run: dict[str, Any]) -> list[tuple[list[str], float]]:
    """Names of models and their share of the solver's time, largest first.

    Models that work in the same stage of a substep (seams and plasticity in the internal force, say) have one share between
    them, and run.json gives it to each: here they are one entry.
    """
    out: dict[float, list[str]] = {}
    for model in _models(run):
        out.setdefault(float(model["share"]), []).append(str(model["name"]))
    apart = [([n], 0.0) for n in out.pop(0.0, [])]  # no time is not a stage in common
    return sorted(((names, share) for share, names in out.items()), key=lambda g: -g[1]) + apart


def _models(run: dict[str, Any]) -> list[dict[str, Any]]:
    models = run.get("models")
    return [m for m in models if isinstance(m, dict) and "name" in m and "share" in m] if isinstance(models, list) else []


def in_words(run: dict[str, Any]) -> str:
    """'kirchhoff_love_plane_stress 69 %, shell_contact 7 %'; '' where run.json does not say."""
    return ", ".join(f"{' + '.join(names)} {percent(share)}" for names, share in grouped(run))


def percent(share: float) -> str:
    """A share for people."""
    return f"{100.0 * share:.0f} %" if share >= 0.0095 else "< 1 %"


def table(folders: Sequence[Path]) -> str:
    """What `sunder models` prints: a line a run, and what made each model active. Raises CommandError for what is no run."""
    lines = ["| scene | active models and their share of the time |", "| --- | --- |"]
    why: dict[str, list[str]] = {}
    for folder in folders:
        run = read_run(folder)
        if not _models(run):
            raise CommandError(f"models: {folder}: holds no run.json with models; name the folder of a run")
        name = f"`{run.get('scene')}`" + (f" ({folder})" if len(folders) > 1 else "")
        lines.append(f"| {name} | {in_words(run)} |")
        for model in _models(run):
            why.setdefault(str(model["why"]), [])
            if model["name"] not in why[str(model["why"])]:
                why[str(model["why"])].append(str(model["name"]))
    lines += ["", *(f"{', '.join(names)}: {reason}" for reason, names in why.items())]
    return "\n".join(lines)
