"""Vertices and slots of sheets for formats with smooth normals: those of outside, inside and edge are separate."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator

import numpy as np

from ..report.appearance import Appearance
from ..report.scene_text import Words
from .materials import material_of_shell, slot_name
from .thick import EDGE, INSIDE, OTHER, OUTSIDE, border, normal_rates, vertex_normals


@dataclass
class Slot:
    """Triangles of one material, which have vertices of their own."""
    material: str
    look: Appearance
    first: int             # vertex of the shape
    count: int             # of vertices
    triangles: np.ndarray  # (m, 3) from `first` on


def faces(points: np.ndarray, triangles: np.ndarray, part: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns vertices and their normals: of each shell outside, inside and edge; points alone where there is no `half`
    of a thickness (n,) [m]."""
    places, normals = [], []
    for one, used, mine in _parts(triangles, part):
        at = points[used]
        out = vertex_normals(at, mine)
        if not len(half):
            places.append(at)
            normals.append(out)
            continue
        way = half[used, None] * out
        rim, _ = border(mine)
        a, b = rim.T
        wall = np.stack([(at - way)[a], (at - way)[b], (at + way)[b], (at + way)[a]], axis=1)  # (k, 4, 3)
        across = np.cross(wall[:, 1] - wall[:, 0], wall[:, 3] - wall[:, 0])
        across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
        places += [at + way, at - way, wall.reshape(-1, 3)]
        normals += [out, -out, np.repeat(across, 4, axis=0)]
    normal = np.concatenate(normals)
    normal[np.linalg.norm(normal, axis=1) < 0.5] = (0.0, 0.0, 1.0)  # formats ask for unit vectors
    return np.concatenate(places), normal


def face_velocities(points: np.ndarray, velocity: np.ndarray, triangles: np.ndarray, part: np.ndarray,
                    half: np.ndarray) -> np.ndarray:
    """Returns velocities [m/s] of the vertices that `faces` makes, from those of points (n, 3)."""
    out = []
    for _, used, mine in _parts(triangles, part):
        own = velocity[used]
        if not len(half):
            out.append(own)
            continue
        way = half[used, None] * normal_rates(points[used], own, mine)
        a, b = border(mine)[0].T
        out += [own + way, own - way,
                np.stack([(own - way)[a], (own - way)[b], (own + way)[b], (own + way)[a]], axis=1).reshape(-1, 3)]
    return np.concatenate(out)


def over_faces(values: np.ndarray, triangles: np.ndarray, part: np.ndarray, thick: bool) -> np.ndarray:
    """Returns values (n,) or (n, k) of points as values of the vertices that `faces` makes."""
    out = []
    for _, used, mine in _parts(triangles, part):
        own = values[used]
        out += [own, own, own[border(mine)[0][:, [0, 1, 1, 0]].ravel()]] if thick else [own]
    return np.concatenate(out)


def slots_of(triangles: np.ndarray, part: np.ndarray, thick: bool, words: Words) -> list[Slot]:
    """Returns the slots of the vertices that `faces` makes."""
    slots, first = [], 0
    for one, used, mine in _parts(triangles, part):
        material, look = material_of_shell(one, words)
        if not thick:
            slots.append(Slot(slot_name(material, OTHER), look, first, len(used), mine))
            first += len(used)
            continue
        walls = 4 * np.arange(len(border(mine)[0]))[:, None] + np.array([[0, 1, 2, 0, 2, 3]])
        for side, count, of in ((OUTSIDE, len(used), mine), (INSIDE, len(used), mine[:, ::-1]),
                                (EDGE, 4 * len(walls), walls.reshape(-1, 3))):
            if len(of):
                slots.append(Slot(slot_name(material, side), look, first, count, of))
            first += count
    return slots


def _parts(triangles: np.ndarray, part: np.ndarray) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Yields each shell's number, points and triangles (from these points) of a piece that seams may join."""
    of = part[triangles[:, 0]]
    for one in np.unique(of):
        used, local = np.unique(triangles[of == one], return_inverse=True)
        yield int(one), used, local.reshape(-1, 3)
