"""`sunder fuzz`: garbage for everything that reads."""
from __future__ import annotations

import argparse

from sunder_tools.command.parser import Subparsers, add_command, count

from ..fuzz.fuzzers import DEFAULT_RUNS, TARGETS, fuzz

NAME = "fuzz"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder fuzz`."""
    parser = add_command(
        subparsers, NAME, "feed garbage to everything that reads",
        "Installs clang, builds fuzzers with sanitizers, and looks for input that does harm: messages of\n"
        "both sides, scenes, images, meshes. Exit status 1 where something is found.")
    parser.add_argument("--target", metavar="NAME", help=f"{', '.join(TARGETS[:-1])} or {TARGETS[-1]} only")
    parser.add_argument("--runs", metavar="N", type=count, default=DEFAULT_RUNS,
                        help=f"inputs for each (default: {DEFAULT_RUNS})")


def run(arguments: argparse.Namespace) -> int:
    """Fuzzes; returns the exit status. Raises CommandError."""
    return fuzz(arguments.target, arguments.runs)
