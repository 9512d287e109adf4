"""The force that tears a sheet out of its plane: the trousers test."""
from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from sunder_tools.launch.build import Executables
from sunder_tools.pictures.crack_lines import grown, last_graph
from sunder_tools.report.run_json import read_run

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
