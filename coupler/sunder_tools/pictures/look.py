"""The quantity that colours triangles in a picture, and the knowledge about them outside of the frame."""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..report.columns import read_columns
from ..report.scene_text import Words, scene_words
from .frames import SHELL, list_frames
from .materials import colour_of, material_of_body, material_of_shell
from .vtp import VtpError

Colour = tuple[float, ...]  # red, green, blue
COLOURS = ("part", "damage", "fragment", "speed")
MOST, CHUNK = 6000, 512  # triangles of shells that are kept; places that are compared with them at once
SAME_THICKNESS = 0.02  # relative
SAME_DENSITY = 1e-6  # relative; mass and area of a shard are written with nine digits


@dataclass(frozen=True)
class Look:
    """Colouring of a picture. `part_of` is the shell that each shard came from, by its body's number."""
    by: str = "part"
    glass: tuple[bool, ...] = ()   # of each shell: it is seen through
    colours: tuple[Colour, ...] = ()  # of each shell, that of its material
    bodies: tuple[Colour, ...] = ()   # of each body of the scene; empty where it names no material; the fourth: seen through
    part_of: dict[int, int] = field(default_factory=dict)
    fastest: float = 1.0  # [m/s], end of the colour scale of speed
    thickness: tuple[float, ...] = ()  # [m] of each shell
    last: tuple[np.ndarray, np.ndarray] | None = None  # points [m] of the last frame of shells, and their shells
    endless: bool = False              # the floor is a half space, of which frames have a part

    @staticmethod
    def of(folder: Path, by: str = "part", fastest: float = 1.0) -> "Look":
        """Makes the colouring for the run in `folder`; with less knowledge where its scene is not found."""
        words = scene_words(folder)
        look = Look.of_words(words, by, origins(folder, words), fastest)
        return replace(look, last=_last_shells(folder)) if len(set(look.colours)) > 1 else look

    @staticmethod
    def of_words(words: Words, by: str = "part", part_of: dict[int, int] | None = None, fastest: float = 1.0) -> "Look":
        """Makes the colouring from what is known of the scene."""
        return Look(by, words.glass, tuple(material_of_shell(k, words)[1].colour for k in range(len(words.shells))),
                    tuple(colour_of(material_of_body(k + 1, words)[1]) if name else () for k, name in enumerate(words.body_materials)),
                    part_of or {}, fastest, words.thickness, endless=words.endless)

    def parts_by_thickness(self, points: np.ndarray, triangles: np.ndarray, part: np.ndarray) -> np.ndarray:
        """Returns the shells (m,) of triangles of broken pieces, `part` (m,) where that is known. A piece may be of several
        shells, as what is frozen is. Its points come in pairs, inside and outside, so it has the thickness of its shell. -1 where
        shells of this thickness have different colours; where all shells have one colour, it is the first."""
        if len(self.colours) == 0 or (part >= 0).all():
            return part
        found = np.where(part >= 0, part, 0 if len(set(self.colours)) == 1 else -1)
        at = np.flatnonzero(found < 0)
        pair = triangles[at, 0] // 2 * 2
        inside = pair + 1 < len(points)
        thick = np.where(inside, np.linalg.norm(points[np.where(inside, pair + 1, 0)] - points[pair], axis=1), np.nan)
        for one in dict.fromkeys(self.thickness):
            fits = [k for k, t in enumerate(self.thickness) if abs(t - one) <= SAME_THICKNESS * one]
            if fits and len({self.colours[k] for k in fits}) == 1:
                found[at[np.abs(thick - one) <= SAME_THICKNESS * one]] = fits[0]
        return found

    def parts_of_frozen(self, points: np.ndarray, triangles: np.ndarray, part: np.ndarray, frozen: np.ndarray) -> np.ndarray:
        """Returns the shells (m,) of triangles, for those that are `frozen` (m,) and not yet known that of the nearest point of the
        shells when they were last seen: what is frozen stays there."""
        at = np.flatnonzero((part < 0) & frozen)
        if self.last is None or not len(at):
            return part
        used, inverse = np.unique(triangles[at, 0] // 2 * 2, return_inverse=True)
        places, shells = self.last
        square, nearest = (places * places).sum(axis=1), np.zeros(len(used), np.int64)
        for begin in range(0, len(used), CHUNK):
            mine = points[used[begin:begin + CHUNK]]
            nearest[begin:begin + CHUNK] = np.argmin(square - 2.0 * mine @ places.T, axis=1)
        found = part.copy()
        found[at] = shells[nearest][inverse]
        return found


def _last_shells(folder: Path) -> tuple[np.ndarray, np.ndarray] | None:
    """Points of the last frame of shells, MOST at most, and the shell of each; None where a run has none or does not freeze."""
    try:
        frames = list_frames(folder)
        kept = [frame for frame in frames if SHELL in frame.files]
        shell = kept[-1].read(SHELL) if kept and kept[-1] is not frames[-1] else None
    except (VtpError, OSError):
        return None  # what draws the frames says so
    if shell is None or not len(shell.triangles):
        return None
    corner = shell.triangles[::1 + len(shell.triangles) // MOST].astype(np.int64)
    part = shell.of_triangles("shell", 0).astype(np.int64)[::1 + len(shell.triangles) // MOST]
    return shell.points[corner].mean(axis=1), part


def origins(folder: Path, words: Words) -> dict[int, int]:
    """Finds the shell of each shard in shards.csv, by its mass per area.

    Frames do not say. Of several shells with this mass per area that can break the first is named: it has their colour
    only where they are of one material, else the shard is left out.
    """
    table = read_columns(folder / "shards.csv")
    if not {"id", "area [m^2]", "mass [kg]"} <= set(table):
        return {}
    found: dict[int, int] = {}
    for body, area, mass in zip(table["id"], table["area [m^2]"], table["mass [kg]"]):
        fits = [k for k, density in enumerate(words.surface_density)
                if words.breaks[k] and abs(mass - density * area) < SAME_DENSITY * mass]
        if len({words.materials[k] for k in fits}) == 1:
            found[int(body)] = fits[0]
    return found


def parts_of_bodies(body: np.ndarray, part_of: dict[int, int]) -> np.ndarray:
    """Returns the shell (n,) of each of the bodies (n,), -1 where it is unknown."""
    ids, inverse = np.unique(body.astype(np.int64), return_inverse=True)
    return np.array([part_of.get(int(i), -1) for i in ids], np.int64)[inverse].reshape(body.shape)
