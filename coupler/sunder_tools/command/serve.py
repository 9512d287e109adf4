"""`sunder serve`: an engine that waits for a run on another machine."""
from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

from ..errors import CommandError
from ..launch import engines
from ..launch.build import ensure_built
from .parser import Subparsers, add_command

NAME = "serve"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder serve`."""
    parser = add_command(
        subparsers, NAME, "wait with an engine for a run on another machine",
        "Serves one session and ends with it. On the other machine:\n"
        "  sunder run SCENE --rigid tcp://THIS_MACHINE:PORT --keys DIR")
    parser.add_argument("--endpoint", metavar="ADDRESS", required=True, help="tcp://0.0.0.0:PORT, or ipc://PATH")
    parser.add_argument("--rigid", metavar="ENGINE", default="bullet", help="its name or program (default: bullet)")
    parser.add_argument("--keys", metavar="DIR", type=Path,
                        help="folder made by 'sunder keys', the same on both machines")


def run(arguments: argparse.Namespace) -> int:
    """Serves one session; returns the engine's exit status. Raises CommandError."""
    executables = ensure_built()
    rigid = engines.resolve(arguments.rigid, executables)
    if not rigid.command:
        raise CommandError(f"--rigid {arguments.rigid}: is no engine that can be launched; give a name or a program")
    engines.check(arguments.rigid, rigid, executables)
    keys = ["--keys", str(arguments.keys)] if arguments.keys else []
    return subprocess.run([*rigid.command, "--endpoint", arguments.endpoint, *keys, "--die-with-parent"],
                          check=False).returncode
