"""Line plots, with PIL only."""
from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from PIL import Image, ImageDraw

from .lettering import TEXT, draw_text

WIDTH, HEIGHT, LEFT, BELOW, ABOVE = 760, 460, 90, 60, 40
LINE, GRID, PAPER = (32, 104, 160), (222, 224, 226), (250, 250, 249)


@dataclass(frozen=True)
class Curve:
    """One line; both axes logarithmic where `logarithmic`, then only positive points are drawn."""
    name: str
    x_label: str
    y_label: str
    x: list[float]
    y: list[float]
    logarithmic: bool = True


def _ticks(low: float, high: float, logarithmic: bool) -> list[float]:
    if logarithmic:
        first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
        ticks = [base * 10.0**e for e in range(first, last + 1) for base in ((1, 2, 5) if last - first <= 2 else (1,))]
    else:
        step = 10.0 ** math.floor(math.log10(max(high - low, 1e-300) / 2.0))
        ticks = [step * k for k in range(math.floor(low / step), math.ceil(high / step) + 1)]
    return [t for t in ticks if low <= t * (1 + 1e-9) and t <= high * (1 + 1e-9)]


def _panel(curve: Curve) -> Image.Image:
    image = Image.new("RGB", (WIDTH, HEIGHT), PAPER)
    draw = ImageDraw.Draw(image)
    points = [(x, y) for x, y in zip(curve.x, curve.y)
              if x is not None and y is not None and math.isfinite(x) and math.isfinite(y) and (not curve.logarithmic or (x > 0.0 and y > 0.0))]
    draw_text(image, (LEFT, 10), curve.name, 18)
    if len(points) < 2:
        return image
    scale = math.log10 if curve.logarithmic else float
    spans = []
    for axis in (0, 1):
        values = [p[axis] for p in points]
        low, high = min(values), max(values)
        if curve.logarithmic:
            low, high = low / 1.3, high * 1.3
        elif low == high:
            low, high = low - 1.0, high + 1.0
        spans.append((low, high))

    def place(x: float, y: float) -> tuple[float, float]:
        (x0, x1), (y0, y1) = spans
        return (LEFT + (scale(x) - scale(x0)) / (scale(x1) - scale(x0)) * (WIDTH - LEFT - 30),
                HEIGHT - BELOW - (scale(y) - scale(y0)) / (scale(y1) - scale(y0)) * (HEIGHT - BELOW - ABOVE))

    for x in _ticks(*spans[0], curve.logarithmic):
        at = place(x, spans[1][0])
        draw.line([at, place(x, spans[1][1])], fill=GRID)
        draw_text(image, (round(at[0]) - 12, HEIGHT - BELOW + 6), f"{x:g}", 14)
    for y in _ticks(*spans[1], curve.logarithmic):
        at = place(spans[0][0], y)
        draw.line([at, place(spans[0][1], y)], fill=GRID)
        draw_text(image, (10, round(at[1]) - 8), f"{y:.3g}", 14)
    draw_text(image, (WIDTH // 2, HEIGHT - 28), curve.x_label, 15)
    draw_text(image, (WIDTH - 260, ABOVE - 8), curve.y_label, 15)
    places = [place(*p) for p in points]
    draw.line(places, fill=LINE, width=3)
    for x, y in places:
        draw.ellipse([x - 4, y - 4, x + 4, y + 4], fill=LINE, outline=TEXT)
    return image


def write_plots(curves: list[Curve], path: Path) -> None:
    """All curves on one sheet, two a row. Raises OSError."""
    columns = min(2, len(curves))
    rows = -(-len(curves) // columns)
    sheet = Image.new("RGB", (WIDTH * columns, HEIGHT * rows), PAPER)
    for i, curve in enumerate(curves):
        sheet.paste(_panel(curve), (WIDTH * (i % columns), HEIGHT * (i // columns)))
    sheet.save(path)
