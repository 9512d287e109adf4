"""Tests of the command `sunder`, with fake executables; see fakes.py."""
from tests import REPOSITORY

__all__ = ["REPOSITORY", "sunder"]


def sunder(arguments: list[str]) -> int:
    """Runs a command line in this process, with the subcommands of tests/commands; returns the exit status."""
    from sunder_tools.command.main import main
    return main(arguments, ["tests.commands"])
