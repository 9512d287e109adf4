"""How far settings are from the reference, how far that can be told, and which of them are worth their cost."""
from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import Iterable, Mapping, Sequence

import numpy as np

from ..statistics import student

Runs = Mapping[int, Mapping[str, np.ndarray]]  # by seed: quantities of each run

WORTH = 0.03       # of the error: a change that takes less from it is not tried together with others
WORTH_TIME = 0.1   # of the cost, which is no more certain than that on a machine that does other things besides
MOST_TOGETHER = 4  # changes in a combination


@dataclass(frozen=True)
class Gap:
    """Of one quantity: relative error against the reference, and what of it is not told apart from none: half of the
    difference's 95 % confidence interval over seeds, or the reference's own error, whichever is larger."""
    error: float
    noise: float

    @property
    def resolved(self) -> bool:
        """Whether there is an error that scatter does not explain."""
        return self.error > self.noise


@dataclass(frozen=True)
class Judged:
    """A setting that has been run. Costs are means over its runs [s]."""
    label: str
    processor_s: float
    wall_s: float
    gaps: dict[str, Gap] = field(default_factory=dict)

    @property
    def error(self) -> float:
        """Root mean square of the quantities' relative errors."""
        return _rms([g.error for g in self.gaps.values()])

    @property
    def noise(self) -> float:
        """The same of what is not told apart from none."""
        return _rms([g.noise for g in self.gaps.values()])

    @property
    def height(self) -> float:
        """Where it stands in the comparison: what is below the noise is as good as the reference, as far as is known."""
        return max(self.error, self.noise)

    @property
    def resolved(self) -> bool:
        """Whether its error is more than scatter explains."""
        return self.error > self.noise


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(sum(v * v for v in values) / len(values)) if values else math.nan


def compared(runs: Runs, reference: Runs, name: str, chance: bool) -> tuple[float, float]:
    """Relative error of quantity `name` and half of its 95 % confidence interval, over the seeds that both have.

    Differences are taken seed by seed: where the strengths are the same in both, less of their scatter is left. Where
    chance plays no part one run is enough, and the interval is zero; with chance it takes two, and is infinite before.
    """
    seeds = [s for s in runs if s in reference and name in runs[s] and name in reference[s]]
    if not seeds:
        return math.nan, math.nan
    scale = float(np.linalg.norm(np.mean([reference[s][name] for s in seeds], axis=0)))
    difference = np.array([runs[s][name] - reference[s][name] for s in seeds])
    if scale == 0.0:
        return math.nan, math.nan
    error = float(np.linalg.norm(difference.mean(axis=0))) / scale
    n = len(seeds)
    if n < 2:
        return error, math.inf if chance else 0.0
    spread = difference.std(axis=0, ddof=1)
    return error, student(0.95, n - 1) * float(np.linalg.norm(spread)) / math.sqrt(n) / scale


def gaps(runs: Runs, reference: Runs, own: Mapping[str, float], chance: bool) -> dict[str, Gap]:
    """Of every quantity in `own`, the reference's own errors. Empty where a run lacks one: such settings are not judged."""
    out = {}
    for name, floor in own.items():
        error, half = compared(runs, reference, name, chance)
        if not math.isfinite(error):
            return {}
        out[name] = Gap(error, max(half, floor))
    return out


def own_errors(reference: Runs, next_finest: Runs) -> dict[str, float]:
    """Of each quantity that both have and that is not zero: the difference to the next finest runs. Where these are coarser
    by the root of two and convergence is of second order, that is the reference's error."""
    names = dict.fromkeys(name for run in reference.values() for name in run)
    found = {name: compared(next_finest, reference, name, False)[0] for name in names}
    return {name: error for name, error in found.items() if math.isfinite(error)}


def front(judged: Sequence[Judged], at_least: Mapping[str, float] | None = None) -> list[Judged]:
    """Those that no other beats in cost without being worse in error, cheapest first. What is within the noise of the
    reference counts as equally good. `at_least`: errors by label, below which a setting is not believed."""
    def height(one: Judged) -> float:
        return max(one.height, (at_least or {}).get(one.label, 0.0))

    out: list[Judged] = []
    for one in sorted((j for j in judged if j.gaps), key=lambda j: (j.processor_s, height(j))):
        if not out or height(one) < height(out[-1]) * (1.0 - 1e-9):
            out.append(one)
    return out


def fronts(judged: Sequence[Judged], at_least: Mapping[str, float] | None = None) -> tuple[list[Judged], list[Judged]]:
    """The front of those whose error is known, and that of those of which only a bound is, cheapest first.

    A bound takes others off the first front, since its error is no larger. Nothing takes a bound off but another bound: its
    error may be far below.
    """
    return ([one for one in front(judged, at_least) if one.resolved],
            front([one for one in judged if not one.resolved], at_least))


def alike(runs: Runs, own: Runs, names: Iterable[str], chance: bool) -> bool:
    """Whether scatter explains, of each quantity, what is between two settings, or there is nothing between them."""
    found = gaps(runs, own, dict.fromkeys(names, 0.0), chance)
    return bool(found) and not any(gap.resolved for gap in found.values())


def combinations(own: Judged, single: Mapping[str, Judged], knob_of: Mapping[str, str],
                 exclusive: Sequence[frozenset[str]] = (), converging: Iterable[str] | None = None) -> list[tuple[str, ...]]:
    """Labels of single changes that may be worth more together, best guess of a front, cheapest first.

    Guessed: costs as factors, squared errors as sums of what each change adds to the scene's own or takes from it. Of one
    knob there is one change at most, and of each set in `exclusive`; changes that neither gain time nor error are left out.
    A knob that is not `converging` (None: all are) takes nothing from the error: where it seems to, it is by luck.
    """
    if not own.gaps or own.processor_s <= 0.0:
        return []
    floor = own.noise

    def effect(one: Judged) -> tuple[float, float]:
        added = max(one.error, floor) ** 2 - max(own.error, floor) ** 2
        lucky = converging is not None and knob_of[one.label] not in converging
        return one.processor_s / own.processor_s, max(added, 0.0) if lucky else added

    gain = ((1.0 - WORTH) ** 2 - 1.0) * max(own.error, floor) ** 2  # of the squared error
    useful = {label: effect(one) for label, one in single.items() if one.gaps}
    useful = {label: e for label, e in useful.items() if e[0] < 1.0 - WORTH_TIME or e[1] < gain}
    # A change that costs more and errs more than another one of its knob is beaten by it.
    useful = {label: e for label, e in useful.items() if not any(
        o != label and knob_of[o] == knob_of[label] and f[0] <= e[0] and f[1] <= e[1] and f != e
        for o, f in useful.items())}
    guessed: list[tuple[float, float, tuple[str, ...]]] = []
    for size in range(1, MOST_TOGETHER + 1):
        for labels in itertools.combinations(useful, size):
            knobs = [knob_of[label] for label in labels]
            if len(set(knobs)) < size or any(len(e & set(knobs)) > 1 for e in exclusive):
                continue
            cost = own.processor_s * math.prod(useful[label][0] for label in labels)
            square = max(own.error, floor) ** 2 + sum(useful[label][1] for label in labels)
            guessed.append((cost, math.sqrt(max(square, floor ** 2)), labels))
    out: list[tuple[str, ...]] = []
    best = math.inf
    for cost, error, labels in sorted(guessed):
        if error < best * (1.0 - 1e-9):
            best = error
            if len(labels) > 1:
                out.append(labels)
    return out
