"""Shadows along the light: of pieces on the ground and on one another."""
from __future__ import annotations

import numpy as np

from .meshes import Scene, Surface
from .raster import rasterise

LIGHT = np.array([-0.36, -0.28, 0.89]) / np.linalg.norm([-0.36, -0.28, 0.89])  # towards the light
TEXELS = 480             # of a side of the map
SOLID, GLASS = 0.50, 0.19  # darkness behind these
INNER = (2.0, 98.0)      # [%] of the points decide about the size of the map; dust flies far
ENOUGH = 4000            # of the points for that
MARGIN = 1.25            # of the map around them
OFF = 1.5                # [texels] off a surface, towards the light, at which its shadows are looked up
GRAZING = 4.0            # over the cosine of the light: its shadows fade where the light grazes it


class Shadows:
    """A map of what is nearest to the light."""

    def __init__(self, scene: Scene) -> None:
        across = np.cross(LIGHT, [0.0, 1.0, 0.0])
        across /= np.linalg.norm(across)
        self._axes = np.stack([across, np.cross(LIGHT, across), LIGHT])
        solid, glass = (surface.triangles[surface.throws] for surface in (scene.solid, scene.glass))
        used = [surface.points[triangles[::1 + len(triangles) // ENOUGH, 0]] for surface, triangles in
                ((scene.solid, solid), (scene.glass, glass)) if len(triangles)]
        flat = (np.concatenate(used) if used else np.zeros((1, 3))) @ self._axes[:2].T
        low, high = np.percentile(flat, INNER, axis=0)
        if len(scene.moving):  # bodies have few points
            body, size = scene.moving @ self._axes[:2].T, float((high - low).max())
            low, high = (np.minimum(low, np.maximum(body.min(axis=0), low - size)),
                         np.maximum(high, np.minimum(body.max(axis=0), high + size)))
        side = max(MARGIN * float((high - low).max()), 1e-3)
        self._low, self._scale = 0.5 * (low + high - side), float(TEXELS / side)
        self._single = self._axes.astype(np.float32)
        self._maps = [(self._map(surface, triangles), dark) for surface, triangles, dark in
                      ((scene.solid, solid, SOLID), (scene.glass, glass, GLASS)) if len(triangles)]
        dark: np.ndarray = np.zeros((TEXELS + 2, TEXELS + 2), np.float32)
        for nearest, strength in self._maps:
            dark = np.maximum(dark, np.float32(strength) * (nearest.reshape(dark.shape) > -np.inf))
        for axis in (0, 1):  # of three texels each
            dark = (np.roll(dark, 1, axis) + dark + np.roll(dark, -1, axis)) / 3.0
        self._dark = dark.ravel()

    def _map(self, surface: Surface, triangles: np.ndarray) -> np.ndarray:
        local = surface.points @ self._axes.T
        _, near = rasterise((local[:, :2] - self._low) * self._scale, local[:, 2], triangles, TEXELS, TEXELS)
        bordered = np.full((TEXELS + 2, TEXELS + 2), -np.inf, np.float32)
        bordered[1:-1, 1:-1] = near.reshape(TEXELS, TEXELS)
        return bordered.ravel()

    def below(self, points: np.ndarray) -> np.ndarray:
        """Returns the darkness 0..1 at points (n, 3) below everything, with a soft edge."""
        x, y = (np.floor((points @ axis - low) * self._scale) + 1.0 for axis, low in zip(self._single, map(float, self._low)))
        inside = (x > 0.0) & (x <= TEXELS) & (y > 0.0) & (y <= TEXELS)
        return np.take(self._dark, np.where(inside, y * (TEXELS + 2) + x, 0.0).astype(np.int64))

    def on(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Returns the darkness 0..1 at points (n, 3) of surfaces that throw shadows themselves."""
        light = np.maximum(normals @ self._single[2], 0.0)
        off = points + (OFF / self._scale) * (normals + self._single[2])
        return self.at(off) * np.minimum(GRAZING * light, 1.0)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Returns the darkness 0..1 at points (n, 3)."""
        dark = np.zeros(len(points), np.float32)
        if not self._maps:
            return dark
        x, y, near = (points @ axis for axis in self._single)
        x, y = ((value - float(low)) * self._scale + 0.5 for value, low in ((x, self._low[0]), (y, self._low[1])))
        column, row = np.floor(x), np.floor(y)
        right, down = x - column, y - row  # shares of the four texels around
        inside = (column >= 0) & (column <= TEXELS) & (row >= 0) & (row <= TEXELS)
        first = np.where(inside, row * (TEXELS + 2) + column, 0.0).astype(np.int64)  # 0: of the border, without shadow
        near = np.where(inside, near, np.inf)
        for nearest, strength in self._maps:
            found = np.zeros(len(points), np.float32)
            for step, share in ((0, (1 - right) * (1 - down)), (1, right * (1 - down)), (TEXELS + 2, (1 - right) * down),
                                (TEXELS + 3, right * down)):
                found += share * (np.take(nearest, first + step) > near)
            np.maximum(dark, strength * np.minimum(found, 1.0), out=dark)
        return dark
