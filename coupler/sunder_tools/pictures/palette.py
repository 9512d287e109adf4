"""Colours of pictures: parts of a scene with several shells, fragments, and quantities."""
from __future__ import annotations

import numpy as np

from ..report import appearance

GLASS, STEEL = np.array(appearance.GLASS.colour), np.array(appearance.STEEL.colour)
PARTS = np.array(appearance.UNKNOWN)  # PARTS: of shells that the scene does not tell about
# light grey over yellow and red to dark, readable in grey too; coupler/viewer/colours.js has the same
STOPS = np.array([
    [0.88, 0.90, 0.91], [0.95, 0.80, 0.47], [0.89, 0.49, 0.27], [0.69, 0.19, 0.25], [0.29, 0.06, 0.20]])
GOLDEN = 0.6180339887498949  # its multiples, modulo 1, are evenly spread


def varied(ids: np.ndarray, base: np.ndarray, amount: float) -> np.ndarray:
    """Varies the lightness of `base` by up to `amount`, in the same way for the same id; id 0 gives `base`."""
    golden = np.modf(np.asarray(ids, float) * GOLDEN)[0]
    tone = np.where(np.asarray(ids) == 0, 0.0, 2.0 * golden - 1.0)
    return np.clip(base * (1.0 + amount * tone[:, None]), 0.0, 1.0)


def pastel(ids: np.ndarray) -> np.ndarray:
    """Returns colours (n, 3) that differ clearly for neighbouring ids."""
    hue = np.modf(np.asarray(ids, float) * GOLDEN)[0] * 2.0 * np.pi
    return 0.72 + 0.20 * np.cos(hue[:, None] - np.array([0.0, 2.0943951, 4.1887902]))


def ramp(share: np.ndarray) -> np.ndarray:
    """Returns colours (n, 3) for shares (n,) of the largest value."""
    at = np.clip(share, 0.0, 1.0) * (len(STOPS) - 1)
    return np.stack([np.interp(at, np.arange(len(STOPS)), STOPS[:, axis]) for axis in range(3)], axis=1)


def part_colours(part: np.ndarray, known: tuple[tuple[float, ...], ...]) -> np.ndarray:
    """Returns colours (n, 3) for shell numbers (n,), of which the first have `known` colours."""
    table = PARTS[np.arange(max(int(part.max(initial=0)) + 1, len(known))) % len(PARTS)]
    table[:len(known)] = np.array(known).reshape(-1, 3)
    return table[part]


def is_glass(part: np.ndarray, glass: tuple[bool, ...]) -> np.ndarray:
    """Tests which of the shell numbers (n,) are glass."""
    known = np.zeros(int(part.max(initial=0)) + 1, bool)
    known[:min(len(glass), len(known))] = glass[:len(known)]
    return known[part]
