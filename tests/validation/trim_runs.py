"""Cracks and cuts over ties along trims: whole runs of a sheet with a piece let into it, compared with the sheet in one
patch."""
from __future__ import annotations

import json
import math
from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from sunder_tools.launch.build import Executables
from sunder_tools.report.run_json import read_run

from .seam_runs import ELEMENTS, HEAD, NOTCH, SIDE, STRENGTH, crossings, run_text
from .trials import Table

SPACING = SIDE / ELEMENTS  # [m] of the single patch
MIDDLE = (0.1513, 0.1007)  # [m] of the piece that is let in: the crack crosses its border twice
# [m] of notches, over a spacing: a crack runs by edges, and where one of them meets a border is left to chance.
NOTCHES = tuple(NOTCH + share * SPACING for share in (-0.4, -0.2, 0.0, 0.2, 0.4))
MARGIN = 4.0  # elements of the piece's patch beyond its border


@dataclass(frozen=True)
class Inset:
    """A piece in the sheet: a rectangle, or a disc where `round`. The parameters of its patch are turned."""
    name: str
    half_x: float   # [m]
    half_y: float
    round: bool = False
    turned: float = 0.0    # [rad]
    finer: float = 1.0     # spacing of its elements, over that of the sheet


INSETS = (Inset("straight", 0.02, 0.05), Inset("turned", 0.02, 0.05, False, math.radians(30.0), 0.93),
          Inset("curved", 0.03, 0.03, True, math.radians(20.0), 0.93))


def _points(line: list[tuple[float, float]]) -> str:
    return " ".join(f"points {{ u: {u!r} v: {v!r} }}" for u, v in line)


def _loop(inset: Inset, middle: tuple[float, float], angle: float) -> str:
    if inset.round:
        return f"circle {{ center {{ u: {middle[0]!r} v: {middle[1]!r} }} radius_m: {inset.half_x!r} }}"
    c, s = math.cos(angle), math.sin(angle)
    corners = [(x * inset.half_x, y * inset.half_y) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))]
    return _points([(middle[0] + c * x - s * y, middle[1] + s * x + c * y) for x, y in corners])


def inset_text(inset: Inset, cut: list[tuple[float, float]] | None = None) -> str:
    """Writes the piece; `cut` is a polyline in the sheet's plane [m], which the plate's parameters turn with."""
    c, s = math.cos(inset.turned), math.sin(inset.turned)
    size = [2.0 * (a * abs(c) + b * abs(s) + MARGIN * SPACING)
            for a, b in ((inset.half_x, inset.half_y), (inset.half_y, inset.half_x))]
    middle = (0.5 * size[0], 0.5 * size[1])
    elements = [round(length / (SPACING * inset.finer)) for length in size]
    own = [(middle[0] + c * (x - MIDDLE[0]) + s * (y - MIDDLE[1]), middle[1] - s * (x - MIDDLE[0]) + c * (y - MIDDLE[1]))
           for x, y in cut or []]
    return f"""shells {{ name: "inset" material: "plaster" thickness_m: 0.002
  plate {{ size_x_m: {size[0]!r} size_y_m: {size[1]!r} elements_x: {elements[0]} elements_y: {elements[1]}
    pose {{ position {{ x: {MIDDLE[0]} y: {MIDDLE[1]} }} orientation {{ w: {math.cos(0.5 * inset.turned)!r} z: {math.sin(0.5 * inset.turned)!r} }} }} }}
  trims {{ {_loop(inset, middle, -inset.turned)} }}
  {f"cuts {{ {_points(own)} time_s: 2e-4 }}" if own else ""} }}
"""


def sheet_text(inset: Inset | None, more: str) -> str:
    """Writes the sheet, with a hole where the piece is; `more` goes into its message."""
    hole = f"trims {{ hole: true {_loop(inset, MIDDLE, 0.0)} }}" if inset else ""
    return f"""shells {{ name: "sheet" material: "plaster" thickness_m: 0.002
  plate {{ size_x_m: {SIDE} size_y_m: {SIDE} elements_x: {ELEMENTS} elements_y: {ELEMENTS}
    pose {{ position {{ x: {0.5 * SIDE} y: {0.5 * SIDE} }} }} }}
  {hole}
  {more} }}
"""


def pulled_text(inset: Inset | None, notch: float = NOTCH) -> str:
    """Writes scenes/mode_one.textproto with a notch at this height [m] and a piece let into its sheet."""
    text = HEAD.format(name=inset.name if inset else "single", end=1.5e-3, strength=STRENGTH, mode="TIPS",
                       more="branch_ratio: 5", frames=5e-5)
    text += sheet_text(inset, f"""supports {{ edges: V_MIN kind: SIMPLY_SUPPORTED }}
  supports {{ edges: V_MAX kind: SIMPLY_SUPPORTED
    motion {{ time_s: 0 displacement {{}} }} motion {{ time_s: 2e-3 displacement {{ y: 2e-4 }} }} }}
  cuts {{ points {{ u: 0 v: {notch!r} }} points {{ u: 0.1 v: {notch!r} }} }}""")
    return text + (inset_text(inset) + "seams {}\n" if inset else "")


def trim_crack(table: Table, executables: Executables) -> None:
    """Pulls a notched sheet, in one patch and with pieces let into it across the crack's path. Path and arrival are also
    means over heights of the notch; a note has the standard error."""
    planes = np.array([0.11, MIDDLE[0] - 0.5 * INSETS[0].half_x, MIDDLE[0], MIDDLE[0] + 0.5 * INSETS[0].half_x,
                       MIDDLE[0] + INSETS[2].half_x + 1.5 * SPACING, SIDE - SPACING])
    single = [_pulled(executables, table, None, notch, planes) for notch in NOTCHES]
    for inset in INSETS:
        found: dict[str, list[float]] = defaultdict(list)
        seconds = 0.0
        for notch, (height, when, residual, _) in zip(NOTCHES, single):
            own_height, own_when, own_residual, took = _pulled(executables, table, inset, notch, planes)
            found["off_path_spacings"].append(float(np.max(np.abs(own_height - height))) / SPACING)
            # Delay of the crack at the far side, as a share of its travel time from the notch.
            found["arrival"].append((own_when[-1] - own_when[0]) / (when[-1] - when[0]))
            found["starts"].append(own_when[0] / when[0])
            found["more_residual"].append(max(0.0, abs(own_residual) - abs(residual)))  # than in the single patch
            seconds += took
        for what, reference, tolerance in (("off_path_spacings", 0.0, 1.0), ("arrival", 1.0, 0.05), ("starts", 1.0, 0.02),
                                           ("more_residual", 0.0, 0.005)):
            table.add(f"trim_crack_{inset.name}_{what}", found[what][NOTCHES.index(NOTCH)], reference, tolerance, seconds)
            seconds = 0.0
        for what, reference, tolerance in (("off_path_spacings", 0.0, 1.0), ("arrival", 1.0, 0.05)):
            mean, error = mean_and_error(found[what])
            table.add(f"trim_crack_{inset.name}_mean_{what}", mean, reference, tolerance, 0.0,
                      note=f"of {len(NOTCHES)} heights of the notch: standard error {error:.2g}, from {min(found[what]):.3g} to "
                           f"{max(found[what]):.3g}")


def mean_and_error(values: list[float]) -> tuple[float, float]:
    """The mean and its standard error. Both are NaN where a value is: a crack that does not arrive counts."""
    return float(np.mean(values)), float(np.std(values, ddof=1) / math.sqrt(len(values)))


def _pulled(executables: Executables, table: Table, inset: Inset | None, notch: float,
            planes: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Height [m] and time [s] at which the crack crosses each plane, energy residual, seconds."""
    with run_text(executables, pulled_text(inset, notch)) as (folder, seconds):
        height, when = crossings(folder, planes)
        energy = read_run(folder)["energy"]
    table.lines.append(_course(inset.name if inset else "one patch", notch, height, when, f"energy residual "
                               f"{energy['residual_relative']:.1e}, injected {energy['crack_injected']:.1e} of "
                               f"{energy['dissipated_fracture']:.1e} J"))
    return height, when, energy["residual_relative"], seconds


def _course(name: str, notch: float, height: np.ndarray, when: np.ndarray, told: str) -> str:
    return (f"trim_crack, {name}, notch at {1e3 * notch:.1f} mm: heights off it " + " ".join(f"{1e3 * (y - notch):+.1f}" for y in height)
            + " mm, at " + " ".join(f"{1e6 * t:.0f}" for t in when) + f" us; {told}")


def trim_piece(table: Table, executables: Executables) -> None:
    """Checks that a piece that cuts of both shells separate over a tie leaves as one body, with nothing lost."""
    for inset in INSETS[:2]:
        border, far, near = MIDDLE[0] - inset.half_x, 0.107, 0.149
        low, high = 0.083, 0.121
        outer = [(border, low), (far, low), (far, high), (border, high)]
        inner = [(border, low), (near, low), (near, high), (border, high)]
        text = HEAD.format(name="cut_out", end=2e-3, strength=STRENGTH, mode="CUTS", more="latest_freeze_s: 1.9e-3",
                           frames=1e-3)
        text += sheet_text(inset, f"cuts {{ {_points(outer)} time_s: 2e-4 }} velocity {{ x: 1 z: 3 }}")
        text += inset_text(inset, inner).replace("trims", "velocity { x: 1 z: 3 } trims", 1) + "seams {}\n"
        what = f"trim_piece_{inset.name}"
        with run_text(executables, text) as (folder, seconds):
            run = read_run(folder)
            rows = (folder / "shards.csv").read_text().splitlines()
        areas = sorted(float(row.split(",")[2]) for row in rows[1:])
        table.add(f"{what}_bodies", len(areas), 2.0, 0.0, seconds)  # the remaining part leaves too
        # An end of a cut moves to a corner of the loop's polygon that is within a fiftieth of a spacing (kCutOnCrack). The
        # straight border has no corner there.
        moved = 1e-3 if inset.turned else 1e-9
        table.add(f"{what}_area_m2", areas[0] if areas else math.nan, (near - far) * (high - low), moved, 0.0)
        for key in ("mass_error_max", "momentum_error_max", "angular_momentum_error_max"):
            table.add(f"{what}_{key}", run["handoff"][key], 0.0, 1e-12, 0.0)
        table.add(f"{what}_energy_residual", run["energy"]["residual_relative"], 0.0, 0.01, 0.0)
        table.lines.append(f"{what}: {json.dumps(run['handoff'])}; {rows[1:]}")
