"""What is wrong with a path that should be a run folder. Needs nothing but Python, so that Blender's own can tell it too."""
from __future__ import annotations

from pathlib import Path

from ..words import own_command

FRAMES = "frames.pvd"
SCENE_ENDING = ".textproto"
HOW = "name the folder of a run, the one that 'sunder run SCENE' says at its end"


def not_a_run(path: Path, lacks: str = f"holds no {FRAMES}") -> str:
    """Returns why the path is no folder with frames of a run, and what to name; '' where it is one. `lacks` says what a folder
    without them does not hold."""
    scene = path if path.suffix == SCENE_ENDING else path.with_name(f"{path.name}{SCENE_ENDING}")
    if not path.is_dir():
        if scene.is_file():
            return (f"{scene}: is a scene, and no run of it; run it first: {own_command('run', scene)}, then name the folder that "
                    "this says at its end")
        if path.exists():
            return f"{path}: is a file; {HOW}"
        return f"{path}: no such folder; {HOW}"
    if (path / FRAMES).is_file():
        return ""
    near = next((one for one in (path.resolve().parent, *sorted(path.glob("*"))) if (one / FRAMES).is_file()), None)
    return f"{path}: {lacks}; {f'{near} is the folder of a run' if near is not None else HOW}"
