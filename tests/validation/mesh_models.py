"""Meshes of scenes as shells: the mass of the shells against the sum over the triangles of the file.

The rabbit is closed. The same without the faces of its base is open; the base is where it is flat on the ground. The car is
tessellated here from its splines, each patch with points of its own, which weld along seams.
"""
from __future__ import annotations

import json
import struct
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.launch.build import Executables

from .trials import SCENES, Table

SMOOTH = 0.02  # of area and mass, set beforehand: charts are smooth, triangles flat
SUM = 1e-6     # of the sum that `inspect` has: a glTF file has single precision
FLAT = 0.9     # cosine of a normal that looks down
BASE = 0.02    # share of the height in which the base lies
PARTS = 2      # of each span of a spline of the car, along a side of its triangles


@dataclass
class Model:
    """A mesh: points (n, 3) and triangles (m, 3), with the unit in which they are [m]."""
    name: str
    points: np.ndarray
    triangles: np.ndarray
    unit: float = 1.0

    def area(self) -> float:
        a, b, c = (self.unit * self.points[self.triangles[:, k]] for k in range(3))
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def write(self, path: Path) -> None:
        rows = ["v {!r} {!r} {!r}".format(*map(float, p)) for p in self.points]
        rows += ["f {} {} {}".format(*(int(k) + 1 for k in t)) for t in self.triangles]
        path.write_text("\n".join(rows) + "\n")


def obj_of(path: Path, name: str, unit: float) -> Model:
    """Reads an OBJ file of triangles."""
    lines = [line.split() for line in path.read_text().splitlines()]
    points = np.array([[float(x) for x in words[1:4]] for words in lines if words[:1] == ["v"]])
    faces = [[int(word.split("/")[0]) - 1 for word in words[1:]] for words in lines if words[:1] == ["f"]]
    triangles = [[face[0], face[k], face[k + 1]] for face in faces for k in range(1, len(face) - 1)]
    return Model(name, points, np.array(triangles), unit)


def glb_of(path: Path, name: str) -> Model:
    """Reads the first primitive of a binary glTF file whose node is not moved."""
    content = path.read_bytes()
    length = struct.unpack_from("<I", content, 12)[0]
    told, blob = json.loads(content[20:20 + length]), content[28 + length:]
    primitive = told["meshes"][0]["primitives"][0]

    def array(number: int, width: int) -> np.ndarray:
        accessor = told["accessors"][number]
        first = told["bufferViews"][accessor["bufferView"]].get("byteOffset", 0) + accessor.get("byteOffset", 0)
        kind = {5126: "<f4", 5125: "<u4", 5123: "<u2"}[accessor["componentType"]]
        return np.frombuffer(blob, kind, accessor["count"] * width, first).reshape(-1, width)

    return Model(name, array(primitive["attributes"]["POSITION"], 3).astype(float), array(primitive["indices"], 1).reshape(-1, 3).astype(int))


def without_base(closed: Model, name: str) -> Model:
    """The mesh without the triangles at its lowest places that look down."""
    a, b, c = (closed.points[closed.triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    down = normal[:, 2] < -FLAT * np.linalg.norm(normal, axis=1)
    height = closed.points[:, 2]
    low = (closed.points[closed.triangles, 2] < height.min() + BASE * np.ptp(height)).all(axis=1)
    return Model(name, closed.points, closed.triangles[~(down & low)], closed.unit)


def car_body() -> Model:
    """The car of scenes/car_shape.py as triangles."""
    sys.path.insert(0, str(SCENES))
    try:
        from car_shape import car
        from splines import basis, open_knots
    finally:
        sys.path.remove(str(SCENES))
    points: list[np.ndarray] = []
    triangles: list[list[int]] = []
    for patch in car():
        rows, columns = (size - 2 for size in patch.net.shape[:2])
        v, u = (basis(open_knots(spans), np.linspace(0.0, spans, PARTS * spans + 1))[0] for spans in (rows, columns))
        grid = np.einsum("ai,bj,ijd->abd", v, u, patch.net)
        first, across = sum(len(p) for p in points), grid.shape[1]
        points.append(grid.reshape(-1, 3))
        for j in range(grid.shape[0] - 1):
            for i in range(across - 1):
                a = first + j * across + i
                triangles += [[a, a + 1, a + across + 1], [a, a + across + 1, a + across]]
    return Model("car", np.concatenate(points), np.array(triangles))


def mesh_models(table: Table, executables: Executables) -> None:
    """Adds a row for the area and one for the mass of each model."""
    rabbit = obj_of(SCENES / "rabbit.obj", "rabbit", 1e-3)
    vase = glb_of(SCENES / "vase.glb", "vase")
    with tempfile.TemporaryDirectory(prefix="validate-sunder-") as folder:
        for model, weld in ((rabbit, 0.0), (without_base(rabbit, "rabbit_open"), 0.0), (vase, 0.0), (car_body(), 1e-6)):
            path = Path(folder) / f"{model.name}.obj"
            if model is vase:
                path = path.with_suffix(".glb")
                path.write_bytes((SCENES / "vase.glb").read_bytes())
            else:
                model.write(path)
            start = time.monotonic()
            command = [str(executables.shell), "inspect", str(path), "--unit", repr(model.unit), "--weld", repr(weld)]
            ended = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace", check=False)
            if ended.returncode != 0:
                raise CommandError(f"{model.name}: {ended.stderr.strip()[-300:]}")
            told = json.loads(ended.stdout)
            if told["refused"] is not None:
                raise CommandError(f"{model.name}: {told['refused']}")
            note = f"{told['triangles']} triangles, {len(told['charts'])} charts, {told['edges']['borders']} borders"
            table.add(f"model_{model.name}_area", told["area_m2"], model.area(), SUM, time.monotonic() - start, note=note)
            table.add(f"model_{model.name}_mass", sum(chart["area_of_shell_m2"] for chart in told["charts"]), model.area(), SMOOTH, 0.0,
                      note="of the shells, over density and thickness")
