"""`sunder bench`: speed beside the limits of the machine."""
from __future__ import annotations

import argparse
from pathlib import Path

from sunder_tools.command.parser import Subparsers, add_command
from sunder_tools.errors import BAD_INPUT, CommandError

from ..validation.measure import bench, bench_runs

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
    parser.add_argument("--json", metavar="FILE", type=Path, dest="report", help="the numbers as JSON")
    parser.add_argument("--profile", metavar="FILE", type=Path,
                        help="draw the force kernel's rates under the machine's limits (.png, .svg or .pdf)")


def run(arguments: argparse.Namespace) -> int:
    """Runs the benchmarks; returns the exit status. Raises CommandError."""
    if arguments.runs:
        for option, given in (("--filter", arguments.pattern), ("--profile", arguments.profile)):
            if given is not None:
                raise CommandError(f"bench: {option} chooses among kernels, and --runs measures whole runs; leave one of them out",
                                   BAD_INPUT)
        return bench_runs(arguments.report)
    return bench(arguments.pattern, arguments.report, arguments.profile)
