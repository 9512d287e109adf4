"""What `sunder check` says of a series before its first run: what is refused, what is warned of, and how long it may take.

One scene is checked for each combination of values, that of its first seed: seeds and repeats change neither sizes nor steps.
"""
from __future__ import annotations

import re
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Sequence

from sunder_tools.errors import CommandError
from sunder_tools.launch.build import ensure_built
from sunder_tools.launch.needs import reads_cad

from .campaign import MEMBERS, Planned, Settings
from .member import is_done

OF_CHANCE = ("seed", "repeat")  # columns that do not make another scene to check
MOST_CHECKED = 32  # combinations; of more, those with the smallest and the largest values are checked
NUMBER = r"[0-9.eE+-]*[0-9][0-9.eE+-]*"


@dataclass(frozen=True)
class Checked:
    """What the check says of a combination of values, `words`. `refused` is '' where it is taken."""
    words: str
    refused: str = ""
    minutes: float = 0.0  # of one run, one thread, uncracked
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Forecast:
    """What is known of a series before it runs. `minutes`: of all runs that remain, 0 where every scene is refused; `longest`: of the
    longest one; `side_by_side`: how many can run at a time, whatever the machine."""
    checked: list[Checked]
    combinations: int
    runs: int
    minutes: float
    longest: float
    side_by_side: int
    seconds: float  # that the checks took

    def lines(self, settings: Settings) -> list[str]:
        """Returns lines for people: the cost of all runs."""
        of = "" if len(self.checked) == self.combinations else f" of {self.combinations}, with the smallest and largest values,"
        at_once = min(settings.jobs_at_once(), self.side_by_side)
        told = f"{counted(len(self.checked))}{of} checked in {self.seconds:.2g} s"
        if self.minutes > 0.0:
            told += (f"; {self.runs} runs take at most about {duration(self.minutes)} on one thread, uncracked; "
                     "cracks can make that three times as long; starting, bodies and pictures come on top")
            if at_once > 1:
                told += f"; {at_once} runs at a time: {duration(max(self.minutes / at_once, self.longest))}"
        return [told]

    def troubles(self) -> list[str]:
        """Returns lines for people: refusals and warnings, each kind once, with the first combination that has it."""
        of = len(self.checked)
        return [f"{what}: {len({words for words, _ in found})} of {counted(of)}, first {found[0][0]}: {found[0][1]}"
                for what, told in (("refused", [(c.words, c.refused) for c in self.checked if c.refused]),
                                   ("warning", [(c.words, text) for c in self.checked for text in c.warnings]))
                for found in kinds(told)]


def kinds(told: Sequence[tuple[Any, str]]) -> list[list[tuple[Any, str]]]:
    """Puts sentences together that differ in their numbers only, in order; each with what it was said of."""
    out: dict[str, list[tuple[Any, str]]] = {}
    for of, text in told:
        out.setdefault(re.sub(NUMBER, "N", text), []).append((of, text))
    return list(out.values())


def counted(scenes: int) -> str:
    """Writes a number of scenes."""
    return f"{scenes} scene{'' if scenes == 1 else 's'}"


def duration(minutes: float) -> str:
    """Writes a time in the unit that suits."""
    if minutes < 1.0:
        return f"{60.0 * minutes:.2g} s"
    return f"{minutes:.3g} min" if minutes < 120.0 else f"{minutes / 60.0:.3g} h"


def minutes_of(report: str) -> float:
    """Reads how long a run takes at most, uncracked, from what `sunder check` prints [min]."""
    found = re.search(r"^time +at most ([0-9.e+-]+) min", report, re.M)
    return float(found[1]) if found else 0.0


def read_report(words: str, report: str) -> Checked:
    """Reads minutes and warnings from what `sunder check` prints."""
    return Checked(words, minutes=minutes_of(report),
                   warnings=tuple(re.findall(r"^warning +(.*)$", report, re.M)))


def forecast(name: str, planned: Sequence[Planned], settings: Settings, runs: int | None = None,
             side_by_side: int | None = None) -> Forecast | None:
    """Checks the scenes of members that are not done; None where all are. `runs`: how many there may be in all, `side_by_side`: how
    many at a time; None: those that are not done.

    Raises CommandError where nothing was run yet and every scene is refused.
    """
    places = {Path(settings.out) / MEMBERS / p.member.identity(): p for p in planned}
    remaining = [p for place, p in places.items() if not is_done(place)]
    if not remaining:
        return None
    groups: dict[str, list[Planned]] = {}
    for p in remaining:
        groups.setdefault(words_of(p), []).append(p)
    order = list(groups) if len(groups) <= MOST_CHECKED else [*(some := corners(groups)), *(w for w in groups if w not in some)]
    least = len(groups) if len(groups) <= MOST_CHECKED else min(len(corners(groups)), MOST_CHECKED)
    ensure_built(cad=any(reads_cad(group[0].member.scene.text()) for group in groups.values()))
    start, checked = time.monotonic(), list[Checked]()
    for words in order:
        if len(checked) >= least and not all(c.refused for c in checked):
            break  # all of them may be refused: then the others are asked, too
        try:
            checked.append(read_report(words, groups[words][0].member.scene.check()))
        except CommandError as error:
            checked.append(Checked(words, refused=re.sub(r"^sunder-shell: ", "", str(error))))
    if len(remaining) == len(places) and all(c.refused for c in checked):
        raise CommandError(f"{name}: nothing was run\nrefused by 'sunder check', all {counted(len(groups))}:\n" + "\n".join(
            f"{found[0][0]}: {found[0][1]}" for found in kinds([(c.words, c.refused) for c in checked])))
    taken = [c for c in checked if not c.refused]
    mean = sum(c.minutes for c in taken) / len(taken) if taken else 0.0
    each = {c.words: c.minutes for c in checked}
    minutes = (sum(each.get(words, mean) * len(group) for words, group in groups.items())) if runs is None else mean * runs
    count = len(remaining) if runs is None else runs
    return Forecast(checked, len(groups), count, minutes, max((c.minutes for c in taken), default=0.0),
                    count if side_by_side is None else side_by_side, time.monotonic() - start)


def announce(name: str, planned: Sequence[Planned], settings: Settings, runs: int | None = None,
             side_by_side: int | None = None) -> None:
    """Prints the forecast; refusals of some scenes and warnings also where progress is not wanted. Raises CommandError as
    `forecast` does."""
    found = forecast(name, planned, settings, runs, side_by_side)
    if found is None:
        return
    for line in found.lines(settings):
        settings.say(f"{name}: {line}")
    for line in found.troubles():
        settings.say(line, always=True)


def words_of(planned: Planned) -> str:
    """Returns what makes a scene, without what is left to chance."""
    return ", ".join(f"{k} {v}" for k, v in planned.columns.items() if k not in OF_CHANCE) or "the scene"


def corners(groups: dict[str, list[Planned]]) -> list[str]:
    """Returns the combinations in which every number is the smallest or the largest of its column."""
    rows = {words: group[0].columns for words, group in groups.items()}
    ends: dict[str, tuple[float, float]] = {}
    for name in next(iter(rows.values())):
        values = [row[name] for row in rows.values()]
        if name not in OF_CHANCE and all(isinstance(v, (int, float)) for v in values):
            ends[name] = min(values), max(values)
    return [words for words, row in rows.items() if all(row[name] in both for name, both in ends.items())]
