"""Columns of a run's CSV files."""
from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

MOST_POINTS = 2000  # of a curve; peaks are kept when there are more


def read_columns(path: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV with a line of names; whole rows only: the last may be half written. {} if there is no file."""
    try:
        with path.open(newline="") as source:
            rows = list(csv.reader(line for line in source if line.endswith("\n")))
    except OSError:
        return {}
    if not rows:
        return {}
    good = []
    for row in rows[1:]:
        try:
            good.append([float(x) for x in row])
        except ValueError:
            continue
        if len(row) != len(rows[0]):
            good.pop()
    values = np.array(good, float).reshape(-1, len(rows[0]))
    return {name: values[:, k] for k, name in enumerate(rows[0])}


def thin(time: np.ndarray, values: np.ndarray, most: int = MOST_POINTS) -> tuple[np.ndarray, np.ndarray]:
    """At most about `most` of the points, among them lowest and highest of every stretch, first and last."""
    if len(time) <= most:
        return time, values
    parts = np.array_split(np.arange(len(time)), most // 2)
    safe = np.where(np.isfinite(values), values, 0.0)
    kept = np.unique([0, len(time) - 1, *(int(p[0]) + int(f(safe[p])) for p in parts for f in (np.argmin, np.argmax))])
    return time[kept], values[kept]
