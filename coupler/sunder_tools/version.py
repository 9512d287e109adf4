"""The version of the project. project() in the root CMakeLists.txt is its one source."""
from __future__ import annotations

import re

from .errors import CommandError
from .places import INSTALLED, REPOSITORY

CHECKOUT = REPOSITORY / "CMakeLists.txt"


def version() -> str:
    """E.g. '0.9.0'. Raises CommandError where neither file says."""
    try:
        text = INSTALLED.read_text() if INSTALLED.is_file() else _of_project(CHECKOUT.read_text())
    except OSError as error:
        raise CommandError(f"{error.filename}: cannot be read: {error.strerror}; it has the version") from None
    if not re.fullmatch(r"\d+\.\d+\.\d+\S*", text.strip()):
        place = INSTALLED if INSTALLED.is_file() else CHECKOUT
        raise CommandError(f"{place}: '{text.strip()}' is no version, e.g. 1.2.3; give project() one and install again")
    return text.strip()


def _of_project(text: str) -> str:
    found = re.search(r"^\s*project\(\s*sunder\b[^)]*?\bVERSION\s+([^\s)]+)", text, re.MULTILINE)
    return found[1] if found else ""
