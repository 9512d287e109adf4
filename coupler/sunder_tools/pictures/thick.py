"""Sheets as they are: a shell's middle surface with its thickness, as faces outside, inside and at the edge."""
from __future__ import annotations

import numpy as np

OUTSIDE, INSIDE, EDGE, OTHER = 0, 1, 2, -1  # `side` of a triangle; OTHER: of no sheet, or of one without thickness
SIDE_NAMES = {OUTSIDE: "outside", INSIDE: "inside", EDGE: "edge"}
CREASE_COSINE = 0.766  # faces that turn by less than 40 degrees are shaded as one


def vertex_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Returns a unit normal per point (n, 3), from its triangles weighted by area; zero where there is none. Both sides
    of a crack have their own points."""
    corner = points[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    sums = np.stack([np.bincount(triangles.ravel(), np.repeat(normal[:, axis], 3), len(points)) for axis in range(3)], 1)
    return sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)


def normal_rates(points: np.ndarray, velocity: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Returns how fast `vertex_normals` turn (n, 3) [1/s] where points have these velocities (n, 3) [m/s]."""
    corner, moving = points[triangles], velocity[triangles]
    e, f = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    de, df = moving[:, 1] - moving[:, 0], moving[:, 2] - moving[:, 0]
    sums, rates = (np.stack([np.bincount(triangles.ravel(), np.repeat(of[:, axis], 3), len(points)) for axis in range(3)], 1)
                   for of in (np.cross(e, f), np.cross(de, f) + np.cross(e, df)))
    length = np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)
    unit = sums / length
    return (rates - unit * (unit * rates).sum(axis=1, keepdims=True)) / length


def border(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns edges (k, 2) of one triangle only, in its direction, and that triangle (k,)."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    size = int(pairs.max(initial=0)) + 1
    low, high = pairs.min(axis=1), pairs.max(axis=1)
    _, inverse, count = np.unique(low * size + high, return_inverse=True, return_counts=True)
    alone = count[inverse] == 1
    return pairs[alone], np.tile(np.arange(len(triangles)), 3)[alone]


def sheet_topology(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Makes the closed surface of a sheet whose point v becomes 2v (inside) and 2v + 1 (outside).

    Returns triangles (m, 3), their sides (m,), and the triangle of the middle surface (m,) that each is of. Triangles
    come in the order outside, inside, edge. The edge goes along everything that has one side only: the border, and both
    faces of a crack.
    """
    ends, owner = border(triangles)
    a, b = 2 * ends[:, 0], 2 * ends[:, 1]
    walls = np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)])
    own = np.arange(len(triangles))
    return (np.concatenate([2 * triangles + 1, 2 * triangles[:, ::-1], walls]).astype(np.int64),
            np.repeat([OUTSIDE, INSIDE, EDGE], [len(triangles), len(triangles), len(walls)]),
            np.concatenate([own, own, owner, owner]))


def sheet_points(points: np.ndarray, triangles: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    """Returns the points (2n, 3) of that surface, half of `thickness` (n,) [m] to either side of the middle surface."""
    half = 0.5 * thickness[:, None] * vertex_normals(points, triangles)
    return np.stack([points - half, points + half], axis=1).reshape(-1, 3)


def sides_of_sheet_body(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Returns the sides (m,) of a shard or frozen part, OTHER where it is not drawn as a sheet.

    The shell process writes such a body in pairs of points, inside before outside (`thicken` in
    shell/solver/parting/handoff.cpp). `points` are the body's alone, in the order of the frame.
    """
    none = np.full(len(triangles), OTHER)
    if len(points) % 2 or not len(points):
        return none
    across = np.linalg.norm(points[1::2] - points[::2], axis=1)
    odd = (triangles % 2).sum(axis=1)
    if across.max() > 2.0 * np.median(across) or (odd == 3).sum() != (odd == 0).sum() or not (odd == 3).any():
        return none
    return np.where(odd == 3, OUTSIDE, np.where(odd == 0, INSIDE, EDGE))


def sides_of_piece(points: np.ndarray, triangles: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Returns the same for a body of several shells, `origin` (m,) that of each triangle: each has its own thickness, and its points
    stand together."""
    side = np.full(len(triangles), OTHER)
    for one in np.unique(origin):
        mine = triangles[origin == one]
        low, high = mine.min() // 2 * 2, mine.max() + 1
        side[origin == one] = sides_of_sheet_body(points[low:high + high % 2], mine - low)
    return side


def corner_normals(points: np.ndarray, triangles: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Returns a unit normal for each corner of each triangle (m, 3, 3): smooth over faces that turn by less than
    CREASE_COSINE says, sharp over others. Points with an equal `place` (n,) are one point."""
    corner = points[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    unit = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    at = place[triangles].ravel()
    order = np.argsort(at, kind="stable")
    starts = np.flatnonzero(np.diff(at[order], prepend=-1))
    count = np.diff(np.append(starts, len(order)))
    # pairs of corners that meet in a point: each of a group with each
    many = np.repeat(count, count)
    mine = np.repeat(np.arange(len(order)), many)
    first = np.repeat(np.repeat(starts, count), many)
    other = first + np.arange(len(mine)) - np.repeat(np.cumsum(many) - many, many)
    f, g = order[mine] // 3, order[other] // 3
    joined = (unit[f] * unit[g]).sum(axis=1) > CREASE_COSINE
    joined |= f == g
    target = order[mine][joined]
    sums = np.stack([np.bincount(target, normal[g[joined], axis], len(at)) for axis in range(3)], axis=1)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    up = np.array([0.0, 0.0, 1.0])  # of a triangle without area: formats ask for a unit vector
    return np.where(length > 0.0, sums / np.maximum(length, 1e-300), up).reshape(-1, 3, 3)
