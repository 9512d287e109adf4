"""`sunder bench`: speed beside the limits of the machine."""
from __future__ import annotations

import argparse
from pathlib import Path

from sunder_tools.command.parser import Subparsers, add_command

from ..validation.measure import bench

NAME = "bench"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder bench`."""
    parser = add_command(
        subparsers, NAME, "measure speed beside the machine's limits",
        "Minima over interleaved repetitions, and the machine's multiply-add peak and bandwidth in the\n"
        "same run; what a window's exchange with an engine in another process costs, and a whole run. Numbers\n"
        "stand beside goals and limits; exit status 1 where one is beyond its limit.")
    parser.add_argument("--filter", metavar="NAME", dest="pattern", help="benchmarks whose name holds NAME")
    parser.add_argument("--json", metavar="FILE", type=Path, dest="report", help="the numbers as JSON")
    parser.add_argument("--profile", metavar="FILE", type=Path,
                        help="draw the force kernel's rates under the machine's limits (.png, .svg or .pdf)")


def run(arguments: argparse.Namespace) -> int:
    """Runs the benchmarks; returns the exit status. Raises CommandError."""
    return bench(arguments.pattern, arguments.report, arguments.profile)
