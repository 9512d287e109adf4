"""What both commands of README.md take on machines without packages, by distribution: rows, table and words."""
from __future__ import annotations

from typing import Mapping

from .cells import cell, figure

GOAL, GOAL_S = "first_picture_s", 300.0  # five minutes of two cores from a machine without packages
INSTALL, BUILD, RUN, TEST = "first_install_s", "first_build_s", "first_run_s", "first_test_s"
KEYS = ("On a machine without packages. `first_picture_s` runs from the first line of `coupler/sunder run` to its picture. "
        "It is the sum of `first_install_s`, `first_build_s` and `first_run_s`, which is the run with its picture; the install of "
        "Python before it is not in it. `first_test_s` is the second command, with what it installs and builds.")

Row = dict[str, object]


def with_run(numbers: Mapping[str, float]) -> dict[str, float]:
    """Returns the times of one system with that of the run, which is what installing and building leave of the first picture."""
    out = dict(numbers)
    out[RUN] = round(out[GOAL] - out[INSTALL] - out[BUILD], 1)
    return out


def goals(numbers: Mapping[str, object]) -> list[Row]:
    """The row of each system that compares its first picture with the goal."""
    rows: list[Row] = []
    for system, times in numbers.items():
        assert isinstance(times, dict)
        seconds = float(times[GOAL])
        rows.append({"case": f"{system}.{GOAL}", "run": system, "computed": seconds, "reference": GOAL_S,
                     "error": max(seconds / GOAL_S - 1.0, 0.0), "tolerance": 0.0, "seconds": seconds,
                     "verdict": "pass" if seconds <= GOAL_S else "fail", "note": ""})
    return rows


def table(numbers: Mapping[str, object]) -> list[str]:
    """Lines of a table with a column for each system."""
    systems = {system: times for system, times in numbers.items() if isinstance(times, dict)}
    keys = list(dict.fromkeys(key for times in systems.values() for key in times))
    return [KEYS, "", f"| key | {' | '.join(map(cell, systems))} |", "| --- |" + " --: |" * len(systems),
            *(f"| {cell(key)} | {' | '.join(figure(times.get(key), '.6g') for times in systems.values())} |" for key in keys)]


def told(system: str, times: object, circumstances: Mapping[str, object]) -> str:
    """The line of README.md about one system."""
    assert isinstance(times, dict)
    minutes = {key: f"{float(value) / 60.0:.1f}" for key, value in times.items() if key.endswith("_s")}
    second = f"Second command {minutes[TEST]} min" if TEST in minutes else "Second command not timed"
    return (f"- {system.replace('_', ' ').capitalize()}, {cell(circumstances.get('cores'))} cores: {minutes[GOAL]} min to the first "
            f"picture (goal {GOAL_S / 60.0:.0f}), {minutes[INSTALL]} of installing and {minutes[BUILD]} of building. {second} "
            f"({cell(circumstances.get('commit'))}, {cell(circumstances.get('date'))}).")
