"""Lines of cracks between two frames: with the body that carries them, and with the laminate that they are in."""
from __future__ import annotations

import unittest
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from sunder_tools.pictures.between import Interval, _between
from sunder_tools.pictures.frames import BODIES, CARRIED, CRACKS, SHELL, Frame
from sunder_tools.pictures.vtp import PolyData


@dataclass(frozen=True, eq=False)
class Made(Frame):
    """A frame without files."""
    parts: dict[int, PolyData] = field(default_factory=dict)

    def read(self, part: int) -> PolyData | None:
        return self.parts.get(part)


def made(time_s: float, parts: dict[int, PolyData]) -> Made:
    return Made(time_s, {part: Path() for part in parts}, False, parts)


def turned(points: np.ndarray, angle: float, way: np.ndarray) -> np.ndarray:
    """Turned about z through the centre of a cube at the origin, and moved."""
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]) + way


CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
                  [1, 5, 7], [1, 7, 3]])
LINE = np.array([[0.9, 0.0, 0.2], [0.1, 0.8, 0.2]])
FAR = np.array([10.0, 0.0, 0.0])


class Lines(unittest.TestCase):
    def bodies(self, angle: float, way: np.ndarray) -> tuple[PolyData, PolyData]:
        """Two cubes, of which the second turns the other way, and a line that each carries."""
        both = [turned(CUBE, angle, way), turned(CUBE, -angle, FAR - way)]
        lines = [turned(LINE, angle, way), turned(LINE, -angle, FAR - way)]
        rest = np.concatenate([LINE, LINE + FAR])
        points = np.concatenate(lines)
        return (PolyData(np.concatenate(both), triangles=np.concatenate([FACES, FACES + 8]),
                         cell_data={"body": np.repeat([5, 9], 12), "kind": np.full(24, 3)}),
                PolyData(points, line_points=np.arange(4), line_bounds=np.array([0, 2, 4]),
                         point_data={"displacement": points - rest}, cell_data={"body": np.array([5, 9])}))

    def test_go_with_the_body_that_carries_them(self) -> None:
        way, frames = np.array([0.4, 0.2, -0.6]), []
        for k in range(2):
            cubes, lines = self.bodies(0.5 * k, k * way)
            frames.append(made(float(k), {BODIES: cubes, CARRIED: lines}))
        for share in (0.25, 0.5, 1.0):
            found = _between(Interval(frames[0], frames[1]), share).read(CARRIED)
            assert found is not None
            _, wanted = self.bodies(0.5 * share, share * way)
            np.testing.assert_allclose(found.points, wanted.points, atol=1e-9)
            np.testing.assert_allclose(found.point_data["displacement"], wanted.point_data["displacement"], atol=1e-9)

    def test_of_laminates_go_to_where_the_next_frame_has_them(self) -> None:
        def cracks(ends: list[list[float]], drop: float) -> PolyData:
            at = np.array(ends, float).reshape(-1, 3)
            return PolyData(at + [0, 0, -drop], line_points=np.arange(len(at)), line_bounds=np.arange(0, len(at) + 1, 2),
                            point_data={"displacement": np.tile([0, 0, -drop], (len(at), 1)).astype(float), "parameter": at},
                            cell_data={"shell": np.zeros(len(at) // 2), "time": np.zeros(len(at) // 2)})
        old, new = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [5.0, 5.0, 0.0, 6.0, 5.0, 0.0]
        frames = [made(0.0, {CRACKS: cracks([old], 0.0)}), made(1.0, {CRACKS: cracks([new, old], 0.8)})]  # one is new
        found = _between(Interval(frames[0], frames[1]), 0.5).read(CRACKS)
        assert found is not None
        np.testing.assert_allclose(found.points, [[0, 0, -0.4], [1, 0, -0.4]], atol=1e-12)
        self.assertIsNone(_between(Interval(frames[0], frames[1]), 0.5).read(SHELL))


if __name__ == "__main__":
    unittest.main()
