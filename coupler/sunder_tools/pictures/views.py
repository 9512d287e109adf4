"""Shading: an oblique or side-on picture of a scene."""
from __future__ import annotations

import numpy as np
from PIL import Image, ImageFilter

from .meshes import Scene, Surface
from .raster import Camera, line_pixels, rasterise

LIGHT = np.array([-0.36, -0.28, 0.89]) / np.linalg.norm([-0.36, -0.28, 0.89])  # towards the light
SKY = (np.array([0.985, 0.988, 0.990]), np.array([0.90, 0.92, 0.94]))  # top, bottom of the picture
INK = np.array([0.06, 0.12, 0.16])
SHADOW_HALF_M = 1.3      # the shadow map reaches this far from its centre
SHADOW_TEXELS = 800
GRID_M = 0.1             # spacing of the lines on the floor
BAND = 1 << 14           # [pixels] that are shaded at once; their arrays fit into the cache of a core


def background(width: int, height: int) -> np.ndarray:
    """(height*width, 3) colours 0..1."""
    share = np.linspace(0.0, 1.0, height)[:, None, None]
    picture = np.empty((height, width, 3), np.float32)
    picture[:] = SKY[0] + share * (SKY[1] - SKY[0])
    return picture.reshape(-1, 3)


class _Shadows:
    """How dark the floor is: shadows thrown along the light on the plane z = floor_z."""

    def __init__(self, scene: Scene, floor_z: float) -> None:
        thrown = np.concatenate([scene.shards, scene.moving, scene.glass.points[np.unique(scene.glass.triangles)]])
        self._low = (np.median(thrown[:, :2], axis=0) if len(thrown) else np.zeros(2)) - SHADOW_HALF_M
        self._scale = SHADOW_TEXELS / (2.0 * SHADOW_HALF_M)
        solid = scene.solid
        dark = self._mask(scene.glass, scene.glass.triangles, floor_z) * 0.26
        if len(solid.triangles):
            dark = np.maximum(dark, self._mask(solid, solid.triangles[solid.throws], floor_z) * 0.5)
        image = Image.fromarray((dark * 255).astype(np.uint8)).filter(ImageFilter.GaussianBlur(1.0))
        self._dark = np.asarray(image, float).ravel() / 255.0

    def _mask(self, surface: Surface, triangles: np.ndarray, floor_z: float) -> np.ndarray:
        points = surface.points
        shadow = points[:, :2] - (points[:, 2:] - floor_z) * LIGHT[:2] / LIGHT[2]
        near = np.where(points[:, 2] > floor_z - 0.01, 0.0, np.nan)
        index, _ = rasterise((shadow - self._low) * self._scale, near, triangles, SHADOW_TEXELS, SHADOW_TEXELS)
        return (index >= 0).reshape(SHADOW_TEXELS, SHADOW_TEXELS)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Darkness 0..1 at points of the floor."""
        x, y = (np.floor((points[:, k] - self._low[k]) * self._scale) for k in (0, 1))
        inside = (x >= 0) & (x < SHADOW_TEXELS) & (y >= 0) & (y < SHADOW_TEXELS)
        cell = np.where(inside, y * SHADOW_TEXELS + x, 0.0).astype(np.int64)
        return np.where(inside, np.take(self._dark, cell), 0.0)


class _Shader:
    """Shades points of a surface: Lambert, a highlight and a rim. What depends on triangles only is computed once."""

    def __init__(self, surface: Surface, glass: bool) -> None:
        self._surface, self._glass = surface, glass
        self.normals = surface.normals()
        corners = surface.triangles
        # what a corner lacks of a normal is zero: a triangle without any is flat
        self._curved = np.abs(surface.smooth).sum(axis=1)[corners].sum(axis=1) > 0.0
        self._round = ~np.isnan(surface.round_centre[:, 0])
        # Barycentric weights are affine in the point: one gradient per corner of each triangle, taken from the next corner.
        a, b, c = (surface.points[corners[:, k]] for k in range(3))
        face = np.cross(b - a, c - a)
        square = np.maximum(_dot(face, face), 1e-300)[:, None]
        self._weights = [(gradient := np.cross(face, q - p) / square, _dot(gradient, p))
                         for p, q in ((b, c), (c, a), (a, b))]  # opposite each corner

    def colours(self, index: np.ndarray, world: np.ndarray, eye: np.ndarray) -> np.ndarray:
        """Returns colours (n, 3) at the points `world` (n, 3) of the triangles `index`; `eye` are unit vectors towards the
        eye."""
        normal = np.take(self.normals, index, axis=0)
        self._round_normals(index, world, normal)
        self._bent_normals(index, world, normal)
        facing = _dot(normal, eye)
        normal *= np.where(facing < 0.0, -1.0, 1.0)[:, None]
        lambert = np.maximum(normal @ LIGHT, 0.0)
        half = eye + LIGHT
        highlight = np.maximum(_dot(normal, half) / np.sqrt(_dot(half, half)), 0.0)
        rim = _cube(1.0 - np.minimum(np.abs(facing), 1.0))
        base = np.take(self._surface.colours, index, axis=0)
        if self._glass:
            base *= (0.66 + 0.40 * lambert)[:, None]
            base += (0.22 * _cube(highlight) ** 8 + 0.10 * rim)[:, None]
        else:
            base *= (0.50 + 0.58 * lambert)[:, None]
            base += (0.45 * (highlight ** 8) ** 5 + 0.12 * rim)[:, None]
        return base

    def _round_normals(self, index: np.ndarray, world: np.ndarray, normal: np.ndarray) -> None:
        """Sets the normals at points of balls."""
        at = np.flatnonzero(self._round[index])
        if len(at):
            out = world[at] - self._surface.round_centre[index[at]]
            normal[at] = out / np.maximum(np.sqrt(_dot(out, out)), 1e-12)[:, None]

    def _bent_normals(self, index: np.ndarray, world: np.ndarray, normal: np.ndarray) -> None:
        """Sets the normals at points of curved triangles to those between the corners'."""
        at = np.flatnonzero(self._curved[index])
        if len(at) == 0:
            return
        triangle, point = index[at], world[at]
        corners, smooth = self._surface.triangles, self._surface.smooth
        sum_ = np.zeros((len(at), 3))
        for k, (gradient, offset) in enumerate(self._weights):
            weight = np.clip(_dot(np.take(gradient, triangle, axis=0), point) - np.take(offset, triangle), 0.0, 1.0)
            sum_ += weight[:, None] * np.take(smooth, np.take(corners[:, k], triangle), axis=0)
        length = np.sqrt(_dot(sum_, sum_))
        seen = length > 1e-6
        normal[at[seen]] = sum_[seen] / length[seen, None]


def _cube(values: np.ndarray) -> np.ndarray:
    """Third power; numpy's own is some thirty times as slow."""
    return values * values * values


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of rows (n, 3): (n,). Three times as fast as a sum over the short axis."""
    return np.einsum("ij,ij->i", a, b)


def _floor(colours: np.ndarray, points: np.ndarray, pixel_m: np.ndarray, shadows: _Shadows) -> np.ndarray:
    """Grid lines and shadows over the floor's colour; `pixel_m` is a pixel's size there [m]."""
    x, y = points[:, 0] / GRID_M, points[:, 1] / GRID_M
    off = np.minimum(np.abs(x - np.rint(x)), np.abs(y - np.rint(y))) * GRID_M  # [m] from a line
    line = np.clip(1.2 - off / pixel_m, 0.0, 1.0)
    return colours * ((1.0 - 0.09 * line) * (1.0 - shadows.at(points)))[:, None]


def draw_scene(scene: Scene, camera: Camera, width: int, height: int, line_px: int = 2) -> np.ndarray:
    """The picture, (height, width, 3) colours 0..1. Glass lets a part of what is behind it through.

    Pixels are shaded in bands that stay in the processor's cache. Arrays of a whole picture come fresh from the system each
    time, and making their pages took as long as the shading.
    """
    picture = background(width, height)
    pixels, near = camera.project(scene.solid.points)
    solid = rasterise(pixels, near, scene.solid.triangles, width, height)
    pixels, near = camera.project(scene.glass.points)
    glass = rasterise(pixels, near, scene.glass.triangles, width, height)
    painter = _Painter(scene, camera, width)
    for begin in range(0, len(picture), BAND):
        band = slice(begin, begin + BAND)
        index, depth = solid[0][band], solid[1][band]
        painter.solid(picture[band], begin, index, depth)
        painter.glass(picture[band], begin, glass[0][band], glass[1][band], depth)
    front = np.maximum(solid[1], glass[1], out=glass[1])
    _draw_lines(picture, scene.outlines, camera, front, width, height, line_px, 0.50)
    _draw_lines(picture, scene.cracks, camera, front, width, height, line_px, 0.80)
    return np.clip(picture, 0.0, 1.0, out=picture).reshape(height, width, 3)


def as_bytes(picture: np.ndarray) -> np.ndarray:
    """Colours 0..1 (height, width, 3) as bytes, row by row for the sake of the cache."""
    out = np.empty(picture.shape, np.uint8)
    for row, colours in enumerate(picture):
        out[row] = colours * 255.0 + 0.5
    return out


class _Painter:
    """Paints bands of a picture: consecutive pixels, the first of which has the number `begin`."""

    def __init__(self, scene: Scene, camera: Camera, width: int) -> None:
        self._scene, self._camera, self._width = scene, camera, width
        self._solid, self._glass = _Shader(scene.solid, glass=False), _Shader(scene.glass, glass=True)
        self._shadows = None if scene.floor_z is None or not scene.solid.is_floor.any() else _Shadows(scene, scene.floor_z)
        self._of_floor = (scene.solid.is_floor & (self._shadows is not None)).astype(np.int8)  # per triangle

    def _world(self, pixel: np.ndarray, nearness: np.ndarray) -> np.ndarray:
        row, column = np.divmod(pixel, self._width)
        return self._camera.unproject(np.stack([column + 0.5, row + 0.5], axis=1), nearness)

    def solid(self, picture: np.ndarray, begin: int, index: np.ndarray, depth: np.ndarray) -> None:
        """Paints what is opaque: triangles `index` (-1: none) of nearness `depth`."""
        if len(self._scene.solid.triangles) == 0:
            return
        kind = np.where(index < 0, 0, 1 + np.take(self._of_floor, index))  # 0 nothing, 1 something, 2 the floor
        at = np.flatnonzero(kind == 1)
        if len(at):
            world = self._world(at + begin, depth[at])
            picture[at] = self._solid.colours(index[at], world, self._camera.towards_eye(world))
        at = np.flatnonzero(kind == 2)
        if len(at) and self._shadows is not None:
            world = self._world(at + begin, np.take(depth, at))
            away = world - self._camera.eye
            distance = np.sqrt(_dot(away, away)) if self._camera.perspective else 1.0
            colours = _floor(np.take(self._scene.solid.colours, np.take(index, at), axis=0), world,
                             distance / self._camera.scale.min(), self._shadows)
            if len(at) == len(picture):  # as most often
                picture[:] = colours
            else:
                picture[at] = colours

    def glass(self, picture: np.ndarray, begin: int, index: np.ndarray, depth: np.ndarray, behind: np.ndarray) -> None:
        """Paints glass over what is behind it, at nearness `behind`."""
        at = np.flatnonzero(depth > behind)
        if len(at) == 0:
            return
        world = self._world(at + begin, depth[at])
        eye = self._camera.towards_eye(world)
        colours = self._glass.colours(index[at], world, eye)
        slant = 1.0 - np.abs(_dot(np.take(self._glass.normals, index[at], axis=0), eye))
        opacity = (self._scene.glass_opacity + 0.25 * slant * slant)[:, None]
        picture[at] += opacity * (colours - picture[at])


def _draw_lines(picture: np.ndarray, segments: np.ndarray, camera: Camera, front: np.ndarray, width: int,
                height: int, thick: int, strength: float) -> None:
    """Blends ink over the pixels where a line is not hidden (by more than a bias that spares its own faces)."""
    if len(segments) == 0:
        return
    start, near_start = camera.project(segments[:, 0])
    end, near_end = camera.project(segments[:, 1])
    where, near = line_pixels(start, end, near_start, near_end, width, height, thick)
    bias = 0.004 * near if camera.perspective else 0.002
    seen = np.unique(where[near + bias >= front[where]])
    picture[seen] += strength * (INK - picture[seen])
