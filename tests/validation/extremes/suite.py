"""All rows of `validate extremes`, and the run of those that are asked for."""
from __future__ import annotations

from sunder_tools.launch.build import Executables

from .bodies import BODIES
from .cracks import CRACKS
from .rows import choose, run_rows
from .shells import SHELLS

ROWS = (*SHELLS, *BODIES, *CRACKS)


def validate_extremes(case: str | None, full: bool, executables: Executables) -> tuple[dict[str, object], bool]:
    """The rows of `--case`, or all; see run_rows."""
    return run_rows(choose(ROWS, case, full), executables)
