"""A run as things that move: each piece, body and soft body with its places over time, and the shapes that it has.

A piece has one name from the frame that shows it first, through hand-off, to the last. While it is in a shell it bends:
its shape has positions of all frames in which its triangles stay the same. Where a crack grows the shape ends, and
another one begins with the next frame. Up to that frame the old one goes on, to where the new one begins.
"""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Iterator

import numpy as np

from ..report.scene_text import Words
from .between import RIGID, centre_of_sheet, ends
from .faces import Slot, face_velocities, faces, over_faces, slots_of
from .frames import BODIES, FROZEN, SHARD, SHELL, SOFT, Frame
from .materials import material_of_body, material_of_shards, name_of_body, slot_name
from .mesh import origin_of_triangles, part_of_points, thickness_of_points
from .meshes import weld
from .motion import by_body, colours, parameters, reference_points
from .rigid import centre_of_mass, fit, quaternion, turn_of
from .soft import balls, look_of_soft
from .thick import EDGE, INSIDE, OTHER, OUTSIDE, corner_normals, sides_of_piece, vertex_normals
from .vtp import PolyData

MOST_STEPS = 60  # positions of one shape: weights of morph targets grow with the square; point caches have no such limit


@dataclass
class Shape:
    """A mesh that is seen in the frames first..last, [m] from its thing's centre, and turned with it.

    `points` has an entry for each of these frames, or one where the shape is rigid. Where another shape follows, one more
    tells where the next frame finds it.
    """
    slots: list[Slot]
    first: int
    last: int
    points: list[np.ndarray]   # (n, 3) each
    normals: list[np.ndarray]  # (n, 3) each
    rest: np.ndarray           # (n, 3) [m] in the world, NaN where there is none
    damage: np.ndarray         # (n,) in the first frame, NaN where there is none
    uv: np.ndarray             # (n, 2) parameters of the shell, 0 to 1, NaN where there are none
    colour: np.ndarray         # (n, 3) red, green, blue of a mesh file, NaN where there is none
    # [m/s] of the run, an entry for each of `points`; none where the shape is rigid or frames have no velocity:
    velocity: list[np.ndarray] = field(default_factory=list)  # (n, 3) each, against the centre
    drift: list[np.ndarray] = field(default_factory=list)     # (3,) of the centre
    state: tuple[object, ...] = ()  # what decides whether the next frame has the same triangles
    # (n,) of a rigid shape, whose triangles share no vertices: equal for those that are one point of the surface
    point: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def rigid(self) -> bool:
        """Tells whether one entry serves all frames."""
        return len(self.points) == 1


@dataclass
class Thing:
    """What has a name. Places are known at the frames of `keys`; `centre` (3,) [m], `turn` quaternions (x, y, z, w)."""
    name: str
    group: str = ""  # the shell that it belongs to
    keys: list[int] = field(default_factory=list)
    centre: list[np.ndarray] = field(default_factory=list)
    turn: list[np.ndarray] = field(default_factory=list)
    shapes: list[Shape] = field(default_factory=list)

    def place(self, k: int, centre: np.ndarray, turn: np.ndarray | None = None) -> None:
        """Sets the place at frame k; one that is known already is replaced."""
        q = np.array([0.0, 0.0, 0.0, 1.0]) if turn is None else quaternion(turn)
        if self.keys and self.keys[-1] == k:
            self.keys.pop(), self.centre.pop(), self.turn.pop()
        if self.turn and self.turn[-1] @ q < 0.0:
            q = -q  # the shorter way round
        self.keys.append(k)
        self.centre.append(centre)
        self.turn.append(q)


@dataclass
class _Rigid:
    """The body as its present shape has it."""
    points: np.ndarray
    triangles: np.ndarray
    centre: np.ndarray
    mean: np.ndarray
    base: np.ndarray  # rotation (3, 3) of the thing with which the shape began


Key = tuple[str, int]  # "piece", "body" or "soft", and the number


@dataclass
class _Moving:
    """A body of a frame."""
    key: Key
    points: np.ndarray
    triangles: np.ndarray  # (m, 3) from these points
    broken: bool           # a piece of shells
    places: np.ndarray     # (n, 8) of its points at rest, their parameters and colours; NaN where it was no piece of a shell
    origin: np.ndarray     # (m,) shell of each triangle, -1: none, or not known


class _Sheets:
    """The shells of a frame, piece by piece. `size` [m]: of the shells in the first frame that has any; 0: this one is it."""

    def __init__(self, frame: Frame, thickness: tuple[float, ...], size: float) -> None:
        self.time_s, self.shell, self.size = frame.time_s, frame.read(SHELL), size
        self.pieces: dict[Key, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}  # points, triangles from these, their numbers
        shell = self.shell
        if shell is None or not len(shell.triangles):
            return
        self.rest, self.part, self.uv = reference_points(shell), part_of_points(shell), parameters(shell)
        self.colour = colours(shell)
        velocity = shell.point_data.get("velocity")
        self.velocity = velocity if velocity is not None and velocity.ndim == 2 else None
        self.size = size or float(np.ptp(self.rest, axis=0).max()) or 1.0
        thick = thickness_of_points(shell, thickness)
        self._half = None if thick is None else 0.5 * thick
        damage = shell.of_triangles("damage", 0.0)
        self._damage = damage.max(axis=1) if damage.ndim == 2 else damage
        piece = shell.of_triangles("fragment", 0).astype(np.int64)
        order = np.argsort(piece, kind="stable")
        ids, starts = np.unique(piece[order], return_index=True)
        for one, mine in zip(ids, np.split(order, starts[1:])):
            used, local = np.unique(shell.triangles[mine], return_inverse=True)
            self.pieces["piece", int(one)] = used, local.reshape(-1, 3), mine

    def half(self, used: np.ndarray) -> np.ndarray:
        """Returns half of the thickness [m] at points; empty where it is not known."""
        return np.zeros(0) if self._half is None else self._half[used]

    def state(self, key: Key) -> tuple[object, ...]:
        """Equal for two frames where a piece has the same triangles of the same points at rest; () where it is not."""
        if key not in self.pieces:
            return ()
        used, triangles, _ = self.pieces[key]
        return triangles.tobytes(), np.round(self.rest[used] / (1e-7 * self.size)).astype(np.int64).tobytes()

    def damage(self, key: Key) -> np.ndarray:
        """Returns the largest damage (n,) of the triangles at each point of a piece."""
        used, triangles, mine = self.pieces[key]
        values = np.zeros(len(used))
        np.maximum.at(values, triangles.ravel(), np.repeat(self._damage[mine], 3))
        return values


class Story:
    """Reads frames one after another into `things`, in the order in which they are seen first."""

    def __init__(self, words: Words, part_of: dict[int, int], middle: bool = False, most_steps: int = MOST_STEPS) -> None:
        self._words, self._part_of, self._most_steps = words, part_of, most_steps
        self._thickness = () if middle else words.thickness
        self._things: dict[Key, Thing] = {}
        self._open: dict[Key, Shape] = {}
        self._rigid: dict[Key, _Rigid] = {}
        self._before: _Sheets | None = None
        self._soft_before: tuple[float, PolyData] | None = None
        self._size = 0.0

    @property
    def things(self) -> list[Thing]:
        """All that was seen."""
        return list(self._things.values())

    def read(self, k: int, frame: Frame) -> None:
        """Adds frame k. Raises VtpError, OSError."""
        now, bodies, soft = _Sheets(frame, self._thickness, self._size), frame.read(BODIES), frame.read(SOFT)
        self._size = now.size
        moving = list(_bodies(bodies))
        self._end_shapes(k, now, bodies, moving)
        for key in now.pieces:
            self._bend(k, key, now)
        for body in moving:
            self._move(k, body)
        seen = {*now.pieces, *(body.key for body in moving)}
        if soft is not None and len(soft.points):
            seen |= self._soften(k, frame.time_s, soft)
        for key in [key for key in self._open if key not in seen]:
            del self._open[key]
        self._before = now

    def _end_shapes(self, k: int, now: _Sheets, bodies: PolyData | None, moving: list[_Moving]) -> None:
        """Ends the shapes of pieces that have other triangles now. They go on to where this frame finds their points."""
        before = self._before
        if before is None or before.shell is None:
            return
        ending = [key for key in before.pieces if key in self._open and (
            self._open[key].state != now.state(key) or len(self._open[key].points) > self._most_steps)]
        if not ending:
            return
        arriving = ends(before.shell, now.shell, bodies, now.time_s - before.time_s)
        centres = {body.key: centre_of_mass(body.points, body.triangles) for body in moving if body.key in ending}
        for key in ending:
            used, triangles, _ = before.pieces[key]
            if key in now.pieces:
                assert now.shell is not None
                here, faces_now, _ = now.pieces[key]
                centres[key] = centre_of_sheet(now.shell.points[here], faces_now, now.rest[here])
            there, shape = arriving[used], self._open.pop(key)
            centre = centres.get(key, centre_of_sheet(there, triangles, before.rest[used]))
            points, normals = faces(there, triangles, before.part[used], before.half(used))
            seconds = now.time_s - before.time_s
            if shape.velocity and seconds > 0.0:  # on the way there; frames of one time leave it open
                shape.drift.append((centre - self._things[key].centre[-1]) / seconds)
                shape.velocity.append((points - centre - shape.points[-1]) / seconds)
            shape.points.append(points - centre)
            shape.normals.append(normals)
            self._things[key].place(k, centre)

    def _thing(self, key: Key, part: int) -> Thing:
        """Returns the thing of this key, named when it is seen first."""
        if key not in self._things:
            shells = self._words.shells
            if key[0] == "piece":
                part = part if part >= 0 else self._part_of.get(key[1], 0 if len(shells) == 1 else -1)
                group = shells[part] if 0 <= part < len(shells) else f"shell_{part}" if part >= 0 else ""
                self._things[key] = Thing(f"{group}_piece_{key[1]}" if group else f"piece_{key[1]}", group)
            elif key[0] == "soft":
                self._things[key] = Thing(f"soft_{key[1]}")
            else:
                self._things[key] = Thing(name_of_body(key[1], self._words))
        return self._things[key]

    def _bend(self, k: int, key: Key, now: _Sheets) -> None:
        """Adds a frame of a piece in a shell."""
        assert now.shell is not None
        used, triangles, _ = now.pieces[key]
        part, half, at = now.part[used], now.half(used), now.shell.points[used]
        centre = centre_of_sheet(at, triangles, now.rest[used])
        points, normals = faces(at, triangles, part, half)
        thing = self._thing(key, int(part.min()))
        thing.place(k, centre)
        shape = self._open.get(key)
        if shape is not None:
            shape.points.append(points - centre)
            shape.normals.append(normals)
            shape.last = k
        else:
            rest, _ = faces(now.rest[used], triangles, part, half)
            damage, uv, colour = (over_faces(values, triangles, part, len(half) > 0)
                                  for values in (now.damage(key), now.uv[used], now.colour[used]))
            shape = Shape(slots_of(triangles, part, len(half) > 0, self._words), k, k, [points - centre], [normals], rest,
                          damage, uv, colour, state=now.state(key))
            thing.shapes.append(shape)
            self._open[key] = shape
        if now.velocity is not None:
            moving = now.velocity[used]
            shape.drift.append(centre_of_sheet(moving, triangles, now.rest[used]))  # as the centre follows from the points
            shape.velocity.append(face_velocities(at, moving, triangles, part, half) - shape.drift[-1])

    def _move(self, k: int, body: _Moving) -> None:
        """Adds a frame of a body."""
        key, points, triangles = body.key, body.points, body.triangles
        thing = self._thing(key, int(body.origin.min()))
        shape, rigid = self._open.get(key), self._rigid.get(key)
        if shape is not None and rigid is not None and len(points) == len(rigid.points) and np.array_equal(
                triangles, rigid.triangles):
            turn, left = fit(rigid.points, points)
            if left <= RIGID * np.ptp(points, axis=0).max():
                thing.place(k, points.mean(axis=0) + turn @ (rigid.centre - rigid.mean), turn @ rigid.base)
                shape.last = k
                return
        centre = centre_of_mass(points, triangles)
        base = turn_of(thing.turn[-1]) if thing.turn else np.eye(3)
        self._rigid[key] = _Rigid(points, triangles, centre, points.mean(axis=0), base)
        thing.place(k, centre, base)
        side = sides_of_piece(points, triangles, body.origin) if body.broken else np.full(len(triangles), OTHER)
        part = body.origin
        if body.broken:
            guess = self._part_of.get(key[1], self._words.shells.index(thing.group) if thing.group in self._words.shells else -1)
            part = np.where(part >= 0, part, guess)
        normals = corner_normals(points, triangles, weld(points))
        # faces of a closed crack in a piece stay apart; points of a body count as one within a millionth of its size
        point = np.arange(len(points)) if body.broken else weld((points - centre) / (float(np.ptp(points, axis=0).max()) or 1.0))
        slots, order, first = [], [], 0
        for of in np.unique(part):
            material, look = (material_of_shards(int(of), self._words) if body.broken
                              else material_of_body(key[1], self._words))
            for one in (OUTSIDE, INSIDE, EDGE, OTHER):
                mine = np.flatnonzero((side == one) & (part == of))
                if len(mine):
                    slots.append(Slot(slot_name(material, one), look, first, 3 * len(mine),
                                      np.arange(3 * len(mine)).reshape(-1, 3)))
                    order.append(mine)
                    first += 3 * len(mine)
        which = np.concatenate(order)
        corners = (points[triangles[which]].reshape(-1, 3) - centre) @ base
        of_corners = body.places[triangles[which]].reshape(-1, 8)
        shape = Shape(slots, k, k, [corners], [normals[which].reshape(-1, 3) @ base], of_corners[:, :3],
                      np.full(len(corners), np.nan), of_corners[:, 3:5], of_corners[:, 5:], point=point[triangles[which]].ravel())
        thing.shapes.append(shape)
        self._open[key] = shape

    def _soften(self, k: int, time_s: float, soft: PolyData) -> set[Key]:
        """Adds a frame of all soft bodies, and returns which they are."""
        now, before = _soft_bodies(soft), self._soft_before
        ending = [key for key, body in now.items() if key in self._open and (
            self._open[key].state != body.state or len(self._open[key].points) > self._most_steps)]
        # balls that are at the surface no more go on with their particles
        arriving = (_soft_bodies(soft, before[1].point_data["surface"]) if before is not None and ending
                    and len(before[1].points) == len(soft.points) else {})
        for key, body in now.items():
            thing = self._thing(key, -1)
            shape, centre, drift = self._open.get(key), body.points.mean(axis=0), body.velocity.mean(axis=0)
            thing.place(k, centre)
            if key in ending:
                shape = self._open.pop(key)
                old = arriving.get(key)
                if old is not None and old.state == shape.state and before is not None:
                    seconds = time_s - before[0]
                    way = old.points - centre - shape.points[-1]
                    shape.velocity.append(way / seconds if seconds > 0.0 else shape.velocity[-1])
                    shape.drift.append((centre - thing.centre[-2]) / seconds if seconds > 0.0 else shape.drift[-1])
                    shape.points.append(old.points - centre)
                    shape.normals.append(vertex_normals(old.points, old.triangles))
                shape = None
            if shape is None:
                count = len(body.points)
                slot = Slot(thing.name, look_of_soft(key[1]), 0, count, body.triangles)
                shape = Shape([slot], k, k, [], [], np.full((count, 3), np.nan), np.full(count, np.nan), np.full((count, 2), np.nan),
                              np.full((count, 3), np.nan), state=body.state)
                thing.shapes.append(shape)
                self._open[key] = shape
            shape.points.append(body.points - centre)
            shape.normals.append(vertex_normals(body.points, body.triangles))
            shape.last = k
            shape.drift.append(drift)
            shape.velocity.append(body.velocity - drift)
        self._soft_before = time_s, soft
        return set(now)


@dataclass
class _Soft:
    """Balls of a soft body: points (n, 3) [m], triangles (m, 3) from them, velocities (n, 3) [m/s], and which particles."""
    points: np.ndarray
    triangles: np.ndarray
    velocity: np.ndarray
    state: tuple[object, ...]


def _soft_bodies(soft: PolyData, surface: np.ndarray | None = None) -> dict[Key, _Soft]:
    """Returns each soft body of a frame; `surface` says which particles are seen, by default those at the surface now."""
    if surface is not None:
        soft = replace(soft, point_data=soft.point_data | {"surface": surface})
    points, triangles, particle, _ = balls(soft)
    velocity = np.zeros_like(points)
    velocity[triangles.ravel()] = np.repeat(soft.point_data["velocity"][particle], 3, axis=0)
    body, found = soft.point_data["soft_body"][particle].astype(int), {}
    for one in np.unique(body):
        used, local = np.unique(triangles[body == one], return_inverse=True)
        found["soft", int(one)] = _Soft(points[used], local.reshape(-1, 3), velocity[used], (particle[body == one].tobytes(),))
    return found


def _bodies(bodies: PolyData | None) -> Iterator[_Moving]:
    """Yields each body of a frame."""
    if bodies is None or not len(bodies.triangles):
        return
    origin = origin_of_triangles(bodies)
    body, kind = bodies.of_triangles("body", 0).astype(np.int64), bodies.of_triangles("kind", 0).astype(int)
    order = np.argsort(body, kind="stable")
    values, starts = np.unique(body[order], return_index=True)
    number = np.zeros(len(bodies.points), np.int64)
    points = by_body(bodies)
    places = np.column_stack([reference_points(bodies), parameters(bodies), colours(bodies)])
    if "displacement" not in bodies.point_data:
        places[:] = np.nan
    for one, which in zip(values, np.split(order, starts[1:])):
        mine, sort = points[int(one)], int(kind[which[0]])
        number[mine] = np.arange(len(mine))
        piece = sort in (SHARD, FROZEN)
        yield _Moving(("piece" if piece else "body", int(one)), bodies.points[mine], number[bodies.triangles[which]], piece,
                      places[mine] if piece else np.full((len(mine), 8), np.nan), origin[which])


def story_of(frames: list[Frame], words: Words, part_of: dict[int, int], middle: bool = False,
             most_steps: int = MOST_STEPS) -> list[Thing]:
    """Returns all things of these frames. Raises VtpError, OSError."""
    story = Story(words, part_of, middle, most_steps)
    for k, frame in enumerate(frames):
        story.read(k, frame)
    return story.things
