"""Stars of cracks under a ball: arms are straight, and no crack runs beside another along a border."""
from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sunder_tools.launch.build import Executables
from sunder_tools.pictures.crack_lines import Graph, grown, last_graph

from .crack_pictures import draw_cracks
from .trials import Table, kept_run

STEP = 5.0       # [spacings] between two directions of an arm: a single edge knows its lattice only
SHORTEST = 10.0  # [spacings] of an arm that counts
STRAIGHT = 10.0  # [spacings] least mean radius of curvature
BAND = 6.0       # [spacings] of the border
BESIDE = (0.5, 3.0)  # [spacings] between two lines that count as double
PARALLEL = math.cos(math.radians(30.0))
DOUBLED = 0.02   # most of the length of all cracks


@dataclass(frozen=True)
class Star:
    """A name, a scene of the repository, its settings, and the middle and half width of its pane in parameters [m]. `round`
    panes have a circle as border."""
    name: str
    scene: str
    settings: tuple[str, ...]
    seeds: int
    middle: float
    half: float
    spacing: float
    round: bool = False


# To the end of the scene, and glass until its cracks have stopped: lines along its border come last.
STARS = (
    Star("struck_glass", "struck_glass", (), 8, 0.03, 0.03, 0.0015),
    Star("round_pane", "round_pane", (), 8, 0.015, 0.0135, 0.00075, True),
    Star("glass", "glass", ("end_time_s=0.01",), 8, 0.25, 0.25, 0.00625),
    Star("glass_clamped", "glass", ("end_time_s=0.01", "shells[pane].supports[0].kind=CLAMPED"), 4, 0.25, 0.25, 0.00625),
)


def arms(graph: Graph) -> list[np.ndarray]:
    """Returns the polylines (n, 2) of all cracks: from an end or a fork to the next, edges of one crack only."""
    vertices, points = graph.vertices(), graph.ends.reshape(-1, 2)
    place = {int(v): points[k] for k, v in enumerate(vertices.reshape(-1))}
    out = []
    for crack in np.unique(graph.crack):
        at: dict[int, list[int]] = defaultdict(list)  # edges at a vertex
        edges = np.flatnonzero(graph.crack == crack)
        for e in edges:
            for v in vertices[e]:
                at[int(v)].append(int(e))
        left = {int(e) for e in edges}
        for start in [v for v, own in at.items() if len(own) != 2] + list(at):  # rings come last
            for first in at[start]:
                if first not in left:
                    continue
                line, here, edge = [place[start]], start, first
                while True:
                    left.discard(edge)
                    a, b = (int(v) for v in vertices[edge])
                    here = b if here == a else a
                    line.append(place[here])
                    onward = [e for e in at[here] if e in left]
                    if len(at[here]) != 2 or not onward:
                        break
                    edge = onward[0]
                out.append(np.array(line))
    return out


def curvatures(line: np.ndarray, step: float) -> np.ndarray:
    """Returns turns per length [rad/m] between one chord of length `step` [m] along the line and the next."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.arange(0.0, length[-1] + 1e-9 * step, step)
    chords = np.diff(np.column_stack([np.interp(places, length, line[:, d]) for d in (0, 1)]), axis=0)
    angle = np.arctan2(chords[:, 1], chords[:, 0])
    turn = np.abs((np.diff(angle) + math.pi) % (2.0 * math.pi) - math.pi)
    return turn / step


def doubled(graph: Graph, star: Star) -> float:
    """Returns the share of the length of cracks that runs along the border beside another such line."""
    middle, along = graph.ends.mean(axis=1) - star.middle, np.diff(graph.ends, axis=1)[:, 0]
    length = np.linalg.norm(along, axis=1)
    along = along / length[:, None]
    if star.round:
        far = np.linalg.norm(middle, axis=1)
        normal, depth = middle / far[:, None], star.half - far
    else:
        axis = np.argmax(np.abs(middle), axis=1)
        normal, depth = np.eye(2)[axis], star.half - np.abs(middle).max(axis=1)
    tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
    runs = (depth < BAND * star.spacing) & (np.abs((along * tangent).sum(axis=1)) > PARALLEL)
    twice = np.zeros(len(graph), bool)
    low, high = (b * star.spacing for b in BESIDE)
    for k in np.flatnonzero(runs):
        apart = middle[runs] - middle[k]
        across, beside = np.abs(apart @ normal[k]), np.abs(apart @ tangent[k])
        twice[k] = bool(((across > low) & (across < high) & (beside < star.spacing)).any())
    return float(length[twice].sum() / length.sum())


def measure(graph: Graph, star: Star) -> tuple[np.ndarray, int, float]:
    """Returns curvatures [1/spacing] along all long arms, the number of these, and the doubled share."""
    long = [line for line in arms(graph)
            if np.linalg.norm(np.diff(line, axis=0), axis=1).sum() >= SHORTEST * star.spacing]
    bends = [curvatures(line, STEP * star.spacing) * star.spacing for line in long]
    return np.concatenate(bends) if bends else np.zeros(0), len(long), doubled(graph, star)


def stars(table: Table, executables: Executables) -> None:
    """Runs the scenes of STARS, each with its seeds."""
    for star in STARS:
        bends: list[np.ndarray] = []
        shares: list[float] = []
        drawn: list[Graph | None] = []
        seconds, number = 0.0, 0
        for seed in range(1, star.seeds + 1):
            with kept_run(executables, f"{star.scene}.textproto", [f"fracture.seed={seed}", *star.settings]) as (folder, took):
                graph = grown(last_graph(Path(folder)))
            seconds += took
            found, long, share = measure(graph, star)
            bends.append(found)
            shares.append(share)
            drawn.append(graph)
            number += long
        every = np.concatenate(bends)
        radius = 1.0 / float(every.mean()) if len(every) else math.nan  # without a long arm nothing is shown
        table.add(f"star_{star.name}_radius_at_least", min(radius, STRAIGHT), STRAIGHT, 0.0, seconds)
        table.add(f"star_{star.name}_doubled", float(np.mean(shares)), 0.0, DOUBLED, 0.0)
        table.lines.append(f"stars {star.name}: {number} arms of {SHORTEST:g} spacings or more in {star.seeds} runs, mean "
                           f"radius of curvature {radius:.3g} spacings; doubled along the border "
                           f"{100.0 * float(np.mean(shares)):.2g} % of the length, at most {100.0 * max(shares):.2g} %")
        if table.pictures is not None:
            draw_cracks(table.pictures / f"star_{star.name}.png", [drawn], (2.0 * star.middle, 2.0 * star.middle))
