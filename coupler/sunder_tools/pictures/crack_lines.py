"""Crack lines of a run: the edges of one frame, in the parameters of their shell and on the sheet at rest."""
from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .frames import CRACKS, list_frames
from .meshes import reference_points
from .vtp import PolyData, VtpError


@dataclass(frozen=True)
class Graph:
    """Crack lines of one frame. Equal vertices have equal coordinates, to the last bit."""
    ends: np.ndarray   # (n, 2, 2) parameter points [m]
    rest: np.ndarray  # (n, 2, 3) on the sheet at rest [m], cut off at its border
    crack: np.ndarray  # (n,) number of the crack
    born: np.ndarray   # (n,) [s]

    def __len__(self) -> int:
        return len(self.ends)

    def some(self, which: np.ndarray) -> "Graph":
        """Selects edges by `which` (n,)."""
        return Graph(self.ends[which], self.rest[which], self.crack[which], self.born[which])

    def keys(self) -> list[bytes]:
        """Returns one key per edge: its two points in either order, crack and birth."""
        order = np.lexsort((self.ends[:, :, 1], self.ends[:, :, 0]), axis=1)
        points = np.take_along_axis(self.ends, order[:, :, None], axis=1).reshape(len(self), 4)
        return [row.tobytes() for row in np.column_stack([points, self.crack, self.born])]

    def vertices(self) -> np.ndarray:
        """Returns numbers (n, 2) of the ends; equal points have equal numbers."""
        if len(self) == 0:
            return np.zeros((0, 2), int)
        return np.unique(self.ends.reshape(-1, 2), axis=0, return_inverse=True)[1].reshape(-1, 2)


def graph_of(mesh: PolyData | None, where: str) -> Graph:
    """The graph in a crack file. Raises VtpError where an array is missing."""
    if mesh is None:
        raise VtpError(f"{where}: there is none")
    missing = [n for n in ("parameter",) if n not in mesh.point_data] + [
        n for n in ("crack", "time") if n not in mesh.cell_data]
    if missing:
        raise VtpError(f"{where}: no {', '.join(missing)}; written by an earlier version, run the scene again")
    if (np.diff(mesh.line_bounds) != 2).any():
        raise VtpError(f"{where}: a crack line that is not one edge")
    pairs = mesh.segments()
    return Graph(mesh.point_data["parameter"][pairs][:, :, :2] + 0.0, reference_points(mesh)[pairs],  # + 0.0: no minus zero
                 np.asarray(mesh.cell_data["crack"]).astype(int), np.asarray(mesh.cell_data["time"], float))


def last_graph(folder: Path) -> Graph:
    """Returns the crack lines of the last frame with any. Raises ValueError where there is none."""
    frames = [f for f in list_frames(folder) if CRACKS in f.files]
    if not frames:
        raise ValueError(f"{folder}: no crack lines")
    mesh = frames[-1].read(CRACKS)
    return graph_of(mesh, str(frames[-1].files[CRACKS]))


def grown(graph: Graph) -> Graph:
    """Returns the grown edges, without cuts at time zero."""
    return graph.some(graph.born > 0.0)


class Within(NamedTuple):
    """Cracks, and what of them lies in a box of parameters."""
    length: float  # [m] of all
    share: float   # of that length within the box; NaN without cracks
    first: bool    # the first of them began within the box


def within(graph: Graph, low: np.ndarray, high: np.ndarray) -> Within:
    """Measures cracks against the box from `low` to `high` (u, v); an edge counts by its middle."""
    if len(graph) == 0:
        return Within(0.0, math.nan, False)
    length = np.linalg.norm(graph.ends[:, 1] - graph.ends[:, 0], axis=1)
    inside = ((graph.ends.mean(axis=1) >= low) & (graph.ends.mean(axis=1) <= high)).all(axis=1)
    return Within(float(length.sum()), float(length[inside].sum() / length.sum()), bool(inside[int(np.argmin(graph.born))]))
