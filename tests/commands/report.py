"""`sunder report`: runs suites and writes their results as pages."""
from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from sunder_tools.command.parser import Subparsers, add_command
from sunder_tools.errors import BAD_INPUT, CHECK_FAILED, DONE, INTERRUPTED, PEER_LOST, CommandError
from sunder_tools.launch import first_use
from sunder_tools.launch.build import build_dir
from sunder_tools.places import REPOSITORY
from sunder_tools.report.machine import circumstances, system
from sunder_tools.words import did_you_mean

from ..benchmarks import ci
from ..benchmarks.goals import beyond
from ..benchmarks.package import measure_package
from ..validation import first_times
from ..validation.known import WITHOUT_LIST
from ..validation.measure import VALIDATIONS, bench, bench_runs, case_names, keep_judged, validate
from ..validation.results import (BENCH, BENCH_RUNS, CI, FIRST_USE, NUMBERS, PACKAGE, WHOLE, Result, page, put_status, read_all,
                                  replace, result_of, today, write)

NAME = "report"
KEPT = (CI, FIRST_USE)  # suites that run nothing: they keep what was measured when something else ran
SUITES = (*VALIDATIONS, BENCH, BENCH_RUNS, PACKAGE, *KEPT)
PICTURES = "pictures"
TITLES = {"validation": "Results of validation", "benchmarks": "Results of benchmarks"}  # of pages, by folder of tests/


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder report`."""
    parser = add_command(
        subparsers, NAME, "run suites and write their results as pages",
        "Runs the suites named, all where none is, and keeps the JSON of each in tests/validation/results and\n"
        "tests/benchmarks/results. Writes RESULTS.md beside both and the status lines of README.md, from all JSON\n"
        "that is there: a suite can be renewed alone, with --case one case of it, and with --rigid the rows of one engine.\n"
        "Rows are judged by the lists of known failures as they are now. Ctrl-C keeps the cases that ran. package\n"
        "builds the Debian package, runs a scene with it, and measures its programs beside those of this checkout. Two run\n"
        "nothing. first_use keeps what the first picture of this checkout took, on a machine that had nothing, beside the\n"
        "times of other distributions; ci keeps what the steps of .ci/run took. Exit status 1 where a suite fails.\n"
        "'pictures' instead of a suite draws the pictures that pages show, which takes hours; with --picture one of them.\n"
        "Exit status 1 where this machine cannot draw one, which then stays as it is.",
        "sunder report shells contact\nsunder report cracks --case mirror\nsunder report pictures --picture glass")
    parser.add_argument("suites", metavar="SUITE", nargs="*", help=", ".join((*SUITES, PICTURES)))
    parser.add_argument("--case", metavar="NAME",
                        help="run this case only, and keep the other rows of the suite; with one SUITE of 'sunder validate'")
    parser.add_argument("--rigid", metavar="ENGINE",
                        help="with 'engines': hold this engine to the suite, and keep the rows of the others")
    parser.add_argument("--json-dir", metavar="DIR", type=Path,
                        help="keep the JSON in DIR/validation and DIR/benchmarks, the pages beside, and leave README.md alone")
    parser.add_argument("--picture", metavar="NAME", action="append", default=[],
                        help="with 'pictures': draw this one only, e.g. glass for scenes/glass.png; may be given again")
    parser.add_argument("--runs", metavar="DIR", type=Path,
                        help="with 'pictures': take the run of a scene from DIR/NAME, or run it into there")
    parser.add_argument("--deb", metavar="FILE", type=Path, help="with 'package': measure this package, and build none")
    parser.add_argument("--no-run", action="store_true", help="run nothing: write the pages anew from the JSON")


def run(arguments: argparse.Namespace) -> int:
    """Runs suites and writes pages; returns the exit status. Raises CommandError."""
    if PICTURES in arguments.suites:
        return _draw(arguments)
    if arguments.picture or arguments.runs:
        raise CommandError("report: --picture and --runs go with 'sunder report pictures'", BAD_INPUT)
    for suite in arguments.suites:
        if suite not in SUITES:
            raise CommandError(f"report: no suite '{suite}'; {did_you_mean(suite, (*SUITES, PICTURES))}", BAD_INPUT)
    if arguments.suites and arguments.no_run:
        raise CommandError(f"report: --no-run runs no suite; leave '{arguments.suites[0]}' out", BAD_INPUT)
    if arguments.case is not None and (len(arguments.suites) != 1 or arguments.suites[0] in NUMBERS):
        raise CommandError("report: --case goes with one suite of 'sunder validate', as in 'sunder report cracks --case mirror'",
                           BAD_INPUT)
    if arguments.rigid is not None and (arguments.suites != ["engines"] or arguments.case is not None):
        raise CommandError("report: --rigid goes with the suite 'engines' alone, as in 'sunder report engines --rigid mujoco'",
                           BAD_INPUT)
    if arguments.rigid is not None and not arguments.rigid.isidentifier():
        raise CommandError(f"report: --rigid {arguments.rigid}: the page has engines of this project, by their names; for a program "
                           "of yours take 'sunder validate engines --rigid PROGRAM'", BAD_INPUT)
    if arguments.deb is not None and arguments.suites != [PACKAGE]:
        raise CommandError("report: --deb goes with the suite 'package' alone, as in 'sunder report package --deb sunder.deb'", BAD_INPUT)
    top = arguments.json_dir or REPOSITORY / "tests"
    suites = () if arguments.no_run else arguments.suites or tuple(suite for suite in SUITES if suite not in KEPT)
    failed, ended = [], DONE
    for suite in suites:
        ended = run_suite(suite, folder_of(suite, top), arguments.case, arguments.rigid, arguments.deb)
        if ended == INTERRUPTED:
            break
        if ended != DONE:
            failed.append(suite)
    write_pages(top, None if arguments.json_dir else REPOSITORY / "README.md")
    if failed:
        print(f"sunder: these suites fail: {', '.join(failed)}", file=sys.stderr)
    if ended == INTERRUPTED:
        left = suites[suites.index(suite) + 1:]
        print(f"sunder: interrupted; what ran is kept{f', not run: ' + ', '.join(left) if left else ''}", file=sys.stderr)
        return INTERRUPTED
    return CHECK_FAILED if failed else DONE


def _draw(arguments: argparse.Namespace) -> int:
    if arguments.suites != [PICTURES] or arguments.case or arguments.json_dir or arguments.no_run:
        raise CommandError("report: 'pictures' stands alone, with --picture and --runs only", BAD_INPUT)
    from ..docs.pictures import draw_pictures  # numpy and PIL only now
    left = draw_pictures(arguments.picture, arguments.runs)
    return CHECK_FAILED if left else DONE


def folder_of(suite: str, top: Path) -> Path:
    """Where the JSON of a suite is kept."""
    return top / ("benchmarks" if suite in NUMBERS else "validation") / "results"


def run_suite(suite: str, folder: Path, case: str | None = None, rigid: str | None = None, deb: Path | None = None) -> int:
    """Runs a suite, or one case or engine of it, and keeps what it gives; returns its exit status. One that breaks leaves the
    earlier result. One that is interrupted renews the cases that ran; benchmarks are kept all or none."""
    only = case or rigid
    print(f"sunder: {suite}{f', {only}' if only else ''}", file=sys.stderr, flush=True)
    if suite in KEPT:
        good = (keep_first_use if suite == FIRST_USE else keep_ci)(folder, build_dir().parent)
        return DONE if good else CHECK_FAILED
    made_with, start = circumstances(build_dir()), time.monotonic()
    with tempfile.TemporaryDirectory(prefix="report-sunder-") as temporary:
        numbers = Path(temporary) / f"{suite}.json"
        try:
            if suite == PACKAGE:
                ended = keep_judged(measure_package(deb), numbers)
            elif suite in (BENCH, BENCH_RUNS):
                ended = bench(None, numbers) if suite == BENCH else bench_runs(numbers)
            else:
                ended = validate(suite, case, numbers, None, known=suite not in WITHOUT_LIST, rigid=rigid)
        except CommandError as error:
            if error.status != PEER_LOST:
                raise  # it could not begin: a build that fails, a program that is missing
            print(f"sunder: {suite}: {error}", file=sys.stderr)
            return CHECK_FAILED
        if ended == INTERRUPTED and (suite == BENCH or not numbers.is_file()):
            return INTERRUPTED
        if not numbers.is_file():
            print(f"sunder: {suite}: ended with status {ended} and wrote no JSON", file=sys.stderr)
            return CHECK_FAILED
        found = json.loads(numbers.read_text())
    seconds = time.monotonic() - start
    earlier = _earlier(suite, folder)
    if "engines" in found and (rigid or ended == INTERRUPTED):
        result = _with_engines(earlier, found["engines"], seconds, made_with)
    elif ended == INTERRUPTED:
        result = _with_cases(earlier, suite, found, made_with)
    else:
        result = result_of(suite, found, seconds, made_with, case or WHOLE, case_names(suite) if case else ())
        if case and earlier:
            result = earlier.with_case(result)
    if result is not None:
        write(result, folder)
    return ended


def _with_engines(result: Result | None, found: dict[str, dict[str, Any]], seconds: float,
                  made_with: dict[str, object]) -> Result | None:
    """Puts the rows of each engine in the place of its earlier ones; of one that was interrupted, those that it has."""
    for name, one in found.items():
        run = f"{name}, in part" if "left" in one else name
        part = result_of("engines", {"engines": {name: one}}, seconds / len(found), made_with, run)
        result = part if result is None else result.with_case(part) if "left" in one else result.with_engine(part, name)
    return result


def _with_cases(result: Result | None, suite: str, found: dict[str, Any], made_with: dict[str, object]) -> Result | None:
    """Puts the rows of each case that ran in the place of its earlier ones."""
    rows = found["cases"]
    for case, count in found["ran"].items():
        own, rows = rows[:count], rows[count:]
        part = result_of(suite, {"cases": own}, sum(row["seconds"] for row in own), made_with, case,
                         (*found["ran"], *found["left"]))
        result = part if result is None else result.with_case(part)
    return result


def keep_first_use(folder: Path, builds: Path) -> bool:
    """Keeps what the first picture took on this distribution, beside others. Raises CommandError where this checkout has not
    been built from nothing."""
    found, made_with = first_use.read(builds), first_use.made_with(builds)
    if not set(first_use.KEYS) <= set(found) or not made_with:
        raise CommandError(f"report: {builds / first_use.FILE} does not tell of a first use: run 'coupler/sunder run "
                           "scenes/glass.textproto' in a new checkout on a machine without its packages, then this", BAD_INPUT)
    seconds = found["first_picture_s"] + found.get(first_use.TEST_KEY, 0.0)
    name = str(made_with.get("system") or system())
    result = result_of(FIRST_USE, {name: first_times.with_run(found)}, seconds, made_with, name)
    good = not today([result])[0].count("fail")
    earlier = _earlier(FIRST_USE, folder)
    write(earlier.with_numbers(result) if earlier else result, folder)
    return good


def keep_ci(folder: Path, builds: Path) -> bool:
    """Keeps what the steps of .ci/run took. Raises CommandError where it has not run to its end on this commit."""
    numbers, made_with = ci.read(builds / ci.FILE), circumstances(build_dir())
    write(result_of(CI, dict(numbers), numbers[ci.WHOLE], made_with), folder)
    return not beyond(numbers)


def _earlier(suite: str, folder: Path) -> Result | None:
    return next((kept for kept in read_all(folder) if kept.suite == suite), None)


def kept(top: Path, room: str) -> list[Result]:
    """Results that are kept below `top` in `room`, one of TITLES, judged as of today. Raises CommandError."""
    order = {suite: k for k, suite in enumerate(SUITES)}
    return sorted(today(read_all(top / room / "results")), key=lambda result: order.get(result.suite, len(order)))


def write_pages(top: Path, readme: Path | None) -> None:
    """Both pages, and the status and times of a README."""
    found = {room: kept(top, room) for room in TITLES}
    for room, results in found.items():
        if results:
            path = top / room / "RESULTS.md"
            replace(path, page(TITLES[room], results))
            print(f"written          {path}")
    if readme is not None:
        put_status(readme, [result for results in found.values() for result in results])
        print(f"status           {readme}")
