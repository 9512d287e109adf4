"""Remains of a shell after an impact: pieces with their sizes, and radial cracks."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.pictures.crack_lines import grown
from sunder_tools.pictures.frames import SHELL
from sunder_tools.pictures.meshes import reference_points
from sunder_tools.pictures.vtp import PolyData

from .crossings import radial_crossings
from .measures import Stated
from .scene import Results

SPLINTER = 1e-3  # share of the shell's area: smaller shards are not counted as pieces, as in run.json


@dataclass(frozen=True)
class Pieces:
    """Areas [m^2] at the end, sorted, largest first. `whole` is the area of the shell at rest.

    `off` came off as rigid bodies; `standing` are those that the shell still had, whether held or loose. Where the
    shell was frozen, what did not come off counts as one.
    """
    off: np.ndarray
    standing: np.ndarray
    whole: float

    def counted(self, splinter: float = SPLINTER) -> np.ndarray:
        """Returns all areas of at least `splinter` times the whole, largest first [m^2]."""
        both = np.sort(np.concatenate([self.off, self.standing]))[::-1]
        return both[both >= splinter * self.whole]

    def mean_size(self, splinter: float = SPLINTER) -> float:
        """Returns the mean area of the piece that holds a random point of the shell [m^2]: sum of squares over sum.

        Many splinters do not change it, as they change a mean over pieces.
        """
        areas = self.counted(splinter)
        return float((areas ** 2).sum() / areas.sum())


def pieces(results: Results) -> Pieces:
    """Reads the areas. Raises CommandError where the needed frames are missing: the first one, and the last one of a
    shell that is not frozen."""
    frames = [frame for frame in results.frames if SHELL in frame.files]
    if not frames:
        raise CommandError(f"{results.folder}: no frame of the shell; keep='last' keeps what is needed")
    first = _areas(frames[0].read(SHELL))
    off, whole = np.sort(results.shards["area"])[::-1], float(first.sum())
    time = results.run["time"]
    if time["frozen_at_s"] is not None:
        left = whole - float(off.sum())
        return Pieces(off, np.array([left] if left > 1e-9 * whole else []), whole)
    if abs(frames[-1].time_s - time["simulated_s"]) > 1e-6 * time["simulated_s"]:
        raise CommandError(f"{results.folder}: the last frame is of {frames[-1].time_s:g} s, the run ended at "
                           f"{time['simulated_s']:g} s")
    return Pieces(off, np.sort(_areas(frames[-1].read(SHELL)))[::-1], whole)


def _areas(shell: PolyData | None) -> np.ndarray:
    """Returns the area at rest [m^2] of each fragment in a frame."""
    assert shell is not None
    corner = reference_points(shell)[shell.triangles]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    number = np.unique(shell.of_triangles("fragment", 0), return_inverse=True)[1]
    return np.bincount(number, weights=area)


def fragments(splinter: float = SPLINTER) -> Any:
    """Measures, for experiments, number and sizes of pieces of at least `splinter` of the shell's area: columns `pieces`,
    `pieces_off`, those that came off, `largest_piece_m2`, `median_piece_m2` and `mean_piece_m2`."""
    def measure(results: Results) -> dict[str, float]:
        found = pieces(results)
        areas = found.counted(splinter)
        return {"pieces": len(areas), "pieces_off": int((found.off >= splinter * found.whole).sum()),
                "largest_piece_m2": float(areas.max()), "median_piece_m2": float(np.median(areas)),
                "mean_piece_m2": found.mean_size(splinter)}
    return Stated(("pieces", "pieces_off", "largest_piece_m2", "median_piece_m2", "mean_piece_m2"), measure)


def radial_cracks(centre: tuple[float, float], radius_m: float) -> Any:
    """Measures, for experiments, cracks that cross a circle in the parameter domain [m] within 45 degrees of the
    radius: column `radial_cracks`."""
    def measure(results: Results) -> dict[str, float]:
        graph = results.cracks
        ends = np.zeros((0, 2, 2)) if graph is None else grown(graph).ends
        return {"radial_cracks": len(radial_crossings(ends, np.array(centre), radius_m))}
    return Stated(("radial_cracks",), measure)
