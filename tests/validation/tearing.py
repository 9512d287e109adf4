"""Sheets that are torn out of their plane: the force of the trousers test, and the course of two cracks beside a flap."""
from __future__ import annotations

import csv
import math
import tempfile
from pathlib import Path

import numpy as np

from sunder_tools.launch.build import Executables
from sunder_tools.pictures.crack_lines import grown, last_graph
from sunder_tools.report.run_json import read_run

from .patterns import power_law
from .trials import Table, add_books, kept_run

FRACTURE_ENERGY, THICKNESS = 41.0, 1e-3  # [J/m^2], [m]: scenes/trousers.textproto
FORCE = 0.5 * FRACTURE_ENERGY * THICKNESS  # [N], of a leg: work of both legs 2 F da, surface G_f thickness da
GRIDS = (35, 50, 100)  # elements along the cut's line
FROM, TO = 0.058, 0.088  # [m], of the crack: legs hang straight, and the far border is not near
COURSE = 0.0201  # [m], v of the cut
LEG = "sheet_support_0_region_0_impulse_z [N s]"
WITHIN = 0.03


def force_of_leg(folder: Path, first: float, last: float) -> float:
    """Returns the mean force [N] that the first support bore between two times [s], from its impulses."""
    with (folder / "probes.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    impulse = sum(float(row[LEG]) for row in rows if first < float(row["time [s]"]) <= last)
    return impulse / (last - first)


def times_of(folder: Path, lengths: tuple[float, ...]) -> list[float]:
    """Returns the times [s] at which the crack had each length [m], as series.csv has them."""
    with (folder / "series.csv").open(newline="") as file:
        rows = [(float(row["time [s]"]), float(row["cracks [m]"])) for row in csv.DictReader(file)]
    return [next((time for time, length in rows if length >= wanted), math.nan) for wanted in lengths]


def trousers(table: Table, executables: Executables) -> None:
    """Runs scenes/trousers.textproto on three grids: the force of a leg, and how straight it tears."""
    for elements in GRIDS:
        settings = [f"shells[sheet].plate.elements_x={elements}", f"shells[sheet].plate.elements_y={2 * elements // 5}"]
        with kept_run(executables, "trousers.textproto", settings) as (folder, seconds):
            first, last = times_of(folder, (FROM, TO))
            force = force_of_leg(folder, first, last) if math.isfinite(first + last) else math.nan
            middle = grown(last_graph(folder)).ends.mean(axis=1)
            off = float(np.abs(middle[middle[:, 0] < TO, 1] - COURSE).max()) * elements / 0.1
            run = read_run(folder)
        table.add(f"trousers_{elements}_force", force, FORCE, WITHIN, seconds)
        table.add(f"trousers_{elements}_off_course", off, 0.0, 1.0, 0.0)  # [spacings]
        add_books(table, f"trousers_{elements}", run)
    table.lines.append("trousers: an edge of a spacing is cut as a whole when J has reached G_f, and J falls while it opens: the "
                       "mean force is below that of a crack that grows evenly, the less the finer the grid")


FLAP_LENGTH, FLAP_ACROSS, FLAP_WIDTH, FLAP_CUT = 0.06, 0.03, 0.012, 0.01  # [m]
FLAP_GRID = (80, 40)  # elements along and across
EXPONENT = 8.0 / 11.0
EXPONENT_WITHIN = 0.03 / 0.73
FARTHEST = 0.9  # [of the width of the flap]: the course from there on to the meeting point counts


def flap_scene() -> str:
    """Returns the text of a held film with a flap between two cuts, whose end is lifted, then drawn over the film."""
    h = FLAP_LENGTH / FLAP_GRID[0]
    low, high = 0.5 * (FLAP_ACROSS - FLAP_WIDTH) + 0.13 * h, 0.5 * (FLAP_ACROSS + FLAP_WIDTH) - 0.13 * h

    def region(of: float, to: float) -> str:
        return f"regions {{ low {{ u: 0 v: {of:.9g} }} high {{ u: {0.6 * h:.9g} v: {to:.9g} }} }}"

    places = ((0.0, 0.0, 0.0), (0.003, 0.003, 0.008), (0.0066, 0.010, 0.010), (0.02, 0.0368, 0.010))  # [s], [m], [m]: along, up
    motion = " ".join(f"motion {{ time_s: {time:.9g} displacement {{ x: {x:.9g} z: {z:.9g} }} }}" for time, x, z in places)
    return "\n".join([
        'name: "flap"', f"end_time_s: {places[-1][0]}", "window_s: 2e-5", "gravity {}",
        'materials { name: "film" density: 900 youngs_modulus: 2e9 poisson_ratio: 0.3 strength: 1e9 fracture_energy: 500 '
        "mass_damping_per_s: 300 }",
        "shells {", '  name: "sheet" material: "film" thickness_m: 1e-4',
        f"  plate {{ size_x_m: {FLAP_LENGTH} size_y_m: {FLAP_ACROSS} elements_x: {FLAP_GRID[0]} elements_y: {FLAP_GRID[1]} }}",
        *(f"  cuts {{ points {{ u: 0 v: {v:.9g} }} points {{ u: {FLAP_CUT} v: {v:.9g} }} }}" for v in (low, high)),
        "  supports { edges: V_MIN edges: V_MAX edges: U_MAX kind: SIMPLY_SUPPORTED }",
        f"  supports {{ kind: SIMPLY_SUPPORTED {region(0.0, low - 0.3 * h)} {region(high + 0.3 * h, FLAP_ACROSS)} }}",
        f"  supports {{ kind: SIMPLY_SUPPORTED {region(low + 0.3 * h, high - 0.3 * h)} {motion} }}", "}",
        "fracture { quiet_time_s: 1 interlock: false }", "output { frame_interval_s: 2e-3 }", ""])


def flap_exponent(ends: np.ndarray, middle: float, width: float) -> float:
    """Returns the exponent p of width ~ (distance to the meeting point)^p from edges (n, 2, 2) [m] of two cracks on either
    side of v = `middle`. Places count where their width is below FARTHEST `width`. NaN where they are fewer than three."""
    points = ends.reshape(-1, 2)
    meets = float(points[np.argmin(np.abs(points[:, 1] - middle)), 0])
    apart, left = 2.0 * np.abs(points[:, 1] - middle), meets - points[:, 0]
    counts = (apart < FARTHEST * width) & (apart > 0.0) & (left > 0.0)
    if len(np.unique(left[counts])) < 3:
        return math.nan
    return power_law(left[counts], apart[counts]).exponent


def flap(table: Table, executables: Executables) -> None:
    """Runs a pulled flap: its two cracks approach each other (Brau 2014)."""
    with tempfile.TemporaryDirectory(prefix="validate-sunder-") as place:
        scene = Path(place) / "flap.textproto"
        scene.write_text(flap_scene())
        with kept_run(executables, str(scene), []) as (folder, seconds):
            graph, run = grown(last_graph(folder)), read_run(folder)
    middle = 0.5 * FLAP_ACROSS
    table.add("flap_exponent", flap_exponent(graph.ends, middle, FLAP_WIDTH), EXPONENT, EXPONENT_WITHIN, seconds)
    sides = [graph.ends[(graph.ends[:, :, 1].mean(axis=1) > middle) == side].reshape(-1, 2) for side in (False, True)]
    spacing = FLAP_LENGTH / FLAP_GRID[0]
    mirrored = [max(float(np.abs(a[:, 1] - middle).min(initial=math.inf)) for a in sides),
                abs(float(sides[0][:, 0].max(initial=0.0)) - float(sides[1][:, 0].max(initial=0.0)))]
    table.add("flap_closes", mirrored[0] / spacing, 0.0, 1.0, 0.0)    # [spacings]
    table.add("flap_lopsided", mirrored[1] / spacing, 0.0, 1.0, 0.0)  # [spacings]: both cracks reach as far
    add_books(table, "flap", run)
    table.lines.append("flap: 8/11 holds where the fold between both cracks is sharp; stress ahead of a tip is then that of the "
                       "fold, across it, and turns the crack along the fold")
