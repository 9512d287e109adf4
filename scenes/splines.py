"""Quadratic B-splines over knots 0, 0, 0, ... n, n, n: knot insertion and values, as the solver computes them at
load."""
from __future__ import annotations

import numpy as np


def open_knots(spans: int) -> np.ndarray:
    """Returns 0, 0, 0, 1, 2, ... n, n, n."""
    return np.concatenate([[0.0, 0.0], np.arange(spans + 1), [float(spans)] * 2])


def with_knot(knots: np.ndarray, rows: np.ndarray, knot: float) -> tuple[np.ndarray, np.ndarray]:
    """Inserts one knot without changing the curves (Boehm 1980). `rows` (n, ...) are control points along the first
    axis."""
    k = int(np.searchsorted(knots, knot, side="right")) - 1
    new = []
    for i in (k - 1, k):
        a = (knot - knots[i]) / (knots[i + 2] - knots[i])
        new.append((1.0 - a) * rows[i - 1] + a * rows[i])
    return np.insert(knots, k + 1, knot), np.concatenate([rows[:k - 1], np.stack(new), rows[k:]])


def refined(knots: np.ndarray, rows: np.ndarray, elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Divides spans into equal parts until none is longer than the domain divided by `elements`."""
    longest = (knots[-1] - knots[0]) / elements
    marks = np.unique(knots)
    for a, b in zip(marks, marks[1:]):
        pieces = max(1, int(np.ceil((b - a) / longest - 1e-9)))
        for i in range(1, pieces):
            knots, rows = with_knot(knots, rows, a + (b - a) * i / pieces)
    return knots, rows


def basis(knots: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Evaluates all functions and their first derivatives at parameters (m,): two arrays (m, n)."""
    n = len(knots) - 3
    value, slope = np.zeros((len(at), n)), np.zeros((len(at), n))
    for row, u in enumerate(at):
        s = int(np.clip(np.searchsorted(knots, u, side="right") - 3, 0, n - 3))
        a, b, c, d = knots[s + 1:s + 5]
        low, high, line = (u - a) / (c - a), (u - b) / (d - b), (u - b) / (c - b)
        value[row, s:s + 3] = (1 - line) * (1 - low), (1 - line) * low + line * (1 - high), line * high
        slope[row, s:s + 3] = -2 * (1 - line) / (c - a), 2 * ((1 - line) / (c - a) - line / (d - b)), 2 * line / (d - b)
    return value, slope
