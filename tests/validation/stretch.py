"""Stretch of a sheet, triangle by triangle, from the written frames alone; the paper's Fig. 4."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from sunder_tools.pictures.contact_sheet import time_text
from sunder_tools.pictures.flat import along_normal
from sunder_tools.pictures.frames import SHELL, list_frames
from sunder_tools.pictures.lettering import draw_text
from sunder_tools.pictures.meshes import reference_points
from sunder_tools.pictures.raster import orthographic_camera, rasterise
from sunder_tools.pictures.strain import principal_stretch
from sunder_tools.pictures.vtp import PolyData, VtpError

from .crack_check import element_side

SLIVER = 0.05  # elements: a smaller triangle, where a crack cuts off a corner, is ignored
WIDTH, GAP, HEAD, CAPTION = 620, 8, 44, 30  # [px]
MARGIN = 1.04
MOST = 3.0  # stretch with the last colour; larger ones have the same colour
PAPER, CALM, FAR = np.array([0.98, 0.98, 0.976]), np.array([0.80, 0.87, 0.88]), np.array([0.78, 0.10, 0.08])


@dataclass(frozen=True)
class Stretched:
    """The sheet at one time."""
    time_s: float
    shell: PolyData
    stretch: np.ndarray  # larger principal stretch of each triangle
    side: float          # of an element [m]

    def counted(self) -> np.ndarray:
        """Selects triangles that are no slivers."""
        return _area(self.shell) > SLIVER * self.side ** 2

    def largest(self) -> float:
        return float(self.stretch[self.counted()].max())

    def beyond(self, limit: float) -> float:
        """Returns the area at rest with a larger stretch than the given one, in elements."""
        area = _area(self.shell)
        return float(area[self.counted() & (self.stretch > limit)].sum()) / self.side ** 2


def separated_at(folder: Path) -> float:
    """Returns the time [s] of the first frame with the sheet in several pieces. Raises VtpError."""
    for frame in list_frames(folder):
        shell = frame.read(SHELL)
        if shell is not None and len(np.unique(shell.of_triangles("fragment", 0))) > 1:
            return frame.time_s
    raise VtpError(f"{folder}: the sheet stays whole")


def stretched_at(folder: Path, time_s: float) -> Stretched:
    """Returns the first frame with the shell from that time on. Raises VtpError where there is none, as after
    freezing."""
    side = 0.0
    for frame in list_frames(folder):
        shell = frame.read(SHELL)
        if shell is None:
            continue
        side = side or element_side(shell)
        if frame.time_s >= time_s - 1e-9:
            return Stretched(frame.time_s, shell, principal_stretch(shell), side)
    raise VtpError(f"{folder}: no frame of the shell at {time_s:g} s")


def _area(shell: PolyData) -> np.ndarray:
    corner = reference_points(shell)[shell.triangles]
    return 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)


def write_stretched(found: list[tuple[str, Stretched]], path: Path) -> None:
    """Draws sheets side by side in their present shape, from pale to red with their stretch. Raises OSError."""
    points = np.concatenate([one.shell.points for _, one in found])
    first = found[0][1].shell
    axes = along_normal(reference_points(first), first.triangles, WIDTH, WIDTH, 1.0).axes
    local = points @ axes.T
    low, high = local.min(axis=0), local.max(axis=0)
    scale = WIDTH / (MARGIN * (high[0] - low[0]))
    height = int(np.ceil(scale * MARGIN * (high[1] - low[1])))
    camera = orthographic_camera(0.5 * (low + high) @ axes, axes[2], -axes[1], scale, scale, WIDTH, height)
    sheet = Image.new("RGB", (len(found) * (WIDTH + GAP) + GAP, HEAD + CAPTION + height + GAP),
                      tuple(int(255 * c) for c in PAPER))
    draw_text(sheet, (GAP + 4, 10), f"stretch of a torn sheet, from 1 (pale) to {MOST:g} and more (red)", 20)
    for k, (name, one) in enumerate(found):
        pixels, near = camera.project(one.shell.points)
        index = rasterise(pixels, near, one.shell.triangles, WIDTH, height)[0]
        share = np.clip((one.stretch[index] - 1.0) / (MOST - 1.0), 0.0, 1.0)[:, None]
        colours = np.where((index >= 0)[:, None], CALM + share * (FAR - CALM), PAPER).reshape(height, WIDTH, 3)
        left = GAP + k * (WIDTH + GAP)
        sheet.paste(Image.fromarray((colours * 255.0 + 0.5).astype(np.uint8)), (left, HEAD + CAPTION))
        draw_text(sheet, (left + 4, HEAD), f"{name}, {time_text(one.time_s)}: at most {one.largest():.3g}", 16)
    sheet.save(path)
