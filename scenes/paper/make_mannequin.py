#!/usr/bin/python3
"""Makes the mannequin and the dress of fig16.textproto.

    scenes/paper/make_mannequin.py [--spacing METRES] [SCENE...]

Writes mannequin.obj and mannequin_inflated.obj beside this file: the same points and faces, at rest and inflated. In each
SCENE the lines between `# begin dress` and `# end dress` are replaced. x points to the wearer's left, y to the back, z up
from the hem. The figure is the surface of rounded parts that blend into each other. The dress goes around it at a distance,
in the panels of the garment of Fig. 15 (make_garment.py).
"""
from __future__ import annotations

import argparse
import functools
import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))
sys.path.append(str(Path(__file__).resolve().parent))
import make_garment as garment  # noqa: E402
from make_garment import Panel, fitted, greville, lengths  # noqa: E402
from scene_part import number, replace_part  # noqa: E402
from splines import basis, open_knots  # noqa: E402

FOLDER = Path(__file__).resolve().parent
SPACING_M = 0.0035
THICKNESS_M = 0.005
GAP_M = 0.006      # from the figure to the middle of the dress
CELL_M = 0.022     # of the mesh of the figure
BLEND_M = 0.04     # radius with which parts blend
SWELL = 0.55       # share by which the inflated trunk is wider and deeper
TRUNK_M = 0.20     # half width of the trunk: arms move aside and do not swell
# Heights [m] above the hem: upper edges of the panels, and where straps begin.
UNDERARM_M, STRAP_M, NECK_FRONT_M, NECK_BACK_M = 0.60, 0.72, 0.66, 0.68
HIP_M, FLARE = 0.27, 0.18  # the skirt is this much wider at the hem than at the hip
SHOULDER_M = 0.69  # height of the line about which straps go
SPANS_V, SPANS_STRAP = 16, 12
# Angles [degrees] from the left side on, where panels of front and back end: side, strap, neck, strap, side.
ENDS_DEG = (0.0, 34.0, 50.0, 130.0, 146.0, 180.0)

# Ellipsoids: centre and half axes [m]. Rods: both ends and their radii [m]. Those with an x are there on both sides.
ELLIPSOIDS = [((0, 0.005, 0.25), (0.172, 0.122, 0.15)), ((0, -0.005, 0.41), (0.132, 0.098, 0.17)),
              ((0, 0, 0.60), (0.155, 0.112, 0.19)), ((0.068, -0.082, 0.585), (0.064, 0.056, 0.066)),
              ((0, -0.015, 1.0), (0.078, 0.098, 0.125))]
RODS = [((0.0, 0.005, 0.745), (0.155, 0.01, 0.745), 0.055, 0.048), ((0, 0.012, 0.76), (0, 0.0, 0.92), 0.056, 0.05),
        ((0.088, 0, 0.2), (0.085, 0, -0.28), 0.088, 0.058)]
ARMS = [((0.165, 0.01, 0.745), (0.43, 0.02, 0.63), 0.046, 0.036), ((0.43, 0.02, 0.63), (0.64, -0.05, 0.55), 0.036, 0.026),
        ((0.64, -0.05, 0.55), (0.72, -0.08, 0.52), 0.028, 0.022)]


def _ellipsoid(p: np.ndarray, centre: np.ndarray, half: np.ndarray) -> np.ndarray:
    """A distance that is right to first order near the surface."""
    size = np.linalg.norm((p - centre) / half, axis=-1)
    slope = np.linalg.norm((p - centre) / half ** 2, axis=-1)
    return size * (size - 1.0) / np.maximum(slope, 1e-9)


def _rod(p: np.ndarray, a: np.ndarray, b: np.ndarray, near: float, far: float) -> np.ndarray:
    along = np.clip(((p - a) @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(p - a - along[..., None] * (b - a), axis=-1) - (near + along * (far - near))


def _blend(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The smaller of two distances, rounded where they are alike."""
    share = np.clip(0.5 + 0.5 * (b - a) / BLEND_M, 0.0, 1.0)
    return b + (a - b) * share - BLEND_M * share * (1.0 - share)


def distance(p: np.ndarray, arms: bool = True) -> np.ndarray:
    """Distance [m] of points (..., 3) to the figure, negative inside."""
    mirrored = np.stack([np.abs(p[..., 0]), p[..., 1], p[..., 2]], axis=-1)  # the figure is the same on both sides
    found = [_ellipsoid(mirrored, np.array(c), np.array(h)) for c, h in ELLIPSOIDS]
    found += [_rod(mirrored, np.array(a), np.array(b), *radii) for a, b, *radii in RODS + (ARMS if arms else [])]
    out = found[0]
    for other in found[1:]:
        out = _blend(out, other)
    return out


def _gradient(p: np.ndarray) -> np.ndarray:
    step = 1e-5
    return np.stack([(distance(p + step * e) - distance(p - step * e)) / (2.0 * step) for e in np.eye(3)], axis=-1)


def figure() -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and triangles of the figure's surface, by surface nets: a point in each cell that it passes."""
    low, high = np.array([-0.81, -0.25, -0.42]), np.array([0.81, 0.25, 1.20])
    count = np.ceil((high - low) / CELL_M).astype(int) + 1
    grid = low + CELL_M * np.stack(np.meshgrid(*(np.arange(n) for n in count), indexing="ij"), axis=-1)
    value = distance(grid)
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    n = count - 1
    around = np.stack([value[i:i + n[0], j:j + n[1], k:k + n[2]] for i, j, k in corners], axis=-1)
    passed = (around.min(axis=-1) < 0.0) & (around.max(axis=-1) >= 0.0)
    index = np.full(tuple(n), -1)
    index[passed] = np.arange(int(passed.sum()))
    points = grid[:-1, :-1, :-1][passed] + 0.5 * CELL_M
    triangles = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        step = np.eye(3, dtype=int)
        first = value[tuple(slice(0, s - (1 if d == axis else 0)) for d, s in enumerate(count))]
        second = value[tuple(slice(1 if d == axis else 0, None) for d in range(3))]
        for place in np.argwhere((first < 0.0) != (second < 0.0)):
            cells = [place - step[u] - step[v], place - step[v], place, place - step[u]]
            ids = [int(index[tuple(c)]) for c in cells]
            if first[tuple(place)] >= 0.0:
                ids.reverse()
            triangles += [(ids[0], ids[1], ids[2]), (ids[0], ids[2], ids[3])]
    return _settled(points, np.array(triangles)), np.array(triangles)


def _settled(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Points evenly spread over the surface: each goes half of the way to the mean of its neighbours, then to the surface."""
    a, b = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).T
    neighbours = np.bincount(a, minlength=len(points))[:, None]
    for _ in range(12):
        mean = np.stack([np.bincount(a, points[b, d], len(points)) for d in range(3)], axis=-1) / neighbours
        points = 0.5 * (points + mean)
        slope = _gradient(points)
        points = points - (distance(points) / np.maximum((slope * slope).sum(axis=-1), 0.1))[:, None] * slope
    return points


def _ramp(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """Smoothly from 0 at `low` to 1 at `high`."""
    s = np.clip((x - low) / (high - low), 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


def inflated(points: np.ndarray) -> np.ndarray:
    """The points of the inflated figure. Its trunk swells about the axis of the body, most from hip to chest."""
    x, y, z = points.T
    swell = SWELL * _ramp(z, -0.02, 0.22) * (1.0 - _ramp(z, 0.56, 0.75))
    return np.stack([x + swell * np.clip(x, -TRUNK_M, TRUNK_M), y * (1.0 + swell * (1.0 - _ramp(np.abs(x), 0.18, 0.4))), z],
                    axis=-1)


@functools.cache
def _outlines() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heights (h,) and angles (a,), and distances [m] (h, a) from the axis of the convex line around the trunk, GAP_M off."""
    heights, turn = np.linspace(0.0, STRAP_M, 121), np.linspace(-np.pi, np.pi, 361)
    way = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=-1)
    up = heights[:, None, None] * np.array([0.0, 0.0, 1.0])
    inside, outside = np.zeros((len(heights), len(turn))), np.full((len(heights), len(turn)), 0.5)
    for _ in range(24):
        middle = 0.5 * (inside + outside)
        inner = distance(middle[..., None] * way + up, arms=False) < GAP_M
        inside, outside = np.where(inner, middle, inside), np.where(inner, outside, middle)
    support = (outside[:, :, None] * np.cos(turn[:, None] - turn[None, :])).max(axis=1)  # in each direction
    facing = np.maximum(np.cos(turn[:, None] - turn[None, :]), 0.05)
    return heights, turn, (support[:, None, :] / facing).min(axis=2)


def around(angle: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the dress [m]; angles in radians from the left side to the back."""
    heights, turn, table = _outlines()

    def radius(z: np.ndarray) -> np.ndarray:
        row, column = z / heights[-1] * (len(heights) - 1), (angle - turn[0]) / (turn[1] - turn[0])
        i, j = np.clip(row.astype(int), 0, len(heights) - 2), np.clip(column.astype(int), 0, len(turn) - 2)
        s, t = row - i, column - j
        return ((1 - s) * ((1 - t) * table[i, j] + t * table[i, j + 1]) + s * ((1 - t) * table[i + 1, j] + t * table[i + 1, j + 1]))

    down = np.clip(1.0 - height / HIP_M, 0.0, 1.0)
    skirt = radius(np.full_like(height, HIP_M)) * (1.0 + FLARE * down ** 1.5)  # hangs from the hip
    wide = np.where(down > 0.0, np.maximum(radius(height), skirt), radius(height))
    return np.stack([wide * np.cos(angle), wide * np.sin(angle), height], axis=-1)


def _top(name: str, share: np.ndarray, back: bool) -> np.ndarray:
    """Height [m] of a panel's upper edge at shares 0..1 of its width, from the side on."""
    if name.startswith("strap"):
        return np.full_like(share, STRAP_M)
    if name == "neck":
        low = NECK_BACK_M if back else NECK_FRONT_M
        return STRAP_M - (STRAP_M - low) * 4.0 * share * (1.0 - share)
    rise = share if name == "side_left" else 1.0 - share
    return UNDERARM_M + (STRAP_M - UNDERARM_M) * rise ** 2


def _over_shoulder(front: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """Control points (v, u, 3) of a strap from one edge (u, 3) of control points to the other, over the shoulder."""
    at = greville(SPANS_STRAP) / SPANS_STRAP
    matrix, _ = basis(open_knots(SPANS_STRAP), greville(SPANS_STRAP))
    begin, end = (np.arctan2(row[:, 2] - SHOULDER_M, -row[:, 1]) for row in (front, behind))
    rows = [front]
    for s in at[1:-1]:
        turn = begin + s * (end - begin)
        way = np.stack([np.zeros_like(turn), -np.cos(turn), np.sin(turn)], axis=-1)
        foot = np.stack([(1.0 - s) * front[:, 0] + s * behind[:, 0], np.zeros_like(turn), np.full_like(turn, SHOULDER_M)], axis=-1)
        inside, outside = np.zeros_like(turn), np.full_like(turn, 0.18)
        for _ in range(24):
            middle = 0.5 * (inside + outside)
            inner = distance(foot + middle[:, None] * way) < GAP_M
            inside, outside = np.where(inner, middle, inside), np.where(inner, outside, middle)
        rows.append(foot + outside[:, None] * way)
    rows = np.array([*rows, behind])
    net = np.linalg.solve(matrix, rows.reshape(len(rows), -1)).reshape(rows.shape)
    net[0], net[-1] = front, behind
    return net


def panels() -> list[Panel]:
    """Returns the twelve patches of the dress. v goes up; on straps from the front over the shoulder to the back."""
    out: list[Panel] = []
    for back in (False, True):
        for k, name in enumerate(garment.NAMES):
            spans = garment.SPANS_U[name.partition("_")[0]]
            share, up = np.meshgrid(greville(spans) / spans, greville(SPANS_V) / SPANS_V)
            angle = np.radians(ENDS_DEG[k] + share * (ENDS_DEG[k + 1] - ENDS_DEG[k]))
            height = up * _top(name, share, back)
            points = around(angle if back else -angle, height)
            if not back:
                points = points[:, ::-1]  # turned round, so that normals point outwards as well
            out.append(Panel(f"{'back' if back else 'front'}_{name}", fitted(points)))
    for side in ("left", "right"):
        front, behind = (next(p for p in out if p.name == f"{where}_strap_{side}").net[-1] for where in ("front", "back"))
        out.append(Panel(f"shoulder_{side}", _over_shoulder(front, behind[::-1])))
    return out


def scene_text(spacing_m: float) -> list[str]:
    """Returns the shells; the scene has the material `cloth`."""
    out = []
    for panel in panels():
        (nu, nv), (wide, high) = panel.spans(), lengths(panel)
        counts = [max(1, round(length / (spans * spacing_m))) * spans for length, spans in ((wide, nu), (high, nv))]
        out += ["shells {", f'  name: "{panel.name}"', '  material: "cloth"', f"  thickness_m: {THICKNESS_M:g}", "  nurbs {",
                *(f"    knots_{axis}: [{', '.join(number(k) for k in open_knots(spans))}]" for axis, spans in
                  (("u", nu), ("v", nv))), f"    elements_u: {counts[0]} elements_v: {counts[1]}"]
        out += ["    " + " ".join(f"control_points {{ x: {number(x)} y: {number(y)} z: {number(z)} }}" for x, y, z in row)
                for row in panel.net.round(6)]
        out += ["  }", "}"]
    return out


def write_obj(path: Path, points: np.ndarray, triangles: np.ndarray) -> None:
    """Writes a mesh."""
    lines = ["# made by make_mannequin.py"]
    lines += [f"v {number(x)} {number(y)} {number(z)}" for x, y, z in points.round(5)]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    path.write_text("\n".join(lines) + "\n")


def made_by(spacing_m: float) -> str:
    return f"made by make_mannequin.py --spacing {spacing_m:g}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--spacing", type=float, default=SPACING_M, metavar="METRES", help="size of elements")
    parser.add_argument("scenes", nargs="*", type=Path, metavar="SCENE")
    arguments = parser.parse_args()
    points, triangles = figure()
    write_obj(FOLDER / "mannequin.obj", points, triangles)
    write_obj(FOLDER / "mannequin_inflated.obj", inflated(points), triangles)
    print(f"figure: {len(points)} points, {len(triangles)} triangles")
    for panel in panels():
        wide, high = lengths(panel)
        print(f"{panel.name:18} {wide:.3f} m by {high:.3f} m")
    for scene in arguments.scenes:
        replace_part(scene, "dress", made_by(arguments.spacing), scene_text(arguments.spacing))
    return 0


if __name__ == "__main__":
    sys.exit(main())
