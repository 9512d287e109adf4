"""Shading: an oblique or side-on picture of a scene."""
from __future__ import annotations

from typing import Iterator

import numpy as np

from .ground import lines
from .meshes import Scene, Surface
from .raster import Camera, line_pixels, rasterise
from .shadows import LIGHT, Shadows

LIGHT32 = LIGHT.astype(np.float32)

SKY = (np.array([0.985, 0.988, 0.990]), np.array([0.90, 0.92, 0.94]))  # top, bottom of the picture
INK = np.array([0.06, 0.12, 0.16])
STEEPEST = 6.0           # rise of a surface over a pixel [pixels] above which pixels are shaded one by one
EDGE_OPACITY = 1.1       # of glass along its sheet, where its colour is deep
FLAT = 0.9               # cosine between faces below which they are
GRID_M = 0.1             # spacing of the lines on the floor
BAND = 1 << 15           # [pixels] that are shaded at once; their arrays fit into the cache of a core


def background(width: int, height: int) -> np.ndarray:
    """(height*width, 3) colours 0..1."""
    share = np.linspace(0.0, 1.0, height)[:, None, None]
    picture = np.empty((height, width, 3), np.float32)
    picture[:] = SKY[0] + share * (SKY[1] - SKY[0])
    return picture.reshape(-1, 3)


class _Shader:
    """Shades points of a surface: Lambert, a highlight and a rim. What depends on triangles only is computed once."""

    def __init__(self, surface: Surface) -> None:
        self._surface = surface
        self.normals = surface.normals().astype(np.float32)
        self.base = surface.colours.astype(np.float32)
        corners = surface.triangles
        # what a corner lacks of a normal is zero: a triangle without any is flat
        self._curved = np.abs(surface.smooth).sum(axis=1)[corners].sum(axis=1) > 0.0
        self._round = ~np.isnan(surface.round_centre[:, 0])
        # Barycentric weights are affine in the point: one gradient per corner of each triangle, taken from the next corner.
        a, b, c = (surface.points[corners[:, k]] for k in range(3))
        face = np.cross(b - a, c - a)
        square = np.maximum(_dot(face, face), 1e-300)[:, None]
        self._weights = [((gradient := np.cross(face, q - p) / square).astype(np.float32), _dot(gradient, p).astype(np.float32))
                         for p, q in ((b, c), (c, a), (a, b))]  # opposite each corner
        self._smooth = surface.smooth.astype(np.float32)

    def opaque(self, index: np.ndarray, world: np.ndarray, eye: np.ndarray, shadows: Shadows) -> np.ndarray:
        """Returns colours (n, 3) at the points `world` (n, 3) of the triangles `index`; `eye` are unit vectors towards the
        eye."""
        normal, facing = self._facing(index, world, eye)
        dark = shadows.on(world, normal)
        lambert = np.maximum(_dot(normal, LIGHT32), 0.0)
        base = np.take(self.base, index, axis=0)
        # what looks down has as much light from the ground as what looks up has from the sky
        base *= ((0.64 + 0.10 * np.abs(normal[:, 2]) + 0.28 * lambert + 0.06 * facing) * (1.0 - dark))[:, None]
        base += (0.20 * (_highlight(normal, eye) ** 16) ** 5 * (1.0 - 2.0 * dark) + 0.10 * _cube(1.0 - facing))[:, None]
        return base

    def clear(self, index: np.ndarray, world: np.ndarray, eye: np.ndarray, shadows: Shadows,
              opacity: float) -> tuple[np.ndarray, np.ndarray]:
        """Returns for points of glass the share of the light from behind that comes through (n, 3), and the light that they
        add (n, 3). They add a mirror image of a bright sky over a dark ground, more of it at grazing angles. They also add
        some light of their own."""
        normal, facing = self._facing(index, world, eye)
        dark = shadows.on(world, normal)
        tint = np.take(self.base, index, axis=0)
        share = np.where(np.take(self._surface.edge, index), np.float32(EDGE_OPACITY), np.float32(opacity))[:, None]
        mirror = (0.04 + 0.60 * _cube(1.0 - facing))[:, None]
        up = 2.0 * facing * normal[:, 2] - eye[:, 2]
        lambert = np.maximum(_dot(normal, LIGHT32), 0.0) * (1.0 - dark)
        sky = (0.55 + 0.50 * np.minimum(np.maximum(0.5 + up, 0.0), 1.0))[:, None]
        own = mirror * sky + 0.30 * share * (0.60 + 0.55 * lambert)[:, None] * tint
        own += (0.35 * _cube(_highlight(normal, eye)) ** 8 * (1.0 - 2.0 * dark))[:, None]
        return (1.0 - mirror) * (1.0 - 0.30 * share) * (1.0 - share * (1.0 - tint)), own

    def _facing(self, index: np.ndarray, world: np.ndarray, eye: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns unit normals that look to the eye, and their cosines with the direction to it."""
        normal = np.take(self.normals, index, axis=0)
        self._round_normals(index, world, normal)
        self._bent_normals(index, world, normal)
        facing = _dot(normal, eye)
        normal *= np.where(facing < 0.0, np.float32(-1.0), np.float32(1.0))[:, None]
        return normal, np.minimum(np.abs(facing), 1.0)

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
        corners, smooth = self._surface.triangles, self._smooth
        sum_ = np.zeros((len(at), 3), np.float32)
        for k, (gradient, offset) in enumerate(self._weights):
            weight = _dot(np.take(gradient, triangle, axis=0), point)
            weight -= np.take(offset, triangle)
            np.minimum(np.maximum(weight, 0.0, out=weight), 1.0, out=weight)
            sum_ += weight[:, None] * np.take(smooth, np.take(corners[:, k], triangle), axis=0)
        length = np.sqrt(_dot(sum_, sum_))
        seen = length > 1e-6
        normal[at[seen]] = sum_[seen] / length[seen, None]


def _highlight(normal: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """Returns the cosine between normals and the middle of light and eye."""
    half = eye + LIGHT32
    return np.maximum(_dot(normal, half) / np.sqrt(_dot(half, half)), 0.0)


def _cube(values: np.ndarray) -> np.ndarray:
    """Third power; numpy's own is some thirty times as slow."""
    return values * values * values


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of rows (n, 3), or of rows and one vector (3,): (n,). Three times as fast as a sum over the short axis, and the same for
    any number of rows, which a product by a library of linear algebra is not."""
    return np.einsum("ij,ij->i" if b.ndim == 2 else "ij,j->i", a, b)


def draw_scene(scene: Scene, camera: Camera, width: int, height: int, line_px: int = 2) -> np.ndarray:
    """The picture, (height, width, 3) colours 0..1. Glass lets a part of what is behind it through.

    Pixels are shaded in bands that stay in the processor's cache. Arrays of a whole picture come fresh from the system each
    time, and making their pages took as long as the shading.
    """
    picture = background(width, height)
    solid, glass = (rasterise(pixels, near, _seen(surface, pixels), width, height) for surface in (scene.solid, scene.glass)
                    for pixels, near in (camera.project(surface.points),))
    painter = _Painter(scene, camera, width)
    rows = max(2, BAND // width // 2 * 2)
    for begin in range(0, len(picture), rows * width):
        band = slice(begin, begin + rows * width)
        index, depth = solid[0][band], solid[1][band]
        painter.solid(picture[band], begin, index, depth)
        painter.glass(picture[band], begin, glass[0][band], glass[1][band], depth)
    front = np.maximum(solid[1], glass[1], out=glass[1])
    _draw_lines(picture, scene.outlines, camera, front, width, height, line_px, 0.60)
    _draw_lines(picture, scene.cracks, camera, front, width, height, line_px, 0.80, scene.thickness_m)
    return np.clip(picture, 0.0, 1.0, out=picture).reshape(height, width, 3)


def _seen(surface: Surface, pixels: np.ndarray) -> np.ndarray:
    """Returns the triangles; of those that turn their back to the eye and are closed, nothing but a point."""
    if not surface.closed.any():
        return surface.triangles
    at = np.flatnonzero(surface.closed)
    a, b, c = (pixels[surface.triangles[at, k]] for k in range(3))
    with np.errstate(invalid="ignore"):
        back = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) > (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])  # rows go down
    triangles = surface.triangles.copy()
    triangles[at[back]] = 0
    return triangles


def as_bytes(picture: np.ndarray) -> np.ndarray:
    """Colours 0..1 (height, width, 3) as bytes, row by row for the sake of the cache."""
    out = np.empty(picture.shape, np.uint8)
    for row, colours in enumerate(picture):
        out[row] = colours * 255.0 + 0.5
    return out


NOTHING, PIECE, FLOOR, GROUND = 0, 1, 2, 3  # what a pixel shows


class _Painter:
    """Paints bands of a picture: whole rows, the first pixel of which has the number `begin`.

    A picture is drawn larger than it is shown, and averaged. So two by two pixels that show one smooth surface are shaded
    as one, in their middle.
    """

    def __init__(self, scene: Scene, camera: Camera, width: int) -> None:
        self._scene, self._camera, self._width = scene, camera, width
        self._solid, self._glass = _Shader(scene.solid), _Shader(scene.glass)
        self._shadows = Shadows(scene)
        self._kind = np.where(scene.solid.is_floor, FLOOR, PIECE).astype(np.int8)  # per triangle

    def solid(self, picture: np.ndarray, begin: int, index: np.ndarray, depth: np.ndarray) -> None:
        """Paints what is opaque: triangles `index` (-1: none) of nearness `depth`, which becomes that of the ground too."""
        kind = np.where(index < 0, NOTHING, np.take(self._kind, index)) if len(self._kind) else np.zeros(len(index), np.int8)
        ground = self._scene.ground
        if ground is not None:
            near = ground.nearness(self._camera, begin // self._width, len(index) // self._width, self._width)
            shown = near > depth
            kind[shown], depth[shown] = GROUND, near[shown]
        smooth = self._smooth(kind, depth, index, self._solid.normals)
        for one in (PIECE, FLOOR, GROUND):
            shown = kind == one
            if not shown.any():
                continue
            at, blocks = self._chosen(shown, smooth)
            world = self._world(at, blocks, begin, depth)
            if one == PIECE:
                colours = self._solid.opaque(index[at], world, self._camera.towards_eye(world), self._shadows)
            elif one == FLOOR:
                dark = self._shadows.below(world)
                line = lines(world, self._pixel_m(world), GRID_M)
                colours = np.take(self._solid.base, index[at], axis=0)
                colours = colours * ((1.0 - 0.09 * line) * (1.0 - dark))[:, None]
            else:
                assert ground is not None
                dark = self._shadows.below(world)
                colours = ground.colours(world, self._pixel_m(world), picture[at], dark)
            for pixel, part in self._spread(at, blocks):
                picture[pixel] = colours[part]

    def glass(self, picture: np.ndarray, begin: int, index: np.ndarray, depth: np.ndarray, behind: np.ndarray) -> None:
        """Paints glass over what is behind it, at nearness `behind`."""
        shown = depth > behind
        if not shown.any():
            return
        at, blocks = self._chosen(shown, self._smooth(shown, depth, index, self._glass.normals))
        world = self._world(at, blocks, begin, depth)
        eye = self._camera.towards_eye(world)
        if self._scene.clear:
            through, own = self._glass.clear(index[at], world, eye, self._shadows, self._scene.glass_opacity)
        else:
            own = self._glass.opaque(index[at], world, eye, self._shadows)
            slant = 1.0 - np.abs(_dot(np.take(self._glass.normals, index[at], axis=0), eye))
            opacity = (self._scene.glass_opacity + 0.25 * slant * slant)[:, None]
            through, own = 1.0 - opacity, opacity * own
        for pixel, part in self._spread(at, blocks):
            picture[pixel] = picture[pixel] * through[part] + own[part]

    def _world(self, at: np.ndarray, blocks: int, begin: int, depth: np.ndarray) -> np.ndarray:
        """Returns places of pixels, in single precision: twice as fast, and a picture has no more."""
        row, column = np.divmod(at + begin, self._width)
        pixels = np.stack([column, row], axis=1).astype(np.float32)
        pixels[:blocks] += 1.0
        pixels[blocks:] += 0.5
        return self._camera.unproject(pixels, np.take(depth, at).astype(np.float32))

    def _pixel_m(self, world: np.ndarray) -> np.ndarray:
        """Returns the size of a pixel [m] at points."""
        if not self._camera.perspective:
            return np.full(len(world), 1.0 / self._camera.scale.min(), world.dtype)
        away = world - self._camera.eye.astype(world.dtype)
        return np.sqrt(_dot(away, away)) / float(self._camera.scale.min())

    def _smooth(self, kind: np.ndarray, depth: np.ndarray, index: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Tests two by two pixels for showing one smooth surface: (rows / 2, width / 2); none where sizes are odd."""
        rows = len(kind) // self._width
        if rows % 2 or self._width % 2:
            return np.zeros((0, 0), bool)

        def of(values: np.ndarray) -> list[np.ndarray]:
            whole = values.reshape(rows, self._width)
            return [whole[::2, ::2], whole[::2, 1::2], whole[1::2, ::2], whole[1::2, 1::2]]

        kinds, nears, which = of(kind), of(depth), of(index)
        same = (kinds[0] == kinds[1]) & (kinds[0] == kinds[2]) & (kinds[0] == kinds[3])
        with np.errstate(invalid="ignore"):  # where nothing is shown
            most = (STEEPEST / self._camera.scale.min()) * (nears[0] if self._camera.perspective else 1.0)
            same &= (np.abs(nears[0] - nears[3]) <= most) & (np.abs(nears[1] - nears[2]) <= most)
        edge = np.flatnonzero((same & ((which[0] != which[3]) | (which[1] != which[2]))).ravel())
        if len(edge):
            one, two, three, four = (np.take(normals, w.ravel()[edge], axis=0) for w in which)
            bent = (np.abs(_dot(one, four)) < FLAT) | (np.abs(_dot(two, three)) < FLAT)
            same.ravel()[edge[bent]] = False
        return same

    def _chosen(self, shown: np.ndarray, smooth: np.ndarray) -> tuple[np.ndarray, int]:
        """Returns the pixels to shade of those that are `shown`, and how many of them, the first ones, are of blocks."""
        if not smooth.size:
            return np.flatnonzero(shown), 0
        whole = shown.reshape(-1, self._width)
        row, column = np.divmod(np.flatnonzero((smooth & whole[::2, ::2]).ravel()), self._width // 2)
        single, rough = whole.copy(), ~smooth
        for i in (0, 1):
            for j in (0, 1):
                single[i::2, j::2] &= rough
        return np.concatenate([2 * row * self._width + 2 * column, np.flatnonzero(single.ravel())]), len(row)

    def _spread(self, at: np.ndarray, blocks: int) -> Iterator[tuple[np.ndarray, slice]]:
        """Yields pixels, and the part of what was shaded that is theirs."""
        yield at, slice(None)
        for step in (1, self._width, self._width + 1):
            yield at[:blocks] + step, slice(blocks)


def _draw_lines(picture: np.ndarray, segments: np.ndarray, camera: Camera, front: np.ndarray, width: int,
                height: int, thick: int, strength: float, reach_m: float = 0.0) -> None:
    """Blends ink over the pixels where a line is not hidden (by more than a bias that spares its own faces). It is seen through
    `reach_m` of what is in front of it."""
    if len(segments) == 0:
        return
    start, near_start = camera.project(segments[:, 0])
    end, near_end = camera.project(segments[:, 1])
    where, near = line_pixels(start, end, near_start, near_end, width, height, thick)
    bias = near * (0.004 + reach_m * near) if camera.perspective else 0.002 + reach_m
    seen = np.unique(where[near + bias >= front[where]])
    picture[seen] += strength * (INK - picture[seen])
