#!/usr/bin/python3
"""Writes a falling tree: a trunk and branches as OFF files beside this script and beside the scenes, bodies and joints
into the scenes.

    scenes/make_tree.py [--notch DEGREES] [SCENE...]

In each SCENE the lines between `# begin tree` and `# end tree` are replaced. The tree falls about a hinge at its foot
and starts leaning, as fast as it would be if it had stood almost upright and at rest before. With a notch the hinge
breaks when that closes, at so many degrees off the vertical; without, it holds.
"""
from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scene_part import number, replace_part

FOOT = np.array([0.45, -4.40, 0.35])    # of the hinge, on a stump [m]
TARGET = np.array([1.62, 0.0])  # target: x and y of the middle of the windscreen [m]
LEAN_DEG, FROM_DEG = 62.0, 5.0  # angles to the vertical: at the start, and where the fall began
DENSITY = 600.0                         # green wood of a spruce [kg/m^3]
GRAVITY = 9.81                          # [m/s^2]
CORNERS = 10                            # of each end of a trunk or branch
TRUNK = (6.5, 0.17, 0.08)               # length, radius at the foot and at the top [m]
# Height on the trunk, length [m], angle to the trunk and about it [degrees; 0 points down when the tree lies], radii
# [m].
BRANCHES = [
    (4.15, 0.55, 65.0, 10.0, 0.055, 0.040), (4.75, 0.60, 60.0, -15.0, 0.055, 0.040),
    (3.30, 1.30, 50.0, 110.0, 0.060, 0.035), (3.75, 1.40, 50.0, -105.0, 0.060, 0.035),
    (5.20, 1.20, 45.0, 80.0, 0.050, 0.030), (5.50, 1.10, 45.0, -75.0, 0.050, 0.030),
    (4.90, 1.00, 50.0, 180.0, 0.050, 0.030)]


@dataclass
class Piece:
    """A tapered prism from `start` to `end`, in the frame of the standing tree: foot at the origin, z up."""
    name: str
    start: np.ndarray
    end: np.ndarray
    radii: tuple[float, float]

    def corners(self) -> np.ndarray:
        """Returns the corners of both ends, (2 CORNERS, 3) [m]."""
        along = (self.end - self.start) / np.linalg.norm(self.end - self.start)
        side = np.cross(along, [0.0, 1.0, 0.0] if abs(along[1]) < 0.9 else [1.0, 0.0, 0.0])
        side /= np.linalg.norm(side)
        turn = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
        ring = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * np.cross(along, side)
        return np.concatenate([self.start + self.radii[0] * ring, self.end + self.radii[1] * ring]).round(6)

    def mass_properties(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Returns mass [kg], centre [m] and second moment of mass about the origin (3, 3) [kg m^2], by tetrahedra."""
        p = self.corners()
        n = CORNERS
        faces = [(i, (i + 1) % n, n + (i + 1) % n) for i in range(n)] + [(i, n + (i + 1) % n, n + i) for i in range(n)]
        faces += [(0, i + 1, i) for i in range(1, n - 1)] + [(n, n + i, n + i + 1) for i in range(1, n - 1)]
        middle = p.mean(axis=0)
        mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
        for face in faces:
            corner = np.vstack([p[list(face)], middle])
            m = DENSITY * np.linalg.det(corner[:3] - middle) / 6.0
            total = corner.sum(axis=0)
            mass += m
            first += m / 4.0 * total
            second += m / 20.0 * (np.outer(total, total) + corner.T @ corner)
        return mass, first / mass, second


def tree() -> list[Piece]:
    length, thick, thin = TRUNK
    pieces = [Piece("trunk", np.zeros(3), np.array([0.0, 0.0, length]), (thick, thin))]
    for k, (height, reach, off, about, r0, r1) in enumerate(BRANCHES):
        a, b = np.radians(off), np.radians(about)
        along = np.array([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)])
        start = np.array([0.0, 0.0, height])  # on the axis, so that the branch starts inside the trunk
        pieces.append(Piece(f"branch_{k + 1}", start, start + reach * along, (r0, r1)))
    return pieces


def start() -> tuple[np.ndarray, np.ndarray, float]:
    """Returns the rotation (3, 3) from the standing tree to its start, the hinge's axis, and the angular velocity
    [rad/s]."""
    towards = np.append(TARGET - FOOT[:2], 0.0)
    towards /= np.linalg.norm(towards)
    axis = np.cross([0.0, 0.0, 1.0], towards)
    standing = np.column_stack([towards, axis, [0.0, 0.0, 1.0]])  # turns the tree's x to the direction of the fall
    lean = np.radians(LEAN_DEG)
    about_y = np.array([[np.cos(lean), 0.0, np.sin(lean)], [0.0, 1.0, 0.0], [-np.sin(lean), 0.0, np.cos(lean)]])
    inertia = moment = 0.0
    for piece in tree():
        mass, centre, second = piece.mass_properties()
        inertia += second[0, 0] + second[2, 2]  # about the tree's y through the foot
        moment += mass * centre[2]  # branches are even enough for a centre on the axis
    fallen = GRAVITY * moment * (np.cos(np.radians(FROM_DEG)) - np.cos(lean))
    return standing @ about_y, axis, float(np.sqrt(2.0 * fallen / inertia))


def quaternion(r: np.ndarray) -> np.ndarray:
    """Returns w x y z of a rotation by less than half a turn."""
    w = 0.5 * np.sqrt(1.0 + np.trace(r))
    return np.array([w, *(np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / (4.0 * w))])


def off_text(piece: Piece) -> str:
    """Writes an OFF file: z up, the tree's foot at the origin. Viewers use the faces; the solver takes the corners'
    hull."""
    n = CORNERS
    corners = [" ".join(number(c) for c in p) for p in piece.corners()]
    faces = [f"{n} {' '.join(str(i) for i in reversed(range(n)))}", f"{n} {' '.join(str(n + i) for i in range(n))}"]
    faces += [f"4 {i} {(i + 1) % n} {n + (i + 1) % n} {n + i}" for i in range(n)]
    return "\n".join(["OFF", f"{2 * n} {len(faces)} 0", *corners, *faces]) + "\n"


def _vector(v: np.ndarray) -> str:
    return f"{{ x: {number(v[0])} y: {number(v[1])} z: {number(v[2])} }}"


def scene_text(notch_deg: float | None = None) -> list[str]:
    """Writes bodies and joints of the tree; the scene has the material `wood`. Its hinge breaks at a lean of
    `notch_deg` [degrees]. Raises ValueError where the tree leans further from the start."""
    if notch_deg is not None and not LEAN_DEG < notch_deg < 180.0:
        raise ValueError(f"--notch {notch_deg:g}: the tree starts at {LEAN_DEG:g} degrees; more than that, less than 180")
    rotation, axis, speed = start()
    q = [number(c) for c in quaternion(rotation)]
    pose = f"pose {{ position {_vector(FOOT)} orientation {{ w: {q[0]} x: {q[1]} y: {q[2]} z: {q[3]} }} }}"
    out = []
    for piece in tree():
        _, centre, _ = piece.mass_properties()
        velocity = speed * np.cross(axis, rotation @ centre)
        out += ["bodies {", f'  name: "{piece.name}"', '  material: "wood"',
                f'  mesh {{ path: "tree_{piece.name}.off" }}', f"  {pose}",
                f"  twist {{ linear {_vector(velocity)} angular {_vector(speed * axis)} }}", "}"]
    out += ["joints {", '  name: "foot"', "  kind: HINGE", '  first: "trunk"', f"  position {_vector(FOOT)}",
            f"  axis {_vector(axis)}"]
    if notch_deg is not None:
        out.append(f"  breaks {{ angle_deg: {number(notch_deg - LEAN_DEG)} }}")
    out.append("}")
    for piece in tree()[1:]:
        at = FOOT + rotation @ piece.start
        out.append(f'joints {{ name: "{piece.name}_fork" kind: FIXED first: "{piece.name}" second: "trunk" '
                   f"position {_vector(at)} }}")
    return out


def made_by(notch_deg: float | None) -> str:
    return "made by make_tree.py" + ("" if notch_deg is None else f" --notch {notch_deg:g}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--notch", type=float, metavar="DEGREES")
    parser.add_argument("scenes", nargs="*", type=Path, metavar="SCENE")
    arguments = parser.parse_args()
    for piece in tree():
        for folder in {Path(__file__).resolve().parent, *(scene.resolve().parent for scene in arguments.scenes)}:
            (folder / f"tree_{piece.name}.off").write_text(off_text(piece))
        mass, centre, _ = piece.mass_properties()
        print(f"{piece.name:10} {mass:6.1f} kg, centre {np.linalg.norm(centre):.2f} m from the foot")
    print(f"starts {LEAN_DEG:g} degrees off the vertical with {start()[2]:.3f} rad/s")
    for scene in arguments.scenes:
        replace_part(scene, "tree", made_by(arguments.notch), scene_text(arguments.notch))
    return 0


if __name__ == "__main__":
    sys.exit(main())
