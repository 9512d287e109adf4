"""Pictures of crack lines, in the parameters of their shell."""
from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from sunder_tools.pictures.crack_lines import Graph


def draw_cracks(path: Path, rows: Sequence[Sequence[Graph | None]], extent: tuple[float, float], size: int = 200) -> None:
    """Draws crack lines of many runs, each `size` pixels wide, with a list for each row. Early lines are blue, late
    ones red, cuts of time zero grey. `extent` [m] is the size of the shell along u and v. None stands for a run
    without cracks."""
    from PIL import Image, ImageDraw
    scale = size / extent[0]
    height = round(extent[1] * scale)
    image = Image.new("RGB", (size * max(map(len, rows)), height * len(rows)), "white")
    draw = ImageDraw.Draw(image)
    for j, row in enumerate(rows):
        for i, graph in enumerate(row):
            draw.rectangle([i * size, j * height, (i + 1) * size, (j + 1) * height], outline="#cccccc")
            if graph is None:
                continue
            first, last = float(graph.born[graph.born > 0.0].min(initial=math.inf)), float(graph.born.max())
            for ends, born in zip(graph.ends, graph.born):
                at = [(i * size + u * scale, (j + 1) * height - v * scale) for u, v in ends]
                late = (born - first) / (last - first) if last > first else 0.0
                draw.line(at, fill=(int(255 * late), 0, int(255 * (1.0 - late))) if born > 0.0 else "#999999")
    image.save(path)
    print(f"picture          {path}", flush=True)
