"""Skeletons of binary pictures, with numpy only."""
from __future__ import annotations

import numpy as np


def thinned(image: np.ndarray) -> np.ndarray:
    """Returns the skeleton of (h, w) booleans: one pixel wide, and connected where the picture is (Zhang and Suen
    1984)."""
    work = np.pad(np.asarray(image, bool), 1)
    while True:
        before = int(work.sum())
        for first in (True, False):
            n, ne, e, se, s, sw, w, nw = _around(work)
            ring = np.stack([n, ne, e, se, s, sw, w, nw])
            count = ring.sum(axis=0)
            rises = (~ring & np.roll(ring, -1, axis=0)).sum(axis=0)
            loose = (count >= 2) & (count <= 6) & (rises == 1)
            loose &= ~(n & e & s) & ~(e & s & w) if first else ~(n & e & w) & ~(n & s & w)
            work[1:-1, 1:-1] &= ~loose
        if int(work.sum()) == before:
            return work[1:-1, 1:-1]


def _around(work: np.ndarray) -> tuple[np.ndarray, ...]:
    """Returns the eight neighbours of all pixels inside the rim, clockwise from above."""
    h, w = work.shape
    return tuple(work[1 + i:h - 1 + i, 1 + j:w - 1 + j]
                 for i, j in ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1)))


def grown(image: np.ndarray, radius: float) -> np.ndarray:
    """Sets all pixels within `radius` [px] of a set pixel."""
    reach = int(radius)
    h, w = image.shape
    sums = np.cumsum(np.pad(np.asarray(image, np.int32), ((reach, reach), (reach + 1, reach))), axis=1)
    out = np.zeros((h, w), bool)
    for i in range(-reach, reach + 1):  # a disc consists of rows of different widths
        half = int((radius * radius - i * i) ** 0.5)
        row = sums[reach + i:reach + i + h]
        out |= row[:, reach + half + 1:reach + half + 1 + w] > row[:, reach - half:reach - half + w]
    return out


def closed(image: np.ndarray) -> np.ndarray:
    """Closes holes and clefts narrower than two pixels."""
    return ~grown(~grown(image, 1.5), 1.5) | np.asarray(image, bool)


def share_outside(image: np.ndarray, other: np.ndarray, radius: float) -> float:
    """Returns the share of `image`'s pixels further than `radius` [px] from every pixel of `other`; NaN where there
    is none."""
    count = int(image.sum())
    return int((image & ~grown(other, radius)).sum()) / count if count else float("nan")
