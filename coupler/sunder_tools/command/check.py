"""`sunder check`: what the solver says of a scene before it runs."""
from __future__ import annotations

import argparse
import subprocess

from ..errors import PEER_LOST, CommandError, how_it_ended
from ..launch.needs import built_for
from ..launch.fidelity import with_fidelity
from .parser import Subparsers, add_command, add_scene, add_settings, need_scene
from .run import add_fidelity

NAME = "check"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder check`."""
    parser = add_command(subparsers, NAME, "check a scene and say what it will cost",
                         "Reports errors with line, field and remedy; else sizes, stable step, minutes, memory.")
    add_scene(parser)
    add_settings(parser, "change a field, e.g. shells[pane].thickness_m=0.003; repeatable")
    add_fidelity(parser)


def run(arguments: argparse.Namespace) -> int:
    """Hands the scene to sunder-shell --check; returns its exit status. Raises CommandError."""
    need_scene(arguments.scene)
    settings = with_fidelity(arguments.scene, arguments.settings, arguments.fidelity, quiet=False)
    executables = built_for(arguments.scene)
    command = [str(executables.shell), "--scene", str(arguments.scene), "--check"]
    status = subprocess.run(command + [part for s in settings for part in ("--set", s)], check=False).returncode
    if status < 0:
        raise CommandError(f"sunder-shell {how_it_ended(status)} while checking {arguments.scene}", PEER_LOST)
    return status
