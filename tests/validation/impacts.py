"""Impacts on a brittle plate: independence of the lattice, radial cracks against speed, and effects of refinement."""
from __future__ import annotations

import csv
import math
import os
import random
import shutil
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path

import numpy as np

from sunder_lab.crossings import radial_crossings
from sunder_tools.launch.build import Executables
from sunder_tools.pictures.contact_sheet import write_contact_sheet
from sunder_tools.pictures.crack_lines import Graph, grown, last_graph
from sunder_tools.pictures.frames import SHELL, list_frames
from sunder_tools.pictures.meshes import reference_points
from sunder_tools.report.run_json import read_run

from .crack_pictures import draw_cracks
from .patterns import (PowerLaw, anova, chance_of_distance, distance, harmonic, lengths, off_circle, power_law, quantile_bounds,
                       upper_bound)
from .trials import MOST_MISSING, Table, kept_run

SIDE = 0.06       # [m] of the plate of scenes/acrylic.textproto
ROUND = 0.03      # [m] of that of scenes/round_pane.textproto
ELEMENTS = 80
SEEDS = 16
TURNS = (0, 15, 30, 45)  # [degrees]
COUNTED_AT = 4e-3  # [m]: radial cracks are counted four thicknesses from the impact
LEAST_CHANCE = 0.01
FEWEST_RADIALS = 3.0  # mean in a round pane; of fewer, neither number nor directions mean much
MOST_STRIPS = 0.5  # pieces at the border, in a run
TAKEN = 0.1  # chosen: how far the energy that cracks take may be from G_f, on the mean over seeds
SPEEDS = (15, 22, 30, 40, 57, 80, 120)  # [m/s]
BETWEEN_PUBLISHED = math.log(8.0 / 4.0) / math.log(57.0 / 22.0)


BARS = "(± 2 standard errors)"


def _bar(values: list) -> float:
    """Returns half of the error bar of a mean over seeds."""
    return 2.0 * float(np.std(values, ddof=1)) / math.sqrt(len(values))


def _beside(seed: int) -> list[str]:
    """Shifts the pellet from the lattice's point of symmetry, by up to half an element; otherwise the symmetry would
    show."""
    chance = random.Random(seed)
    reach = 0.5 * SIDE / ELEMENTS
    return [f"bodies[pellet].pose.position.{axis}={chance.uniform(-reach, reach):.9g}" for axis in "xy"]


def _struck(executables: Executables, scene: str, seed: int,
            settings: list[str]) -> tuple[Graph | None, dict, float, float]:
    """Returns cracks, run.json, the pellet's final velocity [m/s] and seconds; None for cracks where there are none."""
    with kept_run(executables, scene, [f"fracture.seed={seed}", "end_time_s=1.2e-4", *_beside(seed), *settings]) as (
            folder, seconds):
        rows = list(csv.reader((folder / "probes.csv").open()))
        back = float(rows[-1][rows[0].index("pellet_vz [m/s]")])
        try:
            graph = grown(last_graph(folder))
        except ValueError:
            graph = None
        return (graph if graph is not None and len(graph) else None), read_run(folder), back, seconds


def _add_energy(table: Table, name: str, residuals: list[float]) -> None:
    """Adds row NAME_energy, as `add_books` does, for the worst of many runs."""
    table.add(f"{name}_energy", float(np.abs(residuals).max()), 0.0, MOST_MISSING, 0.0)


def _add_taken(table: Table, name: str, taken: list[float]) -> None:
    """Row NAME_taken_over_G_f: cracks take their fracture energy, on the mean over the seeds of the finest grid."""
    table.add(f"{name}_taken_over_G_f", float(np.mean(taken)), 1.0, TAKEN, 0.0)


def round_pane(table: Table, executables: Executables) -> None:
    """Runs scenes/round_pane.textproto with its lattice turned by 0, 15, 30 and 45 degrees, SEEDS seeds each."""
    centre, radius = np.array([0.5 * ROUND, 0.5 * ROUND]), 0.0135
    names = ("harmonic", "harmonic_in_the_room", "length", "radials")
    groups: dict[str, list[list[complex]]] = {name: [] for name in names}
    seconds, residuals = 0.0, []
    rows: list[list[Graph | None]] = []
    for degrees in TURNS:
        half = 0.5 * math.radians(degrees)
        found: dict[str, list[complex]] = {name: [] for name in groups}
        rows.append([])
        for seed in range(1, SEEDS + 1):
            graph, run, _, took = _struck(executables, "round_pane.textproto", seed + 100 * degrees, [
                f"shells[plate].plate.pose.orientation.w={math.cos(half):.15g}",
                f"shells[plate].plate.pose.orientation.z={math.sin(half):.15g}"])
            seconds += took
            residuals.append(run["energy"]["residual_relative"])
            rows[-1].append(graph)
            ends = np.zeros((0, 2, 2)) if graph is None else graph.ends
            ends = ends[off_circle(ends, centre, radius, 1e-3)]
            if len(ends) == 0:
                raise ValueError(f"round_pane: no crack at {degrees} degrees, seed {seed}")
            found["harmonic"].append(harmonic(ends))
            # a harmonic of the lattice would turn with it
            found["harmonic_in_the_room"].append(harmonic(ends, turn=2.0 * half))
            found["length"].append(float(lengths(ends).sum()))
            found["radials"].append(float(len(radial_crossings(ends, centre, COUNTED_AT))))
        for name, values in found.items():
            groups[name].append(values)
        length, radials = 1e3 * np.real(found["length"]), np.real(found["radials"])
        table.lines.append(f"round_pane at {degrees} degrees: harmonic {np.mean(found['harmonic']):.2f}, length "
                           f"{length.mean():.0f} +- {length.std(ddof=1):.0f} mm, radial cracks {radials.mean():.1f} +- "
                           f"{radials.std(ddof=1):.1f}")
    every = np.array(groups["harmonic"]).reshape(-1)
    table.add("round_pane_harmonic_bound", upper_bound(every), 0.0, 0.3, seconds)
    table.add("round_pane_radials_at_least", min(float(np.real(groups["radials"]).mean()), FEWEST_RADIALS), FEWEST_RADIALS,
              0.0, 0.0)
    _add_energy(table, "round_pane", residuals)
    for name, of_turns in groups.items():
        chance = anova([np.array(v) for v in of_turns])[1]
        table.add(f"round_pane_{name}_depends", float(chance < LEAST_CHANCE), 0.0, 0.0, 0.0)
        table.lines.append(f"round_pane: chance of so much difference between turns in {name} {chance:.2f}")
    table.lines.append(f"round_pane: mean harmonic of all {len(every)} runs {every.mean():.3f}; of one run some "
                       f"{np.abs(every).mean():.2f}, as few arms have")
    if table.pictures is not None:
        draw_cracks(table.pictures / "round_pane.png", rows, (ROUND, ROUND), names=[f"turned by {d}°" for d in TURNS])


@dataclass(frozen=True)
class Radials:
    """Radial cracks of a plate that a pellet hits: numbers, cracks and residuals at each speed."""
    counts: dict[int, list[int]]
    graphs: list[list[Graph | None]]
    residuals: list[float]
    seconds: float

    def mean(self, speed: int) -> float:
        return float(np.mean(self.counts[speed]))

    def crossed(self, speed: int) -> bool:
        """Whether most runs have a radial crack."""
        return 2 * sum(c > 0 for c in self.counts[speed]) >= len(self.counts[speed])

    def fit(self, most: float = math.inf) -> PowerLaw:
        """The power law of runs with radial cracks up to a speed [m/s], without speeds at which most runs have none."""
        pairs = [(float(speed), float(count)) for speed, counts in self.counts.items()
                 if speed <= most and self.crossed(speed) for count in counts if count > 0]
        return power_law(np.array([x for x, _ in pairs]), np.array([y for _, y in pairs]))

    def most_at(self) -> int:
        """The speed with most cracks: at higher ones rings cut a plug out before radial cracks run."""
        return max(self.counts, key=lambda speed: (self.mean(speed), speed))


def _radials(table: Table, executables: Executables, name: str, settings: list[str], speeds: tuple[int, ...], seeds: int,
             counted_at: float = COUNTED_AT) -> Radials:
    """Runs scenes/acrylic.textproto with these settings at each speed, so many seeds each."""
    centre = np.array([0.5 * SIDE, 0.5 * SIDE])
    counts: dict[int, list[int]] = {}
    graphs: list[list[Graph | None]] = []
    residuals: list[float] = []
    seconds = 0.0
    for speed in speeds:
        counts[speed], row = [], []
        for seed in range(1, seeds + 1):
            graph, run, _, took = _struck(executables, "acrylic.textproto", seed, [
                f"bodies[pellet].twist.linear.z=-{speed}", *settings]
                + [f"shells[plate].plate.elements_{axis}={ELEMENTS}" for axis in "xy"])
            seconds += took
            residuals.append(run["energy"]["residual_relative"])
            row.append(graph)
            counts[speed].append(0 if graph is None else len(radial_crossings(graph.ends, centre, counted_at)))
        graphs.append(row)
        found = Radials(counts, graphs, residuals, seconds)
        table.lines.append(f"{name} {speed} m/s: {found.mean(speed):.1f} radial cracks, {' '.join(map(str, counts[speed]))}"
                           + ("" if found.crossed(speed) else "; left out, in most runs none"))
    return found


def impact_speed(table: Table, executables: Executables) -> None:
    """Runs scenes/acrylic.textproto at seven speeds over a factor of eight, SEEDS seeds each."""
    found = _radials(table, executables, "impact_speed", [], SPEEDS, SEEDS)
    means = {speed: found.mean(speed) for speed in SPEEDS}
    errors = {speed: _bar(found.counts[speed]) for speed in SPEEDS}
    every, most = found.fit(), found.most_at()
    fit = found.fit(most)
    table.add("impact_speed_exponent", fit.exponent, 0.5, 0.2, found.seconds)
    table.add("impact_speed_at_22", means[22], 4.0, 0.25, 0.0)
    table.add("impact_speed_at_57", means[57], 8.0, 0.25, 0.0)
    _add_energy(table, "impact_speed", found.residuals)
    table.lines.append(f"impact_speed: exponent up to {most} m/s, where cracks are most, {fit.exponent:.2f}, +- "
                       f"{fit.half:.2f} (95 %); over all speeds {every.exponent:.2f}, +- {every.half:.2f}; published 0.5, "
                       f"4 cracks at 22 m/s and 8 at 57 (Vandenberghe, Vermorel, Villermaux 2013), {BETWEEN_PUBLISHED:.2f} "
                       "between these two")
    axes = {"panel": "radial cracks", "x_label": "speed [m/s]", "y_label": f"radial cracks {BARS}", "logarithmic": False,
            "from_zero": True}
    table.curves.append({"name": "found", "x": [float(s) for s in SPEEDS], "y": [means[s] for s in SPEEDS],
                         "half": [errors[s] for s in SPEEDS], **axes})
    table.curves.append({"name": "published", "x": [22.0, 57.0], "y": [4.0, 8.0], **axes})
    table.curves.append({"name": "square root", "x": [float(s) for s in SPEEDS],
                         "y": [4.0 * 2.0 ** 0.5 * (s * s / (22.0 * 57.0)) ** 0.25 for s in SPEEDS], **axes})
    if table.pictures is not None:
        draw_cracks(table.pictures / "impact_speed.png", found.graphs, (SIDE, SIDE),
                    names=[f"{speed} m/s" for speed in SPEEDS])


GLASS = ("preset=SODA_LIME_GLASS", "strength=60e6")
OTHER_PLATES = {  # name: settings, and where cracks are counted, four thicknesses from the impact [m]
    "acrylic_2mm": (["shells[plate].thickness_m=2e-3", "bodies[pellet].pose.position.z=0.00301"], 8e-3),
    "glass_1mm": ([f"materials[acrylic].{field}" for field in GLASS], 4e-3),
    "glass_2mm": ([f"materials[acrylic].{field}" for field in GLASS]
                  + ["shells[plate].thickness_m=2e-3", "bodies[pellet].pose.position.z=0.00301"], 8e-3),
}
OTHER_SPEEDS, OTHER_SEEDS = (15, 22, 40, 57, 80), 8


def impact_speed_plates(table: Table, executables: Executables) -> None:
    """The same of glass, and of plates twice as thick: the exponent only, since nobody has published their numbers."""
    for name, (settings, counted_at) in OTHER_PLATES.items():
        found = _radials(table, executables, f"impact_speed_plates {name}", settings, OTHER_SPEEDS, OTHER_SEEDS, counted_at)
        try:
            fit, most = found.fit(found.most_at()), found.most_at()
        except ValueError as error:
            table.lines.append(f"impact_speed_plates {name}: {error}")
            table.add(f"impact_speed_{name}_exponent", math.nan, 0.5, 0.2, found.seconds)
            continue
        table.add(f"impact_speed_{name}_exponent", fit.exponent, 0.5, 0.2, found.seconds)
        _add_energy(table, f"impact_speed_{name}", found.residuals)
        table.lines.append(f"impact_speed_plates {name}: exponent up to {most} m/s {fit.exponent:.2f}, +- {fit.half:.2f} (95 %)")
        if table.pictures is not None:
            draw_cracks(table.pictures / f"impact_speed_{name}.png", found.graphs, (SIDE, SIDE),
                        names=[f"{speed} m/s" for speed in OTHER_SPEEDS])


def _add_equivalence(table: Table, name: str, of: list[list[float]], margin: float, seconds: float) -> list[float]:
    """Adds rows for results on three grids, coarse first. The last two must be equivalent: the difference of their means
    and twice its standard error together may not exceed `margin`, a share of the mean set beforehand; the first and the
    last, twice that. So scatter makes a row harder to pass, not easier. The error is that of the differences, seed by seed:
    a seed has the same place of the ball on all grids, and the same flaws where they do not follow the grid. Returns the
    means."""
    mean = [float(np.mean(values)) for values in of]
    for row, first, share in ((name, 1, margin), (f"{name}_over_three", 0, 2.0 * margin)):
        error = float(np.std(np.subtract(of[2], of[first]), ddof=1)) / math.sqrt(len(of[2]))
        furthest = mean[first] + math.copysign(abs(mean[2] - mean[first]) + 2.0 * error, mean[2] - mean[first])
        table.add(row, furthest, mean[first], share, seconds if first == 1 else 0.0)
    return mean


def refinement(table: Table, executables: Executables) -> None:
    """Runs scenes/acrylic.textproto at 40 m/s on three grids, SEEDS seeds each, until the plate has stopped the ball."""
    found: dict[int, dict[str, list[float]]] = {}
    grids = (50, 75, 110)
    for elements in grids:
        here: dict[str, list[float]] = {"surface": [], "length": [], "fragments": [], "residual_speed": [], "fracture": [], "residual": []}
        seconds = 0.0
        for seed in range(1, SEEDS + 1):
            graph, run, back, took = _struck(executables, "acrylic.textproto", seed, ["end_time_s=3e-4"] + [
                f"shells[plate].plate.elements_{axis}={elements}" for axis in "xy"])
            seconds += took
            here["surface"].append(run["cracks"]["surface_total_m2"])
            here["length"].append(0.0 if graph is None else float(lengths(graph.ends).sum()))
            here["fragments"].append(float(run["counts"]["fragments"]))
            here["residual_speed"].append(-back)
            here["fracture"].append(run["energy"]["dissipated_fracture"])
            here["residual"].append(run["energy"]["residual_relative"])
        found[elements] = here
        table.lines.append(f"refinement {SIDE / elements * 1e3:.2f} mm: " + ", ".join(
            f"{name} {np.mean(v):.4g} +- {np.std(v, ddof=1):.2g}" for name, v in here.items()))
    for name, part in (("surface", 0.1), ("residual_speed", 0.05)):
        mean = _add_equivalence(table, f"refinement_{name}", [found[elements][name] for elements in grids], part, seconds)
        table.curves.append({"name": f"refinement: {name}", "x_label": "spacing [mm]", "y_label": f"{name} {BARS}",
                             "x": [SIDE / elements * 1e3 for elements in grids], "y": mean, "logarithmic": False,
                             "half": [_bar(found[elements][name]) for elements in grids], "from_zero": True})
    _add_energy(table, "refinement", [r for elements in grids for r in found[elements]["residual"]])


QUANTILES = (0.25, 0.5, 0.75)


@dataclass(frozen=True)
class Shattering:
    """A plate that breaks into pieces, on three grids; the element of each grid is 1.3 to 1.5 times that of the next
    one."""
    name: str
    scene: str
    shell: str
    ball: str
    grids: tuple[int, int, int]  # elements along the plate
    settings: tuple[str, ...]
    takes_its_energy: bool = False  # cracks take the energy that their area needs
    seeds: int = SEEDS


# A heavy ball breaks a plate of acrylic into sectors. Its cracks should dissipate the energy that their area needs. The
# surface of one run scatters by a sixth: twice the standard error of fewer seeds is more than the margin.
SNAPPED = Shattering("snapped", "acrylic.textproto", "plate", "pellet", (44, 66, 96), (
    "bodies[pellet].sphere.radius_m=0.008", "bodies[pellet].pose.position.z=0.00851",
    "bodies[pellet].twist.linear.z=-20", "end_time_s=8e-4", "output.frame_interval_s=2e-4"), True, 64)
# Pieces of a pane with a strength that no grid resolves.
STRUCK = Shattering("pieces", "struck_glass.textproto", "pane", "ball", (40, 56, 80), ())
# All surface, resolved and not; pieces above LARGE squared spacings of the coarsest grid; the ball. Shares of the mean.
COMPARED = (("surface", 0.1), ("large_pieces", 0.2), ("residual_speed", 0.05))
LARGE = 10.0

# A pane that shatters, on grids that resolve the length that a crack needs for its energy: 4 mm in bending.
RESOLVED = ("materials[glass].strength=60e6", "materials[glass].fracture_energy=80")
TOUGH = Shattering("tough", "struck_glass.textproto", "pane", "ball", (40, 56, 80), (
    *RESOLVED, "bodies[ball].twist.linear.z=-30"))
# A larger and slower ball: the stress under it is only 1.4 times the strength, and pieces are larger than the
# resolution of the grids. Most of them are still in place at the end.
HEAVY = Shattering("heavy", "struck_glass.textproto", "pane", "ball", (40, 56, 80), (
    *RESOLVED, "bodies[ball].sphere.radius_m=0.01", "bodies[ball].pose.position.z=0.01051",
    "bodies[ball].twist.linear.z=-10", "end_time_s=3e-4"), True)


def _in_place(folder: Path, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Returns the areas at rest [m^2] of the pieces that the shell process still has at the end, without the
    largest. The first array has pieces that reach further than `spacing` [m] from the plate's border; the second has
    the others, strips at the border. A crack along a clamp leaves no strips."""
    mesh = list_frames(folder)[-1].read(SHELL)
    if mesh is None or len(mesh.triangles) == 0:
        return np.zeros(0), np.zeros(0)
    points = reference_points(mesh)[:, :2]
    corner = points[mesh.triangles]
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    low, high = points.min(axis=0), points.max(axis=0)
    samples = np.concatenate([corner, corner.mean(axis=1, keepdims=True)], axis=1)  # (triangles, 4, 2)
    inside = np.minimum(samples - low, high - samples).min(axis=2).max(axis=1)
    _, piece = np.unique(mesh.of_triangles("fragment", 0), return_inverse=True)
    areas, depth = np.bincount(piece, area), np.zeros(piece.max() + 1)
    np.maximum.at(depth, piece, inside)
    others = np.arange(len(areas)) != areas.argmax()
    return np.sort(areas[others & (depth > spacing)]), np.sort(areas[others & (depth <= spacing)])


def _shattered(executables: Executables, what: Shattering, elements: int, seed: int,
               picture: Path | None) -> tuple[dict, np.ndarray, np.ndarray]:
    """Returns the compared numbers of one run, and areas [m^2] of its pieces, handed off or all; and the same areas
    without pieces at the border."""
    chance = random.Random(seed)
    reach = 0.5 * SIDE / what.grids[0]  # the same places on all grids
    beside = [f"bodies[{what.ball}].pose.position.{axis}={chance.uniform(-reach, reach):.9g}" for axis in "xy"]
    with kept_run(executables, what.scene, [f"fracture.seed={seed}", *what.settings, *beside] + [
            f"shells[{what.shell}].plate.elements_{axis}={elements}" for axis in "xy"]) as (folder, seconds):
        run, probe = read_run(folder), list(csv.reader((folder / "probes.csv").open()))
        areas = np.array([float(row["area [m^2]"]) for row in csv.DictReader((folder / "shards.csv").open())])
        kept, left = _in_place(folder, SIDE / elements)
        if picture is not None:
            shutil.copy(write_contact_sheet(folder), picture)
            print(f"picture          {picture}", flush=True)
    large = np.concatenate([areas, kept]) > LARGE * (SIDE / what.grids[0]) ** 2
    return {"count": float(run["counts"]["fragments"]), "surface": run["cracks"]["surface_total_m2"],
            "large_pieces": float(large.sum()), "length": run["cracks"]["length_m"],
            "residual_speed": -float(probe[-1][probe[0].index(f"{what.ball}_vz [m/s]")]), "area_off": float(areas.sum()),
            "taken": run["cracks"]["taken_relative"] or 0.0, "residual": run["energy"]["residual_relative"],
            "seconds": seconds}, np.concatenate([areas, kept, left]), np.concatenate([areas, kept])


def _one_thread() -> None:
    os.environ["OMP_NUM_THREADS"] = "1"  # results do not depend on the number of threads


def _pieces_of(table: Table, executables: Executables, what: Shattering) -> None:
    """Compares pieces, their sizes, cracks and the ball on three grids, with as many seeds each. Numbers must be
    equivalent (`_add_equivalence`); the distance of the distributions of sizes is told."""
    name = what.name
    found: dict[int, list[dict]] = {}
    sizes: dict[int, list[np.ndarray]] = {}
    inside: dict[int, list[np.ndarray]] = {}
    left: list[float] = []
    for elements in what.grids:
        spacing = 1e3 * SIDE / elements  # [mm]
        picture = table.pictures / f"{name}_{elements}.png" if table.pictures is not None else None
        # one run per processor
        with ProcessPoolExecutor(len(os.sched_getaffinity(0)), initializer=_one_thread) as pool:
            runs = list(pool.map(_shattered, repeat(executables), repeat(what), repeat(elements), range(1, what.seeds + 1),
                                 [picture] + [None] * (what.seeds - 1)))
        found[elements] = [numbers for numbers, _, _ in runs]
        sizes[elements] = [areas * 1e6 for _, areas, _ in runs if len(areas)]  # [mm^2]
        inside[elements] = [areas * 1e6 for _, _, areas in runs if len(areas)]
        left.append(float(np.mean([len(every) - len(areas) for _, every, areas in runs])))
        every = np.sort(np.concatenate([*sizes[elements], np.zeros(0)]))
        table.curves.append({"name": f"{spacing:.2f} mm", "panel": f"{name}: share that is no larger",
                             "x_label": "area [mm^2]", "y_label": "share", "x": every.tolist(),
                             "y": (np.arange(1, len(every) + 1) / len(every)).tolist(), "logarithmic": False,
                             "from_zero": True})
        table.lines.append(f"{name} {spacing:.2f} mm: " + ", ".join(
            f"{key} {np.mean([r[key] for r in found[elements]]):.4g} +- "
            f"{np.std([r[key] for r in found[elements]], ddof=1):.2g}"
            for key in ("surface", "large_pieces", "count", "length", "taken", "area_off", "residual_speed"))
            + f"; largest energy residual {max(abs(r['residual']) for r in found[elements]):.1e}")
        bounds = [quantile_bounds(sizes[elements], share) for share in QUANTILES]
        table.lines.append(f"{name} {spacing:.2f} mm: quartiles of the area of {len(every)} "
            + "in all but the largest " + ", ".join(
            f"{q:.2f} ({low:.2f} to {high:.2f})" for q, low, high in bounds)
            + f" mm^2; the median is {bounds[1][0] / spacing ** 2:.1f} squared spacings")
    last = what.grids[2]
    for key, part in COMPARED:
        of = {elements: [r[key] for r in found[elements]] for elements in what.grids}
        mean = _add_equivalence(table, f"{name}_{key}", list(of.values()), part, sum(r["seconds"] for r in found[last]))
        table.curves.append({"name": f"{name}: {key}", "x_label": "spacing [mm]", "y_label": f"{key} {BARS}",
                             "x": [1e3 * SIDE / elements for elements in what.grids], "y": mean, "logarithmic": False,
                             "half": [_bar(of[elements]) for elements in what.grids], "from_zero": True})
    if what.takes_its_energy:
        _add_taken(table, name, [r["taken"] for r in found[last]])
    _add_energy(table, name, [r["residual"] for elements in what.grids for r in found[elements]])
    _sizes(table, name, "sizes", sizes, what.grids)
    table.lines.append(f"{name}: left at the border, no further from it than a spacing: "
                       f"{', '.join(f'{n:.1f}' for n in left)} of these in a run")
    table.add(f"{name}_strips_at_the_border", max(left), 0.0, MOST_STRIPS, 0.0)
    _sizes(table, name, "sizes_inside", inside, what.grids)


def _sizes(table: Table, name: str, key: str, sizes: dict[int, list[np.ndarray]], grids: tuple[int, ...]) -> None:
    """Tells how far apart the sizes of pieces are from grid to grid, `sizes` [mm^2] of every run."""
    if not all(sizes[elements] for elements in grids):
        table.lines.append(f"{name}: {key.replace('_', ' ')}: no pieces on one of the grids")
        return
    apart = [distance(np.concatenate(sizes[a]), np.concatenate(sizes[b])) for a, b in zip(grids, grids[1:])]
    chance = chance_of_distance(sizes[grids[1]], sizes[grids[2]])
    medians = ", ".join(f"{np.median(np.concatenate(sizes[elements])):.2f}" for elements in grids)
    table.lines.append(f"{name}: {key.replace('_', ' ')}, medians {medians} mm^2; distributions of areas are {apart[0]:.2f} "
                       f"and {apart[1]:.2f} apart from grid to grid; chance of so much between the last two if they are of "
                       f"one kind {chance:.3f}")


def snapped(table: Table, executables: Executables) -> None:
    """Checks pieces where cracks should dissipate the energy that their area needs, so that results may converge."""
    _pieces_of(table, executables, SNAPPED)


def tough(table: Table, executables: Executables) -> None:
    """Checks pieces of a pane that shatters, on grids that resolve the start of cracks."""
    _pieces_of(table, executables, TOUGH)


def heavy(table: Table, executables: Executables) -> None:
    """Checks pieces of such a pane under a larger and slower ball; they are larger than the resolution of the grids."""
    _pieces_of(table, executables, HEAVY)


def pieces(table: Table, executables: Executables) -> None:
    """Reports pieces of scenes/struck_glass.textproto: their number and sizes do not converge."""
    _pieces_of(table, executables, STRUCK)
