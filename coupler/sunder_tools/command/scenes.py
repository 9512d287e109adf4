"""`sunder scenes`: the scenes that ship."""
from __future__ import annotations

import argparse
import shutil
import textwrap

from ..errors import BAD_INPUT, DONE, CommandError
from ..launch.shipped import Shipped, measure, shipped
from .parser import Subparsers, add_command

NAME = "scenes"
INDENT = 30  # characters before what a scene shows


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder scenes`."""
    parser = add_command(subparsers, NAME, "list the scenes that ship",
                         "A line a scene: its name, the processor's seconds that a run took where that was measured, what it shows.")
    parser.add_argument("--measure", action="store_true",
                        help="run the scenes and write scenes/seconds.json; without names all but those of the paper, which takes hours")
    parser.add_argument("names", metavar="NAME", nargs="*", help="with --measure: these scenes only")


def run(arguments: argparse.Namespace) -> int:
    """Measures where that is asked, then prints the list; returns the exit status. Raises CommandError."""
    if arguments.names and not arguments.measure:
        raise CommandError(f"scenes: '{arguments.names[0]}': names go with --measure only", BAD_INPUT)
    if arguments.measure:
        measure(arguments.names)
    print(table(shipped(), shutil.get_terminal_size().columns))
    return DONE


def table(scenes: list[Shipped], columns: int) -> str:
    """The list within so many columns of text."""
    lines = [f"{'scene':<22}{'cpu s':>6}  what it shows"]
    for scene in scenes:
        seconds = "" if scene.seconds is None else f"{scene.seconds:.3g}"
        lines.append(textwrap.fill(scene.about, max(columns, 2 * INDENT), initial_indent=f"{scene.name:<22}{seconds:>6}  ",
                                   subsequent_indent=" " * INDENT))
    return "\n".join(lines)
