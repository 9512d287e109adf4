"""Where the project is, where it may write, and the variable that names another build of it."""
from __future__ import annotations

import os
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]  # a checkout, or share/sunder of an installation
BUILD_DIR_VARIABLE = "SUNDER_BUILD_DIR"
INSTALLED = REPOSITORY / "coupler" / "VERSION"  # written when the project is installed; a checkout has none
PROGRAMS = REPOSITORY.parents[1] / "libexec" / "sunder"  # of an installation
CHECKOUT_ONLY = "builds from the sources, which an installation does not have; use 'coupler/sunder' of a checkout"


def work_folder() -> Path:
    """What the project builds and gets for itself is kept here: build/ of a checkout, the user's cache of an installation."""
    if not INSTALLED.is_file():
        return REPOSITORY / "build"
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "sunder"
