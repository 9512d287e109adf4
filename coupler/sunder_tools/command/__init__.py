"""The command line: `main` finds the subcommands, `parser` has what they share, and each other module is one subcommand.

A subcommand is a module of this folder with a NAME, `add_parser(subparsers)` and `run(arguments) -> int`. `main` lists the
folder, so a new one needs its file only. Modules import numpy and PIL inside `run`: they may not be installed yet.
"""
