"""`sunder render`: stills and a film of a run, with the contact sheet's rasteriser."""
from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Callable, Iterator, Sequence

import numpy as np
from PIL import Image

from ..errors import DONE, CommandError
from ..launch.folder import existing_run
from ..launch.install import FILM_PACKAGES, ensure_installed
from ..places import BUILD_DIR_VARIABLE, work_folder
from ..replacing import replacing
from .between import FPS, film_frames
from .contact_sheet import SAMPLES, boxes, ground_of, moment_text, stand, towards_what_is_hit, write_contact_sheet
from .cycles import BACKDROPS, Cycles, drawn
from .frames import BODIES, SHELL, SOFT, Frame, choose_frames, list_frames
from .ground import Ground
from .lettering import draw_colour_bar, draw_text
from .look import Look
from .memory import keep_memory
from .meshes import load_scene
from .motion import body_velocity, shell_velocity
from .pace import tell_pace
from .picked import pick
from .raster import perspective_camera
from .soft import speeds
from .views import as_bytes, draw_scene
from .vtp import VtpError

STILLS = 6               # without --frames
SIZE = (1280, 720)       # [px]
FILM_S = 6.0  # [s] approximate length of a film with few frames, which is slowed down
FRAMES_A_SECOND = (4, 30)
SPEED_FRAMES = 24  # largest number of frames that are read to find the largest speed
VIEWS = {"front": (180.0, 12.0), "back": (0.0, 12.0), "left": (90.0, 8.0), "right": (-90.0, 8.0), "top": (-90.0, 89.0)}
ENCODERS = {".mp4": ("-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart"),
            ".webm": ("-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0", "-pix_fmt", "yuv420p")}
ANIMATED = (".gif", ".png")


@dataclass(frozen=True)
class Shot:
    """View and style of a run's pictures."""
    size: tuple[int, int] = SIZE                  # [px] width, height
    view: tuple[float, float] | None = None       # [degrees] azimuth of the eye from +x, elevation; None: as in the sheet
    zoom: float = 1.0
    close: bool = False  # the shell fills the picture instead of the whole scene
    caption: bool = True
    look: Look = Look()
    samples: int | None = None  # rays a pixel of Blender's Cycles; None: drawn by the contact sheet's rasteriser
    backdrop: str = BACKDROPS[0]  # around a scene that Cycles draws


@dataclass(frozen=True)
class _Stage:
    """Everything that a process needs to draw any frame."""
    frames: list[Frame]
    shot: Shot
    low: np.ndarray        # box [m] that fills the picture
    high: np.ndarray
    direction: np.ndarray  # of view
    ground: Ground


def parse_view(text: str) -> tuple[float, float]:
    """Reads a name of VIEWS or 'AZIMUTH,ELEVATION' in degrees. Raises ValueError."""
    if text in VIEWS:
        return VIEWS[text]
    azimuth, elevation = (float(x) for x in text.split(","))
    if not (-720.0 <= azimuth <= 720.0 and -89.0 <= elevation <= 89.0):
        raise ValueError(text)
    return azimuth, elevation


def frames_of(folder: Path, command: str) -> list[Frame]:
    """Returns all frames of a run. Raises CommandError where there are none."""
    existing_run(folder, command)
    try:
        frames = list_frames(folder)
    except (VtpError, OSError) as error:
        raise CommandError(f"{command}: {folder}: its frames cannot be read: {error}") from None
    if not frames:
        raise CommandError(f"{command}: {folder}/frames.pvd: no frame of it is there; was the folder 'frames' moved?")
    return frames


def render(folder: Path, out: Path | None, film: bool, sheet: bool, spec: str | None, shot: Shot, rate: float | None,
           jobs: int, speed: float | None = None) -> int:
    """Writes pictures and prints their paths; returns the exit status. Raises CommandError.

    With `speed` a film has pictures between frames, so that time runs evenly.
    """
    keep_memory()
    frames = frames_of(folder, "render")
    _check_cycles(shot, film, spec, speed)
    if sheet:
        with telling(folder / "contact_sheet.png"):
            print(write_contact_sheet(folder))
        return DONE
    if spec is not None:
        numbers = pick(spec, frames)
    elif film:
        numbers = list(range(len(frames)))
    else:
        chosen = choose_frames(frames, STILLS)
        numbers = [k for k, frame in enumerate(frames) if frame in chosen]
    if film:
        tell_pace(folder, [frames[k] for k in numbers], rate, speed, spec is None and shot.samples is None)
    if film and speed is not None:
        frames, _ = film_frames([frames[k] for k in numbers], rate, speed)
        numbers, rate = list(range(len(frames))), rate or FPS
    fps = rate or FPS
    if film:
        target = _film_file(out if out is not None else folder / "film.mp4", given=out is not None, size=shot.size)
    else:
        target = out if out is not None else folder / "stills"
    with telling(target):
        stage = _set_stage(folder, frames, numbers, shot)
        pictures = _drawn(stage, numbers, jobs) if shot.samples is None else _by_cycles(
            folder, stage, numbers, Cycles(shot.samples, fps, speed, jobs, shot.backdrop))
        if film:
            seconds_each = 1.0 / (rate or float(np.clip(len(numbers) / FILM_S, *FRAMES_A_SECOND)))
            _write_film(target, pictures, shot.size, seconds_each)
        else:
            target.mkdir(parents=True, exist_ok=True)
            for k, picture in zip(numbers, pictures):
                put_in_place(target / f"still_{k:06d}.png", partial(picture.save, format="PNG"))
    print(target)
    return DONE


def _check_cycles(shot: Shot, film: bool, spec: str | None, speed: float | None) -> None:
    """Refuses what Cycles does not draw."""
    if shot.samples is None:
        return
    if shot.look.by != "part":
        raise CommandError(f"--colour {shot.look.by}: Cycles draws materials as they are; leave --cycles or --colour out")
    if film and spec is not None and speed is not None:
        raise CommandError("--frames with --speed and --cycles: leave --frames out; the film then has the whole run")


def _by_cycles(folder: Path, stage: _Stage, numbers: Sequence[int], how: Cycles) -> Iterator[Image.Image]:
    camera = perspective_camera(stage.low, stage.high, stage.direction, *stage.shot.size)
    for done, picture in enumerate(drawn(folder, how, numbers, camera, stage.ground, stage.shot.size), start=1):
        print(f"sunder: {done} of {len(numbers)} pictures", file=sys.stderr, flush=True)
        _write_caption(picture, stage, numbers[done - 1])
        yield picture


class telling:  # noqa: N801: reads as a word in `with telling(target)`
    """Turns errors while pictures or meshes are written into CommandError."""

    def __init__(self, target: Path) -> None:
        self._target = target

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, VtpError) or isinstance(error, OSError) and str(error.filename).endswith(".vtp"):
            raise CommandError(f"a frame cannot be read: {error}") from None
        if isinstance(error, OSError):
            raise CommandError(f"cannot write {self._target}: {error.strerror or error}"
                               f"{f': {error.filename}' if error.filename else ''}; free some space there, or name "
                               "a place that you may write to") from None


def put_in_place(target: Path, write: Callable[[Path], object]) -> None:
    """Runs `write(path)` so that the file is complete or absent."""
    with replacing(target) as part:
        write(part)


def _set_stage(folder: Path, frames: list[Frame], numbers: Sequence[int], shot: Shot) -> _Stage:
    look = Look.of(folder, shot.look.by, _fastest(frames, numbers) if shot.look.by == "speed" else 1.0)
    seen = [load_scene(frames[k], look) for k in (numbers[0], numbers[len(numbers) // 2], numbers[-1])]
    close, wide = boxes(frames[0], seen)
    low, high = close if shot.close else wide
    if shot.view is None:
        direction = towards_what_is_hit(load_scene(frames[0], look), *close)
    else:
        azimuth, elevation = np.radians(shot.view)
        direction = -np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    middle = 0.5 * (low + high)
    return _Stage(frames, replace(shot, look=look), middle + (low - middle) / shot.zoom, middle + (high - middle) / shot.zoom,
                  direction, ground_of(seen, *wide, look.endless))


def _fastest(frames: list[Frame], numbers: Sequence[int]) -> float:
    """Returns the largest speed [m/s] in some of the frames, of shells and bodies, for the colour scale."""
    top = 0.0
    for k in np.unique(np.linspace(0, len(numbers) - 1, SPEED_FRAMES).round().astype(int)):
        shell = frames[numbers[k]].read(SHELL)
        found = [shell_velocity(shell)] if shell is not None else []
        found += [body_velocity(frames, numbers[k])] if BODIES in frames[numbers[k]].files else []
        soft = frames[numbers[k]].read(SOFT)
        top = max(top, float(speeds(soft).max(initial=0.0)) if soft is not None else 0.0)
        top = max([top] + [float(np.linalg.norm(v, axis=1).max(initial=0.0)) for v in found])
    return top or 1.0


_stage: _Stage | None = None  # of this process


def _enter(stage: _Stage) -> None:
    global _stage
    _stage = stage
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes; the first one ends the others
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # with this signal


def _draw(k: int) -> np.ndarray:
    assert _stage is not None
    return draw_one(_stage, k)


def draw_one(stage: _Stage, k: int) -> np.ndarray:
    """Draws frame k as (height, width, 3) bytes. Raises VtpError, OSError."""
    shot = stage.shot
    width, height = shot.size[0] * SAMPLES, shot.size[1] * SAMPLES
    velocity = body_velocity(stage.frames, k) if shot.look.by == "speed" else None
    scene = load_scene(stage.frames[k], shot.look, velocity)
    stand(scene, stage.ground)
    camera = perspective_camera(stage.low, stage.high, stage.direction, width, height)
    image = Image.fromarray(as_bytes(draw_scene(scene, camera, width, height))).reduce(SAMPLES)
    _write_caption(image, stage, k)
    return np.asarray(image)


def _write_caption(image: Image.Image, stage: _Stage, k: int) -> None:
    if stage.shot.caption:
        height = stage.shot.size[1]
        draw_text(image, (height // 40, height // 60), moment_text(stage.frames[k]), max(height // 32, 8))
        scale = scale_of(stage.shot.look)
        if scale is not None:
            draw_colour_bar(image, *scale)


def scale_of(look: Look) -> tuple[str, str, str] | None:
    """Returns title with unit, and both ends of the colour scale; None where colours tell no quantity."""
    if look.by == "damage":
        return "damage [-]", "0", "1"
    return ("speed [m/s]", "0", f"{look.fastest:.3g}") if look.by == "speed" else None


def _drawn(stage: _Stage, numbers: Sequence[int], jobs: int) -> Iterator[Image.Image]:
    """Draws the pictures in order, with several processes."""
    jobs = min(jobs, len(numbers))
    if jobs <= 1:
        yield from (Image.fromarray(draw_one(stage, k)) for k in numbers)
        return
    try:
        pool = multiprocessing.get_context("fork").Pool(jobs, _enter, (stage,))
    except OSError as error:  # its locks are files in /dev/shm, which may not be written to
        print(f"sunder: note: pictures are drawn one after another: /dev/shm: {error.strerror}", file=sys.stderr, flush=True)
        yield from _drawn(stage, numbers, 1)
        return
    with pool:
        yield from (Image.fromarray(picture) for picture in pool.imap(_draw, numbers))


def _film_file(target: Path, given: bool, size: tuple[int, int]) -> Path:
    """Returns the film's path. Chooses another kind of file where ffmpeg is missing and no kind was asked for.
    Raises CommandError."""
    if target.suffix not in (*ENCODERS, *ANIMATED):
        raise CommandError(f"--out {target}: a film is one of {', '.join((*ENCODERS, *ANIMATED))}")
    if target.suffix in ANIMATED:
        return target
    if any(n % 2 for n in size):
        raise CommandError(f"--size {size[0]}x{size[1]}: {target.suffix} needs even numbers")
    if shutil.which("ffmpeg"):
        return target
    try:
        if os.environ.get(BUILD_DIR_VARIABLE):
            raise CommandError(f"there is no ffmpeg, and {BUILD_DIR_VARIABLE} is set: nothing is installed then")
        work_folder().mkdir(parents=True, exist_ok=True)
        ensure_installed(work_folder() / "install.log", FILM_PACKAGES)
        return target
    except (CommandError, OSError) as error:
        if given:
            raise CommandError(f"{error}\n{target} needs ffmpeg; --out with .gif or .png (animated) does not") from None
        print(f"sunder: {error}\nsunder: so the film is an animated GIF", file=sys.stderr, flush=True)
        return target.with_suffix(".gif")


def _write_film(target: Path, pictures: Iterator[Image.Image], size: tuple[int, int], seconds_each: float) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.suffix in ENCODERS:
        put_in_place(target, lambda path: _encode(path, pictures, size, seconds_each))
    else:
        first = next(pictures)
        milliseconds = max(round(1000 * seconds_each), 20)  # browsers slow down faster films
        options: dict[str, Any] = {"optimize": False} if target.suffix == ".gif" else {}
        rest = list(pictures)  # PNG needs them twice
        put_in_place(target, lambda path: first.save(path, format=target.suffix[1:].upper(), save_all=True, append_images=rest,
                                                     duration=milliseconds, loop=0, **options))


def _encode(path: Path, pictures: Iterator[Image.Image], size: tuple[int, int], seconds_each: float) -> None:
    """Writes the film with ffmpeg. Raises CommandError with its last message where it fails, OSError."""
    command = ["ffmpeg", "-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
               f"{size[0]}x{size[1]}", "-r", f"{1.0 / seconds_each:.6f}", "-i", "-", *ENCODERS[path.suffix], str(path)]
    with tempfile.TemporaryFile() as words:
        encoder = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=words, stderr=words)
        assert encoder.stdin is not None
        try:
            for picture in pictures:
                encoder.stdin.write(picture.tobytes())
            encoder.stdin.close()
        except BrokenPipeError:
            pass  # ffmpeg's message gives the reason
        except BaseException:
            encoder.kill()
            raise
        finally:
            status = encoder.wait()
        if status != 0:
            words.seek(0)
            raise CommandError(f"ffmpeg failed with status {status}: {words.read().decode(errors='replace').strip()[-800:]}")
