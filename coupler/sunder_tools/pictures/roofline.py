"""Rates of stages under the limits of the machine: operations a second over operations a byte (Williams, Waterman and
Patterson 2009)."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..errors import CommandError
from ..report.profile import PROFILE_FILE, PROFILE_PICTURE, read_profile
from .plots import Line, Panel, write_panels

BESIDE = 8.0  # how far the roof goes to either side of the points [times]


@dataclass(frozen=True)
class Rate:
    """A stage or a kernel: operations a byte, and 1e9 operations a second; the memory's rate for it [GB/s]."""
    name: str
    intensity: float
    gflops: float
    gb_per_s: float


def roofs(peak_gflops: float, rates: list[Rate], name: str) -> Panel:
    """Returns a panel with a dot a rate, and a roof for each rate of memory, of arrays as large as those of its dots."""
    low, high = min(r.intensity for r in rates) / BESIDE, max(r.intensity for r in rates) * BESIDE
    lines = []
    for memory in sorted({r.gb_per_s for r in rates}):
        bend = peak_gflops / memory
        x = [low, bend, max(high, 2.0 * bend)] if bend > low else [low, high]
        lines.append(Line(f"{memory:.3g} GB/s", x, [min(peak_gflops, memory * at) for at in x]))
    for r in rates:
        lines.append(Line(r.name, [r.intensity], [r.gflops]))
    return Panel(name, "operations a byte", "1e9 operations a second", lines, logarithmic=True)


def write_profile(folder: Path) -> Path:
    """Draws profile.png of the profile.json in a run folder; returns it. Raises CommandError where there is none or no stage
    of it has a model, OSError."""
    profile = read_profile(folder)
    if profile is None:
        raise CommandError(f"{folder / PROFILE_FILE}: there is none, or it is damaged; run the scene with --profile")
    rates = [Rate(s.name, s.work.operations / s.work.bytes, 1e-9 * s.work.operations * s.work.passes / s.seconds,
                  s.work.gb_per_s) for s in profile.stages if s.work is not None and s.work.bytes > 0.0]
    if not rates:
        raise CommandError(f"{folder / PROFILE_FILE}: no stage has a model: no window with shells was run; "
                           "give a longer end_time_s")
    shares = [Line(s.name, [k + 1.0], [s.seconds]) for k, s in enumerate(sorted(profile.stages, key=lambda s: -s.seconds))]
    path = folder / PROFILE_PICTURE
    write_panels([roofs(profile.peak_gflops, rates, f"rates of stages, {profile.threads} thread{'s' * (profile.threads != 1)}"),
                  Panel("time of stages", "rank", "time [s]", shares, from_zero=True)], path)
    return path
