"""`validate extremes`: scenes far from any use, each with what is expected of it, run by the real programs."""
from __future__ import annotations

import csv
import math
import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Iterator, Sequence

from sunder_tools.errors import BAD_INPUT, DONE, PHYSICS, CommandError, Interrupted, how_it_ended
from sunder_tools.launch.build import Executables
from sunder_tools.places import REPOSITORY
from sunder_tools.report.run_json import read_run

from ..programs import interrupted_after

SCENE_FILE = "extreme.textproto"
MOST_LEDGER = 1e-12  # of the impulses: what each window promises
KILLED = "killed"    # at its time limit, in place of an exit status
LOOK_S = 1.0         # between two looks at how long it has computed
ENDING_S = 10.0      # of processor time, that it may take to end once it is told to
BUSY = 8.0           # so many times its limit a row may take where others compute


@dataclass(frozen=True)
class Outcome:
    """What a run has left: exit status or KILLED, words on stderr, run.json, and columns of its tables."""
    status: int | str
    words: str
    run: dict[str, Any]
    series: dict[str, list[float]]
    probes: dict[str, list[float]]
    shards: dict[str, list[float]]
    seconds: float


@dataclass(frozen=True)
class Quantity:
    """A number with an exact answer; the tolerance is relative, absolute where the reference is zero."""
    name: str
    computed: float
    reference: float
    tolerance: float

    def error(self) -> float:
        return abs(self.computed / self.reference - 1.0) if self.reference != 0.0 else abs(self.computed)

    def good(self) -> bool:
        return self.error() <= self.tolerance  # NaN is not


class Expectation:
    """What a row says beforehand. `judge` returns what was found, and what is wrong about it ('' if nothing)."""

    def judge(self, found: Outcome, scene: str) -> tuple[str, str]:
        raise NotImplementedError

    def number(self, found: Outcome) -> Quantity:
        """The same as a number for the report."""
        raise NotImplementedError


# A value that looks as if it were given in another unit: most of these rows have one, on purpose.
DOUBT = r"(materials|shells|bodies)\[[^]]*\]\.[a-z_.]+ is [-+.0-9e]+ (Pa|kg/m\^3|m|m/s)[ ,;]"


@dataclass(frozen=True)
class Stable(Expectation):
    """Runs to its end, every number finite, and the energy books within `bound` at every window. It warns where `warns` is
    given, and of `also` where that is, and only with what these patterns match from its begin."""
    bound: float
    warns: str = ""
    also: str = ""

    def __str__(self) -> str:
        return f"stable, energy within {self.bound:.0e}" + "".join(f", warns: {wanted}" for wanted in self._wanted)

    @property
    def _wanted(self) -> list[str]:
        return [wanted for wanted in (self.warns, self.also) if wanted]

    def judge(self, found: Outcome, scene: str) -> tuple[str, str]:
        run, wrong = found.run, []
        if found.status != DONE or run.get("status") != "done":
            return _ending(found), "did not run to its end"
        told = {wanted: [w for w in run["warnings"] if re.match(wanted, w)] for wanted in self._wanted}
        if other := [w for w in run["warnings"] if w not in sum(told.values(), []) and not re.match(DOUBT, w)]:
            wrong.append(f"warns: {other[0]}")
        wrong += [f"does not warn: {wanted}" for wanted, found_ones in told.items() if not found_ones]
        if not _all_finite([run, found.series, found.probes, found.shards]):
            wrong.append("a number is not finite")
        if not max(run["ledger"].values()) <= MOST_LEDGER:
            wrong.append(f"ledger {max(run['ledger'].values()):.1e}")
        worst = _worst_residual(found)
        if not worst <= self.bound:
            wrong.append(f"energy {worst:.1e}")
        return f"{worst:.1e}", "; ".join(wrong)

    def number(self, found: Outcome) -> Quantity:
        return Quantity("", _worst_residual(found) if found.status == DONE else math.nan, 0.0, self.bound)


@dataclass(frozen=True)
class Refused(Expectation):
    """Ends with status 2 before anything is written, and names the file, the line that begins with `line`, and `field`."""
    field: str
    line: str

    def __str__(self) -> str:
        return f"refused: {self.field}"

    def judge(self, found: Outcome, scene: str) -> tuple[str, str]:
        if found.status != BAD_INPUT:
            return _ending(found), "was not refused"
        lines = [n for n, text in enumerate(scene.splitlines(), 1) if text.strip().startswith(self.line)]
        if len(lines) != 1:
            raise CommandError(f"the scene has {len(lines)} lines that begin with '{self.line}'")
        said = re.search(rf"{re.escape(SCENE_FILE)}:(\d+):\d+: (\S+?):? ", found.words)
        if not said:
            return _ending(found), "names no line and field"
        where = f"line {said[1]}, {said[2]}"
        wrong = "" if int(said[1]) == lines[0] and said[2] == self.field else f"expected line {lines[0]}, {self.field}"
        return where, wrong if not found.run else "run.json was written"

    def number(self, found: Outcome) -> Quantity:
        return Quantity("", _status_number(found), BAD_INPUT, 0.0)


@dataclass(frozen=True)
class Stopped(Expectation):
    """Ends with status 4 and says why: kind of the error, and words of its message."""
    kind: str
    says: str

    def __str__(self) -> str:
        return f"stopped: {self.kind}"

    def judge(self, found: Outcome, scene: str) -> tuple[str, str]:
        error = found.run.get("error") or {}
        if found.status != PHYSICS or found.run.get("status") != "failed":
            return _ending(found), "was not stopped"
        right = error.get("kind") == self.kind and self.says in str(error.get("message"))
        return f"{error.get('kind')}: {error.get('message')}", "" if right else f"expected '{self.says}'"

    def number(self, found: Outcome) -> Quantity:
        return Quantity("", _status_number(found), PHYSICS, 0.0)


Check = Callable[[Outcome, "Runner"], Sequence[Quantity]]


@dataclass(frozen=True)
class Row:
    """A scene and what is expected of it. `check` compares with exact answers; `groups` name it for --case."""
    name: str
    scene: str
    expected: Expectation
    check: Check | None = None
    limit_s: float = 60.0     # of processor time, some ten times what it takes: beyond it the row counts as one that hangs
    full: bool = False        # long: with --full, or by name
    processes: int = 1
    engine: str = "bullet"
    files: dict[str, str] = field(default_factory=dict)  # beside the scene


class Runner:
    """Runs scenes in a temporary folder; one that several rows compare with is run once."""

    def __init__(self, executables: Executables) -> None:
        self.executables = executables
        self._known: dict[tuple[str, str], Outcome] = {}

    def compare_with(self, scene: str, limit_s: float = 60.0, engine: str = "bullet") -> Outcome:
        """A scene whose result another one is held to. Raises CommandError where it does not run."""
        known = scene, engine
        if known not in self._known:
            found = self.run(Row("reference", scene, Stable(1.0), limit_s=limit_s, engine=engine))
            if found.status != DONE:
                raise CommandError(f"what it is compared with does not run: {_ending(found)}")
            self._known[known] = found
        return self._known[known]

    def run(self, row: Row) -> Outcome:
        with tempfile.TemporaryDirectory(prefix="extreme-sunder-") as name:
            folder, out = Path(name), Path(name) / "out"
            scene = folder / SCENE_FILE
            scene.write_text(row.scene)
            for path, text in row.files.items():
                (folder / path).write_text(text)
            if row.processes == 1:
                command = [str(self.executables.single), "--engine", row.engine]
            else:
                command = [sys.executable, str(REPOSITORY / "coupler" / "sunder"), "run", "--rigid", row.engine]
            start = time.monotonic()
            if row.processes == 1:  # `run` does so by itself
                command += ["--scene", str(scene)]
                checked = subprocess.run([*command, "--check"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                         stderr=subprocess.PIPE, text=True, errors="replace", check=False)
                if checked.returncode != DONE:
                    return Outcome(checked.returncode, checked.stderr.strip(), {}, {}, {}, {}, time.monotonic() - start)
            else:
                command.append(str(scene))
            command += ["--out", str(out), "--threads", "1", "--quiet"]
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.PIPE, text=True, errors="replace")
            status: int | str
            try:
                words = _until_it_ends(process, row.limit_s)
                status = process.returncode
            except subprocess.TimeoutExpired:
                process.terminate()  # of two processes the command ends both
                try:
                    words = _until_it_ends(process, processor_s(process.pid) + ENDING_S)
                except subprocess.TimeoutExpired:
                    process.kill()
                    _, words = process.communicate()
                status = KILLED
            finally:
                if process.poll() is None:
                    process.kill()
                    process.wait()
            return Outcome(status, words.strip(), read_run(out), _columns(out / "series.csv"), _columns(out / "probes.csv"),
                           _columns(out / "shards.csv"), time.monotonic() - start)


def _until_it_ends(process: subprocess.Popen[str], limit_s: float) -> str:
    """What it said on stderr. Raises TimeoutExpired once it has computed for so long, or been there for BUSY times that:
    on a machine that has much else to do a row does not hang because it has to wait."""
    start = time.monotonic()
    while True:
        try:
            return process.communicate(timeout=LOOK_S)[1]
        except subprocess.TimeoutExpired:
            if processor_s(process.pid) > limit_s or time.monotonic() - start > BUSY * limit_s:
                raise


def processor_s(pid: int) -> float:
    """[s] of processor that a process and all that it has started have used; those that have been waited for, too."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        children = [int(child) for task in Path(f"/proc/{pid}/task").iterdir() for child in (task / "children").read_text().split()]
    except OSError:  # it has just ended
        return 0.0
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK") + sum(map(processor_s, children))


def run_rows(rows: Sequence[Row], executables: Executables) -> tuple[dict[str, object], bool]:
    """Runs them one after the other and prints the table; returns the `cases` of the report, and whether all is well. Where
    the user interrupts them, the report also has the rows that `ran`, with their number of cases, and those that are
    `left`."""
    runner = Runner(executables)
    cases: list[dict[str, object]] = []
    ran: dict[str, int] = {}
    print("| row | expected | found | s |\n| --- | --- | --- | --- |")
    good = True
    start = time.monotonic()
    for row in rows:
        try:
            text, new = run_row(row, runner)
        except (Interrupted, KeyboardInterrupt):
            break
        cases += new
        ran[row.name] = len(new)
        passed = all(case["pass"] for case in new)
        good = good and passed
        print(f"| `{row.name}` | {row.expected} | {text} | {new[0]['seconds']} |", flush=True)
    failed = len({str(case["name"]).split(":")[0] for case in cases if not case["pass"]})
    print(f"\n{len(ran)} rows, {failed} failed, {time.monotonic() - start:.0f} s")
    left = [row.name for row in rows[len(ran):]]
    if left:
        print(interrupted_after(len(ran), len(left), "row"))
    return {"cases": cases, **({"ran": ran, "left": left} if left else {})}, good


def run_row(row: Row, runner: Runner) -> tuple[str, list[dict[str, object]]]:
    """Runs one and judges it; returns what the table says, and the cases of the report: itself, and its quantities."""
    found = runner.run(row)
    if found.status == KILLED:
        text, wrong = f"killed after {row.limit_s:g} s of processor, or {BUSY:g} times that", "hangs"
    else:
        text, wrong = row.expected.judge(found, row.scene)
    quantities: Sequence[Quantity] = ()
    if row.check is not None and not wrong:
        try:
            quantities = row.check(found, runner)
        except (CommandError, KeyError, IndexError, ValueError, ZeroDivisionError) as error:
            wrong = f"{type(error).__name__}: {error}"
    for q in quantities:
        text += f"; {q.name} {q.error():.1e}" + ("" if q.good() else f" **above {q.tolerance:.0e}**")
    if wrong:
        text = f"**{wrong}** ({text})"
    seed = re.search(r"\bseed: (\d+)", row.scene)
    own = row.expected.number(found)
    cases = [{"name": row.name, "computed": own.computed, "reference": own.reference, "error": own.error(),
              "tolerance": own.tolerance, "pass": not wrong, "seconds": round(found.seconds, 2),
              "seed": int(seed[1]) if seed else 0, "expected": str(row.expected), "found": text}]
    cases += [{"name": f"{row.name}: {q.name}", "computed": q.computed, "reference": q.reference, "error": q.error(),
               "tolerance": q.tolerance, "pass": q.good(), "seconds": 0.0, "seed": cases[0]["seed"]} for q in quantities]
    return text.replace("\n", " "), cases


def choose(rows: Sequence[Row], case: str | None, full: bool) -> list[Row]:
    """Those of a name, or whose name begins with it and an underscore; else all that are not long. Raises CommandError."""
    if case is None:
        return [row for row in rows if full or not row.full]
    chosen = [row for row in rows if row.name == case] or [
        row for row in rows if row.name.startswith(case + "_") and (full or not row.full)]
    if not chosen:
        raise CommandError(f"no row is called '{case}'; there are: {' '.join(row.name for row in rows)}", BAD_INPUT)
    return chosen


def _status_number(found: Outcome) -> float:
    return float(found.status) if isinstance(found.status, int) else math.nan


def _ending(found: Outcome) -> str:
    if found.status == KILLED:
        return KILLED
    said = found.words.splitlines()
    return f"{how_it_ended(int(found.status))}{': ' + said[-1] if said else ''}"


def _worst_residual(found: Outcome) -> float:
    """Of the most energy there was: run.json and series.csv have it over the most there was until then."""
    most, worst = 0.0, []
    for kinetic, elastic, residual in zip(*(found.series.get(name, []) for name in ("kinetic", "elastic", "residual"))):
        most = max(most, kinetic + elastic)
        worst.append(abs(residual) * most)
    last = abs(found.run.get("energy", {}).get("residual_relative", math.nan))
    return max(last, max(worst) / most if most > 0.0 else last)


def _numbers(value: object) -> Iterator[float]:
    if isinstance(value, dict):
        for item in value.values():
            yield from _numbers(item)
    elif isinstance(value, list):
        for item in value:
            yield from _numbers(item)
    elif isinstance(value, (int, float)):
        yield float(value)


def _all_finite(values: object) -> bool:
    return all(math.isfinite(number) for number in _numbers(values))


def _columns(path: Path) -> dict[str, list[float]]:
    """Columns by name without unit. Empty cells, of shells that are frozen, are left out; {} without the file."""
    try:
        with path.open(newline="") as source:
            head, *rows = list(csv.reader(source))
    except (OSError, ValueError):
        return {}
    return {name.split(" [")[0]: [float(row[k]) for row in rows if row[k]] for k, name in enumerate(head)}
