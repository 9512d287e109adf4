"""Rigid motion between two positions of a body's points, and quaternions (x, y, z, w)."""
from __future__ import annotations

import numpy as np

from .thick import OUTSIDE, sides_of_sheet_body

FLAT_VOLUME = 1e-9  # [-] of the cube of its size: a body with less has no inside


def centre_of(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Returns the centre of volume [m] of a closed surface; the mean of the points where it encloses nothing."""
    origin = points.mean(axis=0)
    a, b, c = (points[triangles] - origin).transpose(1, 0, 2)  # near the origin, differences keep their digits
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    if abs(volume.sum()) < FLAT_VOLUME * np.ptp(points, axis=0).max() ** 3:
        return origin
    return origin + (volume[:, None] * (a + b + c) / 4.0).sum(axis=0) / volume.sum()


def centre_of_mass(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Returns the centre of mass [m] of a body. A shard's mass lies on its middle surface, as the shell has it: where it is
    curved, the centre of its volume is elsewhere. `points` are the body's alone, in the order of the frame."""
    face = triangles[sides_of_sheet_body(points, triangles) == OUTSIDE]
    if not len(face):
        return centre_of(points, triangles)
    corner = (0.5 * (points[::2] + points[1::2]))[face // 2]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return np.asarray((area[:, None] * corner.mean(axis=1)).sum(axis=0) / area.sum())


def fit(before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, float]:
    """Returns the rotation matrix (3, 3) that takes points (n, 3) to others, about their means (Kabsch), and the largest
    distance [m] that is left."""
    p, q = before - before.mean(axis=0), after - after.mean(axis=0)
    if np.array_equal(before, after):
        return np.eye(3), 0.0
    u, _, v = np.linalg.svd(p.T @ q)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v)) or 1.0])
    turn = (u @ sign @ v).T
    return turn, float(np.linalg.norm(p @ turn.T - q, axis=1).max())


def quaternion(turn: np.ndarray) -> np.ndarray:
    """Returns the unit quaternion (x, y, z, w) of a rotation matrix."""
    m = turn
    square = np.array([1 + m[0, 0] - m[1, 1] - m[2, 2], 1 - m[0, 0] + m[1, 1] - m[2, 2],
                       1 - m[0, 0] - m[1, 1] + m[2, 2], 1 + m[0, 0] + m[1, 1] + m[2, 2]])
    largest = int(square.argmax())  # so that nothing small is divided by
    rows = [[square[0], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
            [m[0, 1] + m[1, 0], square[1], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]],
            [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], square[2], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], square[3]]]
    q = np.array(rows[largest])
    return q / np.linalg.norm(q)


def turn_of(q: np.ndarray) -> np.ndarray:
    """Returns the rotation matrix of a unit quaternion (x, y, z, w)."""
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def share_of_turn(turn: np.ndarray, share: float) -> np.ndarray:
    """Returns the rotation matrix about the same axis by a share of the angle, which is at most half a turn."""
    q = quaternion(turn)
    q = q if q[3] >= 0.0 else -q
    sine = float(np.linalg.norm(q[:3]))
    if sine < 1e-12:
        return np.eye(3)
    half = share * np.arctan2(sine, q[3])
    return turn_of(np.append(np.sin(half) * q[:3] / sine, np.cos(half)))
