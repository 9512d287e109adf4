"""What the runs of the figures must hold: limits of their books and depths, and what is known to be beyond them."""
from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sunder_tools.pictures.crack_lines import graph_of
from sunder_tools.pictures.frames import CRACKS, list_frames
from sunder_tools.report.columns import read_columns
from sunder_tools.report.run_json import read_run

from .catalogue import CASES
from .runs import Runs

MOST_IMPULSE = 1e-12  # share of the impulses of a window; round-off of 1e4 samples in double precision is 1e-14
MOST_MISSING = 0.01   # of the paper's G_f times the area of the cracks


@dataclass(frozen=True)
class Check:
    """A number that must not be above `most`. `name` is CASE_WHAT, `words` say what it is."""
    name: str
    value: float
    most: float
    words: str


@dataclass(frozen=True)
class Known:
    """A check that is known to fail: the largest value that is still the known failure, and why it fails."""
    largest: float
    why: str


_SNAPS = ("the bodies bring many times the fracture energy, and strips that snap as they tear move some of it within a few "
          "steps; which strips there are changes with the last bit")

_HEAVY = ("block and tree bring many times the fracture energy, and the books miss a small part of that; "
          "plastic flow and contact are of first order in the step")

_BULLET = ("the bullet brings many times the fracture energy, and the books miss a small part of that as it strikes")
_DRESS = ("the dress gets short cracks in this size; the largest energy is many times their fracture energy, and the books miss "
          "a small part of it")
_STRIPS = ("contact is felt at Gauss points and at the edges of patches; a scrap that hangs on a crack has samples within it only, "
           "and its corners may lie in the body")
_PANE = "the pane snaps back as it shatters, in the last twentieth of the run; until then nothing is missing"

# By size and name of the check.
KNOWN: dict[tuple[str, str], Known] = {
    ("small", "fig01_missing"): Known(0.4, _HEAVY),
    ("small", "fig01_window"): Known(0.06, _HEAVY),
    ("small", "fig11_plate_missing"): Known(0.05, _PANE),
    ("small", "fig12_missing"): Known(0.4, _BULLET),
    ("small", "fig12_window"): Known(0.3, _BULLET),
    ("small", "fig14_even_missing"): Known(0.04, _SNAPS),
    ("small", "fig14_even_window"): Known(0.02, _SNAPS),
    ("small", "fig16_missing"): Known(0.06, _DRESS),
    ("small", "fig16_depth"): Known(0.012, _STRIPS),
}


def verdict(check: Check, size: str) -> str:
    """'held', 'known' or 'failed'. NaN fails."""
    if check.value <= check.most:
        return "held"
    gap = KNOWN.get((size, check.name))
    return "known" if gap is not None and check.value <= gap.largest else "failed"


def said(check: Check, size: str) -> str:
    """A check in one sentence, with its limit where it is not held."""
    words = f"{check.words}: {check.value:.2g}"
    if verdict(check, size) == "held":
        return f"{words}."
    gap = KNOWN.get((size, check.name))
    if gap is None:
        return f"{words}, above the limit of {check.most:g}."
    return f"{words}, above the limit of {check.most:g}. Known up to {gap.largest:g}: {gap.why}."


def fracture_energy(folder: Path, run: dict[str, Any], scene: Any) -> float:
    """G_f times the area of the cracks [J], shell by shell; NaN where they cannot be told apart. `scene` is the message of
    the run's scene. Cracks that run by themselves have a book of it. For those of damage it is length times thickness."""
    if run["cracks"]["resistance"] > 0.0:
        return float(run["cracks"]["resistance"])
    of = {m.name: m.fracture_energy for m in scene.materials if m.strength > 0.0}
    cost = [of.get(s.material, 0.0) * (s.thickness_m - s.interlayer.thickness_m) for s in scene.shells]  # [J/m]
    if not any(cost):
        return 0.0
    lengths = crack_lengths(folder, len(cost))
    return float(sum(c * length for c, length in zip(cost, lengths))) if lengths is not None else math.nan


def crack_lengths(folder: Path, shells: int) -> np.ndarray | None:
    """Length at rest [m] of the grown cracks of each shell, in the last frame with any; None where their numbers are not
    those of `shells` shells."""
    frames = [frame for frame in list_frames(folder) if CRACKS in frame.files]
    mesh = frames[-1].read(CRACKS) if frames else None
    if mesh is None:
        return np.zeros(shells)
    graph = graph_of(mesh, str(frames[-1].files[CRACKS]))
    number = np.asarray(mesh.cell_data["shell"]).astype(int)
    if len(number) != len(graph) or (number >= shells).any():
        return None
    length = np.linalg.norm(graph.rest[:, 1] - graph.rest[:, 0], axis=1) * (graph.born > 0.0)
    return np.bincount(number, length, shells)


def largest_energy(folder: Path) -> float:
    """The largest kinetic plus elastic energy of a run [J], to which run.json relates what is missing; NaN without
    series.csv, which has a row for each window."""
    table = read_columns(folder / "series.csv")
    if not len(table.get("kinetic [J]", ())):
        return math.nan
    return float((table["kinetic [J]"] + table["elastic [J]"]).max())


def number(value: float | None) -> float:
    """A number of run.json, which has null for what is not finite."""
    return math.nan if value is None else float(value)


def missing(folder: Path, run: dict[str, Any], scene: Any) -> tuple[float, float, float]:
    """Energy that the books miss at the end, and its largest change in a window [-], and G_f times the area of the cracks [J].
    The first two are over the third; without crack lines, over the largest energy of the run."""
    largest, needed = largest_energy(folder), fracture_energy(folder, run, scene)
    base = needed or largest or math.nan
    energy = run["energy"]
    return abs(number(energy["residual_relative"])) * largest / base, abs(number(energy["window_gap"])) / base, needed


def books_of(case: str, folder: Path, run: dict[str, Any], scene: Any) -> list[Check]:
    """The checks of a run's books; none where it has not been run to its end."""
    if run.get("status") != "done":
        return []
    end, window, needed = missing(folder, run, scene)
    of = (f"G_f times the area of the cracks, {needed:.3g} J" if needed != 0.0 else
          "the largest energy of the run, as there are no crack lines")
    impulses = [number(run["ledger"][which]) for which in ("linear_max", "angular_max")]
    return [Check(f"{case}_impulses", float(np.max(impulses)), MOST_IMPULSE,
                  f"{case}: impulses that do not agree, of those exchanged"),
            Check(f"{case}_missing", end, MOST_MISSING, f"{case}: energy that is missing at the end, of {of}"),
            Check(f"{case}_window", window, MOST_MISSING, f"{case}: its largest change in a window, of the same")]


def checks_of(runs: Runs, number: int, cases: tuple[str, ...]) -> list[Check]:
    """All checks of a figure whose runs are done: the books of its cases, and what was measured as it was drawn. Raises
    CommandError, and VtpError or OSError for a frame that cannot be read."""
    out = [check for case in cases
           for check in books_of(case, runs.place(case), read_run(runs.place(case)), CASES[case].made(runs.size).message)]
    drawn = runs.record.figures.get(str(number), {}).get("checks", [])
    return out + [Check(str(name), float(value), float(most), str(words)) for name, value, most, words in drawn]
