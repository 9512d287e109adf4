"""`sunder view`: a run in the browser."""
from __future__ import annotations

import argparse

from .parser import Subparsers, add_command, add_run_folder

NAME = "view"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder view`."""
    parser = add_command(
        subparsers, NAME, "play a run in the browser",
        "Serves a page to this machine only, until Ctrl-C. The page follows a run that is still under way.")
    add_run_folder(parser)
    parser.add_argument("--port", metavar="PORT", type=_port, default=0, help="port of 127.0.0.1 (default: a free one)")
    parser.add_argument("--no-browser", action="store_true", help="print the address only")


def run(arguments: argparse.Namespace) -> int:
    """Serves until interrupted; returns the exit status. Raises CommandError."""
    from ..pictures.view import view
    return view(arguments.folder, arguments.port, not arguments.no_browser)


def _port(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"'{text}' is not a port, 0 to 65535")
    return int(text)
