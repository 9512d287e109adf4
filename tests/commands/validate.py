"""`sunder validate`: exact and published answers beside those computed."""
from __future__ import annotations

import argparse
from pathlib import Path

from sunder_tools.command.parser import Subparsers, add_command, number_above_zero
from sunder_tools.errors import BAD_INPUT, CommandError

from ..validation.measure import VALIDATIONS, validate

NAME = "validate"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder validate`."""
    parser = add_command(
        subparsers, NAME, "compare with exact and published answers",
        "A table of case, computed, reference, error, tolerance, seconds; exit status 1 where a case fails.")
    parser.add_argument("what", metavar="WHAT", help=f"{', '.join(VALIDATIONS[:-1])} or {VALIDATIONS[-1]}")
    parser.add_argument("--case", metavar="NAME", help="this case only; with engines also several, NAME,NAME")
    parser.add_argument("--list", action="store_true", help="with engines: print the cases with what they need, and end")
    parser.add_argument("--leave-out", metavar="NAME", help="with engines: not these cases, NAME,NAME")
    parser.add_argument("--expect", metavar="FILE", type=Path,
                        help="with engines --rigid: rows that are known to fail, NAME LARGEST_ERROR WHY, as in\n"
                             "tests/conformance/known; one that is not there, or is worse or passes, is status 1")
    parser.add_argument("--full", action="store_true", help="with extremes: the long rows as well")
    parser.add_argument("--known", action="store_true",
                        help="exit status 0 where nothing fails but what is known to, as far as tests/validation/known allows")
    parser.add_argument("--rigid", metavar="ENGINE", help="with engines: this one only, as 'run' takes it")
    parser.add_argument("--session", metavar="RUN", type=Path,
                        help="with engines --rigid: play the recorded session of this run (or session.rec)\nto the engine, and "
                             "compare its replies window by window")
    parser.add_argument("--tolerance", metavar="F", type=number_above_zero,
                        help="with --session (default: 1e-9 for an engine with double_precision, else\n1e-4)")
    parser.add_argument("--json", metavar="FILE", type=Path, dest="report", help="the table as JSON")
    parser.add_argument("--plots", metavar="FILE.png", type=Path, help="plots of convergence")
    parser.add_argument("--pictures", metavar="DIR", type=Path, help="pictures of the runs, into this folder")


def run(arguments: argparse.Namespace) -> int:
    """Runs the cases; returns the exit status. Raises CommandError."""
    if arguments.session is not None:
        return _play(arguments)
    if arguments.tolerance is not None:
        raise CommandError("--tolerance: is for --session; leave it out", BAD_INPUT)
    for name in ("list", "leave_out", "expect"):
        if getattr(arguments, name) and arguments.what != "engines":
            raise CommandError(f"--{name.replace('_', '-')}: only 'validate engines' takes it", BAD_INPUT)
    if arguments.list:
        from ..validation.programs import program, run_program
        return run_program([str(program("sunder-conformance")), "--list"])
    if arguments.expect is not None and not arguments.rigid:
        raise CommandError("--expect: is for one engine; give --rigid ENGINE too, or leave it out: the engines that come with the "
                           "project have lists of their own", BAD_INPUT)
    return validate(arguments.what, arguments.case, arguments.report, arguments.plots, arguments.pictures,
                    arguments.rigid, arguments.full, arguments.known, arguments.leave_out, arguments.expect)


def _play(arguments: argparse.Namespace) -> int:
    if arguments.what != "engines" or not arguments.rigid:
        raise CommandError("--session: only 'validate engines --rigid ENGINE' takes it", BAD_INPUT)
    for name in ("case", "list", "leave_out", "expect", "full", "known", "plots", "pictures"):
        if getattr(arguments, name):
            raise CommandError(f"--{name.replace('_', '-')}: not with --session, which has no cases; leave it out", BAD_INPUT)
    from ..conformance.sessions import play_session
    return play_session(arguments.session, arguments.rigid, arguments.tolerance, arguments.report)
