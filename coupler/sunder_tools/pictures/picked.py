"""`--frames`: frames of a run by number or by time."""
from __future__ import annotations

import re
from math import floor, log10
from typing import Sequence

import numpy as np

from ..errors import CommandError
from .frames import Frame

UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "\u00b5s": 1e-6, "\u03bcs": 1e-6}  # the second mu is the Greek letter
_END = r"last|[0-9]+|(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?\s*(?:" + "|".join(UNITS) + ")"
_WORD = re.compile(f"({_END})(?:-({_END}))?", re.ASCII)
_TIME = re.compile(r"(.*?)\s*([^0-9.\s]+)")
NEAR = 1e-6   # of the length of the run: times are equal that differ by less
DIGITS = 3    # of times in captions: a time may be off by half of the last one


def pick(spec: str, frames: Sequence[Frame]) -> list[int]:
    """Reads which frames: 'all', or a list such as '0,5,10-20,7.5ms,10ms-20ms,last'. Raises CommandError.

    A time is that of the nearest frame; from one time to another are the frames between, with both ends.
    """
    if not frames:
        raise CommandError(f"--frames {spec}: the run has no frame")
    count, found = len(frames), set[int]()
    times = np.array([frame.time_s for frame in frames])
    for word in (part.strip() for part in spec.split(",")):
        match = _WORD.fullmatch("0-last" if word == "all" else word)
        if match is None:
            raise CommandError(f"--frames {spec}: '{word}' is no frame; give e.g. all, 12, 0,5,last or 10-20, or times as "
                               "7.5ms or 10ms-20ms")
        ends = [end for end in match.groups() if end is not None]
        if all(end == "last" or end.isdigit() for end in ends):
            numbers = [count - 1 if end == "last" else int(end) for end in ends]
            if max(numbers) >= count or numbers[0] > numbers[-1]:
                raise CommandError(f"--frames {spec}: '{word}' is not among the frames 0 to {count - 1}")
            found |= set(range(numbers[0], numbers[-1] + 1))
            continue
        found |= set(_at_times(spec, word, ends, times, frames[0].step))
    return sorted(found)


def _at_times(spec: str, word: str, ends: list[str], times: np.ndarray, steps: bool) -> list[int]:
    """Returns the frames of a word with a time in it."""
    if steps:
        raise CommandError(f"--frames {spec}: '{word}' has a time, and the frames are load steps; give numbers, 0 to {len(times) - 1}")
    told = []
    for end in ends:
        parts = _TIME.fullmatch(end) if end != "last" else None
        if parts is None and end != "last":
            raise CommandError(f"--frames {spec}: '{word}' mixes a number and a time; give two times, as 10ms-20ms, or two numbers")
        told.append(float(times[-1]) if parts is None else float(parts[1]) * UNITS[parts[2]])
    near = NEAR * float(times[-1] - times[0])
    slack = [max(near, _half_a_digit(time)) for time in told]
    if told[0] > told[-1] or told[-1] > times[-1] + slack[-1] or told[0] < times[0] - slack[0]:
        raise CommandError(f"--frames {spec}: '{word}' is not within the run's frames, {times[0]:g} to {times[-1]:g} s")
    if len(told) == 1:
        return [int(np.argmin(np.abs(times - told[0])))]
    between = np.flatnonzero((times >= told[0] - slack[0]) & (times <= told[1] + slack[1]))
    if not len(between):
        after = int(np.searchsorted(times, told[0]))
        raise CommandError(f"--frames {spec}: no frame is within {word}; the nearest are {times[after - 1]:g} and {times[after]:g} s")
    return [int(k) for k in between]


def _half_a_digit(time: float) -> float:
    """What a caption may be off by."""
    return 0.5 * 10.0 ** (floor(log10(time)) + 1 - DIGITS) if time > 0.0 else 0.0
