"""Soft bodies in pictures: a ball for each particle at the surface, shaded with the surface's normal."""
from __future__ import annotations

import numpy as np

from ..report.appearance import Appearance
from .frames import MOVING, SOFT, Frame
from .vtp import PolyData

RUBBER = np.array([[0.78, 0.36, 0.26], [0.30, 0.48, 0.66], [0.42, 0.58, 0.32]])  # colours of the soft bodies, in turn
MATT = 0.6  # roughness of soft bodies
FIRST = 1_000_000  # number of the first soft body where they are numbered with rigid ones
OVERLAP = 1.5  # radii as a multiple of a ball's: neighbours close the gaps

_GOLDEN = 0.5 * (1.0 + 5.0 ** 0.5)
_CORNERS = np.array([(-1, _GOLDEN, 0), (1, _GOLDEN, 0), (-1, -_GOLDEN, 0), (1, -_GOLDEN, 0), (0, -1, _GOLDEN), (0, 1, _GOLDEN),
                     (0, -1, -_GOLDEN), (0, 1, -_GOLDEN), (_GOLDEN, 0, -1), (_GOLDEN, 0, 1), (-_GOLDEN, 0, -1),
                     (-_GOLDEN, 0, 1)]) / np.hypot(1.0, _GOLDEN)
_FACES = np.array([(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
                   (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7),
                   (9, 8, 1)])


def balls(mesh: PolyData) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Makes icosahedra on particles at the surface: points (n, 3) [m], triangles (m, 3), the particle of each
    triangle (m,) and a unit normal of the surface per point (n, 3)."""
    here = np.flatnonzero(mesh.point_data["surface"] > 0.5)
    radius = OVERLAP * mesh.point_data["radius"][here]
    points = mesh.points[here, None, :] + radius[:, None, None] * _CORNERS
    triangles = _FACES + len(_CORNERS) * np.arange(len(here))[:, None, None]
    normal = mesh.point_data["normal"][here]
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    return (points.reshape(-1, 3), triangles.reshape(-1, 3), np.repeat(here, len(_FACES)),
            np.repeat(normal, len(_CORNERS), axis=0))


def colours(mesh: PolyData, particle: np.ndarray) -> np.ndarray:
    """Returns colours (m, 3) of triangles that belong to these particles."""
    return RUBBER[mesh.point_data["soft_body"][particle].astype(int) % len(RUBBER)]


def look_of_soft(number: int) -> Appearance:
    """Returns the look of a soft body, by its number."""
    red, green, blue = RUBBER[number % len(RUBBER)].tolist()
    return Appearance("plain", (red, green, blue), MATT)


def speeds(mesh: PolyData) -> np.ndarray:
    """Returns the speed (n,) [m/s] of the particles."""
    return np.linalg.norm(mesh.point_data["velocity"], axis=1)


def with_soft(frame: Frame, bodies: PolyData | None, velocity: np.ndarray) -> tuple[PolyData | None, np.ndarray]:
    """Adds the frame's soft bodies to the rigid bodies and to the velocities (n, 3) [m/s] of their points, numbered
    from FIRST. Raises VtpError, OSError."""
    soft = frame.read(SOFT)
    if soft is None or not len(soft.points):
        return bodies, velocity
    points, triangles, particle, _ = balls(soft)
    number = FIRST + soft.point_data["soft_body"][particle].astype(int)
    moves = np.repeat(soft.point_data["velocity"][soft.point_data["surface"] > 0.5], len(_CORNERS), axis=0)
    if bodies is None:
        return PolyData(points, triangles=triangles, cell_data={"body": number, "kind": 0 * number + MOVING}), moves
    cells = {"body": np.concatenate([bodies.of_triangles("body", 0), number]),
             "kind": np.concatenate([bodies.of_triangles("kind", MOVING), 0 * number + MOVING]),
             "shell": np.concatenate([bodies.of_triangles("shell", -1), 0 * number - 1])}
    return (PolyData(np.concatenate([bodies.points, points]),
                     triangles=np.concatenate([bodies.triangles, triangles + len(bodies.points)]), cell_data=cells),
            np.concatenate([velocity, moves]))
