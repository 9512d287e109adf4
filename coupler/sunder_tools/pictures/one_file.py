"""`sunder export --gltf FILE`, `--usd FILE` and `--pc2 DIR`: a whole run as things that move."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import BAD_INPUT, DONE, CommandError
from ..report.scene_text import known_words
from .animated import animated_glb
from .between import FPS, MOST_FRAMES, film_frames, key_frames
from .look import origins
from .pace import tell_pace
from .pc2 import write_caches
from .picked import pick
from .render import frames_of, put_in_place, telling
from .story import MOST_STEPS, story_of
from .usda import usda_text

ENDINGS = {"gltf": ".glb", "usd": ".usda"}
CACHES = "pc2"  # a folder, with a sample a picture


def export_one(folder: Path, kind: str, target: Path, spec: str | None, fps: float | None, speed: float | None,
               middle: bool) -> int:
    """Writes the file or the folder and prints its path; returns the exit status. Raises CommandError."""
    _check(kind, target)
    frames = frames_of(folder, "export")
    if spec is not None:
        frames = [frames[k] for k in pick(spec, frames)]
    tell_pace(folder, frames, fps, speed, spec is None)
    frames, times = (film_frames if kind == CACHES else key_frames)(frames, fps, speed)
    words = known_words(folder, "export")
    with telling(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        things = story_of(frames, words, origins(folder, words), middle, MOST_FRAMES if kind == CACHES else MOST_STEPS)
        if kind == CACHES:
            write_caches(target, things, len(frames), _put)
        elif kind == "usd":
            _put(target, usda_text(things, times, fps or FPS, speed, np.array([frame.time_s for frame in frames])).encode("ascii"))
        else:
            extras = {"fps": fps or FPS, "speed": speed, "times_s": [frame.time_s for frame in frames]}
            _put(target, animated_glb(things, times, extras))
    print(target)
    return DONE


def _check(kind: str, target: Path) -> None:
    """Raises CommandError for a target that cannot be."""
    if kind == CACHES:
        if target.exists() and not target.is_dir():
            raise CommandError(f"--{kind} {target}: is a file; name a folder", BAD_INPUT)
    elif target.suffix != ENDINGS[kind]:
        raise CommandError(f"--{kind} {target}: end it in {ENDINGS[kind]}", BAD_INPUT)


def _put(target: Path, content: bytes) -> None:
    put_in_place(target, lambda path: path.write_bytes(content))
