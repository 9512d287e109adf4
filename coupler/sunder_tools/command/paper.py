"""`sunder paper`: the figures and the table of the paper."""
from __future__ import annotations

import argparse
from pathlib import Path

from ..launch.build import ensure_built
from .parser import Subparsers, add_choice, add_command, threads

NAME = "paper"
FIGURES = 18


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder paper`."""
    parser = add_command(
        subparsers, NAME, "run and draw the figures of the paper",
        "Runs the scenes of the figures, draws each as the paper shows it, and writes a page with the pictures, what the\n"
        "paper says, what came out and what differs, and Table 2 beside ours: OUT/SIZE/index.html. Stopped or killed, it\n"
        "goes on with the same command: what is done with the same scene and size is not run again. Exit status 1 where a\n"
        "run fails, or where a figure asked for by its number cannot be made.",
        "sunder paper --figure 9 --size small")
    parser.add_argument("--figure", metavar="N", dest="figures", action="append", type=_figure, default=[],
                        help=f"this figure only, 1 to {FIGURES}, drawn anew; repeatable (default: all)")
    add_choice(parser, "--size", ("small", "full"),
               "small: each run under a minute on an idle core; full: the points of\nthe paper's Table 2 (default: small)", "small")
    parser.add_argument("--out", metavar="DIR", type=Path, help="folder of runs, pictures and page (default: paper)")
    parser.add_argument("--threads", metavar="N", type=threads, help="threads of the shell solver (default: all)")
    parser.add_argument("--quiet", action="store_true", help="no progress, only the outcome")


def _figure(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= FIGURES:
        raise argparse.ArgumentTypeError(f"'{text}' is no figure of the paper, which has 1 to {FIGURES}")
    return int(text)


def run(arguments: argparse.Namespace) -> int:
    """Runs and draws; returns the exit status. Raises CommandError."""
    ensure_built()  # and installed: sunder_lab needs protobuf and numpy
    from sunder_lab.paper import command
    return command.paper(arguments)
