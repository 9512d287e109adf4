"""A blunt tool that is pushed through a held film: one crack oscillates, and its wavelength goes with the tool's width.

Roman, Reis, Audoly, De Villiers, Viguié and Vallet (C. R. Mécanique 331, 811, 2003): wavelength and amplitude are
proportional to the width of the tool, whatever its speed and the thickness of the film.
"""
from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np

from sunder_tools.launch.build import Executables
from sunder_tools.pictures.crack_lines import Graph, grown, last_graph
from sunder_tools.report.run_json import read_run

from .crack_pictures import draw_cracks
from .patterns import power_law
from .trials import Table, add_books, kept_run

RUNS = ((0.005, 1.0), (0.01, 1.0), (0.02, 1.0), (0.01, 2.0))  # [m], [m/s]: width and speed of the tool
DAMPED = 0.5  # [speed / width], the same for all: a rate of its own would make runs dissimilar
THICKNESS = 1e-4  # [m], the same for all
LENGTH, ACROSS, NOTCH = 13.0, 10.0, 2.0  # [widths] of the film, and of the cut that the tool begins in
PER_WIDTH = 5     # elements
ASIDE = 0.1       # [widths]: the cut is off the tool's course, so that chance does not choose the first side
SIDES = 32        # of the prism that stands for a cylinder
SMOOTHED = 5      # edges, over which the course is averaged
EXPONENT_WITHIN = 0.1
SPEED_WITHIN = 0.1


def _prism(width: float) -> str:
    """Returns an OFF file of an upright prism, four widths tall."""
    ring = [(0.5 * width * math.cos(2.0 * math.pi * k / SIDES), 0.5 * width * math.sin(2.0 * math.pi * k / SIDES))
            for k in range(SIDES)]
    corners = [f"{x:.9g} {y:.9g} {z:.9g}" for z in (-2.0 * width, 2.0 * width) for x, y in ring]
    faces = [list(range(SIDES))[::-1], list(range(SIDES, 2 * SIDES)),
             *([k, (k + 1) % SIDES, SIDES + (k + 1) % SIDES, SIDES + k] for k in range(SIDES))]
    return "\n".join([f"OFF\n{len(corners)} {len(faces)} 0", *corners,
                      *(" ".join(map(str, [len(face), *face])) for face in faces), ""])


def scene_of(width: float, speed: float) -> str:
    """Returns the text of a film that is clamped all around. The tool stands in a hole and speeds up over a quarter of its
    width."""
    h, length, across = width / PER_WIDTH, LENGTH * width, ACROSS * width
    start = -0.5 * length + (NOTCH - 0.6) * width
    end, faster = (LENGTH - NOTCH - 1.0) * width / speed, 0.5 * width / speed
    hole, cut = (NOTCH - 0.6) * width, 0.5 * across + 0.13 * h + ASIDE * width
    return "\n".join([
        'name: "tool"', f"end_time_s: {end:.9g}", f"window_s: {0.02 * h / speed:.9g}", "gravity {}",
        'materials { name: "film" density: 900 youngs_modulus: 2e9 poisson_ratio: 0.3 strength: 1e9 fracture_energy: 4000 '
        f"mass_damping_per_s: {DAMPED * speed / width:.9g} crack_friction: 0 }}",
        "shells {", f'  name: "sheet" material: "film" thickness_m: {THICKNESS}',
        f"  plate {{ size_x_m: {length:.9g} size_y_m: {across:.9g} elements_x: {round(LENGTH * PER_WIDTH)} "
        f"elements_y: {round(ACROSS * PER_WIDTH)} }}",
        f"  trims {{ hole: true circle {{ center {{ u: {hole:.9g} v: {0.5 * across:.9g} }} radius_m: {0.55 * width:.9g} }} }}",
        f"  cuts {{ points {{ u: {hole + 0.3 * width:.9g} v: {cut:.9g} }} points {{ u: {(NOTCH + 0.5) * width:.9g} v: {cut:.9g} }} }}",
        "  supports { edges: ALL kind: CLAMPED }", "}",
        'bodies { name: "tool" mesh { path: "tool.off" }', f"  motion {{ time_s: 0 position {{ x: {start:.9g} }} }}",
        f"  motion {{ time_s: {faster:.9g} position {{ x: {start + 0.25 * width:.9g} }} twist {{ linear {{ x: {speed} }} }} }}",
        f"  motion {{ time_s: {end:.9g} position {{ x: {start + 0.25 * width + speed * (end - faster):.9g} }} }}", "}",
        "contacts { friction: 0 }",
        f"fracture {{ quiet_time_s: {end:.9g} interlock: false branch_ratio: 1000 }}",  # a film's crack does not divide
        f"output {{ frame_interval_s: {0.1 * end:.9g} }}", ""])


def turning_points(graph: Graph) -> np.ndarray:
    """Returns places (n, 2) [m] at which the course of one crack turns back across v."""
    course = graph.ends[np.argsort(graph.born, kind="stable")].mean(axis=1)
    if len(course) < SMOOTHED + 2:
        return np.zeros((0, 2))
    u, v = (np.convolve(course[:, k], np.full(SMOOTHED, 1.0 / SMOOTHED), "valid") for k in (0, 1))
    way = np.diff(v)
    turns = np.flatnonzero(way[:-1] * way[1:] < 0.0) + 1
    return np.column_stack([u[turns], v[turns]])


def wavelength(graph: Graph) -> float:
    """Returns twice the median length [m] along the course between turning points that follow one another; NaN where there
    are fewer than two."""
    steps = np.diff(turning_points(graph)[:, 0])
    return 2.0 * float(np.median(np.abs(steps))) if len(steps) else math.nan


def blunt_tool(table: Table, executables: Executables) -> None:
    """Pushes tools of three widths, and one at twice the speed, through a film that is damped alike in all."""
    found, graphs = [], []
    for width, speed in RUNS:
        with tempfile.TemporaryDirectory(prefix="validate-sunder-") as place:
            scene = Path(place) / "tool.textproto"
            scene.write_text(scene_of(width, speed)), (Path(place) / "tool.off").write_text(_prism(width))
            with kept_run(executables, str(scene), []) as (folder, seconds):
                graphs.append(last_graph(folder))
                graph, run = grown(graphs[-1]), read_run(folder)
        found.append(wavelength(graph))
        name = f"blunt_tool_{1e3 * width:g}_mm_{speed:g}"
        add_books(table, name, run, seconds)
        table.lines.append(f"{name}: wavelength {found[-1] / width:.2f} widths; the crack turns at "
                           + ", ".join(f"{u / width:.1f}" for u in turning_points(graph)[:, 0]) + " widths")
    widths = [width for width, _ in RUNS[:3]]
    exponent = power_law(np.array(widths), np.array(found[:3])).exponent if np.isfinite(found[:3]).all() else math.nan
    table.add("blunt_tool_exponent", exponent, 1.0, EXPONENT_WITHIN, 0.0)
    table.add("blunt_tool_speed", found[3] / found[1], 1.0, SPEED_WITHIN, 0.0)
    table.curves.append({"name": "found", "panel": "crack before a blunt tool", "x_label": "width [m]", "y_label": "wavelength [m]",
                         "x": widths, "y": found[:3], "logarithmic": True})
    if table.pictures is not None:
        for (width, speed), graph in zip(RUNS, graphs):
            draw_cracks(table.pictures / f"blunt_tool_{1e3 * width:g}_mm_{speed:g}.png", [[graph]],
                        (LENGTH * width, ACROSS * width), 400)
