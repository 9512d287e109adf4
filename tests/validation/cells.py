"""Cells of the tables of results."""
from __future__ import annotations

import math


def figure(value: object, form: str) -> str:
    """Returns '-' for a value that is no number: JSON has null for values that are not finite."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return "-" if value is None or isinstance(value, float) else cell(value)
    return format(value, form)


def cell(value: object) -> str:
    """Returns a text on one line, '-' for none."""
    return "-" if value is None else " ".join(str(value).split()).replace("|", "\\|")
