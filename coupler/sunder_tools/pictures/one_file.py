"""`sunder export --gltf FILE` and `--usd FILE`: a whole run in one animated file."""
from __future__ import annotations

from pathlib import Path

from ..errors import BAD_INPUT, DONE, CommandError
from ..report.scene_text import known_words
from .animated import animated_glb
from .between import FPS, film_frames
from .look import origins
from .render import frames_of, pick, put_in_place, telling
from .story import story_of
from .usda import usda_text

ENDINGS = {"gltf": ".glb", "usd": ".usda"}


def export_one(folder: Path, kind: str, target: Path, spec: str | None, fps: float | None, speed: float | None,
               middle: bool) -> int:
    """Writes the file and prints its path; returns the exit status. Raises CommandError."""
    if target.suffix != ENDINGS[kind]:
        raise CommandError(f"--{kind} {target}: end it in {ENDINGS[kind]}", BAD_INPUT)
    frames = frames_of(folder, "export")
    if spec is not None:
        frames = [frames[k] for k in pick(spec, len(frames))]
    frames, times = film_frames(frames, fps, speed, to_the_end=True)
    words = known_words(folder, "export")
    with telling(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        things = story_of(frames, words, origins(folder, words), middle)
        if kind == "usd":
            text = usda_text(things, times, fps or FPS, speed)
            put_in_place(target, lambda path: path.write_text(text, encoding="ascii"))
            print(target)
            return DONE
        extras = {"fps": fps or FPS, "speed": speed, "times_s": [frame.time_s for frame in frames]}
        content = animated_glb(things, times, extras)
        put_in_place(target, lambda path: path.write_bytes(content))
    print(target)
    return DONE
