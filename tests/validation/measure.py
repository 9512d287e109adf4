"""`validate` and `bench`: run the measuring programs, judge their rows, write tables and plots."""
from __future__ import annotations

import itertools
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Mapping

from sunder_tools.errors import BAD_INPUT, CHECK_FAILED, DONE, INTERRUPTED, PEER_LOST, CommandError
from sunder_tools.launch.build import ensure_built
from sunder_tools.words import did_you_mean

from ..benchmarks import against, goals
from ..conformance import suites
from .experiments import EXPERIMENTS, Table, run_experiments
from .extremes.suite import validate_extremes
from .known import KNOWN, holds, judge, read_known
from .programs import interrupted_after, program, run_program

VALIDATIONS = ("shells", "seams", "cracks", "contact", "soft", "surfaces", "coupling", "engines", "extremes")


def validate(what: str, case: str | None, report: Path | None, plots: Path | None,
             pictures: Path | None = None, rigid: str | None = None, full: bool = False, known: bool = False,
             leave_out: str | None = None, expect: Path | None = None) -> int:
    """Runs the validation cases of `what`. The exit status is 1 where a case fails; with `known`, only where a
    failure is not known or its error is larger than the known one. Where the user interrupts it, what ran is judged and
    written, with `ran` and `left` in the JSON, and the status is 130."""
    if what not in VALIDATIONS:
        raise CommandError(f"nothing called '{what}' to validate; {did_you_mean(what, VALIDATIONS)}", BAD_INPUT)
    if rigid and what != "engines":
        raise CommandError(f"--rigid {rigid}: only 'validate engines' takes it", BAD_INPUT)
    if full and what != "extremes":
        raise CommandError("--full: only 'validate extremes' takes it", BAD_INPUT)
    if known and what in ("engines", "extremes"):
        raise CommandError(f"--known: not with 'validate {what}', which "
                           + ("always judges so" if what == "engines" else "has nothing that is known to fail"), BAD_INPUT)
    if case == "":
        raise CommandError("--case: empty; name a case, or leave it out for all", BAD_INPUT)
    if report is not None:
        _can_write(report)
    if plots is not None and what not in ("engines", "extremes"):
        _can_plot(plots)
    if what == "extremes":
        if plots is not None or pictures is not None:
            raise CommandError("validate extremes: draws nothing; leave --plots and --pictures out", BAD_INPUT)
        return _extremes(case, report, full)
    if what == "engines":
        if plots is not None or pictures is not None:
            raise CommandError("validate engines: draws nothing; leave --plots and --pictures out", BAD_INPUT)
        return _engines(suites.Chosen(case, leave_out, expect), report, rigid)
    if pictures is not None:
        _make_folder(pictures)
    started = time.time()
    gaps = read_known(KNOWN / f"{what}.txt")
    runs = EXPERIMENTS.get(what, ())
    chosen = tuple(e for e in runs if e.name == case or case is None and not e.by_name)
    if case is not None and not chosen:
        names = _listed(what) and (*case_names(what), *cases_by_name(what))  # none: the program says what is wrong with it
        if names and case not in names:
            raise CommandError(f"--case {case}: suite {what} has no such case; {did_you_mean(case, names)}", BAD_INPUT)
    status, found = DONE, dict[str, Any](cases=[], curves=[], ran={}, left=[])
    if case is None or not chosen:
        status = _by_program(what, case, found)
        if status not in (DONE, CHECK_FAILED, INTERRUPTED):
            return status
    table = Table(headed=bool(found["cases"]), pictures=pictures, ran=found["ran"])
    left = [*found["left"], *(run_experiments(chosen, table) if status != INTERRUPTED else (e.name for e in chosen))]
    found |= {"cases": found["cases"] + table.rows, "curves": found["curves"] + table.curves, "left": left}
    if not all(holds(row) for row in table.rows):
        status = CHECK_FAILED
    good, lines = judge(found["cases"], gaps, every=case is None and not left)
    if lines:
        print("\n".join(lines), flush=True)
    if left:
        status = INTERRUPTED
        print(interrupted_after(len(found["ran"]), len(left)), flush=True)
    else:
        del found["ran"], found["left"]
    if known and status in (DONE, CHECK_FAILED):
        status = DONE if good else CHECK_FAILED
    if pictures is not None and all(p.stat().st_mtime < started for p in pictures.iterdir()):
        print("picture          none: these cases draw none", flush=True)
    curves = found.pop("curves")
    if report is not None:
        _write(report, json.dumps(_without_nan(found), indent=1) + "\n")
    if plots is not None and curves:
        from sunder_tools.pictures.plots import Curve, write_plots
        try:
            write_plots([Curve(**curve) for curve in curves], plots)
        except OSError as error:
            raise CommandError(f"cannot write {plots}: {error}", BAD_INPUT) from None
        print(f"plots            {plots}")
    return status


def _by_program(what: str, case: str | None, found: dict[str, Any]) -> int:
    """Runs the cases of sunder-validate, and adds what it writes to `found`; returns its exit status. One that is
    interrupted has written what ran so far."""
    with tempfile.TemporaryDirectory() as folder:
        numbers = Path(folder) / "validation.json"
        command = [str(program("sunder-validate")), what, "--json", str(numbers), "--threads", str(os.cpu_count() or 1)]
        status = run_program(command + (["--case", case] if case else []))
        if numbers.is_file():
            found.update(json.loads(numbers.read_text()))
        elif status == INTERRUPTED:
            found["left"] = [case] if case else _listed(what)
        elif status in (DONE, CHECK_FAILED):
            raise CommandError(f"sunder-validate ended with status {status} and wrote no rows", PEER_LOST)
    return status


def case_names(what: str) -> tuple[str, ...]:
    """Returns the names of the cases of a suite; empty for `engines` and `extremes`, whose rows are their cases. Cases
    that run only where they are named are left out; see cases_by_name. Raises CommandError."""
    if what in ("engines", "extremes"):
        return ()
    return (*_listed(what), *(e.name for e in EXPERIMENTS.get(what, ()) if not e.by_name))


def cases_by_name(what: str) -> tuple[str, ...]:
    """Returns the names of the cases of a suite that run only where they are named. Raises CommandError."""
    return (*_listed(f"{what}, by name"), *(e.name for e in EXPERIMENTS.get(what, ()) if e.by_name))


def _listed(heading: str) -> tuple[str, ...]:
    """The cases below a heading of `sunder-validate --list`."""
    told = subprocess.run([str(program("sunder-validate")), "--list"], stdout=subprocess.PIPE, text=True, check=False).stdout
    part = f"\n{told}".partition(f"\n{heading}:\n")[2].splitlines()
    return tuple(line.split()[0] for line in itertools.takewhile(lambda line: line.startswith("  "), part))


def _engines(chosen: suites.Chosen, report: Path | None, rigid: str | None) -> int:
    suite = program("sunder-conformance")
    status, found = suites.run_suites(suite, ensure_built(), chosen, rigid)
    if found:
        print(suites.table(found))
    if status == INTERRUPTED:
        ran = sum(len(suites.by_case(result["cases"])) for result in found.values())
        print(interrupted_after(ran, sum(len(result.get("left", ())) for result in found.values())))
    if report is not None and found:
        _write(report, json.dumps({"engines": found}, indent=1) + "\n")
    return status


def _extremes(case: str | None, report: Path | None, full: bool) -> int:
    found, good = validate_extremes(case, full, ensure_built(targets=("sunder-single",)))
    if report is not None:
        _write(report, json.dumps(_without_nan(found), indent=1) + "\n")
    return INTERRUPTED if "left" in found else DONE if good else CHECK_FAILED


def _without_nan(value: object) -> object:
    """Writes NaN as null, since JSON has no NaN."""
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def bench(pattern: str | None, report: Path | None, profile: Path | None = None) -> int:
    """Runs the benchmarks with `pattern` in their names, and prints their numbers beside goals and limits. The exit status
    is 1 where a number is beyond its limit. `profile`: draws the rates of the force kernel there. Where the user interrupts
    it, the numbers so far are printed and written, and the status is 130."""
    command = [str(program("sunder-bench"))]
    if pattern:
        command += ["--filter", pattern]
    if report is not None:
        _can_write(report)
    if profile is not None:
        if pattern:
            raise CommandError(f"--profile {profile}: takes kernels and limits that --filter {pattern} leaves out; leave --filter out",
                               BAD_INPUT)
        _can_plot(profile, "--profile")
    with tempfile.TemporaryDirectory() as folder:
        kept = Path(folder) / "bench.json"
        status = run_program([*command, "--json", str(kept)])
        if status != DONE and not (status == INTERRUPTED and kept.is_file()):
            return status
        found = goals.with_ratios(json.loads(kept.read_text()))
        if report is not None:
            _write(report, json.dumps(found, indent=2) + "\n")
        if status == INTERRUPTED:
            print("\n".join(goals.lines(found)))
            print(f"interrupted: {len(found)} number{'' if len(found) == 1 else 's'} so far, others are left", flush=True)
            return status
        if profile is not None:
            _draw_kernels(found, profile)
    return judged(found)


def bench_other(folder: Path, pattern: str | None, rounds: int, report: Path | None) -> int:
    """Compares the benchmarks with those of another build folder. The exit status is 1 where a kernel is slower than there.
    Raises CommandError."""
    if report is not None:
        _can_write(report)
    against.other_program(folder)  # before anything is built
    table, status = against.bench_against(program("sunder-bench"), folder, pattern, rounds)
    if report is not None and table:
        _write(report, json.dumps(_without_nan({"cases": [one.row for one in table]}), indent=1) + "\n")
    return status


def bench_runs(report: Path | None) -> int:
    """Measures whole runs, and prints their numbers beside goals and limits. The exit status is 1 where one is beyond its
    limit."""
    if report is not None:
        _can_write(report)
    from ..benchmarks.runs import measure_runs  # numpy and PIL only now
    found = measure_runs(ensure_built())
    return keep_judged(found, report)


def keep_judged(numbers: dict[str, float], report: Path | None) -> int:
    """Writes numbers where that is asked, and prints them beside goals and limits; returns the exit status."""
    if report is not None:
        _write(report, json.dumps(_without_nan(numbers), indent=1) + "\n")
    return judged(dict(numbers))


def judged(numbers: Mapping[str, float | None]) -> int:
    """Prints numbers beside goals and limits; returns 1 where one is beyond its limit. JSON has null for one that is no
    number."""
    finite = {key: math.nan if value is None else value for key, value in numbers.items()}
    print("\n".join(goals.lines(finite)), flush=True)
    failed = goals.beyond(finite)
    if failed:
        print(f"sunder: beyond the limit: {', '.join(failed)}", file=sys.stderr)
    return CHECK_FAILED if failed else DONE


def _draw_kernels(numbers: dict[str, float], path: Path) -> None:
    """Draws the force kernel at each size under the limits of the same run. Raises OSError."""
    from sunder_tools.pictures.plots import write_panels
    from sunder_tools.pictures.roofline import Rate, roofs
    key = "force_ns_per_layer_point_"
    sizes = [name.removeprefix(key) for name in numbers if re.fullmatch(key + r"\d+k", name)]
    operations, moved, peak, memory = (numbers[name] for name in (
        "operations_per_layer_point", "bytes_per_layer_point", "fma_peak_gflops", "memory_gb_per_s"))
    sizes.sort(key=lambda size: int(size[:-1]))
    write_panels([roofs(peak, [Rate(f"force, {size} layer points", operations / moved, operations / numbers[key + size],
                                    memory) for size in sizes], "rates of the force kernel, one thread")], path)


def _can_write(path: Path) -> None:
    """Checks that a file can be written, before minutes are spent. Raises CommandError; does not change an existing
    file."""
    new = not os.path.lexists(path)
    try:
        path.open("a").close()
        if new:
            path.unlink()
    except OSError as error:
        raise CommandError(f"cannot write {path}: {error.strerror or error}", BAD_INPUT) from None


def _can_plot(path: Path, option: str = "--plots") -> None:
    from sunder_tools.pictures.plots import ENDINGS, need_matplotlib
    if path.suffix not in ENDINGS:
        raise CommandError(f"{option}: cannot write {path}: '{path.suffix}' is none of {', '.join(ENDINGS)}", BAD_INPUT)
    _can_write(path)
    try:
        need_matplotlib()
    except CommandError as error:
        raise CommandError(f"{option}: {error}", BAD_INPUT) from None


def _make_folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CommandError(f"cannot write into {path}: {error.strerror or error}", BAD_INPUT) from None
    if not os.access(path, os.W_OK | os.X_OK):
        raise CommandError(f"cannot write into {path}: Permission denied", BAD_INPUT)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text)
    except OSError as error:
        raise CommandError(f"cannot write {path}: {error.strerror or error}", BAD_INPUT) from None
