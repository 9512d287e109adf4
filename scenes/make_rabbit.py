"""Writes rabbit.obj: the middle surface of a sitting rabbit, closed, in millimetres."""
from __future__ import annotations

from pathlib import Path

import numpy as np

CELL = 3.2    # of the grid that finds the surface [mm]
BLEND = 6.0   # width over which parts run into one another [mm]
ROUNDS = 30   # of smoothing along the surface
# Parts are ellipsoids: middle and half axes [mm], and their turns about x and y [degrees].
PARTS = (
    ((0.0, 4.0, 29.0), (25.0, 29.0, 28.0), (-12.0, 0.0)),     # body
    ((0.0, -14.0, 30.0), (17.0, 14.0, 22.0), (10.0, 0.0)),    # chest
    ((0.0, -21.0, 62.0), (15.5, 18.5, 15.0), (12.0, 0.0)),    # head
    ((-10.5, -8.0, 86.0), (9.0, 8.0, 19.0), (-14.0, -12.0)),   # ears
    ((10.5, -8.0, 86.0), (9.0, 8.0, 19.0), (-14.0, 12.0)),
    ((-13.0, -24.0, 8.0), (8.5, 13.0, 8.0), (0.0, 0.0)),      # feet
    ((13.0, -24.0, 8.0), (8.5, 13.0, 8.0), (0.0, 0.0)),
    ((-20.0, 8.0, 18.0), (10.0, 19.0, 17.0), (0.0, 0.0)),     # haunches
    ((20.0, 8.0, 18.0), (10.0, 19.0, 17.0), (0.0, 0.0)),
    ((0.0, 33.0, 20.0), (9.0, 9.0, 9.0), (0.0, 0.0)),         # tail
)


def turn(about_x: float, about_y: float) -> np.ndarray:
    """The rotation by these angles [degrees], first about x."""
    a, b = np.radians(about_x), np.radians(about_y)
    x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    return y @ x


def outside(p: np.ndarray) -> np.ndarray:
    """About the distance of points (n, 3) from the figure [mm]; negative inside."""
    total = np.zeros(len(p))
    for middle, axes, (about_x, about_y) in PARTS:
        q = (p - np.array(middle)) @ turn(about_x, about_y)
        r = np.array(axes)
        scaled = np.linalg.norm(q / r, axis=1)
        slope = np.maximum(np.linalg.norm(q / r**2, axis=1), 1e-9)
        total += np.exp(-np.clip(scaled * (scaled - 1.0) / slope, -40.0, 200.0) / BLEND)
    return -BLEND * np.log(np.maximum(total, 1e-80))


def slope(p: np.ndarray) -> np.ndarray:
    """The gradient of `outside`, by central differences."""
    e = 1e-3 * np.eye(3)
    return np.stack([(outside(p + e[k]) - outside(p - e[k])) / 2e-3 for k in range(3)], axis=1)


def onto(p: np.ndarray) -> np.ndarray:
    """Points moved onto the surface (Newton)."""
    for _ in range(4):
        g = slope(p)
        p = p - (outside(p) / np.maximum((g * g).sum(axis=1), 1e-9))[:, None] * g
    return p


def quads() -> tuple[np.ndarray, list[tuple[int, int, int, int]]]:
    """Points and quadrilaterals: a point in each cell of a grid that the surface passes, a face across each edge."""
    low, high = np.array([-38.0, -46.0, -6.0]), np.array([38.0, 52.0, 118.0])
    count = np.ceil((high - low) / CELL).astype(int) + 1
    grid = np.stack(np.meshgrid(*(low[k] + CELL * np.arange(count[k]) for k in range(3)), indexing="ij"), axis=-1)
    inside = (outside(grid.reshape(-1, 3)) < 0.0).reshape(count)
    number: dict[tuple[int, ...], int] = {}
    points: list[np.ndarray] = []
    faces: list[tuple[int, int, int, int]] = []

    def point(cell: tuple[int, ...]) -> int:
        if cell not in number:
            number[cell] = len(points)
            points.append(low + CELL * (np.array(cell) + 0.5))
        return number[cell]

    for axis in range(3):
        step = np.eye(3, dtype=int)[axis]
        a, b = (inside[tuple(slice(s, n - 1 + s) for s, n in zip(shift, count))] for shift in ((0, 0, 0), step))
        for at in np.argwhere(a != b):
            u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
            ring = [point(tuple(at + d)) for d in (-u - v, -v, 0 * u, -u)]
            faces.append(tuple(ring if inside[tuple(at)] else ring[::-1]))  # type: ignore[arg-type]
    return np.array(points), faces


def smoothed(p: np.ndarray, faces: list[tuple[int, int, int, int]]) -> np.ndarray:
    """Points spread evenly over the surface: each moves to the mean of its neighbours and back onto the surface."""
    pairs = np.array([(f[k], f[(k + 1) % 4]) for f in faces for k in range(4)])
    valence = np.bincount(pairs[:, 0], minlength=len(p))[:, None]
    p = onto(p)
    for _ in range(ROUNDS):
        mean = np.zeros_like(p)
        np.add.at(mean, pairs[:, 0], p[pairs[:, 1]])
        p = onto(0.5 * p + 0.5 * mean / valence)
    return p


def main() -> None:
    """Writes the file beside this script."""
    points, faces = quads()
    lines = ["# The middle surface of a sitting rabbit, in millimetres (make_rabbit.py)"]
    lines += ["v {:.4f} {:.4f} {:.4f}".format(*p) for p in smoothed(points, faces)]
    lines += ["f {} {} {} {}".format(*(i + 1 for i in f)) for f in faces]
    (Path(__file__).parent / "rabbit.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
