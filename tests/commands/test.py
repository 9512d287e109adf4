"""`sunder test`: builds everything and runs the tests."""
from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Callable

from sunder_tools.command.parser import Subparsers, add_command
from sunder_tools.errors import CHECK_FAILED, DONE, CommandError
from sunder_tools.launch import first_use
from sunder_tools.launch.build import build_dir, ensure_built
from sunder_tools.launch.install import (BLENDER_PACKAGES, BROWSER_PACKAGES, CAD_PACKAGES, FILM_PACKAGES, LINT_PACKAGES,
                                         LOCALE_PACKAGES, PLOT_PACKAGES, SLURM_PACKAGES, ensure_installed)
from sunder_tools.launch.node import ensure_node
from sunder_tools.places import BUILD_DIR_VARIABLE, REPOSITORY

NAME = "test"
LOG = REPOSITORY / "build" / "install.log"
WITHIN_VARIABLE = "SUNDER_WITHIN_TESTS"  # set for tests: what they run of a checkout says nothing of its first use


def add_parser(subparsers: Subparsers) -> None:
    """All arguments of `sunder test` are ctest's: with this prefix none of them is taken for an option of this parser."""
    parser = add_command(subparsers, NAME, "build everything and run the tests",
                         "What follows goes to ctest, e.g. sunder test -R vtp",
                         usage="sunder test [CTEST_ARGUMENT ...]", add_help=False, prefix_chars="\0")
    parser.add_argument("ctest", nargs="*", metavar="CTEST_ARGUMENT")
    parser.set_defaults(parser=parser)


def run(arguments: argparse.Namespace) -> int:
    """Runs ctest; returns 1 where it fails. Raises CommandError."""
    if arguments.ctest[:1] in (["--help"], ["-h"]):
        arguments.parser.print_help()
        return DONE
    may_install = not os.environ.get(BUILD_DIR_VARIABLE)
    ensure_built(all_targets=True, cad=may_install and _can_have("CAD files", _install(CAD_PACKAGES)))
    if may_install:
        _get_packages()
    at_once = len(os.sched_getaffinity(0)) + 2  # some wait: for a process to start, for its peer, for a browser
    command = ["ctest", "--test-dir", str(build_dir()), "--output-on-failure", f"-j{at_once}", *arguments.ctest]
    environment = {key: value for key, value in os.environ.items() if key != BUILD_DIR_VARIABLE}
    environment["PATH"] = "/usr/bin:/bin:" + environment.get("PATH", "")
    environment[WITHIN_VARIABLE] = "1"
    environment["OMP_WAIT_POLICY"] = "passive"  # tests run at once: threads that wait must leave the cores to the other
    status = subprocess.run(command, check=False, env=environment).returncode
    if may_install and not os.environ.get(WITHIN_VARIABLE):  # a part of the tests builds all
        whole = status == 0 and not arguments.ctest
        (first_use.tested if whole else first_use.failed)(build_dir().parent)
    return DONE if status == 0 else CHECK_FAILED


def _get_packages() -> None:
    """Packages that only tests need. Where they cannot be had, their tests are skipped."""
    wanted: tuple[tuple[str, Callable[[], object]], ...] = (
        ("the engines under Node.js", ensure_node), ("Slurm", _install(SLURM_PACKAGES)),
                      ("the sources", _install(LINT_PACKAGES)), ("plots", _install(PLOT_PACKAGES)),
                      ("a German locale", _install(LOCALE_PACKAGES)), ("films", _install(FILM_PACKAGES)),
                      ("Blender", _install(BLENDER_PACKAGES)), ("the viewer", _ensure_viewer))
    for what, get in wanted:
        _can_have(what, get)


def _install(packages: tuple[str, ...]) -> Callable[[], object]:
    return lambda: ensure_installed(LOG, packages)


def _can_have(what: str, get: Callable[[], object]) -> bool:
    """Gets what some tests need; returns whether that worked, and says that they are skipped where it did not."""
    try:
        LOG.parent.mkdir(exist_ok=True)
        get()
    except (CommandError, OSError) as error:
        print(f"sunder: {error}\nsunder: so the tests of {what} are skipped", file=sys.stderr, flush=True)
        return False
    return True


def _ensure_viewer() -> None:
    from sunder_tools.pictures.view import ensure_page  # numpy only once it is installed
    ensure_installed(LOG, BROWSER_PACKAGES)
    ensure_page()
