"""`sunder`: finds the subcommands, reads the command line, runs one of them."""
from __future__ import annotations

import argparse
import difflib
import importlib
import os
import pkgutil
import signal
import sys
from types import FrameType, ModuleType
from typing import Sequence

from ..errors import BAD_INPUT, DONE, INTERRUPTED, CommandError, Interrupted
from .parser import EPILOG, Parser

DESCRIPTION = """\
Tears and shatters thin shells; the pieces fall in a rigid-body engine.
Installs and builds what is missing by itself.
"""


def subcommands(packages: Sequence[str]) -> dict[str, ModuleType]:
    """The subcommands in these packages, by name: every module that has a NAME."""
    found: dict[str, ModuleType] = {}
    for package in packages:
        for entry in pkgutil.iter_modules(importlib.import_module(package).__path__):
            module = importlib.import_module(f"{package}.{entry.name}")
            if hasattr(module, "NAME"):
                found[module.NAME] = module
    return dict(sorted(found.items()))


def make_parser(commands: dict[str, ModuleType]) -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    parser = Parser(prog="sunder", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG,
                    allow_abbrev=False, description=DESCRIPTION)
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", parser_class=Parser)
    for module in commands.values():
        module.add_parser(subparsers)
    return parser


def _suggestion(command: str, commands: Sequence[str]) -> str:
    near = difflib.get_close_matches(command, commands, n=1, cutoff=0.5)
    hint = f"did you mean '{near[0]}'?" if near else f"the commands are {', '.join(commands)}"
    return f"unknown command '{command}'; {hint} See 'sunder --help'"


def _dispatch(arguments: list[str], packages: Sequence[str]) -> int:
    commands = subcommands(packages)
    parser = make_parser(commands)
    if not arguments:
        parser.print_help(sys.stderr)
        return BAD_INPUT
    if not arguments[0].startswith("-") and arguments[0] not in commands:
        raise CommandError(_suggestion(arguments[0], list(commands)), BAD_INPUT)
    options = parser.parse_args(arguments)
    return commands[options.command].run(options)


def _interrupt(number: int, frame: FrameType | None) -> None:
    del number, frame
    raise Interrupted


def main(arguments: list[str], more: Sequence[str] = ()) -> int:
    """Runs the command line `arguments` (without the program's name); returns the exit status.

    `more`: further packages with subcommands.
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # nohup stays nohup
            signal.signal(number, _interrupt)
    try:
        return _dispatch(arguments, (__package__, *more))
    except CommandError as error:
        print(f"sunder: {error}", file=sys.stderr)
        return error.status
    except (Interrupted, KeyboardInterrupt):
        print("sunder: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # e.g. `sunder --help | head -1`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
