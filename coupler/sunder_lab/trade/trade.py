"""The trade of one scene: one setting changed at a time, then several together, each against a converged reference.

    own setting -> reference and next finest -> single changes, cheapest first -> combinations of what was worth it

Every run is a member of a campaign, so that a trade that was killed goes on: what has been run is read, with what it took.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Sequence

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.launch.run import read_usage

from ..campaign import Campaign, Planned, Settings
from ..forecast import minutes_of
from ..member import RUN_FOLDER, Member, is_done, outcome
from ..scene import Results, Scene
from .judge import Judged, alike, combinations, fronts, gaps, own_errors
from .knobs import CONVERGING, KNOBS, Change, Setting, breaks, changes_of, finer
from .plan import Budget, reference_level, rounds
from .quantities import in_short, measured, observed, prepared, shaken

SEEDS = 4           # runs of each setting where chance plays a part
MOST_COMBINED = 12  # combinations that are tried
EXCLUSIVE = (frozenset({"layers", "bending"}), frozenset({"degree", "gauss_points"}))


@dataclass(frozen=True)
class Row:
    """A setting of the table. `values`: means of the quantities over its runs; `kind`: own, reference, next finest, one
    or together; `error` why it could not be judged, else ''. `on_bounds`: of its error only a bound is known, and no
    cheaper setting has a smaller bound. `like_own`: scatter explains its difference to the scene's own."""
    judged: Judged
    kind: str
    values: dict[str, float]
    runs: int
    error: str = ""
    on_front: bool = False
    on_bounds: bool = False
    like_own: bool = False


@dataclass
class Outcome:
    """What a trade has found. `reference` and `next_finest` are labels; `own_errors` the reference's, by quantity."""
    scene: str
    rows: list[Row]
    reference: str
    next_finest: str
    own_errors: dict[str, float]
    chance: bool
    seeds: int
    spent_s: float
    budget_s: float
    over_budget: dict[str, float]      # what did not fit, with the guess of its cost [s]
    not_applicable: dict[str, str]     # knobs that mean nothing for the scene, and why
    not_compared: dict[str, str]       # quantities, and why

    def on_front(self) -> list[Row]:
        """Cheapest first."""
        return sorted((r for r in self.rows if r.on_front), key=lambda r: r.judged.processor_s)

    def on_bounds(self) -> list[Row]:
        """Cheapest first."""
        return sorted((r for r in self.rows if r.on_bounds), key=lambda r: r.judged.processor_s)


@dataclass
class Trade:
    """`budget_min`: minutes of processor time of all runs together, those of earlier starts included. `seeds` None: as many
    as it takes where chance plays a part, else one. `vary`: knobs, all that apply unless some are named."""
    scene: Scene
    budget_min: float
    seeds: int | None = None
    vary: Sequence[str] = ()
    engine: str = "bullet"
    name: str = ""
    _runs: dict[str, dict[int, dict[str, np.ndarray]]] = field(default_factory=dict)
    _costs: dict[str, tuple[float, float]] = field(default_factory=dict)
    _errors: dict[str, str] = field(default_factory=dict)
    _paid: dict[Path, str] = field(default_factory=dict)  # by whose budget a run was made
    _planned: dict[str, list[Planned]] = field(default_factory=dict)

    def check(self) -> float:
        """Refuses what cannot be traded, and returns the solver's own guess of a run [s]. Raises CommandError."""
        if not (math.isfinite(self.budget_min) and self.budget_min > 0.0):
            raise CommandError(f"--budget {self.budget_min:g}: must be a positive number of minutes")
        unknown = [name for name in self.vary if name not in KNOBS]
        if unknown:
            raise CommandError(f"--vary {','.join(unknown)}: there are {', '.join(KNOBS)}")
        if self.seeds is not None and self.seeds < 1:
            raise CommandError(f"--seeds {self.seeds}: must be at least 1")
        if not self.scene.message.shells:
            raise CommandError("the scene has no shell: there is nothing to trade")
        guess = 60.0 * minutes_of(prepared(self.scene).check())
        if guess > 60.0 * self.budget_min:
            raise CommandError(f"--budget {self.budget_min:g}: one run of the scene as it is may take {guess / 60:.2g} minutes by "
                               "'sunder check'; give more, or shorten the scene with --until")
        return guess

    def run(self, settings: Settings) -> Outcome:
        """Runs what the budget allows, and judges it. Raises CommandError where the scene itself cannot be run."""
        self.check()
        chance = breaks(self.scene)
        seeds = self.seeds or (SEEDS if chance else 1)
        budget = Budget(60.0 * self.budget_min, seeds)
        changes, left = changes_of(self.scene, self.engine)
        if self.vary:
            left.update({k: "not asked for" for k in KNOBS if k not in self.vary})
            changes = [c for c in changes if c.knob in self.vary]
        with Campaign(settings) as campaign:
            at_once = max(1, -(-(settings.jobs or 1) // seeds))
            own = Setting()
            self._run(campaign, [own], budget)
            if self._errors.get(own.label):
                raise CommandError(f"the scene as it is cannot be run: {self._errors[own.label]}")
            budget.own_s = budget.spent[own.label] / seeds

            def level(k: int) -> Setting:
                return finer(self.scene, k)

            best = reference_level(budget, level, self._refused)
            campaign.say(f"a run takes {budget.own_s:.3g} s; the reference is: {level(best).label}")
            reference, beside = level(best), level(best - 1)
            self._run(campaign, [beside], budget)
            self._run(campaign, [reference], budget)
            for one in (reference, beside):
                if self._errors.get(one.label):
                    raise CommandError(f"the reference ({one.label}) cannot be run: {self._errors[one.label]}")
            errors = own_errors(self._runs[reference.label], self._runs[beside.label])
            if not errors:
                raise CommandError("no quantity can be compared: nothing cracks, no body moves, and no shell has a probe; add "
                                   "output.probes")
            fine = [c for c in changes if self._as_fine(c, reference)]
            left.update({c.label: "as fine as the reference, or finer: there is nothing to hold it against" for c in fine})
            single = [Setting((c,)) for c in changes if c not in fine]
            rounds(single, budget, at_once, lambda some: self._try(campaign, some, budget, left))
            together = self._together(campaign, budget, changes, single, reference, errors, chance, at_once, left)
            kinds = {**{s.label: "one" for s in single}, **{s.label: "together" for s in together},
                     beside.label: "next finest", own.label: "own", reference.label: "reference"}
            bare = {s.label: s.converging.label for s in [*single, *together]}
            rows = self._rows(kinds, bare, reference, errors, chance)
            results, times = campaign.table([p for some in self._planned.values() for p in some], measured)
            campaign.write(results, times)
        return Outcome(self.name or self.scene.message.name, rows, reference.label, beside.label, errors, chance, seeds,
                       sum(budget.spent.values()), budget.limit_s, budget.left_out, left, self._not_compared(errors))

    def _refused(self, setting: Setting) -> str:
        """Why the solver would not take this setting; empty where it does."""
        try:
            setting.scene(prepared(self.scene)).check()
        except CommandError as error:
            return f"{setting.label}: {error}"
        return ""

    def _together(self, campaign: Campaign, budget: Budget, changes: list[Change], single: list[Setting],
                  reference: Setting, errors: dict[str, float], chance: bool, at_once: int,
                  left: dict[str, str]) -> list[Setting]:
        """Combinations that may be on the front, run as far as the budget goes."""
        of = {c.label: c for c in changes}
        judged = {s.label: self._judged(s.label, reference, errors, chance) for s in single if s.label in self._runs}
        own = self._judged(Setting().label, reference, errors, chance)
        judged = {label: j for label, j in judged.items() if of[label].knob != "fidelity"}  # a combination already
        found = combinations(own, judged, {label: of[label].knob for label in judged}, EXCLUSIVE, CONVERGING)
        out = []
        for labels in found[:MOST_COMBINED]:
            # what they have taken one by one is a better guess than the knobs' own
            parts = tuple(replace(of[label], cost=judged[label].processor_s / own.processor_s) for label in labels)
            out.append(Setting(parts))
        rounds(out, budget, at_once, lambda some: self._try(campaign, some, budget, left))
        return out

    @staticmethod
    def _as_fine(change: Change, reference: Setting) -> bool:
        """Whether elements are as small as in the reference or smaller: there is nothing to hold it against."""
        return change.knob in ("elements", "fidelity") and change.cost >= max(
            (c.cost for c in reference.changes if c.knob == "elements"), default=1.0) * (1.0 - 1e-9) and change.cost > 1.0

    def _try(self, campaign: Campaign, settings: Sequence[Setting], budget: Budget, left: dict[str, str]) -> None:
        """Runs those that the solver takes; of others, the reason goes to `left`."""
        refused = {s.label: "" if all(is_done(campaign.place(p.member)) for p in self._members(s, budget.runs))
                   else self._refused(s) for s in settings}
        left.update({label: why.removeprefix(f"{label}: ").removeprefix("sunder-shell: ") for label, why in refused.items() if why})
        taken = [setting for setting in settings if not refused[setting.label]]
        if taken:
            self._run(campaign, taken, budget)

    def _run(self, campaign: Campaign, settings: Sequence[Setting], budget: Budget) -> None:
        """All runs of these settings; what they gave and took is kept by label."""
        for setting in settings:
            self._planned[setting.label] = self._members(setting, budget.runs)
        campaign.run([p for s in settings for p in self._planned[s.label]])
        for setting in settings:
            self._keep(campaign, setting.label, budget)

    def _members(self, setting: Setting, runs: int) -> list[Planned]:
        return [Planned({"setting": setting.label, "seed": seed}, Member(
            shaken(setting.scene(prepared(self.scene)), seed), setting.engine(self.engine))) for seed in range(runs)]

    def _keep(self, campaign: Campaign, label: str, budget: Budget) -> None:
        runs: dict[int, dict[str, np.ndarray]] = {}
        processor, wall = [], []
        for planned in self._planned[label]:
            place = campaign.place(planned.member)
            found = outcome(place)
            used = read_usage(place / RUN_FOLDER)
            processor.append(used.get("processor_s", 0.0))
            if place not in self._paid:  # two settings may come to the same run
                self._paid[place] = label
            wall.append(used.get("wall_s", 0.0))
            if found.get("status") != "done":
                self._errors[label] = str(found.get("error") or "was not run")
                continue
            try:
                runs[int(planned.columns["seed"])] = observed(Results(place / RUN_FOLDER))
            except CommandError as error:
                self._errors[label] = str(error).replace(f"{place}/", "")
        self._runs[label] = runs
        self._costs[label] = float(np.mean(processor)), float(np.mean(wall))
        budget.spent[label] = float(sum(cost for cost, p in zip(processor, self._planned[label])
                                        if self._paid[campaign.place(p.member)] == label))

    def _judged(self, label: str, reference: Setting, errors: dict[str, float], chance: bool) -> Judged:
        """Without gaps where a run failed or lacks a quantity."""
        found = {} if self._errors.get(label) else gaps(self._runs[label], self._runs[reference.label], errors, chance)
        return Judged(label, *self._costs[label], found)

    def _rows(self, kinds: dict[str, str], bare: dict[str, str], reference: Setting, errors: dict[str, float],
              chance: bool) -> list[Row]:
        """`bare`: of each label, that of the same setting without what replaces a law or a scheme."""
        out = []
        for label, kind in kinds.items():
            if label not in self._runs:
                continue
            judged = self._judged(label, reference, errors, chance)
            runs = self._runs[label]
            names = dict.fromkeys(name for run in runs.values() for name in run)
            values = {name: float(np.mean([in_short(name, run[name]) for run in runs.values() if name in run]))
                      for name in names}
            missing = sorted(set(errors) - set(names))
            why = self._errors.get(label, "") or ("" if judged.gaps else f"nothing to compare: no {', '.join(missing)}")
            out.append(Row(judged, kind, values, len(runs), why))
        heights = {r.judged.label: r.judged.height for r in out if r.judged.gaps}
        least = {label: heights[other] for label, other in bare.items() if other != label and other in heights}
        best, bounds = ({j.label for j in some} for some in fronts([r.judged for r in out if r.kind != "reference"], least))
        own = Setting().label
        like = {r.judged.label for r in out if r.judged.label != own and not r.error
                and alike(self._runs[r.judged.label], self._runs[own], errors, chance)}
        return [replace(r, on_front=r.judged.label in best, on_bounds=r.judged.label in bounds, like_own=r.judged.label in like)
                for r in sorted(out, key=lambda r: r.judged.processor_s)]

    def _not_compared(self, errors: dict[str, float]) -> dict[str, str]:
        from .quantities import UNITS
        why = {"deflection": "the shell cracks, or has no probe and none can be placed", "impulse": "no body moves",
               "energy_taken": "no body moves", "crack_length": "nothing cracks", "pieces": "nothing cracks",
               "mean_piece": "nothing cracks"}
        return {name: why[name] for name in UNITS if name not in errors}


def folder_of(scene: Path, out: Path | None) -> Path:
    """Where a trade is kept, so that the same command goes on with it."""
    return out or Path("trades") / scene.stem


def as_json(found: Outcome) -> dict[str, Any]:
    """For trade.json; NaN and infinity are null."""
    def number(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return {
        "scene": found.scene, "reference": found.reference, "next_finest": found.next_finest,
        "reference_own_error": {k: number(v) for k, v in found.own_errors.items()},
        "chance": found.chance, "seeds": found.seeds, "processor_s": found.spent_s, "budget_s": found.budget_s,
        "settings": [{
            "setting": r.judged.label, "kind": r.kind, "runs": r.runs, "processor_s": number(r.judged.processor_s),
            "wall_s": number(r.judged.wall_s), "error": number(r.judged.error), "noise": number(r.judged.noise),
            "resolved": bool(r.judged.resolved), "on_front": r.on_front, "on_bounds": r.on_bounds,
            "like_own": r.like_own, "why_not": r.error or None,
            "quantities": {n: {"mean": number(v), "error": number(r.judged.gaps[n].error) if n in r.judged.gaps else None,
                               "noise": number(r.judged.gaps[n].noise) if n in r.judged.gaps else None}
                           for n, v in r.values.items()}} for r in found.rows],
        "front": [r.judged.label for r in found.on_front()],
        "bounds": [r.judged.label for r in found.on_bounds()],
        "over_budget_s": found.over_budget, "not_applicable": found.not_applicable, "not_compared": found.not_compared}
