"""Draws the crack pattern from above, and the last frame edge on."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from ..report.columns import read_columns
from .frames import CRACKS, SHELL, Frame
from .meshes import Scene, fragment_edges, reference_points
from .raster import Camera, line_pixels, nothing, orthographic_camera, rasterise
from .views import INK, background, draw_scene
from .vtp import PolyData

PAINTED_FRAMES = 24  # largest number of frames that are painted besides the last
DAMAGE = np.array([0.93, 0.62, 0.45])


def _pastel(fragment: np.ndarray) -> np.ndarray:
    """Returns pale colours that differ between neighbouring ids; the largest fragment stays nearly white."""
    ids, inverse, count = np.unique(fragment, return_inverse=True, return_counts=True)
    hue = np.modf(ids * 0.6180339887498949)[0] * 2.0 * np.pi
    colours = 0.86 + 0.10 * np.cos(hue[:, None] - np.array([0.0, 2.0943951, 4.1887902]))
    if len(count):
        colours[count.argmax()] = [0.95, 0.97, 0.97]
    return colours[inverse]


def shards_of(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Returns when the shards of a run were born (n,) [s], and their areas (n,) [m^2]."""
    shards = read_columns(folder / "shards.csv")
    born, lost = (np.array(shards.get(name, []), float) for name in ("birth [s]", "area [m^2]"))
    return born, lost


def crack_pattern(frames: list[Frame], born: np.ndarray, lost: np.ndarray, width: int, height: int,
                  margin: float = 1.08) -> tuple[np.ndarray, float] | None:
    """Draws the undeformed pane along its normal: (height, width, 3) colours 0..1, and the scale [px/m].

    A piece that was handed over is no longer in later frames. So the last frame is painted first, and earlier ones where
    nothing is yet: those before the pieces with the largest areas `lost` (n,) were `born` (n,) [s]. None if the run has no
    shell frames.
    """
    kept = [frame for frame in frames if SHELL in frame.files]
    last = kept[-1].read(SHELL) if kept else None
    first = kept[0].read(SHELL) if kept else None
    if first is None or last is None or not len(first.triangles):
        return None
    points = reference_points(first)
    picture = _Pattern(along_normal(points, first.triangles, width, height, margin), width, height)
    picture.paint(last, kept[-1].read(CRACKS), True)
    for k in _before(np.array([frame.time_s for frame in kept]), born, lost)[::-1]:
        mesh = kept[k].read(SHELL)
        if mesh is not None and len(mesh.triangles):
            picture.paint(mesh, kept[k].read(CRACKS), False)
    return picture.inked(), float(picture.camera.scale[0])


def _before(times: np.ndarray, born: np.ndarray, lost: np.ndarray) -> np.ndarray:
    """Returns which of the frames at `times` (n,) are the last ones with some piece, without the last frame: at most
    PAINTED_FRAMES, those that lose most, in order of time."""
    frame = np.searchsorted(times, born * (1.0 - 1e-9)) - 1
    of = (frame >= 0) & (frame < len(times) - 1)
    area = np.bincount(frame[of], lost[of], len(times))
    chosen = np.argsort(-area, kind="stable")[:PAINTED_FRAMES]
    return np.sort(chosen[area[chosen] > 0.0])


class _Pattern:
    """A picture of the pane at rest that is filled from the last frame backwards."""

    def __init__(self, camera: Camera, width: int, height: int) -> None:
        self.camera, self._width, self._height = camera, width, height
        self._picture = background(width, height)
        self._free = np.ones(width * height, bool)
        self._nearest = nothing(width * height)
        self._ink: list[np.ndarray] = []

    def paint(self, mesh: PolyData, cracks: PolyData | None, whole: bool) -> None:
        """Paints what covers pixels that are free. `whole`: all of the frame's cracks belong to the pattern."""
        points = reference_points(mesh)
        pixels, near = self.camera.project(points)
        shown = np.arange(len(mesh.triangles)) if whole else np.flatnonzero(self._is_free(pixels[mesh.triangles]))
        if not len(shown):
            return
        fragment, damage = mesh.of_triangles("fragment", 0), np.clip(mesh.of_triangles("damage", 0.0), 0.0, 1.0)
        if damage.ndim == 2:  # one value for each layer
            damage = damage.max(axis=1)
        colours = _pastel(fragment)[shown]
        colours += 0.6 * damage[shown, None] * (DAMAGE - colours)
        fresh = np.zeros(len(self._free), bool)
        hit, triangle = self._rasterise(pixels, near, mesh.triangles[shown])
        self._picture[hit] = colours[triangle]
        fresh[hit] = True
        self._free[hit] = False
        pieces = np.isin(fragment, fragment[shown])
        lines = [points[fragment_edges(mesh, pieces)]]
        if cracks is not None and (whole or "displacement" in cracks.point_data):
            lines.append(reference_points(cracks)[cracks.segments()])
        for drawn in map(self._pixels, lines):
            self._ink.append(drawn if whole else drawn[fresh[drawn]])

    def inked(self) -> np.ndarray:
        """Returns the picture with its lines."""
        ink = np.unique(np.concatenate(self._ink))
        self._picture[ink] += 0.85 * (INK - self._picture[ink])
        return self._picture.reshape(self._height, self._width, 3)

    def _is_free(self, corner: np.ndarray) -> np.ndarray:
        """Tests triangles (m, 3, 2) [px] for a free pixel in the middle or towards a corner."""
        middle = corner.mean(axis=1, keepdims=True)
        at = np.floor(np.concatenate([middle, middle + 0.6 * (corner - middle)], axis=1)).astype(np.int64)
        inside = ((at >= 0) & (at < [self._width, self._height])).all(axis=2)
        return (inside & self._free[np.where(inside, at[..., 1] * self._width + at[..., 0], 0)]).any(axis=1)

    def _rasterise(self, pixels: np.ndarray, near: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns free pixels that triangles cover, and these triangles."""
        index, depth = self._nearest
        rasterise(pixels, near, triangles, self._width, self._height, self._nearest)
        covered = np.flatnonzero(index >= 0)
        hit = covered[self._free[covered]]
        triangle = index[hit]
        index[covered], depth[covered] = -1, -np.inf
        return hit, triangle

    def _pixels(self, segments: np.ndarray) -> np.ndarray:
        start, near_start = self.camera.project(segments[:, 0])
        end, near_end = self.camera.project(segments[:, 1])
        return line_pixels(start, end, near_start, near_end, self._width, self._height, 2)[0]


def along_normal(points: np.ndarray, triangles: np.ndarray, width: int, height: int, margin: float) -> Camera:
    """Looks straight on the pane, from above where it is level."""
    corner = points[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]).sum(axis=0)
    normal /= max(float(np.linalg.norm(normal)), 1e-12)
    if normal[2] < -1e-6:
        normal = -normal
    up = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < 0.7 else np.array([0.0, 0.0, 1.0])
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    trial = orthographic_camera(centre, -normal, up, 1.0, 1.0, 0, 0)
    local = (points - centre) @ trial.axes[:2].T
    scale = float(np.min(np.array([width, height]) / np.maximum(np.ptp(local, axis=0), 1e-9))) / margin
    return orthographic_camera(centre, -normal, up, scale, scale, width, height)


def proportion(first: PolyData) -> float:
    """Returns width over height of the pane in its crack pattern."""
    points = reference_points(first)
    pixels, _ = along_normal(points, first.triangles, 1, 1, 1.0).project(points)
    wide, high = np.maximum(np.ptp(pixels, axis=0), 1e-9)
    return float(wide / high)


def side_view(scene: Scene, low: np.ndarray, high: np.ndarray, width: int, height: int) -> tuple[np.ndarray, Camera]:
    """Draws the box low..high [m] edge on along +y, without perspective.

    The floor is seen as the edge of a grey ground, so a body that hovers shows a gap and one that sinks is cut by the line.
    """
    extent = np.maximum(high - low, 1e-6)
    scale = min(width / extent[0], height / extent[2])
    camera = orthographic_camera(0.5 * (low + high), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]),
                                 scale, scale, width, height)
    picture = draw_scene(scene, camera, width, height)
    if scene.floor_z is not None:
        row = int(round(camera.project(np.array([[0.0, 0.0, scene.floor_z]]))[0][0, 1]))
        ground = max(row, 0)
        picture[ground:] += 0.45 * (np.array([0.70, 0.69, 0.67]) - picture[ground:])
        picture[ground:ground + 2] = 0.25
    return picture, camera
