"""`sunder export`: a run as a sequence of meshes, one file a frame, that Blender and Houdini read.

Cracks change the triangles from frame to frame, so there is no single mesh that is animated.

PLY (binary): x, y, z [m] and vx, vy, vz [m/s] per vertex; fragment (id of the piece, in the shell and as a shard), damage,
part (number of the shell; -1 for bodies), body (its number, for a shard that of its piece; -1 for the shell) and
kind (0 moving, 1 shard, 2 static, 3 frozen; -1 for the shell) per face. z is up.
glTF (binary, .glb): a node per shell, the shards, and each body of the scene, y up as the format asks, with the materials
of the scene; _VELOCITY, _FRAGMENT and _DAMAGE per vertex, for which faces have vertices of their own.
"""
from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import DONE
from ..report.scene_text import Words, scene_words
from .frames import BODIES, FROZEN, SHARD, SHELL, Frame
from .look import origins
from .motion import body_velocity, shell_velocity
from .palette import GLASS, PARTS
from .render import put_in_place, frames_of, pick, telling
from .soft import with_soft

FORMATS = ("ply", "gltf")
TIMES = "frame_times.csv"
STEEL = (0.58, 0.60, 0.63)


@dataclass
class Mesh:
    """All triangles of a frame, those of shells first."""
    points: np.ndarray     # (n, 3) [m]
    velocity: np.ndarray   # (n, 3) [m/s]
    triangles: np.ndarray  # (m, 3)
    fragment: np.ndarray  # (m,) id of the piece, in the shell and as a shard; for a body of the scene its number
    damage: np.ndarray  # (m,) 0..1, largest of all layers; 0 for bodies
    part: np.ndarray       # (m,) number of the shell, -1 for bodies
    body: np.ndarray       # (m,) -1 for the shell
    kind: np.ndarray       # (m,) as in frames.py, -1 for the shell


def mesh_of(frames: list[Frame], k: int) -> Mesh:
    """Reads frame k. Raises VtpError, OSError."""
    shell = frames[k].read(SHELL)
    bodies, moves = with_soft(frames[k], frames[k].read(BODIES), body_velocity(frames, k))
    points, velocity, triangles = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros((0, 3), int)]
    names = ("fragment", "damage", "part", "body", "kind")
    columns: dict[str, list[np.ndarray]] = {name: [np.zeros(0)] for name in names}
    if shell is not None:
        points.append(shell.points)
        velocity.append(shell_velocity(shell))
        triangles.append(shell.triangles)
        damage = shell.of_triangles("damage", 0.0)
        none = np.full(len(shell.triangles), -1)
        for name, values in zip(names, (shell.of_triangles("fragment", 0), damage.max(axis=1) if damage.ndim == 2 else damage,
                                        shell.of_triangles("shell", 0), none, none)):
            columns[name].append(values)
    if bodies is not None:
        triangles.append(bodies.triangles + sum(map(len, points)))
        points.append(bodies.points)
        velocity.append(moves)
        body = bodies.of_triangles("body", 0)
        none = np.full(len(body), -1)
        for name, values in zip(names, (body, 0.0 * body, none, body, bodies.of_triangles("kind", 0))):
            columns[name].append(values)
    joined = {name: np.concatenate(values) for name, values in columns.items()}
    return Mesh(np.concatenate(points), np.concatenate(velocity), np.concatenate(triangles), joined["fragment"].astype(int),
                joined["damage"], joined["part"].astype(int), joined["body"].astype(int), joined["kind"].astype(int))


def ply_bytes(mesh: Mesh, time_s: float) -> bytes:
    """Writes a binary PLY."""
    vertex = np.zeros(len(mesh.points), [(n, "<f4") for n in ("x", "y", "z", "vx", "vy", "vz")])
    for axis in range(3):
        vertex["xyz"[axis]], vertex["v" + "xyz"[axis]] = mesh.points[:, axis], mesh.velocity[:, axis]
    face = np.zeros(len(mesh.triangles), [("corners", "u1"), ("vertex_indices", "<i4", 3), ("fragment", "<i4"), ("damage", "<f4"),
                                          ("part", "<i4"), ("body", "<i4"), ("kind", "<i4")])
    face["corners"], face["vertex_indices"] = 3, mesh.triangles
    for name in ("fragment", "damage", "part", "body", "kind"):
        face[name] = getattr(mesh, name)
    lines = ["ply", "format binary_little_endian 1.0", f"comment time {time_s!r} s", f"element vertex {len(vertex)}",
             *(f"property float {n}" for n in vertex.dtype.names or ()), f"element face {len(face)}",
             "property list uchar int vertex_indices", "property int fragment", "property float damage", "property int part",
             "property int body", "property int kind", "end_header"]
    return ("\n".join(lines) + "\n").encode("ascii") + vertex.tobytes() + face.tobytes()


class _Glb:
    """A binary glTF under construction."""

    def __init__(self, time_s: float) -> None:
        self._blob = bytearray()
        self.json: dict[str, object] = {
            "asset": {"version": "2.0", "generator": "sunder export"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
            "meshes": [], "materials": [], "accessors": [], "bufferViews": [], "extras": {"time_s": time_s}}

    def _add(self, name: str, value: object) -> int:
        entries = self.json[name]
        assert isinstance(entries, list)
        entries.append(value)
        return len(entries) - 1

    def _accessor(self, values: np.ndarray, kind: str, target: int, limits: bool = False) -> int:
        view = self._add("bufferViews", {"buffer": 0, "byteOffset": len(self._blob), "byteLength": values.nbytes,
                                         "target": target})
        self._blob += values.tobytes()
        self._blob += bytes(-len(self._blob) % 4)
        accessor = {"bufferView": view, "componentType": 5126 if values.dtype.kind == "f" else 5125, "count": len(values),
                    "type": kind}
        if limits:  # required for positions
            accessor |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self._add("accessors", accessor)

    def _material(self, name: str, colour: tuple[float, ...]) -> int:
        """The number of the material of this name, which is added where it is new."""
        materials = self.json["materials"]
        assert isinstance(materials, list)
        for number, there in enumerate(materials):
            if there["name"] == name:
                return number
        linear = [round(float(c) ** 2.2, 4) for c in colour[:3]]
        alpha = colour[3] if len(colour) > 3 else 1.0
        return self._add("materials", {
            "name": name, "doubleSided": True, "alphaMode": "BLEND" if alpha < 1.0 else "OPAQUE",
            "pbrMetallicRoughness": {"baseColorFactor": [*linear, alpha], "metallicFactor": 0.0, "roughnessFactor": 0.5}})

    def add(self, name: str, mesh: Mesh, which: np.ndarray, of: str, colour: tuple[float, ...]) -> None:
        """Adds the triangles `which` as a node of this name and of the material `of`, which has the colour with which it
        came first; adds nothing where there are none."""
        if not which.any():
            return
        corners = mesh.triangles[which].ravel()
        upright = [0, 2, 1], np.array([1.0, 1.0, -1.0])  # x, y, z to x, z, -y
        attributes = {
            "POSITION": self._accessor((mesh.points[corners][:, upright[0]] * upright[1]).astype("<f4"), "VEC3", 34962, True),
            "_VELOCITY": self._accessor((mesh.velocity[corners][:, upright[0]] * upright[1]).astype("<f4"), "VEC3", 34962),
            "_FRAGMENT": self._accessor(np.repeat(mesh.fragment[which], 3).astype("<f4"), "SCALAR", 34962),
            "_DAMAGE": self._accessor(np.repeat(mesh.damage[which], 3).astype("<f4"), "SCALAR", 34962)}
        material = self._material(of, colour)
        indices = self._accessor(np.arange(len(corners), dtype="<u4"), "SCALAR", 34963)
        number = self._add("meshes", {"name": name, "primitives": [
            {"attributes": attributes, "indices": indices, "material": material}]})
        node = self._add("nodes", {"name": name, "mesh": number})
        scene = self.json["scenes"]
        assert isinstance(scene, list)
        scene[0]["nodes"].append(node)

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


def glb_bytes(mesh: Mesh, time_s: float, words: Words, part_of: dict[int, int]) -> bytes:
    """Writes a binary glTF 2.0. Materials have the names that the scene gives them."""
    out = _Glb(time_s)

    def look(part: int) -> tuple[str, tuple[float, ...]]:
        """Material and colour of a shell; of one that the scene does not tell about, a material of its own."""
        if part >= len(words.materials):
            return f"shell_{part}", tuple(PARTS[part % len(PARTS)])
        name = words.materials[part]
        return name, (*GLASS, 0.5) if words.glass[part] else tuple(PARTS[words.materials.index(name) % len(PARTS)])

    for part in np.unique(mesh.part[mesh.part >= 0]):
        out.add(words.shells[part] if part < len(words.shells) else f"shell_{part}", mesh, mesh.part == part, *look(int(part)))
    broken = (mesh.kind == SHARD) | (mesh.kind == FROZEN)
    of = np.array([part_of.get(int(b), -1) for b in mesh.body])
    for part in np.unique(of[broken]):
        if part < 0 and len({m for m, breaks in zip(words.materials, words.breaks) if breaks}) == 1:
            out.add("shards", mesh, broken & (of == part), *look(words.breaks.index(True)))  # of whichever shell
        elif part < 0:
            out.add("shards", mesh, broken & (of == part), "shards", tuple(PARTS[0]))
        else:
            out.add(f"shards_of_{words.shells[part]}", mesh, broken & (of == part), *look(int(part)))
    own = ~broken & (mesh.body >= 0)
    for number in np.unique(mesh.body[own]):
        known = 0 < number <= len(words.bodies)
        name, material = (words.bodies[number - 1], words.body_materials[number - 1]) if known else (f"body_{number}", "")
        out.add(name, mesh, own & (mesh.body == number), material or "body", STEEL)
    return out.packed()


def export(folder: Path, kind: str, out: Path | None, spec: str | None) -> int:
    """Writes the meshes and prints their paths; returns the exit status. Raises CommandError."""
    frames = frames_of(folder, "export")
    numbers = pick(spec or "all", len(frames))
    target = out if out is not None else folder / "export"
    words = scene_words(folder)
    part_of = origins(folder, words)
    with telling(target):
        target.mkdir(parents=True, exist_ok=True)
        for k in numbers:
            mesh, time_s = mesh_of(frames, k), frames[k].time_s
            content = ply_bytes(mesh, time_s) if kind == "ply" else glb_bytes(mesh, time_s, words, part_of)
            put_in_place(target / f"frame_{k:06d}.{'ply' if kind == 'ply' else 'glb'}", lambda path: path.write_bytes(content))
        rows = "".join(f"{k},{frames[k].time_s!r}\n" for k in numbers)
        put_in_place(target / TIMES, lambda path: path.write_text("frame,time [s]\n" + rows))
    print(target)
    return DONE
