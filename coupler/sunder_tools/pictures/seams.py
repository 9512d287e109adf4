"""Borders of joined shells: where two shells go on as one surface there is nothing to see, though the mesh of each ends."""
from __future__ import annotations

import numpy as np

from .motion import reference_points
from .vtp import PolyData

NEAR = 0.1  # of the length of a line or of the usual side of a triangle: so closely do two shells' lines follow a curved seam
OPEN = 0.05  # of that length: the most by which the two sides of a seam that holds have moved apart
MOST_SAMPLES = 400  # of a line beside much shorter ones


def off_seams(mesh: PolyData, lines: np.ndarray) -> np.ndarray:
    """Returns those lines (k, 2) of a mesh's borders along which no other shell goes on with the same fragment: one whose
    border is as near at rest, and has moved with it."""
    shell, fragment = (np.zeros(len(mesh.points), np.int64) for _ in range(2))
    for of_point, name in ((shell, "shell"), (fragment, "fragment")):
        of_point[mesh.triangles.ravel()] = np.repeat(mesh.of_triangles(name, 0).astype(np.int64), 3)
    part, label = shell[lines[:, 0]], fragment[lines[:, 0]]
    if not len(lines) or part.min() == part.max():
        return lines
    rest = reference_points(mesh)
    moved = mesh.points - rest
    length = np.linalg.norm(rest[lines[:, 1]] - rest[lines[:, 0]], axis=1)
    joined = np.zeros(len(lines), bool)
    usual = _usual_side(rest[mesh.triangles])
    if not usual > 0.0:
        return lines
    size = np.ceil(np.log2(np.maximum(length, usual)))  # lines of similar lengths are asked together
    for one in np.unique(size):
        asked = np.flatnonzero(size == one)
        joined[asked] = _joined(rest[lines], moved[lines], length, np.column_stack([part, label]), asked, 2.0 ** one)
    return lines[~joined]


def _usual_side(corners: np.ndarray) -> float:
    """Mean of the square roots of twice the areas of triangles (m, 3, 3), by area: slivers do not count."""
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return float((area * np.sqrt(2.0 * area)).sum() / max(area.sum(), 1e-300))


def _joined(ends: np.ndarray, moved: np.ndarray, length: np.ndarray, owner: np.ndarray, asked: np.ndarray,
            scale: float) -> np.ndarray:
    """Which of the lines `asked` have a line of another part, with the same label, beside their middle and moving with it.

    `ends`, `moved` (k, 2, 3): places at rest and displacements; `owner` (k, 2): part and label; `scale`: length of the lines.
    """
    near, middle = NEAR * scale, ends[asked].mean(axis=1)
    low, high = middle.min(axis=0) - 2.0 * near, middle.max(axis=0) + 2.0 * near
    there = np.flatnonzero((ends.max(axis=1) >= low).all(axis=1) & (ends.min(axis=1) <= high).all(axis=1))
    count = np.minimum(np.ceil(length[there] / near).astype(int) + 1, MOST_SAMPLES)
    of_line = np.repeat(np.arange(len(there)), count)
    along = ((np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count))
             / np.maximum(count - 1, 1)[of_line])[:, None]
    of_line = there[of_line]
    places = ends[of_line, 0] + along * (ends[of_line, 1] - ends[of_line, 0])
    shifts = moved[of_line, 0] + along * (moved[of_line, 1] - moved[of_line, 0])
    cells = np.floor((places - low) / near).astype(np.int64) + 1
    inside = ((cells >= 0) & (places <= high + near)).all(axis=1)
    cells, places, shifts, of_line = cells[inside], places[inside], shifts[inside], of_line[inside]
    extent = np.floor((high - low) / near).astype(np.int64) + 4
    key = np.ravel_multi_index(cells.T, extent, mode="clip")
    order = np.argsort(key, kind="stable")
    key = key[order]
    at = np.floor((middle - low) / near).astype(np.int64) + 1
    shift, found = moved[asked].mean(axis=1), np.zeros(len(asked), bool)
    for step in np.ndindex(3, 3, 3):
        wanted = np.ravel_multi_index((at + np.array(step) - 1).T, extent, mode="clip")
        first, last = np.searchsorted(key, wanted, "left"), np.searchsorted(key, wanted, "right")
        for k in range(int((last - first).max(initial=0))):
            some = np.flatnonzero(first + k < last)
            sample = order[first[some] + k]
            mine, other = owner[asked[some]], owner[of_line[sample]]
            beside = np.linalg.norm(places[sample] - middle[some], axis=1) <= 1.5 * near
            together = np.linalg.norm(shifts[sample] - shift[some], axis=1) <= OPEN * scale
            found[some] |= (mine[:, 0] != other[:, 0]) & (mine[:, 1] == other[:, 1]) & beside & together
    return found
