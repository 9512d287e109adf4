"""One animated glTF of a run: a node with keyframes for each piece and body, morph targets for what bends.

A node has the place of its thing, under the node of its shell; the shapes that it has one after another are its children.
A shape that is not to be seen has scale 0, which all readers know. y is up.
"""
from __future__ import annotations

from typing import Any

import numpy as np

from .glb import INDICES, VERTICES, Glb, texture, thrice, upright
from .story import Shape, Thing


def _quaternions(turn: list[np.ndarray]) -> np.ndarray:
    """Turns rotations with z up into those with y up: the axis turns with everything else."""
    q = np.array(turn)
    return np.column_stack([q[:, 0], q[:, 2], -q[:, 1], q[:, 3]]).astype("<f4")


class _Animation:
    """Channels of one animation; equal times are stored once."""

    def __init__(self, out: Glb, name: str) -> None:
        self._out = out
        self._times: dict[bytes, int] = {}
        self.json: dict[str, Any] = {"name": name, "channels": [], "samplers": []}

    def add(self, node: int, path: str, times: np.ndarray, values: np.ndarray, kind: str, how: str = "LINEAR") -> None:
        """Adds keyframes of a node."""
        raw = times.astype("<f4")
        if raw.tobytes() not in self._times:
            self._times[raw.tobytes()] = self._out.accessor(raw, "SCALAR", None, True)
        self.json["samplers"].append({"input": self._times[raw.tobytes()], "interpolation": how,
                                      "output": self._out.accessor(values.astype("<f4"), kind)})
        self.json["channels"].append({"sampler": len(self.json["samplers"]) - 1, "target": {"node": node, "path": path}})


def _mesh(out: Glb, name: str, shape: Shape) -> int:
    """Adds a shape as a mesh, with a morph target for each position after the first."""
    primitives = []
    for slot in shape.slots:
        mine = slice(slot.first, slot.first + slot.count)
        base, normal = shape.points[0][mine], shape.normals[0][mine]
        attributes = {"POSITION": out.accessor(upright(base), "VEC3", VERTICES, True),
                      "NORMAL": out.accessor(upright(normal), "VEC3", VERTICES)}
        if np.isfinite(shape.uv[mine]).all():
            attributes["TEXCOORD_0"] = out.accessor(texture(shape.uv[mine]), "VEC2", VERTICES)
        if np.isfinite(shape.colour[mine]).all():
            attributes["COLOR_0"] = out.accessor(shape.colour[mine].astype("<f4"), "VEC3", VERTICES)
        if np.isfinite(shape.rest[mine]).all():
            attributes["_REST"] = out.accessor(upright(shape.rest[mine]), "VEC3", VERTICES)
        if np.isfinite(shape.damage[mine]).all():
            attributes["_DAMAGE"] = out.accessor(thrice(shape.damage[mine]), "VEC3", VERTICES)
        if shape.velocity:
            attributes["_VELOCITY"] = out.accessor(upright(shape.velocity[0][mine] + shape.drift[0]), "VEC3", VERTICES)
        primitive = {"attributes": attributes, "material": out.material(slot.material, slot.look),
                     "indices": out.accessor(slot.triangles.astype("<u4").ravel(), "SCALAR", INDICES)}
        if not shape.rigid:
            primitive["targets"] = [
                {"POSITION": out.accessor(upright(points[mine] - base), "VEC3", VERTICES, True),
                 "NORMAL": out.accessor(upright(normals[mine] - normal), "VEC3", VERTICES)}
                for points, normals in zip(shape.points[1:], shape.normals[1:])]
        primitives.append(primitive)
    return out.add("meshes", {"name": name, "primitives": primitives})


def animated_glb(things: list[Thing], times: np.ndarray, extras: dict[str, Any]) -> bytes:
    """Writes a binary glTF 2.0. `times` (n,) [s] of the film are those of all frames."""
    out = Glb("sunder export", extras)
    animation = _Animation(out, "run")
    groups: dict[str, int] = {}
    for thing in things:
        whole = len(thing.shapes) == 1 and thing.shapes[0].first == 0 and thing.shapes[0].last == len(times) - 1
        node = out.node(thing.name, translation=upright(thing.centre[0]).tolist())
        if whole:
            _show(out, animation, node, thing.name, thing.shapes[0], times)
        else:
            children = []
            for number, shape in enumerate(thing.shapes):
                name = f"{thing.name}_shape_{number}"
                children.append(out.node(name))
                _show(out, animation, children[-1], name, shape, times)
            out.json["nodes"][node]["children"] = children
        _place(animation, node, thing, times)
        if not thing.group:
            out.show(node)
            continue
        if thing.group not in groups:
            groups[thing.group] = out.node(thing.group, children=[])
            out.show(groups[thing.group])
        out.json["nodes"][groups[thing.group]]["children"].append(node)
    if animation.json["channels"]:
        out.add("animations", animation.json)
    return out.packed()


def _place(animation: _Animation, node: int, thing: Thing, times: np.ndarray) -> None:
    """Adds the keyframes of a thing's place."""
    at, centre = times[thing.keys], upright(np.array(thing.centre))
    if len(at) > 1 and (thing.group or np.ptp(centre, axis=0).any()):
        animation.add(node, "translation", at, centre, "VEC3")
    turn = _quaternions(thing.turn)
    if len(at) > 1 and np.ptp(turn, axis=0).any():
        animation.add(node, "rotation", at, turn, "VEC4")


def _show(out: Glb, animation: _Animation, node: int, name: str, shape: Shape, times: np.ndarray) -> None:
    """Gives a node the mesh of a shape, its bending, and the time in which it is seen."""
    number = _mesh(out, name, shape)
    out.json["nodes"][node]["mesh"] = number
    if not shape.rigid:
        steps = len(shape.points)
        weights = np.eye(steps)[:, 1:]  # a target after another
        out.json["meshes"][number]["weights"] = [0.0] * (steps - 1)
        animation.add(node, "weights", times[shape.first:shape.first + steps], weights.ravel(), "SCALAR")
    seen = [(times[0], 0.0)] if shape.first > 0 else []
    seen.append((times[shape.first], 1.0))
    if shape.last + 1 < len(times):
        seen.append((times[shape.last + 1], 0.0))
    if len(seen) > 1:
        animation.add(node, "scale", np.array([t for t, _ in seen]), np.repeat([[s] for _, s in seen], 3, axis=1), "VEC3", "STEP")
        if seen[0][1] == 0.0:
            out.json["nodes"][node]["scale"] = [0.0, 0.0, 0.0]
