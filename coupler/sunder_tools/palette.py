"""Colours of the parts of a scene with several shells: calm, and apart from their neighbours in number."""
from __future__ import annotations

import numpy as np

GLASS = np.array([0.56, 0.79, 0.79])
PARTS = np.array([  # muted, of much the same lightness, so that shape is read from the light
    [0.42, 0.47, 0.53], [0.80, 0.55, 0.46], [0.62, 0.70, 0.58], [0.83, 0.74, 0.56], [0.56, 0.62, 0.73], [0.71, 0.57, 0.66],
    [0.76, 0.63, 0.52], [0.76, 0.66, 0.58], [0.60, 0.67, 0.63], [0.63, 0.69, 0.66], [0.68, 0.70, 0.76], [0.72, 0.73, 0.77],
])


def part_colours(part: np.ndarray, glass: tuple[bool, ...] = ()) -> np.ndarray:
    """(n, 3) of shell numbers (n,), 0..1; `glass`: which shells are, as far as known."""
    colours = PARTS[part % len(PARTS)]
    colours[is_glass(part, glass)] = GLASS
    return colours


def is_glass(part: np.ndarray, glass: tuple[bool, ...]) -> np.ndarray:
    """(n,) of shell numbers (n,)."""
    known = np.zeros(int(part.max(initial=0)) + 1, bool)
    known[:min(len(glass), len(known))] = glass[:len(known)]
    return known[part]
