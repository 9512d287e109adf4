"""Dents that an impact leaves in a held shell: depth and volume."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.pictures.frames import SHELL
from sunder_tools.pictures.meshes import reference_points
from sunder_tools.words import did_you_mean

from .measures import Stated
from .scene import Results, Scene


@dataclass(frozen=True)
class Dent:
    """Dent of one shell, in the last frame of the shells: area at rest [m^2], largest displacement [m], time of that
    frame [s]. `pushed_in` and `pushed_out` are the volumes between rest and present shape, against its normal and along
    it [m^3]. All displacement counts, also elastic displacement and the motion of a loose part as a whole."""
    area: float
    pushed_in: float
    pushed_out: float
    deepest: float
    time: float


def dents(results: Results) -> dict[str, Dent]:
    """Returns the dents of all shells in the frame, by name. Volumes are those of the normal displacement over the
    shell at rest.

    Raises CommandError where no frame shows a shell.
    """
    frames = [frame for frame in results.frames if SHELL in frame.files]
    if not frames:
        raise CommandError(f"{results.folder}: no frame of the shell; keep='last' keeps what is needed")
    mesh = frames[-1].read(SHELL)
    assert mesh is not None
    at_rest = reference_points(mesh)
    moved = (mesh.points - at_rest)[mesh.triangles]
    corner = at_rest[mesh.triangles]
    normal = 0.5 * np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])  # times the area
    along = (moved.mean(axis=1) * normal).sum(axis=1)
    area, farthest = np.linalg.norm(normal, axis=1), np.linalg.norm(moved, axis=2).max(axis=1)
    part = mesh.of_triangles("shell", 0).astype(int)
    found = {}
    for number, shell in enumerate(results.scene.message.shells):
        own = part == number
        if not own.any():
            continue  # the whole shell has left
        found[shell.name] = Dent(float(area[own].sum()), float(-along[own].clip(max=0.0).sum()),
                                 float(along[own].clip(min=0.0).sum()), float(farthest[own].max(initial=0.0)),
                                 frames[-1].time_s)
    return found


def dent(shell: str) -> Any:
    """Measures, for experiments, volumes that a shell is pushed in and out by, and its largest displacement:
    columns `dent_in_m3`, `dent_out_m3` and `deepest_m`."""
    def refuse(scene: Scene) -> None:
        names = [one.name for one in scene.message.shells]
        if shell not in names:
            raise CommandError(f"no shell '{shell}'; {did_you_mean(shell, names)}")

    def measure(results: Results) -> dict[str, float]:
        all_of_them = dents(results)
        if shell not in all_of_them:
            raise CommandError(f"no shell '{shell}' in the last frame; there are: {', '.join(all_of_them)}")
        one = all_of_them[shell]
        return {"dent_in_m3": one.pushed_in, "dent_out_m3": one.pushed_out, "deepest_m": one.deepest}
    return Stated(("dent_in_m3", "dent_out_m3", "deepest_m"), measure, refuse)
