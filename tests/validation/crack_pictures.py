"""Pictures of crack lines, in the parameters of their shell."""
from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.pictures.crack_lines import Graph, grown
from sunder_tools.pictures.plots import DOTS_PER_INCH, INK, NAME_SIZE, need_matplotlib
from sunder_tools.pictures.units import scale

EARLY_TO_LATE = "viridis"  # even in lightness, for colour-blind eyes and in grey too
CUT = "#999999"
FRAME = "#cccccc"
BAR = (1.0, 2.0, 5.0)  # lengths of a scale bar, times a power of ten


def draw_cracks(path: Path, rows: Sequence[Sequence[Graph | None]], extent: tuple[float, float], size: int = 200,
                names: Sequence[str] = ()) -> None:
    """Writes the picture that `figure_of` makes; says so where there is no matplotlib, since results count more. Raises
    OSError."""
    try:
        figure = figure_of(rows, extent, size, names)
    except CommandError as error:
        print(f"sunder: {path.name} is not drawn: {error}", file=sys.stderr, flush=True)
        return
    figure.savefig(path, metadata={"Software": None})
    print(f"picture          {path}", flush=True)


def figure_of(rows: Sequence[Sequence[Graph | None]], extent: tuple[float, float], size: int = 200,
              names: Sequence[str] = ()) -> Any:
    """Draws crack lines of many runs, each `size` pixels wide, with a list for each row, as a matplotlib Figure.

    Colours go from the first to the last growth of each run, cuts of time zero are grey. `extent` [m] is the size of the
    shell along u and v, `names` are those of the rows. None stands for a run without cracks. Raises CommandError where
    there is no matplotlib.
    """
    need_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure
    columns = max(map(len, rows))
    wide, high = extent[0] * columns, extent[1] * len(rows)
    figure = Figure(figsize=(size * columns / DOTS_PER_INCH + 1.6, size * high / wide * columns / DOTS_PER_INCH + 0.6),
                    dpi=DOTS_PER_INCH, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    lines, shares, cuts, frames = [], [], [], []
    for j, row in enumerate(rows):
        for i, graph in enumerate(row):
            corner = np.array([i * extent[0], (len(rows) - 1 - j) * extent[1]])
            frames.append(corner + np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]) * extent)
            if graph is None:
                continue
            new = grown(graph)
            cuts += list(graph.some(graph.born <= 0.0).ends + corner)
            lines += list(new.ends + corner)
            first, last = (float(new.born.min()), float(new.born.max())) if len(new) else (0.0, 0.0)
            shares += [(born - first) / (last - first) if last > first else 0.0 for born in new.born]
    axes.add_collection(LineCollection(frames, colors=FRAME, linewidths=0.8))
    axes.add_collection(LineCollection(cuts, colors=CUT, linewidths=1.2))
    axes.add_collection(LineCollection(lines, array=np.array(shares), cmap=EARLY_TO_LATE, clim=(0.0, 1.0), linewidths=1.2))
    axes.set_xlim(-0.01 * wide, 1.01 * wide)
    axes.set_ylim(-0.01 * high, 1.01 * high)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([(len(rows) - 0.5 - j) * extent[1] for j in range(len(names))], names, color=INK, fontsize=NAME_SIZE)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    bar = _length_of_bar(0.5 * extent[0])
    factor, unit = scale("m", [bar])
    axes.annotate("", (0.0, -0.06), (bar / (1.02 * wide), -0.06), xycoords="axes fraction", arrowprops={
        "arrowstyle": "|-|", "color": INK, "mutation_scale": 3, "shrinkA": 0, "shrinkB": 0})
    axes.annotate(f"{bar * factor:g} {unit}", (bar / (1.02 * wide), -0.06), xycoords="axes fraction", xytext=(6, 0),
                  textcoords="offset points", va="center", color=INK, fontsize=NAME_SIZE)
    told = figure.colorbar(ScalarMappable(cmap=EARLY_TO_LATE), ax=axes, ticks=[0.0, 1.0], shrink=min(1.0, 3 / len(rows)))
    told.ax.set_yticklabels(["first growth", "last growth"], fontsize=NAME_SIZE, color=INK)
    return figure


def _length_of_bar(most: float) -> float:
    """Returns the longest round length of at most `most` [m]."""
    ten = 10.0 ** np.floor(np.log10(most))
    return float(max(b * ten for b in BAR if b * ten <= most * (1 + 1e-9)))
