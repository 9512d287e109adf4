"""Writes vase.glb: the outer face of a vase as glTF, whose colours are its thickness: white is thick."""
from __future__ import annotations

import json
import math
import struct
from pathlib import Path

import numpy as np

ROUND = 64  # points around
# Radius and height of the outer profile from the middle of the foot to the lip [m], and the thickness there, over the largest.
PROFILE = ((0.000, 0.000, 1.0), (0.014, 0.000, 1.0), (0.026, 0.001, 1.0), (0.035, 0.005, 1.0), (0.0415, 0.012, 0.95),
           (0.0465, 0.022, 0.85), (0.052, 0.037, 0.75), (0.057, 0.055, 0.7), (0.060, 0.075, 0.65), (0.060, 0.096, 0.6),
           (0.055, 0.117, 0.6), (0.045, 0.137, 0.6), (0.035, 0.153, 0.6), (0.029, 0.167, 0.55), (0.028, 0.179, 0.5),
           (0.032, 0.190, 0.45), (0.039, 0.200, 0.4))
BETWEEN = 3  # pieces of each stretch of the profile


def smooth(points: np.ndarray) -> np.ndarray:
    """Returns points of a curve through `points` (Catmull and Rom)."""
    ends = np.concatenate([[points[0] * [-1, 1, 1] if points[0, 0] else points[1] * [-1, 1, 1]], points,
                           [2 * points[-1] - points[-2]]])
    out = []
    for k in range(1, len(points)):
        for i in range(BETWEEN):
            t = i / BETWEEN
            weights = (0.5 * t * (-1 + t * (2 - t)), 0.5 * (2 + t * t * (3 * t - 5)), 0.5 * t * (1 + t * (4 - 3 * t)),
                       0.5 * t * t * (t - 1))
            out.append(sum(w * p for w, p in zip(weights, ends[k - 1:k + 3])))
    return np.array([*out, points[-1]])


def main() -> None:
    """Writes the file beside this script."""
    rings = smooth(np.array(PROFILE))[1:]
    points, colours = [(0.0, 0.0, 0.0)], [PROFILE[0][2]]
    for radius, height, thick in rings:
        for k in range(ROUND):
            angle = 2 * math.pi * k / ROUND
            points.append((radius * math.cos(angle), height, -radius * math.sin(angle)))  # y is up in glTF
            colours.append(thick)
    corners = [(0, 1 + (k + 1) % ROUND, 1 + k) for k in range(ROUND)]
    for ring in range(len(rings) - 1):
        for k in range(ROUND):
            a, b = 1 + ring * ROUND + k, 1 + ring * ROUND + (k + 1) % ROUND
            corners += [(a, b, b + ROUND), (a, b + ROUND, a + ROUND)]
    place = np.array(points, "<f4")
    grey = np.repeat(np.round(255 * np.array(colours))[:, None], 4, axis=1).astype(np.uint8)
    grey[:, 3] = 255
    parts = [place.tobytes(), grey.tobytes(), np.array(corners, "<u2").tobytes()]
    offsets = np.cumsum([0, *map(len, parts)])
    text = json.dumps({
        "asset": {"version": "2.0", "generator": "make_vase.py"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "vase", "mesh": 0}], "materials": [{"name": "porcelain"}],
        "meshes": [{"name": "vase", "primitives": [
            {"attributes": {"POSITION": 0, "COLOR_0": 1}, "indices": 2, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3",
             "min": place.min(axis=0).tolist(), "max": place.max(axis=0).tolist()},
            {"bufferView": 1, "componentType": 5121, "count": len(points), "type": "VEC4", "normalized": True},
            {"bufferView": 2, "componentType": 5123, "count": 3 * len(corners), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": int(at), "byteLength": len(part)} for at, part in zip(offsets, parts)],
        "buffers": [{"byteLength": int(offsets[-1])}]}, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(parts) + b"\0" * (-int(offsets[-1]) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    (Path(__file__).parent / "vase.glb").write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


if __name__ == "__main__":
    main()
