"""Frames between those of a run: resampled in time, for films and exports with --speed.

A frame between keeps the triangles of the one before it. The centres of mass of its bodies go straight on, and bodies turn
evenly about them. Points of shells go straight to where the next frame has them.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..errors import BAD_INPUT, CommandError
from .frames import BODIES, CARRIED, CRACKS, SHELL, SOFT, Frame
from .mesh import part_of_points
from .meshes import reference_points
from .motion import by_body, shell_velocity
from .rigid import centre_of_mass, fit, share_of_turn
from .vtp import PolyData

FPS = 24.0
MOST_FRAMES = 100_000  # more than an hour of film
SAME_PLACE = 1e-9      # [-] of a shell's size: points at rest that are nearer are one
KEPT = 2                # intervals that keep what they have read
PASSES = 12            # in which corrections spread to points that the next frame does not have
RIGID = 1e-6           # [-] of a body's size: what a fit may leave of a rigid body
CLOSE = 2.0 ** -22     # [-] of a film: two spacings of single precision


def _keys(shell: PolyData, size: float) -> np.ndarray:
    """Returns a value per point (n,), equal for the same point of the same shell at rest."""
    cell = np.column_stack([np.round(reference_points(shell) / (SAME_PLACE * size)).astype(np.int64), part_of_points(shell)])
    return np.ascontiguousarray(cell).view([("", np.int64)] * 4).ravel()


def ends(shell: PolyData, after: PolyData | None, bodies: PolyData | None, seconds: float) -> np.ndarray:
    """Returns where the points (n, 3) of a shell are `seconds` later [m].

    It is where the next frame has the same point at rest. Cracks that have grown move and double points: those go on
    with their velocity, and with the correction that neighbours needed. A piece that is a body by then ends at its centre.
    """
    forward = shell.points + seconds * shell_velocity(shell)
    known = np.zeros(len(forward), bool)
    correction = np.zeros_like(forward)
    if after is not None and len(after.points):
        size = float(np.ptp(reference_points(shell), axis=0).max()) or 1.0
        mine, theirs = _keys(shell, size), _keys(after, size)
        values, first = np.unique(theirs, return_index=True)
        at = np.minimum(np.searchsorted(values, mine), len(values) - 1)
        known = values[at] == mine
        correction[known] = after.points[first[at[known]]] - forward[known]
    _spread(shell.triangles, known, correction)
    if bodies is not None:
        _end_at_bodies(shell, forward, known, correction, bodies)
    return forward + correction


def _spread(triangles: np.ndarray, known: np.ndarray, correction: np.ndarray) -> None:
    """Gives points that are not known the mean correction of their neighbours, outwards from the known ones."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    settled = known.copy()
    for _ in range(PASSES):
        here = pairs[~settled[pairs[:, 0]] & settled[pairs[:, 1]]]
        if not len(here):
            return
        count = np.bincount(here[:, 0], minlength=len(known))
        fresh = count > 0
        for axis in range(3):
            sums = np.bincount(here[:, 0], correction[here[:, 1], axis], len(known))
            correction[fresh, axis] = sums[fresh] / count[fresh]
        settled |= fresh


def _end_at_bodies(shell: PolyData, forward: np.ndarray, known: np.ndarray, correction: np.ndarray, bodies: PolyData) -> None:
    """Corrects pieces of which the next frame has a body and no point."""
    piece, rest = shell.of_triangles("fragment", 0).astype(np.int64), reference_points(shell)
    body, points = bodies.of_triangles("body", 0).astype(np.int64), by_body(bodies)
    number = np.zeros(len(bodies.points), np.int64)
    for one in set(np.unique(piece).tolist()) & set(points):
        mine = shell.triangles[piece == one]
        used = np.unique(mine)
        if known[used].any():
            continue
        number[points[one]] = np.arange(len(points[one]))
        centre = centre_of_mass(bodies.points[points[one]], number[bodies.triangles[body == one]])
        correction[used] = centre - centre_of_sheet(forward, mine, rest)


def centre_of_sheet(points: np.ndarray, triangles: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Returns the centre [m] of the area at rest, and so of the mass; `rest` (n, 3) [m] are the points at rest."""
    corner, flat = points[triangles], rest[triangles]
    area = np.linalg.norm(np.cross(flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]), axis=1)
    if not area.sum() > 0.0:
        return corner.mean(axis=(0, 1))
    return (area[:, None] * corner.mean(axis=1)).sum(axis=0) / area.sum()


@dataclass(frozen=True)
class _Move:
    """The motion of a body: its number, its points, its centre of mass (3,) [m], its rotation (3, 3) about it, the way (3,) of
    it [m]."""
    body: int
    mine: np.ndarray
    centre: np.ndarray
    turn: np.ndarray
    way: np.ndarray

    def moved(self, points: np.ndarray, share: float) -> np.ndarray:
        """Returns where points (..., 3) of the body are after this share of its motion."""
        return (points - self.centre) @ share_of_turn(self.turn, share).T + self.centre + share * self.way


@dataclass(frozen=True, eq=False)
class Interval:
    """Two frames that follow one another. The last ones that were asked keep what they have read."""
    before: Frame
    after: Frame

    def _remember(self) -> None:
        if self in _recent:
            return
        _recent.append(self)
        if len(_recent) > KEPT:
            forgotten = _recent.pop(0)
            for name in ("_shell", "_soft", "_bodies"):
                vars(forgotten).pop(name, None)

    @cached_property
    def _shell(self) -> tuple[PolyData, np.ndarray] | None:
        shell = self.before.read(SHELL)
        if shell is None:
            return None
        return shell, ends(shell, self.after.read(SHELL), self.after.read(BODIES), self.after.time_s - self.before.time_s)

    @cached_property
    def _soft(self) -> tuple[PolyData, PolyData] | None:
        pair = self.before.read(SOFT), self.after.read(SOFT)
        if pair[0] is None or pair[1] is None or len(pair[0].points) != len(pair[1].points):
            return None
        return pair[0], pair[1]

    @cached_property
    def _bodies(self) -> tuple[PolyData, list[_Move]] | None:
        """Bodies, and those that move."""
        bodies, after = self.before.read(BODIES), self.after.read(BODIES)
        if bodies is None:
            return None
        then, moves = by_body(after) if after is not None else {}, []
        body, number = bodies.of_triangles("body", 0).astype(np.int64), np.zeros(len(bodies.points), np.int64)
        for one, mine in by_body(bodies).items():
            theirs = then.get(one)
            if after is None or theirs is None or len(theirs) != len(mine):
                continue
            here, there = bodies.points[mine], after.points[theirs]
            turn, left = fit(here, there)
            if left <= RIGID * np.ptp(here, axis=0).max():
                number[mine] = np.arange(len(mine))
                centre, middle = centre_of_mass(here, number[bodies.triangles[body == one]]), here.mean(axis=0)
                moves.append(_Move(int(one), mine, centre, turn, there.mean(axis=0) + turn @ (centre - middle) - centre))
        return bodies, moves

    def shell_at(self, share: float) -> PolyData | None:
        """Returns the shells after this share of the interval. Raises VtpError, OSError."""
        self._remember()
        if self._shell is None:
            return None
        shell, end = self._shell
        way = share * (end - shell.points)
        data = dict(shell.point_data)
        if "displacement" in data and data["displacement"].ndim == 2:
            data["displacement"] = data["displacement"] + way
        return replace(shell, points=shell.points + way, point_data=data)

    def bodies_at(self, share: float) -> PolyData | None:
        """Returns the bodies after this share of the interval. Raises VtpError, OSError."""
        self._remember()
        if self._bodies is None:
            return None
        bodies, moves = self._bodies
        points = bodies.points.copy()
        for move in moves:
            points[move.mine] = move.moved(points[move.mine], share)
        data = dict(bodies.point_data)
        if "displacement" in data:
            data["displacement"] = data["displacement"] + points - bodies.points
        return replace(bodies, points=points, point_data=data)

    def carried_at(self, share: float) -> PolyData | None:
        """Returns the crack lines that bodies carry, after this share of the interval. Raises VtpError, OSError."""
        self._remember()
        lines = self.before.read(CARRIED)
        if lines is None or self._bodies is None or "body" not in lines.cell_data:
            return lines
        points, pairs, of_line = lines.points.copy(), lines.segments(), lines.cell_data["body"].astype(np.int64)
        for move in self._bodies[1]:
            mine = pairs[of_line == move.body].ravel()
            points[mine] = move.moved(points[mine], share)
        return _shifted(lines, points)

    def cracks_at(self, share: float) -> PolyData | None:
        """Returns the cracks after this share of the interval. Those of laminates move, to where the next frame has the same
        line. Raises VtpError, OSError."""
        lines, after = self.before.read(CRACKS), self.after.read(CRACKS)
        if lines is None or after is None or not any(
                mesh.point_data.get("displacement", np.zeros(0)).any() for mesh in (lines, after)):
            return lines
        there = {key: pair for key, pair in zip(_line_keys(after), after.segments())}
        points = lines.points.copy()
        for key, pair in zip(_line_keys(lines), lines.segments()):
            if key in there:
                points[pair] += share * (after.points[there[key]] - points[pair])
        return _shifted(lines, points)

    def soft_at(self, share: float) -> PolyData | None:
        """Returns the particles after this share of the interval. Raises VtpError, OSError."""
        self._remember()
        if self._soft is None:
            return self.before.read(SOFT)
        before, after = self._soft
        return replace(before, points=(1.0 - share) * before.points + share * after.points)


def _line_keys(lines: PolyData) -> list[bytes]:
    """Returns what tells a crack's line from others: its shell and the parameters of its ends."""
    pairs = lines.segments()
    shell = lines.cell_data.get("shell", np.zeros(len(pairs)))
    ends_of = lines.point_data.get("parameter", reference_points(lines))[pairs].reshape(len(pairs), -1)
    return [row.tobytes() for row in np.column_stack([shell, ends_of]).astype(float)]


def _shifted(mesh: PolyData, points: np.ndarray) -> PolyData:
    """Returns the mesh with its points elsewhere, and their displacements with them."""
    data = dict(mesh.point_data)
    if "displacement" in data:
        data["displacement"] = data["displacement"] + points - mesh.points
    return replace(mesh, points=points, point_data=data)


_recent: list[Interval] = []


@dataclass(frozen=True, kw_only=True)
class Between(Frame):
    """A time between two frames of a run."""
    interval: Interval
    share: float

    def read(self, part: int) -> PolyData | None:
        """As a frame of the run does it."""
        made = {SHELL: self.interval.shell_at, CRACKS: self.interval.cracks_at, BODIES: self.interval.bodies_at,
                SOFT: self.interval.soft_at, CARRIED: self.interval.carried_at}.get(part)
        return made(self.share) if made is not None else super().read(part)


def _pictures(frames: list[Frame], rate: float, speed: float) -> int:
    """Returns the number of pictures of a film after the first. Raises CommandError where there are more than MOST_FRAMES."""
    whole = (frames[-1].time_s - frames[0].time_s) / (speed / rate)
    if whole >= MOST_FRAMES:
        raise CommandError(f"--speed {speed:g} with --fps {rate:g} gives {whole:.0f} frames; at most {MOST_FRAMES}; take a higher "
                           "--speed", BAD_INPUT)
    return int(whole + 1e-9)


def film_frames(frames: list[Frame], fps: float | None, speed: float | None) -> tuple[list[Frame], np.ndarray]:
    """Returns a frame for each picture of a film in which time runs `speed` times as fast, and their times in it [s], from 0 on.
    Raises CommandError.

    Without `speed` the frames are those of the run, each a picture, whatever time lies between them.
    """
    rate = fps or FPS
    if speed is None:
        return frames, np.arange(len(frames)) / rate
    first, last = frames[0].time_s, frames[-1].time_s
    out: list[Frame] = []
    k = 0
    intervals = [Interval(a, b) for a, b in zip(frames, frames[1:])]
    for j in range(_pictures(frames, rate, speed) + 1):
        time_s = min(first + j * (speed / rate), last)
        while k + 1 < len(frames) and frames[k + 1].time_s <= time_s * (1 + 1e-12):
            k += 1
        if k + 1 == len(frames):
            out.append(frames[k])
            break
        share = (time_s - frames[k].time_s) / (frames[k + 1].time_s - frames[k].time_s)
        out.append(frames[k] if share < 1e-9 else _between(intervals[k], time_s))
    return out, (np.array([frame.time_s for frame in out]) - first) / speed


def _between(interval: Interval, time_s: float) -> Between:
    """Returns the frame at a time in an interval."""
    before = interval.before
    share = (time_s - before.time_s) / (interval.after.time_s - before.time_s)
    return Between(time_s, before.files, before.step, interval=interval, share=share)


def key_frames(frames: list[Frame], fps: float | None, speed: float | None) -> tuple[list[Frame], np.ndarray]:
    """Returns the frames from which straight lines lead through all pictures of a film, and their times in it [s]. Raises
    CommandError.

    These are frames of the run, however many pictures there are. Where one picture lies between two of them, it is taken in
    their place; what lies between two pictures is left out. The first and the last frame are there. Times are apart in single
    precision, as files have them. Without `speed` it is `film_frames`.
    """
    if speed is None:
        return film_frames(frames, fps, None)
    rate = fps or FPS
    pictures, step, first = _pictures(frames, rate, speed), speed / rate, frames[0].time_s
    codes = (np.array([frame.time_s for frame in frames]) - first) / step
    near = CLOSE * max(float(codes[-1]), 1.0)
    kept = [k for k in range(len(frames)) if k + 1 == len(frames) or codes[k + 1] - codes[k] > near]
    codes = np.where(np.abs(codes - np.rint(codes)) < near, np.rint(codes), codes)  # a frame is the picture of its time
    found: dict[float, Frame] = {}
    for a, b in zip(kept, kept[1:]):
        begin, end = int(np.floor(codes[a])) + 1, min(int(np.ceil(codes[b])) - 1, pictures)
        if end > begin:
            found[float(codes[a])], found[float(codes[b])] = frames[a], frames[b]
        elif end == begin:
            found[float(begin)] = _between(Interval(frames[a], frames[b]), first + begin * step)
        for k in (a, b):
            if codes[k] == np.rint(codes[k]):
                found[float(codes[k])] = frames[k]
    found.setdefault(float(codes[kept[0]]), frames[kept[0]])
    found.setdefault(float(codes[kept[-1]]), frames[kept[-1]])
    at = sorted(found)
    return [found[code] for code in at], np.array(at) / rate
