"""Velocities of a frame's points: as the run wrote them, or from frame to frame for rigid bodies."""
from __future__ import annotations

import numpy as np

from .frames import BODIES, Frame
from .vtp import PolyData


def shell_velocity(mesh: PolyData) -> np.ndarray:
    """Returns velocities (n, 3) [m/s], zero where an older frame has none."""
    velocity = mesh.point_data.get("velocity")
    return np.zeros_like(mesh.points) if velocity is None or velocity.ndim != 2 else velocity.astype(float)


def reference_points(mesh: PolyData) -> np.ndarray:
    """Returns positions at rest [m], or the present ones where the file has no displacement."""
    displacement = mesh.point_data.get("displacement")
    return mesh.points if displacement is None or displacement.ndim != 2 else mesh.points - displacement


def parameters(mesh: PolyData) -> np.ndarray:
    """Returns the parameters (n, 2) of points on their shell, 0 to 1, NaN where an older frame has none."""
    uv = mesh.point_data.get("uv")
    return np.full((len(mesh.points), 2), np.nan) if uv is None or uv.ndim != 2 else uv.astype(float)


def colours(mesh: PolyData) -> np.ndarray:
    """Returns red, green and blue (n, 3) of points, 0 to 1, NaN where no mesh file of the run has colours."""
    colour = mesh.point_data.get("colour")
    return np.full((len(mesh.points), 3), np.nan) if colour is None or colour.ndim != 2 else colour.astype(float)


def body_velocity(frames: list[Frame], k: int) -> np.ndarray:
    """Returns velocities (n, 3) [m/s] of bodies' points in frame k; (0, 3) where there are none. Raises VtpError,
    OSError.

    It is that of the frame, where the scene asks for BODY_MOTION. Otherwise it is the mean over the interval since the
    frame before, or up to the next for a body that is new; zero where a body is in neither. Spin of more than half a
    turn in an interval is not seen then.
    """
    here = frames[k].read(BODIES)
    if here is None:
        return np.zeros((0, 3))
    if "velocity" in here.point_data:
        return shell_velocity(here)
    velocity = np.zeros_like(here.points)
    missing = by_body(here)
    for other in (k - 1, k + 1):
        if not missing or not 0 <= other < len(frames):
            continue
        there = frames[other].read(BODIES)
        for body, points in by_body(there).items() if there is not None else ():
            mine = missing.get(body)
            if mine is not None and len(mine) == len(points):  # rigid: the same corners in the same order
                assert there is not None
                velocity[mine] = (there.points[points] - here.points[mine]) / (frames[other].time_s - frames[k].time_s)
                del missing[body]
    return velocity


def by_body(mesh: PolyData) -> dict[int, np.ndarray]:
    """Returns the points of each body, in ascending order of bodies."""
    body = mesh.of_triangles("body", 0).astype(np.int64)
    owner = np.full(len(mesh.points), -1, np.int64)
    owner[mesh.triangles.ravel()] = np.repeat(body, 3)
    order = np.argsort(owner, kind="stable")
    ids, starts = np.unique(owner[order], return_index=True)
    return {int(i): points for i, points in zip(ids, np.split(order, starts[1:])) if i >= 0}
