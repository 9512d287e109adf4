"""Gaps in what `sunder inspect` sees: borders that run beside one another and are not joined."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

MOST_EDGES = 2000     # free edges of a CAD file that are compared, and points on borders of a mesh
BESIDE = 0.25         # of the shorter edge: borders further apart than that do not run beside one another
BESIDE_MESH = 0.2     # the same of the edges of a mesh
ROUND_OFF = 1e-9      # of the size


@dataclass(frozen=True)
class Gap:
    """Two borders that nearly meet: faces of a CAD file, or points of a mesh in all."""
    width_m: float
    at_m: tuple[float, float, float]
    faces: tuple[int, ...] = ()
    points_m: float = float("inf")  # of a mesh: how far the nearest point of the other border is, where it is furthest


def gaps_of_edges(edges: list[dict[str, Any]], reach_m: float) -> list[Gap] | None:
    """Finds pairs of free edges of different faces of which one runs along the other, no further off than `reach_m`. None
    where there are too many edges."""
    free = [(edge["faces"][0], np.array(edge["points_m"]), float(edge["length_m"])) for edge in edges if len(edge["faces"]) == 1]
    if len(free) > MOST_EDGES:
        return None
    boxes = [(points.min(axis=0) - reach_m, points.max(axis=0) + reach_m) for _, points, _ in free]
    out = []
    for i, (face, points, length) in enumerate(free):
        for k in range(i):
            other, beside, far = free[k]
            if other == face or (boxes[i][0] > boxes[k][1]).any() or (boxes[k][0] > boxes[i][1]).any():
                continue
            most = min(reach_m, BESIDE * min(length, far))
            # one of them may go on beyond the other
            found = [one for one in (_along(points, beside), _along(beside, points)) if one[0] <= most]
            apart, at = max(found, key=lambda one: one[0], default=(0.0, points[0]))
            if apart > ROUND_OFF * length:
                out.append(Gap(apart, (float(at[0]), float(at[1]), float(at[2])), (other, face)))
    return sorted(out, key=lambda gap: -gap.width_m)


def gap_of_borders(borders: list[list[list[float]]]) -> tuple[int, Gap | None] | None:
    """Counts the points on borders of a mesh beside which another stretch of border runs, and returns the widest such gap. Its
    width is a distance from an edge, and points that are welded have to be near points. None where there are too many."""
    if not borders:
        return 0, None
    ends = np.array(borders)  # (m, 2, 3)
    points, number = np.unique(ends.reshape(-1, 3), axis=0, return_inverse=True)
    if len(points) > MOST_EDGES:
        return None
    pairs = number.reshape(-1, 2)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    count, widest, furthest = 0, None, 0.0
    for i, p in enumerate(points):
        own = (pairs == i).any(axis=1)
        near = np.isin(pairs, pairs[own]).any(axis=1)  # meets an edge that meets the point
        if near.all():
            continue
        distance = _distances(p, ends[~near, 0], ends[~near, 1]).min()
        if distance <= BESIDE_MESH * lengths[own].mean():
            count += 1
            furthest = max(furthest, float(np.linalg.norm(ends[~near].reshape(-1, 3) - p, axis=1).min()))
            if widest is None or distance > widest.width_m:
                widest = Gap(float(distance), (float(p[0]), float(p[1]), float(p[2])))
    return count, None if widest is None else replace(widest, points_m=furthest)


def _along(points: np.ndarray, line: np.ndarray) -> tuple[float, np.ndarray]:
    """Returns the largest distance of points from a polyline, and where it is."""
    found = [_distances(p, line[:-1], line[1:]).min() for p in points]
    return float(max(found)), points[int(np.argmax(found))]


def _distances(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    way = b - a
    share = np.clip(np.einsum("ij,ij->i", p - a, way) / np.maximum(np.einsum("ij,ij->i", way, way), 1e-300), 0.0, 1.0)
    return np.asarray(np.linalg.norm(p - a - share[:, None] * way, axis=1))
