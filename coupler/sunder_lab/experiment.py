"""`Experiment`: runs a scene with every combination of parameters, seeds and repeats, and makes a table of results."""
from __future__ import annotations

import itertools
import random
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence, Union

from sunder_tools.errors import CommandError
from sunder_tools.pictures.plots import Line, Panel, write_panels

from .campaign import Campaign, Measure, Planned, Settings
from .impact import impact
from .member import Member
from .scene import Scene, Value
from .table import Cell, Table

SEED_PATH = "fracture.seed"
# Columns of every table; no parameter and no measure may use these names.
OWN = ("member", "seed", "repeat", "status", "error")

To = Union[str, Sequence[str], Mapping[str, Callable[[Any], Value]], Callable[[Scene, Any], None]]


@dataclass(frozen=True)
class Parameter:
    """Values of a parameter, and the place in the scene that takes them: a path; several paths with the same value;
    paths with a function of the value (`{"bodies[ball].twist.linear.z": lambda speed: -speed}`); or a function that
    changes the scene."""
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
    interval, and every run as a dot. There is a line for each value of column `by`."""
    x: str
    y: str
    by: str | None = None
    logarithmic: bool = False
    title: str = ""

    def panel(self, table: Table) -> Panel:
        """Draws the panel. Raises CommandError where a column is missing."""
        lines = []
        for key in dict.fromkeys(table[self.by].tolist()) if self.by else [None]:
            part = table.where(**{self.by: key}) if self.by else table
            means = [m for m in part.means(self.y, [self.x]) if m.count]
            dots = [(x, y) for x, y in zip(part[self.x], part[self.y])] if any(m.count > 1 for m in means) else []
            lines.append(Line(f"{self.by} {key:g}" if isinstance(key, (int, float)) else f"{self.by} {key}",
                              [m.key[self.x] for m in means], [m.mean for m in means], [m.half for m in means], dots))
        return Panel(self.title or f"{self.y} over {self.x}", self.x, self.y, lines, self.logarithmic)


@dataclass
class Experiment:
    """A series of runs of one scene.

    Every combination of `parameters` is run with every seed (of the strength's scatter), `repeats` times. What differs
    between repeats is `scatter`: paths whose value is moved by up to so much either way, evenly, the same for the same
    seed and repeat. Without it repeats are the same to the bit, and more than one is refused.

    A parameter is a `Parameter`, or a list of values where its name is a path itself. `measure` makes columns of a run's
    `Results`; several may be given.
    """
    name: str
    scene: Scene
    parameters: Mapping[str, Parameter | Sequence[Any]]
    seeds: Sequence[int] = ()  # none: the scene's own
    repeats: int = 1
    scatter: Mapping[str, float] = field(default_factory=dict)
    measure: Measure | Sequence[Measure] = field(default_factory=impact)
    plots: Sequence[Plot] = ()
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
        if faults:
            raise CommandError(f"{self.name}: nothing was run\n" + "\n".join(faults))
        rows = []
        for values in itertools.product(*(p.values for p in parameters.values())):
            for seed in self.seeds or (None,):
                for repeat in range(self.repeats):
                    rows.append(self._planned(parameters, values, seed, repeat))
        return rows

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

    def run(self, settings: Settings | Path | str) -> Table:
        """Runs members that have not been run, and writes results.csv, results.sqlite, times.csv and plots.png into
        a folder."""
        planned = self.plan()
        settings = settings if isinstance(settings, Settings) else Settings(settings)
        with Campaign(settings) as campaign:
            campaign.run(planned)
            results, times = campaign.table(planned, self._measured)
            campaign.write(results, times)
            self._draw(Table(row for row in results if row["status"] == "done"), campaign)
        return results

    def _draw(self, done: Table, campaign: Campaign) -> None:
        """Writes plots.png. A plot of a missing column does not lose results."""
        panels = []
        for plot in self.plots if len(done) else ():
            try:
                panels.append(plot.panel(done))
            except CommandError as error:
                campaign.say(f"plot of {plot.y} over {plot.x}: {error}", always=True)
        if panels:
            write_panels(panels, campaign.folder / "plots.png")

    def _measured(self, results: Any) -> dict[str, Any]:
        out: dict[str, Any] = {}
        for measure in [self.measure] if callable(self.measure) else self.measure:
            found = measure(results)
            taken = [name for name in found if name in out or name in self.parameters or name in OWN]
            if taken:
                raise ValueError(f"a measure gives a column that there is already: {', '.join(taken)}")
            out.update(found)
        return out
