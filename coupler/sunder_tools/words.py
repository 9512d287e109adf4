"""Words in messages: the nearest right ones for a mistyped one, and command lines as a shell takes them."""
from __future__ import annotations

import difflib
import os
import shlex
import shutil
import sys
from pathlib import Path
from typing import Iterable

from .places import COUPLER

MOST_GUESSES = 3
LIKE = 0.6  # least likeness of a guess, as difflib counts it: 1 is the same word


def nearest(word: str, choices: Iterable[str]) -> list[str]:
    """The choices most like `word`, best first, [] where none is like it: the same word, then those that start with it
    and a dash. Capitals, leading dashes, and - or _ make no difference."""
    plain: dict[str, str] = {}
    for choice in choices:
        plain.setdefault(_plain(choice), choice)
    begun = [choice for choice in plain if word and (choice + "-").startswith(_plain(word) + "-")]
    begun.sort(key=lambda choice: choice != _plain(word))
    like = [choice for choice in difflib.get_close_matches(_plain(word), list(plain), MOST_GUESSES, LIKE) if choice not in begun]
    return [plain[near] for near in (begun + like)[:MOST_GUESSES]]


def did_you_mean(word: str, choices: Iterable[str]) -> str:
    """'did you mean 'run'?', or all there are: 'there are run, check'."""
    choices = list(choices)
    near = nearest(word, choices)
    if near:
        return f"did you mean {' or '.join(repr(choice) for choice in near)}?"
    return f"there are {', '.join(choices)}" if choices else "there are none"


def quoted(text: object) -> str:
    """One argument as a shell takes it."""
    return shlex.quote(str(text))


def command_line(arguments: Iterable[object]) -> str:
    """A command that can be pasted into a shell."""
    return " ".join(quoted(argument) for argument in arguments)


def own_command(*arguments: object) -> str:
    """A command line of `sunder` itself that can be pasted where this one was typed."""
    return command_line([own_program(), *arguments])


def own_program() -> str:
    """How a shell finds this command: the name where it is on the path, else the path of the running script. A script of the
    user's runs this as a library: then it is the command beside these sources, if there is one."""
    running = Path(sys.argv[0])
    script = running if running.name == "sunder" and running.is_file() else COUPLER / "sunder"
    found = shutil.which("sunder")
    if not script.is_file() or found is not None and os.path.samefile(found, script):
        return "sunder"
    return str(script) if "/" in str(script) else f"./{script}"


def _plain(word: str) -> str:
    return word.lower().replace("_", "-").lstrip("-")
