"""Words in messages: the nearest right ones for a mistyped one, and command lines as a shell takes them."""
from __future__ import annotations

import difflib
import shlex
from typing import Iterable

MOST_GUESSES = 3
LIKE = 0.6  # least likeness of a guess, as difflib counts it: 1 is the same word


def nearest(word: str, choices: Iterable[str]) -> list[str]:
    """The choices most like `word`, best first, [] where none is like it. Capitals, leading dashes, and - or _
    make no difference."""
    plain: dict[str, str] = {}
    for choice in choices:
        plain.setdefault(_plain(choice), choice)
    return [plain[near] for near in difflib.get_close_matches(_plain(word), list(plain), MOST_GUESSES, LIKE)]


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


def _plain(word: str) -> str:
    return word.lower().replace("_", "-").lstrip("-")
