"""Readers of exported files that share no code with their writers."""
from __future__ import annotations

import json
import struct

import numpy as np


def read_ply(raw: bytes) -> dict[str, np.ndarray]:
    """An independent reader: header by words, then records by struct."""
    head, _, body = raw.partition(b"end_header\n")
    lines = [line.split() for line in head.decode("ascii").splitlines()]
    assert lines[0] == ["ply"] and lines[1] == ["format", "binary_little_endian", "1.0"]
    sizes, out, at = {"float": "f", "int": "i", "uchar": "B"}, {}, 0
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
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
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
