"""What the steps of .ci/run took, as it has written them: the commit, then a line 'STEP SECONDS' for each step."""
from __future__ import annotations

import re
from pathlib import Path

from sunder_tools.errors import BAD_INPUT, CommandError
from sunder_tools.report.machine import commit

FILE = "ci.txt"  # in the folder that builds are made in
STEPS = ("programs", "tests_built", "tests")  # in the order in which .ci/run takes them
WHOLE = "ci_s"  # all steps together


def read(path: Path) -> dict[str, float]:
    """Returns the seconds of each step, as `ci_STEP_s`, and of all. Raises CommandError where the file does not tell of all
    steps on this commit."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    steps = {found[1]: float(found[2]) for line in lines[1:] if (found := re.fullmatch(r"(\w+) (\d+)", line))}
    lacks = [step for step in STEPS if step not in steps]
    if lacks:
        raise CommandError(f"report: {path} lacks {', '.join(lacks)}: run '.ci/run' to its end, then this", BAD_INPUT)
    if lines[0] != commit().rstrip("+"):
        raise CommandError(f"report: {path} tells of commit {lines[0]}, and this is {commit()}: run '.ci/run' again, then this",
                           BAD_INPUT)
    return {**{f"ci_{step}_s": steps[step] for step in STEPS}, WHOLE: sum(steps[step] for step in STEPS)}
