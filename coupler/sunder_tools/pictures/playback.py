"""Data of the viewer's page: the list of frames, each frame as a binary buffer, and the curves."""
from __future__ import annotations

import json
import struct
from collections import OrderedDict
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from ..report.columns import read_columns, thin
from ..report.run_json import read_run
from ..report.scene_text import Words, scene_words
from .frames import BODIES, CARRIED, CRACKS, SHELL, Frame, list_frames
from .look import Look, origins
from .mesh import origin_of_triangles
from .meshes import fragment_edges, lines_in_place, piece_edges, thickness_of_lines
from .motion import body_velocity, shell_velocity
from .palette import PARTS
from .sheets import sheet_of
from .soft import with_soft
from .vtp import PolyData

CACHED_BYTES = 200 << 20
NOTHING = np.zeros((0, 3))


class Playback:
    """A run folder, finished or still growing; several threads may use it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._lock = Lock()
        self._packed: OrderedDict[str, bytes] = OrderedDict()
        self._words: Words | None = None

    def state(self) -> dict[str, Any]:
        """Returns status and frames as JSON. A frame's version changes when another run replaces it. Raises
        VtpError, OSError."""
        run = read_run(self.folder)
        words = self._known()
        look = Look.of_words(words, part_of=origins(self.folder, words))
        frames = list_frames(self.folder) if (self.folder / "frames.pvd").exists() else []
        return {"name": self.folder.resolve().name, "scene": run.get("scene", ""), "status": run.get("status", "unknown"),
                "frames": [{"time_s": f.time_s, "version": _version(f)} for f in frames],
                "shells": [{"name": n, "material": m, "glass": g, "colour": c}
                           for n, m, g, c in zip(words.shells, words.materials, words.glass, look.colours)],
                "palette": PARTS.tolist(), "part_of": look.part_of, "bodies": words.bodies, "body_colours": look.bodies,
                "error": run.get("error"), "counts": run.get("counts", {})}

    def _known(self) -> Words:
        if self._words is None or not self._words.shells:
            self._words = scene_words(self.folder)
        return self._words

    def frame(self, k: int) -> bytes | None:
        """Returns pack_frame() of frame k, or None where there is none. Raises VtpError, OSError."""
        frames = list_frames(self.folder)
        if not 0 <= k < len(frames):
            return None
        thickness = self._known().thickness
        key = " ".join([*map(_version, frames[max(k - 1, 0):k + 2]), str(thickness)])  # neighbouring frames give velocities
        with self._lock:
            if key in self._packed:
                self._packed.move_to_end(key)
                return self._packed[key]
        packed = pack_frame(frames, k, thickness)
        with self._lock:
            self._packed[key] = packed
            while len(self._packed) > 1 and sum(map(len, self._packed.values())) > CACHED_BYTES:
                self._packed.popitem(last=False)
        return packed

    def curves(self) -> dict[str, Any]:
        """Returns plots: titles, units and thinned curves of series.csv and probes.csv; None for a value that is not
        finite."""
        series, probes = read_columns(self.folder / "series.csv"), read_columns(self.folder / "probes.csv")
        words = self._known()
        plots = [_plot("energies", "J", series, [n for n in series if n.endswith(" [J]")]),
                 _plot("crack length", "m", series, ["cracks [m]"]),
                 _plot("fragments", "", series, ["fragments [-]", "handed_off [-]"])]
        plots += impulses(probes, words)
        for unit in ("m", "m/s", "N"):
            plots.append(_plot({"m": "probes: place", "m/s": "probes: velocity", "N": "reaction of supports"}[unit], unit,
                               probes, [n for n in probes if n.endswith(f" [{unit}]")]))
        return {"plots": [p for p in plots if p["curves"]]}


def _version(frame: Frame) -> str:
    """Returns a text that changes with the frame's files."""
    stats = [path.stat() for _, path in sorted(frame.files.items())]
    return "-".join(f"{s.st_mtime_ns:x}.{s.st_size:x}" for s in stats)


def _plot(title: str, unit: str, columns: dict[str, np.ndarray], names: list[str]) -> dict[str, Any]:
    curves = []
    for name in names:
        values = columns.get(name)
        if values is None or "time [s]" not in columns or not np.any(values[np.isfinite(values)]):
            continue  # constant zeros are left out
        t, y = thin(columns["time [s]"], values)
        curves.append({"name": name.rpartition(" [")[0], "t": t.tolist(),
                       "y": [v if np.isfinite(v) else None for v in y.tolist()]})
    return {"title": title, "unit": unit, "curves": curves}


def impulses(probes: dict[str, np.ndarray], words: Words) -> list[dict[str, Any]]:
    """Returns the impulse on each probed body since the start, from all contacts: m (v - v0 - g t) [N s].

    Where its mass is not known, the same per mass [m/s]. Also the impulse that each part of a support gave, and all of
    them; where there are no such columns, the reaction in time.
    """
    out: dict[str, list[Any]] = {"N s": [], "m/s": []}
    time = probes.get("time [s]", np.zeros(0))
    held: dict[str, np.ndarray] = {}
    for probe, _ in words.probes or [(n[:-9], "") for n in probes if n.endswith("_vx [m/s]")]:
        columns = [probes.get(f"{probe}_v{a} [m/s]") for a in "xyz"]
        if any(c is None for c in columns) or not len(time):
            continue
        velocity = np.stack([c for c in columns if c is not None], axis=1)
        change = velocity - velocity[0] - (time - time[0])[:, None] * np.array(words.gravity)
        mass = words.mass_under(probe)
        scale, unit = (mass, "N s") if mass is not None else (1.0, "m/s")
        for axis, a in enumerate("xyz"):
            held[f"{probe} {a}"] = scale * change[:, axis]
            out[unit].append(f"{probe} {a}")
    for a in "xyz":
        end = f"_impulse_{a} [N s]"
        parts = {n.removesuffix(end): np.cumsum(values) for n, values in probes.items() if n.endswith(end)}
        for part, impulse in parts.items():
            held[f"{part} {a}"] = impulse
            out["N s"].append(f"{part} {a}")
        force = probes.get(f"reaction_{a} [N]")
        if parts:
            held[f"supports {a}"] = np.sum(list(parts.values()), axis=0)
            out["N s"].append(f"supports {a}")
        elif force is not None and len(force) > 1:
            steps = 0.5 * (force[1:] + force[:-1]) * np.diff(time)
            held[f"supports {a}"] = np.concatenate([[0.0], np.cumsum(steps)])
            out["N s"].append(f"supports {a}")
    plots = []
    for unit, names in out.items():
        table = {"time [s]": time} | {f"{n} [{unit}]": held[n] for n in names}
        plots.append(_plot("impulse" if unit == "N s" else "impulse per mass", unit, table, list(table)[1:]))
    return plots


def pack_frame(frames: list[Frame], k: int, thickness: tuple[float, ...] = ()) -> bytes:
    """Packs a frame for the page: length of a JSON header (u32), the header, padding to 8, then arrays,
    little-endian. Where `thickness` [m] of each shell is known, shells have faces outside, inside and at the edge.

    The header has time, origin, the largest thickness [m] and {name: [type, offset, length]}; offsets count from the first array. Positions are
    single precision from `origin` [m], so that what is small and far away stays sharp. Raises VtpError, OSError.
    """
    shell, cracks, bodies, carried = (frames[k].read(part) for part in (SHELL, CRACKS, BODIES, CARRIED))
    bodies, moves = with_soft(frames[k], bodies, body_velocity(frames, k))
    corners = [m.points for m in (shell, bodies) if m is not None and len(m.points)]
    box = np.concatenate(corners) if corners else np.zeros((1, 3))
    origin = 0.5 * (shell.points.min(0) + shell.points.max(0)) if shell is not None and len(shell.points) else box.mean(0)
    arrays: dict[str, np.ndarray] = {}
    lines = [np.zeros((0, 2, 3))]
    inner, thick = np.zeros((0, 2, 3)), 0.0
    if shell is not None:
        sheet = sheet_of(shell, thickness)
        thick, speed = sheet.thickness_m, np.linalg.norm(shell_velocity(shell), axis=1)
        used, index = np.arange(len(sheet.points)), sheet.triangles
        if thick:  # its points are there twice, for edges too
            used, index = np.unique(sheet.triangles, return_inverse=True)
        arrays["shell.position"] = (sheet.points[used] - origin).astype("<f4")
        arrays["shell.normal"] = sheet.smooth[used].astype("<f4")  # zero where it is flat
        arrays["shell.index"] = index.ravel().astype("<u4")
        arrays["shell.speed"] = speed[used % (2 * len(speed)) // 2 if thick else used].astype("<f4")
        for name in ("damage", "c_his"):
            values = shell.of_triangles(name, 0.0)[sheet.own]
            arrays[f"shell.{name}"] = (values.max(axis=1) if values.ndim == 2 else values).astype("<f4")
        arrays["shell.fragment"] = shell.of_triangles("fragment", 0)[sheet.own].astype("<i4")
        arrays["shell.part"] = shell.of_triangles("shell", 0)[sheet.own].astype("<i4")
        lines.append(sheet.points[sheet.lines(fragment_edges(shell))])
    if cracks is not None:
        inner = cracks.points[lines_in_place(cracks, shell)]
    if carried is not None:
        inner = np.concatenate([inner, carried.points[carried.segments()]])
        thick = max(thick, thickness_of_lines(carried, thickness))
    if bodies is not None:
        arrays |= _mesh("bodies", bodies, moves, origin)
        body = bodies.of_triangles("body", 0)
        arrays["bodies.body"] = body.astype("<i4")
        arrays["bodies.kind"] = bodies.of_triangles("kind", 0).astype("<i4")
        arrays["bodies.part"] = origin_of_triangles(bodies).astype("<i4")  # -1: none, or not known
        outlines = piece_edges(bodies, np.arange(len(bodies.triangles)), _normals(bodies))
        arrays["outlines"] = (bodies.points[outlines] - origin).astype("<f4")
    arrays["cracks"] = (np.concatenate(lines) - origin).astype("<f4")
    arrays["inner"] = (inner - origin).astype("<f4")  # lines of middle surfaces
    table, blocks, at = {}, [], 0
    for name, values in arrays.items():
        raw = np.ascontiguousarray(values).tobytes()
        table[name] = [values.dtype.str[1:], at, values.size]
        blocks.append(raw + bytes(-len(raw) % 8))
        at += len(blocks[-1])
    header = json.dumps({"time_s": frames[k].time_s, "origin": origin.tolist(), "thickness_m": thick, "arrays": table}).encode()
    header += b" " * (-(len(header) + 4) % 8)
    return struct.pack("<I", len(header)) + header + b"".join(blocks)


def _mesh(name: str, mesh: PolyData, velocity: np.ndarray, origin: np.ndarray) -> dict[str, np.ndarray]:
    return {f"{name}.position": (mesh.points - origin).astype("<f4"), f"{name}.index": mesh.triangles.astype("<u4"),
            f"{name}.speed": np.linalg.norm(velocity, axis=1).astype("<f4")}


def _normals(mesh: PolyData) -> np.ndarray:
    corner = mesh.points[mesh.triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
