"""Compares cracks that only grow with cracks that would be extracted anew at each stage.

The paper's Fig. 8. The middle line of the damaged region is taken from the written frames alone: elements whose
damage was complete once, as a picture, thinned.
"""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from sunder_tools.pictures.contact_sheet import time_text
from sunder_tools.pictures.flat import along_normal
from sunder_tools.pictures.frames import CRACKS, SHELL, list_frames
from sunder_tools.pictures.lettering import draw_text
from sunder_tools.pictures.meshes import reference_points
from sunder_tools.pictures.raster import Camera, line_pixels, orthographic_camera, rasterise
from sunder_tools.pictures.vtp import PolyData, VtpError

from .crack_check import element_side
from .thinning import closed, grown, share_outside, thinned

WIDTH, GAP, HEAD, CAPTION = 760, 8, 44, 36  # [px]
TALLEST = 760  # [px] largest height of a panel
LARGEST = 20.0  # [px] largest size of an element
ROOM = 2.5  # elements around the shown region
GROWN = (1 / 3, 2 / 3, 1.0)  # shares of all edges that grew, at which the stages are taken
FINE = 0.25  # elements: a middle line that is further away than this has moved
PAPER, SHEET = np.array([0.98, 0.98, 0.976]), np.array([0.93, 0.955, 0.955])
REGION = np.array([0.97, 0.84, 0.74])
STAGE = (np.array([0.05, 0.45, 0.68]), np.array([0.10, 0.50, 0.20]), np.array([0.74, 0.14, 0.50]))
COLOUR = ("blue", "green", "magenta")
GONE = np.array([0.90, 0.08, 0.06])


@dataclass(frozen=True)
class Stage:
    """One stage: the region damaged by then, its middle line, and the cracks."""
    time_s: float
    region: np.ndarray    # (h, w) pixels
    skeleton: np.ndarray  # (h, w) pixels
    cracks: np.ndarray    # (n, 2, 3) edges on the sheet at rest [m]


@dataclass(frozen=True)
class Stages:
    """Three stages, and their view."""
    stages: list[Stage]
    camera: Camera
    sheet: np.ndarray     # (h, w) pixels
    cell: float           # side of an element [px]

    def share_moved(self, cells: float = 1.0) -> float:
        """Returns the share of the first stage's middle line that is further than so many elements from the last
        stage's."""
        return share_outside(self.stages[0].skeleton, self.stages[-1].skeleton, cells * self.cell)


def find_stages(folder: Path) -> Stages:
    """Reads the stages of a run folder. Raises VtpError, OSError."""
    frames: list[tuple[float, PolyData, PolyData]] = []
    for frame in list_frames(folder):
        shell, lines = frame.read(SHELL), frame.read(CRACKS)
        if shell is not None and lines is not None:
            frames.append((frame.time_s, shell, lines))
    grew = [len(lines.line_bounds) - len(frames[1][2].line_bounds) for _, _, lines in frames[1:]]  # cuts come with the second frame
    if not grew or grew[-1] <= 0:
        raise VtpError(f"{folder}: no crack grows")
    chosen = [1 + next(k for k, n in enumerate(grew) if n >= share * grew[-1]) for share in GROWN]
    frames = frames[:chosen[-1] + 1]
    first, last = frames[0][1], frames[-1][2]
    side = element_side(first)
    damaged = [reference_points(shell)[_torn(shell)].reshape(-1, 3) for _, shell, _ in frames]
    camera, height = _camera(first, np.concatenate([*damaged, last.points]), side)
    region = np.zeros((height, WIDTH), bool)
    stages = []
    for k, (time_s, shell, lines) in enumerate(frames):
        # pieces leave the shell, so damage at any earlier time counts
        region |= _painted(shell, _torn(shell), camera, height)
        if k in chosen:
            whole = closed(region)  # cells beside a crack are drawn slightly apart
            stages += [Stage(time_s, whole, thinned(whole), lines.points[lines.segments()])] * chosen.count(k)
    return Stages(stages, camera, _painted(first, first.triangles, camera, height), side * float(camera.scale[0]))


def _torn(shell: PolyData) -> np.ndarray:
    """Selects triangles of elements whose damage has ever been complete."""
    return shell.triangles[shell.of_triangles("c_his", 0.0) >= 1.0]


def _camera(first: PolyData, shown: np.ndarray, side: float) -> tuple[Camera, int]:
    """Looks at the shown region from above, at the width of a panel. Also returns the panel's height [px]."""
    axes = along_normal(reference_points(first), first.triangles, WIDTH, WIDTH, 1.0).axes
    local = shown @ axes.T
    low, high = local.min(axis=0) - ROOM * side, local.max(axis=0) + ROOM * side
    scale = min(WIDTH / (high[0] - low[0]), TALLEST / (high[1] - low[1]), LARGEST / side)
    height = int(np.ceil(scale * (high[1] - low[1])))
    return orthographic_camera(0.5 * (low + high) @ axes, axes[2], -axes[1], scale, scale, WIDTH, height), height


def _painted(mesh: PolyData, triangles: np.ndarray, camera: Camera, height: int) -> np.ndarray:
    pixels, near = camera.project(reference_points(mesh))
    return (rasterise(pixels, near, triangles, WIDTH, height)[0] >= 0).reshape(height, WIDTH)


def write_stages(found: Stages, path: Path) -> None:
    """Draws the stages one below the other: cracks on the left, middle lines on the right. Raises OSError."""
    height = found.sheet.shape[0]
    sheet = Image.new("RGB", (2 * WIDTH + 3 * GAP, HEAD + len(found.stages) * (CAPTION + height + GAP)),
                      tuple(int(255 * c) for c in PAPER))
    draw_text(sheet, (GAP + 4, 10), "cracks as they were cut: what is there stays", 20)
    draw_text(sheet, (WIDTH + 2 * GAP + 4, 10), "middle line of the damage, worked out anew at each stage", 20)
    for k, stage in enumerate(found.stages):
        top = HEAD + k * (CAPTION + height + GAP)
        sheet.paste(_picture(_cracks(found, k)), (GAP, top + CAPTION))
        sheet.paste(_picture(_middle(found, k)), (WIDTH + 2 * GAP, top + CAPTION))
        text = f"{time_text(stage.time_s)}: {len(stage.cracks)} edges"
        text += f", {len(stage.cracks) - len(found.stages[k - 1].cracks)} new ({COLOUR[k]})" if k else f" ({COLOUR[k]})"
        draw_text(sheet, (GAP + 4, top + 8), text, 16)
        if k:
            lost = [share_outside(earlier.skeleton, stage.skeleton, FINE * found.cell) for earlier in found.stages[:k]]
            text = ", ".join(f"{100 * share:.0f} % of the {COLOUR[i]} line" for i, share in enumerate(lost))
            draw_text(sheet, (WIDTH + 2 * GAP + 4, top + 8), f"red: no more within {FINE:g} elements, {text}", 16)
    sheet.save(path)


def _picture(colours: np.ndarray) -> Image.Image:
    return Image.fromarray((np.clip(colours, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8))


def _ground(found: Stages, stage: Stage) -> np.ndarray:
    """Draws the sheet with its damaged region: (h, w, 3) colours."""
    out = np.where(found.sheet[:, :, None], SHEET, PAPER)
    return np.where(stage.region[:, :, None], REGION, out)


def _cracks(found: Stages, k: int) -> np.ndarray:
    """Draws edges in the colour of the stage that first had them."""
    picture = _ground(found, found.stages[k])
    height = picture.shape[0]
    for i in range(k, -1, -1):  # earliest on top
        edges = found.stages[i].cracks
        start, near_start = found.camera.project(edges[:, 0])
        end, near_end = found.camera.project(edges[:, 1])
        picture.reshape(-1, 3)[line_pixels(start, end, near_start, near_end, WIDTH, height, 3)[0]] = STAGE[i]
    return picture


def _middle(found: Stages, k: int) -> np.ndarray:
    """Draws the stage's own middle line, and in red the parts of earlier middle lines that lie elsewhere."""
    picture = _ground(found, found.stages[k])
    own = found.stages[k].skeleton
    for earlier in found.stages[:k]:
        picture[grown(earlier.skeleton & ~grown(own, FINE * found.cell), 1.0)] = GONE
    picture[grown(own, 1.0)] = STAGE[k]
    return picture
