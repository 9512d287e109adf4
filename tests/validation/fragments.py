"""Strips that are stretched at an even rate until they break: size of the fragments over the rate.

Zhou, Molinari and Ramesh (Int. J. Fracture 139, 169, 2006; Applied Physics Letters 88, 261918, 2006) solve a thin ring
that expands, with cohesive cracks that soften in a straight line. With s0 = E G_f / strength^2 and the rate
r0 = c strength^3 / (E^2 G_f), the mean size is s0 4.5 / (1 + 4.5 (rate / r0)^(2/3)), and sizes have Rayleigh's
distribution. A strip whose every point moves away from the middle in proportion to its distance is such a ring, cut open.
`solved` is the same problem with the same flaws in one dimension, without anything of the solver.
"""
from __future__ import annotations

import csv
import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sunder_tools.launch.build import Executables
from sunder_tools.pictures.frames import SHELL, list_frames
from sunder_tools.pictures.meshes import reference_points
from sunder_tools.report.run_json import read_run

from .patterns import distance
from .trials import MOST_MISSING, Table, kept_run

YOUNG, DENSITY, STRENGTH, FRACTURE_ENERGY = 1e9, 1e3, 1e6, 10.0  # strains stay at a thousandth: nothing but cracks is nonlinear
SPEED = math.sqrt(YOUNG / DENSITY)                               # [m/s] of waves along the strip
SIZE = YOUNG * FRACTURE_ENERGY / STRENGTH ** 2                   # [m], s0
RATE = SPEED * STRENGTH ** 3 / (YOUNG ** 2 * FRACTURE_ENERGY)    # [1/s], r0
RATES = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)                         # of r0
MODES = ("damage", "tips")
GRIDS = (10, 15)  # elements along a fragment of the published size
EXPECTED = 60     # fragments
ACROSS = 4        # elements; a crack needs a line that is longer than a few Gauss points
MODULUS = 50.0    # of Weibull's scatter from place to place along the strip; a strip without any fails everywhere at once
BAND = 1.43       # [spacings]: width over which damage takes G_f (case `bar`)
RELEASED = 0.9    # share of the time until the strength is reached, from which on all but the ends moves by itself
WITHIN = 0.2
# Chosen. Means of EXPECTED sizes of Rayleigh's distribution scatter by 0.523 / sqrt(EXPECTED) = 0.07 of themselves, and the
# ratio of two such means of other flaws by 0.10. All grids and `solved` have the same flaws, so theirs scatters by less.
BETWEEN_GRIDS = 0.15
FROM_SOLVED = 0.15      # in mode DAMAGE, whose law is that of `solved`
FROM_RAYLEIGH = 0.1     # chosen
APART = 0.1             # chosen; between the sizes of mode DAMAGE and those that are solved
FINER = 40              # elements along a fragment in `solved`
STEP = 0.1              # [of the passage of a wave over an element] in `solved`
SECTORS = 3             # of a ring
PUSH = 0.2              # [of the time until the strength is reached]
STIFF = 1e-3            # [of the opening at which nothing is borne]: unloading in `solved` is no stiffer than from there
OFF = 0.01  # [of the strip's section]: smaller pieces are chips of the border


def published_size(rate: float) -> float:
    """Returns the mean size over s0 at a rate over r0."""
    return 4.5 / (1.0 + 4.5 * rate ** (2.0 / 3.0))


def from_rayleigh(sizes: np.ndarray) -> float:
    """Returns the largest difference between the cumulative distribution of sizes (n,), over their mean, and Rayleigh's
    with a mean of 1."""
    x = np.sort(np.asarray(sizes, float))
    x = x / x.mean()
    model = 1.0 - np.exp(-0.25 * math.pi * x * x)
    count = len(x)
    return float(np.maximum(model - np.arange(count) / count, np.arange(1, count + 1) / count - model).max())


@dataclass(frozen=True)
class Strip:
    """A strip and its loading."""
    mode: str
    rate: float  # of r0
    grid: int    # elements along a fragment of the published size
    seed: int = 1

    @property
    def spacing(self) -> float:
        """Returns the side of an element [m]."""
        return published_size(self.rate) * SIZE / self.grid

    @property
    def elements(self) -> int:
        return EXPECTED * self.grid

    @property
    def length(self) -> float:
        return self.elements * self.spacing

    @property
    def width(self) -> float:
        return ACROSS * self.spacing


def flaws(strip: Strip, places: np.ndarray) -> np.ndarray:
    """Returns factors of the strength at places (n,) along a strip [of the published size], the same on all grids."""
    first = np.random.default_rng(strip.seed).weibull(MODULUS, EXPECTED * GRIDS[0])
    return np.interp(places * GRIDS[0], np.arange(len(first)) + 0.5, first / first.mean())


def solved(strip: Strip) -> np.ndarray:
    """Returns sizes (n,) over s0 of the fragments of a bar of two-node elements. Any node opens at its strength, then bears
    less in a straight line down to nothing, unloads towards zero, and is stiff where it closes. Lengths are in s0, times in
    s0 / c, stresses in the strength."""
    h = published_size(strip.rate) / FINER
    count = EXPECTED * FINER
    x = h * np.arange(count + 1)
    strength = flaws(strip, x / (h * FINER))
    gone = 2.0 * strength  # opening at which nothing is borne, over strength s0 / E: G_f goes with the square of the strength
    strength[[0, -1]] = math.inf
    pull = strip.rate * (x - 0.5 * x[-1])
    held = RELEASED * float(strength.min()) / strip.rate
    left, right, slow, fast = held * pull, held * pull, pull.copy(), pull.copy()  # displacements and velocities of both sides
    open_ = np.zeros(count + 1, bool)
    most: np.ndarray = np.zeros(count + 1)
    step = STEP * h
    for _ in range(int((0.3 / strip.rate + 12.0 / (strip.rate * published_size(strip.rate)) + 3.0) / step)):
        stress = (left[1:] - right[:-1]) / h
        before, after = np.append(0.0, stress), np.append(stress, 0.0)
        open_ |= 0.5 * (before + after) >= strength
        gap = right - left
        first = open_ & (np.maximum(most, gap) <= STIFF * gone) & (gap >= 0.0)
        most = np.where(open_, np.maximum(np.maximum(most, gap), STIFF * gone), 0.0)
        bears = np.where(open_, strength, 0.0) * np.maximum(0.0, 1.0 - most / gone)
        bears = np.where(gap > 0.0, bears * np.minimum(1.0, gap / np.where(open_, most, 1.0)), gap / h)
        bears = np.where(first, np.where(open_, strength, 0.0), bears)
        whole = (after - before) / h
        push, draw = np.where(open_, 2.0 * (bears - before) / h, whole), np.where(open_, 2.0 * (after - bears) / h, whole)
        push[[0, -1]] = draw[[0, -1]] = 0.0
        slow, fast = slow + step * push, fast + step * draw
        left, right = left + step * slow, right + step * fast
    return np.diff(np.concatenate([[0.0], x[open_ & (most >= gone)], [x[-1]]]))


def _write_flaws(folder: Path, strip: Strip, parts: int = 1) -> tuple[float, float]:
    """Writes grey images flaws_0.pgm and so on of the factors, one for each part; returns those of black and white."""
    factors = flaws(strip, (np.arange(strip.elements) + 0.5) / strip.grid)
    low, high = float(factors.min()), float(factors.max())
    for k, part in enumerate(np.split(np.round((factors - low) / (high - low) * 65535.0).astype(">u2"), parts)):
        (folder / f"flaws_{k}.pgm").write_bytes(f"P5 {len(part)} {ACROSS} 65535\n".encode() + np.tile(part, (ACROSS, 1)).tobytes())
    return low, high


def _times(strip: Strip, shortest: float = 0.45) -> tuple[float, float, float]:
    """Returns the time at which the strength is reached, the window, and the end, by which the last cracks are open [s].
    `shortest` is that of windows, in passages of a wave over an element."""
    rate = strip.rate * RATE
    broken = STRENGTH / (YOUNG * rate)
    opening = 2.0 * FRACTURE_ENERGY / STRENGTH / (rate * published_size(strip.rate) * SIZE)  # until a crack is open
    window = max(0.01 * broken, shortest * strip.spacing / SPEED)
    return broken, window, window * math.ceil((1.05 * broken + 2.0 * opening + 2.0 * SIZE / SPEED) / window)


def _head(name: str, strip: Strip, shortest: float = 0.45) -> list[str]:
    _, window, end = _times(strip, shortest)
    damage = f"mode: DAMAGE damage_width_m: {BAND * strip.spacing:.12g} healing: false" if strip.mode == "damage" else "mode: TIPS"
    return [f'name: "{name}"', f"end_time_s: {end:.12g}", f"window_s: {window:.12g}", "gravity {}",
            f'materials {{ name: "brittle" density: {DENSITY} youngs_modulus: {YOUNG} poisson_ratio: 0 strength: {STRENGTH} '
            f"fracture_energy: {FRACTURE_ENERGY} }}", f"fracture {{ {damage} quiet_time_s: {end:.12g} }}",
            f"output {{ frame_interval_s: {0.5 * end:.12g} }}"]


def scene_of(strip: Strip, low: float, high: float) -> str:
    """Returns the text of the scene. Each column of control points is driven at its own speed until just before the
    strength is reached, then only both ends are."""
    h, length, rate = strip.spacing, strip.length, strip.rate * RATE
    broken, window, end = _times(strip)
    released = window * max(1, math.floor(RELEASED * broken / window))
    places = [0.0, *((k + 0.5) * h for k in range(strip.elements)), length]  # Greville points of degree 2
    supports = []
    for k, u in enumerate(places):
        until = f"until_s: {released:.12g} " if 0 < k < len(places) - 1 else ""
        supports.append(
            f"  supports {{ kind: SIMPLY_SUPPORTED axes: X {until}"
            f"regions {{ low {{ u: {max(0.0, u - 0.1 * h):.12g} v: 0 }} high {{ u: {min(length, u + 0.1 * h):.12g} v: {strip.width:.12g} }} }} "
            f"motion {{ time_s: 0 }} motion {{ time_s: {end:.12g} displacement {{ x: {rate * (u - 0.5 * length) * end:.12g} }} }} }}")
    return "\n".join([
        *_head("strip", strip), "shells {", f'  name: "strip" material: "brittle" thickness_m: {strip.width:.12g}',
        f"  plate {{ size_x_m: {length:.12g} size_y_m: {strip.width:.12g} elements_x: {strip.elements} elements_y: {ACROSS} }}",
        f'  strength_map {{ path: "flaws_0.pgm" low_factor: {low:.9g} high_factor: {high:.9g} }}', *supports, "}", ""])


def ring_of(strip: Strip, low: float, high: float) -> str:
    """Returns the text of a ring of joined sectors, as long as the strip. A short push from inside gives it the speed at
    which its circumference grows at the rate; forces along the ring then slow it down a little."""
    radius, thickness = strip.length / (2.0 * math.pi), 0.5 * strip.width
    push = PUSH * _times(strip)[0]
    pressure = 2.0 * DENSITY * thickness * strip.rate * RATE * radius / push  # it rises and falls evenly
    # a ring is thinner than a strip, and without damage its stable step is longer: a window is at least a step
    lines = [*_head("ring", strip, 0.45 if strip.mode == "damage" else 0.6), "seams {}"]
    for k in range(SECTORS):
        half = math.pi * k / SECTORS
        lines += [
            "shells {", f'  name: "ring_{k}" material: "brittle" thickness_m: {thickness:.12g}',
            f"  cylinder {{ radius_m: {radius:.12g} length_m: {strip.width:.12g} angle_deg: {360 // SECTORS} elements_u: "
            f"{strip.elements // SECTORS} elements_v: {ACROSS} pose {{ orientation {{ w: {math.cos(half):.15g} z: {math.sin(half):.15g} }} }} }}",
            f'  strength_map {{ path: "flaws_{k}.pgm" low_factor: {low:.9g} high_factor: {high:.9g} }}',
            f"  loads {{ pressure: {pressure:.12g} factor {{ time_s: 0 value: 0 }} factor {{ time_s: {0.5 * push:.12g} value: 1 }} "
            f"factor {{ time_s: {push:.12g} value: 0 }} }}", "}"]
    return "\n".join([*lines, ""])


def sizes_of(folder: Path, width: float) -> np.ndarray:
    """Returns lengths (n,) [m] of all pieces of a strip, those that have left and those that have not."""
    with (folder / "shards.csv").open(newline="") as file:
        areas = [float(row["area [m^2]"]) for row in csv.DictReader(file)]
    mesh = list_frames(folder)[-1].read(SHELL)
    if mesh is not None and len(mesh.triangles):
        corner = reference_points(mesh)[mesh.triangles]
        area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
        _, piece = np.unique(mesh.of_triangles("fragment", 0), return_inverse=True)
        areas += map(float, np.bincount(piece, area))
    lengths = np.array(areas) / width
    return lengths[lengths > OFF * width]


def _broken(executables: Executables, strip: Strip) -> tuple[np.ndarray, float, float]:
    """Returns sizes over s0, the missing share of the energy, and seconds."""
    with tempfile.TemporaryDirectory(prefix="validate-sunder-") as place:
        scene = Path(place) / "strip.textproto"
        scene.write_text(scene_of(strip, *_write_flaws(Path(place), strip)))
        with kept_run(executables, str(scene), []) as (folder, seconds):
            return sizes_of(folder, strip.width) / SIZE, read_run(folder)["energy"]["residual_relative"], seconds


def strip(table: Table, executables: Executables) -> None:
    """Runs strips at six rates, in both modes that start cracks, on two grids each."""
    axes = {"x_label": "rate over c strength^3 / (E^2 G_f)", "y_label": "mean size over E G_f / strength^2", "logarithmic": True}
    table.curves.append({"name": "Zhou, Molinari, Ramesh", "panel": "fragments of a strip", "x": list(RATES),
                         "y": [published_size(rate) for rate in RATES], **axes})
    alone = {rate: solved(Strip("damage", rate, FINER)) for rate in RATES}
    table.curves.append({"name": "solved in one dimension", "panel": "fragments of a strip", "x": list(RATES),
                         "y": [float(alone[rate].mean()) for rate in RATES], **axes})
    table.lines.append("strip, solved in one dimension: sizes over the published one " + ", ".join(
        f"{alone[rate].mean() / published_size(rate):.2f} at {rate:g}" for rate in RATES)
        + f"; they scatter by {np.concatenate([s / s.mean() for s in alone.values()]).std():.2f} of their mean")
    for mode in MODES:
        means, residuals = [], []
        every: list[np.ndarray] = []
        for rate in RATES:
            strips = [Strip(mode, rate, grid) for grid in GRIDS]
            found = [_broken(executables, one) for one in strips]
            mean = [one.length / SIZE / len(sizes) for one, (sizes, _, _) in zip(strips, found)]
            sizes = found[-1][0]
            means.append(mean[-1])
            every.append(sizes / sizes.mean())
            residuals += [residual for _, residual, _ in found]
            name = f"strip_{mode}_{rate:g}"
            table.add(f"{name}_size", mean[-1], published_size(rate), WITHIN, sum(seconds for _, _, seconds in found))
            table.add(f"{name}_grids", mean[-1] / mean[0], 1.0, BETWEEN_GRIDS, 0.0)
            if mode == "damage":
                table.add(f"{name}_solved", mean[-1], float(alone[rate].mean()), FROM_SOLVED, 0.0)
            table.lines.append(f"{name}: {' and '.join(str(len(sizes)) for sizes, _, _ in found)} fragments; scatter of the sizes "
                               f"{sizes.std() / sizes.mean():.2f} of their mean, {from_rayleigh(sizes):.2f} from Rayleigh's "
                               "distribution")
        table.add(f"strip_{mode}_rayleigh", from_rayleigh(np.concatenate(every)), 0.0, FROM_RAYLEIGH, 0.0)
        if mode == "damage":
            apart = distance(np.concatenate(every), np.concatenate([s / s.mean() for s in alone.values()]))
            table.add("strip_damage_distribution", apart, 0.0, APART, 0.0)
        table.add(f"strip_{mode}_energy", float(np.abs(residuals).max()), 0.0, MOST_MISSING, 0.0)
        table.curves.append({"name": mode, "panel": "fragments of a strip", "x": list(RATES), "y": means, **axes})
        table.lines.append(f"strip, mode {mode}: Rayleigh's sizes scatter by {math.sqrt(4.0 / math.pi - 1.0):.2f} of their mean, "
                           f"these by {np.concatenate(every).std():.2f}")


def expanding_ring(table: Table, executables: Executables) -> None:
    """Runs rings at six rates, in both modes, on the finer grid: number of the fragments."""
    for mode in MODES:
        residuals = []
        for rate in RATES:
            ring = Strip(mode, rate, GRIDS[-1])
            with tempfile.TemporaryDirectory(prefix="validate-sunder-") as place:
                scene = Path(place) / "ring.textproto"
                scene.write_text(ring_of(ring, *_write_flaws(Path(place), ring, SECTORS)))
                with kept_run(executables, str(scene), []) as (folder, seconds):
                    run = read_run(folder)
            residuals.append(run["energy"]["residual_relative"])
            table.add(f"ring_{mode}_{rate:g}_size", ring.length / SIZE / run["counts"]["fragments"], published_size(rate), WITHIN,
                      seconds)
        table.add(f"ring_{mode}_energy", float(np.abs(residuals).max()), 0.0, MOST_MISSING, 0.0)
