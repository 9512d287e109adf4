"""Line plots, with PIL only."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

from PIL import Image, ImageDraw

from ..replacing import replacing
from .lettering import TEXT, draw_text

WIDTH, HEIGHT, LEFT, BELOW, ABOVE = 760, 480, 90, 60, 60
LEGEND, ROW = 190, 18  # width of the legend, and height of a line's name
SMALL = 12  # size of labels beside points
STEPS = 40  # points along a line that labels keep away from
GRID, PAPER = (222, 224, 226), (250, 250, 249)
# Distinguishable with colour vision deficiencies (Okabe and Ito 2008).
COLOURS = ((0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (86, 180, 233), (230, 159, 0))


@dataclass(frozen=True)
class Curve:
    """One line of a plot. Where `logarithmic`, both axes are, and only positive points are drawn. Curves of one
    `panel` share axes, which begin at zero where one curve asks for it. `half` is half the length of a point's error
    bar."""
    name: str
    x_label: str
    y_label: str
    x: list[float]
    y: list[float]
    logarithmic: bool = True
    half: list[float] = field(default_factory=list)
    panel: str = ""
    from_zero: bool = False


@dataclass(frozen=True)
class Line:
    """Points joined by a line; `half` gives half the length of each error bar. `dots` are not joined. `labels` are
    written beside the points."""
    name: str
    x: list[float]
    y: list[float]
    half: list[float] = field(default_factory=list)
    dots: list[tuple[float, float]] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Panel:
    """Lines over one pair of axes, with a legend where there are several."""
    name: str
    x_label: str
    y_label: str
    lines: list[Line]
    logarithmic: bool = False
    from_zero: bool = False  # shows small differences as small


def _ticks(low: float, high: float, logarithmic: bool) -> list[float]:
    if logarithmic:
        first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
        for bases in ((1,), (1, 2, 5), range(1, 10)):  # the fewest that give three
            ticks = [base * 10.0**e for e in range(first, last + 1) for base in bases]
            if sum(low <= t <= high for t in ticks) >= 3:
                break
    else:
        step = 10.0 ** math.floor(math.log10(max(high - low, 1e-300) / 2.0))
        ticks = [step * k for k in range(math.floor(low / step), math.ceil(high / step) + 1)]
    return [t for t in ticks if low <= t * (1 + 1e-9) and t <= high * (1 + 1e-9)]


def _good(values: tuple[float | None, ...], logarithmic: bool) -> bool:
    return all(v is not None and math.isfinite(v) and (not logarithmic or v > 0.0) for v in values)


def draw_panel(panel: Panel) -> Image.Image:
    """Draws one pair of axes; with fewer than two points, only its name."""
    image = Image.new("RGB", (WIDTH, HEIGHT), PAPER)
    draw = ImageDraw.Draw(image)
    log = panel.logarithmic
    above = max(ABOVE, 12 + ROW * len(panel.lines)) if len(panel.lines) > 1 else ABOVE  # names stand above the axes
    points = [p for line in panel.lines for p in [*zip(line.x, line.y), *line.dots] if _good(p, log)]
    draw_text(image, (10, 8), panel.name, 18)
    if len(set(points)) < 2:
        return image
    bars = [(x, y + sign * h) for line in panel.lines for x, y, h in zip(line.x, line.y, line.half) for sign in (-1, 1)]
    points += [p for p in bars if _good(p, log)]

    def scale(value: float) -> float:
        return math.log10(value) if log else float(value)

    spans = []
    for axis in (0, 1):
        values = [p[axis] for p in points]
        low, high = min(values), max(values)
        if panel.from_zero and not log:
            low, high = min(low, 0.0), max(high, 0.0)
        if log:
            low, high = low / 1.3, high * 1.3
        elif low == high:
            low, high = low - 1.0, high + 1.0
        spans.append((low, high))

    def place(x: float, y: float) -> tuple[float, float]:
        (x0, x1), (y0, y1) = spans
        return (LEFT + (scale(x) - scale(x0)) / (scale(x1) - scale(x0)) * (WIDTH - LEFT - 30),
                HEIGHT - BELOW - (scale(y) - scale(y0)) / (scale(y1) - scale(y0)) * (HEIGHT - BELOW - above))

    for x in _ticks(*spans[0], log):
        at = place(x, spans[1][0])
        draw.line([at, place(x, spans[1][1])], fill=GRID)
        draw_text(image, (round(at[0]) - 12, HEIGHT - BELOW + 6), f"{x:g}", 14)
    for y in _ticks(*spans[1], log):
        at = place(spans[0][0], y)
        draw.line([at, place(spans[0][1], y)], fill=GRID)
        draw_text(image, (10, round(at[1]) - 8), f"{y:.3g}", 14)
    draw_text(image, (WIDTH // 2, HEIGHT - 28), panel.x_label, 15)
    draw_text(image, (10, 34), panel.y_label, 15)
    for k, line in enumerate(panel.lines):
        colour = COLOURS[k % len(COLOURS)]
        pale = tuple((c + 2 * p) // 3 for c, p in zip(colour, PAPER))
        for x, y in (place(*p) for p in line.dots if _good(p, log)):
            draw.ellipse([x - 3, y - 3, x + 3, y + 3], fill=pale)
        for x, y, h in zip(line.x, line.y, line.half):
            if _good((x, y, h), False) and _good((x, y - h), log):
                (x0, low), (_, high) = place(x, y - h), place(x, y + h)
                draw.line([(x0, low), (x0, high)], fill=colour, width=2)
                for end in (low, high):
                    draw.line([(x0 - 5, end), (x0 + 5, end)], fill=colour, width=2)
        places = [place(*p) for p in zip(line.x, line.y) if _good(p, log)]
        draw.line(places, fill=colour, width=3)
        for x, y in places:
            draw.ellipse([x - 4, y - 4, x + 4, y + 4], fill=colour, outline=TEXT)
        if len(panel.lines) > 1:
            y = 6 + ROW * k
            draw.rectangle([WIDTH - LEGEND, y + 6, WIDTH - LEGEND + 14, y + 11], fill=colour)
            draw_text(image, (WIDTH - LEGEND + 20, y), line.name, 14)
    labels = [(place(x, y), label) for line in panel.lines for x, y, label in zip(line.x, line.y, line.labels)
              if _good((x, y), log)]
    if labels:
        _write_labels(image, labels, [place(*p) for p in points], [
            [place(*p) for p in zip(line.x, line.y) if _good(p, log)] for line in panel.lines])
    return image


Place = tuple[float, float]


def _write_labels(image: Image.Image, labels: list[tuple[Place, str]], points: list[Place], lines: list[list[Place]]) -> None:
    """Places each text near its point where there is room, away from points and lines, with a thin line to the point
    [pixels]."""
    along = [(a[0] + (b[0] - a[0]) * k / STEPS, a[1] + (b[1] - a[1]) * k / STEPS)
             for line in lines for a, b in zip(line, line[1:]) for k in range(STEPS)]
    taken = [(x - 4, y - 4, x + 4, y + 4) for x, y in points + along]
    draw = ImageDraw.Draw(image)
    for (x, y), text in labels:
        width = SMALL * 0.56 * len(text)  # approximately; the font is not known here
        spots = [(min(max(LEFT, x + dx), WIDTH - 8 - width), y + dy) for far in range(8, HEIGHT, SMALL + 3)
                 for dy in (-far - SMALL, far) for dx in (8, -8 - width)]
        spots = [s for s in spots if ABOVE <= s[1] <= HEIGHT - BELOW - SMALL] or [(LEFT, y)]
        boxes = [(a, b, a + width, b + SMALL) for a, b in spots]
        box = next((b for b in boxes if not any(_meet(b, t) for t in taken)), boxes[0])
        taken.append(box)
        draw.line([(x, y), (min(max(x, box[0]), box[2]), box[3] if box[3] < y else box[1])], fill=TEXT)
        draw_text(image, (round(box[0]), round(box[1])), text, SMALL)


def _meet(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def write_panels(panels: list[Panel], path: Path) -> None:
    """Draws all panels on one sheet, two in a row. Raises OSError."""
    columns = min(2, len(panels))
    rows = -(-len(panels) // columns)
    sheet = Image.new("RGB", (WIDTH * columns, HEIGHT * rows), PAPER)
    for i, panel in enumerate(panels):
        sheet.paste(draw_panel(panel), (WIDTH * (i % columns), HEIGHT * (i // columns)))
    with replacing(path) as part:
        sheet.save(part)


def write_plots(curves: list[Curve], path: Path) -> None:
    """Draws a panel for each curve, or for curves that share one. Raises OSError."""
    panels: dict[str, list[Curve]] = {}
    for c in curves:
        panels.setdefault(c.panel or c.name, []).append(c)
    write_panels([Panel(name, of[0].x_label, of[0].y_label, [Line(c.name, c.x, c.y, c.half) for c in of],
                        of[0].logarithmic, any(c.from_zero for c in of)) for name, of in panels.items()], path)
