"""All triangles of a frame in one mesh, as exports take them: shells with their thickness, shards, bodies."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .frames import BODIES, FROZEN, SHARD, SHELL, Frame
from .motion import body_velocity, by_body, colours, parameters, reference_points, shell_velocity
from .soft import with_soft
from .thick import OTHER, normal_rates, sheet_points, sheet_topology, sides_of_piece
from .vtp import PolyData


@dataclass
class Mesh:
    """All triangles of a frame, those of shells first."""
    points: np.ndarray     # (n, 3) [m]
    velocity: np.ndarray   # (n, 3) [m/s]
    rest: np.ndarray       # (n, 3) [m] place at rest, NaN where there is none
    uv: np.ndarray         # (n, 2) parameters on the shell, 0 to 1, NaN where there are none
    colour: np.ndarray     # (n, 3) red, green, blue of a mesh file, NaN where there is none
    triangles: np.ndarray  # (m, 3)
    fragment: np.ndarray  # (m,) id of the piece, in the shell and as a shard; for a body of the scene its number
    damage: np.ndarray  # (m,) 0..1, largest of all layers; 0 for bodies
    part: np.ndarray       # (m,) number of the shell, -1 for bodies
    body: np.ndarray       # (m,) -1 for the shell
    kind: np.ndarray       # (m,) as in frames.py, -1 for the shell
    side: np.ndarray       # (m,) as in thick.py
    origin: np.ndarray     # (m,) number of the shell that it is or was a piece of, -1 where there is none or it is not known


def part_of_points(shell: PolyData) -> np.ndarray:
    """Returns the number of the shell of each point (n,); points of one shell only."""
    part = np.zeros(len(shell.points), np.int64)
    part[shell.triangles.ravel()] = np.repeat(shell.of_triangles("shell", 0).astype(np.int64), 3)
    return part


def origin_of_triangles(bodies: PolyData) -> np.ndarray:
    """Returns the number of the shell that each triangle (m,) of bodies was a piece of; -1 where it was none, and in frames of
    earlier versions."""
    return bodies.of_triangles("shell", -1).astype(np.int64)


def thickness_of_points(shell: PolyData, thickness: tuple[float, ...]) -> np.ndarray | None:
    """Returns the thickness [m] at each point (n,), None where that of a shell is not known. A frame has that of its
    points where it varies."""
    if (varying := shell.point_data.get("thickness_at_rest")) is not None:
        return varying
    part = part_of_points(shell)
    if part.max(initial=0) >= len(thickness):
        return None
    found = np.array(thickness)[part]
    return found if np.isfinite(found).all() else None


def mesh_of(frames: list[Frame], k: int, thickness: tuple[float, ...] = ()) -> Mesh:
    """Reads frame k. `thickness` [m] of each shell makes their faces; without it they are middle surfaces. Raises
    VtpError, OSError."""
    shell = frames[k].read(SHELL)
    rigid = frames[k].read(BODIES)
    bodies, moves = with_soft(frames[k], rigid, body_velocity(frames, k))
    points, velocity, triangles = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros((0, 3), int)]
    rests, uvs, tints = [np.zeros((0, 3))], [np.zeros((0, 2))], [np.zeros((0, 3))]
    names = ("fragment", "damage", "part", "body", "kind", "side", "origin")
    columns: dict[str, list[np.ndarray]] = {name: [np.zeros(0)] for name in names}
    if shell is not None:
        moving, own = shell_velocity(shell), np.arange(len(shell.triangles))
        rest, uv, tint = reference_points(shell), parameters(shell), colours(shell)
        place, faces, side = shell.points, shell.triangles, np.full(len(own), OTHER)
        thick = thickness_of_points(shell, thickness)
        if thick is not None:
            way = 0.5 * thick[:, None] * normal_rates(place, moving, faces)
            moving = np.stack([moving - way, moving + way], axis=1).reshape(-1, 3)
            place, rest, uv = sheet_points(place, faces, thick), sheet_points(rest, faces, thick), np.repeat(uv, 2, axis=0)
            tint = np.repeat(tint, 2, axis=0)
            faces, side, own = sheet_topology(faces)
        points.append(place)
        velocity.append(moving)
        rests.append(rest)
        uvs.append(uv)
        tints.append(tint)
        triangles.append(faces)
        damage = shell.of_triangles("damage", 0.0)
        none, part = np.full(len(own), -1), shell.of_triangles("shell", 0)[own]
        for name, values in zip(names, (shell.of_triangles("fragment", 0)[own],
                                        (damage.max(axis=1) if damage.ndim == 2 else damage)[own],
                                        part, none, none, side, part)):
            columns[name].append(values)
    if bodies is not None:
        triangles.append(bodies.triangles + sum(map(len, points)))
        points.append(bodies.points)
        velocity.append(moves)
        rest, uv, tint = places_of_bodies(rigid, len(bodies.points))
        rests.append(rest)
        uvs.append(uv)
        tints.append(tint)
        body, kind = bodies.of_triangles("body", 0), bodies.of_triangles("kind", 0)
        none = np.full(len(body), -1)
        origin = none.copy()
        if rigid is not None:
            origin[:len(rigid.triangles)] = origin_of_triangles(rigid)
        for name, values in zip(names, (body, 0.0 * body, none, body, kind, _sides(rigid, len(body)), origin)):
            columns[name].append(values)
    joined = {name: np.concatenate(values) for name, values in columns.items()}
    return Mesh(np.concatenate(points), np.concatenate(velocity), np.concatenate(rests), np.concatenate(uvs),
                np.concatenate(tints), np.concatenate(triangles), joined["fragment"].astype(int),
                joined["damage"], *(joined[name].astype(int) for name in ("part", "body", "kind", "side", "origin")))


def places_of_bodies(bodies: PolyData | None, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns places at rest (count, 3) [m], parameters (count, 2) and colours (count, 3) of the points of bodies that were
    pieces of shells, NaN for others."""
    rest, uv, tint = (np.full((count, width), np.nan) for width in (3, 2, 3))
    if bodies is not None and "displacement" in bodies.point_data:
        broken = np.isin(bodies.of_triangles("kind", 0), (SHARD, FROZEN))
        mine = np.unique(bodies.triangles[broken])
        rest[mine], uv[mine], tint[mine] = (of(bodies)[mine] for of in (reference_points, parameters, colours))
    return rest, uv, tint


def _sides(bodies: PolyData | None, count: int) -> np.ndarray:
    """Returns the sides (count,) of the triangles of rigid bodies, OTHER for those after them."""
    side = np.full(count, OTHER)
    if bodies is None:
        return side
    body = bodies.of_triangles("body", 0).astype(np.int64)
    broken = np.isin(bodies.of_triangles("kind", 0), (SHARD, FROZEN))
    number, origin = np.zeros(len(bodies.points), np.int64), origin_of_triangles(bodies)
    for one, mine in by_body(bodies).items():
        which = np.flatnonzero((body == one) & broken)
        if len(which):
            number[mine] = np.arange(len(mine))
            side[which] = sides_of_piece(bodies.points[mine], number[bodies.triangles[which]], origin[which])
    return side
