"""The quantity that colours triangles in a picture, and the knowledge about them outside of the frame."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..report.columns import read_columns
from ..report.scene_text import Words, scene_words
from .materials import material_of_body, material_of_shell

Colour = tuple[float, ...]  # red, green, blue
COLOURS = ("part", "damage", "fragment", "speed")
SAME_THICKNESS = 0.02  # relative
SAME_DENSITY = 1e-6  # relative; mass and area of a shard are written with nine digits


@dataclass(frozen=True)
class Look:
    """Colouring of a picture. `part_of` is the shell that each shard came from, by its body's number."""
    by: str = "part"
    glass: tuple[bool, ...] = ()   # of each shell: it is seen through
    colours: tuple[Colour, ...] = ()  # of each shell, that of its material
    bodies: tuple[Colour, ...] = ()   # of each body of the scene; empty where it names no material
    part_of: dict[int, int] = field(default_factory=dict)
    fastest: float = 1.0  # [m/s], end of the colour scale of speed
    thickness: tuple[float, ...] = ()  # [m] of each shell
    endless: bool = False              # the floor is a half space, of which frames have a part

    @staticmethod
    def of(folder: Path, by: str = "part", fastest: float = 1.0) -> "Look":
        """Makes the colouring for the run in `folder`; with less knowledge where its scene is not found."""
        words = scene_words(folder)
        return Look.of_words(words, by, origins(folder, words), fastest)

    @staticmethod
    def of_words(words: Words, by: str = "part", part_of: dict[int, int] | None = None, fastest: float = 1.0) -> "Look":
        """Makes the colouring from what is known of the scene."""
        return Look(by, words.glass, tuple(material_of_shell(k, words)[1][:3] for k in range(len(words.shells))),
                    tuple(material_of_body(k + 1, words)[1] if name else () for k, name in enumerate(words.body_materials)), part_of or {}, fastest,
                    words.thickness, words.endless)

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
