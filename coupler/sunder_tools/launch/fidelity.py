"""Fidelity presets: settings that `sunder trade` has found worth their cost, made from a scene's own values.

A preset is a handful of --set for one run. What the user sets is never overridden. The scene is read as text, as for
pictures: protobuf is not needed; it is the solver that judges it.
"""
from __future__ import annotations

import math
import re
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Callable, Sequence

from ..errors import DONE
from ..report.scene_text import Message, SceneTextError, parse_text
from .needs import built_for

PATCHES = {"plate": ("elements_x", "elements_y"), "cylinder": ("elements_u", "elements_v"),
           "sphere": ("elements_u", "elements_v"), "cone": ("elements_u", "elements_v"),
           "nurbs": ("elements_u", "elements_v"), "cad": ("elements_u", "elements_v")}
OF_LENGTH = ("annulus", "cad", "mesh")  # their element_m is the length of an element
NEARER = 2.0 ** 0.25  # a coarser scene that is refused is tried again with so many times the elements


@dataclass(frozen=True)
class Preset:
    """Factors of the elements that a scene has along either side of a shell, and of its window. Both were worth
    their cost in every scene by which presets were chosen. coupler/experiments/README.md, "The trade", says how both cost and
    error are measured."""
    elements: float = 1.0
    window: float = 1.0


PRESETS = {"draft": Preset(0.5, 4.0), "standard": Preset(), "reference": Preset(math.sqrt(2.0))}


@dataclass(frozen=True)
class Taken:
    """The settings of a preset for a scene, as --set takes them; `was` has the scene's own value of each."""
    name: str
    settings: tuple[str, ...]
    was: tuple[str, ...]
    kept: tuple[str, ...] = ()  # paths that the user has set

    def words(self) -> str:
        """One line for people."""
        made = ", ".join(f"{setting} (was {was})" for setting, was in zip(self.settings, self.was))
        own = f"; as you set them: {', '.join(self.kept)}" if self.kept else ""
        return f"fidelity {self.name}: {made or 'the scene as it is'}{own}"


def taken(name: str, scene: Message, given: Sequence[str], accepted: Callable[[Sequence[str]], bool]) -> Taken:
    """Values of preset `name` for a scene. `given`: --set of the user.

    `accepted` says whether the solver takes given settings. A window that a draft makes too long for a scene is halved.
    Elements too large for a body that is to meet them are made smaller again, at most to the scene's own. Settings that
    are refused even so are refused by the run.
    """
    preset = PRESETS[name]

    def tried(preset: Preset) -> tuple[Taken, bool]:
        found = _values(name, preset, scene, given)
        return found, not found.settings or accepted([*given, *found.settings])

    found, taken_so = tried(preset)
    if not taken_so and preset.window > 1.0:
        shorter = preset
        while shorter.window > 1.0 and not tried(replace(shorter, elements=1.0))[1]:
            shorter = replace(shorter, window=max(1.0, 0.5 * shorter.window))
        if shorter != preset:  # it was the window, or that too
            preset = shorter
            found, taken_so = tried(preset)
    while not taken_so and preset.elements < 1.0:
        finer = preset.elements * NEARER
        preset = replace(preset, elements=1.0 if finer > 0.99 else finer)
        found, taken_so = tried(preset)
    return found


def with_fidelity(scene: Path, settings: list[str], name: str | None, quiet: bool, until: str | None = None) -> list[str]:
    """`settings`, and before them those of preset `name`; says which. `until` [s] is the end that the run will be given.

    A scene that cannot be read is left as it is: the solver says where it is wrong.
    """
    if name is None:
        return settings
    shell = str(built_for(scene).shell)

    def accepted(tried: Sequence[str]) -> bool:
        command = [shell, "--scene", str(scene), "--check", *(part for s in tried for part in ("--set", s)),
                   *(("--until", until) if until else ())]
        return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              check=False).returncode == DONE
    try:
        found = taken(name, parse_text(scene.read_text()), settings, accepted)
    except (OSError, UnicodeDecodeError, SceneTextError):
        return settings
    if not quiet:
        print(f"sunder: {found.words()}", file=sys.stderr, flush=True)
    return [*found.settings, *settings]


def _values(name: str, preset: Preset, scene: Message, given: Sequence[str]) -> Taken:
    names = [str(_last(s, "name") or "") for s in scene.get("shells", [])]
    users = {_by_name(setting.partition("=")[0], names) for setting in given}
    wanted: list[tuple[str, str, str]] = []  # path, value, what it was
    for shell, called in zip(scene.get("shells", []), names):
        for patch, counts in PATCHES.items():
            for count in counts:
                own = _last(_last(shell, patch), count)
                if isinstance(own, float) and preset.elements != 1.0:
                    path = f"shells[{called}].{patch}.{count}"
                    wanted.append((path, f"{max(1, round(own * preset.elements))}", f"{own:g}"))
        for patch in OF_LENGTH:
            own = _last(_last(shell, patch), "element_m")
            if isinstance(own, float) and preset.elements != 1.0:
                wanted.append((f"shells[{called}].{patch}.element_m", f"{own / preset.elements:.6g}", f"{own:g}"))
    own, settle = _last(scene, "window_s"), _last(scene, "settle_window_s")
    if isinstance(own, float) and preset.window != 1.0:
        window = float(f"{own * preset.window:.12g}")
        wanted.append(("window_s", f"{window:.12g}", f"{own:g}"))
        if isinstance(settle, float) and "window_s" not in users:  # a whole number of windows
            wanted.append(("settle_window_s", f"{max(1, round(settle / window)) * window:.12g}", f"{settle:g}"))
    mine = [w for w in wanted if w[0] not in users and float(w[1]) != float(w[2])]
    return Taken(name, tuple(f"{path}={value}" for path, value, _ in mine), tuple(was for _, _, was in mine),
                 tuple(path for path, _, _ in wanted if path in users))


def _by_name(path: str, names: Sequence[str]) -> str:
    """A path whose shell may be given by number, with its name."""
    found = re.match(r"shells\[(\d+)\]", path)
    if found and int(found[1]) < len(names) and found[1] not in names:
        return f"shells[{names[int(found[1])]}]{path[found.end():]}"
    return path


def _last(message: Any, name: str) -> Any:
    """The last value of a field, None where it is not there."""
    return message[name][-1] if isinstance(message, dict) and message.get(name) else None
