"""The middle line of a region of pixels, by thinning: what Fan et al. 2022 take anew at each stage, for Fig. 8 (b)."""
from __future__ import annotations

import numpy as np


def thinned(region: np.ndarray) -> np.ndarray:
    """The skeleton of a region (h, w) of true pixels, one pixel wide (Zhang and Suen 1984)."""
    now = np.pad(region.astype(bool), 1)
    while True:
        before = now.copy()
        for first in (True, False):
            now = now & ~_removable(now, first)
        if np.array_equal(now, before):
            return now[1:-1, 1:-1]


def _removable(now: np.ndarray, first: bool) -> np.ndarray:
    """The pixels that one half of an iteration takes away: on the border, no end of a line, no link."""
    # neighbours clockwise from above
    p2, p3, p4, p5, p6, p7, p8, p9 = ring = [np.roll(now, shift, (0, 1)) for shift in (
        (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1), (1, 1))]
    count = np.sum(ring, axis=0)
    turns = np.sum([~a & b for a, b in zip(ring, [*ring[1:], ring[0]])], axis=0)
    if first:
        sides = ~(p2 & p4 & p6) & ~(p4 & p6 & p8)
    else:
        sides = ~(p2 & p4 & p8) & ~(p2 & p6 & p8)
    del p3, p5, p7, p9
    return now & (count >= 2) & (count <= 6) & (turns == 1) & sides


def grown(region: np.ndarray, pixels: int) -> np.ndarray:
    """The region and all within so many pixels of it, along either side."""
    out = region
    for axis in (0, 1):
        out = np.any([_shifted(out, k, axis) for k in range(-pixels, pixels + 1)], axis=0)
    return out


def _shifted(region: np.ndarray, by: int, axis: int) -> np.ndarray:
    out = np.roll(region, by, axis)
    edge = [slice(None), slice(None)]
    edge[axis] = slice(0, by) if by > 0 else slice(by, None) if by < 0 else slice(0, 0)
    out[tuple(edge)] = False
    return out


def moved(earlier: np.ndarray, later: np.ndarray, pixels: int) -> float:
    """The share of an earlier line that the later one has no pixel near, within so many pixels; 0 where there is none."""
    return float((earlier & ~grown(later, pixels)).sum() / max(int(earlier.sum()), 1))
