"""Frames of a run, as listed in frames.pvd, and the choice of frames for a contact sheet."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..report.run_json import load_steps, read_run
from .vtp import PolyData, VtpError, read_vtp

SHELL, CRACKS, BODIES, SOFT, CARRIED = range(5)  # `part` in frames.pvd; CARRIED: cracks of laminates that became bodies
MOVING, SHARD, STATIC, FROZEN = 0, 1, 2, 3     # `kind` of a triangle in bodies_*.vtp
MEASURED_FRAMES = 120  # largest number of frames that are read to choose the panels


@dataclass(frozen=True)
class Frame:
    """One time; a part without a file (a frozen shell) reads as None. `step`: the time is the number of a load step."""
    time_s: float
    files: dict[int, Path]
    step: bool = False

    def read(self, part: int) -> PolyData | None:
        """Reads the part's mesh, or returns None where this frame has none. Raises VtpError, OSError."""
        path = self.files.get(part)
        return read_vtp(path) if path is not None else None


def list_frames(folder: Path) -> list[Frame]:
    """Lists all frames of a run folder in order of time. Raises VtpError, OSError."""
    pvd = folder / "frames.pvd"
    try:
        root = ElementTree.parse(pvd).getroot()
    except ElementTree.ParseError as error:
        raise VtpError(f"{pvd}: {error}") from None
    by_time: dict[float, dict[int, Path]] = {}
    for entry in root.iter("DataSet"):
        try:
            time_s, part, name = float(entry.attrib["timestep"]), int(entry.get("part", "0")), entry.attrib["file"]
        except (KeyError, ValueError) as error:
            raise VtpError(f"{pvd}: bad DataSet: {error}") from None
        path = folder / name
        if path.exists():  # the last frame of a killed run may be listed but missing
            by_time.setdefault(time_s, {})[part] = path
    steps = load_steps(read_run(folder)) > 0
    return [Frame(time_s, files, steps) for time_s, files in sorted(by_time.items())]


def choose_frames(frames: list[Frame], panels: int) -> list[Frame]:
    """Chooses `panels` frames, with the first and the last, in equal steps of change.

    Change counts growth of cracks, new shards, movement of shards, and the mere passing of frames,
    each relative to its total over the run. So the breaking gets its panels, although it takes a
    thousandth of the time.
    """
    if len(frames) <= panels:
        return frames
    index = np.unique(np.linspace(0, len(frames) - 1, MEASURED_FRAMES).round().astype(int))
    cracks, shards, height = (np.zeros(len(index)) for _ in range(3))
    for k, i in enumerate(index):
        mesh = frames[i].read(CRACKS)
        if mesh is not None:
            ends = mesh.points[mesh.segments()]
            cracks[k] = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
        elif k > 0:
            cracks[k] = cracks[k - 1]
        bodies = frames[i].read(BODIES)
        if bodies is not None:
            shard = bodies.of_triangles("kind", STATIC) == SHARD
            shards[k] = len(np.unique(bodies.of_triangles("body", 0)[shard]))
            if shard.any():
                height[k] = bodies.points[bodies.triangles[shard], 2].mean()
    first = int(np.argmax(shards > 0))
    height[:first] = height[first]
    change = np.zeros(len(index))
    for share, measure in ((0.4, cracks), (0.15, shards), (0.25, height), (0.2, np.arange(len(index)))):
        steps = np.abs(np.diff(measure, prepend=measure[0]))
        if steps.sum() > 0:
            change += share * np.cumsum(steps) / steps.sum()
    chosen = {0, len(index) - 1}
    for target in np.linspace(0.0, change[-1], panels)[1:-1]:
        free = [k for k in range(len(index)) if k not in chosen]
        chosen.add(min(free, key=lambda k: abs(change[k] - target)))
    return [frames[index[k]] for k in sorted(chosen)]
