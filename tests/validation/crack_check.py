"""Checks that the cracks of a run are consistent over time, from the written frames alone.

    PYTHONPATH=coupler /usr/bin/python3 -m tests.validation.crack_check RUN_FOLDER

An earlier crack edge must be an edge of every later frame. A new one must hang on an earlier one or belong to a crack
that starts. Where a crack ends at another there must be no gap, and no crack runs on top of another. Each shell of a run
has cracks of its own: a crack that goes on over a seam starts there.
"""
from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from sunder_tools.pictures.crack_lines import Graph, graph_of
from sunder_tools.pictures.frames import CRACKS, SHELL, list_frames
from sunder_tools.pictures.meshes import reference_points
from sunder_tools.pictures.vtp import PolyData, VtpError

TOUCH = 1e-6  # spacings: round-off. Joints overshoot by 2e-3, so lines that are meant to meet do cross
GAP = 0.05  # spacings: an end nearer than this that does not touch leaves a gap
ON_TOP = 0.02  # spacings: an edge this near to an earlier one over half of its length cuts nothing new
OF_LENGTH = 0.1  # or this share of a shorter edge, as where a crack crosses two others beside their joint
SAMPLES = 10  # points of an edge
AT_BORDER = 1e-3  # spacings: an end this near to the border has run out
MOST_NOTES = 12  # faults that are described one by one


@dataclass
class Findings:
    """Counts of what the frames show, and counts of faults, which must be zero."""
    frames: int = 0         # with crack lines
    growing: int = 0        # frames with more edges than the one before
    edges: int = 0          # in the last frame
    cracks: int = 0
    starts: int = 0  # connected groups of new edges that touch no earlier edge
    lost: int = 0  # edges that vanish, move or change their crack, and edges that appear after their time
    unconnected: int = 0  # new edges of an old crack that touch no earlier edge
    gaps: int = 0  # end vertices that stop before another edge, each counted once
    apart: int = 0  # cracks whose own edges are not connected
    doubled: int = 0  # edges on top of an earlier one
    notes: list[str] = field(default_factory=list)

    def faults(self) -> int:
        """Returns the number of all faults."""
        return self.lost + self.unconnected + self.gaps + self.apart + self.doubled


def check_folder(folder: Path) -> Findings:
    """Checks all frames of a run folder, shell by shell. Raises VtpError, OSError."""
    graphs: dict[int, list[tuple[float, Graph]]] = {}
    sides: dict[int, tuple[float, np.ndarray, np.ndarray]] = {}
    for frame in list_frames(folder):
        lines = frame.read(CRACKS)
        if lines is None:
            continue
        if not sides:
            first = frame.read(SHELL)
            if first is None:
                raise VtpError(f"{folder}: the first frame has crack lines but no shell")
            of = first.of_triangles("shell", 0)
            for number in np.unique(of).astype(int).tolist():
                own = of == number
                sides[number] = (element_side(first, own), border_of(first, own), bulge_of(first, own))
        graph, of = graph_of(lines, str(frame.files[CRACKS])), np.asarray(lines.cell_data.get("shell", 0)).astype(int)
        if not np.isin(of, list(sides)).all():
            raise VtpError(f"{frame.files[CRACKS]}: a crack of a shell that the first frame has not")
        for number in sides:
            graphs.setdefault(number, []).append((frame.time_s, graph.some(np.broadcast_to(of == number, len(graph)))))
    found = Findings()
    for number, (spacing, border, bulge) in sides.items():
        of_shell = check_graphs(graphs[number], spacing, border, bulge)
        if len(sides) > 1:
            of_shell.notes = [f"shell {number}, {note}" for note in of_shell.notes]
        found = joined(found, of_shell)
    return found


def joined(a: Findings, b: Findings) -> Findings:
    """Combines two shells of a run: adds faults and counts; takes frames and growing frames from the shell with the
    most."""
    sums = {name: getattr(a, name) + getattr(b, name) for name in (
        "edges", "cracks", "starts", "lost", "unconnected", "gaps", "apart", "doubled")}
    return Findings(max(a.frames, b.frames), max(a.growing, b.growing), **sums, notes=(a.notes + b.notes)[:MOST_NOTES])


def element_side(shell: PolyData, of: np.ndarray | None = None) -> float:
    """Returns the side of a square element [m]: two triangles are one element. `of` selects triangles (n,); default:
    all."""
    corner = reference_points(shell)[shell.triangles if of is None else shell.triangles[of]]
    return float(np.sqrt(np.median(np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1))))


def border_of(shell: PolyData, of: np.ndarray) -> np.ndarray:
    """Returns sides (k, 2, 3) [m] at rest of triangles that no other triangle shares. `of` selects triangles (n,);
    default: all."""
    return reference_points(shell)[_outer_sides(shell, of)]


def _outer_sides(shell: PolyData, of: np.ndarray) -> np.ndarray:
    """Returns points (k, 2) of the sides of the triangles `of` that no other of them shares."""
    sides = np.sort(shell.triangles[of][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    pairs, count = np.unique(sides, axis=0, return_counts=True)
    return pairs[count == 1]


def bulge_of(shell: PolyData, of: np.ndarray) -> np.ndarray:
    """Returns how far (k,) [m] a curved border may be off the sides of `border_of`: twice the offset of an arc
    through its neighbours."""
    points, sides = reference_points(shell), _outer_sides(shell, of)
    ends: dict[int, list[int]] = {}
    for a, b in ((int(a), int(b)) for a, b in sides):
        ends.setdefault(a, []).append(b)
        ends.setdefault(b, []).append(a)
    bend = np.zeros(len(points))
    for point, beside in ends.items():
        if len(beside) == 2:
            back, ahead = points[beside[0]] - points[point], points[beside[1]] - points[point]
            if back @ ahead < -0.7 * np.linalg.norm(back) * np.linalg.norm(ahead):  # otherwise a corner
                bend[point] = 0.5 * np.linalg.norm(np.cross(back, ahead)) / np.linalg.norm(ahead - back)
    return bend[sides].max(axis=1, initial=0.0)


def check_graphs(graphs: list[tuple[float, Graph]], spacing: float, border: np.ndarray, bulge: np.ndarray) -> Findings:
    """Checks graphs in order of time. `spacing` is the side of an element [m]. `border` (k, 2, 3) are segments [m];
    the sheet's border is off them by up to `bulge` (k,) [m]."""
    found = Findings()
    gaps: set[bytes] = set()
    apart: set[int] = set()
    before: Graph | None = None
    before_s = -np.inf
    for time_s, now in graphs:
        found.frames += 1
        fresh = np.ones(len(now), bool)
        if before is not None:
            fresh = _compare(found, before, now, before_s, time_s)
            _attach(found, before, now, fresh, spacing, time_s)
        else:
            _attach(found, now.some(np.zeros(len(now), bool)), now, fresh, spacing, time_s)
        found.growing += bool(fresh.any())
        if fresh.any():
            _doubled(found, now, fresh, spacing, time_s)
            for end, text in _gaps(now, spacing, border, bulge):
                if end not in gaps:
                    gaps.add(end)
                    _note(found, time_s, text)
            for number in _cracks_apart(now) - apart:
                apart.add(number)
                _note(found, time_s, f"crack {number} is in pieces")
        before, before_s = now, time_s
    if before is not None:
        found.edges, found.cracks = len(before), len(np.unique(before.crack))
    found.gaps, found.apart = len(gaps), len(apart)
    return found


def _note(found: Findings, time_s: float, text: str) -> None:
    if len(found.notes) < MOST_NOTES:
        found.notes.append(f"at {time_s:.6g} s: {text}")


def _place(point: np.ndarray) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"


def _compare(found: Findings, before: Graph, now: Graph, before_s: float, time_s: float) -> np.ndarray:
    """Checks that earlier edges are still there, each as often as before. Returns which edges are new."""
    left: dict[bytes, int] = {}
    for key in before.keys():
        left[key] = left.get(key, 0) + 1
    fresh = np.ones(len(now), bool)
    for i, key in enumerate(now.keys()):
        if left.get(key, 0) > 0:
            left[key] -= 1
            fresh[i] = False
    for i, key in enumerate(before.keys()):
        if left[key] > 0:
            left[key] -= 1
            found.lost += 1
            _note(found, time_s, f"an edge of crack {before.crack[i]} at {_place(before.ends[i, 0])} is gone or "
                  "changed")
    # frames.pvd has nine digits of time. Cuts are made after the first frame and have its time.
    for i in np.flatnonzero(fresh & (now.born < before_s - 1e-6 * (time_s - before_s))):
        found.lost += 1
        _note(found, time_s, f"an edge of crack {now.crack[i]} at {_place(now.ends[i, 0])}, born at "
              f"{now.born[i]:.6g} s, is not in the frame before")
    return fresh


def _attach(found: Findings, before: Graph, now: Graph, fresh: np.ndarray, spacing: float, time_s: float) -> None:
    """Checks that new edges touch earlier ones, directly or through one another, or start a new crack."""
    new = np.flatnonzero(fresh)
    if len(new) == 0:
        return
    number = now.vertices()
    group = _Groups(len(now))
    old = np.flatnonzero(~fresh)
    for i in old[1:]:
        group.join(old[0], i)
    for i in new:
        shares = (number == number[i, 0]).any(axis=1) | (number == number[i, 1]).any(axis=1)
        for j in np.flatnonzero(shares | (_apart(now.ends[i], now.ends) <= TOUCH * spacing)):
            group.join(i, j)
    root_of_old = group.root(old[0]) if len(old) else -1
    known = set(before.crack.tolist())
    starting = set()
    for i in new:
        root = group.root(i)
        if root == root_of_old:
            continue
        if int(now.crack[i]) in known:
            found.unconnected += 1
            _note(found, time_s, f"a new edge of crack {now.crack[i]} at {_place(now.ends[i, 0])} hangs on nothing")
        else:
            starting.add(root)
    found.starts += len(starting)


def _gaps(now: Graph, spacing: float, border: np.ndarray, bulge: np.ndarray) -> list[tuple[bytes, str]]:
    """Finds end vertices near an edge that touch neither it nor an edge connected to it there."""
    number = now.vertices()
    degree = np.bincount(number.ravel()) if len(now) else np.zeros(0, int)
    gaps = []
    for i, k in zip(*np.nonzero(degree[number] == 1)):
        end = now.ends[i, k]
        is_near = _distance(end, now.ends) < GAP * spacing
        is_near[i] = False
        if not is_near.any() or (_distance(now.rest[i, k], border) < bulge + AT_BORDER * spacing).any():
            continue
        near = np.flatnonzero(is_near)
        # The end has reached the edges that its own edge meets there, and edges connected to these.
        reached = np.concatenate([[i], near[_apart(now.ends[i], now.ends[near]) <= TOUCH * spacing]])
        for j in np.setdiff1d(near, reached):
            if not np.isin(number[j], number[reached]).any() and (
                    _apart(now.ends[j], now.ends[reached]) > TOUCH * spacing).all():
                share = float(_distance(end, now.ends[j:j + 1])[0]) / spacing
                gaps.append((end.tobytes(), f"crack {now.crack[i]} ends at {_place(end)}, {share:.2g} spacings "
                             f"short of crack {now.crack[j]}"))
                break
    return gaps


def _doubled(found: Findings, now: Graph, fresh: np.ndarray, spacing: float, time_s: float) -> None:
    """Finds new edges on top of an earlier one or another new one."""
    order = np.concatenate([np.flatnonzero(~fresh), np.flatnonzero(fresh)])
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    for k in range(int((~fresh).sum()), len(order)):
        a, b = now.ends[order[k]]
        others = now.ends[order[:k]]
        others = others[_distance(0.5 * (a + b), others) < np.linalg.norm(b - a) + ON_TOP * spacing]
        close = min(ON_TOP * spacing, OF_LENGTH * float(np.linalg.norm(b - a)))
        on_top = [_distance(a + s * (b - a), others).min(initial=np.inf) < close for s in share]
        if sum(on_top) > SAMPLES // 2:
            found.doubled += 1
            _note(found, time_s, f"an edge of crack {now.crack[order[k]]} at {_place(a)} runs on top of another")


def _cracks_apart(now: Graph) -> set[int]:
    """Returns numbers of cracks whose edges are not connected at their own vertices."""
    number = now.vertices()
    result = set()
    for crack in np.unique(now.crack):
        own = number[now.crack == crack]
        group = _Groups(int(own.max()) + 1)
        for a, b in own:
            group.join(a, b)
        if len({group.root(v) for v in own.ravel()}) > 1:
            result.add(int(crack))
    return result


class _Groups:
    """Union-find over indices."""

    def __init__(self, count: int) -> None:
        self._parent = list(range(count))

    def root(self, i: int) -> int:
        while self._parent[i] != i:
            self._parent[i] = self._parent[self._parent[i]]
            i = self._parent[i]
        return i

    def join(self, i: int, j: int) -> None:
        a, b = self.root(i), self.root(j)
        self._parent[max(a, b)] = min(a, b)


def _distance(point: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """Returns distances [m] from a point, or from points (n, d) one by one, to segments (n, 2, d)."""
    along = segments[:, 1] - segments[:, 0]
    share = ((point - segments[:, 0]) * along).sum(axis=1) / np.maximum((along ** 2).sum(axis=1), 1e-300)
    return np.linalg.norm(point - segments[:, 0] - np.clip(share, 0.0, 1.0)[:, None] * along, axis=1)


def _apart(segment: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Returns the least distances [m] between a segment (2, 2) and segments (n, 2, 2); 0 where they cross."""
    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        return (q - p)[..., 0] * (r - p)[..., 1] - (q - p)[..., 1] * (r - p)[..., 0]

    a, b = segment
    c, d = others[:, 0], others[:, 1]
    crossing = (side(a, b, c) * side(a, b, d) < 0.0) & (side(c, d, a) * side(c, d, b) < 0.0)
    flat = np.broadcast_to(segment, others.shape)
    nearest = np.minimum(np.minimum(_distance(a, others), _distance(b, others)),
                         np.minimum(_distance(c, flat), _distance(d, flat)))
    return np.where(crossing, 0.0, nearest)


def main(arguments: list[str]) -> int:
    """Prints the findings for the run folder. The exit status is 1 where there is a fault."""
    if len(arguments) != 1:
        print("usage: python3 -m tests.validation.crack_check RUN_FOLDER", file=sys.stderr)
        return 2
    try:
        found = check_folder(Path(arguments[0]))
    except (VtpError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    print(f"{found.frames} frames, {found.growing} with new edges; at the end {found.edges} edges of {found.cracks} "
          f"cracks, {found.starts} started on their own")
    print(f"lost {found.lost}, unconnected {found.unconnected}, gaps {found.gaps}, cracks in pieces {found.apart}, "
          f"doubled {found.doubled}")
    for note in found.notes:
        print(f"  {note}")
    return 1 if found.faults() else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
