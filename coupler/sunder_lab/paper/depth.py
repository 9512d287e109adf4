"""How far points are outside of a closed surface of triangles."""
from __future__ import annotations

import numpy as np

CHUNK = 2000  # points at once


def outside(points: np.ndarray, corners: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Distances [m] of points (n, 3) from the surface, negative inside. Each is that to the faces around the corner that is
    nearest to the point, so it is exact where faces are small against how the surface bends."""
    used, inverse = np.unique(triangles, return_inverse=True)
    corners, triangles = corners[used], inverse.reshape(triangles.shape)
    faces, start = _around(len(corners), triangles)
    out = np.empty(len(points))
    for first in range(0, len(points), CHUNK):
        part = points[first:first + CHUNK]
        squared = (corners * corners).sum(axis=1)[None, :] - 2.0 * part @ corners.T
        nearest = squared.argmin(axis=1)
        best, found = np.full(len(part), np.inf), np.full(len(part), np.inf)
        for k in range(int(np.diff(start).max())):
            there = start[nearest] + k < start[nearest + 1]
            face = triangles[faces[start[nearest[there]] + k]]
            a, b, c = (corners[face[:, j]] for j in range(3))
            foot = _foot(part[there], a, b, c)
            away = part[there] - foot
            far, side = np.linalg.norm(away, axis=1), (away * np.cross(b - a, c - a)).sum(axis=1)
            # At an edge two faces are equally near. The one that the point is farther over says the side.
            height = np.abs(side) / np.maximum(np.linalg.norm(np.cross(b - a, c - a), axis=1), 1e-300)
            rank = far - 1e-6 * height
            at = np.flatnonzero(there)
            better = rank < best[at]
            best[at[better]], found[at[better]] = rank[better], (np.where(side < 0.0, -1.0, 1.0) * far)[better]
        out[first:first + CHUNK] = found
    return out


def _around(count: int, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangles around each corner, one after the other, and where those of each corner begin."""
    corner = triangles.ravel()
    order = np.argsort(corner, kind="stable")
    return order // 3, np.concatenate([[0], np.cumsum(np.bincount(corner, minlength=count))])


def _foot(p: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """The point of each triangle that is nearest to p (n, 3)."""
    normal = np.cross(b - a, c - a)
    size = np.maximum((normal * normal).sum(axis=1), 1e-300)
    share = np.stack([(np.cross(v - u, p - u) * normal).sum(axis=1) / size for u, v in ((b, c), (c, a), (a, b))], axis=1)
    inside = share[:, :1] * a + share[:, 1:2] * b + share[:, 2:] * c
    best, far = inside, np.where((share >= 0.0).all(axis=1), ((p - inside) ** 2).sum(axis=1), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        side = v - u
        along = np.clip(((p - u) * side).sum(axis=1) / np.maximum((side * side).sum(axis=1), 1e-300), 0.0, 1.0)
        foot = u + along[:, None] * side
        here = ((p - foot) ** 2).sum(axis=1)
        best = np.where((here < far)[:, None], foot, best)
        far = np.minimum(far, here)
    return best
