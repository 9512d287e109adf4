"""The scenes that ship: what each shows, and how long it takes, as far as that was measured."""
from __future__ import annotations

import json
import os
import re
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from ..errors import BAD_INPUT, CommandError
from ..places import REPOSITORY
from ..report.machine import circumstances
from ..words import did_you_mean
from .build import build_dir
from .needs import built_for
from .run import launch_once, read_usage

SCENES = REPOSITORY / "scenes"
ENDING = ".textproto"
FOLDERS = ("", "cad", "paper")  # below the folder of scenes: the rest needs OpenCASCADE, or is of the paper
SECONDS = "seconds.json"  # beside the scenes; written by measure() only


@dataclass(frozen=True)
class Shipped:
    """A scene that ships."""
    name: str
    path: Path
    about: str              # the first sentence of its leading comment
    seconds: float | None   # of processor, of both processes, for a run without pictures; None where it was not measured


def shipped(folder: Path = SCENES) -> list[Shipped]:
    """All scenes of a folder and of FOLDERS below it, by name, such as 'paper/fig01'. Raises CommandError where the measured
    seconds cannot be read."""
    measured = read_seconds(folder)
    return [Shipped(name, path, about(path.read_text(encoding="utf-8")), _seconds(measured.get(name)))
            for below in FOLDERS for path in sorted((folder / below).glob("*" + ENDING))
            for name in (str(path.relative_to(folder)).removesuffix(ENDING),)]


def about(text: str) -> str:
    """The first sentence of the comment that a scene begins with, '' where it begins with none."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# ").rstrip())
    words = " ".join(lines)
    end = re.search(r"[.!?](?= [A-Z]|$)", words)  # not 'Fig. 12' nor '1.5 m'
    return words[:end.end()] if end else words


def read_seconds(folder: Path) -> dict[str, object]:
    """The measurements by scene; {} where there is no file. Raises CommandError where it cannot be read."""
    path = folder / SECONDS
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise CommandError(f"{path}: cannot be read: {error}; remove it, or measure again with 'sunder scenes --measure'",
                           BAD_INPUT) from None
    return kept if isinstance(kept, dict) else {}


def _seconds(entry: object) -> float | None:
    value = entry.get("processor_s") if isinstance(entry, dict) else None
    return float(value) if isinstance(value, (int, float)) else None


def measure(names: list[str], folder: Path = SCENES) -> None:
    """Runs these scenes, all but the paper's where none is named, and keeps the processor's seconds of each as soon as it has ended.

    Other programs on the machine change those least. Raises CommandError for a name that does not ship, before anything runs.
    """
    there = {scene.name: scene.path for scene in shipped(folder)}
    for name in names:
        if name not in there:
            raise CommandError(f"no scene '{name}' ships; {did_you_mean(name, there)}", BAD_INPUT)
    for name in names or [name for name in there if not name.startswith("paper/")]:
        executables = built_for(there[name])
        print(f"sunder: measuring {name}", file=sys.stderr, flush=True)
        made_with = circumstances(build_dir())  # the load before it, not its own
        with tempfile.TemporaryDirectory(prefix="seconds-sunder-") as out:
            launch_once(executables, there[name], Path(out), [])
            taken = read_usage(Path(out)).get("processor_s")
            if taken is None:
                raise CommandError(f"{name}: the run has left no record of its processor time in {out}: is the disk full?")
        _keep(folder, name, {"processor_s": float(f"{taken:.3g}"), **made_with})


def _keep(folder: Path, name: str, entry: dict[str, object]) -> None:
    path, temporary = folder / SECONDS, folder / f".{SECONDS}.{os.getpid()}"
    try:
        temporary.write_text(json.dumps(dict(sorted((read_seconds(folder) | {name: entry}).items())), indent=1) + "\n")
        os.replace(temporary, path)
    except OSError as error:
        raise CommandError(f"cannot write {path}: {error.strerror}", BAD_INPUT) from None
    finally:
        temporary.unlink(missing_ok=True)
