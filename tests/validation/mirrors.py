"""Where a crack in a strip of glass divides: the branching constant, the speed and the energy of a running crack."""
from __future__ import annotations

import math
import re

from sunder_tools.launch.build import Executables
from sunder_tools.pictures.crack_lines import Graph, grown, last_graph
from sunder_tools.report.run_json import read_run

from .crack_paths import first_division, front_speed
from .crack_pictures import draw_cracks
from .trials import Table, add_books, kept_run

CONSTANT = 2.2  # [MPa sqrt(m)], 2.1 to 2.3 of float glass (ASTM C1678)
WITHIN = 0.1
RESOLVED = 5.0  # spacings, below which the length until a division is not resolved
SPEED = (1300.0, 1500.0)  # [m/s], 1450 published
TAKEN = 0.15
THICKNESS, WIDTH, POISSON = 2e-4, 0.03, 0.22  # [m], [m], [-]
GRIDS = (30, 42, 60)  # elements along the crack
STRESSES = (("stretched", 20e6), ("stretched", 30e6), ("bent", 60e6))  # [Pa]


def _settings(kind: str, stress: float, elements: int) -> list[str]:
    """Settings of scenes/mirror.textproto for a stress [Pa], of a face where the strip is bent."""
    out = [f"shells[strip].plate.elements_x={2 * elements}", f"shells[strip].plate.elements_y={elements}"]
    force = stress * THICKNESS if kind == "stretched" else 0.0  # [N/m]
    moment = stress * THICKNESS ** 2 / 6.0 if kind == "bent" else 0.0  # [N m/m]
    return out + [f"shells[strip].loads[0].edge_force.force_per_length.x={force:.9g}",
                  *(f"shells[strip].loads[{k}].edge_moment.moment_per_length={moment:.9g}" for k in (1, 2))]


def mirror(table: Table, executables: Executables) -> None:
    """Runs scenes/mirror.textproto. Bent, the stress is that which releases the same energy when it stretches."""
    rows: list[list[Graph | None]] = []
    for kind, stress in STRESSES:
        rows.append([])
        same_energy = 1.0 if kind == "stretched" else math.sqrt((1.0 + POISSON) / (3.0 * (3.0 + POISSON)))
        for elements in GRIDS:
            with kept_run(executables, "mirror.textproto", _settings(kind, stress, elements)) as (folder, seconds):
                graph, run = last_graph(folder), read_run(folder)
            if graph is None:
                raise ValueError(f"mirror: no crack, {kind} at {stress:g} Pa on {elements} elements")
            rows[-1].append(graph)
            found = grown(graph)
            across = Graph(found.ends[:, :, ::-1], found.rest, found.crack, found.born)  # it runs along v
            length, when = first_division(across)
            mean, _ = front_speed(across, when if math.isfinite(when) else 30e-6)
            spacings = length * elements / WIDTH
            name = f"mirror_{kind}_{stress / 1e6:.0f}_{elements}"
            constant = stress * same_energy * math.sqrt(length) / 1e6
            if math.isfinite(when):  # what the one crack took until then
                short = [*_settings(kind, stress, elements), f"end_time_s={0.95 * when:.9g}"]
                with kept_run(executables, "mirror.textproto", short) as (folder, more):
                    taken, seconds = read_run(folder)["cracks"]["taken_relative"], seconds + more
            else:
                taken = run["cracks"]["taken_relative"]
            table.lines.append(f"{name}: divides {1e3 * length:.2f} mm from the edge ({spacings:.1f} spacings) at "
                               f"{when * 1e6:.1f} us")
            if spacings >= RESOLVED:
                table.add(f"{name}_constant", constant, CONSTANT, WITHIN, seconds)
            table.add(f"{name}_speed", mean, 0.5 * sum(SPEED), (SPEED[1] - SPEED[0]) / sum(SPEED), 0.0)
            table.add(f"{name}_taken", math.nan if taken is None else taken, 1.0, TAKEN, 0.0)
            add_books(table, name, run)
    constants = [row for row in table.rows if re.fullmatch(r"mirror_.*_constant", str(row["name"]))]
    table.add("mirror_constants", len(constants), 5.0, 0.0, 0.0)  # two stresses and three grids, less the unresolved one
    table.lines.append("mirror: bent, the faces press on one another at the closed side, as a hinge does; such a crack takes "
                       "less than the stress ahead of it says, and does not divide at this stress")
    if table.pictures is not None:
        draw_cracks(table.pictures / "mirror.png", rows, (2.0 * WIDTH, WIDTH))
