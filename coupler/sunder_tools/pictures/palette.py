"""Colours of pictures: parts of a scene with several shells, fragments, and quantities."""
from __future__ import annotations

import numpy as np

GLASS = np.array([0.56, 0.79, 0.79])
PARTS = np.array([  # muted, of much the same lightness, so that shape is read from the light
    [0.42, 0.47, 0.53], [0.73, 0.57, 0.50], [0.62, 0.68, 0.60], [0.76, 0.70, 0.59], [0.56, 0.62, 0.70], [0.66, 0.57, 0.63],
    [0.70, 0.61, 0.54], [0.71, 0.64, 0.58], [0.58, 0.64, 0.61], [0.61, 0.66, 0.64], [0.65, 0.67, 0.72], [0.68, 0.69, 0.73],
])
STOPS = np.array([  # light grey over yellow and red to dark: reads in grey as well; coupler/viewer/colours.js has the same
    [0.88, 0.90, 0.91], [0.95, 0.80, 0.47], [0.89, 0.49, 0.27], [0.69, 0.19, 0.25], [0.29, 0.06, 0.20]])
GOLDEN = 0.6180339887498949  # multiples of it, modulo 1, are spread evenly


def varied(ids: np.ndarray, base: np.ndarray, amount: float) -> np.ndarray:
    """`base` made lighter or darker by up to `amount`, always the same for the same id; id 0 is `base`."""
    golden = np.modf(np.asarray(ids, float) * GOLDEN)[0]
    tone = np.where(np.asarray(ids) == 0, 0.0, 2.0 * golden - 1.0)
    tint = np.stack([tone, 0.6 * tone, 0.4 * tone], axis=1)
    return np.clip(base * (1.0 + amount * tint), 0.0, 1.0)


def pastel(ids: np.ndarray) -> np.ndarray:
    """(n, 3): plainly different for neighbouring ids."""
    hue = np.modf(np.asarray(ids, float) * GOLDEN)[0] * 2.0 * np.pi
    return 0.72 + 0.20 * np.cos(hue[:, None] - np.array([0.0, 2.0943951, 4.1887902]))


def ramp(share: np.ndarray) -> np.ndarray:
    """(n, 3) of shares (n,) of the highest value."""
    at = np.clip(share, 0.0, 1.0) * (len(STOPS) - 1)
    return np.stack([np.interp(at, np.arange(len(STOPS)), STOPS[:, axis]) for axis in range(3)], axis=1)


def part_colours(part: np.ndarray, glass: tuple[bool, ...]) -> np.ndarray:
    """(n, 3) of shell numbers (n,); `glass`: which shells are, as far as known."""
    colours = PARTS[part % len(PARTS)]
    colours[is_glass(part, glass)] = GLASS
    return colours


def is_glass(part: np.ndarray, glass: tuple[bool, ...]) -> np.ndarray:
    """(n,) of shell numbers (n,)."""
    known = np.zeros(int(part.max(initial=0)) + 1, bool)
    known[:min(len(glass), len(known))] = glass[:len(known)]
    return known[part]
