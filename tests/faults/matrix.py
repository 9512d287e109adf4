"""The whole matrix: a pool plays it, a table shows it."""
from __future__ import annotations

import multiprocessing
import tempfile
from pathlib import Path

from .faults import BIRTHS, FAULTS, PHASES, Cell
from .session import Outcome, exchange, play

WORKERS = 6  # most of them wait


def used_again(cell: Cell) -> bool:
    """Whether the cell's folder is used again at once where not all are: every kind of ending is among them, as each
    fault is on each side."""
    return cell.phase == (BIRTHS if BIRTHS in FAULTS[cell.fault].phases else FAULTS[cell.fault].phases[-1])


def _play(job: tuple[Cell, bool]) -> Outcome:
    return play(*job)


def play_matrix(names: list[str], all_again: bool = False) -> dict[Cell, Outcome]:
    """Plays all cells of the named faults, each once: what is late in its own time is wrong, however busy the machine is.
    `all_again`: every folder is used again."""
    jobs = [(cell, all_again or used_again(cell)) for name in names for cell in FAULTS[name].cells()]
    jobs.sort(key=lambda job: job[0].fault not in ("stop", "pause", "slow"))  # long ones first
    with tempfile.TemporaryDirectory() as folder:
        exchange(Path(folder))
        with multiprocessing.get_context("fork").Pool(WORKERS) as pool:
            return {o.cell: o for o in pool.imap_unordered(_play, jobs)}


def table(outcomes: dict[Cell, Outcome]) -> str:
    """Rows of faults and sides, columns of phases: status and kind of the shell | of the rigid process | seconds."""
    rows = [["fault", "in what", *PHASES]]
    for fault in FAULTS.values():
        for side in fault.sides:
            row = [fault.name, side]
            for phase in PHASES:
                outcome = outcomes.get(Cell(fault.name, side, phase))
                row.append("-" if outcome is None else "skipped" if outcome.skipped else
                           "WRONG" if outcome.wrong else outcome.said)
            if any(cell != "-" for cell in row[2:]):
                rows.append(row)
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = ["  ".join(text.ljust(width) for text, width in zip(row, widths)).rstrip() for row in rows]
    played = {outcome.cell.fault for outcome in outcomes.values()}
    lines += [""] + [f"{f.name}: {f.what}{f' (-: {f.elsewhere})' if f.elsewhere else ''}" for f in FAULTS.values()
                     if f.name in played]
    lines += [f"skipped: {reason}" for reason in sorted({o.skipped for o in outcomes.values() if o.skipped})]
    return "\n".join(lines)
