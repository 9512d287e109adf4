"""`sunder paper`: from the command line to runs, pictures and page."""
from __future__ import annotations

import argparse
import sys
from dataclasses import astuple
from pathlib import Path

from sunder_tools.errors import CHECK_FAILED, DONE, INTERRUPTED, CommandError
from sunder_tools.pictures.vtp import VtpError

from .checks import checks_of, said, verdict
from .figures import FIGURES, Figure
from .page import write_page
from .runs import Runs

OUT = Path("paper")


def paper(options: argparse.Namespace) -> int:
    """Runs and draws what `options` ask for (see `sunder paper --help`); returns the exit status: 1 where a run or a picture
    failed, or a check that is not known to. Raises CommandError."""
    wanted = [FIGURES[number] for number in options.figures or FIGURES]
    runs = Runs(options.out or OUT, options.size, options.threads, options.quiet)
    runs.open()
    try:
        return _run_and_draw(options, wanted, runs)
    finally:
        runs.close()


def _run_and_draw(options: argparse.Namespace, wanted: list[Figure], runs: Runs) -> int:
    status = DONE
    for figure in wanted:
        if figure.draw is None and options.figures:
            print(f"figure {figure.number}: {figure.says}", flush=True)
    made = [figure for figure in wanted if figure.draw is not None]
    runs.plan([case for figure in made for case in figure.cases])
    try:
        for figure in made:
            if not runs.run(figure.cases):
                return INTERRUPTED
            good = not any(runs.failure(case) for case in figure.cases) and draw(runs, figure, bool(options.figures))
            status = status if good else CHECK_FAILED
            write_page(runs)
    finally:
        page = write_page(runs)
    print(page)
    return status if all([_hold(runs, figure) for figure in made]) else CHECK_FAILED


def _hold(runs: Runs, figure: Figure) -> bool:
    """Whether all checks of a figure hold or are known not to; tells those that fail."""
    try:
        failed = [check for check in checks_of(runs, figure.number, figure.cases) if verdict(check, runs.size) == "failed"]
    except (VtpError, OSError) as error:
        print(f"sunder: the books of figure {figure.number} are not checked: {error}", file=sys.stderr, flush=True)
        return False
    for check in failed:
        print(f"sunder: figure {figure.number}: {said(check, runs.size)}", file=sys.stderr, flush=True)
    return not failed


def draw(runs: Runs, figure: Figure, again: bool) -> bool:
    """Draws a figure whose runs are done, unless it was drawn from the same ones; returns whether its pictures are there."""
    assert figure.draw is not None
    of = {case: runs.identity(case) for case in figure.cases}
    kept = runs.record.figures.get(str(figure.number), {})
    if not again and kept.get("of") == of and "checks" in kept and kept.get("pictures") and all(
            (runs.folder / name).is_file() for name, _ in kept["pictures"]):
        return True
    try:
        drawn = figure.draw(runs)
        runs.record.figures[str(figure.number)] = {"of": of, "pictures": drawn.pictures, "found": drawn.found,
                                                    "checks": [astuple(check) for check in drawn.checks]}
    except VtpError as error:
        print(f"sunder: figure {figure.number} is not drawn: {error}", file=sys.stderr, flush=True)
        runs.record.figures[str(figure.number)] = {"of": of, "pictures": [], "found": [], "failed": str(error)}
    except OSError as error:
        raise CommandError(f"figure {figure.number}: {error.filename or runs.folder}: {error.strerror}; free some space there, or "
                           "name another --out") from None
    runs.record.write()
    return bool(runs.record.figures[str(figure.number)]["pictures"])
