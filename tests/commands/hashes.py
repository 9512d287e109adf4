"""`sunder hashes`: whether what runs compute is the same to the bit."""
from __future__ import annotations

import argparse
from pathlib import Path

from sunder_tools.command.parser import Subparsers, add_command, count
from sunder_tools.errors import BAD_INPUT, CHECK_FAILED, DONE, CommandError
from sunder_tools.launch.build import build_dir, ensure_built
from sunder_tools.words import did_you_mean

from ..validation import hashes

NAME = "hashes"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder hashes`."""
    parser = add_command(
        subparsers, NAME, "state hashes of the scenes that ship, before and after a change",
        "Runs each scene, shortened, with one and two threads, and prints its state hash. Exit status 1 where a\n"
        "hash depends on the threads or is not that of --against.",
        example="sunder hashes --against before.json     (written by --json before.json before the change)")
    parser.add_argument("scenes", metavar="SCENE", nargs="*", help="names, e.g. glass or paper/fig13 (default: all)")
    parser.add_argument("--threads", metavar="N", type=count, action="append", help="repeatable (default: 1 and 2)")
    parser.add_argument("--json", metavar="FILE", type=Path, dest="report", help="the hashes, for --against")
    parser.add_argument("--against", metavar="FILE", type=Path, help="hashes of before")


def run(arguments: argparse.Namespace) -> int:
    """Runs the scenes; returns the exit status. Raises CommandError."""
    known = hashes.names()
    for name in arguments.scenes:
        if name not in known:
            raise CommandError(f"no scene '{name}' ships; {did_you_mean(name, known)}", BAD_INPUT)
    against = hashes.read(arguments.against) if arguments.against else {}
    ensure_built(targets=("sunder-single",))
    program = build_dir() / "coupler" / "single" / "sunder-single"
    rows = []
    print(hashes.HEADER, flush=True)
    for scene in arguments.scenes or known:
        for threads in arguments.threads or (1, 2):
            rows.append(hashes.hash_of(program, scene, threads))
            print(hashes.line(rows[-1], against), flush=True)
    if arguments.report:
        hashes.write(arguments.report, rows)
    wrong = hashes.unequal(rows, against)
    print(f"{len(rows)} runs, {len(wrong)} scenes differ{': ' + ', '.join(wrong) if wrong else ''}")
    return CHECK_FAILED if wrong else DONE
