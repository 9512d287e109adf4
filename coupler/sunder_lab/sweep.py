"""`sunder sweep FILE`: runs the experiments that a Python file defines."""
from __future__ import annotations

import runpy
import sys
import traceback
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Union

from sunder_tools.errors import BAD_INPUT, CHECK_FAILED, DONE, CommandError, Interrupted
from sunder_tools.pictures.plots import ENDINGS

from .campaign import MEMBERS, Settings, warnings_of
from .experiment import Experiment
from .forecast import kinds
from .member import RUN_FOLDER
from .statistics import student
from .table import ENOUGH, Cell, Table
from .v50 import V50, Ballistic

Series = Union[Experiment, V50]


def sweep(file: Path, settings: Settings) -> int:
    """Runs every series of `file`. The exit status is 1 where a member failed; the others have been run."""
    found = series_of(file)
    for series in found:
        series.plan()  # reports errors of all series before the first one runs
    places = {series.name: Path(settings.out) / (series.name if len(found) > 1 else "") for series in found}
    for series in found:
        series.announce(replace(settings, out=places[series.name]))
    status = DONE
    for series in found:
        out = places[series.name]
        here = replace(settings, out=out, check=False)
        done = series.run(here)
        if isinstance(done, Table):
            status = max(status, _tell_table(series, done))
            for line in [*_warnings(out, done), *_unsettled(done), *_few(done)]:
                print(line)
        else:
            status = max(status, _tell_v50(series, done))
        print(f"table            {out / 'results.csv'}, {out / 'results.sqlite'}")
        if drawn := [str(out / f"plots{ending}") for ending in ENDINGS if (out / f"plots{ending}").is_file()]:
            print(f"plots            {', '.join(drawn)}")
    return status


def series_of(file: Path) -> list[Series]:
    """Returns the experiments and bisections among the names that a Python file defines. Raises CommandError."""
    if not file.is_file():
        raise CommandError(f"{file}: no such file")
    sys.path.insert(0, str(file.resolve().parent))  # files beside it can be imported, as for a script
    try:
        names = runpy.run_path(str(file), run_name="__sweep__")
    except (CommandError, Interrupted):
        raise
    except BaseException as error:  # noqa: BLE001: whatever the file does, SystemExit too
        where = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == str(file)]
        line = getattr(error, "lineno", None) or (where[-1] if where else "?")
        raise CommandError(f"{file}:{line}: {type(error).__name__}: {error}") from None
    finally:
        sys.path.pop(0)
    found = [value for name, value in names.items() if not name.startswith("_") and isinstance(value, (Experiment, V50))]
    found = list({id(value): value for value in found}.values())
    if not found:
        raise CommandError(f"{file}: defines no sunder.Experiment and no sunder.V50")
    if len({value.name.casefold() for value in found}) != len(found):
        raise CommandError(f"{file}: two series of one name, or of names that differ in case only; each has a folder of its own")
    for value in found:
        if not value.name or "/" in value.name or value.name.startswith("."):
            raise CommandError(f"{file}: a series cannot be called '{value.name}': it is a folder's name")
    return found


def _tell_table(series: Series, table: Table) -> int:
    bad = [row for row in table if row["status"] != "done"]
    print(f"{series.name:<16} {len(table) - len(bad)} of {len(table)} runs done")
    for row in bad:
        print(f"{row['status']:<16} {_settings(table, row)}: {row['error']}")
    return CHECK_FAILED if bad else DONE


def _settings(table: Table, row: dict[str, Cell]) -> str:
    """What makes a row: its parameters and its seed."""
    return ", ".join(f"{k} {row[k]}" for k in table.columns[1:table.columns.index("status")])


def _warnings(out: Path, table: Table) -> list[str]:
    """What the runs of a series warn of, a line for each kind: how many runs, and the first of them, its settings and its folder,
    in its own words."""
    told = [(row, warning) for row in table
            for warning in warnings_of(out / MEMBERS / str(row["member"]) / RUN_FOLDER) or []]
    return [f"warning          {len({row['member'] for row, _ in found})} of {len(table)} runs, first {_settings(table, found[0][0])} "
            f"({found[0][0]['member']}): {found[0][1]}" for found in kinds(told)]


def _unsettled(table: Table) -> list[str]:
    """A line where runs end before the body of `sunder.impact` has arrived, or while it is still pushed."""
    if "settled" not in table.columns:
        return []
    told = [row for row in table if row["status"] == "done"]
    early = [row for row in told if row["settled"] == 0.0]
    return [f"warning          {len(early)} of {len(told)} runs end before the body has arrived or while it is still pushed "
            "(settled is 0): what they give as final is of that moment; set a later end_time_s"] if early else []


def _few(table: Table) -> list[str]:
    """A line where seeds and repeats are too few for means that can be trusted."""
    if "seed" not in table.columns or not len(table):
        return []
    chance = ("member", "seed", "repeat")
    of = table.columns[:table.columns.index("status")]
    runs = Counter(tuple(str(row[name]) for name in of if name not in chance) for row in table)
    least = min(runs.values())
    if least >= ENOUGH:
        return []
    wide = f"half of the 95 % interval of their mean is {student(0.95, least - 1):.3g} standard errors" if least > 1 else \
        "nothing is known of their scatter"
    return [f"warning          {least} run{'s' * (least > 1)} of the same values: {wide}; take {ENOUGH} seeds or more"] if least > 1 or \
        _cracks(table) else []


def _cracks(table: Table) -> bool:
    """Whether cracks are measured in some run, so that seeds play a part."""
    return any(row.get("crack_length_m") or row.get("radial_cracks") for row in table)


def _tell_v50(series: Series, found: Ballistic) -> int:
    assert isinstance(series, V50)
    print(f"{series.name:<16} V50 {found.v50:.4g} m/s, {found.low:.4g} to {found.high:.4g} with {found.confidence:.1%} "
          f"confidence, +- {found.resolution:.2g} of bisection, {len(found.limits)} panes")
    lost = len(series.seeds) - len(found.limits)
    if lost:
        print(f"left out         {lost} panes with a run that failed or was not decided; see results.csv")
    return CHECK_FAILED if lost else DONE


def settings_of(file: Path, out: Path | None, jobs: int | None, executor: str, threads: int, keep: str,
                sbatch: list[str], quiet: bool, plots: str = "") -> Settings:
    """Reads the command line. The default folder is sweeps/NAME, so that a second call continues the series."""
    if sbatch and executor != "slurm":
        raise CommandError("--sbatch: is for --executor slurm", BAD_INPUT)
    return Settings(out or Path("sweeps") / file.stem, jobs or 0, executor, threads, keep, sbatch, quiet, plots=plots)
