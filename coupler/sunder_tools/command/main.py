"""`sunder`: finds the subcommands, reads the command line, runs one of them."""
from __future__ import annotations

import argparse
import importlib
import os
import pkgutil
import re
import signal
import sys
from types import FrameType, ModuleType
from typing import Collection, Sequence

from ..errors import BAD_INPUT, DONE, INTERRUPTED, CommandError, Interrupted
from ..version import version
from ..words import did_you_mean
from .parser import EPILOG, Parser

OF_SOURCES = ("bench", "fuzz", "hashes", "report", "test", "validate")  # in a checkout; an installation has no tests
NEGATIVE = r"-(\.?[0-9]|(?i:inf|infinity|nan)\b)"  # how a value begins that is no option
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


def make_parser(commands: dict[str, ModuleType]) -> tuple[Parser, dict[str, Parser]]:
    """The parser of the whole command line, and those of the subcommands by name."""
    parser = Parser(prog="sunder", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG,
                    allow_abbrev=False, description=DESCRIPTION)
    parser.add_argument("--version", action="store_true", help="print the version and end")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", parser_class=Parser)
    for module in commands.values():
        module.add_parser(subparsers)
    return parser, subparsers.choices


def with_negative_values(arguments: list[str], valued: Collection[str]) -> list[str]:
    """Joins an option of those that take a value and one that begins with a minus, as --view -90,89, which argparse would take
    for an option."""
    joined: list[str] = []
    for argument in arguments:
        before = joined[-1] if joined else ""
        if "--" not in joined and before in valued and re.match(NEGATIVE, argument):
            joined[-1] = f"{before}={argument}"
        else:
            joined.append(argument)
    return joined


def _dispatch(arguments: list[str], packages: Sequence[str]) -> int:
    commands = subcommands(packages)
    parser, of_command = make_parser(commands)
    if not arguments:
        parser.print_help(sys.stderr)
        return BAD_INPUT
    if arguments[0] in of_command:
        arguments = with_negative_values(arguments, of_command[arguments[0]].valued)
    name, rest = arguments[0], arguments[1:]
    if name.startswith("-"):
        parser.check_options(arguments)
    elif name not in commands and name in OF_SOURCES:
        raise CommandError(f"'{name}' needs the tests, which come with the sources; run coupler/sunder {name} in a checkout",
                           BAD_INPUT)
    elif name not in commands:
        raise CommandError(f"unknown command '{name}'; {did_you_mean(name, commands)} (see 'sunder --help')", BAD_INPUT)
    else:
        of_command[name].check_options(rest)
    options = parser.parse_args(arguments)
    if options.version:
        print(f"sunder {version()}")
        return DONE
    if options.command is None:
        raise CommandError("a command is missing; see 'sunder --help'", BAD_INPUT)
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
