"""A folder of members of a series: their plan, their state and their results. Experiments and bisections build on
it."""
from __future__ import annotations

import fcntl
import os
import sys
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Iterator, Mapping

from sunder_tools.errors import CommandError, Interrupted
from sunder_tools.launch import engines
from sunder_tools.launch.build import ensure_built
from sunder_tools.launch.needs import reads_cad
from sunder_tools.pictures.plots import ENDINGS, Panel, write_panels
from sunder_tools.report.run_json import read_run

from .executors import Executor, Local, Slurm, default_jobs
from .member import KEEP, RUN_FOLDER, Member, is_done, outcome
from .scene import Results
from .table import Cell, Table, write_sqlite

MARK = "sunder-series"  # a file that marks the folder of a series
MEMBERS = "members"

Measure = Callable[[Results], Mapping[str, Any]]


@dataclass(frozen=True)
class Planned:
    """A planned row: its own columns, and the member that gives the others."""
    columns: dict[str, Cell]
    member: Member


Look = Callable[[Planned, Results], None]


@dataclass
class Settings:
    """Ways to run a series; none changes a result. `jobs` 0: as many as the processors can run at once. `check`: whether
    the solver's own check is asked before the first run. `plots`: ending of a file of the plots beside plots.png, svg or pdf."""
    out: Path | str
    jobs: int = 0
    executor: str = "local"
    threads: int = 1
    keep: str = "last"
    sbatch: list[str] = field(default_factory=list)
    quiet: bool = False
    check: bool = True
    plots: str = ""

    def make(self) -> Executor:
        """Returns the executor. Raises CommandError for an unknown one."""
        if self.executor == "local":
            return Local(self.jobs or default_jobs(self.threads))
        if self.executor == "slurm":
            return Slurm(Path(self.out).resolve(), self.threads, self.jobs, self.sbatch)
        raise CommandError(f"--executor {self.executor}: there are local and slurm")

    def jobs_at_once(self) -> int:
        """Returns how many runs there are at a time; 1 where that is not known."""
        return self.jobs or (default_jobs(self.threads) if self.executor == "local" else 1)

    def say(self, words: str, always: bool = False) -> None:
        """Prints progress on stderr."""
        if always or not self.quiet:
            print(f"sunder: {words}", file=sys.stderr, flush=True)


def member(out: Path | str, name: str) -> Results:
    """Opens the run behind a row of a table; `name` is its column `member`. Raises CommandError where there is none."""
    return Results(Path(out) / MEMBERS / name / RUN_FOLDER)


def warnings_of(run: Path) -> list[str] | None:
    """Returns the warnings of a run; None where it has written no run.json."""
    told = read_run(run)
    if "status" not in told:
        return None
    found = told.get("warnings")
    return [str(one) for one in found] if isinstance(found, list) else []


class Campaign:
    """Context manager: holds the folder for this process alone, runs members in it, and makes tables of them."""

    def __init__(self, settings: Settings) -> None:
        """Opens the folder. Raises CommandError where it is no folder of a series, or another series is running in
        it."""
        if settings.plots and f".{settings.plots}" not in ENDINGS:
            raise CommandError(f"plots '{settings.plots}': there are {', '.join(ending[1:] for ending in ENDINGS)}")
        if settings.keep not in KEEP:
            raise CommandError(f"keep '{settings.keep}': there are {', '.join(KEEP)}")
        self.settings, self.executor, self.folder = settings, settings.make(), Path(settings.out)
        try:
            if self.folder.is_dir() and any(self.folder.iterdir()) and not (self.folder / MARK).is_file():
                raise CommandError(f"--out {self.folder}: holds other files and no series; give a new or an empty folder")
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / MARK).touch()  # first: another series that looks in now sees a folder of a series
            (self.folder / MEMBERS).mkdir(exist_ok=True)
        except OSError as error:
            raise CommandError(f"--out {self.folder}: cannot be written: {error.strerror}; name a folder that you may write to") from None
        self._handle = os.open(self.folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._handle)
            raise CommandError(f"--out {self.folder}: another series is running there") from None

    def __enter__(self) -> "Campaign":
        return self

    def __exit__(self, *exception: object) -> None:
        os.close(self._handle)

    def place(self, member: Member) -> Path:
        """Returns its folder."""
        return (self.folder / MEMBERS / member.identity()).resolve()

    def run(self, planned: list[Planned], look: Look | None = None) -> None:
        """Runs members that are not done. A member that has failed earlier is tried once more.

        `look` sees the first member that is done, before the others are run where it was done earlier. What it raises
        ends the runs that are under way.
        """
        places = {self.place(p.member): p for p in planned}
        remaining = [place for place in places if not is_done(place)]
        self.say(f"{len(places)} runs, {len(places) - len(remaining)} of them done already")
        done = next((p for p in planned if is_done(self.place(p.member))), None)
        if done is not None and look is not None:
            look(done, Results(self.place(done.member) / RUN_FOLDER))
            look = None
        if not remaining:
            return
        executables = ensure_built(cad=any(reads_cad(places[place].member.scene.text()) for place in remaining))
        for engine in dict.fromkeys(places[place].member.engine for place in remaining):
            engines.check(engine, engines.resolve(engine, executables), executables)
        for place in remaining:
            places[place].member.prepare(place, self.settings.threads, self.settings.keep)
        count = 0

        def ended(place: Path) -> None:
            nonlocal count, look
            count += 1
            found = outcome(place)
            words = ", ".join(f"{k} {v}" for k, v in places[place].columns.items())
            self.say(f"[{count}/{len(remaining)}] {found.get('status', 'unknown')} {words}"
                      + (f": {found['error']}" if found.get("error") else ""))
            if look is not None and found.get("status") == "done":
                look(places[place], Results(place / RUN_FOLDER))
                look = None

        self.executor.run(remaining, ended)

    def table(self, planned: list[Planned], measure: Measure) -> tuple[Table, Table]:
        """Returns the table of results, and a table of values that differ between runs: times, hosts, builds.

        A member that failed has its error in `error`, and so has one that could not be measured. `warnings` is the number of
        sentences in its run.json.
        """
        rows: list[dict[str, object]] = []
        times: list[dict[str, object]] = []
        for p in planned:
            place = self.place(p.member)
            found = outcome(place)
            row = {"member": place.name, **p.columns, "status": found.get("status", "not run"),
                   "error": found.get("error") or None}
            told = warnings_of(place / RUN_FOLDER)
            row["warnings"] = None if told is None else len(told)
            if row["status"] == "done":
                try:
                    row.update(measure(Results(place / RUN_FOLDER)))
                except Exception as error:  # noqa: BLE001: the measure is the user's; the other rows stand
                    row["status"], row["error"] = "not measured", f"{type(error).__name__}: {error}".replace(
                        f"{place}/", "")
            rows.append(row)
            spent: dict[str, object] = {k: found.get(k) for k in ("wall_s", "processor_s", "host", "program")}
            times.append({"member": place.name} | spent)
        programs = {str(t["program"]) for t in times if t["program"]}
        if len(programs) > 1:
            self.say(f"runs of {len(programs)} different builds of the solver are in this table, see times.csv; a new "
                      "--out runs all anew", always=True)
        return Table(rows), Table(times)

    @contextmanager
    def kept(self, planned: list[Planned], measure: Measure) -> Iterator[None]:
        """Context of runs: where they are interrupted, tables of what is done are written, and it is said how far it is."""
        try:
            yield
        except (Interrupted, KeyboardInterrupt):
            self.write(*self.table(planned, measure))
            done = sum(is_done(self.place(p.member)) for p in planned)
            self.say(f"{done} of {len(planned)} runs done, in {self.folder / 'results.csv'}; the same command goes on", always=True)
            raise

    def write(self, results: Table, times: Table) -> None:
        """Writes results.csv, times.csv, and results.sqlite with both."""
        results.write_csv(self.folder / "results.csv")
        times.write_csv(self.folder / "times.csv")
        write_sqlite(self.folder / "results.sqlite", {"results": results, "times": times})

    def draw(self, panels: list[Panel], name: str) -> None:
        """Writes plots into the folder as NAME.png, and with another ending where that is asked for. Says why where that
        cannot be, since results are there all the same."""
        for ending in ENDINGS:
            (self.folder / name).with_suffix(ending).unlink(missing_ok=True)
        for ending in dict.fromkeys((".png", f".{self.settings.plots}" if self.settings.plots else ".png")):
            try:
                if panels:
                    write_panels(panels, (self.folder / name).with_suffix(ending))
            except (CommandError, OSError) as error:
                self.say(f"{name}{ending} is not drawn: {error}", always=True)

    def say(self, words: str, always: bool = False) -> None:
        """Prints progress on stderr."""
        self.settings.say(words, always)
