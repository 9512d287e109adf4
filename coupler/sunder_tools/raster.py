"""Cameras and a z-buffer rasteriser in numpy."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

NEAR_M = 0.02            # triangles with a corner closer to the eye are not drawn
CANDIDATES = 1_500_000   # (triangle, pixel) pairs handled at once; bounds the memory


@dataclass(frozen=True)
class Camera:
    """World [m] to pixels. `nearness` is linear across a triangle on the screen, greater is nearer:
    1/depth with perspective, -depth without."""
    eye: np.ndarray     # (3,) [m]
    axes: np.ndarray    # (3, 3) rows: right, down, forward
    scale: np.ndarray   # (2,) perspective: focal length [px]; else [px/m]; may differ in x and y
    centre: np.ndarray  # (2,) [px], where the forward axis goes through
    perspective: bool

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pixels (n, 2) and nearness (n,); NaN where a point is too near to be seen."""
        local = (points - self.eye) @ self.axes.T
        depth = local[:, 2]
        if not self.perspective:
            return local[:, :2] * self.scale + self.centre, -depth
        near = np.where(depth > NEAR_M, 1.0 / np.maximum(depth, NEAR_M), np.nan)
        return local[:, :2] * near[:, None] * self.scale + self.centre, near

    def unproject(self, pixels: np.ndarray, nearness: np.ndarray) -> np.ndarray:
        """World positions (n, 3) of pixels with known nearness."""
        local = np.empty((len(pixels), 3))
        local[:, :2] = (pixels - self.centre) / self.scale
        if self.perspective:
            local[:, 2] = 1.0 / nearness
            local[:, :2] *= local[:, 2:]
        else:
            local[:, 2] = -nearness
        return local @ self.axes + self.eye

    def towards_eye(self, points: np.ndarray) -> np.ndarray:
        """Unit vectors (n, 3) from points to the eye."""
        if not self.perspective:
            return np.broadcast_to(-self.axes[2], points.shape)
        rays = self.eye - points
        return rays / np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), 1e-12)


def _axes(forward: np.ndarray, up: np.ndarray) -> np.ndarray:
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def perspective_camera(low: np.ndarray, high: np.ndarray, direction: np.ndarray, width: int, height: int,
                       field_deg: float = 28.0, margin: float = 1.06) -> Camera:
    """Looks along `direction` so that the box low..high [m] fills the picture."""
    axes = _axes(np.asarray(direction, float), np.array([0.0, 0.0, 1.0]))
    focal = 0.5 * height / np.tan(0.5 * np.radians(field_deg))
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    local = (corners - corners.mean(axis=0)) @ axes.T
    offset = np.zeros(2)
    distance = 1.0
    for _ in range(20):  # centre the projected box, then step back until it fits
        # |x - offset| * focal / (z + d) <= half size / margin, for each corner and direction
        need = [np.max(np.abs(local[:, k] - offset[k]) * focal * margin / (0.5 * size) - local[:, 2])
                for k, size in ((0, width), (1, height))]
        distance = max(max(need), NEAR_M - local[:, 2].min() + 0.05)
        seen = local[:, :2] / (local[:, 2:] + distance)
        offset = offset + 0.5 * distance * (np.max(seen - offset / (local[:, 2:] + distance), axis=0)
                                            + np.min(seen - offset / (local[:, 2:] + distance), axis=0))
    eye = corners.mean(axis=0) + offset @ axes[:2] - distance * axes[2]
    return Camera(eye, axes, np.array([focal, focal]), np.array([0.5 * width, 0.5 * height]), True)


def orthographic_camera(centre: np.ndarray, direction: np.ndarray, up: np.ndarray, scale_x: float,
                        scale_y: float, width: int, height: int) -> Camera:
    """Looks along `direction`; `centre` [m] is in the middle, scales in px/m."""
    axes = _axes(np.asarray(direction, float), np.asarray(up, float))
    return Camera(np.asarray(centre, float), axes, np.array([scale_x, scale_y]),
                  np.array([0.5 * width, 0.5 * height]), False)


def rasterise(pixels: np.ndarray, nearness: np.ndarray, triangles: np.ndarray, width: int,
              height: int) -> tuple[np.ndarray, np.ndarray]:
    """Nearest triangle per pixel: (indices, -1 where none; nearness, -inf where none), flat, row by row.

    `pixels` (n, 2) and `nearness` (n,) are the projected points; both sides of triangles are seen.
    """
    index = np.full(width * height, -1, np.int64)
    depth = np.full(width * height, -np.inf)
    corner = pixels[triangles]  # (m, 3, 2)
    low = np.ceil(corner.min(axis=1) - 0.5)    # pixel centres are at k + 0.5
    high = np.floor(corner.max(axis=1) - 0.5)
    with np.errstate(invalid="ignore"):
        area = ((corner[:, 1, 0] - corner[:, 0, 0]) * (corner[:, 2, 1] - corner[:, 0, 1])
                - (corner[:, 2, 0] - corner[:, 0, 0]) * (corner[:, 1, 1] - corner[:, 0, 1]))
        low = np.clip(low, 0, [width, height])
        high = np.clip(high, -1, [width - 1, height - 1])
        good = np.isfinite(area) & (np.abs(area) > 1e-9) & (high >= low).all(axis=1)
        good &= np.isfinite(nearness[triangles]).all(axis=1)
    kept = np.flatnonzero(good)
    if len(kept) == 0:
        return index, depth
    span = (high[kept] - low[kept] + 1).astype(np.int64)
    count = span[:, 0] * span[:, 1]
    ends = np.cumsum(count)
    near = nearness[triangles]
    start = 0
    while start < len(kept):
        stop = max(start + 1, int(np.searchsorted(ends, (ends[start - 1] if start else 0) + CANDIDATES)))
        _rasterise_some(kept[start:stop], span[start:stop], count[start:stop], low, corner, area,
                        near, width, index, depth)
        start = stop
    return index, depth


def _rasterise_some(ids: np.ndarray, span: np.ndarray, count: np.ndarray, low: np.ndarray, corner: np.ndarray,
                    area: np.ndarray, near: np.ndarray, width: int, index: np.ndarray, depth: np.ndarray) -> None:
    """Every pixel of every bounding box at once; updates `index` and `depth`."""
    which = np.repeat(np.arange(len(ids)), count)
    local = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    row, column = np.divmod(local, span[which, 0])
    tri = ids[which]
    x = column + low[tri, 0]
    y = row + low[tri, 1]
    # Barycentric weights and nearness are affine in the pixel: one gradient per triangle.
    a, b, c = corner[ids, 0], corner[ids, 1], corner[ids, 2]
    inverse = 1.0 / area[ids]
    w1x, w1y = (c[:, 1] - a[:, 1]) * inverse, -(c[:, 0] - a[:, 0]) * inverse
    w2x, w2y = -(b[:, 1] - a[:, 1]) * inverse, (b[:, 0] - a[:, 0]) * inverse
    dx, dy = x + 0.5 - a[which, 0], y + 0.5 - a[which, 1]
    w1 = dx * w1x[which] + dy * w1y[which]
    w2 = dx * w2x[which] + dy * w2y[which]
    inside = (w1 >= -1e-9) & (w2 >= -1e-9) & (w1 + w2 <= 1.0 + 1e-9)
    tri, w1, w2 = tri[inside], w1[inside], w2[inside]
    pixel = (y[inside] * width + x[inside]).astype(np.int64)
    value = near[tri, 0] + w1 * (near[tri, 1] - near[tri, 0]) + w2 * (near[tri, 2] - near[tri, 0])
    # Of several candidates for a pixel numpy keeps any one; repeat with those that are still nearer.
    while True:
        nearer = value > depth[pixel]
        if not nearer.any():
            return
        pixel, value, tri = pixel[nearer], value[nearer], tri[nearer]
        depth[pixel] = value
        index[pixel] = tri


def line_pixels(start: np.ndarray, end: np.ndarray, near_start: np.ndarray, near_end: np.ndarray, width: int,
                height: int, thick: int) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (flat) and nearness of line segments given by projected ends; `thick` pixels wide."""
    length = np.abs(end - start).max(axis=1) if len(start) else np.zeros(0)
    good = np.isfinite(length) & (length < 4 * (width + height))
    start, end, near_start, near_end, length = (v[good] for v in (start, end, near_start, near_end, length))
    steps = np.ceil(length * 1.2).astype(np.int64) + 1
    which = np.repeat(np.arange(len(steps)), steps)
    local = np.arange(len(which)) - np.repeat(np.cumsum(steps) - steps, steps)
    share = local / np.maximum(steps[which] - 1, 1)
    at = start[which] + share[:, None] * (end - start)[which]
    near = near_start[which] + share * (near_end - near_start)[which]
    found, values = [], []
    for row in range(thick):
        for column in range(thick):
            x = np.floor(at[:, 0] + column - 0.5 * (thick - 1)).astype(np.int64)
            y = np.floor(at[:, 1] + row - 0.5 * (thick - 1)).astype(np.int64)
            seen = (x >= 0) & (x < width) & (y >= 0) & (y < height)
            found.append(y[seen] * width + x[seen])
            values.append(near[seen])
    return np.concatenate(found), np.concatenate(values)
