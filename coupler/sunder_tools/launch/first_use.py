"""What the first use of a checkout takes: installing, building, all until the first picture, and all tests.

Kept in FILE of the folder that builds are made in, with the circumstances, for `sunder report first_use`. What is there
already stays.
"""
from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from ..report.machine import circumstances

FILE = "first_use.json"
KEYS = ("first_install_s", "first_build_s", "first_build_steps", "first_picture_s")  # s: seconds
TEST_KEY = "first_test_s"  # of the second command, with its packages and what it builds; there once it has passed
MADE_WITH = "made_with"
FAILED = "tests_failed"  # the first time: what a later one takes is no first use
_start = time.monotonic()  # of this process, nearly
_built_in: Path | None = None  # by this process


def installed(folder: Path, seconds: float) -> None:
    """Keeps how long the packages of a run took."""
    _keep(folder, first_install_s=seconds)


def built(folder: Path, seconds: float, steps: int) -> None:
    """Keeps how long the programs took, from nothing."""
    global _built_in
    _built_in = folder if _keep(folder, first_build_s=seconds, first_build_steps=steps) else None


def drawn() -> None:
    """Keeps how long all took until a picture of a run was there, where the same command has built the programs."""
    if _built_in is not None and _keep(_built_in, first_picture_s=time.monotonic() - _start):
        _write(_built_in, _all(_built_in) | {MADE_WITH: circumstances(_built_in / "release")})


def tested(folder: Path) -> None:
    """Keeps how long all tests took, with their packages and what they built, where the first picture was kept too."""
    if MADE_WITH in _all(folder) and FAILED not in _all(folder):
        _keep(folder, **{TEST_KEY: time.monotonic() - _start})


def failed(folder: Path) -> None:
    """Notes that tests have failed: a later time would lack what has been built by then."""
    if MADE_WITH in _all(folder) and TEST_KEY not in _all(folder):
        _keep(folder, **{FAILED: 1.0})


def read(folder: Path) -> dict[str, float]:
    """What is kept, by KEYS and TEST_KEY; nothing where there is no such file."""
    try:
        kept = _all(folder)
        return {key: float(kept[key]) for key in (*KEYS, TEST_KEY) if key in kept}
    except (ValueError, TypeError):
        return {}


def made_with(folder: Path) -> dict[str, object]:
    """Commit, machine and compiler of the first picture; nothing where none was drawn."""
    found = _all(folder).get(MADE_WITH)
    return dict(found) if isinstance(found, dict) else {}


def _all(folder: Path) -> dict[str, Any]:
    try:
        kept = json.loads((folder / FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return kept if isinstance(kept, dict) else {}


def _keep(folder: Path, **numbers: float) -> bool:
    """Adds numbers that are not there yet; returns whether any was new. A folder that cannot be written loses them."""
    before = _all(folder)
    after = {key: round(value, 1) for key, value in numbers.items()} | before
    return after != before and _write(folder, after)


def _write(folder: Path, kept: dict[str, Any]) -> bool:
    try:
        (folder / FILE).write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    except OSError:
        return False
    return True
