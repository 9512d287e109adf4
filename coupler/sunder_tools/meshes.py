"""What a picture needs of a frame: glass and solid triangles, their colours, and the lines on them."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .frames import BODIES, CRACKS, FROZEN, MOVING, SHARD, SHELL, STATIC, Frame
from .vtp import PolyData

WELD_M = 1e-6            # points closer than this are one when lines are looked for
SHARP_COSINE = 0.8       # edges between faces that turn by more than 37 degrees are drawn
LONGEST_STATIC_M = 0.12  # static triangles are divided to this, so that none reaches behind the eye
GLASS = np.array([0.56, 0.79, 0.79])
STEEL = np.array([0.58, 0.60, 0.63])
FLOOR = np.array([0.87, 0.87, 0.86])


@dataclass
class Surface:
    """Triangles of one sort. `round_centre` is the centre of a ball that a triangle belongs to, else NaN."""
    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))          # [m]
    triangles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), int))
    colours: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))         # per triangle, 0..1
    round_centre: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))    # per triangle [m]
    is_floor: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))       # per triangle

    def normals(self) -> np.ndarray:
        """Unit normals per triangle; zero for a degenerate one."""
        corner = self.points[self.triangles]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)


@dataclass
class Scene:
    """A frame ready to be drawn."""
    glass: Surface
    solid: Surface
    cracks: np.ndarray      # (k, 2, 3) ends of crack and fragment lines [m]
    outlines: np.ndarray    # (k, 2, 3) sharp edges of shards and frozen remains [m]
    shards: np.ndarray      # (n, 3) corners of shards [m]
    moving: np.ndarray      # (n, 3) corners of the scene's own moving bodies [m]
    floor_z: float | None   # height of the lowest level static face [m]; None: there is none


def varied(ids: np.ndarray, base: np.ndarray, amount: float) -> np.ndarray:
    """`base` made lighter or darker by up to `amount`, always the same for the same id; id 0 is `base`."""
    golden = np.modf(np.asarray(ids, float) * 0.6180339887498949)[0]
    tone = np.where(np.asarray(ids) == 0, 0.0, 2.0 * golden - 1.0)
    tint = np.stack([tone, 0.6 * tone, 0.4 * tone], axis=1)
    return np.clip(base * (1.0 + amount * tint), 0.0, 1.0)


def weld(points: np.ndarray, apart: np.ndarray | None = None) -> np.ndarray:
    """A number per point, the same for points in one place (and with the same number in `apart`)."""
    cell = np.round(points / WELD_M).astype(np.int64)
    if apart is not None:
        cell = np.column_stack([cell, np.asarray(apart, np.int64)])
    cell = np.ascontiguousarray(cell)
    whole = cell.view([("", np.int64)] * cell.shape[1]).ravel()  # a row as one value, so that none collide
    return np.unique(whole, return_inverse=True)[1]


def edges(triangles: np.ndarray, same: np.ndarray, labels: np.ndarray, normals: np.ndarray | None) -> np.ndarray:
    """Edges (k, 2) of the mesh that are to be seen: its border, where the label changes, where it is sharp.

    `same` is weld() of the points; the result indexes the points themselves.
    """
    if len(triangles) == 0:
        return np.zeros((0, 2), int)
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner = np.tile(np.arange(len(triangles)), 3)
    ends = np.sort(same[pairs], axis=1)
    order = np.argsort(ends[:, 0] * (same.max() + 1) + ends[:, 1], kind="stable")
    ends, pairs, owner = ends[order], pairs[order], owner[order]
    starts = np.flatnonzero(np.concatenate([[True], (np.diff(ends, axis=0) != 0).any(axis=1)]))
    count = np.diff(np.append(starts, len(ends)))
    label = labels[owner]
    seen = (count == 1) | (np.minimum.reduceat(label, starts) != np.maximum.reduceat(label, starts))
    if normals is not None:
        turn = np.abs((normals[owner] * np.repeat(normals[owner[starts]], count, axis=0)).sum(axis=1))
        seen |= np.minimum.reduceat(turn, starts) < SHARP_COSINE
    return pairs[starts[seen]]


def reference_points(mesh: PolyData) -> np.ndarray:
    """Undeformed positions [m]; the present ones where the file has no displacement."""
    displacement = mesh.point_data.get("displacement")
    return mesh.points if displacement is None or displacement.ndim != 2 else mesh.points - displacement


def fragment_edges(mesh: PolyData) -> np.ndarray:
    """Edges (k, 2) along which the shell's fragments, or their outer border, end."""
    return edges(mesh.triangles, weld(reference_points(mesh)), mesh.of_triangles("fragment", 0), None)


def _divided(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles halved until no edge is longer than LONGEST_STATIC_M; also which one each came from."""
    corner, source = points[triangles], np.arange(len(triangles))
    for _ in range(16):
        length = np.linalg.norm(corner[:, [1, 2, 0]] - corner, axis=2)
        long = length.max(axis=1) > LONGEST_STATIC_M
        if not long.any() or len(corner) > 20_000:
            break
        k = length[long].argmax(axis=1)[:, None] + np.arange(3)  # longest edge first
        c = np.take_along_axis(corner[long], (k % 3)[:, :, None], axis=1)
        middle = 0.5 * (c[:, 0] + c[:, 1])
        corner = np.concatenate([corner[~long], np.stack([c[:, 0], middle, c[:, 2]], axis=1),
                                 np.stack([middle, c[:, 1], c[:, 2]], axis=1)])
        source = np.concatenate([source[~long], source[long], source[long]])
    return corner.reshape(-1, 3), np.arange(3 * len(corner)).reshape(-1, 3), source


def _ball_centres(points: np.ndarray, triangles: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Per triangle the centre of its body if that is a ball, else NaN."""
    centres = np.full((len(triangles), 3), np.nan)
    for one in np.unique(body):
        mine = body == one
        corner = np.unique(points[np.unique(triangles[mine])].round(9), axis=0)
        if len(corner) < 20:
            continue
        centre = 0.5 * (corner.min(axis=0) + corner.max(axis=0))
        radius = np.linalg.norm(corner - centre, axis=1)
        if radius.std() < 0.02 * radius.mean():
            centres[mine] = centre
    return centres


def _join(parts: list[Surface]) -> Surface:
    shifts = np.cumsum([0] + [len(part.points) for part in parts])
    return Surface(np.concatenate([p.points for p in parts]),
                   np.concatenate([p.triangles + shift for p, shift in zip(parts, shifts)]),
                   np.concatenate([p.colours for p in parts]), np.concatenate([p.round_centre for p in parts]),
                   np.concatenate([p.is_floor for p in parts]))


def _surface(points: np.ndarray, triangles: np.ndarray, colours: np.ndarray) -> Surface:
    return Surface(points, triangles, colours, np.full((len(triangles), 3), np.nan), np.zeros(len(triangles), bool))


def load_scene(frame: Frame) -> Scene:
    """Reads a frame's files. Raises VtpError, OSError."""
    glass, solid, cracks, outlines = [Surface()], [Surface()], [np.zeros((0, 2, 3))], [np.zeros((0, 2, 3))]
    shards = moving = np.zeros((0, 3))
    floor_z: float | None = None
    shell = frame.read(SHELL)
    if shell is not None and len(shell.triangles):
        fragment = shell.of_triangles("fragment", 0)
        counts = np.unique(fragment, return_counts=True)
        ids = np.where(fragment == counts[0][counts[1].argmax()], 0, fragment + 1)  # the largest keeps the base colour
        glass.append(_surface(shell.points, shell.triangles, varied(ids, GLASS, 0.10)))
        cracks.append(shell.points[fragment_edges(shell)])
    lines = frame.read(CRACKS)
    if lines is not None:
        cracks.append(lines.points[lines.segments()])
    bodies = frame.read(BODIES)
    if bodies is not None and len(bodies.triangles):
        kind, body = bodies.of_triangles("kind", MOVING), bodies.of_triangles("body", 0)
        broken = (kind == SHARD) | (kind == FROZEN)
        if broken.any():
            part = _surface(bodies.points, bodies.triangles[broken],
                            varied(np.where(kind == FROZEN, 0, body + 1)[broken], GLASS, 0.14))
            glass.append(part)
            owner = np.zeros(len(bodies.points), np.int64)
            owner[bodies.triangles.ravel()] = np.repeat(body, 3)
            found = edges(part.triangles, weld(bodies.points, owner), body[broken], part.normals())
            outlines.append(bodies.points[found])
        shards = bodies.points[np.unique(bodies.triangles[kind == SHARD])]
        own = kind == MOVING
        moving = bodies.points[np.unique(bodies.triangles[own])]
        if own.any():
            part = _surface(bodies.points, bodies.triangles[own], varied(body[own] * 0, STEEL, 0.0))
            part.round_centre = _ball_centres(bodies.points, part.triangles, body[own])
            solid.append(part)
        fixed = kind == STATIC
        if fixed.any():
            points, triangles, _ = _divided(bodies.points, bodies.triangles[fixed])
            part = _surface(points, triangles, np.broadcast_to(FLOOR, (len(triangles), 3)))
            level = np.abs(part.normals()[:, 2]) > 0.999
            if level.any():
                height = points[triangles][:, :, 2].mean(axis=1)
                part.is_floor = level & (height < height[level].min() + 1e-4)
                floor_z = float(height[level].min())
            solid.append(part)
    return Scene(_join(glass), _join(solid), np.concatenate(cracks), np.concatenate(outlines), shards, moving, floor_z)
