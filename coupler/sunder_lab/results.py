"""Files of a run folder, as numpy arrays."""
from __future__ import annotations

import csv
import re
from functools import cached_property
from pathlib import Path
from typing import Any, Iterator, Mapping

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.pictures.crack_lines import Graph, graph_of
from sunder_tools.pictures.frames import CRACKS, Frame, list_frames
from sunder_tools.report.run_json import read_run


class Columns(Mapping[str, np.ndarray]):
    """Columns of a CSV file, by name without unit, all of one length; `units` has the texts in brackets.

    What is empty in the file is NaN: probes of a shell that is frozen, for example.
    """

    def __init__(self, path: Path) -> None:
        """Reads the file. Raises CommandError where it does not exist or is no such table."""
        self.path = path
        try:
            with path.open(newline="") as source:
                head, *rows = list(csv.reader(source))
            numbers = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows], float)
        except (OSError, ValueError) as error:
            raise CommandError(f"{path}: no such table: {error}") from None
        numbers = numbers.reshape(len(rows), len(head))
        split = [re.fullmatch(r"(.*?)(?: \[(.*)\])?", name) for name in head]
        names = [match[1] if match else "" for match in split]
        self.units = {name: (match[2] or "-") if match else "-" for name, match in zip(names, split)}
        self._columns = {name: numbers[:, k] for k, name in enumerate(names)}

    def __getitem__(self, name: str) -> np.ndarray:
        """Returns a column. Raises CommandError that lists the existing columns."""
        if name not in self._columns:
            raise CommandError(f"{self.path}: no column '{name}'; there are: {', '.join(self._columns)}")
        return self._columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def vector(self, name: str, axes: str = "_x _y _z") -> np.ndarray:
        """Returns (n, 3) from three columns `name` + each of `axes`."""
        return np.stack([self[name + axis] for axis in axes.split()], axis=1)


class RunArrays:
    """Everything that a run has written, as arrays. Each file is read once, when it is first needed."""

    def __init__(self, folder: Path | str) -> None:
        """Opens a run folder. Raises CommandError where it holds no run."""
        self.folder = Path(folder)
        self.run: dict[str, Any] = read_run(self.folder)
        if "status" not in self.run:
            raise CommandError(f"{self.folder}: holds no run.json of a run")

    @property
    def status(self) -> str:
        """Returns done, failed, interrupted or running."""
        return str(self.run["status"])

    @property
    def energy(self) -> dict[str, float]:
        """Returns the energies at the end [J], as in run.json."""
        return dict(self.run["energy"])

    @cached_property
    def series(self) -> Columns:
        """Returns energies, crack length and fragments, with a row for each window."""
        return Columns(self.folder / "series.csv")

    @cached_property
    def probes(self) -> Columns:
        """Returns the probes of the scene's output.probes. Raises CommandError where it has none."""
        if not (self.folder / "probes.csv").is_file():
            raise CommandError(f"{self.folder}: the scene has no output.probes")
        return Columns(self.folder / "probes.csv")

    @cached_property
    def shards(self) -> Columns:
        """Returns every piece that was handed off as a rigid body."""
        return Columns(self.folder / "shards.csv")

    @cached_property
    def frames(self) -> list[Frame]:
        """Returns the stored frames in order of time; `frame.read(part)` gives points, triangles and data as arrays."""
        return list_frames(self.folder)

    @cached_property
    def cracks(self) -> Graph | None:
        """Returns the crack lines at the end: ends (n, 2, 2) in parameters [m], on the sheet at rest (n, 2, 3) [m],
        crack, birth [s].

        None where there is none. What was cut at time zero counts, its birth is zero.
        """
        for frame in reversed(self.frames):
            if CRACKS in frame.files:
                graph = graph_of(frame.read(CRACKS), str(frame.files[CRACKS]))
                return graph if len(graph) else None
        return None
