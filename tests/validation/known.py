"""Lists of cases that are known to fail, with the largest error of the known failure."""
from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from sunder_tools.errors import BAD_INPUT, CommandError
from sunder_tools.places import REPOSITORY

KNOWN = REPOSITORY / "tests" / "validation" / "known"
SKIPPED = "skipped"  # verdict of a row whose case lacks what it needs
WITHOUT_LIST = ("engines", "extremes")  # suites that judge their known failures themselves
FORM = "a line has the form 'NAME LARGEST_ERROR WHY'"

Row = dict[str, object]


@dataclass(frozen=True)
class Gap:
    """A known failure."""
    largest: float  # largest error, as in the table, that is still the known failure
    why: str


def read_known(path: Path) -> dict[str, Gap]:
    """Reads the known failures by names of rows; none where there is no such file. Raises CommandError with file and
    line."""
    if not path.exists():
        return {}
    gaps: dict[str, Gap] = {}
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise CommandError(f"{path}: cannot be read as UTF-8 text: {error}", BAD_INPUT) from None
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        name, *rest = line.split(maxsplit=2)
        where = f"{path}:{number}: '{name}'"
        if len(rest) < 2:
            raise CommandError(f"{where} has no error or no reason; {FORM}", BAD_INPUT)
        try:
            largest = float(rest[0])
        except ValueError:
            largest = math.nan
        if not (math.isfinite(largest) and largest > 0.0):
            raise CommandError(f"{where}: the largest error '{rest[0]}' is no positive number; {FORM}", BAD_INPUT)
        if name in gaps:
            raise CommandError(f"{where} is there twice; leave one line", BAD_INPUT)
        gaps[name] = Gap(largest, rest[1])
    return gaps


def _number(value: object) -> float:
    """Reads null as a value that is not finite, as programs write it."""
    return float(value) if isinstance(value, (int, float)) else math.nan


def today(suite: str, rows: list[Row], folder: Path = KNOWN) -> list[Row]:
    """Judges stored rows by the list of the suite as it is now. A row that did not pass is known, with the reason that the
    list gives, or fails. Raises CommandError for a list that cannot be read."""
    if suite in WITHOUT_LIST:
        return rows
    gaps = read_known(folder / f"{suite}.txt")
    return [_today(row, gaps.get(str(row["case"]))) if row["verdict"] in ("known", "fail") else row for row in rows]


def _today(row: Row, gap: Gap | None) -> Row:
    known = gap is not None and _number(row["error"]) <= gap.largest  # NaN is not known
    return {**row, "verdict": "known" if known else "fail",
            "note": gap.why if gap and known else f"known to be off by {gap.largest:g} at most" if gap else ""}


def holds(row: Row) -> bool:
    """Whether a row passes, or is skipped."""
    return bool(row["pass"]) or row.get("verdict") == SKIPPED


def judge(rows: list[Row], gaps: dict[str, Gap], every: bool) -> tuple[bool, list[str]]:
    """Marks failing rows of sunder-validate's JSON that are known with "known", the reason. Returns whether no other
    row fails, and lines that report it. With `every` row of a kind present, an entry of the list without a row is a
    fault of the list."""
    good, lines, names = True, [], {str(row["name"]) for row in rows}
    for row in rows:
        if row.get("verdict") == SKIPPED:
            continue
        gap = gaps.get(str(row["name"]))
        error, tolerance = _number(row["error"]), _number(row["tolerance"])
        if row["pass"]:
            if gap:
                lines.append(f"reached   {row['name']}: known to fail, up to {gap.largest:g}")
        elif gap and error <= gap.largest:  # NaN is not known
            row["known"] = gap.why
            lines.append(f"known     {row['name']}: off by {error:.3g}, by {gap.largest:g} at most: {gap.why}")
        else:
            good = False
            lines.append(f"FAILED    {row['name']}: off by {error:.3g}, {tolerance:.3g} allowed"
                         + (f", known to be off by {gap.largest:g} at most" if gap else ""))
    for name in sorted(set(gaps) - names) if every else ():
        good = False
        lines.append(f"no row    {name}: known to fail; has its case died, or take it from tests/validation/known")
    return good, lines
