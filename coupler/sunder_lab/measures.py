"""Measures that state their columns, so that the names in a series are checked before its first run."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Mapping

from .results import RunArrays
from .scene import Scene


def _anything(scene: Scene) -> None:
    """Accepts every scene."""
    del scene


@dataclass(frozen=True)
class Stated:
    """A measure whose columns are known before a run.

    `of` gives their values; a column that it leaves out is empty in that row. `refuse` raises CommandError for a scene
    that the measure cannot work on. `absent` says of columns that it does not give how to have them.
    """
    columns: tuple[str, ...]
    of: Callable[[Any], Mapping[str, Any]]
    refuse: Callable[[Scene], None] = _anything
    absent: Mapping[str, str] = field(default_factory=dict)

    def __call__(self, results: RunArrays) -> dict[str, Any]:
        """Returns the values. Raises ValueError where there is a column that was not stated."""
        found = dict(self.of(results))
        unknown = [name for name in found if name not in self.columns]
        if unknown:
            raise ValueError(f"a measure gives columns that it does not state: {', '.join(unknown)}")
        return {**dict.fromkeys(self.columns), **found}


def gives(*columns: str) -> Callable[[Callable[[Any], Mapping[str, Any]]], Stated]:
    """Decorates a measure of one's own with the columns that it gives, so that plots of them are checked at once."""
    def stated(of: Callable[[Any], Mapping[str, Any]]) -> Stated:
        return Stated(columns, of)
    return stated
