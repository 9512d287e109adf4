"""Prepares a frame for drawing: glass and solid triangles, their colours, and the lines on them."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .frames import BODIES, CARRIED, CRACKS, FROZEN, MOVING, SHARD, SHELL, SOFT, STATIC, Frame
from .ground import Ground
from .look import Look, parts_of_bodies
from .mesh import origin_of_triangles
from .motion import reference_points as reference_points  # others import it from here
from .motion import shell_velocity
from .palette import GLASS, STEEL, is_glass, part_colours, pastel, ramp, varied
from .seams import off_seams
from .sheets import sheet_of, sides_of_pieces
from .soft import balls, colours as soft_colours, speeds
from .thick import CREASE_COSINE, EDGE, INSIDE, OTHER, vertex_normals
from .vtp import PolyData

WELD_M = 1e-6  # nearer points are one when lines are searched
SAME_SHARE = 0.02  # of the usual side of a triangle: ends of shells on either side of a seam are as near at rest
SHARP_COSINE = 0.8  # edges between faces that turn by more than 37 degrees are drawn
LONGEST_STATIC_M = 0.12  # static triangles are divided to this size, so that none reaches behind the eye
FLOOR = np.array([0.87, 0.87, 0.86])
DEBRIS = np.array([0.66, 0.69, 0.71])  # shards of an unknown shell of several
CLEAR, COLOURED = 0.30, 0.70  # opacity of glass: as it is, and with the colours of a quantity
VARIED = 0.05  # lightness of pieces, by their id: a piece keeps its colour from the shell to its rest
PALE = np.array([0.90, 0.92, 0.92])    # the largest fragment


@dataclass
class Surface:
    """Triangles of one kind. `round_centre` is the centre of the ball that a triangle belongs to, otherwise NaN."""
    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))          # [m]
    triangles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), int))
    colours: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))         # per triangle, 0..1
    round_centre: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))    # per triangle [m]
    is_floor: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))       # per triangle
    throws: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))         # per triangle: a shadow
    closed: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))         # per triangle: its back is never seen
    edge: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))           # per triangle: of the edge of a sheet
    smooth: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))          # per point: unit normal, zero or NaN where flat

    def normals(self) -> np.ndarray:
        """Returns unit normals of the triangles; zero for a degenerate one."""
        corner = self.points[self.triangles]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)


@dataclass
class Scene:
    """A frame ready for drawing. Transparent triangles are in `glass`, all others in `solid`."""
    glass: Surface
    solid: Surface
    cracks: np.ndarray      # (k, 2, 3) ends of crack and fragment lines [m]
    outlines: np.ndarray    # (k, 2, 3) sharp edges of shards and frozen remains [m]
    shards: np.ndarray      # (n, 3) corners of shards and soft bodies [m]
    moving: np.ndarray      # (n, 3) corners of the scene's own moving bodies [m]
    floor_z: float | None   # height of the lowest level static face [m]; None: there is none
    glass_opacity: float = CLEAR  # for a view along the normal of the glass
    clear: bool = True           # glass tints and mirrors; otherwise its colours tell a quantity
    ground: Ground | None = None  # below everything
    thickness_m: float = 0.0     # of the thickest shell: lines of its middle surface are seen through half of it
    shard_of: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))  # (n,) of `shards`: numbers, those of soft bodies < 0


def weld(points: np.ndarray, apart: np.ndarray | None = None) -> np.ndarray:
    """Returns a number per point, equal for points at one place with equal `apart`."""
    cell = np.round(points / WELD_M).astype(np.int64)
    if apart is not None:
        cell = np.column_stack([cell, np.asarray(apart, np.int64)])
    cell = np.ascontiguousarray(cell)
    whole = cell.view([("", np.int64)] * cell.shape[1]).ravel()  # a row as one value, so that none collide
    return np.unique(whole, return_inverse=True)[1]


def edges(triangles: np.ndarray, same: np.ndarray, labels: np.ndarray, normals: np.ndarray | None) -> np.ndarray:
    """Returns the visible edges (k, 2) of a mesh: its border, changes of the label, sharp edges.

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


def fragment_edges(mesh: PolyData, mine: np.ndarray | slice = slice(None)) -> np.ndarray:
    """Returns edges (k, 2) at borders of the shells' fragments, of their triangles `mine`, but for seams that hold."""
    own = np.zeros(len(mesh.points), np.int64)  # each shell ends at its seams
    own[mesh.triangles.ravel()] = np.repeat(mesh.of_triangles("shell", 0).astype(np.int64), 3)
    return off_seams(mesh, edges(mesh.triangles[mine], weld(reference_points(mesh), own), mesh.of_triangles("fragment", 0)[mine],
                                 None))


def piece_edges(bodies: PolyData, mine: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Returns the visible edges (k, 2) of bodies, of their triangles `mine` (m,) with these normals (m, 3). A piece of several
    shells has lines where it ends, and none along its seams, as before it left them."""
    triangles, body = bodies.triangles[mine], bodies.of_triangles("body", 0).astype(np.int64)[mine]
    shell = origin_of_triangles(bodies)[mine]
    ids, inverse = np.unique(body, return_inverse=True)
    low, high, first = np.full(len(ids), 1 << 30), np.full(len(ids), -1), np.full(len(ids), len(bodies.points))
    np.minimum.at(low, inverse, shell)
    np.maximum.at(high, inverse, shell)
    np.minimum.at(first, inverse, triangles.min(axis=1, initial=len(bodies.points)))
    sewn = ((low >= 0) & (low < high))[inverse]
    owner = np.zeros(len(bodies.points), np.int64)
    owner[triangles.ravel()] = np.repeat(body, 3)
    lines = [edges(triangles[~sewn], weld(bodies.points, owner), body[~sewn], normals[~sewn])]
    faces = sewn & (sides_of_pieces(triangles, first[inverse]) == INSIDE)
    if faces.any():
        inside = triangles[faces]  # of pairs of points, inside before outside
        used, local = np.unique(inside, return_inverse=True)
        rest = reference_points(bodies)
        middle, flat = 0.5 * (rest[used] + rest[used + 1]), local.reshape(-1, 3)
        side = np.linalg.norm(middle[flat] - middle[flat[:, [1, 2, 0]]], axis=2)
        ends = edges(flat, weld(middle / (SAME_SHARE * np.median(side)) * WELD_M, owner[used]), body[faces], None)
        lines += [used[ends], used[ends] + 1]
    return np.concatenate(lines)


def lines_in_place(lines: PolyData, shell: PolyData | None) -> np.ndarray:
    """Returns the segments (k, 2) of crack lines that lie where the shells are. Lines are of the shells at rest: once a shell
    has moved they hang in the air, and its cracks are seen as edges of its mesh (`fragment_edges`), which moves. Lines of a
    laminated shell move with it, and its mesh has no gaps."""
    segments = lines.segments()
    if shell is None or not len(segments) or "shell" not in lines.cell_data:
        return segments
    of_line = lines.cell_data["shell"].astype(np.int64)
    if len(of_line) != len(segments):
        return segments
    of_triangle, moved = shell.of_triangles("shell", 0).astype(np.int64), shell.point_data.get("displacement")
    carried = lines.point_data.get("displacement")
    keep = np.zeros(len(segments), bool)
    for one in np.unique(of_line):
        mine, here = of_line == one, np.unique(shell.triangles[of_triangle == one])
        at_rest = moved is None or (len(here) > 0 and not moved[here].any())
        keep |= mine & (at_rest or (carried is not None and carried[segments].any(axis=(1, 2))))
    return np.asarray(segments[keep])


def thickness_of_lines(lines: PolyData, thickness: tuple[float, ...]) -> float:
    """Returns the largest thickness [m] of the shells of crack lines, 0 where it is not known."""
    of_line = np.unique(lines.cell_data.get("shell", np.zeros(0)).astype(np.int64))
    return max((thickness[k] for k in of_line if 0 <= k < len(thickness) and thickness[k] == thickness[k]), default=0.0)


def _divided(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Halves triangles until no edge is longer than LONGEST_STATIC_M. Also returns the original triangle of each."""
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
    """Returns, for each triangle, the centre of its body if that is a ball, otherwise NaN."""
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


def _shaded_shards(points: np.ndarray, triangles: np.ndarray,
                   body: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Returns points, triangles, normals of points, and sides of triangles for shards. The shell process writes shards in pairs
    of points, inside before outside (`thicken`, `draw_prisms`). Normals are smooth over both faces and flat at the edge, whose
    corners become points of their own."""
    ids, inverse = np.unique(body, return_inverse=True)
    first = np.full(len(ids), len(points))
    np.minimum.at(first, inverse, triangles.min(axis=1))
    side = sides_of_pieces(triangles, first[inverse])
    face = side != EDGE
    smooth, corner = vertex_normals(points, triangles[face]), points[triangles]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    turned = (smooth[triangles] * across[:, None]).sum(axis=2) < CREASE_COSINE * np.linalg.norm(across, axis=1)[:, None]
    fold = np.zeros(len(points), bool)
    fold[triangles[turned & face[:, None]]] = True
    face &= ~fold[triangles].any(axis=1)  # a fold stays sharp
    normals = np.concatenate([smooth, np.zeros_like(points)])
    return np.concatenate([points, points]), np.where(face[:, None], triangles, triangles + len(points)), normals, side


def _join(parts: list[Surface]) -> Surface:
    shifts = np.cumsum([0] + [len(part.points) for part in parts])
    return Surface(np.concatenate([p.points for p in parts]),
                   np.concatenate([p.triangles + shift for p, shift in zip(parts, shifts)]),
                   np.concatenate([p.colours for p in parts]), np.concatenate([p.round_centre for p in parts]),
                   np.concatenate([p.is_floor for p in parts]), np.concatenate([p.throws for p in parts]),
                   np.concatenate([p.closed for p in parts]), np.concatenate([p.edge for p in parts]),
                   np.concatenate([p.smooth for p in parts]))


def _surface(points: np.ndarray, triangles: np.ndarray, colours: np.ndarray, throws: bool = True) -> Surface:
    return Surface(points, triangles, colours, np.full((len(triangles), 3), np.nan), np.zeros(len(triangles), bool),
                   np.full(len(triangles), throws), np.zeros(len(triangles), bool), np.zeros(len(triangles), bool),
                   np.full_like(points, np.nan))


def _sheet(points: np.ndarray, triangles: np.ndarray, colours: np.ndarray, smooth: np.ndarray, side: np.ndarray) -> Surface:
    """Makes the surface of a sheet with thickness. One of its faces is enough for its shadow."""
    out = _surface(points, triangles, colours)
    out.smooth, out.throws, out.edge = smooth, side != INSIDE, side == EDGE
    return out


def _shell_colours(shell: PolyData, look: Look, part: np.ndarray, several: bool) -> np.ndarray:
    fragment = shell.of_triangles("fragment", 0)
    ids, inverse, counts = np.unique(fragment, return_inverse=True, return_counts=True)
    largest = (np.arange(len(ids)) == counts.argmax())[inverse]
    if look.by == "fragment":
        return np.where(largest[:, None], PALE, pastel(fragment))
    if look.by == "damage":
        damage = shell.of_triangles("damage", 0.0)
        return ramp(damage.max(axis=1) if damage.ndim == 2 else damage)
    if look.by == "speed":
        speed = np.linalg.norm(shell_velocity(shell), axis=1)[shell.triangles].mean(axis=1)
        return ramp(speed / look.fastest)
    return varied(fragment, part_colours(part, look.colours) if several or look.colours else GLASS, VARIED)


def _broken_colours(body: np.ndarray, frozen: np.ndarray, look: Look, part: np.ndarray, several: bool,
                    speed: np.ndarray) -> np.ndarray:
    if look.by == "fragment":
        return np.where(frozen[:, None], PALE, pastel(body))
    if look.by == "damage":
        return ramp(np.zeros(len(body)))  # frames have no value for detached pieces
    if look.by == "speed":
        return ramp(speed / look.fastest)
    if several:
        base = np.where((part >= 0)[:, None], part_colours(np.maximum(part, 0), look.colours), DEBRIS)
    else:
        base = np.array(look.colours[0]) if look.colours else GLASS
    return varied(body, base, VARIED)


def _body_colours(body: np.ndarray, look: Look, base: np.ndarray) -> np.ndarray:
    """Returns colours (n, 3) of bodies of the scene by their numbers (n,); `base` of those that name no material."""
    return _of_bodies(body, np.array([base, *(colour[:3] if colour else base for colour in look.bodies)]))


def _of_bodies(body: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Returns the row of `table` for each of the bodies (n,); the first row for those that are not of the scene."""
    number = body.astype(np.int64)
    return np.asarray(table[np.where((number > 0) & (number < len(table)), number, 0)])


def _parted(whole: Surface, clear: np.ndarray, glass: list[Surface], solid: list[Surface]) -> None:
    """Adds the triangles `clear` (n,) of a surface to `glass`, the others to `solid`."""
    if not clear.any():
        solid.append(whole)
        return
    for where, surfaces in ((clear, glass), (~clear, solid)):
        if where.any():
            used, local = np.unique(whole.triangles[where], return_inverse=True)
            surfaces.append(Surface(whole.points[used], local.reshape(-1, 3), whole.colours[where], whole.round_centre[where],
                                    whole.is_floor[where], whole.throws[where], whole.closed[where], whole.edge[where],
                                    whole.smooth[used]))


def load_scene(frame: Frame, look: Look = Look(), velocity: np.ndarray | None = None) -> Scene:
    """Reads the files of a frame. `velocity` (n, 3) [m/s] of bodies' points is for colours by speed. Raises
    VtpError, OSError.

    A shell is seen through where its material is glass, as are its shards. Others are opaque and have a colour each.
    A lone shell of which the scene is not known is drawn as glass.
    """
    glass, solid, cracks, outlines = [Surface()], [Surface()], [np.zeros((0, 2, 3))], [np.zeros((0, 2, 3))]
    shards: np.ndarray = np.zeros((0, 3))
    shard_of: np.ndarray = np.zeros(0, np.int64)
    moving: np.ndarray = np.zeros((0, 3))
    floor_z: float | None = None
    thickness_m = 0.0
    shell = frame.read(SHELL)
    several = len(look.glass) > 1 or not all(look.glass)
    if shell is not None and len(shell.triangles):
        part = shell.of_triangles("shell", 0).astype(np.int64)
        several = several or part.max() > 0
        sheet = sheet_of(shell, look.thickness)
        colours, thickness_m = _shell_colours(shell, look, part, several)[sheet.own], sheet.thickness_m
        clear = is_glass(part, look.glass)[sheet.own] if several else np.ones(len(colours), bool)
        for where, surfaces in ((clear, glass), (~clear, solid)):
            if where.any():
                surfaces.append(_sheet(sheet.points, sheet.triangles[where], colours[where], sheet.smooth, sheet.side[where]))
                surfaces[-1].closed = sheet.side[where] != OTHER
        (outlines if thickness_m else cracks).append(sheet.points[sheet.lines(fragment_edges(shell))])
    lines = frame.read(CRACKS)
    if lines is not None:
        cracks.append(lines.points[lines_in_place(lines, shell)])
    carried = frame.read(CARRIED)
    if carried is not None:
        cracks.append(carried.points[carried.segments()])
        thickness_m = max(thickness_m, thickness_of_lines(carried, look.thickness))
    bodies = frame.read(BODIES)
    if bodies is not None and len(bodies.triangles):
        kind, body = bodies.of_triangles("kind", MOVING), bodies.of_triangles("body", 0)
        speed = np.linalg.norm(velocity, axis=1)[bodies.triangles].mean(axis=1) if velocity is not None else 0.0 * body
        broken = (kind == SHARD) | (kind == FROZEN)
        if broken.any():
            mine = bodies.triangles[broken]
            points, corners, smooth, side = _shaded_shards(bodies.points, mine, body[broken])
            part = origin_of_triangles(bodies)[broken]
            part = np.where(part >= 0, part, parts_of_bodies(body[broken], look.part_of))
            part = look.parts_by_thickness(bodies.points, mine, part)
            part = look.parts_of_frozen(bodies.points, mine, part, (kind == FROZEN)[broken])
            colours = _broken_colours(body[broken], (kind == FROZEN)[broken], look, part, several, speed[broken])
            clear = is_glass(np.maximum(part, 0), look.glass) & (part >= 0) if several else np.ones(len(part), bool)
            for where, surfaces in ((clear, glass), (~clear, solid)):
                if where.any():
                    surfaces.append(_sheet(points, corners[where], colours[where], smooth, side[where]))
            normals = _surface(bodies.points, mine, colours).normals()
            outlines.append(bodies.points[piece_edges(bodies, np.flatnonzero(broken), normals)])
        used, at = np.unique(bodies.triangles[kind == SHARD], return_index=True)
        shards, shard_of = bodies.points[used], np.repeat(body[kind == SHARD], 3)[at].astype(np.int64)
        see_through = _of_bodies(body, np.array([False, *(len(colour) > 3 for colour in look.bodies)]))
        own = kind == MOVING
        moving = bodies.points[np.unique(bodies.triangles[own])]
        if own.any():
            shown = ramp(speed[own] / look.fastest) if look.by == "speed" else _body_colours(body[own], look, STEEL)
            ours = _surface(bodies.points, bodies.triangles[own], shown)
            ours.round_centre = _ball_centres(bodies.points, ours.triangles, body[own])
            _parted(ours, see_through[own], glass, solid)
        fixed = kind == STATIC
        if fixed.any():
            points, triangles, source = _divided(bodies.points, bodies.triangles[fixed])
            ours = _surface(points, triangles, _body_colours(body[fixed][source], look, FLOOR), throws=False)
            level = np.abs(ours.normals()[:, 2]) > 0.999
            if level.any():
                height = points[triangles][:, :, 2].mean(axis=1)
                ours.is_floor = level & (height < height[level].min() + 1e-4)
                floor_z = float(height[level].min())
            _parted(ours, see_through[fixed][source] & ~ours.is_floor, glass, solid)
    soft = frame.read(SOFT)
    if soft is not None and len(soft.points):
        points, triangles, particle, normals = balls(soft)
        shown = ramp(speeds(soft)[particle] / look.fastest) if look.by == "speed" else soft_colours(soft, particle)
        solid.append(_surface(points, triangles, shown))
        solid[-1].smooth = normals
        # a picture must contain these
        moving, shards = np.concatenate([moving, points]), np.concatenate([shards, points])
        own_body = np.zeros(len(points), np.int64)
        own_body[triangles] = -1 - soft.point_data["soft_body"][particle].astype(np.int64)[:, None]
        shard_of = np.concatenate([shard_of, own_body])
    return Scene(_join(glass), _join(solid), np.concatenate(cracks), np.concatenate(outlines), shards, moving, floor_z,
                 CLEAR if look.by == "part" else COLOURED, look.by == "part", thickness_m=thickness_m, shard_of=shard_of)
