"""Writes bowl.obj: the middle surface of a bowl, in millimetres."""
from __future__ import annotations

import math
from pathlib import Path

ROUND = 64  # points around
# Radius and height of the profile from the middle of the bottom to the lip [mm].
PROFILE = ((0.0, 0.0), (12.0, 0.2), (22.0, 1.2), (32.0, 4.6), (41.0, 11.0), (49.0, 19.5), (56.0, 29.0), (62.5, 39.0),
           (70.0, 48.0))
BETWEEN = 3  # pieces of each stretch of the profile


def profile() -> list[tuple[float, float]]:
    """Points of a smooth curve through PROFILE (Catmull and Rom); it is level in the middle."""
    points = [(-PROFILE[1][0], PROFILE[1][1]), *PROFILE,
              (2 * PROFILE[-1][0] - PROFILE[-2][0], 2 * PROFILE[-1][1] - PROFILE[-2][1])]
    out = []
    for k in range(1, len(points) - 2):
        for i in range(BETWEEN):
            t = i / BETWEEN
            a, b, c, d = (0.5 * t * (-1 + t * (2 - t)), 0.5 * (2 + t * t * (3 * t - 5)), 0.5 * t * (1 + t * (4 - 3 * t)),
                          0.5 * t * t * (t - 1))
            out.append(tuple(a * p + b * q + c * r + d * s for p, q, r, s in zip(*points[k - 1:k + 3])))
    return [*out, PROFILE[-1]]  # type: ignore[list-item]


def main() -> None:
    """Writes the file beside this script."""
    rings = profile()[1:]
    lines = ["# The middle surface of a bowl, in millimetres (make_bowl.py)", "v 0 0 0"]
    for radius, height in rings:
        for k in range(ROUND):
            angle = 2 * math.pi * k / ROUND
            lines.append(f"v {radius * math.cos(angle):.6f} {radius * math.sin(angle):.6f} {height:.6f}")
    for k in range(ROUND):
        lines.append(f"f 1 {2 + k} {2 + (k + 1) % ROUND}")
    for ring in range(len(rings) - 1):
        for k in range(ROUND):
            a, b = 2 + ring * ROUND + k, 2 + ring * ROUND + (k + 1) % ROUND
            lines.append(f"f {a} {a + ROUND} {b + ROUND} {b}")
    (Path(__file__).parent / "bowl.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
