"""Cameras and a z-buffer rasteriser in numpy."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

NEAR_M = 0.02  # triangles with a corner nearer to the eye are not drawn
CANDIDATES = 200_000  # (triangle, pixel) pairs that are handled at once; limits the memory
INSIDE = 1e-9  # of a barycentric weight: pixels on an edge belong to both triangles


@dataclass(frozen=True)
class Camera:
    """Maps the world [m] to pixels. `nearness` is linear over a triangle on the screen and larger for nearer points:
    1/depth with perspective, -depth without."""
    eye: np.ndarray     # (3,) [m]
    axes: np.ndarray    # (3, 3) rows: right, down, forward
    scale: np.ndarray   # (2,) perspective: focal length [px]; else [px/m]; may differ in x and y
    centre: np.ndarray  # (2,) [px], where the forward axis meets the picture
    perspective: bool

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns pixels (n, 2) and nearness (n,); NaN where a point is too near to the eye."""
        local = (points - self.eye) @ self.axes.T
        depth = local[:, 2]
        if not self.perspective:
            return local[:, :2] * self.scale + self.centre, -depth
        near = np.where(depth > NEAR_M, 1.0 / np.maximum(depth, NEAR_M), np.nan)
        return local[:, :2] * near[:, None] * self.scale + self.centre, near

    def unproject(self, pixels: np.ndarray, nearness: np.ndarray) -> np.ndarray:
        """Returns world positions (n, 3) of pixels with known nearness."""
        depth = 1.0 / nearness if self.perspective else -nearness
        right, down = ((pixels[:, k] - float(self.centre[k])) / float(self.scale[k]) for k in (0, 1))
        if self.perspective:
            right *= depth
            down *= depth
        world = np.empty((len(pixels), 3), pixels.dtype)
        for k in range(3):  # a product of matrices as narrow as these is several times as slow
            x, y, z, start = (float(value) for value in (*self.axes[:, k], self.eye[k]))
            world[:, k] = right * x + down * y + depth * z + start
        return world

    def towards_eye(self, points: np.ndarray) -> np.ndarray:
        """Returns unit vectors (n, 3) from points to the eye."""
        if not self.perspective:
            return np.broadcast_to(-self.axes[2].astype(points.dtype), points.shape)
        rays = self.eye.astype(points.dtype) - points
        return rays / np.maximum(np.sqrt(np.einsum("ij,ij->i", rays, rays)), 1e-12)[:, None]


def _axes(forward: np.ndarray, up: np.ndarray) -> np.ndarray:
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def perspective_camera(low: np.ndarray, high: np.ndarray, direction: np.ndarray, width: int, height: int,
                       field_deg: float = 28.0, margin: float = 1.06) -> Camera:
    """Makes a camera along `direction`, with the box low..high [m] filling the picture."""
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
    """Makes a camera along `direction` without perspective; `centre` [m] is in the middle, scales are in px/m."""
    axes = _axes(np.asarray(direction, float), np.asarray(up, float))
    return Camera(np.asarray(centre, float), axes, np.array([scale_x, scale_y]),
                  np.array([0.5 * width, 0.5 * height]), False)


def nothing(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns what `rasterise` finds for so many pixels where no triangle is: indices -1, nearness -inf."""
    return np.full(count, -1, np.int64), np.full(count, -np.inf)


def rasterise(pixels: np.ndarray, nearness: np.ndarray, triangles: np.ndarray, width: int, height: int,
              before: tuple[np.ndarray, np.ndarray] | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Finds the nearest triangle for each pixel: indices, -1 where none; nearness, -inf where none; flat, row by
    row.

    `pixels` (n, 2) and `nearness` (n,) are the projected points; both sides of triangles are seen. The result is written into
    `before` where that is given.
    """
    index, depth = before if before is not None else nothing(width * height)
    corner = pixels[triangles]  # (m, 3, 2)
    near = nearness[triangles]
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    with np.errstate(invalid="ignore"):
        # a reduction over an axis as short as these is several times as slow
        low = np.ceil(np.minimum(np.minimum(a, b), c) - 0.5)    # pixel centres are at k + 0.5
        high = np.floor(np.maximum(np.maximum(a, b), c) - 0.5)
        area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
        low = np.maximum(low, 0.0)
        high = np.minimum(high, [width - 1.0, height - 1.0])
        good = (high[:, 0] >= low[:, 0]) & (high[:, 1] >= low[:, 1])
        good &= np.isfinite(area) & (np.abs(area) > 1e-9) & np.isfinite(near[:, 0] + near[:, 1] + near[:, 2])
    kept = np.flatnonzero(good)
    if len(kept) == 0:
        return index, depth
    span = (high[kept] - low[kept] + 1).astype(np.int64)
    count = span[:, 0] * span[:, 1]
    ends = np.cumsum(count)
    start = 0
    while start < len(kept):
        stop = max(start + 1, int(np.searchsorted(ends, (ends[start - 1] if start else 0) + CANDIDATES)))
        _rasterise_some(kept[start:stop], span[start:stop], low, corner, area, near, width, index, depth)
        start = stop
    return index, depth


def _rasterise_some(ids: np.ndarray, span: np.ndarray, low: np.ndarray, corner: np.ndarray, area: np.ndarray,
                    near: np.ndarray, width: int, index: np.ndarray, depth: np.ndarray) -> None:
    """Goes through the rows of each triangle and the pixels inside; updates `index` and `depth`."""
    # Barycentric weights and nearness are affine in the pixel: one gradient per triangle, (m, 3) by corner.
    a, b, c = corner[ids, 0], corner[ids, 1], corner[ids, 2]
    inverse = 1.0 / area[ids]
    gx = np.stack([b[:, 1] - c[:, 1], c[:, 1] - a[:, 1], a[:, 1] - b[:, 1]]) * inverse
    gy = np.stack([c[:, 0] - b[:, 0], a[:, 0] - c[:, 0], b[:, 0] - a[:, 0]]) * inverse
    at = low[ids] + 0.5 - a
    first = gx * at[:, 0] + gy * at[:, 1]  # weights at the first pixel of the box
    first[0] += 1.0
    rows, row = _counted(span[:, 1])
    slope, start = gx[:, rows], first[:, rows] + row * gy[:, rows]
    with np.errstate(divide="ignore", invalid="ignore"):
        zero = -(start + INSIDE) / slope  # column where a weight becomes positive, or stops being so
        never = (slope == 0.0) & (start < -INSIDE)
        never = never[0] | never[1] | never[2]
    columns = span[rows, 0].astype(float)
    opens, closes = np.where(slope > 0.0, zero, 0.0), np.where(slope < 0.0, zero, np.inf)
    begin = np.maximum(np.maximum(opens[0], opens[1]), opens[2])
    begin = np.ceil(np.minimum(np.maximum(begin, 0.0), columns))
    end = np.minimum(np.minimum(closes[0], closes[1]), closes[2])
    end = np.floor(np.maximum(np.minimum(end, columns - 1.0), -1.0))
    count = np.where(never, 0.0, np.maximum(end - begin + 1.0, 0.0)).astype(np.int64)
    line, column = _counted(count)
    column += np.take(begin.astype(np.int64), line)
    rise = (near[ids, 1:] - near[ids, :1]).T  # (2, m): a face of constant nearness keeps it to the bit
    value = near[ids, 0][rows] + (start[1:] * rise[:, rows]).sum(axis=0)
    value = np.take(value, line) + column * np.take((gx[1:] * rise).sum(axis=0)[rows], line)
    pixel = np.take((low[ids, 1].astype(np.int64)[rows] + row) * width + low[ids, 0].astype(np.int64)[rows], line) + column
    tri = np.take(ids[rows], line)
    # numpy keeps any one of several candidates for a pixel, so this repeats with those that are still nearer.
    while True:
        nearer = value > np.take(depth, pixel)
        if not nearer.any():
            return
        if not nearer.all():
            pixel, value, tri = pixel[nearer], value[nearer], tri[nearer]
        depth[pixel] = value
        index[pixel] = tri


def _counted(count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns, for counts (m,), the owner of each counted item and its number with that owner."""
    whose = np.repeat(np.arange(len(count)), count)
    return whose, np.arange(len(whose)) - np.repeat(np.cumsum(count) - count, count)


def line_pixels(start: np.ndarray, end: np.ndarray, near_start: np.ndarray, near_end: np.ndarray, width: int,
                height: int, thick: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns pixels (flat) and nearness of line segments given by projected ends, `thick` pixels wide."""
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
