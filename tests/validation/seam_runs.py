"""Cracks and cuts over seams: whole runs of a sheet in two patches, compared with the sheet in one patch."""
from __future__ import annotations

import json
import math
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

import numpy as np

from sunder_tools.launch.build import Executables
from sunder_tools.launch.run import launch_once
from sunder_tools.pictures.crack_lines import grown, last_graph
from sunder_tools.report.columns import read_columns
from sunder_tools.report.run_json import read_run

from .trials import Table

SIDE = 0.2        # [m] of the sheet
ELEMENTS = 50  # per side of the single patch
STRENGTH = 8e6  # [Pa]: no crack nucleates ahead of the crack, which follows its energy
NOTCH = 0.1013    # [m] height of the notch
SEAM = 0.14  # [m] along the crack's path, where the sheet is divided
HEAD = """name: "{name}" end_time_s: {end} window_s: 5e-6 gravity {{}}
materials {{ name: "plaster" density: 1000 youngs_modulus: 3e9 poisson_ratio: 0.2 strength: {strength} fracture_energy: 12 }}
fracture {{ mode: {mode} seed: 1 {more} }}
output {{ frame_interval_s: {frames} }}
"""


def sheet_text(elements: list[tuple[float, float, int, int]], name: str) -> str:
    """Writes scenes/mode_one.textproto with its sheet divided along x: (from [m], to [m], elements along x, along
    y)."""
    text = HEAD.format(name=name, end=1.5e-3, strength=STRENGTH, mode="TIPS", more="branch_ratio: 5", frames=5e-5)
    for number, (low, high, along, across) in enumerate(elements):
        cut = f"cuts {{ points {{ u: 0 v: {NOTCH} }} points {{ u: 0.1 v: {NOTCH} }} }}" if low == 0.0 else ""
        text += f"""shells {{ name: "part{number}" material: "plaster" thickness_m: 0.002
  plate {{ size_x_m: {high - low!r} size_y_m: {SIDE} elements_x: {along} elements_y: {across}
    pose {{ position {{ x: {0.5 * (low + high)!r} y: {0.5 * SIDE} }} }} }}
  supports {{ edges: V_MIN kind: SIMPLY_SUPPORTED }}
  supports {{ edges: V_MAX kind: SIMPLY_SUPPORTED
    motion {{ time_s: 0 displacement {{}} }} motion {{ time_s: 2e-3 displacement {{ y: 2e-4 }} }} }}
  {cut} }}
"""
    return text + ("seams {}\n" if len(elements) > 1 else "")


@contextmanager
def run_text(executables: Executables, text: str) -> Iterator[tuple[Path, float]]:
    """Runs a scene given as text. Yields its run folder, which exists within the context, and the seconds of the
    run."""
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="validate-sunder-") as folder:
        scene, out = Path(folder) / "scene.textproto", Path(folder) / "out"
        scene.write_text(text)
        out.mkdir()
        launch_once(executables, scene, out, [])
        yield out, time.monotonic() - start


def crossings(folder: Path, planes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns height [m] and time [s] at which a grown crack first crosses each plane of constant x [m]; NaN: none
    crosses."""
    graph = grown(last_graph(folder))
    x = graph.rest[:, :, 0]
    height, when = np.full(len(planes), math.nan), np.full(len(planes), math.nan)
    for k, plane in enumerate(planes):
        hit = np.nonzero((x.min(axis=1) <= plane) & (x.max(axis=1) > plane))[0]
        if not len(hit):
            continue
        ends = graph.rest[hit]
        share = (plane - ends[:, 0, 0]) / (ends[:, 1, 0] - ends[:, 0, 0])
        y = ends[:, 0, 1] + share * (ends[:, 1, 1] - ends[:, 0, 1])
        best = int(np.argmin(graph.born[hit]))
        height[k], when[k] = y[best], graph.born[hit][best]
    return height, when


def crack(table: Table, executables: Executables) -> None:
    """Pulls a notched sheet, in one patch and in two with a seam across the crack's path."""
    spacing = SIDE / ELEMENTS
    left, right = round(SEAM / spacing), ELEMENTS - round(SEAM / spacing)
    planes = np.array([0.12, SEAM - 1.5 * spacing, SEAM + 1.5 * spacing, 0.16, 0.18, SIDE - spacing])
    with run_text(executables, sheet_text([(0.0, SIDE, ELEMENTS, ELEMENTS)], "single")) as (folder, seconds):
        height, when = crossings(folder, planes)
        residual = read_run(folder)["energy"]["residual_relative"]
    table.lines.append(f"crack, one patch: energy residual {residual:.1e}, heights off the notch "
                       + " ".join(f"{1e3 * (y - NOTCH):+.1f}" for y in height) + " mm, at "
                       + " ".join(f"{1e6 * t:.0f}" for t in when) + " us")
    for name, across in (("matching", ELEMENTS), ("other_knots", ELEMENTS + 7)):
        parts = [(0.0, SEAM, left, ELEMENTS), (SEAM, SIDE, right, across)]
        with run_text(executables, sheet_text(parts, name)) as (folder, seconds):
            found_height, found_when = crossings(folder, planes)
            run = read_run(folder)
        table.add(f"crack_{name}_off_path_spacings", float(np.max(np.abs(found_height - height))) / spacing, 0.0, 1.0,
                  seconds)
        # Delay of the crack at the far side, as a share of its travel time from the notch.
        run_time = when[-1] - when[0]
        table.add(f"crack_{name}_arrival", (found_when[-1] - found_when[0]) / run_time, 1.0, 0.1, 0.0)
        table.add(f"crack_{name}_starts", found_when[0] / when[0], 1.0, 0.02, 0.0)
        more = abs(run["energy"]["residual_relative"]) - abs(residual)  # than in the single patch
        table.add(f"crack_{name}_more_residual", max(0.0, more), 0.0, 0.005, 0.0)
        table.lines.append(f"crack, {name}: heights "
                           + " ".join(f"{1e3 * (y - NOTCH):+.1f}" for y in found_height) + " mm, at "
                           + " ".join(f"{1e6 * t:.0f}" for t in found_when) + f" us; energy residual "
                           f"{run['energy']['residual_relative']:.1e}, injected {run['energy']['crack_injected']:.1e} of "
                           f"{run['energy']['dissipated_fracture']:.1e} J")


HEIGHTS = (0.1013, 0.1003, 0.0997)  # [m] of the notch: 0.33 and 0.08 elements above the seam, and as far below
PATH = (0.11, 0.12, 0.14, 0.16, 0.18, 0.196)  # [m] along the crack's path
MOST_OFF = 1.5  # elements from the notch's line: in the single patch the crack leaves it by up to 1.7


def along_text(notch: float, parts: list[tuple[float, float, int]], name: str) -> str:
    """Writes scenes/mode_one.textproto with its sheet divided along the crack's path: (from [m], to [m], elements
    along x)."""
    text = HEAD.format(name=name, end=1.5e-3, strength=STRENGTH, mode="TIPS", more="branch_ratio: 5", frames=5e-5)
    for number, (low, high, along) in enumerate(parts):
        across = round((high - low) / SIDE * ELEMENTS)
        cut = f"cuts {{ points {{ u: 0 v: {notch - low!r} }} points {{ u: 0.1 v: {notch - low!r} }} }}"
        text += f"""shells {{ name: "part{number}" material: "plaster" thickness_m: 0.002
  plate {{ size_x_m: {SIDE} size_y_m: {high - low!r} elements_x: {along} elements_y: {across}
    pose {{ position {{ x: {0.5 * SIDE} y: {0.5 * (low + high)!r} }} }} }}
  {"supports { edges: V_MIN kind: SIMPLY_SUPPORTED }" if low == 0.0 else ""}
  {"supports { edges: V_MAX kind: SIMPLY_SUPPORTED motion { time_s: 0 displacement {} }"
   " motion { time_s: 2e-3 displacement { y: 2e-4 } } }" if high == SIDE else ""}
  {cut if low <= notch < high else ""} }}
"""
    return text + ("seams {}\n" if len(parts) > 1 else "")


def follow(table: Table, executables: Executables) -> None:
    """Compares a crack along a seam, or within an element of it, with the crack in a single patch."""
    middle, planes, knots = 0.5 * SIDE, np.array(PATH), ("matching", "other_knots")
    late, off = [], []  # with matching knots; NaN where the crack does not cross every plane
    through = dict.fromkeys(knots, 0)
    most, spent = 0.0, 0.0
    for notch in HEIGHTS:
        with run_text(executables, along_text(notch, [(0.0, SIDE, ELEMENTS)], "single")) as (folder, seconds):
            height, when = crossings(folder, planes)
            stored = read_columns(folder / "series.csv")["elastic [J]"].max()
            table.lines.append(f"follow, one patch, notch at {1e3 * notch:.1f} mm: "
                               + _course(height - notch, when, read_run(folder)))
        arrival, spent = when[-1], spent + seconds
        for name, along in zip(knots, (ELEMENTS, ELEMENTS + 7)):
            parts = [(0.0, middle, ELEMENTS), (middle, SIDE, along)]
            with run_text(executables, along_text(notch, parts, name)) as (folder, seconds):
                height, when = crossings(folder, planes)
                run, elastic = read_run(folder), read_columns(folder / "series.csv")["elastic [J]"]
            spent += seconds
            # a sheet that is not separated is stretched further and stores four times as much
            through[name] += bool(elastic[-1] < stored)
            if name == "matching":
                late.append(when[-1] / arrival)
                off.append(np.abs(height - notch).max() * ELEMENTS / SIDE)
            most = max(most, run["energy"]["crack_injected"] / run["energy"]["dissipated_fracture"])
            table.add(f"follow_{name}_{1e4 * notch:.0f}_energy_residual", run["energy"]["residual_relative"], 0.0, 0.01, 0.0)
            table.lines.append(f"follow, {name}: " + _course(height - notch, when, run))
    worst = float(late[int(np.argmax(np.abs(np.array(late) - 1.0)))])  # NaN where there is one
    table.add("follow_matching_arrival", worst, 1.0, 0.1, spent)
    table.add("follow_matching_off_path_spacings", float(np.max(off)), 0.0, MOST_OFF, 0.0)
    for name in knots:
        table.add(f"follow_{name}_through", through[name], float(len(HEIGHTS)), 0.0, 0.0)
    table.add("follow_injected", most, 0.0, 0.01, 0.0)


def _course(off: np.ndarray, when: np.ndarray, run: dict) -> str:
    return ("off the notch's line " + " ".join(f"{1e3 * y:+.1f}" for y in off) + " mm, at "
            + " ".join(f"{1e6 * t:.0f}" for t in when) + f" us; {run['counts']['fragments']} pieces; fracture took "
            f"{run['energy']['dissipated_fracture']:.1e} J, cracks added {run['energy']['crack_injected']:.1e}")


def cut_text(across: int, free: bool) -> str:
    """Writes two plates with a seam at x = 0.2 m, and cuts in both that together separate a piece over the seam."""
    text = HEAD.format(name="cut_out", end=2e-3, strength=STRENGTH, mode="CUTS", more="latest_freeze_s: 1.9e-3", frames=1e-3)
    for number, (low, elements, cut) in enumerate((
            (0.0, 20, ((0.2, 0.061), (0.08, 0.083), (0.08, 0.131), (0.2, 0.147))),
            (0.2, across, ((0.0, 0.061), (0.11, 0.083), (0.11, 0.131), (0.0, 0.147))))):
        points = " ".join(f"points {{ u: {u} v: {v} }}" for u, v in cut)
        edge = "U_MIN" if low == 0.0 else "U_MAX"
        hold = "" if free else f"supports {{ edges: {edge} kind: CLAMPED }}"
        text += f"""shells {{ name: "part{number}" material: "plaster" thickness_m: 0.002
  plate {{ size_x_m: 0.2 size_y_m: 0.2 elements_x: 20 elements_y: {elements}
    pose {{ position {{ x: {low + 0.1!r} y: 0.1 }} }} }}
  velocity {{ x: {1.0 if free else 0.0} z: {3.0 if free else 0.0} }}
  {hold} cuts {{ {points} time_s: 2e-4 }} }}
"""
    if not free:
        text += """bodies { name: "ball" material: "plaster" sphere { radius_m: 0.03 }
  pose { position { x: 0.2 y: 0.11 z: 0.0311 } } twist { linear { z: -4 } } }
"""
    return text + "seams {}\n"


def piece(table: Table, executables: Executables) -> None:
    """Checks that a piece that cuts of both patches separate over the seam leaves as one body, with nothing lost."""
    area = 0.5 * 0.12 * (0.086 + 0.048) + 0.5 * 0.11 * (0.086 + 0.048)
    for across in (20, 27):
        name = "matching" if across == 20 else "other_knots"
        for free in (True, False):
            what = f"piece_{name}_{'free' if free else 'struck'}"
            with run_text(executables, cut_text(across, free)) as (folder, seconds):
                run = read_run(folder)
                rows = (folder / "shards.csv").read_text().splitlines()
            handed = run["handoff"]
            areas = sorted(float(row.split(",")[2]) for row in rows[1:])
            table.add(f"{what}_bodies", len(areas), 2.0 if free else 1.0, 0.0, seconds)  # the remaining part leaves too
            table.add(f"{what}_area_m2", areas[0] if areas else math.nan, area, 1e-9, 0.0)
            for key in ("mass_error_max", "momentum_error_max", "angular_momentum_error_max"):
                table.add(f"{what}_{key}", handed[key], 0.0, 1e-12, 0.0)
            table.add(f"{what}_energy_residual", run["energy"]["residual_relative"], 0.0, 0.01, 0.0)
            table.lines.append(f"{what}: {json.dumps(handed)}; {rows[1:]}")
