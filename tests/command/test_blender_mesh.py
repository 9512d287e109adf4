"""Rigid meshes that the Blender add-on makes: closed, with the normals and parameters of the run; skipped without Blender."""
from __future__ import annotations

import json
import shutil
import subprocess
import unittest
from typing import Any

import numpy as np

from sunder_tools.pictures.story import Shape, story_of
from sunder_tools.report.appearance import STEEL, as_linear
from sunder_tools.report.scene_text import SCENE_COPY

from . import REPOSITORY
from .synthetic import ball, write_vtp
from .test_animated import SCENE, Parting
from .test_view import InAFolder

ADDON = REPOSITORY / "coupler" / "blender"
# Of each rigid mesh: how many polygons its edges have, and place, normal and parameters of its corners.
SCRIPT = """
import json, sys
sys.dont_write_bytecode = True
sys.path.insert(0, {addon!r})
import bpy
import sunder_run
sunder_run.load({folder!r})
told = {{}}
for thing in bpy.data.objects:
    if thing.type != "MESH" or thing.parent is None or thing.data.shape_keys is not None:
        continue
    mesh = thing.data
    if hasattr(mesh, "calc_normals_split"):  # until 4.0
        mesh.calc_normals_split()
        normals = [list(loop.normal) for loop in mesh.loops]
    else:
        normals = [list(normal.vector) for normal in mesh.corner_normals]
    shared = {{}}
    for polygon in mesh.polygons:
        for edge in polygon.edge_keys:
            shared[edge] = shared.get(edge, 0) + 1
    uv = mesh.uv_layers.get("UVMap")
    rest = mesh.attributes.get("rest_position")
    told[thing.name] = {{
        "vertices": len(mesh.vertices), "shared": sorted(set(shared.values())), "normals": normals,
        "places": [list(mesh.vertices[loop.vertex_index].co) for loop in mesh.loops],
        "uv": [list(entry.uv) for entry in uv.data] if uv else [],
        "looks": {{material.name: [list(s["Base Color"].default_value)[:3], s["Metallic"].default_value, s["Roughness"].default_value]
                  for material in mesh.materials for s in [material.node_tree.nodes["Principled BSDF"].inputs]}},
        "rest": [list(rest.data[loop.vertex_index].vector) for loop in mesh.loops] if rest else []}}
open({out!r}, "w").write(json.dumps(told))
"""


def rows(*columns: np.ndarray) -> np.ndarray:
    """Rows of all columns, in an order of their own."""
    whole = np.column_stack(columns)
    return whole[np.lexsort(whole.round(4).T)]


class Made(InAFolder):
    def made(self) -> dict[str, dict[str, Any]]:
        script, out = self.folder / "script.py", self.folder / "told.json"
        script.write_text(SCRIPT.format(addon=str(ADDON), folder=str(self.folder), out=str(out)))
        done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python", str(script)],
                              cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr[-2000:])
        told: dict[str, dict[str, Any]] = json.loads(out.read_text())
        return told


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed; apt-get install --no-install-recommends blender")
class Shards(Made, Parting):
    def test_a_shard_is_closed_and_keeps_its_creases_and_parameters(self) -> None:
        (self.folder / SCENE_COPY).write_text(SCENE)
        made, = [one for name, one in self.made().items() if name == "pane_piece_2_shape_1"]
        self.assertEqual((made["vertices"], made["shared"]), (8, [2]))
        shape: Shape = next(thing for thing in story_of(self.frames, self.words, {}) if thing.name == "pane_piece_2").shapes[1]
        self.assertTrue(shape.rigid)
        wanted = rows(shape.points[0], shape.rest, shape.uv, shape.normals[0])
        np.testing.assert_allclose(rows(*(np.array(made[key]) for key in ("places", "rest", "uv", "normals"))), wanted, atol=2e-4)
        along = np.abs(np.array(made["normals"])).max(axis=1)
        self.assertGreater(float(along.min()), 0.9, "a normal that is none of a face")


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed; apt-get install --no-install-recommends blender")
class Balls(Made):
    def test_a_ball_is_round_and_closed_at_its_poles(self) -> None:
        """Its poles are many points, and each of its triangles may have points of its own."""
        (self.folder / "frames").mkdir()
        (self.folder / SCENE_COPY).write_text(SCENE)
        points, triangles = ball(0.02)
        points, triangles = points[triangles].reshape(-1, 3) + [0.1, 0.2, 0.3], np.arange(triangles.size).reshape(-1, 3)
        write_vtp(self.folder / "frames/bodies.vtp", points, triangles, floats="f8",
                  cell_data={"body": np.full(len(triangles), 7.0), "kind": np.zeros(len(triangles))})
        (self.folder / "frames.pvd").write_text('<VTKFile><Collection><DataSet timestep="0" part="2" file="frames/bodies.vtp"/>'
                                                '</Collection></VTKFile>')
        made = self.made()["body_7_shape_0"]
        self.assertEqual((made["vertices"], made["shared"]), (24 * 11 + 2, [2]))
        places, normals = np.array(made["places"]), np.array(made["normals"])
        turned = (normals * places).sum(axis=1) / np.linalg.norm(places, axis=1)
        self.assertGreater(float(turned.min()), 0.98)
        (colour, metallic, rough), = made["looks"].values()
        np.testing.assert_allclose([*colour, metallic, rough], [*as_linear(STEEL.colour), 1.0, STEEL.roughness], atol=1e-6)


if __name__ == "__main__":
    unittest.main()
