"""Borders of joined shells: where two shells go on as one surface there is nothing to see, though the mesh of each ends."""
from __future__ import annotations

import numpy as np

from .motion import reference_points
from .vtp import PolyData

NEAR = 0.1  # of the usual length of a border's line: two shells whose lines do not match follow a curved seam so closely


def off_seams(mesh: PolyData, lines: np.ndarray) -> np.ndarray:
    """Returns those lines (k, 2) of a mesh's borders along which no other shell goes on with the same fragment, neither at rest
    nor as it has moved."""
    shell, fragment = (np.zeros(len(mesh.points), np.int64) for _ in range(2))
    for of_point, name in ((shell, "shell"), (fragment, "fragment")):
        of_point[mesh.triangles.ravel()] = np.repeat(mesh.of_triangles(name, 0).astype(np.int64), 3)
    part, label = shell[lines[:, 0]], fragment[lines[:, 0]]
    if not len(lines) or part.min() == part.max():
        return lines
    joined = np.ones(len(lines), bool)
    for points in (reference_points(mesh), mesh.points):
        ends = points[lines]
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        joined &= _beside(ends, np.column_stack([part, label]), NEAR * float(np.median(length)), length)
    return lines[~joined]


def _beside(ends: np.ndarray, owner: np.ndarray, near: float, length: np.ndarray) -> np.ndarray:
    """Which lines (k, 2, 3) have their middle as near as `near` to 2 near to a line of another part, `owner` (k, 2) being the
    part and the label of each, and with the same label."""
    if not near > 0.0:
        return np.zeros(len(ends), bool)
    count = np.minimum(np.ceil(length / near).astype(int) + 1, 64)
    of_line = np.repeat(np.arange(len(ends)), count)
    along = (np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)) / np.maximum(count - 1, 1)[of_line]
    samples = ends[of_line, 0] + along[:, None] * (ends[of_line, 1] - ends[of_line, 0])
    low = ends.min(axis=(0, 1))
    cells = np.floor((samples - low) / near).astype(np.int64) + 1
    middle = np.floor((ends.mean(axis=1) - low) / near).astype(np.int64) + 1
    size = cells.max(axis=0) + 2
    labels = np.unique(owner[:, 1], return_inverse=True)[1].reshape(-1)

    def key(cell: np.ndarray, label: np.ndarray) -> np.ndarray:
        return ((label * size[0] + cell[:, 0]) * size[1] + cell[:, 1]) * size[2] + cell[:, 2]

    keys = key(cells, labels[of_line])
    order = np.argsort(keys, kind="stable")
    there, starts = np.unique(keys[order], return_index=True)
    part = owner[of_line[order], 0]
    least, most = np.minimum.reduceat(part, starts), np.maximum.reduceat(part, starts)
    found = np.zeros(len(ends), bool)
    for step in np.ndindex(3, 3, 3):
        wanted = key(middle + np.array(step) - 1, labels)
        at = np.minimum(np.searchsorted(there, wanted), len(there) - 1)
        hit = there[at] == wanted
        found |= hit & ((least[at] != owner[:, 0]) | (most[at] != owner[:, 0]))
    return found
