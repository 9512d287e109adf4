"""`sunder build`: installs packages and builds, without a run."""
from __future__ import annotations

import argparse
import os

from ..errors import BAD_INPUT, DONE, CommandError
from ..launch.build import ensure_built
from ..places import BUILD_DIR_VARIABLE, CHECKOUT_ONLY, INSTALLED
from .parser import Subparsers, add_command

NAME = "build"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder build`."""
    parser = add_command(subparsers, NAME, "install and build; 'sunder run' does so by itself",
                         "Installs the packages and builds both programs, before a first run needs them.")
    parser.add_argument("--cad", action="store_true",
                        help="with OpenCASCADE, which reads STEP and IGES; later builds keep it. A scene with a\nCAD file does so by itself")


def run(arguments: argparse.Namespace) -> int:
    """Builds; returns the exit status. Raises CommandError."""
    if os.environ.get(BUILD_DIR_VARIABLE):
        raise CommandError(f"{BUILD_DIR_VARIABLE} is set: nothing is built then; unset it to build this checkout",
                           BAD_INPUT)
    if INSTALLED.is_file():
        raise CommandError(f"this {CHECKOUT_ONLY}", BAD_INPUT)
    ensure_built(cad=arguments.cad)
    return DONE
