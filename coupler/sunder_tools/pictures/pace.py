"""Whether a film lets one see cracks grow: it is told where they do within a few pictures."""
from __future__ import annotations

import sys
from math import floor, log10
from pathlib import Path

import numpy as np

from ..report.columns import read_columns
from .between import FPS, MOST_FRAMES
from .frames import Frame

MOST_OF_IT = 0.9  # share of the length of cracks that counts as their growth: single late edges would stretch it
FEW, ENOUGH = 12, 24  # pictures in which cracks grow: below the first a note is due, the second is what it offers


def growth(folder: Path) -> tuple[float, float] | None:
    """Returns when cracks begin to grow and when MOST_OF_IT of their length is there [s]; None where none grow."""
    series = read_columns(folder / "series.csv")
    time, length = series.get("time [s]", np.zeros(0)), series.get("cracks [m]", np.zeros(0))
    if not len(time) or not length[-1] > 0.0:
        return None
    windows = np.append(0.0, time)  # a row has the end of a window
    return float(windows[np.argmax(length > 0.0)]), float(time[np.argmax(length >= MOST_OF_IT * length[-1])])


def pace_note(folder: Path, frames: list[Frame], fps: float | None, speed: float | None, some: bool = True) -> str:
    """Returns a note where cracks grow within FEW pictures of the film of these frames, '' where they take more or none grow.

    The note has a --speed that spreads them over ENOUGH pictures. Where the whole run is too long for it, --frames goes with it;
    `some` says whether they may go together.
    """
    grown = growth(folder)
    if grown is None or len(frames) < 2 or frames[0].step:
        return ""
    times, rate = np.array([frame.time_s for frame in frames]), fps or FPS
    begin, end = max(grown[0], times[0]), min(grown[1], times[-1])
    if not begin < end:
        return ""
    held = int(((times > begin) & (times <= end)).sum())  # frames of the run that show growth
    pictures = held if speed is None else (end - begin) * rate / speed
    if pictures >= FEW:
        return ""
    slow = _rounded_down((end - begin) * rate / ENOUGH)
    length = (times[-1] - times[0]) * rate / slow
    remedy = f"--speed {slow:.2g} spreads that over {ENOUGH} pictures, and the film has {length:.0f}"
    if length >= MOST_FRAMES:
        if not some:
            return ""
        last = int(np.searchsorted(times, end))
        first = max(int(np.searchsorted(times, begin, "right")) - 1, 0)
        remedy = f"--speed {slow:.2g} --frames {first}-{last} shows that in {ENOUGH} pictures or more"
    few = "" if held >= FEW else (f". Cracks change from frame to frame of the run, and it has {held} of that time: "
                                  f"output {{ shell_frame_interval_s: {_rounded_down((end - begin) / ENOUGH):.2g} }} in its scene "
                                  "gives more")
    return (f"cracks grow within {_count(pictures)} of the film, from {begin:.3g} s to {end:.3g} s of the run; {remedy}{few}")


def tell_pace(folder: Path, frames: list[Frame], fps: float | None, speed: float | None, some: bool = True) -> None:
    """Prints the note on standard error, where one is due."""
    note = pace_note(folder, frames, fps, speed, some)
    if note:
        print(f"sunder: note: {note}", file=sys.stderr, flush=True)


def _rounded_down(value: float) -> float:
    """Returns the next number of two digits that is no larger; value > 0."""
    step = 10.0 ** (floor(log10(value)) - 1)
    return float(f"{floor(value / step + 1e-9) * step:.2g}")


def _count(pictures: float) -> str:
    return "one picture" if pictures <= 1.0 else f"{pictures:.2g} pictures" if pictures < 10.0 else f"{pictures:.0f} pictures"
