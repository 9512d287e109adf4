"""`sunder validate engines`: the conformance suite for every engine, and one table of what each of them holds."""
from __future__ import annotations

import json
import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sunder_tools.errors import BAD_INPUT, CHECK_FAILED, DONE, INTERRUPTED, CommandError
from sunder_tools.launch import engines
from sunder_tools.launch.build import Executables
from sunder_tools.places import REPOSITORY

from ..validation.programs import run_program

KNOWN = REPOSITORY / "tests" / "conformance" / "known"
CELL_CHARS = 24
PASS, KNOWN_FAIL, FAIL, SKIPPED, REPORTED, ABSENT = "pass", "known", "FAIL", "skipped", "told", ""

Row = dict[str, object]


@dataclass(frozen=True)
class Chosen:
    """What of the suite is to be run."""
    case: str | None = None       # NAME,NAME; all where it is absent
    leave_out: str | None = None  # NAME,NAME
    expect: Path | None = None    # list of known failures, instead of that of the engine's name


def suite_command(suite: Path, rigid: engines.Rigid, name: str, chosen: Chosen, numbers: Path) -> list[str]:
    """Call of the suite for one engine; `name` finds the list of its known failures, '' has none."""
    command = [str(suite), "--json", str(numbers)]
    if rigid.endpoint:
        command += ["--endpoint", rigid.endpoint]
    else:
        program, *arguments = rigid.command
        command += ["--engine", program]
        for argument in arguments:
            command += ["--engine-arg", argument]
    known = KNOWN / f"{name}.txt"
    if chosen.expect is not None or name and known.is_file():
        command += ["--expect", str(chosen.expect or known)]
    for option, names in (("--case", chosen.case), ("--leave-out", chosen.leave_out)):
        for one in names.split(",") if names else []:
            command += [option, one]
    return command


def cell(rows: list[Row]) -> str:
    """What one engine makes of one case: a word, and the rows that fail with their errors."""
    verdicts = [str(row["verdict"]) for row in rows]
    if not verdicts:
        return ABSENT
    failing = [row for row in rows if row["verdict"] in ("fail", "known")]
    if not failing:
        return next((word for verdict, word in (("pass", PASS), ("skipped", SKIPPED)) if verdict in verdicts), REPORTED)
    word = FAIL if "fail" in verdicts else KNOWN_FAIL
    figures = []
    for row in failing:
        part = str(row["name"]).partition(".")[2]
        error = row["error"]
        figures.append(f"{part} {error:.1e}" if isinstance(error, float) and math.isfinite(error) else part)
    return f"{word} {', '.join(figures)}".strip()


def by_case(rows: list[Row]) -> dict[str, list[Row]]:
    """Rows of each case, in the order of the suite."""
    cases: dict[str, list[Row]] = {}
    for row in rows:
        cases.setdefault(str(row["name"]).partition(".")[0], []).append(row)
    return cases


def shortened(text: str) -> str:
    """A cell that fits its column: whole words only, so that no number loses its end."""
    if len(text) <= CELL_CHARS:
        return text
    kept = ""
    for word in text.split(" "):
        if len(f"{kept} {word}...") > CELL_CHARS:
            break
        kept = f"{kept} {word}".lstrip()
    return kept.rstrip(",") + "..."


def untried(name: str, result: dict[str, Any]) -> list[str]:
    """Lines about words that an engine declares, and whose cases were all skipped for want of another word."""
    declared = result.get("capabilities", [])
    lines = []
    for word in declared:
        needs = [(set(row["needs"]), row["verdict"]) for row in result["cases"] if word in row["needs"]]
        if needs and all(verdict == "skipped" for _, verdict in needs):
            lacks = sorted(set.union(*(some for some, _ in needs)) - set(declared))
            lines.append(f"note  {name}: it declares '{word}', but no case of that ran: they also need {', '.join(lacks)}")
    return lines


def table(found: dict[str, dict[str, object]]) -> str:
    """Rows are cases, columns engines; what fails comes again below, with its reason."""
    columns = {name: by_case(result["cases"]) for name, result in found.items()}  # type: ignore[arg-type]
    cases = list(dict.fromkeys(case for column in columns.values() for case in column))
    lines = [f"{'case':<26} " + " ".join(f"{name:<{CELL_CHARS}}" for name in columns)]
    for case in cases:
        cells = [cell(column.get(case, [])) for column in columns.values()]
        lines.append(f"{case:<26} " + " ".join(f"{shortened(text):<{CELL_CHARS}}" for text in cells).rstrip())
    for name, result in found.items():
        for row in result["cases"]:  # type: ignore[attr-defined]
            if row["verdict"] not in ("fail", "known"):
                continue
            numbers = "" if row["error"] is None else f" {row['error']:.2g} (allowed {row['tolerance']:.1g})"
            word = "FAIL " if row["verdict"] == "fail" else "known"
            lines.append(f"{word} {name}: {row['name']}{numbers}: {row['note']}")
        lines += untried(name, result)
    return "\n".join(line.rstrip() for line in lines)


def run_suites(suite: Path, executables: Executables, chosen: Chosen, only: str | None = None) -> tuple[
        int, dict[str, dict[str, Any]]]:
    """Exit status, and what the suite wrote for each engine that could be asked. Engines under Node.js are left
    out, with the reason, where their packages cannot be had: they come from a registry. Where the user interrupts it,
    the last engine has what ran, and `left`, the names of its other cases."""
    status = DONE
    found: dict[str, dict[str, object]] = {}
    names = [only] if only else engines.names(executables)
    for k, name in enumerate(names):
        if engines.in_process(name):
            raise CommandError(f"--rigid {name}: the suite speaks over the wire; leave '{engines.IN_PROCESS}:' out", BAD_INPUT)
        try:
            rigid = engines.resolve(name, executables)
        except CommandError as error:
            if only:
                raise
            print(f"{name}: left out: {error}\n", flush=True)
            continue
        with tempfile.TemporaryDirectory() as folder:
            numbers = Path(folder) / "rows.json"
            own = "" if "/" in name else name  # a program of the user's has no known failures here, whatever its name is
            ended = run_program(suite_command(suite, rigid, own, chosen, numbers))
            if ended == BAD_INPUT:
                return BAD_INPUT, found  # it has said why
            if ended == INTERRUPTED:
                if numbers.is_file():
                    found[name] = json.loads(numbers.read_text())
                if names[k + 1:]:
                    print(f"not asked: {', '.join(names[k + 1:])}", flush=True)
                return INTERRUPTED, found
            if not numbers.is_file():
                print(f"{name}: the suite found no engine to speak to", flush=True)
                status = CHECK_FAILED
                continue
            found[name] = json.loads(numbers.read_text())
        if ended != DONE:
            status = CHECK_FAILED
        print(flush=True)
    return status, found
