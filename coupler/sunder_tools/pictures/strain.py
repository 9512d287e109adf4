"""How far the triangles of a sheet are stretched, from its points now and at rest."""
from __future__ import annotations

import numpy as np

from .meshes import reference_points
from .vtp import PolyData


def principal_stretch(shell: PolyData) -> np.ndarray:
    """Returns the larger principal stretch (n,) of each triangle: the square root of the larger eigenvalue of C, whose
    components are scalar products of a triangle's sides."""
    def metric(points: np.ndarray) -> np.ndarray:
        corner = points[shell.triangles]
        sides = np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], axis=1)
        return sides @ sides.transpose(0, 2, 1)

    c = np.linalg.solve(metric(reference_points(shell)), metric(shell.points))
    half = 0.5 * np.trace(c, axis1=1, axis2=2)
    return np.sqrt(half + np.sqrt(np.maximum(half ** 2 - np.linalg.det(c), 0.0)))
