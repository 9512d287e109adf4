"""Pictures by Blender's Cycles: light that glass bends, metal that mirrors. Blender reads the run by the add-on."""
from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, Sequence

import numpy as np
from PIL import Image

from ..errors import PEER_LOST, CommandError, how_it_ended
from ..launch.install import BLENDER_PACKAGES, ensure_installed
from ..places import BUILD_DIR_VARIABLE, COUPLER, work_folder
from ..report.appearance import as_linear
from ..report.scene_text import scene_words
from .frames import BODIES, MOVING, STATIC, list_frames
from .ground import Ground
from .materials import name_of_body
from .raster import NEAR_M, Camera
from .shadows import LIGHT

SCRIPT = COUPLER / "blender" / "sunder_cycles.py"
DRAWN, FAILED = "sunder-drawn ", "sunder-failed "  # how the script's lines begin
BACKDROPS = ("light", "dark")  # as the script has them
LAST_LINES = 12  # of Blender's words that a message repeats
FAR = 1e4        # [of the size of the ground] where the camera's view ends


@dataclass(frozen=True)
class Cycles:
    """How to draw: rays for each pixel, how fast time runs in the film (None: a picture a frame), threads (0: all), what is
    around the scene (one of BACKDROPS)."""
    samples: int
    fps: float
    speed: float | None
    threads: int = 0
    backdrop: str = BACKDROPS[0]


def find_blender() -> str:
    """Returns Blender's path; installs it where that may be. Raises CommandError."""
    there = shutil.which("blender")
    if there is None:
        if os.environ.get(BUILD_DIR_VARIABLE):
            raise CommandError(f"--cycles needs Blender, and {BUILD_DIR_VARIABLE} is set: nothing is installed then; install "
                               f"it: apt-get install --no-install-recommends {' '.join(BLENDER_PACKAGES)}")
        work_folder().mkdir(parents=True, exist_ok=True)
        ensure_installed(work_folder() / "install.log", BLENDER_PACKAGES)
        there = shutil.which("blender")
    if there is None:
        raise CommandError("--cycles: there is no program 'blender' on the path")
    return there


def job_of(folder: Path, how: Cycles, numbers: Sequence[int], pictures: Sequence[Path], camera: Camera, ground: Ground,
           size: tuple[int, int]) -> dict[str, object]:
    """Returns what the script is told. Lengths are in metres, the focal length is in pixels. Raises VtpError, OSError."""
    return {
        "folder": str(folder.resolve()), "fps": how.fps, "speed": how.speed or 0.0, "samples": how.samples,
        "threads": how.threads, "backdrop": how.backdrop, "frames": [int(n) for n in numbers], "pictures": [str(path) for path in pictures],
        "looks": {name: {"kind": look.kind, "colour": as_linear(look.colour), "roughness": look.roughness}
                  for name, look in scene_words(folder).appearances}, "light": LIGHT.tolist(),
        "static": static_names(folder),
        "ground": {"z": float(ground.z), "centre": [float(c) for c in ground.centre], "size": float(ground.size)},
        "camera": {"eye": camera.eye.tolist(), "axes": np.asarray(camera.axes).tolist(), "focal": float(camera.scale[0]),
                   "size": list(size), "near": NEAR_M, "far": FAR * float(ground.size)}}


def static_names(folder: Path) -> list[str]:
    """Returns the names of the bodies that never move, as the add-on has them. Raises VtpError, OSError."""
    words = scene_words(folder)
    bodies = next((frame.read(BODIES) for frame in list_frames(folder) if BODIES in frame.files), None)
    if bodies is None or not len(bodies.triangles):
        return []
    fixed = bodies.of_triangles("kind", MOVING) == STATIC
    return [name_of_body(int(one), words) for one in np.unique(bodies.of_triangles("body", 0)[fixed])]


def drawn(folder: Path, how: Cycles, numbers: Sequence[int], camera: Camera, ground: Ground,
          size: tuple[int, int]) -> Iterator[Image.Image]:
    """Draws frames in order. Raises CommandError with Blender's last words where it fails."""
    blender = find_blender()
    with tempfile.TemporaryDirectory(prefix="sunder-cycles-") as temporary:
        pictures = [Path(temporary) / f"{k:06d}.png" for k in range(len(numbers))]
        job = Path(temporary) / "job.json"
        job.write_text(json.dumps(job_of(folder, how, numbers, pictures, camera, ground, size)), encoding="utf-8")
        command = [blender, "--background", "--factory-startup", "--python", str(SCRIPT), "--", str(job)]
        said: deque[str] = deque(maxlen=LAST_LINES)
        count = 0
        with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              errors="replace") as process:
            assert process.stdout is not None
            try:
                for line in process.stdout:
                    if line.startswith(FAILED):
                        raise CommandError(f"Blender: {line[len(FAILED):].strip()}")
                    if not line.startswith(DRAWN):
                        said.append(line.rstrip())
                        continue
                    with Image.open(pictures[count]) as picture:
                        yield picture.convert("RGB")
                    pictures[count].unlink()
                    count += 1
            except BaseException:
                process.kill()
                raise
        if count < len(numbers):
            raise CommandError(f"Blender {how_it_ended(process.returncode)} after {count} of {len(numbers)} pictures; its last "
                               "words:\n" + "\n".join(said), PEER_LOST)
