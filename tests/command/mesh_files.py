"""Readers of exported files that share no code with their writers."""
from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np


def read_ply(raw: bytes) -> dict[str, np.ndarray]:
    """An independent reader: header by words, then records by struct."""
    head, _, body = raw.partition(b"end_header\n")
    lines = [line.split() for line in head.decode("ascii").splitlines()]
    assert lines[0] == ["ply"] and lines[1] == ["format", "binary_little_endian", "1.0"]
    sizes, at = {"float": "f", "int": "i", "uchar": "B"}, 0
    out: dict[str, Any] = {}
    elements: list[tuple[str, int, list[list[str]]]] = []
    for line in lines[2:]:
        if line[0] == "element":
            elements.append((line[1], int(line[2]), []))
        elif line[0] == "property":
            elements[-1][2].append(line[1:])
    for name, count, properties in elements:
        for _ in range(count):
            for words in properties:
                if words[0] == "list":
                    n, = struct.unpack_from("<" + sizes[words[1]], body, at)
                    at += struct.calcsize(sizes[words[1]])
                    value = struct.unpack_from(f"<{n}{sizes[words[2]]}", body, at)
                    at += struct.calcsize(f"<{n}{sizes[words[2]]}")
                else:
                    value, = struct.unpack_from("<" + sizes[words[0]], body, at)
                    at += struct.calcsize(sizes[words[0]])
                out.setdefault(f"{name}.{words[-1]}", []).append(value)
    assert at == len(body), "bytes are left"
    return {key: np.array(values) for key, values in out.items()}


def read_pc2(raw: bytes) -> tuple[float, float, np.ndarray]:
    """First frame, frames a sample, and samples (s, n, 3) of a point cache."""
    assert raw[:12] == b"POINTCACHE2\0"
    version, points, start, rate, samples = struct.unpack_from("<iiffi", raw, 12)
    assert version == 1 and len(raw) == 32 + 12 * points * samples
    return start, rate, np.array(struct.unpack_from(f"<{3 * points * samples}f", raw, 32)).reshape(samples, points, 3)


def read_obj(text: str) -> dict[str, Any]:
    """`name`, points `v` (n, 3), normals `vn` (n, 3), texture coordinates `vt` (n, 2) where there are any, and triangles (m, 3)
    from 0 by material in `f`."""
    out: dict[str, Any] = {"v": [], "vn": [], "vt": [], "f": {}}
    material = ""
    for kind, *words in (line.split(" ") for line in text.splitlines() if not line.startswith("#")):
        if kind in ("v", "vn", "vt"):
            out[kind].append([float(word) for word in words])
        elif kind == "f":
            corners = [word.split("/") for word in words]  # point, texture, normal
            assert len(corners) == 3 and all(a == c and b == (a if out["vt"] else "") for a, b, c in corners)
            out["f"].setdefault(material, []).append([int(a) - 1 for a, _, _ in corners])
        elif kind == "usemtl":
            material, = words
        else:
            assert kind in ("o", "mtllib"), kind
            out["name" if kind == "o" else kind], = words
    return {"v": np.array(out["v"]), "vn": np.array(out["vn"]), "vt": np.array(out["vt"]), "name": out["name"], "mtllib": out["mtllib"],
            "f": {m: np.array(f) for m, f in out["f"].items()}}


def glb_parts(raw: bytes) -> tuple[dict, bytes]:
    """JSON and binary chunk."""
    magic, version, length = struct.unpack_from("<4sII", raw)
    assert (magic, version, length) == (b"glTF", 2, len(raw))
    size, kind = struct.unpack_from("<I4s", raw, 12)
    assert kind == b"JSON" and size % 4 == 0
    content = json.loads(raw[20:20 + size])
    blob = raw[28 + size:]
    assert struct.unpack_from("<I4s", raw, 20 + size) == (len(blob), b"BIN\0")
    assert content["buffers"] == [{"byteLength": len(blob)}]
    return content, blob


def read_glb(raw: bytes) -> dict[str, dict[str, np.ndarray]]:
    """An independent reader: {node: {attribute: values}}; `index` into the points, `slot`: material of each triangle."""
    content, blob = glb_parts(raw)

    def values(number: int) -> np.ndarray:
        accessor = content["accessors"][number]
        view = content["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
        array = np.frombuffer(blob, {5126: "<f4", 5125: "<u4"}[accessor["componentType"]], accessor["count"] * width,
                              view["byteOffset"])
        assert array.nbytes == view["byteLength"] and view["byteOffset"] % 4 == 0
        array = array.reshape(-1, width)
        if "min" in accessor:
            np.testing.assert_allclose(array.min(axis=0), accessor["min"], rtol=1e-6)
            np.testing.assert_allclose(array.max(axis=0), accessor["max"], rtol=1e-6)
        return array

    found = {}
    for number in content["scenes"][content["scene"]]["nodes"]:
        node = content["nodes"][number]
        parts, first = [], 0
        for primitive in content["meshes"][node["mesh"]]["primitives"]:
            arrays = {n: values(k) for n, k in primitive["attributes"].items()}
            index = values(primitive["indices"]).ravel()
            slot = content["materials"][primitive["material"]]["name"]
            parts.append(arrays | {"index": index + first, "slot": np.full(len(index) // 3, slot)})
            first += len(arrays["POSITION"])
        found[node["name"]] = {n: np.concatenate([p[n] for p in parts]) for n in parts[0]}
    return found


class Animated:
    """An animated glTF, evaluated as its specification says: nodes by name, at any time of the film."""

    def __init__(self, raw: bytes) -> None:
        self.json, self._blob = glb_parts(raw)
        self.names = [node["name"] for node in self.json["nodes"]]
        assert len(self.names) == len(set(self.names)), "a name twice"
        self.parent = {child: k for k, node in enumerate(self.json["nodes"]) for child in node.get("children", [])}
        self._channels: dict[tuple[int, str], tuple[np.ndarray, np.ndarray, str]] = {}
        for animation in self.json.get("animations", []):
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                times = self.values(sampler["input"]).ravel()
                assert (np.diff(times) > 0).all()
                key = channel["target"]["node"], channel["target"]["path"]
                assert key not in self._channels
                self._channels[key] = times, self.values(sampler["output"]).reshape(len(times), -1), sampler["interpolation"]

    def values(self, number: int) -> np.ndarray:
        accessor = self.json["accessors"][number]
        view = self.json["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        kind = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        return np.frombuffer(self._blob, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)

    @property
    def times(self) -> np.ndarray:
        """All times of keyframes."""
        return np.unique(np.concatenate([times for times, _, _ in self._channels.values()]))

    def _at(self, node: int, path: str, time: float, default: list[float]) -> np.ndarray:
        """The value of a channel, or of the node where it has none."""
        if (node, path) not in self._channels:
            return np.array(self.json["nodes"][node].get(path, default), float)
        times, values, how = self._channels[node, path]
        values = values.astype(float)
        k = int(np.searchsorted(times, time, side="right")) - 1
        if k < 0 or k == len(times) - 1:
            return values[max(k, 0)]
        share = (time - times[k]) / (times[k + 1] - times[k]) if how == "LINEAR" else 0.0
        a, b = values[k], values[k + 1]
        if path != "rotation":
            return a + share * (b - a)
        cosine = a @ b
        angle = np.arccos(min(abs(cosine), 1.0))
        if angle < 1e-4:
            return (a + share * (np.sign(cosine) * b - a)) / np.linalg.norm(a + share * (np.sign(cosine) * b - a))
        return (np.sin((1 - share) * angle) * a + np.sign(cosine) * np.sin(share * angle) * b) / np.sin(angle)

    def matrix(self, node: int, time: float) -> np.ndarray:
        """Takes points of a node to the world, (3, 4)."""
        x, y, z, w = self._at(node, "rotation", time, [0, 0, 0, 1])
        turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        mine = np.column_stack([turn * self._at(node, "scale", time, [1, 1, 1]), self._at(node, "translation", time, [0, 0, 0])])
        if node not in self.parent:
            return mine
        up = self.matrix(self.parent[node], time)
        return np.column_stack([up[:, :3] @ mine[:, :3], up[:, :3] @ mine[:, 3] + up[:, 3]])

    def centre(self, name: str, time: float) -> np.ndarray:
        """Where a node is [m], with z up again."""
        x, y, z = self.matrix(self.names.index(name), time)[:, 3]
        return np.array([x, -z, y])

    def seen(self, name: str, time: float) -> dict[str, np.ndarray]:
        """Corners (m, 3, 3) of the triangles of a node and its children by material, with z up; those of scale 0 are left
        out."""
        found: dict[str, list[np.ndarray]] = {}
        node = self.names.index(name)
        for one in [node, *self.json["nodes"][node].get("children", [])]:
            if "mesh" not in self.json["nodes"][one]:
                continue
            matrix = self.matrix(one, time)
            if not np.abs(matrix[:, :3]).max() > 0.0:
                continue
            weights = self._at(one, "weights", time, [])
            for primitive in self.json["meshes"][self.json["nodes"][one]["mesh"]]["primitives"]:
                points = self.values(primitive["attributes"]["POSITION"]).astype(float)
                for weight, target in zip(weights, primitive.get("targets", [])):
                    points = points + weight * self.values(target["POSITION"])
                points = points @ matrix[:, :3].T + matrix[:, 3]
                points = points[:, [0, 2, 1]] * [1, -1, 1]
                material = self.json["materials"][primitive["material"]]["name"]
                found.setdefault(material, []).append(points[self.values(primitive["indices"]).reshape(-1, 3)])
        return {material: np.concatenate(parts) for material, parts in found.items()}
