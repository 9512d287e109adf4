"""`sunder models`: which models were active in runs, and their share of the time."""
from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import DONE
from ..report import models
from .parser import Subparsers, add_command

NAME = "models"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder models`."""
    parser = add_command(
        subparsers, NAME, "list the active models of runs and their share of the time",
        "Prints one line per run from its run.json, and why each model was active. Models of one stage share its time.")
    parser.add_argument("folders", metavar="DIR", type=Path, nargs="+", help="folders of runs")


def run(arguments: argparse.Namespace) -> int:
    """Prints the table; returns the exit status. Raises CommandError."""
    print(models.table(arguments.folders))
    return DONE
