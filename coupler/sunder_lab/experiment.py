"""`Experiment`: runs a scene with every combination of parameters, seeds and repeats, and makes a table of results."""
from __future__ import annotations

import itertools
import random
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Iterator, Mapping, Sequence, Union

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.pictures.plots import Line, Panel
from sunder_tools.pictures.units import scale, valued, words_and_unit
from sunder_tools.words import did_you_mean

from .campaign import Campaign, Measure, Planned, Settings
from .forecast import announce
from .impact import FORCE, INTERVAL, impact
from .measures import Stated
from .member import Member
from .scene import Results, Scene, Value
from .table import ENOUGH, Cell, Table

SEED_PATH = "fracture.seed"
# Measures that are never below 0, as lengths and areas are not. An energy of a body that strikes what is at rest is not
# either; a shell that moves or is stressed at the start may give some back.
NOT_NEGATIVE = ("mean_force_N", "impulse_N_s", "contact_until_s", "crack_length_m", "largest_piece_m2", "median_piece_m2", "mean_piece_m2",
                "dent_in_m3", "dent_out_m3", "energy_lost_J", "energy_motion_J", "energy_elastic_J", "energy_fracture_J",
                "energy_plastic_J", "energy_faces_J", "energy_damping_J")
ROUND_OFF = 1e-9  # of a column's largest value: below zero by less is zero
HOLLOW = "hollow: ended before or during contact (settled is 0)"
# Columns of every table; no parameter and no measure may use these names.
OWN = ("member", "seed", "repeat", "status", "error", "warnings")

To = Union[str, Sequence[str], Mapping[str, Callable[[Any], Value]], Callable[[Scene, Any], None]]


@dataclass(frozen=True)
class Parameter:
    """Values of a parameter, and the place in the scene that takes them.

    `to` is a path, or several paths that get the same value. It may also be paths with a function of the value each
    (`{"bodies[ball].twist.linear.z": lambda speed: -speed}`), or a function that changes the scene.
    """
    values: Sequence[Any]
    to: To

    def apply(self, scene: Scene, value: Any) -> None:
        """Applies a value to a scene. Raises BadSetting where a path does not exist or the value does not fit."""
        if callable(self.to):
            self.to(scene, value)
        elif isinstance(self.to, Mapping):
            for path, function in self.to.items():
                scene[path] = function(value)
        else:
            for path in [self.to] if isinstance(self.to, str) else self.to:
                scene[path] = value


@dataclass(frozen=True)
class Plot:
    """A panel of plots.png: the mean of column `y` over seeds and repeats at each `x`, with its 95 % confidence
    interval, and every run as a dot. There is a line for each value of column `by`.

    Error bars end at `least`, below which `y` cannot be. Where it is None, that is 0 for whole numbers and for the measures of
    NOT_NEGATIVE, as long as no run has a negative one; other columns have no such end.

    Runs whose `settled` is 0 are hollow, and so are means that contain one.
    """
    x: str
    y: str
    by: str | None = None
    logarithmic: bool = False
    title: str = ""
    least: float | None = None

    def names(self) -> list[str]:
        """Returns the columns that it draws."""
        return [self.x, self.y, *([self.by] if self.by else [])]

    def words(self) -> str:
        """Returns what messages call it."""
        return f"plot of {self.y} over {self.x}"

    def panel(self, table: Table) -> Panel:
        """Draws the panel. Raises CommandError where a column is missing or holds text."""
        for name in (self.x, self.y):
            if table[name].dtype == object:
                raise CommandError(f"column '{name}' holds text; a plot draws numbers, and text may be 'by'")
        lines, counts = [], set()
        for key in dict.fromkeys(table[self.by].tolist()) if self.by else [None]:
            part = table.where(**{self.by: key}) if self.by else table
            means = [m for m in part.means(self.y, [self.x]) if m.count]
            counts |= {m.count for m in means}
            early = part["settled"] == 0.0 if "settled" in part.columns else np.zeros(len(part), bool)
            dots = list(zip(part[self.x], part[self.y], early)) if any(m.count > 1 for m in means) else []
            hollow = {row[self.x] for row, no in zip(part, early) if no and row[self.y] is not None}
            lines.append(Line(valued(self.by, key) if self.by else "",
                              [m.key[self.x] for m in means], [m.mean for m in means], [m.half for m in means],
                              [(x, y) for x, y, no in dots if not no], hollow=[m.key[self.x] in hollow for m in means],
                              hollow_dots=[(x, y) for x, y, no in dots if no]))
        return Panel(self.title or f"{words_and_unit(self.y)[0]} over {words_and_unit(self.x)[0]}", self.x, self.y, lines, self.logarithmic,
                     bars="\n".join(filter(None, (self._interval(table), _runs(counts)))), least=self._least(table), hollow=HOLLOW)

    def _interval(self, table: Table) -> str:
        """Says over which interval a force is taken; '' where it is no such force, or the intervals differ."""
        if self.y != FORCE or INTERVAL not in table.columns:
            return ""
        found = {row[INTERVAL] for row in table if row[self.y] is not None}
        if len(found) != 1:
            return ""
        seconds = float(found.pop())
        factor, unit = scale("s", [seconds])
        return f"mean over {seconds * factor:g} {unit}"

    def _least(self, table: Table) -> float | None:
        """Returns where error bars end."""
        if self.least is not None:
            return self.least
        values = [row[self.y] for row in table if row[self.y] is not None]
        least = -ROUND_OFF * max((abs(v) for v in values), default=0.0)
        known = self.y in NOT_NEGATIVE or all(isinstance(v, int) for v in values)
        return 0.0 if values and known and min(values) >= least else None


def _runs(counts: set[int]) -> str:
    """Says what error bars are, of as many runs at each place; '' where there are none."""
    if max(counts, default=0) < 2:
        return ""
    few = f": take {ENOUGH} or more" if min(counts) < ENOUGH else ""
    return f"mean ± 95 % interval, {min(counts)}{f' to {max(counts)}' if len(counts) > 1 else ''} runs a point{few}"


def _numbers(values: Sequence[Any]) -> bool:
    return all(isinstance(value.item() if hasattr(value, "item") else value, (bool, int, float)) for value in values)


@dataclass
class Experiment:
    """A series of runs of one scene.

    Every combination of `parameters` is run with every seed (of the strength's scatter), `repeats` times. What differs
    between repeats is `scatter`: paths whose value is moved by up to so much either way, evenly, the same for the same
    seed and repeat. Without it repeats are the same to the bit, and more than one is refused.

    A parameter is a `Parameter`, or a list of values where its name is a path itself. `measure` makes columns of a run's
    `Results`; several may be given. A function of one's own states its columns by `@gives("name", ...)`: plots are then
    checked before the first run, else with the first one that is done.
    """
    name: str
    scene: Scene
    parameters: Mapping[str, Parameter | Sequence[Any]]
    seeds: Sequence[int] = ()  # none: the scene's own
    repeats: int = 1
    scatter: Mapping[str, float] = field(default_factory=dict)
    measure: Measure | Sequence[Measure] = field(default_factory=impact)
    plots: Plot | Sequence[Plot] = ()
    engine: str = "bullet"

    def plan(self) -> list[Planned]:
        """Plans every row. Raises CommandError that names all unsuitable parameters, before anything runs."""
        faults = []
        parameters = {name: p if isinstance(p, Parameter) else Parameter(p, name) for name, p in self.parameters.items()}
        for name, parameter in parameters.items():
            if name in OWN:
                faults.append(f"parameter '{name}': every table has a column of that name; choose another")
            if isinstance(parameter.values, str) or not len(parameter.values):
                faults.append(f"parameter '{name}': needs a list of values")
                continue
            for value in parameter.values:
                try:
                    parameter.apply(self.scene.copy(), value)
                except Exception as error:  # noqa: BLE001: a function of the user's may raise anything
                    faults.append(f"parameter '{name}', value {value!r}: {error}")
                    break
        for path in self.scatter:
            try:
                self._scattered(self.scene.copy(), path, 0, 0)
            except CommandError as error:
                faults.append(f"scatter: {error}")
        if self.repeats < 1 or (self.repeats > 1 and not self.scatter):
            faults.append(f"repeats is {self.repeats}: must be 1, or more with a scatter; the same scene gives the same "
                          "results to the bit")
        faults += self._faults_of_names(parameters)
        if faults:
            faults += dict.fromkeys(self._refused(self.scene))
            raise CommandError(f"{self.name}: nothing was run\n" + "\n".join(faults))
        rows = []
        for values in itertools.product(*(p.values for p in parameters.values())):
            for seed in self.seeds or (None,):
                for repeat in range(self.repeats):
                    rows.append(self._planned(parameters, values, seed, repeat))
        faults = list(dict.fromkeys(fault for row in rows for fault in self._refused(row.member.scene)))
        if faults:
            raise CommandError(f"{self.name}: nothing was run\n" + "\n".join(faults))
        return rows

    def _plots(self) -> Sequence[Plot]:
        return [self.plots] if isinstance(self.plots, Plot) else self.plots

    def _measures(self) -> list[Measure]:
        return [self.measure] if callable(self.measure) else list(self.measure)

    def _refused(self, scene: Scene) -> Iterator[str]:
        """What measures find wrong with a planned scene."""
        for measure in self._measures():
            if isinstance(measure, Stated):
                try:
                    measure.refuse(scene)
                except CommandError as error:
                    yield f"measure of {measure.columns[0]}, ...: {error}"

    def _faults_of_names(self, parameters: dict[str, Parameter]) -> list[str]:
        """Names of columns that are there already, and plots of columns that no run will give."""
        faults = [f"a measure is {measure!r}: must be a function of a run's results" for measure in self._measures()
                  if not callable(measure)]
        stated = [name for measure in self._measures() if isinstance(measure, Stated) for name in measure.columns]
        taken = {name.casefold(): name for name in OWN}
        twice = []
        for name in [*(name for name in parameters if name not in OWN), *stated]:
            other = taken.setdefault(name.casefold(), name)
            if other == name and [*parameters, *stated, *OWN].count(name) > 1:
                twice.append(name)
            elif other != name:
                faults.append(f"column '{name}': differs from '{other}' in case only, which is the same name in results.sqlite")
        if twice := list(dict.fromkeys(twice)):
            more = f", and of {len(twice) - 1} more" if len(twice) > 1 else ""
            faults.append(f"column '{twice[0]}': there is one of that name already{more}; leave a measure out, or choose other "
                          "names, of a measure by sunder.gives")
        own = [name for name in OWN if name != "repeat" or self.repeats > 1]
        texts = {"member", "status", "error"} | {name for name, p in parameters.items() if not _numbers(p.values)}
        for plot in self._plots():
            for name in plot.names():
                if name in (plot.x, plot.y) and name in texts:
                    faults.append(f"{plot.words()}: column '{name}' holds text; a plot draws numbers, and text may be 'by'")
                elif name not in [*own, *parameters, *stated] and self._all_stated():
                    faults.append(f"{plot.words()}: no column '{name}'; {self._remedy(name, [*own, *parameters, *stated])}")
        return list(dict.fromkeys(faults))

    def _remedy(self, name: str, known: list[str]) -> str:
        """What to do for a column that is not there."""
        told = [m.absent[name] for m in self._measures() if isinstance(m, Stated) and name in m.absent]
        return told[0] if told else did_you_mean(name, known)

    def _all_stated(self) -> bool:
        return all(isinstance(measure, Stated) for measure in self._measures())

    def _look(self, planned: Planned, results: Results) -> None:
        """Raises CommandError where plots name columns that neither the first run that is done has, nor a measure states.

        This is for measures that do not state their columns.
        """
        try:
            found = self._measured(results)
        except Exception:  # noqa: BLE001: the measure is the user's; the table will say so
            return
        stated = [name for measure in self._measures() if isinstance(measure, Stated) for name in measure.columns]
        known = [*OWN, *planned.columns, *found, *stated]
        faults = [f"{plot.words()}: no column '{name}'; {self._remedy(name, known)}"
                  for plot in self._plots() for name in plot.names() if name not in known]
        if faults:
            raise CommandError("\n".join([
                f"{self.name}: ended with the first run that is done; the same command goes on", *faults,
                "columns that only some runs have are stated: decorate the measure with @sunder.gives(\"NAME\", ...)"]))

    def _planned(self, parameters: dict[str, Parameter], values: tuple[Any, ...], seed: int | None,
                 repeat: int) -> Planned:
        scene = self.scene.copy()
        columns: dict[str, Cell] = {}
        for (name, parameter), value in zip(parameters.items(), values):
            parameter.apply(scene, value)
            columns[name] = value
        if seed is not None:
            scene[SEED_PATH] = seed
        for path in self.scatter:
            self._scattered(scene, path, seed or 0, repeat)
        columns["seed"] = seed if seed is not None else scene[SEED_PATH]
        if self.repeats > 1:
            columns["repeat"] = repeat
        return Planned(columns, Member(scene, self.engine))

    def _scattered(self, scene: Scene, path: str, seed: int, repeat: int) -> None:
        by = random.Random(f"{path} {seed} {repeat}").uniform(-1.0, 1.0) * self.scatter[path]
        scene[path] = float(scene[path]) + by

    def announce(self, settings: Settings) -> None:
        """Prints what `sunder check` says of the scenes. Raises CommandError where all are refused."""
        announce(self.name, self.plan(), settings)

    def run(self, settings: Settings | Path | str) -> Table:
        """Runs members that have not been run, and writes results.csv, results.sqlite, times.csv and plots.png into
        a folder."""
        planned = self.plan()
        settings = settings if isinstance(settings, Settings) else Settings(settings)
        if settings.check:
            self.announce(settings)
        with Campaign(settings) as campaign:
            with campaign.kept(planned, self._measured):
                campaign.run(planned, self._look if self.plots and not self._all_stated() else None)
            results, times = campaign.table(planned, self._measured)
            campaign.write(results, times)
            self._draw(Table(row for row in results if row["status"] == "done"), campaign)
        return results

    def _draw(self, done: Table, campaign: Campaign) -> None:
        """Writes plots.png. A plot of a missing column does not lose results."""
        panels = []
        for plot in self._plots() if len(done) else ():
            try:
                panels.append(plot.panel(done))
            except CommandError as error:
                campaign.say(f"{plot.words()}: {error}", always=True)
        campaign.draw(panels, "plots")

    def _measured(self, results: Any) -> dict[str, Any]:
        out: dict[str, Any] = {}
        for measure in self._measures():
            found = measure(results)
            there = {name.casefold(): name for name in (*out, *self.parameters, *OWN)}
            taken = [f"'{name}' beside '{there[name.casefold()]}'" for name in found if name.casefold() in there]
            if taken:
                raise ValueError("a measure gives a column that there is already, or that differs from one in case only: "
                                 f"{', '.join(taken)}")
            out.update(found)
        return out
