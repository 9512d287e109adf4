"""Radial cracks: their crossings of a circle."""
from __future__ import annotations

import math

import numpy as np

RADIAL = math.cos(math.radians(45.0))  # an edge within 45 degrees of the radius is radial


def radial_crossings(ends: np.ndarray, centre: np.ndarray, radius: float) -> np.ndarray:
    """Returns the angles [rad], sorted, at which edges (n, 2, 2) within 45 degrees of the radius cross a circle."""
    local = ends - centre
    along = local[:, 1] - local[:, 0]
    middle = local.mean(axis=1)
    a = (along ** 2).sum(axis=1)
    b = (local[:, 0] * along).sum(axis=1)
    c = (local[:, 0] ** 2).sum(axis=1) - radius ** 2
    straight = np.abs((along * middle).sum(axis=1)) >= RADIAL * np.sqrt(a) * np.linalg.norm(middle, axis=1)
    crosses = straight & (a > 0.0) & ((c < 0.0) != ((local[:, 1] ** 2).sum(axis=1) < radius ** 2))
    share = np.zeros(len(ends))
    root = np.sqrt(np.maximum(b ** 2 - a * c, 0.0))
    np.divide(np.where(c < 0.0, -b + root, -b - root), a, out=share, where=crosses)
    at = (local[:, 0] + share[:, None] * along)[crosses]
    return np.sort(np.arctan2(at[:, 1], at[:, 0]))
