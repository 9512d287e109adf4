"""`sunder engines`: which rigid-body engines there are and what they can do."""
from __future__ import annotations

import argparse

from ..errors import DONE
from ..launch import engines
from ..launch.build import ensure_built
from .parser import Subparsers, add_command

NAME = "engines"


def add_parser(subparsers: Subparsers) -> None:
    """`sunder engines` has no arguments."""
    add_command(subparsers, NAME, "list the rigid-body engines and what they can do",
                "Launches each engine and asks it; rigid/README.md says what the words promise.")


def run(arguments: argparse.Namespace) -> int:
    """Prints the table; returns the exit status."""
    del arguments
    print(engines.table(ensure_built()))
    return DONE
