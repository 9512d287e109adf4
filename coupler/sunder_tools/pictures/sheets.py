"""Shells in pictures: with their thickness where it is known, so that a piece looks the same before and after hand-off."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .mesh import thickness_of_points
from .thick import CREASE_COSINE, EDGE, INSIDE, OTHER, OUTSIDE, sheet_topology, vertex_normals
from .vtp import PolyData


@dataclass(frozen=True)
class Sheet:
    """Triangles of a frame's shells. Point v of the middle surface is 2v inside and 2v + 1 outside. The second half repeats
    the points, for triangles that are shaded flat."""
    points: np.ndarray     # (n, 3) [m]
    triangles: np.ndarray  # (m, 3)
    smooth: np.ndarray     # (n, 3) unit normals for shading, zero where it is flat
    own: np.ndarray        # (m,) triangle of the middle surface
    side: np.ndarray       # (m,) as in thick.py; OTHER without thickness
    thickness_m: float     # the largest; 0 where it is not known

    def lines(self, pairs: np.ndarray) -> np.ndarray:
        """Returns edges (k, 2) of the middle surface where they are seen: on both faces, as (2k, 2) points of the sheet."""
        return pairs if self.thickness_m == 0.0 else np.concatenate([2 * pairs + 1, 2 * pairs])


def sheet_of(shell: PolyData, thickness: tuple[float, ...]) -> Sheet:
    """Makes faces outside, inside and at the edge from the `thickness` [m] of each shell. Where that of one is not known, the
    middle surfaces stand for all."""
    normal = vertex_normals(shell.points, shell.triangles)
    thick = thickness_of_points(shell, thickness)
    if thick is None or not (thick > 0.0).any():
        own = np.arange(len(shell.triangles))
        return Sheet(shell.points, shell.triangles, normal, own, np.full(len(own), OTHER), 0.0)
    half = 0.5 * thick[:, None] * normal
    faces = np.stack([shell.points - half, shell.points + half], axis=1).reshape(-1, 3)
    triangles, side, own = sheet_topology(shell.triangles)
    # A face is smooth; an edge and a fold are flat, so their corners are points of their own, with no normal.
    fold = _folded(shell.points, shell.triangles, normal)
    flat = (side == EDGE) | fold[own]
    smooth = np.concatenate([np.stack([-normal, normal], axis=1).reshape(-1, 3), np.zeros_like(faces)])
    return Sheet(np.concatenate([faces, faces]), np.where(flat[:, None], triangles + len(faces), triangles), smooth, own, side,
                 float(thick.max()))


def _folded(points: np.ndarray, triangles: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Tests triangles (m,) for a corner at a fold: one where some triangle turns away from the mean of all."""
    corner = points[triangles]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    along = np.einsum("ijk,ik->ij", normal[triangles], across)
    turned = along < CREASE_COSINE * np.linalg.norm(across, axis=1)[:, None]
    fold = np.zeros(len(points), bool)
    fold[triangles[turned]] = True
    return np.asarray(fold[triangles].any(axis=1))


def sides_of_pieces(triangles: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Returns the sides (m,) of triangles of shards and frozen parts; `first` (m,) is the first point of each one's body. Their
    points come in pairs, inside before outside."""
    odd = ((triangles - first[:, None]) % 2).sum(axis=1)
    return np.where(odd == 3, OUTSIDE, np.where(odd == 0, INSIDE, EDGE))
