"""What must be built before a scene can run: OpenCASCADE is built in with the first scene that reads a CAD file."""
from __future__ import annotations

import re
from pathlib import Path

from .build import Executables, ensure_built

# Of the text format: a string, a comment, or the message `cad`. Strings and comments come first: what they hold is no field.
_PARTS = re.compile(r""""(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|\#[^\n]*|(?P<cad>\bcad(?:\s|\#[^\n]*)*:?(?:\s|\#[^\n]*)*[{<])""")


def reads_cad(text: str) -> bool:
    """True where the scene `text` has a shell from a CAD file."""
    return any(found["cad"] for found in _PARTS.finditer(text))


def built_for(scene: Path) -> Executables:
    """`ensure_built`, with what this scene needs. Raises CommandError. A file that cannot be read needs nothing: the solver
    says what is wrong with it."""
    try:
        text = scene.read_text()
    except (OSError, ValueError):
        text = ""
    return ensure_built(cad=reads_cad(text))
