"""Panels of which the figures are put together: sheets straight on with a colour for each triangle, views, bars."""
from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Sequence

import numpy as np
from PIL import Image, ImageDraw

from sunder_tools.pictures.contact_sheet import DIRECTION, moment_text, stand
from sunder_tools.pictures.flat import along_normal
from sunder_tools.pictures.frames import CRACKS, SHELL, Frame, list_frames
from sunder_tools.pictures.ground import Ground
from sunder_tools.pictures.lettering import draw_text
from sunder_tools.pictures.look import Look
from sunder_tools.pictures.meshes import Scene, fragment_edges, load_scene, reference_points
from sunder_tools.pictures.raster import Camera, line_pixels, orthographic_camera, perspective_camera, rasterise
from sunder_tools.pictures.views import as_bytes, draw_scene
from sunder_tools.pictures.vtp import PolyData
from sunder_tools.replacing import replacing
from sunder_tools.report.scene_text import SCENE_COPY

SAMPLES = 2                 # per pixel and direction
GAP, HEAD = 8, 26           # [px] between panels, and of the line over each
PAPER = np.array([0.98, 0.98, 0.976])
INK = np.array([0.06, 0.12, 0.16])
LETTERS = 15                # [px]
MARGIN = 1.05
AWAY = 0.8                  # sides of triangles: crack lines farther from all points of a sheet are not drawn
NOTHING = np.zeros((0, 2, 3))


@dataclass(frozen=True)
class Box:
    """What of space is seen [m]."""
    low: np.ndarray
    high: np.ndarray

    @staticmethod
    def around(points: Sequence[np.ndarray]) -> "Box":
        """The box of all points (n, 3); the unit cube where there are none."""
        some = [p for p in points if len(p)]
        if not some:
            return Box(np.zeros(3), np.ones(3))
        return Box(np.min([p.min(axis=0) for p in some], axis=0), np.max([p.max(axis=0) for p in some], axis=0))


def sheet_camera(first: PolyData, box: Box, width: int) -> tuple[Camera, int]:
    """A camera straight on a flat sheet that shows the box in a picture `width` wide; also its height [px]."""
    axes = along_normal(reference_points(first), first.triangles, width, width, 1.0).axes
    corners = np.array([[x, y, z] for x in (box.low[0], box.high[0]) for y in (box.low[1], box.high[1])
                        for z in (box.low[2], box.high[2])]) @ axes.T
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = width / (MARGIN * (high[0] - low[0]))
    height = int(np.ceil(scale * MARGIN * (high[1] - low[1])))
    return orthographic_camera(0.5 * (low + high) @ axes, axes[2], -axes[1], scale, scale, width, height), height


def sheet_panel(shell: PolyData, colours: np.ndarray, first: PolyData, box: Box, width: int,
                lines: np.ndarray = NOTHING, at_rest: bool = False) -> Image.Image:
    """Draws a sheet straight on, with a colour 0..1 (n, 3) for each triangle and lines (k, 2, 3) [m] of ink over it.

    With `at_rest` it has its shape at rest. A triangle whose colour is NaN is left out.
    """
    camera, height = sheet_camera(first, box, width * SAMPLES)
    kept = ~np.isnan(colours).any(axis=1)
    pixels, near = camera.project(reference_points(shell) if at_rest else shell.points)
    index = rasterise(pixels, near, shell.triangles[kept], width * SAMPLES, height)[0]
    picture = np.where((index >= 0)[:, None], np.append(colours[kept], [PAPER], axis=0)[index], PAPER)
    draw_lines(picture, camera, lines, width * SAMPLES, height, INK)
    return Image.fromarray(as_bytes(picture.reshape(height, width * SAMPLES, 3))).reduce(SAMPLES)


def draw_lines(picture: np.ndarray, camera: Camera, lines: np.ndarray, width: int, height: int, colour: np.ndarray,
               thick: int = 3) -> None:
    """Draws lines (k, 2, 3) [m] into the pixels (height * width, 3)."""
    if len(lines) == 0:
        return
    (start, near_start), (end, near_end) = (camera.project(lines[:, k]) for k in (0, 1))
    picture[np.unique(line_pixels(start, end, near_start, near_end, width, height, thick)[0])] = colour


def crack_lines(frame: Frame, at_rest: bool = False) -> np.ndarray:
    """Ends (k, 2, 3) [m] of a frame's crack lines and of the borders of its pieces; now without those at no sheet."""
    shell, cracks, out = frame.read(SHELL), frame.read(CRACKS), [NOTHING]
    for mesh, pairs in ((shell, fragment_edges(shell) if shell else None), (cracks, cracks.segments() if cracks else None)):
        if mesh is not None and pairs is not None and len(pairs):
            out.append((reference_points(mesh) if at_rest else mesh.points)[pairs])
    found = np.concatenate(out)
    return found if at_rest or shell is None else found[at_sheet(found, shell)]


def at_sheet(lines: np.ndarray, shell: PolyData) -> np.ndarray:
    """Which of the lines (k, 2, 3) are near a point of the sheet (k,): where a crack gapes, its line is at neither side."""
    if not len(shell.triangles) or not len(lines):
        return np.ones(len(lines), bool)
    sides = np.linalg.norm(shell.points[shell.triangles[:, 0]] - shell.points[shell.triangles[:, 1]], axis=1)
    reach, points = AWAY * float(np.median(sides)), shell.points[np.unique(shell.triangles)]
    points, middles = points[np.argsort(points[:, 0])], lines.mean(axis=1)
    wide = reach * (1.0 + 1e-6)
    begin, end = (np.searchsorted(points[:, 0], middles[:, 0] + side * wide) for side in (-1.0, 1.0))
    return np.array([bool((np.abs(points[b:e] - middle).max(axis=1, initial=0.0) < reach).any())
                     for b, e, middle in zip(begin, end, middles)])


def crack_length(frame: Frame) -> float:
    """Length of a frame's crack lines at rest [m]."""
    cracks = frame.read(CRACKS)
    if cracks is None or not len(cracks.line_points):
        return 0.0
    ends = reference_points(cracks)[cracks.segments()]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())


def growing(frames: list[Frame], shares: Sequence[float]) -> list[Frame]:
    """The first frames in which the cracks have come to these shares of their growth, from the first frame on."""
    length = np.maximum.accumulate([crack_length(frame) for frame in frames])
    grown = (length - length[0]) / max(float(length[-1] - length[0]), 1e-12)
    return [frames[int(np.argmax(grown >= share - 1e-9))] for share in shares]


def at_times(frames: list[Frame], times: Sequence[float]) -> list[Frame]:
    """The frames nearest to these times [s]."""
    return [min(frames, key=lambda frame: abs(frame.time_s - time)) for time in times]


def shell_frames(folder: Path) -> list[Frame]:
    """The frames of a run that have a shell. Raises VtpError, OSError."""
    return [frame for frame in list_frames(folder) if SHELL in frame.files]


def view_panels(folder: Path, frames: list[Frame], size: tuple[int, int], box: Box | None = None, by: str = "part",
                direction: Sequence[float] = DIRECTION) -> list[Image.Image]:
    """Draws frames of a run in perspective, all with one camera. Raises VtpError, OSError."""
    look = Look.of(folder, by)
    scenes = [_on_sheets(load_scene(frame, look), frame) for frame in frames]
    if box is None:
        box = Box.around([points for scene in scenes for points in (
            scene.glass.points, scene.solid.points[np.unique(scene.solid.triangles[~scene.solid.is_floor])], scene.moving)])
    stand_on_floor(folder, scenes, box)
    width, height = size[0] * SAMPLES, size[1] * SAMPLES
    camera = perspective_camera(box.low, box.high, np.asarray(direction, float), width, height)
    return [Image.fromarray(as_bytes(draw_scene(scene, camera, width, height))).reduce(SAMPLES) for scene in scenes]


def stand_on_floor(folder: Path, scenes: list[Scene], box: Box) -> None:
    """Puts scenes whose floor is a half space on a ground as wide as the box: frames have only a part of that floor."""
    heights = [scene.floor_z for scene in scenes if scene.floor_z is not None]
    if heights and "half_space" in (folder / SCENE_COPY).read_text(encoding="utf-8"):
        size = 0.5 * float(np.linalg.norm((box.high - box.low)[:2]))
        for scene in scenes:
            stand(scene, Ground(min(heights), 0.5 * (box.low + box.high)[:2], size))


def _on_sheets(scene: Scene, frame: Frame) -> Scene:
    """The scene without crack lines that no sheet is at."""
    shell = frame.read(SHELL)
    return scene if shell is None else replace(scene, cracks=scene.cracks[at_sheet(scene.cracks, shell)])


def captions(frames: list[Frame]) -> list[str]:
    """The time of each frame."""
    return [moment_text(frame) for frame in frames]


def board(panels: Sequence[Image.Image], words: Sequence[str], columns: int) -> Image.Image:
    """Puts panels of one size into rows, with words over each."""
    width, height = max(p.width for p in panels), max(p.height for p in panels)
    rows = -(-len(panels) // columns)
    paper = tuple(int(255 * c) for c in PAPER)
    sheet = Image.new("RGB", (columns * (width + GAP) + GAP, rows * (height + HEAD + GAP) + GAP), paper)
    for k, (panel, word) in enumerate(zip(panels, words)):
        row, column = divmod(k, columns)
        left, top = GAP + column * (width + GAP), GAP + row * (height + HEAD + GAP)
        sheet.paste(panel, (left, top + HEAD))
        draw_text(sheet, (left + 4, top + 3), word, LETTERS)
    return sheet


def bars(shares: Sequence[tuple[str, float]], width: int, colours: Sequence[tuple[int, int, int]]) -> Image.Image:
    """Draws shares of a whole as horizontal bars, with their names and per cent; one without a name is a gap."""
    high, names = 26, 270
    sheet = Image.new("RGB", (width, GAP + len(shares) * (high + GAP)), tuple(int(255 * c) for c in PAPER))
    draw, top = ImageDraw.Draw(sheet), GAP
    longest = max((share for _, share in shares), default=1.0) or 1.0
    for k, (name, share) in enumerate(shares):
        if not name:  # a gap
            top += GAP
            continue
        draw_text(sheet, (GAP, top + 4), name, LETTERS)
        end = names + int((width - names - 90) * share / longest)
        draw.rectangle([names, top, max(end, names + 1), top + high - 4], fill=colours[k % len(colours)])
        draw_text(sheet, (end + 8, top + 4), f"{100.0 * share:.1f} %", LETTERS)
        top += high + GAP
    return sheet


def save(image: Image.Image, path: Path) -> Path:
    """Writes a PNG so that it is complete or absent. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as part:
        image.save(part, format="PNG", optimize=True)
    return path
