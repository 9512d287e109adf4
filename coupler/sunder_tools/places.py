"""Where the project is, where it may write, and the variable that names another build of it."""
from __future__ import annotations

import os
from pathlib import Path


def _repository(here: Path = Path(__file__).resolve().parent) -> Path:
    """A checkout, or share/sunder of an installation. `pip install` keeps the place of the checkout in CHECKOUT."""
    told = here / "CHECKOUT"
    if not told.is_file():
        return here.parents[1]
    checkout = Path(told.read_text(encoding="utf-8").strip())
    if not (checkout / "proto" / "scene.proto").is_file():
        raise ImportError(f"sunder was installed from the checkout {checkout}, which is not there; install it again: "
                          "pip install CHECKOUT/coupler")
    return checkout


def _programs(repository: Path) -> Path:
    """Where an installation has its programs; a checkout may lie right below the root, where nothing is installed."""
    return repository.parent.parent / "libexec" / "sunder"


REPOSITORY = _repository()
COUPLER = REPOSITORY / "coupler"
BUILD_DIR_VARIABLE = "SUNDER_BUILD_DIR"
INSTALLED = REPOSITORY / "coupler" / "VERSION"  # written when the project is installed; a checkout has none
PROGRAMS = _programs(REPOSITORY)
LOCK_FILE = "package-lock.json"  # of npm: beside the sources, and copied beside packages that are complete
CHECKOUT_ONLY = "builds from the sources, which an installation does not have; use 'coupler/sunder' of a checkout"


def named_build() -> Path | None:
    """The build folder that SUNDER_BUILD_DIR names; None where it is not set. No Debian package is installed then."""
    name = os.environ.get(BUILD_DIR_VARIABLE)
    return Path(name).absolute() if name else None


def work_folder() -> Path:
    """What the project builds and gets for itself is kept here: build/ of a checkout, the user's cache of an installation."""
    if not INSTALLED.is_file():
        return REPOSITORY / "build"
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "sunder"


def npm_folder(name: str, sources: Path) -> Path:
    """Where the packages of `sources`/package-lock.json are, or are to go: `name` in the work folder.

    SUNDER_BUILD_DIR keeps its own: packages are found in it, beside it or in the work folder, and go into it. `packages.mjs`
    of rigid/jolt looks in the same places.
    """
    named = named_build()
    places = [work_folder() / name] if named is None else [named / name, named.parent / name, work_folder() / name]
    return next((place for place in places if has_packages(place, sources)), places[0])


def has_packages(folder: Path, sources: Path) -> bool:
    """True if the packages of `sources`/package-lock.json are in `folder`."""
    try:
        return (folder / LOCK_FILE).read_bytes() == (sources / LOCK_FILE).read_bytes()
    except OSError:
        return False
