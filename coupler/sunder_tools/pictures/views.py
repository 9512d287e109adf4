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


def background(width: int, height: int) -> np.ndarray:
    """(height*width, 3) colours 0..1."""
    share = np.linspace(0.0, 1.0, height)[:, None, None]
    return np.broadcast_to(SKY[0] + share * (SKY[1] - SKY[0]), (height, width, 3)).reshape(-1, 3).copy()


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
        cell = np.floor((points[:, :2] - self._low) * self._scale).astype(np.int64)
        inside = ((cell >= 0) & (cell < SHADOW_TEXELS)).all(axis=1)
        cell = np.where(inside[:, None], cell, 0)
        return np.where(inside, self._dark[cell[:, 1] * SHADOW_TEXELS + cell[:, 0]], 0.0)


def _shade(surface: Surface, index: np.ndarray, world: np.ndarray, eye: np.ndarray, glass: bool) -> np.ndarray:
    """Lambert, a highlight and a rim; `eye` are unit vectors towards the eye."""
    normal = surface.normals()[index]
    centre = surface.round_centre[index]
    round_ = ~np.isnan(centre[:, 0])
    if round_.any():
        out = world[round_] - centre[round_]
        normal[round_] = out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)
    bent = _bent_normals(surface, index, world)
    normal = np.where(np.isfinite(bent), bent, normal)
    facing = _dot(normal, eye)
    normal = np.where(facing[:, None] < 0.0, -normal, normal)
    lambert = np.maximum(normal @ LIGHT, 0.0)[:, None]
    half = eye + LIGHT
    highlight = np.maximum(_dot(normal, half) / np.sqrt(_dot(half, half)), 0.0)[:, None]
    rim = (1.0 - np.minimum(np.abs(facing), 1.0))[:, None] ** 3
    base = surface.colours[index]
    if glass:
        return base * (0.66 + 0.40 * lambert) + 0.22 * highlight ** 24 + 0.10 * rim
    return base * (0.50 + 0.58 * lambert) + 0.45 * highlight ** 40 + 0.12 * rim


def _bent_normals(surface: Surface, index: np.ndarray, world: np.ndarray) -> np.ndarray:
    """Normals between those of the corners, at points of the triangles; NaN where the surface is flat."""
    bent = np.full(world.shape, np.nan)
    corners = surface.triangles
    # what a corner lacks of a normal is zero: a triangle without any is flat
    curved = np.abs(surface.smooth).sum(axis=1)[corners].sum(axis=1) > 0.0
    at = np.flatnonzero(curved[index])
    if len(at) == 0:
        return bent
    # Barycentric weights are affine in the point: one gradient per corner of each triangle, taken from the next corner.
    a, b, c = (surface.points[corners[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    square = np.maximum(_dot(face, face), 1e-300)[:, None]
    triangle, point = index[at], world[at]
    sum_ = np.zeros((len(at), 3))
    for k, (p, q) in enumerate(((b, c), (c, a), (a, b))):  # opposite each corner
        gradient = np.cross(face, q - p) / square
        weight = np.clip(_dot(gradient[triangle], point) - _dot(gradient, p)[triangle], 0.0, 1.0)
        sum_ += weight[:, None] * surface.smooth[corners[:, k]][triangle]
    length = np.sqrt(_dot(sum_, sum_))
    seen = length > 1e-6
    bent[at[seen]] = sum_[seen] / length[seen, None]
    return bent


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of rows (n, 3): (n,). Three times as fast as a sum over the short axis."""
    return np.einsum("ij,ij->i", a, b)


def _floor(colours: np.ndarray, points: np.ndarray, pixel_m: np.ndarray, shadows: _Shadows) -> np.ndarray:
    """Grid lines and shadows over the floor's colour; `pixel_m` is a pixel's size there [m]."""
    off = np.abs(points[:, :2] / GRID_M - np.round(points[:, :2] / GRID_M)) * GRID_M  # [m] from a line
    line = np.clip(1.2 - off.min(axis=1) / pixel_m, 0.0, 1.0)
    return colours * (1.0 - 0.09 * line)[:, None] * (1.0 - shadows.at(points))[:, None]


def draw_scene(scene: Scene, camera: Camera, width: int, height: int, line_px: int = 2) -> np.ndarray:
    """The picture, (height, width, 3) colours 0..1. Glass lets a part of what is behind it through."""
    picture = background(width, height)
    pixels, near = camera.project(scene.solid.points)
    index, depth = rasterise(pixels, near, scene.solid.triangles, width, height)
    hit = np.flatnonzero(index >= 0)
    centre_of = np.stack([hit % width + 0.5, hit // width + 0.5], axis=1)
    if len(hit):
        world = camera.unproject(centre_of, depth[hit])
        colours = _shade(scene.solid, index[hit], world, camera.towards_eye(world), glass=False)
        floor = scene.solid.is_floor[index[hit]]
        if floor.any() and scene.floor_z is not None:
            distance = np.linalg.norm(world[floor] - camera.eye, axis=1) if camera.perspective else 1.0
            colours[floor] = _floor(scene.solid.colours[index[hit]][floor], world[floor],
                                    distance / camera.scale.min(), _Shadows(scene, scene.floor_z))
        picture[hit] = colours
    pixels, near = camera.project(scene.glass.points)
    index, glass_depth = rasterise(pixels, near, scene.glass.triangles, width, height)
    hit = np.flatnonzero(glass_depth > depth)
    if len(hit):
        world = camera.unproject(np.stack([hit % width + 0.5, hit // width + 0.5], axis=1), glass_depth[hit])
        eye = camera.towards_eye(world)
        colours = _shade(scene.glass, index[hit], world, eye, glass=True)
        slant = 1.0 - np.abs(_dot(scene.glass.normals()[index[hit]], eye))
        opacity = (scene.glass_opacity + 0.25 * slant ** 2)[:, None]
        picture[hit] += opacity * (colours - picture[hit])
    front = np.maximum(depth, glass_depth)
    _draw_lines(picture, scene.outlines, camera, front, width, height, line_px, 0.50)
    _draw_lines(picture, scene.cracks, camera, front, width, height, line_px, 0.80)
    return np.clip(picture, 0.0, 1.0).reshape(height, width, 3)


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
