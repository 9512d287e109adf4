"""A made-up run: a pane breaks into cells, the cells fall and lie on a floor, a ball goes through.

Kinematics only, to test what reads and draws frames.
"""
from __future__ import annotations

import json
from pathlib import Path

import numpy as np

SIZE_M, THICKNESS_M, HEIGHT_M, BALL_RADIUS_M = 0.5, 0.004, 0.5, 0.02
NAMES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32"}


def write_vtp(path: Path, points, triangles=(), segments=(), point_data=None, cell_data=None,
              floats: str = "f4") -> None:
    """One PolyData file as the shell process writes it; `floats`: type of the data that are not integers."""
    blocks: list[bytes] = []
    offset = 0

    def array(name: str, values, kind: str, components: int = 1) -> str:
        nonlocal offset
        raw = np.ascontiguousarray(values, "<" + kind).tobytes()
        blocks.append(np.uint64(len(raw)).tobytes() + raw)
        text = (f'<DataArray type="{NAMES[kind]}" Name="{name}" NumberOfComponents="{components}" '
                f'format="appended" offset="{offset}"/>\n')
        offset += len(raw) + 8
        return text

    def cells(name: str, connectivity, each: int) -> str:
        connectivity = np.asarray(connectivity, int).reshape(-1, each)
        return (f"<{name}>\n" + array("connectivity", connectivity, "i8")
                + array("offsets", np.arange(1, len(connectivity) + 1) * each, "i8") + f"</{name}>\n")

    def data(section: str, arrays) -> str:
        body = "".join(array(n, v, "i8" if np.asarray(v).dtype.kind == "i" else floats,
                             np.shape(v)[1] if np.ndim(v) == 2 else 1) for n, v in (arrays or {}).items())
        return f"<{section}>\n{body}</{section}>\n"

    points = np.asarray(points, float).reshape(-1, 3)
    text = ('<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt64">\n<PolyData>\n'
            f'<Piece NumberOfPoints="{len(points)}" NumberOfVerts="0" NumberOfLines="{len(segments)}" '
            f'NumberOfStrips="0" NumberOfPolys="{len(triangles)}">\n'
            + data("PointData", point_data) + data("CellData", cell_data)
            + "<Points>\n" + array("Points", points, "f8", 3) + "</Points>\n"
            + cells("Verts", [], 1) + cells("Lines", segments, 2) + cells("Polys", triangles, 3)
            + '</Piece>\n</PolyData>\n<AppendedData encoding="raw">\n_')
    part = path.with_suffix(".part")  # as the solver does: a killed writer leaves no half frame
    part.write_bytes(text.encode() + b"".join(blocks) + b"\n</AppendedData>\n</VTKFile>\n")
    part.rename(path)


def ball(radius: float, rings: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """A sphere around the origin."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.arange(2 * rings) * np.pi / rings, indexing="ij")
    points = radius * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    index = np.arange(points.size // 3).reshape(theta.shape)
    a, b = index[:-1], index[1:]
    c, d = np.roll(b, -1, 1), np.roll(a, -1, 1)
    return points.reshape(-1, 3), np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)


class SyntheticRun:
    """Frames are numbered 0..count-1; cracks grow in the first third, shards fall in the rest."""

    def __init__(self, folder: Path, elements: int = 24, fragments: int = 40, count: int = 24) -> None:
        self.folder, self.count = folder, count
        random = np.random.default_rng(1)
        axis = np.linspace(-0.5 * SIZE_M, 0.5 * SIZE_M, elements + 1)
        x, y = np.meshgrid(axis, axis)
        inner = random.uniform(-0.3, 0.3, (2, *x.shape)) * SIZE_M / elements
        inner[:, [0, -1], :] = inner[:, :, [0, -1]] = 0.0
        self.points = np.stack([x + inner[0], y + inner[1], 0 * x + HEIGHT_M], -1).reshape(-1, 3)
        index = np.arange((elements + 1) ** 2).reshape(elements + 1, -1)
        a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
        self.triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
        radius = SIZE_M * 0.55 * random.uniform(0, 1, fragments) ** 0.8
        angle = random.uniform(0, 2 * np.pi, fragments)
        self.seeds = np.stack([radius * np.cos(angle), radius * np.sin(angle)], -1)
        centre = self.points[self.triangles].mean(axis=1)[:, :2]
        self.cell = np.argmin(((centre[:, None] - self.seeds) ** 2).sum(-1), axis=1)
        self.radius = np.linalg.norm(centre, axis=1)
        self.held = np.array([bool((self.radius[self.cell == k] > 0.24).any()) for k in range(fragments)])
        self.turn = random.uniform(-3, 3, fragments)
        self.entries: list[str] = []
        (folder / "frames").mkdir(parents=True, exist_ok=True)

    def time_s(self, k: int) -> float:
        """Three decades: microseconds at first, then hundredths of seconds."""
        third = self.count // 3
        return k * 5e-5 if k <= third else third * 5e-5 + (1.0 * (k - third) / (self.count - third)) ** 2

    def write(self, k: int) -> None:
        """Frame k and frames.pvd up to it."""
        time_s, third = self.time_s(k), self.count // 3
        broken = self.radius < 0.4 * min(1.0, k / third)  # cells show where the crack has been
        fragment = np.where(broken, self.cell + 2, 0)  # the number of the body that it will be
        parts = []
        standing = self.held[self.cell] | (k <= third)
        sag = 0.004 * np.exp(-np.linalg.norm(self.points[:, :2], axis=1) / 0.08) * min(k, third) / third
        displacement = np.stack([0 * sag, 0 * sag, -sag], -1)
        if k < 2 * third:
            points = self.points + displacement
            write_vtp(self.folder / f"frames/shell_{k:06d}.vtp", points, self.triangles[standing],
                      point_data={"velocity": 0 * points, "displacement": displacement},
                      cell_data={"damage": 0.4 * broken[standing], "c_his": 0.0 * self.radius[standing],
                                 "fragment": fragment[standing]})
            edge = self._crack_edges(broken & standing)
            write_vtp(self.folder / f"frames/cracks_{k:06d}.vtp", points, segments=edge,
                      point_data={"displacement": displacement}, cell_data={"patch": np.zeros(len(edge), int)})
            parts += [(0, "shell"), (1, "cracks")]
        self._write_bodies(k, time_s, third)
        for part, name in parts + [(2, "bodies")]:
            self.entries.append(f'<DataSet timestep="{time_s!r}" part="{part}" file="frames/{name}_{k:06d}.vtp"/>')
        fresh = self.folder / "frames.pvd.part"
        fresh.write_text(
            '<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">\n<Collection>\n'
            + "\n".join(self.entries) + "\n</Collection>\n</VTKFile>\n")
        fresh.rename(self.folder / "frames.pvd")

    def _crack_edges(self, where: np.ndarray) -> np.ndarray:
        owner: dict[tuple[int, int], int] = {}
        found = []
        for triangle, cell in zip(self.triangles[where], self.cell[where]):
            for i, j in ((0, 1), (1, 2), (2, 0)):
                a, b = int(triangle[i]), int(triangle[j])
                key = min(a, b), max(a, b)
                if owner.setdefault(key, int(cell)) != cell:
                    found.append(key)
        return np.array(found, int).reshape(-1, 2)

    def _write_bodies(self, k: int, time_s: float, third: int) -> None:
        points: list[np.ndarray] = []
        triangles, body, kind = [], [], []

        def add(p: np.ndarray, t: np.ndarray, number: int, sort: int) -> None:
            triangles.append(t + sum(len(one) for one in points))
            points.append(p)
            body.append(np.full(len(t), number))
            kind.append(np.full(len(t), sort))

        p, t = ball(BALL_RADIUS_M)
        add(p + [0.0, 0.0, max(BALL_RADIUS_M, HEIGHT_M + BALL_RADIUS_M + 0.003 - 20 * time_s)], t, 0, 0)
        floor = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
        add(floor, np.array([[0, 1, 2], [0, 2, 3]]), 1, 2)
        if k > third:
            for cell in range(len(self.seeds)):
                mine = self.triangles[self.cell == cell]
                if len(mine) and not self.held[cell]:
                    add(*self._shard(cell, mine, time_s), cell + 2, 1)
            if k >= 2 * third:
                mine = self.triangles[self.held[self.cell]]
                add(*self._plate(mine, self.points), len(self.seeds) + 2, 3)
        write_vtp(self.folder / f"frames/bodies_{k:06d}.vtp", np.concatenate(points), np.concatenate(triangles),
                  cell_data={"body": np.concatenate(body), "kind": np.concatenate(kind)})

    def _plate(self, mine: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangles made THICKNESS_M thick, with walls; pairs of points, inside before outside, as the shell process has."""
        used, flat = np.unique(mine, return_inverse=True)
        flat = flat.reshape(-1, 3)
        base = points[used]
        up = np.array([0, 0, 0.5 * THICKNESS_M])
        pairs = np.concatenate([flat[:, [0, 1]], flat[:, [1, 2]], flat[:, [2, 0]]])
        _, first, count = np.unique(np.sort(pairs, axis=1), axis=0, return_index=True, return_counts=True)
        a, b = pairs[first[count == 1]].T
        a, b = 2 * a, 2 * b
        walls = np.concatenate([np.stack([a, b, b + 1], -1), np.stack([a, b + 1, a + 1], -1)])
        return (np.stack([base - up, base + up], axis=1).reshape(-1, 3),
                np.concatenate([2 * flat[:, ::-1], 2 * flat + 1, walls]))

    def _shard(self, cell: int, mine: np.ndarray, time_s: float) -> tuple[np.ndarray, np.ndarray]:
        points, triangles = self._plate(mine, self.points)
        centre = points.mean(axis=0)
        fall = np.sqrt(2 * (HEIGHT_M - 0.5 * THICKNESS_M) / 9.81)
        s = min(time_s, fall)
        tilt = self.turn[cell] * s * (1 - s / fall)
        turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
        moved = centre + 1.2 * s * np.array([*self.seeds[cell], 0.0]) - [0, 0, 0.5 * 9.81 * s * s]
        result = (points - centre) @ turn.T + moved
        result[:, 2] += max(0.0, -result[:, 2].min())
        return result, triangles

    def write_run_json(self, status: str, frames: int) -> None:
        """What the shell leaves in run.json."""
        run = {"schema": 1, "status": status, "engine": {"name": "fake", "version": "1"},
               "counts": {"fragments": 40, "handed_off": 31},
               "time": {"simulated_s": self.time_s(frames), "wall_s": 1.5},
               "ledger": {"linear_max": 1e-15, "angular_max": 2e-15}, "energy": {"residual_relative": 0.004}}
        temporary = self.folder / "run.json.new"
        temporary.write_text(json.dumps(run))
        temporary.replace(self.folder / "run.json")
