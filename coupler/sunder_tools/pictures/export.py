"""`sunder export`: a run as a sequence of meshes, one file a frame, that Blender and Houdini read.

Cracks change the triangles from frame to frame; animated.py makes one file of a run all the same.

PLY (binary): x, y, z [m] and vx, vy, vz [m/s] per vertex; fragment (id of the piece, in the shell and as a shard), damage,
part (number of the shell; -1 for bodies), body (its number, for a shard that of its piece; -1 for the shell), kind
(0 moving, 1 shard, 2 static, 3 frozen; -1 for the shell) and side (0 outside, 1 inside, 2 edge of a sheet; -1 otherwise)
per face. z is up.
s and t per vertex are the parameters on the shell, 0 to 1; 0 for what was never one. red, green and blue per vertex, 0 to 1,
are those of mesh files, where some have colours of points; white for what has none.
glTF (binary, .glb): a node per shell, the shards, and each body of the scene, y up as the format asks, with the materials
of the scene, of sheets one for each side; _VELOCITY, _FRAGMENT and _DAMAGE per vertex, for which faces have vertices of
their own. What is or was a shell has _REST, the place at rest, and TEXCOORD_0, the parameters;
COLOR_0 are the colours of its mesh file.
"""
from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import DONE
from ..report.appearance import Appearance
from ..report.scene_text import Words, known_words
from .between import film_frames
from .frames import FROZEN, SHARD
from .glb import INDICES, VERTICES, Glb, texture, thrice, upright
from .look import origins
from .materials import material_of_body, material_of_shards, material_of_shell, name_of_body, slot_name
from .mesh import Mesh, mesh_of
from .meshes import weld
from .pace import tell_pace
from .picked import pick
from .render import put_in_place, frames_of, telling
from .thick import corner_normals

FORMATS = ("ply", "gltf")
RGB = ("red", "green", "blue")
TIMES = "frame_times.csv"


def ply_bytes(mesh: Mesh, time_s: float) -> bytes:
    """Writes a binary PLY."""
    names = ("x", "y", "z", "vx", "vy", "vz", "s", "t") + (RGB if np.isfinite(mesh.colour).any() else ())
    vertex = np.zeros(len(mesh.points), [(n, "<f4") for n in names])
    for axis in range(3):
        vertex["xyz"[axis]], vertex["v" + "xyz"[axis]] = mesh.points[:, axis], mesh.velocity[:, axis]
    vertex["s"], vertex["t"] = np.nan_to_num(mesh.uv).T
    for channel, name in enumerate(RGB if RGB[0] in names else ()):
        vertex[name] = np.nan_to_num(mesh.colour[:, channel], nan=1.0)
    face = np.zeros(len(mesh.triangles), [("corners", "u1"), ("vertex_indices", "<i4", 3), ("fragment", "<i4"), ("damage", "<f4"),
                                          ("part", "<i4"), ("body", "<i4"), ("kind", "<i4"), ("side", "<i4")])
    face["corners"], face["vertex_indices"] = 3, mesh.triangles
    for name in ("fragment", "damage", "part", "body", "kind", "side"):
        face[name] = getattr(mesh, name)
    lines = ["ply", "format binary_little_endian 1.0", f"comment time {time_s!r} s", f"element vertex {len(vertex)}",
             *(f"property float {n}" for n in vertex.dtype.names or ()), f"element face {len(face)}",
             "property list uchar int vertex_indices", "property int fragment", "property float damage", "property int part",
             "property int body", "property int kind", "property int side", "end_header"]
    return ("\n".join(lines) + "\n").encode("ascii") + vertex.tobytes() + face.tobytes()


def _add(out: Glb, name: str, mesh: Mesh, normals: np.ndarray, which: np.ndarray, of: str, look: Appearance) -> None:
    """Adds the triangles `which` as a node of this name, with a primitive for each side; nothing where there are none."""
    if not which.any():
        return
    primitives = []
    for side in np.unique(mesh.side[which]):
        mine = which & (mesh.side == side)
        corners = mesh.triangles[mine].ravel()
        attributes = {
            "POSITION": out.accessor(upright(mesh.points[corners]), "VEC3", VERTICES, True),
            "NORMAL": out.accessor(upright(normals[mine].reshape(-1, 3)), "VEC3", VERTICES),
            "_VELOCITY": out.accessor(upright(mesh.velocity[corners]), "VEC3", VERTICES),
            "_FRAGMENT": out.accessor(thrice(np.repeat(mesh.fragment[mine], 3)), "VEC3", VERTICES),
            "_DAMAGE": out.accessor(thrice(np.repeat(mesh.damage[mine], 3)), "VEC3", VERTICES)}
        if np.isfinite(mesh.uv[corners]).all():
            attributes["TEXCOORD_0"] = out.accessor(texture(mesh.uv[corners]), "VEC2", VERTICES)
        if np.isfinite(mesh.colour[corners]).all():
            attributes["COLOR_0"] = out.accessor(mesh.colour[corners].astype("<f4"), "VEC3", VERTICES)
        if np.isfinite(mesh.rest[corners]).all():
            attributes["_REST"] = out.accessor(upright(mesh.rest[corners]), "VEC3", VERTICES)
        primitives.append({"attributes": attributes, "material": out.material(slot_name(of, int(side)), look),
                           "indices": out.accessor(np.arange(len(corners), dtype="<u4"), "SCALAR", INDICES)})
    out.show(out.node(name, mesh=out.add("meshes", {"name": name, "primitives": primitives})))


def _name_of_shell(part: int, words: Words) -> str:
    return words.shells[part] if part < len(words.shells) else f"shell_{part}"


def glb_bytes(mesh: Mesh, time_s: float, words: Words, part_of: dict[int, int]) -> bytes:
    """Writes a binary glTF 2.0. Materials have the names that the scene gives them."""
    out = Glb("sunder export", {"time_s": time_s})
    apart = np.zeros(len(mesh.points), np.int64)
    apart[mesh.triangles.ravel()] = np.repeat(np.where(mesh.body < 0, -1 - mesh.fragment, mesh.body), 3)
    normals = corner_normals(mesh.points, mesh.triangles, weld(mesh.points, apart))
    for part in np.unique(mesh.part[mesh.part >= 0]):
        _add(out, _name_of_shell(int(part), words), mesh, normals, mesh.part == part, *material_of_shell(int(part), words))
    broken = (mesh.kind == SHARD) | (mesh.kind == FROZEN)
    of = np.array([part if part >= 0 else part_of.get(int(b), -1) for part, b in zip(mesh.origin, mesh.body)])
    for part in np.unique(of[broken]):
        _add(out, "shards" if part < 0 else f"shards_of_{_name_of_shell(int(part), words)}", mesh, normals, broken & (of == part),
             *material_of_shards(int(part), words))
    own = ~broken & (mesh.body >= 0)
    for number in np.unique(mesh.body[own]):
        _add(out, name_of_body(int(number), words), mesh, normals, own & (mesh.body == number), *material_of_body(int(number), words))
    return out.packed()


def export(folder: Path, kind: str, out: Path | None, spec: str | None, fps: float | None = None,
           speed: float | None = None, middle: bool = False) -> int:
    """Writes the meshes and prints their folder; returns the exit status. Raises CommandError.

    With `speed` there is a file for each picture of a film, numbered from 0. `middle`: shells have no thickness.
    """
    frames = frames_of(folder, "export")
    numbers = pick(spec or "all", frames)
    if speed is not None:
        chosen = [frames[k] for k in numbers]
        tell_pace(folder, chosen, fps, speed, spec is None)
        frames, _ = film_frames(chosen, fps, speed)
        numbers = list(range(len(frames)))
    target = out if out is not None else folder / "export"
    words = known_words(folder, "export")
    part_of = origins(folder, words)
    with telling(target):
        target.mkdir(parents=True, exist_ok=True)
        for k in numbers:
            mesh, time_s = mesh_of(frames, k, () if middle else words.thickness), frames[k].time_s
            content = ply_bytes(mesh, time_s) if kind == "ply" else glb_bytes(mesh, time_s, words, part_of)
            put_in_place(target / f"frame_{k:06d}.{'ply' if kind == 'ply' else 'glb'}", lambda path: path.write_bytes(content))
        rows = "".join(f"{k},{frames[k].time_s!r}\n" for k in numbers)
        put_in_place(target / TIMES, lambda path: path.write_text("frame,time [s]\n" + rows))
    print(target)
    return DONE
