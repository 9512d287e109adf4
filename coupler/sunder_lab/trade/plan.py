"""What to run for a budget: the reference, then what costs least. Costs are processor time of both processes [s]."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Sequence

from sunder_tools.errors import CommandError

from .knobs import Setting

REFERENCE_SHARE = 0.5  # of the budget, that the reference and the next finest may take
COARSEST, FINEST = -1, 4  # levels of `knobs.finer` that may be the next finest, and the reference


@dataclass
class Budget:
    """What has been spent and on what; `left_out` has the labels of what did not fit, with the guess of their cost [s].

    Guesses are those of the knobs until a setting has been run. They are scaled by what the scene's own setting took.
    """
    limit_s: float
    runs: int  # of each setting
    own_s: float = 0.0
    spent: dict[str, float] = field(default_factory=dict)  # by label, of all runs together
    left_out: dict[str, float] = field(default_factory=dict)

    def guess(self, setting: Setting) -> float:
        """Of all runs of a setting [s]."""
        return self.runs * self.own_s * setting.guess

    @property
    def left_s(self) -> float:
        """What has not been spent."""
        return self.limit_s - sum(self.spent.values())

    def fits(self, setting: Setting) -> bool:
        """Whether its runs are likely to be done within what is left; notes it as left out where they are not."""
        if setting.label in self.spent:
            return True
        if self.guess(setting) <= self.left_s:
            self.left_out.pop(setting.label, None)
            return True
        self.left_out[setting.label] = self.guess(setting)
        return False


def reference_level(budget: Budget, level: Callable[[int], Setting], refused: Callable[[Setting], str]) -> int:
    """The finest level that can be run beside the next finest with the reference's share of the budget.

    `refused` says why the solver would not take a setting, or nothing. Raises CommandError where not even the coarsest
    level that it takes beside its neighbour fits, with the budget that it would need.
    """
    def cost(k: int) -> float:
        return sum(budget.guess(level(i)) for i in (k, k - 1))

    share = REFERENCE_SHARE * budget.limit_s
    # finest first: what is asked of the solver takes time
    for k in range(FINEST, COARSEST, -1):
        if cost(k) <= share and not (refused(level(k)) or refused(level(k - 1))):
            return k
    why = ""
    for k in range(COARSEST + 1, FINEST + 1):
        why = refused(level(k - 1)) or refused(level(k))
        if not why:
            least = cost(k) / 60.0
            raise CommandError(f"--budget {budget.limit_s / 60:g}: {level(k).label} and {level(k - 1).label}, {budget.runs} runs "
                               f"each, take about {least:.2g} minutes of processor time, and may take half of the budget; give "
                               f"--budget {least / REFERENCE_SHARE * 1.1:.2g}, or shorten the scene with --until")
    raise CommandError(f"no setting can be held against a finer one: {why}")


def rounds(settings: Sequence[Setting], budget: Budget, at_once: int,
           run: Callable[[Sequence[Setting]], None]) -> None:
    """Runs `settings`, cheapest first, as long as they fit; `at_once` of them in a round, after which `budget` knows what
    they have taken."""
    waiting = sorted(settings, key=lambda s: (budget.guess(s), s.label))
    while waiting:
        chosen: list[Setting] = []
        planned = 0.0
        while waiting and len(chosen) < max(1, at_once):
            one = waiting.pop(0)
            if not budget.fits(one):
                continue
            if one.label not in budget.spent:
                planned += budget.guess(one)
                if chosen and planned > budget.left_s:
                    waiting.insert(0, one)
                    break
            chosen.append(one)
        if chosen:
            run(chosen)
