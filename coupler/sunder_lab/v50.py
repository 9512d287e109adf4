"""V50: the speed at which half of the panes are perforated, by bisection for each pane."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Sequence

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.pictures.plots import Line, Panel

from .campaign import Campaign, Planned, Settings
from .experiment import HOLLOW, SEED_PATH, Parameter, To
from .forecast import announce
from .impact import impact, perforable, perforated, struck
from .member import Member, write_atomically
from .scene import Results, Scene
from .table import Table

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Ballistic:
    """Result of a bisection. Speeds are in [m/s].

    `limits`: of each pane, the middle of the interval in which it was perforated first; infinite where it was not
    within the range, zero where it was at its lower end. `v50` is their median. `low`, `high` hold the true median with
    the chance `confidence`, whatever the distribution (order statistics); infinite or zero where there are too few
    panes for 95 %. `resolution`: half of the interval that bisection has left, on top of these.
    """
    v50: float
    low: float
    high: float
    confidence: float
    resolution: float
    limits: list[float]


def median_interval(count: int, confidence: float = CONFIDENCE) -> tuple[int, float]:
    """Returns k and its probability. The k-th smallest and k-th largest of `count` numbers enclose the median of
    their distribution with at least `confidence`; k is the largest such number. With too few numbers k is 0 and its
    probability 1."""
    best, chance = 0, 1.0
    for k in range(1, count // 2 + 1):
        inside = 1.0 - 2.0 * sum(math.comb(count, i) for i in range(k)) / 2.0 ** count
        if inside < confidence:
            break
        best, chance = k, inside
    return best, chance


def judged(limits: Sequence[float], resolution: float) -> Ballistic:
    """Computes the median of `limits` [m/s] and its confidence interval."""
    ordered = np.sort(np.asarray(limits, float))
    if len(ordered) == 0:
        raise CommandError("no pane was decided: there is no V50")
    k, chance = median_interval(len(ordered))
    middle = ordered[(len(ordered) - 1) // 2], ordered[len(ordered) // 2]
    v50 = float(middle[0]) if middle[0] == middle[1] else float(sum(middle) / 2.0)
    return Ballistic(v50, float(ordered[k - 1]) if k else 0.0, float(ordered[-k]) if k else math.inf, chance, resolution,
                     [float(v) for v in limits])


@dataclass
class V50:
    """Halves the range of speeds for each pane (seed) until it is no wider than `tolerance`. All panes are bisected
    at the same time, so each round runs as many processes as there are panes.

    `speed` says what of the scene takes a speed, as a `Parameter` does. That a pane which is perforated is so at every
    higher speed is taken for granted; the table has all runs. Near its limit a body may hang in the hole: a run that ends
    before it is decided (`through` gives None) is run again twice as long, `longer` times at most. A pane that is not
    decided then, or has a run that failed, is left out and told.
    """
    name: str
    scene: Scene
    speed: To
    low: float          # [m/s]
    high: float
    seeds: Sequence[int]
    tolerance: float = 1.0  # [m/s]
    through: Callable[[Results], bool | None] = field(default=perforated)
    longer: int = 3
    body: str | None = None
    engine: str = "bullet"

    def plan(self) -> list[Planned]:
        """Plans the first round, with both ends of the range. Raises CommandError where the bisection makes no
        sense."""
        if not 0.0 <= self.low < self.high or not self.tolerance > 0.0:
            raise CommandError(f"{self.name}: speeds {self.low} to {self.high} m/s, to {self.tolerance}: must rise, and "
                               "the tolerance be positive")
        if len(set(self.seeds)) != len(self.seeds) or not self.seeds:
            raise CommandError(f"{self.name}: seeds must be there, each once")
        try:
            rows = [self._planned(seed, speed) for seed in self.seeds for speed in (self.low, self.high)]
            for row in rows:
                struck(row.member.scene.message, self.body, None)
                if self.through is perforated:
                    perforable(row.member.scene.message, self.body)
        except Exception as error:  # noqa: BLE001: a function of the user's may raise anything
            raise CommandError(f"{self.name}: nothing was run\n{error}") from None
        return rows

    def _planned(self, seed: int, speed: float, doubled: int = 0) -> Planned:
        scene = self.scene.copy()
        scene["end_time_s"] = float(scene["end_time_s"]) * 2 ** doubled
        Parameter([speed], self.speed).apply(scene, speed)
        scene[SEED_PATH] = seed
        return Planned({"seed": seed, "speed_m_per_s": speed, "doubled": doubled}, Member(scene, self.engine))

    def _measured(self, results: Results) -> dict[str, object]:
        through = perforated(results, self.body) if self.through is perforated else self.through(results)
        return {"perforated": through, **impact(self.body)(results)}

    def announce(self, settings: Settings) -> None:
        """Prints what `sunder check` says of both ends of the range. Raises CommandError where both are refused."""
        halvings = max(0, math.ceil(math.log2((self.high - self.low) / self.tolerance)))
        announce(self.name, self.plan(), settings, len(self.seeds) * (2 + halvings), len(self.seeds))

    def run(self, settings: Settings | Path | str) -> Ballistic:
        """Runs until every pane is decided. Writes results.csv, results.sqlite, times.csv, v50.json, plots.png."""
        settings = settings if isinstance(settings, Settings) else Settings(settings)
        ranges = {seed: [self.low, self.high] for seed in self.seeds}
        planned = self.plan()
        if settings.check:
            self.announce(settings)
        lost: set[int] = set()
        with Campaign(settings) as campaign:
            fresh = planned
            while fresh:
                with campaign.kept(planned, self._measured):
                    campaign.run(fresh)
                again = []
                for row in campaign.table(fresh, self._measured)[0]:
                    seed, speed = row["seed"], row["speed_m_per_s"]
                    if row["status"] != "done" or (row["perforated"] is None and row["doubled"] >= self.longer):
                        lost.add(seed)
                    elif row["perforated"] is None:
                        again.append(self._planned(seed, speed, row["doubled"] + 1))
                    elif row["perforated"]:
                        ranges[seed][1] = min(ranges[seed][1], speed) if speed > self.low else self.low
                    else:
                        ranges[seed][0] = max(ranges[seed][0], speed) if speed < self.high else self.high
                waiting = {p.columns["seed"] for p in again}
                fresh = again + [self._planned(seed, 0.5 * (a + b)) for seed, (a, b) in ranges.items()
                                 if seed not in lost | waiting and b - a > self.tolerance]
                planned = planned + fresh
            results, times = campaign.table(planned, self._measured)
            campaign.write(results, times)
            found = judged([self._limit(*ranges[seed]) for seed in self.seeds if seed not in lost],
                           0.5 * max((b - a for seed, (a, b) in ranges.items() if seed not in lost), default=0.0))
            write_atomically(campaign.folder / "v50.json", {
                "v50_m_per_s": _finite(found.v50), "low_m_per_s": _finite(found.low), "high_m_per_s": _finite(found.high),
                "confidence": found.confidence, "resolution_m_per_s": found.resolution,
                "limits_m_per_s": [_finite(v) for v in found.limits], "lost_seeds": sorted(lost)})
            self._plot(results, found, campaign)
        return found

    def _limit(self, low: float, high: float) -> float:
        """Returns the limit of one pane [m/s]."""
        if low >= self.high:
            return math.inf
        return 0.0 if high <= self.low else 0.5 * (low + high)

    def _plot(self, results: Table, found: Ballistic, campaign: Campaign) -> None:
        done = Table(row for row in results if row["status"] == "done")
        dots: dict[float, list[tuple[float, float]]] = {settled: [
            (row["speed_m_per_s"], row["residual_velocity_m_per_s"]) for row in done if row["settled"] == settled] for settled in (0.0, 1.0)}
        at_once = sum(v == 0.0 for v in found.limits)  # perforated at the lower end of the range
        share = sorted(v for v in found.limits if math.isfinite(v) and v > 0.0)
        n = len(found.limits)
        first = at_once / n
        steps = [(v, (k + at_once + d) / n) for k, v in enumerate(share) for d in (0, 1)]
        campaign.draw([
            Panel(f"{self.name}: share of panes perforated", "impact speed [m/s]", "share of panes perforated",
                  [Line("share", [self.low, *(v for v, _ in steps), self.high],
                        [first, *(s for _, s in steps), (len(share) + at_once) / n])]),
            Panel("residual velocity", "impact speed [m/s]", "residual velocity [m/s]", [
                Line("", [], [], dots=dots[1.0], hollow_dots=dots[0.0])], hollow=HOLLOW)],
            "plots")


def _finite(value: float) -> float | None:
    """Replaces infinity by None: JSON has no infinity."""
    return value if math.isfinite(value) else None
