"""Measures of crack patterns, and statistics of several of them. Pure functions of arrays."""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sunder_lab.statistics import beta_share, student

RESAMPLED = 4000  # resamples for a bound: its own scatter is then a percent


def lengths(ends: np.ndarray) -> np.ndarray:
    """Returns the total length [m] of edges (n, 2, 2)."""
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)


def harmonic(ends: np.ndarray, order: int = 4, turn: float = 0.0) -> complex:
    """Returns the mean of exp(i order phi), weighted by the length of edges (n, 2, 2). phi is an edge's angle plus
    `turn` [rad].

    An even order knows no sense of an edge. Order 4 is 1 for edges along either axis, -1 for edges along either
    diagonal, 0 on the mean for edges that know nothing of the axes.
    """
    along = ends[:, 1] - ends[:, 0]
    weight = np.linalg.norm(along, axis=1)
    if weight.sum() == 0.0:
        return complex(math.nan, math.nan)
    phi = np.arctan2(along[:, 1], along[:, 0]) + turn
    return complex((weight * np.exp(1j * order * phi)).sum() / weight.sum())


def off_circle(ends: np.ndarray, centre: np.ndarray, radius: float, margin: float) -> np.ndarray:
    """Selects edges (n, 2, 2) with their middle inside a circle by more than `margin` [m]; so the circle's own edges
    are left out."""
    return np.linalg.norm(ends.mean(axis=1) - centre, axis=1) < radius - margin


def anova(groups: list[np.ndarray]) -> tuple[float, float]:
    """Computes a one-way analysis of variance: F, and the probability of such an F or more if all groups are of one
    kind.

    Complex numbers count as two independent ones of one scatter each: twice the degrees of freedom.
    """
    groups = [np.asarray(g) for g in groups]
    if len(groups) < 2 or any(len(g) == 0 for g in groups) or sum(map(len, groups)) <= len(groups):
        raise ValueError("at least two groups, none empty, and more numbers than groups")
    every = np.concatenate(groups)
    parts = 2 if np.iscomplexobj(every) else 1
    between = sum(len(g) * abs(g.mean() - every.mean()) ** 2 for g in groups)
    within = sum((np.abs(g - g.mean()) ** 2).sum() for g in groups)
    d1, d2 = parts * (len(groups) - 1), parts * (len(every) - len(groups))
    if within == 0.0:
        return (0.0, 1.0) if between == 0.0 else (math.inf, 0.0)
    f = float(between / d1 / (within / d2))
    return f, beta_share(d2 / (d2 + d1 * f), 0.5 * d2, 0.5 * d1)


def upper_bound(values: np.ndarray, share: float = 0.95) -> float:
    """Returns a bound of the modulus of the true mean of complex numbers, by resampling; it is reproducible."""
    values = np.asarray(values)
    picks = np.random.default_rng(1).integers(0, len(values), (RESAMPLED, len(values)))
    return float(np.quantile(np.abs(values[picks].mean(axis=1)), share))


@dataclass(frozen=True)
class PowerLaw:
    """Parameters of y = factor x^exponent; `half` is half of the exponent's 95 % confidence interval."""
    exponent: float
    half: float
    factor: float


def power_law(x: np.ndarray, y: np.ndarray) -> PowerLaw:
    """Fits log y over log x by least squares; needs at least three points, all positive."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    if len(x) < 3 or (x <= 0.0).any() or (y <= 0.0).any() or np.ptp(x) == 0.0:
        raise ValueError("a power law needs three positive pairs at least, and different x")
    u, v = np.log(x), np.log(y)
    spread = ((u - u.mean()) ** 2).sum()
    exponent = float(((u - u.mean()) * (v - v.mean())).sum() / spread)
    rest = v - v.mean() - exponent * (u - u.mean())
    error = math.sqrt((rest ** 2).sum() / (len(x) - 2) / spread)
    return PowerLaw(exponent, student(0.95, len(x) - 2) * error, math.exp(v.mean() - exponent * u.mean()))


def distance(a: np.ndarray, b: np.ndarray) -> float:
    """Returns the largest difference between two cumulative distributions (Kolmogorov and Smirnov)."""
    a, b = np.sort(a), np.sort(b)
    every = np.concatenate([a, b])
    share = [np.searchsorted(one, every, side="right") / len(one) for one in (a, b)]
    return float(np.abs(share[0] - share[1]).max())


def chance_of_distance(first: list[np.ndarray], second: list[np.ndarray]) -> float:
    """Returns the probability that two groups of runs of one kind differ in their numbers by as much, or more.

    Whole runs change sides, as the numbers of one run hang together; the same for the same numbers.
    """
    if not first or not second or any(len(run) == 0 for run in first + second):
        raise ValueError("at least one run on either side, none without a number")
    found = distance(np.concatenate(first), np.concatenate(second))
    every, random = first + second, np.random.default_rng(1)
    further = 0
    for _ in range(RESAMPLED):
        order = random.permutation(len(every))
        sides = [np.concatenate([every[k] for k in part]) for part in (order[:len(first)], order[len(first):])]
        further += distance(*sides) >= found - 1e-12
    return further / RESAMPLED


def quantile_bounds(runs: list[np.ndarray], share: float) -> tuple[float, float, float]:
    """Returns a quantile of the numbers of all runs, and its 95 % interval from resampling whole runs."""
    random = np.random.default_rng(1)
    found = [float(np.quantile(np.concatenate([runs[k] for k in random.integers(0, len(runs), len(runs))]), share))
             for _ in range(RESAMPLED)]
    return (float(np.quantile(np.concatenate(runs), share)), float(np.quantile(found, 0.025)),
            float(np.quantile(found, 0.975)))
