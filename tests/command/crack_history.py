"""A made-up history of cracks on a sheet, written as frames."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from .synthetic import write_vtp

SIDE = 0.1  # [m] of the made-up sheet, ten elements a side
SPACING = 0.01
Edge = tuple[tuple[float, float], tuple[float, float], int, float]  # ends [spacings], crack, birth [s]

# A crack from the border turns and forks; another starts in the middle and ends on the first, past it by 2e-3 spacings.
STAGES: list[tuple[float, list[Edge]]] = [
    (0.0, []),
    (1.0, [((-0.1, 5.0), (1.0, 5.0), 0, 0.0), ((1.0, 5.0), (2.0, 5.2), 0, 0.5)]),
    (2.0, [((2.0, 5.2), (3.0, 5.4), 0, 1.5), ((2.5, 8.0), (2.5, 7.0), 1, 1.6)]),
    (3.0, [((3.0, 5.4), (4.0, 6.0), 0, 2.5), ((3.0, 5.4), (4.0, 5.0), 2, 2.5), ((2.5, 7.0), (2.5, 6.0), 1, 2.6)]),
    (4.0, [((2.5, 6.0), (2.5, 5.298), 1, 3.5)]),
]


def history() -> list[tuple[float, list[Edge]]]:
    """Time and edges of each frame: all that came so far."""
    return [(t, [e for _, new in STAGES[:k + 1] for e in new]) for k, (t, _) in enumerate(STAGES)]


def write_history(folder: Path, frames: list[tuple[float, list[Edge]]], shells: int = 1) -> None:
    """Frames of so many such sheets, one above the other, and their cracks; an element is damaged once a crack comes
    within a spacing of its middle."""
    axis = np.linspace(0.0, SIDE, 11)
    x, y = np.meshgrid(axis, axis)
    index = np.arange(121).reshape(11, 11)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    points = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    middle = points[triangles].mean(axis=1)[:, :2]
    entries = []
    (folder / "frames").mkdir(exist_ok=True)
    for k, (time_s, edges) in enumerate(frames):
        ends = np.array([p for e in edges for p in e[:2]], float).reshape(-1, 2) * SPACING
        flat = np.column_stack([ends, np.zeros(len(ends))])
        along = [e[0] + s * (e[1] - e[0]) for e in ends.reshape(-1, 2, 2) for s in np.linspace(0.0, 1.0, 5)]
        near = [np.linalg.norm(middle - p, axis=1) < SPACING for p in along]
        damaged = np.any(near, axis=0) if near else np.zeros(len(triangles), bool)
        every = range(shells)
        sheets = [points + [0.0, 0.0, SIDE * n] for n in every]
        write_vtp(folder / f"frames/shell_{k}.vtp", np.concatenate(sheets),
                  np.concatenate([triangles + n * len(points) for n in every]),
                  cell_data={"c_his": np.tile(damaged.astype(float), shells),
                             "shell": np.repeat(np.arange(float(shells)), len(triangles))})
        write_vtp(folder / f"frames/cracks_{k}.vtp",
                  np.concatenate([np.clip(flat, 0.0, SIDE) + [0.0, 0.0, SIDE * n] for n in every]),
                  segments=np.arange(shells * len(ends)).reshape(-1, 2), point_data={"parameter": np.tile(flat, (shells, 1))},
                  cell_data={"crack": np.tile(np.array([e[2] for e in edges], int), shells),
                             "shell": np.repeat(np.arange(float(shells)), len(edges)),
                             "time": np.tile(np.array([e[3] for e in edges], float), shells)}, floats="f8")
        entries += [f'<DataSet timestep="{time_s}" part="{part}" file="frames/{name}_{k}.vtp"/>'
                    for part, name in ((0, "shell"), (1, "cracks"))]
    (folder / "frames.pvd").write_text(f"<VTKFile><Collection>{''.join(entries)}</Collection></VTKFile>")
