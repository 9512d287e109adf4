"""Colours of pictures: parts of a scene with several shells, fragments, and quantities."""
from __future__ import annotations

import numpy as np

GLASS = np.array([0.56, 0.79, 0.79])
PARTS = np.array([  # muted and of similar lightness, so that shading shows the shape
    [0.42, 0.47, 0.53], [0.73, 0.57, 0.50], [0.62, 0.68, 0.60], [0.76, 0.70, 0.59], [0.56, 0.62, 0.70], [0.66, 0.57, 0.63],
    [0.70, 0.61, 0.54], [0.71, 0.64, 0.58], [0.58, 0.64, 0.61], [0.61, 0.66, 0.64], [0.65, 0.67, 0.72], [0.68, 0.69, 0.73],
])
# light grey over yellow and red to dark, readable in grey too; coupler/viewer/colours.js has the same
STOPS = np.array([
    [0.88, 0.90, 0.91], [0.95, 0.80, 0.47], [0.89, 0.49, 0.27], [0.69, 0.19, 0.25], [0.29, 0.06, 0.20]])
GOLDEN = 0.6180339887498949  # its multiples, modulo 1, are evenly spread


def varied(ids: np.ndarray, base: np.ndarray, amount: float) -> np.ndarray:
    """Varies the lightness of `base` by up to `amount`, in the same way for the same id; id 0 gives `base`."""
    golden = np.modf(np.asarray(ids, float) * GOLDEN)[0]
    tone = np.where(np.asarray(ids) == 0, 0.0, 2.0 * golden - 1.0)
    tint = np.stack([tone, 0.6 * tone, 0.4 * tone], axis=1)
    return np.clip(base * (1.0 + amount * tint), 0.0, 1.0)


def pastel(ids: np.ndarray) -> np.ndarray:
    """Returns colours (n, 3) that differ clearly for neighbouring ids."""
    hue = np.modf(np.asarray(ids, float) * GOLDEN)[0] * 2.0 * np.pi
    return 0.72 + 0.20 * np.cos(hue[:, None] - np.array([0.0, 2.0943951, 4.1887902]))


def ramp(share: np.ndarray) -> np.ndarray:
    """Returns colours (n, 3) for shares (n,) of the largest value."""
    at = np.clip(share, 0.0, 1.0) * (len(STOPS) - 1)
    return np.stack([np.interp(at, np.arange(len(STOPS)), STOPS[:, axis]) for axis in range(3)], axis=1)


def part_colours(part: np.ndarray, glass: tuple[bool, ...]) -> np.ndarray:
    """Returns colours (n, 3) for shell numbers (n,); `glass` lists the shells that are known to be glass."""
    colours = PARTS[part % len(PARTS)]
    colours[is_glass(part, glass)] = GLASS
    return colours


def is_glass(part: np.ndarray, glass: tuple[bool, ...]) -> np.ndarray:
    """Tests which of the shell numbers (n,) are glass."""
    known = np.zeros(int(part.max(initial=0)) + 1, bool)
    known[:min(len(glass), len(known))] = glass[:len(known)]
    return known[part]
