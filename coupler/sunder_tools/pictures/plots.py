"""Line plots by matplotlib, which is installed with the first one."""
from __future__ import annotations

import importlib
import importlib.util
import math
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import CommandError
from ..launch.install import PLOT_PACKAGES, ensure_installed
from ..places import BUILD_DIR_VARIABLE, work_folder
from ..replacing import replacing
from .units import label, scale, words_and_unit

SIZE_INCH, DOTS_PER_INCH = (7.6, 4.8), 100
UNTOLD = {".png": "Software", ".svg": "Date", ".pdf": "CreationDate"}  # what differs between two files of one plot
ENDINGS = tuple(UNTOLD)
INK, GRID, PAPER = "#262e36", "#dee0e2", "#fafaf9"
# Distinguishable with colour vision deficiencies (Okabe and Ito 2008); markers tell lines apart without colours.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
MARKERS = "osD^vP"
BESIDE = 5.0   # [points] between error bars at the same place, so that none hides another
ARROW = 16.0   # [points] length of an arrow down from an upper bound
NAME_SIZE = 9  # [points] of names beside lines and of labels


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
    """Points, joined by a line where `joined`; `half` gives half the length of each error bar. `dots` are not joined.
    `labels` are written beside the points. Points where `hollow` is true, and `hollow_dots`, are not filled. Points where
    `bound` is true are upper bounds, and arrows that point down."""
    name: str
    x: list[float]
    y: list[float]
    half: list[float] = field(default_factory=list)
    dots: list[tuple[float, float]] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    hollow: list[bool] = field(default_factory=list)
    hollow_dots: list[tuple[float, float]] = field(default_factory=list)
    bound: list[bool] = field(default_factory=list)
    joined: bool = True
    size: float = 5.0  # [points] of markers
    colour: str = ""   # '' takes the next one


@dataclass(frozen=True)
class Panel:
    """Lines over one pair of axes. Labels are 'words [unit]' or names of columns, such as 'impulse_N_s'."""
    name: str
    x_label: str
    y_label: str
    lines: list[Line]
    logarithmic: bool = False
    from_zero: bool = False  # shows small differences as small
    bars: str = ""           # what error bars are, below the words of the upright axis
    least: float | None = None  # where error bars end: the quantity cannot be less
    hollow: str = ""            # what hollow markers are, for the legend


def there() -> bool:
    """Tells whether matplotlib can be imported."""
    return importlib.util.find_spec("matplotlib") is not None


def need_matplotlib() -> None:
    """Installs matplotlib where it is missing. Raises CommandError that says what to install."""
    if there():
        return
    remedy = f"as root run: apt-get install -y --no-install-recommends {' '.join(PLOT_PACKAGES)}"
    if os.environ.get(BUILD_DIR_VARIABLE):
        raise CommandError(f"there is no matplotlib, and {BUILD_DIR_VARIABLE} is set: nothing is installed then; {remedy}")
    try:
        work_folder().mkdir(parents=True, exist_ok=True)
        ensure_installed(work_folder() / "install.log", PLOT_PACKAGES)
    except OSError as error:
        raise CommandError(f"there is no matplotlib, and {work_folder()} cannot be written to ({error.strerror}); {remedy}") from None
    importlib.invalidate_caches()
    if not there():
        raise CommandError(f"{' '.join(PLOT_PACKAGES)} is installed, but not for this Python; run coupler/sunder, which takes "
                           "/usr/bin/python3, or install matplotlib here")


def draw(panels: list[Panel]) -> Any:
    """Returns a matplotlib Figure with a panel beside another, two in a row. Raises CommandError."""
    need_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    columns = min(2, len(panels)) or 1
    rows = -(-len(panels) // columns) or 1
    figure = Figure(figsize=(SIZE_INCH[0] * columns, SIZE_INCH[1] * rows), dpi=DOTS_PER_INCH, facecolor=PAPER,
                    layout="constrained")
    FigureCanvasAgg(figure)
    axes = [figure.add_subplot(rows, columns, k + 1) for k in range(len(panels))]
    texts = [_draw_panel(one, panel) for one, panel in zip(axes, panels)]
    figure.canvas.draw()  # names and labels are placed by what stands where
    for one, text in zip(axes, texts):
        _name_lines(figure, one, text.names)
    figure.canvas.draw()
    for one, text in zip(axes, texts):
        _write_labels(figure, one, text.labels)
    return figure


def write_panels(panels: list[Panel], path: Path) -> None:
    """Draws all panels on one sheet. Raises CommandError where there is no matplotlib, OSError."""
    figure = draw(panels)
    from matplotlib import rc_context
    with replacing(path) as part, rc_context({"svg.hashsalt": "sunder"}):  # the same plot has the same bytes
        figure.savefig(part, facecolor=PAPER, metadata={UNTOLD[path.suffix]: None})


def write_plots(curves: list[Curve], path: Path) -> None:
    """Draws a panel for each curve, or for curves that share one. Raises CommandError, OSError."""
    panels: dict[str, list[Curve]] = {}
    for c in curves:
        panels.setdefault(c.panel or c.name, []).append(c)
    write_panels([Panel(name, of[0].x_label, of[0].y_label, [Line(c.name, c.x, c.y, c.half) for c in of],
                        of[0].logarithmic, any(c.from_zero for c in of)) for name, of in panels.items()], path)


def _good(x: float | None, y: float | None, logarithmic: bool) -> bool:
    return all(v is not None and math.isfinite(v) and (not logarithmic or v > 0.0) for v in (x, y))


def _down(y: float, half: float, least: float | None) -> float:
    """Returns how far an error bar reaches down; NaN where there is none."""
    return half if least is None or not half > y - least else max(y - least, 0.0)


@dataclass
class _Texts:
    """Texts with the places where they belong, in the units of the axes."""
    names: list[tuple[float, float, str, str]] = field(default_factory=list)  # of lines, each with its colour
    labels: list[tuple[float, float, str]] = field(default_factory=list)      # of points


def _draw_panel(axes: Any, panel: Panel) -> _Texts:
    """Draws everything but texts beside lines and points, which it returns."""
    from matplotlib.transforms import ScaledTranslation
    log = panel.logarithmic
    axes.set_facecolor(PAPER)
    axes.set_title(panel.name, loc="left", color=INK, fontsize=12)
    points = [p for line in panel.lines for p in [*zip(line.x, line.y), *line.dots, *line.hollow_dots] if _good(*p, log)]
    if not points:
        axes.set_axis_off()
        return _Texts()
    ends = [(x, end) for line in panel.lines for x, y, h in zip(line.x, line.y, line.half)
            for end in (y - _down(y, h, panel.least), y + h)]
    everything = points + [p for p in ends if _good(*p, log)]
    factors = []
    for axis, name in ((0, panel.x_label), (1, panel.y_label)):
        words, unit = words_and_unit(name)
        factor, unit = (1.0, unit) if log else scale(unit, [p[axis] for p in everything])
        text = label(words, unit) + (f"\n{panel.bars}" if axis and panel.bars else "")
        (axes.set_ylabel if axis else axes.set_xlabel)(text, color=INK)
        factors.append(factor)
    if log:
        axes.set_xscale("log")
        axes.set_yscale("log")
        _plain_numbers(axes)
    _set_limits(axes, [(x * factors[0], y * factors[1]) for x, y in everything], panel)
    barred = [line for line in panel.lines if line.joined and any(math.isfinite(h) for h in line.half)]
    for k, line in enumerate(panel.lines):
        style = {"color": line.colour or COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)]}
        where = axes.transData
        if line in barred:
            beside = (barred.index(line) - 0.5 * (len(barred) - 1)) * BESIDE / 72.0
            where = where + ScaledTranslation(beside, 0.0, axes.figure.dpi_scale_trans)
        _draw_line(axes, line, panel, factors, {**style, "transform": where})
    if panel.hollow and any(line.hollow_dots or any(line.hollow) for line in panel.lines):
        axes.plot([], [], linestyle="", marker="o", markersize=5, color=INK, markerfacecolor="none", label=panel.hollow)
    axes.grid(color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.tick_params(which="both", colors=INK)
    if not log:
        axes.ticklabel_format(useOffset=False)
        if all(float(x).is_integer() for x, _ in points) and factors[0] == 1.0:  # seeds, numbers of things
            axes.xaxis.get_major_locator().set_params(integer=True)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, fontsize=NAME_SIZE, labelcolor=INK)
    named = [(k, line) for k, line in enumerate(panel.lines) if line.name and len(panel.lines) > 1 and line.x and line.joined]
    return _Texts([(line.x[-1] * factors[0], line.y[-1] * factors[1], line.name, COLOURS[k % len(COLOURS)])
                   for k, line in named if _good(line.x[-1], line.y[-1], log)],
                  [(x * factors[0], y * factors[1], text) for line in panel.lines
                   for x, y, text in zip(line.x, line.y, line.labels) if text and _good(x, y, log)])


def _plain_numbers(axes: Any) -> None:
    """Writes 0.4 beside logarithmic axes, not a power of ten, and between powers too where they are few."""
    from matplotlib.ticker import LogFormatter

    class Plain(LogFormatter):  # type: ignore[misc]
        def __call__(self, x: float, pos: int | None = None) -> str:
            return f"{x:g}" if super().__call__(x, pos) else ""

    for ticks in (axes.xaxis, axes.yaxis):
        ticks.set_major_formatter(Plain())
        ticks.set_minor_formatter(Plain(minor_thresholds=(2, 0.5)))


def _draw_line(axes: Any, line: Line, panel: Panel, factors: list[float], style: dict[str, Any]) -> None:
    """Draws dots, points, error bars and bounds of one line."""
    log = panel.logarithmic
    alone = line.name if line.name and not (line.x and line.joined) else "_"  # in the legend; else it has its name beside it
    for dots, look in ((line.dots, {"alpha": 0.35, "markeredgewidth": 0}), (line.hollow_dots, {"alpha": 0.6, "markerfacecolor": "none"})):
        some = [(x * factors[0], y * factors[1]) for x, y in dots if _good(x, y, log)]
        if some:
            axes.plot(*zip(*some), linestyle="", markersize=line.size, **look, **style, label="_" if line.x else alone)
    count = len(line.x)
    halves = [*line.half, *[math.nan] * (count - len(line.half))]
    marks = zip([*line.hollow, *[False] * (count - len(line.hollow))], [*line.bound, *[False] * (count - len(line.bound))])
    kept = [(x * factors[0], y * factors[1], _down(y, h, panel.least) * factors[1], h * factors[1], hollow, bound)
            for x, y, h, (hollow, bound) in zip(line.x, line.y, halves, marks) if _good(x, y, log)]
    if not kept:
        return
    plain = line.joined and not any(k[4] or k[5] for k in kept)
    if line.joined and not plain:
        axes.plot([k[0] for k in kept], [k[1] for k in kept], linewidth=1.8, **{**style, "marker": ""})
    looks: tuple[tuple[bool, dict[str, str]], ...] = ((False, {}), (True, {"markerfacecolor": PAPER}))
    for hollow, filled in looks:
        some = [k[:2] for k in kept if k[4] == hollow and not k[5]]
        if some:
            axes.plot(*zip(*some), linestyle="-" if plain else "", linewidth=1.8, markersize=line.size, **filled, **style, label=alone)
            alone = "_"
    bars = [(a, b, min(low, 0.999999 * b) if log else low, h) for a, b, low, h, _, bound in kept if math.isfinite(h) and not bound]
    if bars:
        at, middle, down, up = zip(*bars)
        axes.errorbar(at, middle, [down, up], fmt="none", ecolor=style["color"], elinewidth=1.2, capsize=3, transform=style["transform"])
    for x, y, _, _, _, bound in kept:
        if bound:
            axes.annotate("", (x, y), xytext=(0, -ARROW), textcoords="offset points",
                          arrowprops={"arrowstyle": "<|-", "color": style["color"], "shrinkA": 0, "shrinkB": 0})
    if tops := [k[:2] for k in kept if k[5]]:
        axes.plot(*zip(*tops), linestyle="", markersize=line.size + 3, markeredgewidth=1.6, **{**style, "marker": "_"}, label=alone)


def _set_limits(axes: Any, points: list[tuple[float, float]], panel: Panel) -> None:
    for axis, put in ((0, axes.set_xlim), (1, axes.set_ylim)):
        low, high = min(p[axis] for p in points), max(p[axis] for p in points)
        if panel.logarithmic:
            put(low / 1.3, high * 1.3)
            continue
        if panel.from_zero:
            low, high = min(low, 0.0), max(high, 0.0)
        margin = 0.06 * (high - low) or 0.5 * abs(high) or 1.0
        put(low if panel.from_zero and low == 0.0 else low - margin, high + margin)


def _name_lines(figure: Any, axes: Any, names: list[tuple[float, float, str, str]]) -> None:
    """Writes the name of each line at its right end, in its colour, none over another."""
    apart = 1.25 * NAME_SIZE * figure.dpi / 72.0  # [pixels]
    ends = sorted((axes.transData.transform((x, y))[1], x, name, colour) for x, y, name, colour in names)
    heights = [end[0] for end in ends]
    for _ in range(200):  # pushes neighbours apart until none is too near
        moved = False
        for k in range(len(heights) - 1):
            lack = apart - (heights[k + 1] - heights[k])
            if lack > 1e-6:
                heights[k] -= 0.5 * lack
                heights[k + 1] += 0.5 * lack
                moved = True
        if not moved:
            break
    for height, (_, _, name, colour) in zip(heights, ends):
        share = axes.transAxes.inverted().transform((0.0, height))[1]
        axes.annotate(name, (1.0, share), xycoords="axes fraction", xytext=(6, 0), textcoords="offset points", va="center",
                      color=colour, fontsize=NAME_SIZE, annotation_clip=False)


def _write_labels(figure: Any, axes: Any, labels: list[tuple[float, float, str]]) -> None:
    """Places each text near its point where there is room, away from points, lines and texts."""
    renderer = figure.canvas.get_renderer()
    taken: list[tuple[float, float, float, float]] = []
    for line in axes.lines:
        path = line.get_transform().transform(line.get_xydata())
        taken += [(x - 3, y - 3, x + 3, y + 3) for x, y in path]
        if line.get_linestyle() not in ("None", ""):
            taken += [(a[0] + s * (b[0] - a[0]) - 1, a[1] + s * (b[1] - a[1]) - 1, a[0] + s * (b[0] - a[0]) + 1,
                       a[1] + s * (b[1] - a[1]) + 1) for a, b in zip(path, path[1:]) for s in [k / 40 for k in range(41)]]
    frame = axes.get_window_extent(renderer)
    for x, y, text in labels:
        note = axes.annotate(text, (x, y), xytext=(0, 0), textcoords="offset points", fontsize=NAME_SIZE, color=INK,
                             arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.6, "shrinkA": 0, "shrinkB": 3})
        best = None
        for far in range(8, 160, 10):
            for dx, dy, across, up in ((6, far, "left", "bottom"), (6, -far, "left", "top"), (-6, far, "right", "bottom"),
                                       (-6, -far, "right", "top")):
                note.set_position((dx, dy))
                note.set_ha(across)
                note.set_va(up)
                at = _box_of_text(note, renderer)
                inside = at[0] >= frame.x0 and at[2] <= frame.x1 and at[1] >= frame.y0 and at[3] <= frame.y1
                if inside and not any(at[0] < t[2] and t[0] < at[2] and at[1] < t[3] and t[1] < at[3] for t in taken):
                    best = at
                    break
            if best is not None:
                break
        taken.append(best if best is not None else _box_of_text(note, renderer))


def _box_of_text(note: Any, renderer: Any) -> tuple[float, float, float, float]:
    """Returns where the text alone is [pixels], without its line."""
    from matplotlib.text import Text
    note.update_positions(renderer)
    box = Text.get_window_extent(note, renderer)
    return box.x0, box.y0, box.x1, box.y1
