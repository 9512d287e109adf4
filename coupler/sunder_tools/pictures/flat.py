"""Draws the crack pattern from above, and the last frame edge on."""
from __future__ import annotations

import numpy as np

from .frames import CRACKS, SHELL, Frame
from .meshes import Scene, fragment_edges, reference_points
from .raster import Camera, line_pixels, orthographic_camera, rasterise
from .views import INK, background, draw_scene

PAINTED_FRAMES = 24  # largest number of frames painted over one another
DAMAGE = np.array([0.93, 0.62, 0.45])


def _pastel(fragment: np.ndarray) -> np.ndarray:
    """Returns pale colours that differ between neighbouring ids; the largest fragment stays nearly white."""
    ids, inverse, count = np.unique(fragment, return_inverse=True, return_counts=True)
    hue = np.modf(ids * 0.6180339887498949)[0] * 2.0 * np.pi
    colours = 0.86 + 0.10 * np.cos(hue[:, None] - np.array([0.0, 2.0943951, 4.1887902]))
    if len(count):
        colours[count.argmax()] = [0.95, 0.97, 0.97]
    return colours[inverse]


def crack_pattern(frames: list[Frame], width: int, height: int, margin: float = 1.08) -> tuple[np.ndarray, float] | None:
    """Draws the undeformed pane along its normal: (height, width, 3) colours 0..1, and the scale [px/m].

    A fragment that was handed over is no longer in the shell's later frames, so the frames before each
    hand-over are painted first and the last one over them. None if the run has no shell frames.
    """
    # Areas show when fragments leave. The meshes are read again, since all at once may not fit in memory.
    kept: list[tuple[Frame, float]] = []
    for frame in frames:
        mesh = frame.read(SHELL)
        if mesh is not None:
            corner = reference_points(mesh)[mesh.triangles]
            kept.append((frame, 0.5 * float(np.linalg.norm(
                np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1).sum())))
    if not kept or kept[0][1] <= 0.0:
        return None
    lost = [kept[k][1] - kept[k + 1][1] if k + 1 < len(kept) else np.inf for k in range(len(kept))]
    paint = sorted(k for k in np.argsort(lost)[::-1][:PAINTED_FRAMES] if lost[k] > 1e-9)

    first = kept[0][0].read(SHELL)
    assert first is not None
    points = reference_points(first)
    camera = along_normal(points, first.triangles, width, height, margin)
    picture = background(width, height)
    inked: list[np.ndarray] = []
    for k in paint:
        mesh = kept[k][0].read(SHELL)
        assert mesh is not None
        points = reference_points(mesh)
        pixels, near = camera.project(points)
        index, _ = rasterise(pixels, near, mesh.triangles, width, height)
        hit = index >= 0
        damage = np.clip(mesh.of_triangles("damage", 0.0), 0.0, 1.0)
        if damage.ndim == 2:  # one value for each layer
            damage = damage.max(axis=1)
        colours = _pastel(mesh.of_triangles("fragment", 0))
        colours = colours + 0.6 * damage[:, None] * (DAMAGE - colours)
        picture[hit] = colours[index[hit]]
        inked.append(_ink(points[fragment_edges(mesh)], camera, width, height))
        cracks = kept[k][0].read(CRACKS)
        if cracks is not None and ("displacement" in cracks.point_data or k == paint[-1]):
            inked.append(_ink(reference_points(cracks)[cracks.segments()], camera, width, height))
    ink = np.unique(np.concatenate(inked))
    picture[ink] += 0.85 * (INK - picture[ink])
    return picture.reshape(height, width, 3), float(camera.scale[0])


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


def _ink(segments: np.ndarray, camera: Camera, width: int, height: int) -> np.ndarray:
    start, near_start = camera.project(segments[:, 0])
    end, near_end = camera.project(segments[:, 1])
    return line_pixels(start, end, near_start, near_end, width, height, 2)[0]


def side_view(scene: Scene, low: np.ndarray, high: np.ndarray, width: int, height: int,
              stretch: bool = True) -> tuple[np.ndarray, Camera]:
    """Draws the box low..high [m] edge on along +y, without perspective.

    With `stretch` the heights fill the picture on their own scale. The floor is seen as the edge of
    a grey ground, so a body that hovers shows a gap and one that sinks is cut by the line.
    """
    extent = np.maximum(high - low, 1e-6)
    scale = np.array([width / extent[0], height / extent[2]])
    if not stretch:
        scale[:] = scale.min()
    camera = orthographic_camera(0.5 * (low + high), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]),
                                 scale[0], scale[1], width, height)
    picture = draw_scene(scene, camera, width, height)
    if scene.floor_z is not None:
        row = int(round(camera.project(np.array([[0.0, 0.0, scene.floor_z]]))[0][0, 1]))
        ground = max(row, 0)
        picture[ground:] += 0.45 * (np.array([0.70, 0.69, 0.67]) - picture[ground:])
        picture[ground:ground + 2] = 0.25
    return picture, camera
