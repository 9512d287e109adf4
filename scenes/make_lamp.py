"""Writes lamp.obj: the middle surface of a lamp, in millimetres: a globe, and the cap from which it hangs."""
from __future__ import annotations

import math
from pathlib import Path

ROUND = 72  # points around
# Radius and height of the profile from the top of the cap to the bottom of the globe [mm]. The globe has radius 60.
CAP = ((20.0, 82.0), (20.0, 75.0), (20.0, 68.0), (21.0, 62.5), (24.5, 57.0))
GLOBE = tuple((60.0 * math.sin(angle), 60.0 * math.cos(angle))
              for angle in (math.radians(180.0 * (0.16 + 0.84 * k / 14)) for k in range(14)))
BETWEEN = 3  # pieces of each stretch of the profile


def between(points: list[tuple[float, float]], first: int, last: int) -> list[tuple[float, float]]:
    """Points of a smooth curve through `points` (Catmull and Rom), from number `first` up to `last`."""
    out = []
    for k in range(first, last):
        for i in range(BETWEEN):
            t = i / BETWEEN
            weights = (0.5 * t * (-1 + t * (2 - t)), 0.5 * (2 + t * t * (3 * t - 5)), 0.5 * t * (1 + t * (4 - 3 * t)),
                       0.5 * t * t * (t - 1))
            out.append((sum(w * p[0] for w, p in zip(weights, points[k - 1:k + 3])),
                        sum(w * p[1] for w, p in zip(weights, points[k - 1:k + 3]))))
    return out


def main() -> None:
    """Writes the file beside this script."""
    bottom = (0.0, -60.0)
    beyond = (-GLOBE[-1][0], GLOBE[-1][1])  # the profile goes on beyond the bottom
    points = [(CAP[0][0], 2 * CAP[0][1] - CAP[1][1]), *CAP, *GLOBE, bottom, beyond]
    rings = between(points, 1, len(points) - 2)
    in_cap = BETWEEN * len(CAP)  # rings of the cap; the next one is its border
    lines = ["# The middle surface of a lamp, in millimetres (make_lamp.py)"]
    for radius, height in rings:
        for k in range(ROUND):
            angle = 2 * math.pi * k / ROUND
            lines.append(f"v {radius * math.cos(angle):.6f} {radius * math.sin(angle):.6f} {height:.6f}")
    lines.append("v {:.6f} {:.6f} {:.6f}".format(0.0, *bottom))
    lines.append("g cap")
    for ring in range(len(rings) - 1):
        if ring == in_cap:
            lines.append("g globe")
        for k in range(ROUND):
            a, b = 1 + ring * ROUND + k, 1 + ring * ROUND + (k + 1) % ROUND
            lines.append(f"f {a} {a + ROUND} {b + ROUND} {b}")
    last = 1 + (len(rings) - 1) * ROUND
    for k in range(ROUND):
        lines.append(f"f {last + k} {len(rings) * ROUND + 1} {last + (k + 1) % ROUND}")
    (Path(__file__).parent / "lamp.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
