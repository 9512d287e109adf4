"""Tables of results: rows as CSV and SQLite, columns as arrays, means over seeds."""
from __future__ import annotations

import csv
import io
import math
import re
import sqlite3
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterable, Iterator

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.replacing import replacing

from .statistics import student

ENOUGH = 4  # runs of each point: with two, Student's t makes an interval of 12.7 standard errors either way, with four of 3.2

Cell = Any  # float, int, str, bool or None


@dataclass(frozen=True)
class Mean:
    """Statistics of rows with an equal `key`: number of values, mean, standard deviation, and half of the mean's 95
    % confidence interval (Student; NaN for one value)."""
    key: dict[str, Cell]
    count: int
    mean: float
    deviation: float
    half: float


class Table:
    """Rows with one set of columns, in order; a missing value is None."""

    def __init__(self, rows: Iterable[dict[str, Cell]]) -> None:
        rows = list(rows)
        self.columns = list(dict.fromkeys(name for row in rows for name in row))
        self.rows = [{name: _plain(row.get(name)) for name in self.columns} for row in rows]

    @staticmethod
    def read(path: Path | str) -> "Table":
        """Reads a table back that `write_csv` has written, as results.csv. Raises CommandError where there is none.

        Cells are whole numbers, numbers or text, by what they look like; empty ones are None. Numbers are the same to the bit.
        `member` is text, since a hash may look like a number.
        """
        try:
            with Path(path).open(newline="", encoding="utf-8") as source:
                found = [*csv.reader(source)]
        except (OSError, UnicodeDecodeError) as error:
            raise CommandError(f"{path}: cannot be read: {error}") from None
        if not found or any(len(row) != len(found[0]) for row in found):
            raise CommandError(f"{path}: is no table with a line of names and as many cells in every row")
        out = Table({name: cell if name == "member" else _read(cell) for name, cell in zip(found[0], row)} for row in found[1:])
        out.columns = found[0]
        return out

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, Cell]]:
        return iter(self.rows)

    def __getitem__(self, name: str) -> np.ndarray:
        """Returns a column as an array (n,): numbers with NaN for None, otherwise objects. Raises CommandError."""
        if name not in self.columns:
            raise CommandError(f"no column '{name}'; there are: {', '.join(self.columns)}")
        values = [row[name] for row in self.rows]
        if all(v is None or isinstance(v, (bool, int, float)) for v in values):
            return np.array([math.nan if v is None else float(v) for v in values])
        return np.array(values, object)

    def where(self, /, **wanted: Cell) -> "Table":
        """Returns the rows with these values, with all columns. NaN, as a column has it, stands for a missing value."""
        out = Table(())
        out.columns = self.columns
        out.rows = [row for row in self.rows if all(row.get(k) == _plain(v) for k, v in wanted.items())]
        return out

    def means(self, of: str, by: Iterable[str]) -> list[Mean]:
        """Computes statistics of column `of` over rows with equal columns `by`, in the order of first appearance.
        Values that are no numbers, such as those of failed members, are left out."""
        by = list(by)
        for name in (of, *by):
            self[name]  # raises where the column does not exist
        groups: dict[tuple[Cell, ...], list[float]] = {}
        for row in self.rows:
            values = groups.setdefault(tuple(row[name] for name in by), [])
            if isinstance(row[of], (bool, int, float)) and math.isfinite(row[of]):
                values.append(float(row[of]))
        return [_mean(dict(zip(by, key)), values) for key, values in groups.items()]

    def csv(self) -> str:
        """Returns the table as text; numbers have enough digits to be read back exactly."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([_cell(row[name]) for name in self.columns] for row in self.rows)
        return out.getvalue()

    def write_csv(self, path: Path) -> None:
        """Replaces the file atomically."""
        with replacing(path) as part:
            part.write_text(self.csv())


def write_sqlite(path: Path, tables: dict[str, Table]) -> None:
    """Writes a database of these tables and replaces an earlier one atomically.

    SQLite takes names that differ in case only for one; the later of two such columns gets a number.
    """
    with replacing(path) as part:
        part.unlink(missing_ok=True)
        base = sqlite3.connect(part)
        try:
            for name, table in tables.items():
                columns = ", ".join(f"{_sql_name(own)} {_affinity(table, column)}"
                                    for own, column in zip(distinct(table.columns), table.columns))
                base.execute(f"create table {_sql_name(name)} ({columns})")
                base.executemany(f"insert into {_sql_name(name)} values ({', '.join('?' * len(table.columns))})",
                                 [[row[c] for c in table.columns] for row in table])
            base.commit()
        finally:
            base.close()


def distinct(names: Iterable[str]) -> list[str]:
    """The names, with _2, _3, ... appended where one differs from an earlier one in case only."""
    taken: set[str] = set()
    out = []
    for name in names:
        own, k = name, 2
        while own.casefold() in taken:
            own, k = f"{name}_{k}", k + 1
        taken.add(own.casefold())
        out.append(own)
    return out


def _mean(key: dict[str, Cell], values: list[float]) -> Mean:
    n = len(values)
    mean = float(np.mean(values)) if n else math.nan
    deviation = float(np.std(values, ddof=1)) if n > 1 else math.nan
    return Mean(key, n, mean, deviation, student(0.95, n - 1) * deviation / math.sqrt(n) if n > 1 else math.nan)


def _plain(value: Cell) -> Cell:
    """Converts numpy's numbers to Python's, and types unknown to SQLite to text. NaN becomes None."""
    value = value.item() if hasattr(value, "item") else value
    if isinstance(value, float) and math.isnan(value):
        return None
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)


def _cell(value: Cell) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))  # as SQLite has it
    return repr(value) if isinstance(value, float) else re.sub(r"\s+", " ", str(value))


def _read(cell: str) -> Cell:
    """Reads what `_cell` has written."""
    if re.fullmatch(r"-?\d+", cell):
        return int(cell)
    return float(cell) if re.fullmatch(r"-?(\d+\.\d*|\d+)(e[+-]\d+)?|-?inf", cell) else cell or None


def _sql_name(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _affinity(table: Table, name: str) -> str:
    kinds = {type(row[name]) for row in table if row[name] is not None}
    if kinds <= {int, bool}:
        return "integer" if kinds else ""
    return "real" if kinds <= {int, bool, float} else "text"
