"""Whether a film lets one see cracks grow: it is told where they do within a few pictures."""
from __future__ import annotations

import sys
from math import floor, log10
from pathlib import Path
from typing import Callable

import numpy as np

from ..report.columns import read_columns
from .between import FPS, MOST_FRAMES
from .frames import Frame

MOST_OF_IT = 0.9  # share of the length of cracks that counts as their growth: single late edges would stretch it
FEW, ENOUGH = 12, 24  # pictures in which cracks grow: below the first a note is due, the second is what it offers

LONG = 480  # pictures of a film, 20 s: of a longer one the note names the part in which cracks grow

Spelling = Callable[[str, str], str]  # an option by name and value, as the reader writes it


def as_option(name: str, value: str) -> str:
    """As on the command line."""
    return f"--{name} {value}"


def as_argument(name: str, value: str) -> str:
    """As in a call of Python."""
    return f'{name}="{value}"' if name == "frames" else f"{name}={value}"


def growth(folder: Path) -> tuple[float, float] | None:
    """Returns when cracks begin to grow and when MOST_OF_IT of their length is there [s]; None where none grow."""
    series = read_columns(folder / "series.csv")
    time, length = series.get("time [s]", np.zeros(0)), series.get("cracks [m]", np.zeros(0))
    if not len(time) or not length[-1] > 0.0:
        return None
    windows = np.append(0.0, time)  # a row has the end of a window
    return float(windows[np.argmax(length > 0.0)]), float(time[np.argmax(length >= MOST_OF_IT * length[-1])])


def pace_note(folder: Path, frames: list[Frame], fps: float | None, speed: float | None, some: bool = True,
              spell: Spelling = as_option) -> str:
    """Returns a note where cracks grow within FEW pictures of the film of these frames, '' where they take more or none grow.

    The note has a speed that spreads them over ENOUGH pictures. Where the whole run is too long for it, `frames` goes with it, and
    where it is long, `frames` is told beside; `some` says whether they may go together.
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
    last = int(np.searchsorted(times, end))
    first = max(int(np.searchsorted(times, begin, "right")) - 1, 0)
    part = spell("frames", f"{first}-{last}")
    remedy = f"{spell('speed', f'{slow:.2g}')} spreads that over {ENOUGH} pictures, and the film has {length:.0f}"
    if length >= MOST_FRAMES:
        if not some:
            return ""
        remedy = f"{spell('speed', f'{slow:.2g}')} with {part} shows that in {ENOUGH} pictures or more"
    elif some and length > LONG:
        remedy += f", or {(times[last] - times[first]) * rate / slow:.0f} with {part}"
    few = "" if held >= FEW else (f". Cracks change from frame to frame of the run, and it has {held} of that time: "
                                  f"output {{ shell_frame_interval_s: {_rounded_down((end - begin) / ENOUGH):.2g} }} in its scene "
                                  "gives more")
    return (f"cracks grow within {_count(pictures)} of the film, from {begin:.3g} s to {end:.3g} s of the run; {remedy}{few}")


def fast_note(speed: float | None, spell: Spelling = as_option) -> str:
    """Returns a note on a film that is faster than life: a rate, or how many times slower, may have been meant."""
    if speed is None or speed <= 1.0:
        return ""
    return (f"{spell('speed', f'{speed:g}')} shows {speed:g} s of the run in a second; "
            f"{spell('speed', f'{1.0 / speed:.2g}')} is {speed:g} times slower than life")


def tell_pace(folder: Path, frames: list[Frame], fps: float | None, speed: float | None, some: bool = True,
              spell: Spelling = as_option) -> list[str]:
    """Prints the notes on standard error, where any is due, and returns them."""
    notes = [note for note in (fast_note(speed, spell), pace_note(folder, frames, fps, speed, some, spell)) if note]
    for note in notes:
        print(f"sunder: note: {note}", file=sys.stderr, flush=True)
    return notes


def _rounded_down(value: float) -> float:
    """Returns the next number of two digits that is no larger; value > 0."""
    step = 10.0 ** (floor(log10(value)) - 1)
    return float(f"{floor(value / step + 1e-9) * step:.2g}")


def _count(pictures: float) -> str:
    return "one picture" if pictures <= 1.0 else f"{pictures:.2g} pictures" if pictures < 10.0 else f"{pictures:.0f} pictures"
