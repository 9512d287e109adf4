"""modes.png: a picture of each mode of `sunder modes`, with its frequency."""
from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from PIL import Image

from ..launch.modes_folder import SHEET, TABLE
from ..replacing import replacing
from .frames import list_frames
from .lettering import draw_text
from .look import Look
from .meshes import load_scene
from .raster import perspective_camera
from .views import as_bytes, draw_scene
from .vtp import VtpError

COLUMNS = 4
PANEL = (400, 320)  # [px]
GAP = 8             # [px]
SAMPLES = 2         # per pixel and direction
MOST = 24           # modes that are drawn
DIRECTION = np.array([-0.42, 0.80, -0.46])  # of view
PAPER = (250, 250, 249)


def write_modes_sheet(folder: Path) -> Path:
    """Draws folder/modes.png and returns its path. Raises VtpError, OSError."""
    told = json.loads((folder / TABLE).read_text())
    frames = list_frames(folder)[:MOST]
    if not frames:
        raise VtpError(f"{folder}/frames.pvd: no mode to draw")
    look = Look.of(folder)
    scenes = [load_scene(frame, look) for frame in frames]
    points = np.concatenate([surface.points[np.unique(surface.triangles)] for scene in scenes
                             for surface in (scene.glass, scene.solid)])
    low, high = points.min(axis=0), points.max(axis=0)
    columns = min(COLUMNS, len(frames))
    rows = -(-len(frames) // columns)
    head = 40
    sheet = Image.new("RGB", (columns * (PANEL[0] + GAP) + GAP, head + rows * (PANEL[1] + GAP) + GAP), PAPER)
    size = (PANEL[0] * SAMPLES, PANEL[1] * SAMPLES)
    for k, (scene, mode) in enumerate(zip(scenes, told["modes"])):
        view = Image.fromarray(as_bytes(draw_scene(scene, perspective_camera(low, high, DIRECTION, *size), *size)))
        view = view.reduce(SAMPLES)
        draw_text(view, (10, 6), f"{mode['mode']}: {frequency_text(mode['frequency_Hz'])}", 18)
        row, column = divmod(k, columns)
        sheet.paste(view, (GAP + column * (PANEL[0] + GAP), head + GAP + row * (PANEL[1] + GAP)))
    draw_text(sheet, (GAP + 4, 10), f"{told['name']}     drawn with {told['drawn_amplitude_m'] * 1e3:.3g} mm", 20)
    target = folder / SHEET
    with replacing(target) as part:
        sheet.save(part)
    return target


def frequency_text(frequency: float | None) -> str:
    """'35.2 Hz', '1.25 kHz' or 'unstable'."""
    if frequency is None:
        return "unstable"
    return f"{frequency * 1e-3:.4g} kHz" if frequency >= 1e3 else f"{frequency:.4g} Hz"
