"""A cloth with a weakened region, and the same cloth without it: where its cracks are (paper, Fig. 14)."""
from __future__ import annotations

import numpy as np

from sunder_lab.paper.catalogue import CASES
from sunder_lab.paper.checks import MOST_MISSING, missing
from sunder_tools.launch.build import Executables
from sunder_tools.pictures.crack_lines import Within, grown, last_graph, within
from sunder_tools.report.run_json import read_run

from .trials import SCENES, Table, add_books, kept_run

SIZE = "small"
SEEDS = (1, 2, 3, 4)
# The strength of the figure's cloth does not vary, so that a seed alone changes nothing. A modulus of 30 scatters it by 4 %
# from cell to cell, far less than the weakened region differs. A cell has the spacing of the paper's grid.
SCATTER = ("materials[cloth].weibull_modulus=30", "materials[cloth].flaw_spacing_m=0.01")
# Set beforehand: more than chance, by a factor. The even cloth's cracks are within the region about as its area is.
TIMES = 2.0


def _cracks(table: Table, executables: Executables, case: str, seed: int) -> tuple[Within, float]:
    """Runs a case of the figure. Adds its books, and returns its cracks against the region, and the seconds of the run."""
    region = CASES[case].made(SIZE).find("shells[cloth].strength_regions[0]")
    low, high = np.array([region.low.u, region.low.v]), np.array([region.high.u, region.high.v])
    name = f"weakened_region_{seed}_{'a' if case == 'fig14_even' else 'b'}"
    settings = [*CASES[case].all_settings(SIZE), *SCATTER, f"fracture.seed={seed}"]
    with kept_run(executables, CASES[case].file().removeprefix(f"{SCENES.name}/"), settings) as (folder, seconds):
        found, run = within(grown(last_graph(folder)), low, high), read_run(folder)
        end, window, needed = missing(folder, run, CASES[case].made(SIZE).message)
    add_books(table, name, run)
    table.add(f"{name}_missing", end, 0.0, MOST_MISSING, 0.0, f"of G_f times the area of the cracks, {needed:.3g} J")
    table.add(f"{name}_window", window, 0.0, MOST_MISSING, 0.0, "the largest change of that in a window, of the same")
    return found, seconds


def weakened_region(table: Table, executables: Executables) -> None:
    """Checks that cracks begin in a weakened region, keep to it more than in an even cloth, and go on beyond it."""
    for seed in SEEDS:
        even, _ = _cracks(table, executables, "fig14_even", seed)
        weak, seconds = _cracks(table, executables, "fig14_weakened", seed)
        ratio = weak.share / max(even.share, 1e-9)  # NaN where no crack grew
        name = f"weakened_region_{seed}"
        table.add(f"{name}_share_at_least", min(ratio, TIMES), TIMES, 0.0, seconds,
                  f"share of crack length in the region: even {even.share:.3f}, weakened {weak.share:.3f}")
        table.add(f"{name}_first_inside", weak.first, 1.0, 0.0, 0.0)
        table.add(f"{name}_goes_beyond", weak.share < 1.0, 1.0, 0.0, 0.0)
        table.lines.append(f"weakened_region seed {seed}: even {even.length:.2f} m of cracks, {100.0 * even.share:.0f} % in the "
                           f"region; weakened {weak.length:.2f} m, {100.0 * weak.share:.0f} %, {100.0 * (1.0 - weak.share):.0f} % "
                           f"beyond it")
