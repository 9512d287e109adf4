"""`sunder sweep`: the experiments that a Python file defines."""
from __future__ import annotations

import argparse
from pathlib import Path

from ..launch.build import ensure_built
from .parser import Subparsers, add_choice, add_command, count

NAME = "sweep"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder sweep`."""
    parser = add_command(
        subparsers, NAME, "run the experiments that a Python file defines",
        "Runs every combination of parameters and seeds that is not done yet, and writes results.csv,\n"
        "results.sqlite, times.csv and plots.png. Ctrl-C writes the tables of what is done.\n"
        "Stopped or killed, it goes on with the same command.\n"
        "A run that fails is a row with its error, and exit status 1; the others are run.",
        "sunder sweep coupler/experiments/radial_cracks.py")
    parser.add_argument("file", metavar="FILE", type=Path, help="Python file with a sunder.Experiment or sunder.V50")
    parser.add_argument("--out", metavar="DIR", type=Path, help="folder of the series (default: sweeps/<name of FILE>)")
    parser.add_argument("--jobs", metavar="N", type=count,
                        help="runs at a time (default: processors / threads; for an\narray: as many as Slurm admits)")
    add_choice(parser, "--executor", ("local", "slurm"),
               "processes of this machine, or a Slurm job array; DIR is then on a disk that all nodes share", "local")
    parser.add_argument("--sbatch", metavar="OPTION", action="append", default=[],
                        help="for sbatch, e.g. --sbatch=--partition=long; repeatable")
    parser.add_argument("--threads", metavar="N", type=count, default=1, help="threads of each run (default: 1)")
    add_choice(parser, "--keep", ("last", "all", "none"),
               "frames that stay: first and last with crack lines of all times (default), all, or none", "last")
    add_choice(parser, "--plots", ("png", "svg", "pdf"), "the plots also as plots.svg or plots.pdf", "png")
    parser.add_argument("--quiet", action="store_true", help="no progress, only the outcome")


def run(arguments: argparse.Namespace) -> int:
    """Runs the series; returns the exit status. Raises CommandError."""
    ensure_built()  # and installed: sunder_lab needs protobuf and numpy
    from sunder_lab import sweep
    return sweep.sweep(arguments.file, sweep.settings_of(
        arguments.file, arguments.out, arguments.jobs, arguments.executor, arguments.threads, arguments.keep,
        arguments.sbatch, arguments.quiet, arguments.plots))
