"""contact_sheet.png: the whole run on one picture, with numpy and PIL only."""
from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from ..replacing import replacing
from ..report.run_json import read_run
from ..report.scene_text import scene_words
from .flat import crack_pattern, proportion, shards_of, side_view
from .frames import SHELL, Frame, choose_frames, list_frames
from .ground import Ground
from .lettering import TEXT, draw_text
from .look import Look
from .memory import keep_memory
from .meshes import Scene, load_scene
from .raster import perspective_camera
from .views import as_bytes, draw_scene
from .vtp import VtpError

WIDTH = 1960                   # [px] of the sheet
GRIDS = {12: 4, 8: 4, 6: 3, 4: 4, 3: 3, 2: 2, 1: 1}  # columns for so many panels: rows are full
TALLEST = 640                  # [px] height of a panel
GAP = 8                        # [px] between pictures
HEAD = 44                      # [px] the line on top
LOWER = (380, 860)             # [px] height of the crack pattern and of the side view
NARROWEST = 300                # [px] of these
SAMPLES = 2                    # per pixel and direction
DIRECTION = (-0.42, 0.80, -0.46)  # of view in the panels
FAR = 1.3  # pane widths; bodies further from its middle do not count for the framing, and shards but for the share
SHOWN = 0.85     # of the corners of all shards that are in the picture at every time, whole shards
BESIDE = 1.1     # times the distance of the last of these: others that are about as far are there too
FARTHEST = 3.0   # pane widths: what is further away is left out all the same
BELOW = 0.03  # of the size of what is seen: the ground, where the scene has none
PAPER = (250, 250, 249)
MOST_NAMED = 3  # kinds of sheets, before an ellipsis, and moving bodies, in the title


def write_contact_sheet(folder: Path) -> Path:
    """Draws folder/contact_sheet.png from the frames and returns its path. Raises VtpError, OSError."""
    keep_memory()
    frames = list_frames(folder)
    if not frames:
        raise VtpError(f"{folder}/frames.pvd: no frame to draw")
    panels = max(n for n in GRIDS if n <= len(frames))
    chosen = choose_frames(frames, panels)
    look = Look.of(folder)
    scenes = [load_scene(frame, look) for frame in chosen]
    close, wide = boxes(frames[0], scenes)
    ground = ground_of(scenes, *wide, look.endless)
    for scene in scenes:
        stand(scene, ground)
    columns = GRIDS[panels]
    width = (WIDTH - GAP) // columns - GAP
    size = (width, min(3 * width // 4, TALLEST))
    top = HEAD + -(-panels // columns) * (size[1] + GAP)
    lower = _lower(folder, frames, chosen[-1], scenes[-1], wide)
    sheet = Image.new("RGB", (WIDTH, top + lower.height + GAP), PAPER)
    direction = towards_what_is_hit(scenes[0], *close)
    for k, (frame, scene) in enumerate(zip(chosen, scenes)):
        low, high = close if _within(scene.shards, *close) else boxes(frames[0], [scenes[0], scene])[1]
        samples = (size[0] * SAMPLES, size[1] * SAMPLES)
        view = _image(draw_scene(scene, perspective_camera(low, high, direction, *samples), *samples))
        _caption(view, moment_text(frame) if frame.step else f"{moment_text(frame)}   frame {frames.index(frame)}")
        row, column = divmod(k, columns)
        sheet.paste(view, (GAP + column * (size[0] + GAP), HEAD + row * (size[1] + GAP)))
    sheet.paste(lower, (0, top))
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
    """Scene, materials with thickness, speeds at the start, and what became of it; the folder's name without a scene's."""
    run, words = read_run(folder), scene_words(folder)
    parts = [str(run.get("scene") or "") or folder.resolve().name]
    if run.get("status") in ("failed", "interrupted"):
        parts.append(str(run["status"]))
    sheets = dict.fromkeys(f"{m} {t * 1e3:.3g} mm" if t == t else m for m, t in zip(words.materials, words.thickness))
    if sheets:
        parts.append(", ".join([*list(sheets)[:MOST_NAMED], *(["\u2026"] if len(sheets) > MOST_NAMED else [])]))
    parts += [f"{name} {speed:.3g} m/s" for name, speed in words.speeds[:MOST_NAMED]]
    counts = run.get("counts")
    if isinstance(counts, dict) and "fragments" in counts:
        plural = "" if counts["fragments"] == 1 else "s"
        parts.append(f"{counts['fragments']} fragment{plural}, {counts.get('handed_off', 0)} handed to the rigid engine")
    return "     ".join(parts)


def ground_of(scenes: list[Scene], low: np.ndarray, high: np.ndarray, endless: bool = False) -> Ground:
    """Returns the ground for pictures of the box low..high: the floor where it is as large or `endless`, otherwise a plane below
    all that is in the box at some time."""
    centre, size = 0.5 * (low + high)[:2], 0.5 * float(np.linalg.norm(high - low))
    below = float(low[2])
    for scene in scenes:
        floor = scene.solid.points[scene.solid.triangles[scene.solid.is_floor]].reshape(-1, 3)
        if len(floor) and (endless or (floor[:, :2].min(axis=0) <= low[:2]).all() and (floor[:, :2].max(axis=0) >= high[:2]).all()):
            assert scene.floor_z is not None
            return Ground(scene.floor_z, centre, size)
        for surface in (scene.solid, scene.glass):
            points = surface.points[surface.triangles.ravel()]
            near = (np.abs(points[:, :2] - centre) < size).all(axis=1) & (points[:, 2] > low[2] - 0.5 * size)
            below = min(below, float(points[near, 2].min(initial=below)))
    return Ground(below - BELOW * size, centre, size)


def stand(scene: Scene, ground: Ground) -> None:
    """Puts a scene on the ground, which takes the place of a floor at its height."""
    scene.ground = ground
    if scene.floor_z == ground.z:
        kept = ~scene.solid.is_floor
        for name in ("triangles", "colours", "round_centre", "throws", "closed", "edge", "is_floor"):
            setattr(scene.solid, name, getattr(scene.solid, name)[kept])


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
    lying = [near(scenes[-1].moving, FAR * size), *(_most_shards(scene, centre, FAR * size, FARTHEST * size) for scene in scenes)]
    all_ = np.concatenate([np.stack([low, high]), *lying])
    wide_low, wide_high = all_.min(axis=0), all_.max(axis=0)
    if floor is not None and floor > centre[2] - 3.0 * size:
        wide_low[2] = min(wide_low[2], floor)
    return (low, high), (wide_low, wide_high)


def _most_shards(scene: Scene, centre: np.ndarray, near_m: float, far_m: float) -> np.ndarray:
    """Returns the corners of shards, nearest to the centre first, up to the share that a picture shows. Those nearer than near_m
    are all there, and none beyond far_m: a few that fly far would make all others tiny. A shard is there as a whole."""
    if not len(scene.shards):
        return scene.shards
    _, piece, count = np.unique(scene.shard_of, return_inverse=True, return_counts=True)
    reach = np.zeros(len(count))
    np.maximum.at(reach, piece, np.linalg.norm(scene.shards - centre, axis=1))
    order = np.argsort(reach, kind="stable")
    enough = np.searchsorted(np.cumsum(count[order]), SHOWN * count.sum())  # with this one the share is reached
    return scene.shards[(reach <= np.clip(BESIDE * reach[order[enough]], near_m, far_m))[piece]]


def _within(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    """Tests whether nearly all points are in the box, with a margin of a tenth."""
    spare = 0.1 * (high - low).max()
    return len(points) == 0 or float(((points > low - spare) & (points < high + spare)).all(axis=1).mean()) > 0.97


def _lower(folder: Path, frames: list[Frame], last: Frame, scene: Scene, wide: tuple[np.ndarray, np.ndarray]) -> Image.Image:
    """Draws the crack pattern, and the last frame edge on beside it, as high as lets both fill the sheet."""
    low, high = wide
    margin = 0.04 * float((high - low).max())
    low, high = low - margin, high + margin
    side = float((high[0] - low[0]) / (high[2] - low[2]))
    first = next((mesh for frame in frames if (mesh := frame.read(SHELL)) is not None), None)
    pane = proportion(first) if first is not None and len(first.triangles) else 0.0
    whole = WIDTH - (3 if pane else 2) * GAP
    height = int(np.clip(whole / (side + pane), *LOWER))
    pattern = int(np.clip(pane * height, NARROWEST, whole - NARROWEST)) if pane else 0
    out = Image.new("RGB", (WIDTH, height), PAPER)
    if pane:
        out.paste(_pattern_panel(folder, frames, pattern, height), (GAP, 0))
    out.paste(_side_panel(last, scene, low, high, whole - pattern, height), (pattern + 2 * GAP if pane else GAP, 0))
    return out


def _pattern_panel(folder: Path, frames: list[Frame], width: int, height: int) -> Image.Image:
    drawn = crack_pattern(frames, *shards_of(folder), width * SAMPLES, height * SAMPLES, margin=1.16)
    assert drawn is not None
    panel = _image(drawn[0])
    _caption(panel, "crack pattern, undeformed")
    _scale_bar(panel, drawn[1] / SAMPLES)
    return panel


def _side_panel(frame: Frame, scene: Scene, low: np.ndarray, high: np.ndarray, width: int, height: int) -> Image.Image:
    """Draws the box low..high edge on, at true scale."""
    picture, camera = side_view(scene, low, high, width * SAMPLES, height * SAMPLES)
    view = _image(picture)
    _caption(view, f"side view at {moment_text(frame)}")
    _scale_bar(view, float(camera.scale[0]) / SAMPLES)
    return view


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
