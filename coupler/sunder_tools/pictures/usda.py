"""One animated USD file of a run, as text (.usda), z up, in metres.

An Xform for each piece and body with timeSamples of its place, under that of its shell. Its shapes are Meshes with visibility
over time, points over time where they bend, and a GeomSubset for each material. Written here since Debian has no library of
USD, and three's USDZExporter knows neither points nor visibility over time, nor subsets.
"""
from __future__ import annotations

import re
from typing import Any, Iterable, Sequence

import numpy as np

from ..report.appearance import Appearance
from .materials import OPACITY
from .story import Shape, Thing

TAB = "    "


def identifier(name: str, taken: set[str]) -> str:
    """Returns the name as USD allows it, and as none of `taken`, to which it is added."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    plain = plain if re.match(r"[A-Za-z_]", plain) else f"_{plain}"
    found, number = plain, 1
    while found in taken:
        number += 1
        found = f"{plain}_{number}"
    taken.add(found)
    return found


def _number(value: float) -> str:
    """A number without a needless '.0' or '-0'."""
    return "0" if value == 0.0 else f"{value:.9g}"


def _plain(values: np.ndarray) -> Any:
    """The array as lists of Python's own numbers."""
    return values.tolist()


def _tuples(values: np.ndarray) -> str:
    """An array of vectors, in single precision."""
    return "[" + ", ".join([f"({x:.8g}, {y:.8g}, {z:.8g})" for x, y, z in _plain(values)]) + "]"


def _list(values: Iterable[object]) -> str:
    return "[" + ", ".join(map(str, values)) + "]"


class _Text:
    """Lines with indentation."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._depth = 0

    def add(self, line: str) -> None:
        """Adds a line."""
        self.lines.append(TAB * self._depth + line)

    def open(self, kind: str, name: str, *meta: str) -> None:
        """Begins a prim."""
        self.add(f'def {kind} "{name}"' + (" (" if meta else ""))
        for line in meta:
            self.add(TAB + line)
        if meta:
            self.add(")")
        self.add("{")
        self._depth += 1

    def close(self) -> None:
        """Ends a prim."""
        self._depth -= 1
        self.add("}")

    def samples(self, declared: str, codes: Sequence[float], values: Sequence[str], meta: str = "") -> None:
        """Adds an attribute over time, with what is told of it in round brackets; one value is no animation."""
        if len(values) == 1:
            self.add(f"{declared} = {values[0]}{meta}")
            return
        if meta:
            self.add(declared + meta)
        self.add(f"{declared}.timeSamples = {{")
        for code, value in zip(codes, values):
            self.add(f"{TAB}{_number(code)}: {value},")
        self.add("}")


def usda_text(things: list[Thing], times: np.ndarray, fps: float, speed: float | None,
              run_times: np.ndarray | None = None) -> str:
    """Writes a stage. `times` (n,) [s] of the film are those of all frames, `run_times` those of the run; a time code is a
    picture. Velocities are of the film, as the format has it."""
    codes = times * fps
    rates: np.ndarray = np.full(len(times), speed or 1.0)
    if speed is None and run_times is not None and len(times) > 1:
        seconds = np.diff(times)
        rates = np.divide(np.diff(run_times), seconds, out=np.zeros(len(seconds)), where=seconds > 0.0)
        rates = np.append(rates, rates[-1])
    out = _Text()
    told = "a picture is a frame of the run" if speed is None else f"time runs {_number(speed)} times as fast as in the run"
    out.lines += ["#usda 1.0", "(", TAB + 'defaultPrim = "run"',
                  TAB + f'doc = "sunder export; {told}"', TAB + "metersPerUnit = 1",
                  TAB + 'upAxis = "Z"', TAB + "startTimeCode = 0", TAB + f"endTimeCode = {_number(codes[-1])}",
                  TAB + f"framesPerSecond = {_number(fps)}", TAB + f"timeCodesPerSecond = {_number(fps)}", ")", ""]
    out.open("Xform", "run")
    materials = _materials(out, things)
    taken = {"materials"}
    groups = list(dict.fromkeys(thing.group for thing in things))
    for group in groups:
        inside = taken if not group else set()
        if group:
            out.open("Xform", identifier(group, taken))
        for thing in things:
            if thing.group == group:
                _thing(out, identifier(thing.name, inside), thing, codes, materials, rates)
        if group:
            out.close()
    out.close()
    return "\n".join(out.lines) + "\n"


def _materials(out: _Text, things: list[Thing]) -> dict[str, str]:
    """Writes all materials; returns their paths."""
    looks = {slot.material: slot.look for thing in reversed(things) for shape in thing.shapes for slot in shape.slots}
    taken: set[str] = set()
    paths = {}
    out.open("Scope", "materials")
    for name in sorted(looks):
        own, look = identifier(name, taken), looks[name]
        paths[name] = f"/run/materials/{own}"
        out.open("Material", own)
        out.add(f"token outputs:surface.connect = <{paths[name]}/preview.outputs:surface>")
        out.open("Shader", "preview")
        out.add('uniform token info:id = "UsdPreviewSurface"')
        out.add(f"color3f inputs:diffuseColor = ({', '.join(_number(c) for c in _linear(look))})")
        out.add(f"float inputs:opacity = {_number(OPACITY if look.clear else 1.0)}")
        out.add(f"float inputs:metallic = {_number(look.metallic)}")
        out.add(f"float inputs:roughness = {_number(look.roughness)}")
        out.add("token outputs:surface")
        out.close()
        out.close()
    out.close()
    return paths


def _linear(look: Appearance) -> list[float]:
    return [round(c, 4) for c in look.linear]


def _thing(out: _Text, name: str, thing: Thing, codes: np.ndarray, materials: dict[str, str], rates: np.ndarray) -> None:
    out.open("Xform", name)
    at = _plain(codes[thing.keys])
    centres = [f"({', '.join(_number(x) for x in centre)})" for centre in thing.centre]
    turns = [f"({', '.join(_number(x) for x in (q[3], *q[:3]))})" for q in thing.turn]  # w first
    out.samples("double3 xformOp:translate", at, _constant(centres))
    ops = ['"xformOp:translate"']
    if len(set(turns)) > 1:
        out.samples("quatd xformOp:orient", at, turns)
        ops.append('"xformOp:orient"')
    out.add(f"uniform token[] xformOpOrder = {_list(ops)}")
    for number, shape in enumerate(thing.shapes):
        _mesh(out, f"shape_{number}", shape, codes, materials, rates)
    out.close()


def _constant(values: list[str]) -> list[str]:
    """One value where all are the same."""
    return values[:1] if len(set(values)) == 1 else values


def _mesh(out: _Text, name: str, shape: Shape, codes: np.ndarray, materials: dict[str, str], rates: np.ndarray) -> None:
    at = _plain(codes[shape.first:shape.first + len(shape.points)])
    corners = np.concatenate([slot.first + slot.triangles for slot in shape.slots])
    out.open("Mesh", name, 'prepend apiSchemas = ["MaterialBindingAPI"]')
    out.add("uniform bool doubleSided = 1")
    out.add('uniform token subdivisionScheme = "none"')
    out.add(f"int[] faceVertexCounts = {_list([3] * len(corners))}")
    out.add(f"int[] faceVertexIndices = {_list(_plain(corners.ravel()))}")
    out.samples("float3[] extent", at, [_tuples(np.stack([p.min(axis=0), p.max(axis=0)])) for p in shape.points])
    out.samples("point3f[] points", at, [_tuples(p) for p in shape.points])
    if len(shape.velocity) == len(shape.points):
        each = rates[shape.first:shape.first + len(shape.velocity)]
        out.samples("vector3f[] velocities", at, [_tuples(rate * v) for rate, v in zip(each, shape.velocity)])
    out.samples("normal3f[] normals", at, [_tuples(n) for n in shape.normals], ' (interpolation = "vertex")')
    colours = np.concatenate([np.tile(_linear(slot.look), (len(slot.triangles), 1)) for slot in shape.slots])
    if (colours == colours[0]).all():
        out.add(f'color3f[] primvars:displayColor = {_tuples(colours[:1])} (interpolation = "constant")')
    else:
        out.add(f'color3f[] primvars:displayColor = {_tuples(colours)} (interpolation = "uniform")')
    if any(slot.look.clear for slot in shape.slots):
        opacity = [OPACITY if slot.look.clear else 1.0 for slot in shape.slots for _ in slot.triangles]
        out.add(f'float[] primvars:displayOpacity = {_list(_number(o) for o in opacity)} (interpolation = "uniform")')
    if np.isfinite(shape.rest).all():
        out.add(f'point3f[] primvars:rest = {_tuples(shape.rest)} (interpolation = "vertex")')
    if np.isfinite(shape.uv).all():
        pairs = ", ".join(f"({u:.8g}, {v:.8g})" for u, v in _plain(shape.uv))
        out.add(f'texCoord2f[] primvars:st = [{pairs}] (interpolation = "vertex")')
    if np.isfinite(shape.damage).all():
        out.add(f'float[] primvars:damage = {_list(_number(d) for d in _plain(shape.damage))} (interpolation = "vertex")')
    seen = [(0.0, '"invisible"')] if shape.first > 0 else []
    seen.append((float(codes[shape.first]), '"inherited"'))
    if shape.last + 1 < len(codes):
        seen.append((float(codes[shape.last + 1]), '"invisible"'))
    if len(seen) > 1:
        out.samples("token visibility", [code for code, _ in seen], [value for _, value in seen])
    out.add('uniform token subsetFamily:materialBind:familyType = "partition"')
    faces: dict[str, list[int]] = {}
    count = 0
    for slot in shape.slots:
        faces.setdefault(slot.material, []).extend(range(count, count + len(slot.triangles)))
        count += len(slot.triangles)
    taken: set[str] = set()
    for material, which in faces.items():
        out.open("GeomSubset", identifier(material, taken), 'prepend apiSchemas = ["MaterialBindingAPI"]')
        out.add('uniform token elementType = "face"')
        out.add('uniform token familyName = "materialBind"')
        out.add(f"int[] indices = {_list(which)}")
        out.add(f"rel material:binding = <{materials[material]}>")
        out.close()
    out.close()
