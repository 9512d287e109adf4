"""`sunder modes`: eigenfrequencies and modes of a scene's shells."""
from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from ..errors import PEER_LOST, CommandError, how_it_ended
from ..launch.needs import built_for
from ..launch.modes_folder import open_modes_folder
from .parser import Subparsers, add_command, add_scene, add_settings, count, need_scene, number_within, threads

NAME = "modes"
MOST = 1000  # modes, as the program takes them


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder modes`."""
    parser = add_command(
        subparsers, NAME, "eigenfrequencies and modes of a scene's shells",
        "Prints the lowest eigenfrequencies, and writes them to modes.json with a picture and frames for ParaView:\n"
        "frames.pvd has a frame of each mode, mode_01/frames.pvd one period of the first. Shells with equilibrium\n"
        "vibrate about it, prestressed; bodies, contact and damping do not enter.",
        "sunder modes scenes/intact_pane.textproto --count 6")
    add_scene(parser)
    add_settings(parser, "change a field, e.g. shells[pane].thickness_m=0.003; repeatable")
    parser.add_argument("--count", metavar="N", type=_modes, default=10, help="modes (default: 10)")
    parser.add_argument("--amplitude", metavar="SHARE", type=_share, default=0.1,
                        help="largest displacement that is drawn, over the size of the shells\n(default: 0.1)")
    parser.add_argument("--out", metavar="DIR", type=Path,
                        help="folder of the results; earlier modes there are replaced (default: runs/<scene>-modes)")
    parser.add_argument("--threads", metavar="N", type=threads, help="threads of the solver (default: all)")
    parser.add_argument("--no-pictures", dest="pictures", action="store_false", help="leave modes.png out")


def run(arguments: argparse.Namespace) -> int:
    """Hands the scene to sunder-shell --modes and draws; returns its exit status. Raises CommandError."""
    need_scene(arguments.scene)
    folder = open_modes_folder(arguments.out or Path("runs") / f"{arguments.scene.stem}-modes")
    command = [str(built_for(arguments.scene).shell), "--scene", str(arguments.scene), "--modes", str(arguments.count),
               "--amplitude", repr(arguments.amplitude), "--out", str(folder)]
    if arguments.threads:
        command += ["--threads", arguments.threads]
    status = subprocess.run(command + [part for s in arguments.settings for part in ("--set", s)], check=False).returncode
    if status < 0:
        raise CommandError(f"sunder-shell {how_it_ended(status)} while it sought modes of {arguments.scene}", PEER_LOST)
    if status != 0:
        return status
    if arguments.pictures:
        from ..pictures.modes_sheet import write_modes_sheet  # numpy and PIL only now
        write_modes_sheet(folder)
    print(f"sunder: {folder}", file=sys.stderr)
    return status


def _modes(text: str) -> int:
    number = count(text)
    if number > MOST:
        raise argparse.ArgumentTypeError(f"{number} modes; at most {MOST}")
    return number


def _share(text: str) -> float:
    return number_within(text, 1e-6, 1.0)
