#!/usr/bin/python3
"""Writes the bunnies of fig14.textproto: nine ellipsoids as OFF files beside it, bodies and joints into it.

    scenes/paper/make_bunnies.py [SCENE...]

In each SCENE the lines between `# begin bunnies` and `# end bunnies` are replaced. A bunny is not the scanned one of the
paper's pictures. It is some 0.38 m high, looks along +x, sits at z = 0 and has parts that fixed joints hold together, as a
body of one piece would need more convex parts than an engine takes. Parts that overlap are joined.
"""
from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))
from scene_part import number, replace_part  # noqa: E402

DIVISIONS = 2      # of an icosahedron's faces; each makes four of one
DROP_M_PER_S = 5.0
BUNNIES = {"left": ((-0.17, -0.16, 0.505), 40.0), "right": ((0.18, 0.17, 0.505), 215.0)}  # foot [m], turn about z [degrees]


@dataclass(frozen=True)
class Part:
    """An ellipsoid in the frame of its bunny, joined to another one."""
    name: str
    centre: tuple[float, float, float]  # [m]
    axes: tuple[float, float, float]    # halves [m]
    turn_deg: float                     # about y
    held_by: str


PARTS = [
    Part("body", (-0.015, 0.0, 0.105), (0.125, 0.085, 0.092), -25.0, ""),
    Part("head", (0.088, 0.0, 0.225), (0.068, 0.053, 0.056), 12.0, "body"),
    Part("left_ear", (0.050, 0.030, 0.318), (0.021, 0.016, 0.078), -18.0, "head"),
    Part("right_ear", (0.050, -0.030, 0.318), (0.021, 0.016, 0.078), -18.0, "head"),
    Part("left_thigh", (-0.050, 0.062, 0.056), (0.070, 0.036, 0.056), 0.0, "body"),
    Part("right_thigh", (-0.050, -0.062, 0.056), (0.070, 0.036, 0.056), 0.0, "body"),
    Part("left_paw", (0.083, 0.040, 0.060), (0.032, 0.026, 0.060), -15.0, "body"),
    Part("right_paw", (0.083, -0.040, 0.060), (0.032, 0.026, 0.060), -15.0, "body"),
    Part("tail", (-0.130, 0.0, 0.070), (0.030, 0.030, 0.030), 0.0, "body"),
]


def ball() -> tuple[np.ndarray, np.ndarray]:
    """Returns points (n, 3) and triangles (m, 3) of the unit ball, outward by the right-hand rule."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    points = [np.roll([0.0, a, b], axis) for axis in range(3) for a in (-1.0, 1.0) for b in (-golden, golden)]
    corner = np.array(points) / np.hypot(1.0, golden)
    near = np.linalg.norm(corner[:, None] - corner, axis=2) < 1.1
    faces = [(i, j, k) for i in range(12) for j in range(i + 1, 12) for k in range(j + 1, 12)
             if near[i, j] and near[j, k] and near[k, i]]
    triangles = [f if np.linalg.det(corner[list(f)]) > 0.0 else f[::-1] for f in faces]
    points = list(corner)
    for _ in range(DIVISIONS):
        middle: dict[tuple[int, int], int] = {}
        finer = []
        for a, b, c in triangles:
            ab, bc, ca = (_middle(points, middle, *pair) for pair in ((a, b), (b, c), (c, a)))
            finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = finer
    return np.array(points), np.array(triangles)


def _middle(points: list[np.ndarray], known: dict[tuple[int, int], int], a: int, b: int) -> int:
    key = (min(a, b), max(a, b))
    if key not in known:
        known[key] = len(points)
        points.append((points[a] + points[b]) / np.linalg.norm(points[a] + points[b]))
    return known[key]


def about(axis: int, angle_deg: float) -> np.ndarray:
    """Returns the rotation (3, 3) about an axis."""
    turn, (i, j) = np.radians(angle_deg), ((axis + 1) % 3, (axis + 2) % 3)
    out = np.eye(3)
    out[i, i] = out[j, j] = np.cos(turn)
    out[i, j], out[j, i] = -np.sin(turn), np.sin(turn)
    return out


def off_text(part: Part) -> str:
    """Returns the OFF file of a part, in the frame of its bunny."""
    points, triangles = ball()
    points = (points * part.axes) @ about(1, part.turn_deg).T + part.centre
    lines = ["OFF", f"{len(points)} {len(triangles)} 0", *(" ".join(number(x) for x in p.round(6)) for p in points)]
    return "\n".join([*lines, *(f"3 {a} {b} {c}" for a, b, c in triangles)]) + "\n"


def scene_text() -> list[str]:
    """Returns bodies and joints of the bunnies; the scene has the material `plastic`."""
    out = []
    for bunny, (foot, turn_deg) in BUNNIES.items():
        half = 0.5 * np.radians(turn_deg)
        pose = (f"pose {{ {_vector('position', foot)} orientation {{ w: {number(np.cos(half))} z: {number(np.sin(half))} }} }}")
        for part in PARTS:
            out.append(f'bodies {{ name: "{bunny}_{part.name}" material: "plastic" mesh {{ path: "bunny_{part.name}.off" }} {pose} '
                       f"twist {{ linear {{ z: {number(-DROP_M_PER_S)} }} }} }}")
        centres = {part.name: np.array(part.centre) for part in PARTS}
        for part in PARTS:
            if part.held_by:
                at = np.array(foot) + about(2, turn_deg) @ (0.5 * (centres[part.name] + centres[part.held_by]))
                out.append(f'joints {{ name: "{bunny}_{part.name}_joint" kind: FIXED first: "{bunny}_{part.name}" '
                           f'second: "{bunny}_{part.held_by}" {_vector("position", at)} }}')
    return out


def _vector(name: str, v: tuple[float, ...] | np.ndarray) -> str:
    return f"{name} {{ x: {number(v[0])} y: {number(v[1])} z: {number(v[2])} }}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", type=Path, metavar="SCENE")
    for part in PARTS:
        (Path(__file__).parent / f"bunny_{part.name}.off").write_text(off_text(part))
    for scene in parser.parse_args().scenes:
        replace_part(scene, "bunnies", "made by make_bunnies.py", scene_text())
    return 0


if __name__ == "__main__":
    sys.exit(main())
