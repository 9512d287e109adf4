"""A picture of what `sunder inspect` sees: shells in colours, edges that they share, free edges and gaps."""
from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from ..errors import BAD_INPUT, CommandError
from ..replacing import replacing
from ..report.gaps import Gap
from .frames import list_frames
from .lettering import draw_text
from .look import Look
from .meshes import load_scene
from .raster import Camera, perspective_camera
from .views import as_bytes, draw_scene

SIZE = (1280, 900)  # [px]
SAMPLES = 2         # per pixel and direction
DIRECTION = np.array([-0.42, 0.80, -0.46])  # of view
SHARED, FREE, REFUSED, GAP = (40, 60, 80), (214, 120, 20), (190, 30, 40), (220, 0, 120)
WIDTH, MARK = 2, 7  # [px] of lines, radius of a mark of a gap


def draw_inspected(folder: Path, told: dict[str, Any], gaps: list[Gap], target: Path) -> None:
    """Draws the only frame in `folder`, the shells of a file, with edges over it, to `target`. Without a frame there are edges
    alone. Raises VtpError, OSError, and CommandError where there is neither, as of a closed mesh that is refused."""
    frames = list_frames(folder) if (folder / "frames.pvd").exists() else []
    lines = lines_of(told)
    points = [np.concatenate([line for line, _ in lines])] if lines else []
    scene = None
    if frames:
        scene = load_scene(frames[0], Look("fragment", glass=(False,) * 2))
        points += [surface.points[np.unique(surface.triangles)] for surface in (scene.glass, scene.solid)]
    if not points:
        raise CommandError(f"--picture {target}: there is nothing to draw: no shell can be made, and there is no edge to show; mend "
                           "what is refused, or leave --picture out", BAD_INPUT)
    every = np.concatenate(points)
    size = (SIZE[0] * SAMPLES, SIZE[1] * SAMPLES)
    camera = perspective_camera(every.min(axis=0), every.max(axis=0), DIRECTION, *size)
    if scene is not None:
        picture = Image.fromarray(as_bytes(draw_scene(scene, camera, *size)))
    else:
        picture = Image.new("RGB", size, (250, 250, 249))
    draw = ImageDraw.Draw(picture)
    for line, colour in lines:
        draw.line(_pixels(camera, line), fill=colour, width=WIDTH * SAMPLES)
    for gap in gaps:
        (x, y), = _pixels(camera, np.array([gap.at_m]))
        draw.ellipse((x - MARK * SAMPLES, y - MARK * SAMPLES, x + MARK * SAMPLES, y + MARK * SAMPLES), outline=GAP,
                     width=WIDTH * SAMPLES)
    picture = picture.reduce(SAMPLES)
    words = [(word, colour) for word, colour in (("shared edges", SHARED), ("free edges", FREE), ("of refused faces", REFUSED))
             if any(colour == own for _, own in lines)]
    words += [("gaps", GAP)] if gaps else []
    legend = ImageDraw.Draw(picture)
    for k, (word, colour) in enumerate(words):
        legend.rectangle((14, 20 + 24 * k, 38, 24 + 24 * k), fill=colour)
        draw_text(picture, (46, 12 + 24 * k), word, 16)
    with replacing(target) as part:
        picture.save(part)


def lines_of(told: dict[str, Any]) -> list[tuple[np.ndarray, tuple[int, int, int]]]:
    """Returns polylines (n, 3) [m] with their colours, shared edges first: a free one on top is seen."""
    if "charts" in told:
        return [(np.array(border), FREE) for border in told["borders_m"]]
    refused = {face["face"] for face in told["faces"] if face["refused"] is not None}
    out = [(np.array(edge["points_m"]), REFUSED if refused.intersection(edge["faces"]) else
            SHARED if len(edge["faces"]) > 1 else FREE) for edge in told["edges"]["list"]]
    return sorted(out, key=lambda line: [SHARED, FREE, REFUSED].index(line[1]))


def _pixels(camera: Camera, points: np.ndarray) -> list[tuple[float, float]]:
    pixels, _ = camera.project(points)
    return [(float(x), float(y)) for x, y in pixels if np.isfinite([x, y]).all()]
