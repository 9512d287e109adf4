"""`sunder engine new`: a rigid-body engine to start from."""
from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

from ..errors import BAD_INPUT, DONE, CommandError
from ..launch.build import build_dir
from ..launch.node import ensure_node
from ..places import CHECKOUT_ONLY, INSTALLED, REPOSITORY
from ..words import command_line, own_program
from . import engine_texts
from .parser import Subparsers, add_choice, add_command, one_of

NAME = "engine"
LANGUAGES = ("python", "cpp", "node")


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder engine`."""
    parser = add_command(subparsers, NAME, "write a rigid-body engine to start from",
                         "'engine new' writes a whole engine without contacts, on a base class that has the session, its\n"
                         "checks and the connection: a program NAME in Python, NAME.mjs under Node.js, a folder NAME in\n"
                         "C++. Refuses to replace a file.",
                         "sunder engine new my_engine && sunder run SCENE --rigid ./my_engine")
    parser.add_argument("action", metavar="new", type=one_of("new"), help="what to do: new")
    parser.add_argument("name", metavar="NAME", type=Path, help="name of the engine, with a folder before it if you like")
    add_choice(parser, "--language", LANGUAGES, "language of the engine (default: python)", "python")


def run(arguments: argparse.Namespace) -> int:
    """Writes the engine and says how to try it; returns the exit status. Raises CommandError."""
    target, name = arguments.name, arguments.name.name
    steps: list[list[object]] = []
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise CommandError(f"engine new: '{name}' is no name of an engine: it has small letters, digits and '_' and starts "
                           "with a letter", BAD_INPUT)
    if arguments.language == "python":
        _write({target: engine_texts.PYTHON}, name)
        target.chmod(0o755)
        program = target
    elif arguments.language == "node":
        ensure_node()
        program = target.with_name(f"{name}.mjs")
        _write({program: engine_texts.NODE}, name)
        program.chmod(0o755)
    else:
        if INSTALLED.is_file():
            raise CommandError(f"engine new --language cpp: {CHECKOUT_ONLY}; --language python needs none", BAD_INPUT)
        _write({target / f"{name}.cpp": engine_texts.CPP, target / "CMakeLists.txt": engine_texts.CMAKE}, name)
        build = build_dir()
        program = target / name
        steps = [["cmake", "-S", REPOSITORY, "-B", build, f"-DSUNDER_ENGINES={target.resolve()}"],
                 ["cmake", "--build", build, "--target", name]]
    called = str(program) if "/" in str(program) else f"./{program}"
    steps += [[own_program(), "validate", "engines", "--rigid", called], [own_program(), "run", "SCENE", "--rigid", called]]
    print(f"{target} is written. Build it and try it with:" if arguments.language == "cpp" else
          f"{program} is written. Try it with:")
    for step in steps:
        print(f"  {command_line(step)}")
    return DONE


def _write(texts: dict[Path, str], name: str) -> None:
    """Writes all files or none. Raises CommandError where one is there already or cannot be written."""
    words = {"@name@": name, "@main@": json.dumps((REPOSITORY / "rigid" / "jolt" / "engine_main.mjs").as_uri()),
             "@modules@": repr(str(REPOSITORY / "coupler")),
             "@type@": "".join(part.capitalize() for part in name.split("_"))}
    for path in texts:
        if path.exists() or path.is_symlink():
            raise CommandError(f"{path}: is there already, and is not replaced; choose another name or folder", BAD_INPUT)
    for path, text in texts.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("x", encoding="utf-8") as sink:
                sink.write(re.sub("@[a-z]+@", lambda found: words[found[0]], text))
        except OSError as error:
            raise CommandError(f"cannot write {path}: {error.strerror}", BAD_INPUT) from None
