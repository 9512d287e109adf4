"""Pieces over time: the frames of a run by the ids of pieces, from the shell to the shards."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from sunder_tools.pictures.frames import BODIES, FROZEN, SHARD, SHELL
from sunder_tools.pictures.meshes import reference_points
from sunder_tools.pictures.motion import by_body
from sunder_tools.pictures.rigid import centre_of_mass
from sunder_tools.pictures.vtp import PolyData

from .scene import Results


@dataclass
class Track:
    """A piece in the frames that show it, one after another: `time` [s], `centre` (3,) [m] of its mass.

    Of a shard it is the place in shards.csv. `area` is that at rest [m^2]; NaN from the frame on in which the piece is a body.
    A frame draws a shell back from its cracks by a hundredth, so the area is less than that in shards.csv by some per cent.
    While a piece is in the shell, its centre is off by less than a hundredth of the distance between cracks.
    """
    time: list[float] = field(default_factory=list)
    centre: list[np.ndarray] = field(default_factory=list)
    area: list[float] = field(default_factory=list)


def tracks(results: Results) -> dict[int, Track]:
    """Returns the tracks of all pieces by their ids. Raises VtpError, OSError."""
    found: dict[int, Track] = {}
    for frame in results.frames:
        for shown in (_in_shell(frame.read(SHELL)), _in_bodies(frame.read(BODIES))):
            for number, (centre, area) in shown.items():
                track = found.setdefault(number, Track())
                track.time.append(frame.time_s)
                track.centre.append(centre)
                track.area.append(area)
    return found


def _in_shell(shell: PolyData | None) -> dict[int, tuple[np.ndarray, float]]:
    """Returns present centres and areas at rest."""
    if shell is None:
        return {}
    ids, piece = np.unique(shell.of_triangles("fragment", 0).astype(int), return_inverse=True)
    rest, now = (points[shell.triangles].astype(float) for points in (reference_points(shell), shell.points))
    area = 0.5 * np.linalg.norm(np.cross(rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]), axis=1)
    whole = np.bincount(piece, area)
    centre = np.stack([np.bincount(piece, area * way) for way in now.mean(axis=1).T], axis=1) / whole[:, None]
    return {int(number): (centre[k], float(whole[k])) for k, number in enumerate(ids)}


def _in_bodies(bodies: PolyData | None) -> dict[int, tuple[np.ndarray, float]]:
    """Returns centres of mass of shards and frozen parts."""
    if bodies is None:
        return {}
    broken = np.isin(bodies.of_triangles("kind", 0), (SHARD, FROZEN))
    body, number = bodies.of_triangles("body", 0).astype(int), np.zeros(len(bodies.points), np.int64)
    points, found = by_body(bodies), {}
    for one in np.unique(body[broken]).tolist():
        number[points[one]] = np.arange(len(points[one]))
        found[one] = centre_of_mass(bodies.points[points[one]].astype(float), number[bodies.triangles[body == one]]), np.nan
    return found
