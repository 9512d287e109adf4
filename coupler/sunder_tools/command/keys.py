"""`sunder keys`: keys for a run across machines."""
from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

from ..launch.build import ensure_built
from .parser import Subparsers, add_command

NAME = "keys"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder keys`."""
    parser = add_command(
        subparsers, NAME, "make keys for a run across machines",
        "Writes rigid.key and shell.key (secret, mode 0600) and both public keys into a new folder.\n"
        "Each machine needs its own secret key and both public ones.")
    parser.add_argument("folder", metavar="DIR", type=Path)


def run(arguments: argparse.Namespace) -> int:
    """Lets sunder-rigid make the keys; returns its exit status."""
    return subprocess.run([str(ensure_built().rigid), "--make-keys", str(arguments.folder)], check=False).returncode
