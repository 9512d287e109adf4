"""`sunder trade`: what each setting of a scene costs, and what error it leaves."""
from __future__ import annotations

import argparse
from pathlib import Path

from ..launch.build import ensure_built
from .parser import Subparsers, add_choice, add_command, add_scene, add_settings, count, positive_seconds

NAME = "trade"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder trade`."""
    parser = add_command(
        subparsers, NAME, "measure what each setting of a scene costs and what error it leaves",
        "Runs the scene as it is, a reference as fine as the budget allows, then one setting changed at a time,\n"
        "cheapest first, then several together. Writes trade.csv, trade.json, trade.png and results.csv (a row a\n"
        "run). Stopped or killed, it goes on with the same command; a larger budget adds to what is there.",
        "sunder trade scenes/intact_pane.textproto --budget 5")
    add_scene(parser)
    parser.add_argument("--budget", metavar="MINUTES", type=float, default=10.0,
                        help="processor time of all runs, both processes (default: 10)")
    parser.add_argument("--out", metavar="DIR", type=Path, help="folder of the trade (default: trades/<name of SCENE>)")
    parser.add_argument("--json", metavar="FILE", type=Path, dest="report", help="write trade.json to this file as well")
    parser.add_argument("--vary", metavar="NAMES", default="", help="vary these settings only, e.g. elements,window")
    parser.add_argument("--seeds", metavar="N", type=count, help="runs of each setting (default: 4 where it cracks, else 1)")
    add_settings(parser, "change a field of the scene first; repeatable")
    parser.add_argument("--until", metavar="SECONDS", type=positive_seconds, help="end each run at this simulated time")
    parser.add_argument("--rigid", metavar="ENGINE", default="bullet", help="as 'run' takes it (default: bullet)")
    parser.add_argument("--threads", metavar="N", type=count, default=1, help="threads of each run (default: 1)")
    parser.add_argument("--jobs", metavar="N", type=count, default=1,
                        help="runs at a time (default: 1, which disturbs times least)")
    add_choice(parser, "--plots", ("png", "svg", "pdf"), "the plot also as trade.svg or trade.pdf", "png")
    parser.add_argument("--quiet", action="store_true", help="no progress, only the outcome")


def run(arguments: argparse.Namespace) -> int:
    """Measures; returns the exit status. Raises CommandError."""
    ensure_built()  # and installed: sunder_lab needs protobuf and numpy
    from sunder_lab.trade import command
    return command.trade(arguments)
