"""`sunder bench`: speed beside the limits of the machine."""
from __future__ import annotations

import argparse
from pathlib import Path

from sunder_tools.command.parser import Subparsers, add_command
from sunder_tools.errors import BAD_INPUT, CommandError

from ..benchmarks.against import ROUNDS
from ..validation.measure import bench, bench_other, bench_runs

NAME = "bench"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder bench`."""
    parser = add_command(
        subparsers, NAME, "measure speed beside the machine's limits",
        "Minima over interleaved repetitions, and the machine's multiply-add peak and bandwidth in the\n"
        "same run; what a window's exchange with an engine in another process costs, and a whole run. Numbers\n"
        "stand beside goals and limits; exit status 1 where one is beyond its limit.")
    parser.add_argument("--filter", metavar="NAME", dest="pattern", help="benchmarks whose name holds NAME")
    parser.add_argument("--runs", action="store_true",
                        help="measure whole runs of shipped scenes instead, which takes minutes: what cracks, contact between "
                             "shells, and pictures take")
    parser.add_argument("--against", metavar="DIR", type=Path,
                        help="measure the benchmarks of the build folder DIR in turns with these, and compare; exit status 1\n"
                             "where a kernel is slower than there by more than 2 %%")
    parser.add_argument("--rounds", metavar="N", type=int, help=f"with --against: rounds of both (default: {ROUNDS})")
    parser.add_argument("--json", metavar="FILE", type=Path, dest="report", help="the numbers as JSON")
    parser.add_argument("--profile", metavar="FILE", type=Path,
                        help="draw the force kernel's rates under the machine's limits (.png, .svg or .pdf)")


def run(arguments: argparse.Namespace) -> int:
    """Runs the benchmarks; returns the exit status. Raises CommandError."""
    if arguments.rounds is not None and (arguments.against is None or arguments.rounds < 1):
        raise CommandError(f"bench: --rounds {arguments.rounds}: takes a number from 1 on, and goes with --against DIR", BAD_INPUT)
    if arguments.against is not None:
        for option, given in (("--runs", arguments.runs), ("--profile", arguments.profile)):
            if given:
                raise CommandError(f"bench: --against compares benchmarks; leave {option} out", BAD_INPUT)
        return bench_other(arguments.against, arguments.pattern, arguments.rounds or ROUNDS, arguments.report)
    if arguments.runs:
        for option, given in (("--filter", arguments.pattern), ("--profile", arguments.profile)):
            if given is not None:
                raise CommandError(f"bench: {option} chooses among kernels, and --runs measures whole runs; leave one of them out",
                                   BAD_INPUT)
        return bench_runs(arguments.report)
    return bench(arguments.pattern, arguments.report, arguments.profile)
