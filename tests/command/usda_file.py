"""A reader of USD's text format that shares no code with the writer; as much of the grammar as the writer may use."""
from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

TOKEN = re.compile(r'\s+|("(?:[^"\\]|\\.)*")|(<[^>]*>)|([()\[\]{}=,])|([^\s()\[\]{}=,"<>]+)')


@dataclass
class Prim:
    kind: str
    values: dict[str, Any] = field(default_factory=dict)    # attribute: value, or {time code: value}
    types: dict[str, str] = field(default_factory=dict)
    meta: dict[str, Any] = field(default_factory=dict)      # of attributes too: 'normals.interpolation'


class Usda:
    """Prims by path."""

    def __init__(self, text: str) -> None:
        head, _, body = text.partition("\n")
        assert head == "#usda 1.0"
        self._tokens: list[str] = []
        at = 0
        while at < len(body):
            found = TOKEN.match(body, at)
            assert found, body[at:at + 40]
            self._tokens += [t for t in found.groups() if t is not None]
            at = found.end()
        self._at = 0
        self.prims: dict[str, Prim] = {}
        self.meta = self._meta() if self._peek() == "(" else {}
        while self._at < len(self._tokens):
            self._prim("")

    def _peek(self) -> str:
        return self._tokens[self._at]

    def _next(self, wanted: str | None = None) -> str:
        token = self._tokens[self._at]
        assert wanted is None or token == wanted, (token, wanted, self._tokens[self._at - 5:self._at + 5])
        self._at += 1
        return token

    def _meta(self) -> dict[str, Any]:
        self._next("(")
        found = {}
        while self._peek() != ")":
            name = self._next()
            name = f"{name} {self._next()}" if name == "prepend" else name
            self._next("=")
            found[name] = self._value()
        self._next(")")
        return found

    def _value(self) -> Any:
        token = self._next()
        if token in "([":
            closing, found = {"(": ")", "[": "]"}[token], []
            while self._peek() != closing:
                found.append(self._value())
                if self._peek() != closing:
                    self._next(",")
            self._next(closing)
            return tuple(found) if closing == ")" else found
        if token[0] in '"<':
            return token[1:-1]
        return float(token)

    def _prim(self, above: str) -> None:
        self._next("def")
        prim = Prim(self._next())
        name = self._next()[1:-1]
        assert re.fullmatch(r"[A-Za-z_]\w*", name), name
        path = f"{above}/{name}"
        assert path not in self.prims, path
        self.prims[path] = prim
        prim.meta = self._meta() if self._peek() == "(" else {}
        self._next("{")
        while self._peek() != "}":
            if self._peek() == "def":
                self._prim(path)
            else:
                self._attribute(prim)
        self._next("}")

    def _attribute(self, prim: Prim) -> None:
        kind = self._next()
        kind = self._next() if kind == "uniform" else kind
        if self._peek() == "[":
            kind += self._next("[") + self._next("]")
        name = self._next()
        assert re.fullmatch(r"[A-Za-z_][\w:.]*", name), name
        timed = name.endswith(".timeSamples")
        name = name.removesuffix(".timeSamples")
        assert prim.types.setdefault(name, kind) == kind
        if self._peek() == "=":
            self._next()
            prim.values[name] = self._samples() if timed else self._value()
        if self._peek() == "(":
            prim.meta |= {f"{name}.{key}": value for key, value in self._meta().items()}

    def _samples(self) -> dict[float, Any]:
        self._next("{")
        found: dict[float, Any] = {}
        while self._peek() != "}":
            told = self._next()
            assert told.endswith(":"), told
            time = float(told[:-1])
            assert not found or time > max(found)
            found[time] = self._value()
            if self._peek() != "}":
                self._next(",")
        self._next("}")
        return found

    def at(self, path: str, name: str, time: float, default: Any = None) -> Any:
        """The value of an attribute at a time code: straight between samples where it is of numbers, held otherwise."""
        value = self.prims[path].values.get(name, default)
        if not isinstance(value, dict):
            return value
        times = sorted(value)
        before = max([t for t in times if t <= time], default=times[0])
        after = min([t for t in times if t > time], default=before)
        if isinstance(value[before], str) or after == before or before > time:
            return value[before]
        share = (time - before) / (after - before)
        return (1 - share) * np.array(value[before]) + share * np.array(value[after])

    def _turn(self, path: str, time: float) -> np.ndarray:
        """The unit quaternion of an Xform: evenly between samples, as the format has it."""
        value = self.prims[path].values.get("xformOp:orient", (1.0, 0.0, 0.0, 0.0))
        if not isinstance(value, dict):
            return np.array(value)
        k = max(sum(t <= time for t in value) - 1, 0)
        times = sorted(value)
        a, b = (np.array(value[times[min(at, len(times) - 1)]]) for at in (k, k + 1))
        angle = np.arccos(min(a @ b, 1.0))
        if angle < 1e-7 or time <= times[0]:
            return a
        share = (time - times[k]) / (times[k + 1] - times[k])
        return (np.sin((1.0 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle)

    def seen(self, path: str, time: float) -> dict[str, np.ndarray]:
        """Corners (m, 3, 3) of the visible meshes under an Xform, by the material of their subset."""
        found: dict[str, list[np.ndarray]] = {}
        w, x, y, z = self._turn(path, time)
        turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        for mesh, prim in self.prims.items():
            if prim.kind != "Mesh" or not mesh.startswith(path + "/") or self.at(mesh, "visibility", time) == "invisible":
                continue
            points = np.array(self.at(mesh, "points", time)) @ turn.T + np.array(self.at(path, "xformOp:translate", time))
            assert set(prim.values["faceVertexCounts"]) == {3.0}
            corners = points[np.array(prim.values["faceVertexIndices"], int).reshape(-1, 3)]
            subsets = [p for q, p in self.prims.items() if p.kind == "GeomSubset" and q.startswith(mesh + "/")]
            which = np.concatenate([np.array(p.values["indices"], int) for p in subsets])
            assert sorted(which.tolist()) == list(range(len(corners))), "subsets are no partition"
            for subset in subsets:
                material = subset.values["material:binding"]
                assert self.prims[material].kind == "Material"
                found.setdefault(material.split("/")[-1], []).append(corners[np.array(subset.values["indices"], int)])
        return {material: np.concatenate(parts) for material, parts in found.items()}
