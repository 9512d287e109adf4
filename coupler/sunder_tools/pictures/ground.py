"""The ground of a picture: a level plane that fades into the background. It is drawn only; no body touches it."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .raster import Camera

COLOUR = np.array([0.87, 0.87, 0.86])
FADE = (1.1, 2.6)   # distances from the middle between which it fades, over its size
LINES = 0.6         # its lines are a power of ten apart, the largest below this share of its size


@dataclass(frozen=True)
class Ground:
    """A plane at height z [m] around `centre` (2,), which fades over some times `size` [m]."""
    z: float
    centre: np.ndarray
    size: float

    def nearness(self, camera: Camera, first_row: int, rows: int, width: int) -> np.ndarray:
        """Returns the nearness of the plane at the pixels of some rows, flat; -inf where it is not seen from above."""
        if not camera.perspective or camera.eye[2] <= self.z:
            return np.full(rows * width, -np.inf)
        right = (np.arange(width) + 0.5 - camera.centre[0]) / camera.scale[0] * camera.axes[0, 2]
        down = (np.arange(first_row, first_row + rows) + 0.5 - camera.centre[1]) / camera.scale[1] * camera.axes[1, 2]
        near = ((down[:, None] + right + camera.axes[2, 2]) / (self.z - camera.eye[2])).ravel()
        near[near <= 0.0] = -np.inf
        return near

    def colours(self, points: np.ndarray, pixel_m: np.ndarray, behind: np.ndarray, dark: np.ndarray) -> np.ndarray:
        """Returns colours at points of the plane: its lines, shadows `dark` (n,) 0..1, and what is `behind` far away.
        `pixel_m` is the size of a pixel there [m]."""
        away = np.hypot(points[:, 0] - float(self.centre[0]), points[:, 1] - float(self.centre[1])) / self.size
        share = np.minimum(np.maximum((away - FADE[0]) / (FADE[1] - FADE[0]), 0.0), 1.0)
        share = (share * share * (3.0 - 2.0 * share))[:, None]
        own = COLOUR.astype(points.dtype) * ((1.0 - 0.09 * lines(points, pixel_m, self.spacing)) * (1.0 - dark))[:, None]
        return own + share * (behind - own)

    @property
    def spacing(self) -> float:
        """Distance between its lines [m]."""
        return float(10.0 ** np.floor(np.log10(LINES * self.size)))


def lines(points: np.ndarray, pixel_m: np.ndarray, spacing: float) -> np.ndarray:
    """Returns how far points (n, 3) are on a line of the grid, 0..1, a pixel wide."""
    x, y = points[:, 0] / spacing, points[:, 1] / spacing
    off = np.minimum(np.abs(x - np.rint(x)), np.abs(y - np.rint(y))) * spacing  # [m] from a line
    return np.minimum(np.maximum(1.2 - off / pixel_m, 0.0), 1.0)
