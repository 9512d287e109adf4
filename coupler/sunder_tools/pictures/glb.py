"""A binary glTF 2.0 under construction: accessors, materials with slots, meshes, nodes, an animation."""
from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from ..report.appearance import GLASS_IOR, Appearance

VERTICES, INDICES = 34962, 34963  # targets of buffer views
TRANSMISSION, REFRACTION = "KHR_materials_transmission", "KHR_materials_ior"  # extensions of the format
Y_UP = ([0, 2, 1], np.array([1.0, 1.0, -1.0]))  # x, y, z to x, z, -y: the format has y up


def upright(points: np.ndarray) -> np.ndarray:
    """Turns vectors (..., 3) with z up into single-precision ones with y up."""
    return (points[..., Y_UP[0]] * Y_UP[1]).astype("<f4")


def texture(uv: np.ndarray) -> np.ndarray:
    """Turns parameters (n, 2) into texture coordinates of the format, whose v goes down."""
    return np.column_stack([uv[:, 0], 1.0 - uv[:, 1]]).astype("<f4")


def thrice(values: np.ndarray) -> np.ndarray:
    """Turns numbers (n,) into vectors of three equal ones. Blender 4.3 confuses, or refuses, attributes of its users that
    differ in type within a mesh, so all of them have three numbers."""
    return np.repeat(values.astype("<f4")[:, None], 3, axis=1)


class Glb:
    """Collects entries of a glTF; `packed` gives the file."""

    def __init__(self, generator: str, extras: dict[str, Any]) -> None:
        self._blob = bytearray()
        self._materials: dict[str, int] = {}
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
            "meshes": [], "materials": [], "animations": [], "accessors": [], "bufferViews": [], "extras": extras}

    def add(self, name: str, value: object) -> int:
        """Appends to a list and returns the number of the entry."""
        self.json[name].append(value)
        return len(self.json[name]) - 1

    def accessor(self, values: np.ndarray, kind: str, target: int | None = None, limits: bool = False) -> int:
        """Adds an array of f4 or u4. `limits` are required for positions and for times of keyframes."""
        view: dict[str, int] = {"buffer": 0, "byteOffset": len(self._blob), "byteLength": values.nbytes}
        if target is not None:
            view["target"] = target
        self._blob += values.tobytes()
        self._blob += bytes(-len(self._blob) % 4)
        accessor: dict[str, Any] = {"bufferView": self.add("bufferViews", view),
                                    "componentType": 5126 if values.dtype.kind == "f" else 5125, "count": len(values),
                                    "type": kind}
        if limits:
            accessor |= {"min": np.atleast_1d(values.min(axis=0)).tolist(), "max": np.atleast_1d(values.max(axis=0)).tolist()}
        return self.add("accessors", accessor)

    def material(self, name: str, look: Appearance) -> int:
        """Returns the number of the material of this name, which gets the look where it is new.

        Glass lets light through at full opacity, as the format asks. Light goes through two faces of a sheet, so each has the
        square root of its colour.
        """
        if name not in self._materials:
            colour = [round(c ** 0.5 if look.clear else c, 4) for c in look.linear]
            material = {"name": name, "doubleSided": True, "alphaMode": "OPAQUE", "pbrMetallicRoughness": {
                "baseColorFactor": [*colour, 1.0], "metallicFactor": look.metallic, "roughnessFactor": look.roughness}}
            if look.clear:
                material["extensions"] = {TRANSMISSION: {"transmissionFactor": 1.0}, REFRACTION: {"ior": GLASS_IOR}}
                self.json["extensionsUsed"] = [TRANSMISSION, REFRACTION]
            self._materials[name] = self.add("materials", material)
        return self._materials[name]

    def node(self, name: str, **content: Any) -> int:
        """Adds a node that is in no list of children yet."""
        return self.add("nodes", {"name": name, **content})

    def show(self, node: int) -> None:
        """Puts a node at the top of the scene."""
        self.json["scenes"][0]["nodes"].append(node)

    def packed(self) -> bytes:
        # The format allows no empty lists, and no scene without nodes.
        content = {k: v for k, v in self.json.items() if v != []}
        if not self.json["nodes"]:
            content["scenes"] = [{}]
        else:
            content["buffers"] = [{"byteLength": len(self._blob)}]
        text = json.dumps(content, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        if self._blob:
            chunks += struct.pack("<I4s", len(self._blob), b"BIN\0") + bytes(self._blob)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
