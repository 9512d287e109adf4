"""Energy and momentum books of runs that crack, and a run with a thousand pieces."""
from __future__ import annotations

import shutil

import numpy as np

from sunder_tools.launch.build import Executables
from sunder_tools.pictures.contact_sheet import write_contact_sheet
from sunder_tools.pictures.crack_lines import last_graph
from sunder_tools.report.columns import read_columns
from sunder_tools.report.run_json import read_run

from .trials import Table, add_books, add_momentum, kept_run

COARSE_GLASS = [f"shells[pane].plate.elements_{axis}=40" for axis in "xy"]
# Shipped runs whose books no other case checks.
BOOKS: tuple[tuple[str, list[str]], ...] = (
    ("glass", ["end_time_s=2e-3", *COARSE_GLASS]), ("struck_glass", []), ("acrylic", []), ("round_pane", []),
    ("ductile_strip", []), ("bullet_sheet", []), ("impactor_small", []))

BLAST = 3e6  # [Pa]
FEWEST_PIECES = 1000
EARLY_S, LATE_S = 2.2e-4, 8e-4
# scenes/pressed_plate.textproto under a blast instead of growing pressure, with the scatter of glass and undamped
MANY = [f"shells[pane].loads[0].pressure={BLAST:g}", "shells[pane].loads[0].factor[1].time_s=1e-4",
        "materials[glass].weibull_modulus=8", "materials[glass].mass_damping_per_s=0",
        "output.frame_interval_s=1e-4", "output.shell_frame_interval_s=1e-4",
        *(f"shells[pane].plate.elements_{axis}=96" for axis in "xy")]
QUARTER = [f"shells[pane].plate.{change}" for change in ("size_x_m=0.25", "size_y_m=0.25", "elements_x=48", "elements_y=48")]
MOST_DEARER = 1.5  # cost of an edge among many, over that of an edge among few; quadratic growth would be far beyond
# stages that depend on cracks; the other stages depend on bodies
OF_CRACKS = ("crack_update", "internal_force", "kick_drift")
OF_BODIES = ("coupling", "rigid_contact")
# allowed rise of an edge's cost in four times the pane: timings scatter by this on a shared machine
PROPORTIONAL = 0.25


def books(table: Table, executables: Executables) -> None:
    """Checks the books of every kind of run that cracks: energy that insertions add, energy in no book, and what
    pieces carry."""
    for scene, settings in BOOKS:
        with kept_run(executables, f"{scene}.textproto", settings) as (folder, seconds):
            run = read_run(folder)
        add_books(table, f"books_{scene}", run, seconds)
        add_momentum(table, f"books_{scene}", run)
        energy = run["energy"]
        table.lines.append(f"books {scene}: {run['counts']['fragments']} fragments, {run['counts']['handed_off']} "
                           f"handed off; fracture took {energy['dissipated_fracture']:.3g} J")


def growth_of_number(born: np.ndarray) -> float:
    """Returns the mean number over time after EARLY_S, over that before; `born` [s] has shape (n,)."""
    early = np.clip(EARLY_S - born, 0.0, None).sum() / EARLY_S
    if early <= 0.0:
        return 1.0  # no number to compare with
    return float(np.clip(LATE_S - born, 0.0, LATE_S - EARLY_S).sum() / (LATE_S - EARLY_S) / early)


def many(table: Table, executables: Executables) -> None:
    """Checks a pane that a blast breaks into a thousand pieces, with all cracks nucleated and propagated by
    themselves."""
    update, edges, stages = [], [], []
    ways: tuple[tuple[float, list[str]], ...] = (
        (LATE_S, QUARTER), (EARLY_S, []), (LATE_S, []))
    for end, settings in ways:
        with kept_run(executables, "pressed_plate.textproto", [*MANY, *settings, f"end_time_s={end}"]) as (folder, seconds):
            run = read_run(folder)
            stages.append(run["time"]["stage_s"])
            update.append(stages[-1]["crack_update"])
            graph, births = last_graph(folder), read_columns(folder / "shards.csv")["birth [s]"]
            edges.append(len(graph))
            if table.pictures is not None and end == LATE_S and not settings:
                shutil.copy(write_contact_sheet(folder), table.pictures / "many.png")
                print(f"picture          {table.pictures / 'many.png'}", flush=True)
    pieces, grew = run["counts"]["fragments"], run["time"]["cracks_grew"]
    table.add("many_pieces_at_least", min(pieces, FEWEST_PIECES), FEWEST_PIECES, 0.0, seconds)
    add_books(table, "many", run)
    add_momentum(table, "many", run)
    quarter, early, late = update[0] / edges[0], update[1] / edges[1], (update[2] - update[1]) / (edges[2] - edges[1])
    whole = update[2] / edges[2]
    per_second = {name: (first / EARLY_S, (stages[2][name] - first) / (LATE_S - EARLY_S)) for name, first in stages[1].items()}
    rise = {name: late / early for name, (early, late) in per_second.items()}
    cracks, bodies = growth_of_number(graph.born), growth_of_number(births)
    for of, names, growth in (("cracks", OF_CRACKS, cracks), ("bodies", OF_BODIES, bodies)):
        most = max(rise[name] for name in names)
        table.add(f"many_stages_grow_no_faster_than_{of}", max(most / growth, 1.0), 1.0, 0.0, 0.0)
    table.add("many_cost_of_an_edge_late_to_early", max(late / early, 1.0), 1.0, MOST_DEARER - 1.0, 0.0)
    table.add("many_cost_of_an_edge_in_four_times_the_pane", max(whole / quarter, 1.0), 1.0, PROPORTIONAL, 0.0)
    table.add("many_fracture_share", grew["crack_update_s"] / grew["wall_s"], 0.0, 0.15, 0.0)
    table.lines.append(f"many: {pieces} pieces, {run['counts']['handed_off']} handed off; {edges[2]} edges; an edge costs "
                       f"{1e3 * early:.2f} ms among the first {edges[1]}, {1e3 * late:.2f} ms among the rest, on the whole "
                       f"{1e3 * whole:.2f} ms, and {1e3 * quarter:.2f} ms in a quarter of the pane with {edges[0]}; a "
                       f"millisecond after {1e3 * EARLY_S:.2f} ms has {cracks:.1f} times the edges and {bodies:.1f} times the "
                       f"bodies of one before, and costs {', '.join(f'{name} {times:.1f}' for name, times in rise.items())} "
                       f"times as much; the run "
                       f"takes {seconds:.0f} s; {'; '.join(run['warnings']) or 'no warning'}")
