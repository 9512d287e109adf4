"""contact_sheet.png: the whole run on one picture, with numpy and PIL only."""
from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from ..replacing import replacing
from ..report.run_json import read_run
from .flat import crack_pattern, side_view
from .frames import SHELL, Frame, choose_frames, list_frames
from .lettering import TEXT, draw_text
from .look import Look
from .meshes import Scene, load_scene
from .raster import perspective_camera
from .views import as_bytes, draw_scene
from .vtp import VtpError

COLUMNS, ROWS = 4, 3
PANEL = (480, 360)             # [px] width, height of a view
GAP = 8                        # [px] between pictures
HEAD = 44                      # [px] the line on top
PATTERN = 860                  # [px] side of the crack pattern
DETAIL = 250                   # [px] height of the strip just above the floor
SAMPLES = 2                    # per pixel and direction
DIRECTION = (-0.42, 0.80, -0.46)  # of view in the panels
FAR = 1.3  # pane widths; points further from its middle do not count for the framing
PAPER = (250, 250, 249)
SHEET = (COLUMNS * PANEL[0] + (COLUMNS + 1) * GAP, HEAD + ROWS * (PANEL[1] + GAP) + GAP + PATTERN + GAP)


def write_contact_sheet(folder: Path) -> Path:
    """Draws folder/contact_sheet.png from the frames and returns its path. Raises VtpError, OSError."""
    frames = list_frames(folder)
    if not frames:
        raise VtpError(f"{folder}/frames.pvd: no frame to draw")
    sheet = Image.new("RGB", SHEET, PAPER)
    chosen = choose_frames(frames, COLUMNS * ROWS)
    look = Look.of(folder)
    scenes = [load_scene(frame, look) for frame in chosen]
    close, wide = boxes(frames[0], scenes)
    direction = towards_what_is_hit(scenes[0], *close)
    for k, (frame, scene) in enumerate(zip(chosen, scenes)):
        low, high = close if _within(scene.shards, *close) else wide
        size = (PANEL[0] * SAMPLES, PANEL[1] * SAMPLES)
        view = _image(draw_scene(scene, perspective_camera(low, high, direction, *size), *size))
        _caption(view, moment_text(frame))
        row, column = divmod(k, COLUMNS)
        sheet.paste(view, (GAP + column * (PANEL[0] + GAP), HEAD + row * (PANEL[1] + GAP)))
    top = HEAD + ROWS * (PANEL[1] + GAP)
    sheet.paste(_pattern_panel(frames), (GAP, top))
    side_width = SHEET[0] - PATTERN - 3 * GAP
    sheet.paste(_side_panel(chosen[-1], scenes[-1], wide, side_width), (PATTERN + 2 * GAP, top))
    draw_text(sheet, (GAP + 4, 10), _title(folder), 22)

    target = folder / "contact_sheet.png"
    with replacing(target) as part:
        sheet.save(part)
    return target


def moment_text(frame: Frame) -> str:
    """The frame's time or, where nothing moves, 'load step 2'."""
    return f"load step {frame.time_s:.4g}" if frame.step else time_text(frame.time_s)


def time_text(time_s: float) -> str:
    """'0', '350 µs', '4.20 ms' or '1.25 s'."""
    if time_s == 0.0:
        return "0"
    if time_s < 0.9995e-3:
        return f"{time_s * 1e6:.3g} \u00b5s"
    return f"{time_s * 1e3:.3g} ms" if time_s < 0.9995 else f"{time_s:.3g} s"


def _title(folder: Path) -> str:
    run = read_run(folder)
    words = [folder.resolve().name]
    if run.get("status") in ("failed", "interrupted"):
        words.append(str(run["status"]))
    counts = run.get("counts")
    if isinstance(counts, dict) and "fragments" in counts:
        words.append(f"{counts['fragments']} fragments, {counts.get('handed_off', 0)} handed to the rigid engine")
    return "     ".join(words)


def towards_what_is_hit(scene: Scene, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Returns the usual direction of view, or the opposite one where a body strikes the shell from behind."""
    direction = np.array(DIRECTION)
    if len(scene.moving) and scene.moving[:, 0].mean() < 0.5 * (low[0] + high[0]) - 0.25 * (high - low).max():
        direction[0] *= -1.0
    return direction


def boxes(first: Frame, scenes: list[Scene]) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Returns two boxes [m] to frame: the pane with the striking bodies, and everything down to the floor."""
    shell = first.read(SHELL)
    core = [shell.points] if shell is not None and len(shell.points) else [
        scenes[0].shards, scenes[0].glass.points, scenes[0].moving]
    pane = np.concatenate([part for part in core if len(part)] or [np.zeros((1, 3))])
    centre = 0.5 * (pane.min(axis=0) + pane.max(axis=0))
    size = max(float(np.ptp(pane, axis=0).max()), 0.05)

    def near(points: np.ndarray, reach_m: float) -> np.ndarray:
        return points[np.linalg.norm(points[:, :2] - centre[:2], axis=1) < reach_m]

    hitting = near(scenes[0].moving, size)
    hitting = hitting[np.abs(hitting[:, 2] - centre[2]) < 0.6 * size]
    close = np.concatenate([pane, hitting])
    low, high = close.min(axis=0), close.max(axis=0)
    low[2] = min(low[2], centre[2] - 0.22 * size)
    floor = scenes[-1].floor_z
    if floor is not None and floor < centre[2]:
        low[2] = max(low[2], floor)
    lying = [near(points, FAR * size) for points in (scenes[-1].shards, scenes[-1].moving, scenes[len(scenes) // 2].shards)]
    all_ = np.concatenate([np.stack([low, high]), *lying])
    wide_low, wide_high = all_.min(axis=0), all_.max(axis=0)
    if floor is not None and floor > centre[2] - 3.0 * size:
        wide_low[2] = min(wide_low[2], floor)
    return (low, high), (wide_low, wide_high)


def _within(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    """Tests whether nearly all points are in the box, with a margin of a tenth."""
    spare = 0.1 * (high - low).max()
    return len(points) == 0 or float(((points > low - spare) & (points < high + spare)).all(axis=1).mean()) > 0.97


def _pattern_panel(frames: list[Frame]) -> Image.Image:
    drawn = crack_pattern(frames, PATTERN * SAMPLES, PATTERN * SAMPLES, margin=1.16)
    if drawn is None:
        panel = Image.new("RGB", (PATTERN, PATTERN), PAPER)
        _caption(panel, "no shell in this run")
        return panel
    panel = _image(drawn[0])
    _caption(panel, "crack pattern, undeformed")
    _scale_bar(panel, drawn[1] / SAMPLES)
    return panel


def _side_panel(frame: Frame, scene: Scene, wide: tuple[np.ndarray, np.ndarray], width: int) -> Image.Image:
    """Draws the run edge on: all at true scale, and below it the first centimetres above the floor, stretched."""
    panel = Image.new("RGB", (width, PATTERN), PAPER)
    low, high = wide[0] - 0.04, wide[1] + 0.04
    detail = DETAIL if scene.floor_z is not None else 0
    height = PATTERN - (detail + GAP if detail else 0)
    picture, camera = side_view(scene, low, high, width * SAMPLES, height * SAMPLES, stretch=False)
    view = _image(picture)
    _caption(view, f"side view at {moment_text(frame)}")
    _scale_bar(view, float(camera.scale[0]) / SAMPLES)
    panel.paste(view, (0, 0))
    if scene.floor_z is not None:
        half = 0.5 * width * SAMPLES / camera.scale[0]  # the same length of floor as in the picture above
        middle = 0.5 * (low + high)
        low = np.array([middle[0] - half, low[1], scene.floor_z - 0.008])
        high = np.array([middle[0] + half, high[1], scene.floor_z + 0.048])
        picture, camera = side_view(scene, low, high, width * SAMPLES, detail * SAMPLES)
        view = _image(picture)
        ratio = camera.scale[1] / camera.scale[0]
        _caption(view, f"just above the floor, heights \u00d7 {ratio:.1f}")
        draw = ImageDraw.Draw(view)
        for mm in (0, 10, 20, 30, 40):
            y = camera.project(np.array([[0.0, 0.0, scene.floor_z + mm * 1e-3]]))[0][0, 1] / SAMPLES
            draw.line([(width - 14, y), (width, y)], fill=TEXT)
            draw_text(view, (width - 66, int(y) - 9), f"{mm} mm", 13)
        panel.paste(view, (0, PATTERN - detail))
    return panel


def _image(picture: np.ndarray) -> Image.Image:
    """Averages the samples of each pixel."""
    return Image.fromarray(as_bytes(picture)).reduce(SAMPLES)


def _caption(image: Image.Image, text: str) -> None:
    draw_text(image, (12, 8), text, 18)


def _scale_bar(image: Image.Image, pixels_per_m: float) -> None:
    """Draws a bar of 1, 10 or 100 cm in the lower left corner."""
    length_m = next((m for m in (1.0, 0.1, 0.01) if m * pixels_per_m < 0.4 * image.width), 0.001)
    x, y = 14, image.height - 16
    ImageDraw.Draw(image).line([(x, y), (x + length_m * pixels_per_m, y)], fill=TEXT, width=3)
    draw_text(image, (x, y - 22), f"{length_m * 100:g} cm", 14)
