"""Shells from files of meshes whose answers are known: a sphere of quads only, and a tube of triangles.

Both files are written here and read as a user's are: area, mass and lowest frequencies against exact ones, and the order of
convergence of the frequencies over three spacings.
"""
from __future__ import annotations

import json
import math
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sunder_tools.errors import CommandError, how_it_ended
from sunder_tools.launch.build import Executables

from .trials import Table

YOUNG, POISSON, DENSITY = 2e11, 0.3, 7800.0  # [Pa], [-], [kg/m^3]
MODES = 4
RIGID = 6
EXACT = 0.02  # set beforehand: thin theory neglects stretch or bending, and chords are shorter than arcs
SPACING = 0.02  # [m]: the middle one of three, of the sphere
# Modes of bending are of the thickness: with 0.02 m the second is 2.5 % off. Of 60 faces around, elements of 0.01 m begin to
# follow each face, and the order is lost.
TUBE_SPACING = SPACING / math.sqrt(2.0)
LEAST_ORDER = 1.75  # 2 of bending, less 0.25, as for plates
# Share by which frequencies move at last, below which they have settled and have no order. Those of the sphere move by less
# from the coarsest spacing on, also where the file has three times as many faces along an edge.
SETTLED = 1e-4
SCENE = """name: "{name}" end_time_s: 1e-3 window_s: 1e-4 gravity {{}}
materials {{ name: "steel" density: {density} youngs_modulus: {young} poisson_ratio: {poisson} }}
shells {{ name: "part" material: "steel" thickness_m: {thickness!r} mesh {{ path: {path} element_m: {element!r} }} }}
seams {{}}
"""


@dataclass(frozen=True)
class Exact:
    """A surface as the text of a file, and what is known of it."""
    name: str
    file: str
    text: str
    thickness: float           # [m]
    area: float                # [m^2]
    frequencies: tuple[float, ...]  # [Hz], the lowest ones but for rigid motions
    spacing: float             # [m]: the middle one of three

    @property
    def spacings(self) -> tuple[float, ...]:
        """Each is finer than the one before by the root of two. Twice the coarsest would be too coarse for a sphere: short
        waves of a lumped mass are then as slow as long ones."""
        return tuple(self.spacing * 2.0 ** (0.5 - 0.5 * k) for k in range(3))


def quad_sphere(radius: float, parts: int) -> tuple[list[np.ndarray], list[list[int]]]:
    """The faces of a cube, `parts` squared quads each at equal angles, moved to a sphere: points and quads, seen
    counter-clockwise from outside."""
    points: list[np.ndarray] = []
    known: dict[tuple[int, ...], int] = {}
    quads: list[list[int]] = []

    def at(axis: int, side: int, i: int, j: int) -> int:
        place = [0, 0, 0]
        place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = side * parts, 2 * i - parts, 2 * j - parts
        if tuple(place) not in known:
            x = np.tan(0.25 * math.pi * np.array(place) / parts)
            known[tuple(place)] = len(points)
            points.append(radius * x / np.linalg.norm(x))
        return known[tuple(place)]

    for axis in range(3):
        for side in (-1, 1):
            for j in range(parts):
                for i in range(parts):
                    quad = [at(axis, side, i + a, j + b) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
                    quads.append(quad if side > 0 else quad[::-1])
    return points, quads


def obj_text(points: list[np.ndarray], faces: list[list[int]]) -> str:
    """An OBJ file; faces keep their corners."""
    rows = ["v {!r} {!r} {!r}".format(*map(float, p)) for p in points]
    return "\n".join(rows + ["f " + " ".join(str(k + 1) for k in face) for face in faces]) + "\n"


def tube_off(radius: float, length: float, around: int, along: int) -> str:
    """An OFF file of a tube of triangles with open ends."""
    points = [(radius * math.cos(2.0 * math.pi * i / around), radius * math.sin(2.0 * math.pi * i / around), length * j / along)
              for j in range(along + 1) for i in range(around)]
    faces = []
    for j in range(along):
        for i in range(around):
            a, b = j * around + i, j * around + (i + 1) % around
            c, d = b + around, a + around
            faces += [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
    rows = [f"OFF\n{len(points)} {len(faces)} 0", *("{!r} {!r} {!r}".format(*p) for p in points),
            *("3 {} {} {}".format(*f) for f in faces)]
    return "\n".join(rows) + "\n"


def sphere() -> Exact:
    """A sphere of quads: its lowest frequency has five equal modes, which stretch (Lamb 1882)."""
    radius, twice = 0.2, 6.0  # n (n + 1)
    b, c = twice + 1.0 + 3.0 * POISSON, (twice - 2.0) * (1.0 - POISSON ** 2)
    square = 0.5 * (b - math.sqrt(b * b - 4.0 * c))
    lamb = math.sqrt(square * YOUNG / (DENSITY * (1.0 - POISSON ** 2))) / (2.0 * math.pi * radius)
    return Exact("quads", "quads.obj", obj_text(*quad_sphere(radius, 16)), 0.004, 4.0 * math.pi * radius ** 2, (lamb,) * MODES,
                 SPACING)


def tube() -> Exact:
    """A tube with free ends: modes without stretch, the same all along or growing from the middle (Rayleigh; Love 1888)."""
    radius, length, thickness = 0.2, 0.5, 0.001
    bending = YOUNG * thickness ** 3 / (12.0 * (1.0 - POISSON ** 2))
    n, share = 2.0, (radius / length) ** 2
    ring = (math.sqrt(bending / (DENSITY * thickness)) / radius ** 2 * n * (n * n - 1.0) / math.sqrt(n * n + 1.0)
            / (2.0 * math.pi))
    twisted = ring * math.sqrt((1.0 + 24.0 * (1.0 - POISSON) * share / (n * n)) / (1.0 + 12.0 * share / (n * n * (n * n + 1.0))))
    return Exact("tube", "tube.off", tube_off(radius, length, 120, 48), thickness, 2.0 * math.pi * radius * length,
                 (ring, ring, twisted, twisted), TUBE_SPACING)


def mesh_files(table: Table, executables: Executables) -> None:
    """Adds the rows of both surfaces."""
    for exact in (sphere(), tube()):
        with tempfile.TemporaryDirectory(prefix="validate-sunder-") as folder:
            path = Path(folder) / exact.file
            path.write_text(exact.text)
            start = time.monotonic()
            told = inspected(executables, path, exact.spacing)
            name = f"mesh_file_{exact.name}"
            table.add(f"{name}_area", told["area_m2"], exact.area, EXACT, time.monotonic() - start,
                      note=f"{told['faces']} faces, {len(told['charts'])} charts")
            mass = sum(chart["area_of_shell_m2"] for chart in told["charts"])
            table.add(f"{name}_mass", mass, exact.area, EXACT, 0.0, note="of the shells, over density and thickness")
            start = time.monotonic()
            found = [frequencies(executables, exact, path, spacing) for spacing in exact.spacings]
            means = [float(np.mean(some)) for some in found]
            note = f"order {order_of(means):.2f}: means {means[0]:.6g}, {means[1]:.6g}, {means[2]:.6g} Hz"
            for k, (computed, reference) in enumerate(zip(found[1], exact.frequencies)):
                table.add(f"{name}_frequency_{k + 1}", computed, reference, EXACT, time.monotonic() - start if k == 0 else 0.0)
            table.add(f"{name}_order_below_{LEAST_ORDER}", below_order(means), 0.0, 0.0, 0.0, note=note)


def order_of(means: list[float]) -> float:
    """Order of convergence by three spacings, each finer by the root of two. No reference takes part: those of thin shells
    neglect more than the errors are. NaN where the finer two do not differ."""
    a, b = abs(means[0] - means[1]), abs(means[1] - means[2])
    return 2.0 * math.log2(a / b) if a > 0.0 and b > 0.0 else math.nan


def below_order(means: list[float]) -> float:
    """How far the order is below LEAST_ORDER; 0 where it is not, or where all three have settled. NaN where there is none."""
    if max(means) - min(means) <= SETTLED * max(means):
        return 0.0
    below = LEAST_ORDER - order_of(means)
    return 0.0 if below <= 0.0 else below


def inspected(executables: Executables, path: Path, spacing: float) -> dict[str, Any]:
    """What `sunder inspect` tells of a mesh. Raises CommandError where it is refused."""
    told = json.loads(_run([str(executables.shell), "inspect", str(path), "--element", repr(spacing)]))
    if told["refused"] is not None:
        raise CommandError(f"{path.name}: {told['refused']}")
    assert isinstance(told, dict)
    return told


def frequencies(executables: Executables, exact: Exact, path: Path, spacing: float) -> list[float]:
    """The lowest frequencies [Hz] but for rigid motions, by `sunder modes`. Raises CommandError."""
    scene, out = path.with_suffix(".textproto"), path.with_suffix(f".{spacing!r}")
    scene.write_text(SCENE.format(name=exact.name, density=DENSITY, young=YOUNG, poisson=POISSON, thickness=exact.thickness,
                                  path=json.dumps(path.name), element=spacing))
    out.mkdir()
    _run([str(executables.shell), "--scene", str(scene), "--modes", str(RIGID + MODES), "--out", str(out)])
    return elastic(json.loads((out / "modes.json").read_text())["modes"], exact.frequencies[0])


def elastic(modes: list[dict[str, Any]], lowest: float) -> list[float]:
    """The frequencies of modes that are no rigid motions, far below the `lowest` expected one. Raises CommandError where
    they are fewer than MODES."""
    found = sorted(mode["frequency_Hz"] for mode in modes if mode["frequency_Hz"] is not None and mode["frequency_Hz"] > 0.1 * lowest)
    if len(found) < MODES:
        raise CommandError(f"{len(found)} modes above a tenth of {lowest:.4g} Hz, {MODES} are needed")
    return found[:MODES]


def _run(command: list[str]) -> str:
    ended = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace", check=False)
    if ended.returncode != 0:
        raise CommandError(f"{Path(command[0]).name} {how_it_ended(ended.returncode)}: {ended.stderr.strip()[-300:]}")
    return ended.stdout
