"""The Blender add-on, headless in Debian's Blender; skipped where there is none."""
from __future__ import annotations

import json
import re
import shutil
import subprocess
import unittest
from pathlib import Path

import numpy as np

from sunder_tools.pictures.animated import animated_glb
from sunder_tools.pictures.between import film_frames
from sunder_tools.pictures.frames import BODIES, list_frames
from sunder_tools.pictures.rigid import turn_of
from sunder_tools.pictures.story import story_of
from sunder_tools.report.appearance import GLASS, GLASS_IOR
from sunder_tools.report.scene_text import SCENE_COPY

from . import REPOSITORY, test_pc2
from .synthetic import write_vtp
from .test_animated import SCENE, Parting
from .test_view import InAFolder

READ = ("pictures.between", "pictures.frames", "pictures.look", "pictures.materials", "pictures.pace", "pictures.picked",
        "pictures.story", "report.appearance", "report.run_folder", "report.scene_text")
ADDON = REPOSITORY / "coupler" / "blender"
# What Blender has made, as numbers: {frame: {object: centre, or corners of its visible meshes}}.
SCRIPT = """
import json, sys
sys.dont_write_bytecode = True
sys.path.insert(0, {addon!r})
import bpy
import sunder_run
sunder_run.register()
for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
assert bpy.ops.import_scene.sunder_run(directory={folder!r}) == {{"FINISHED"}}
scene, told = bpy.context.scene, {{}}
for frame in range(scene.frame_start, scene.frame_end + 1):
    scene.frame_set(frame)
    depsgraph, told[frame] = bpy.context.evaluated_depsgraph_get(), {{}}
    for thing in bpy.data.objects:
        if thing.type == "EMPTY":
            told[frame][thing.name] = {{"centre": list(thing.matrix_world.translation), "seen": {{}}}}
    for thing in bpy.data.objects:
        if thing.type != "MESH" or thing.hide_render or thing.parent is None:
            continue
        mesh = thing.evaluated_get(depsgraph).to_mesh()
        at = [list(thing.matrix_world @ v.co) for v in mesh.vertices]
        seen = told[frame][thing.parent.name]["seen"]
        for polygon in mesh.polygons:
            seen.setdefault(mesh.materials[polygon.material_index].name, []).append([at[v] for v in polygon.vertices])
cracks = bpy.data.objects["pane_cracks"].data
one = bpy.data.objects["pane_piece_1_shape_0"]
rest = one.data.attributes["rest_position"].data
glass = bpy.data.materials["glass_outside"].node_tree.nodes["Principled BSDF"].inputs
words = [w for w in ("Transmission", "Transmission Weight") if w in glass]
before = len(bpy.data.objects)
bpy.ops.import_scene.gltf(filepath={gltf!r})  # numpy's fault is mended: Blender's own importer works too
told["more"] = {{
    "fps": scene.render.fps, "keys": [k.name for k in one.data.shape_keys.key_blocks], "gltf": len(bpy.data.objects) - before,
    "collections": sorted(c.name for c in bpy.data.collections if c.name in ("pane", {name!r})),
    "rest": [min(v.vector[2] for v in rest), max(v.vector[2] for v in rest)],
    "damage": [v.value for v in one.data.attributes["damage"].data][:1],
    "places": [list(v.vector) for v in rest], "velocity": [list(v.vector) for v in one.data.attributes["run_velocity"].data],
    "uv": [[list(rest[l.vertex_index].vector), list(u.uv)] for l, u in zip(one.data.loops, one.data.uv_layers["UVMap"].data)],
    "colours": [list(c.color) for c in one.data.color_attributes["Color"].data],
    "shard": sorted(bpy.data.objects["pane_piece_2_shape_1"].data.attributes.keys()),
    "looks": [glass["Roughness"].default_value, glass["Metallic"].default_value, glass["IOR"].default_value],
    "born": [v.value for v in cracks.attributes["born"].data], "transmission": glass[words[0]].default_value}}
told["refused"] = ""
try:
    bpy.ops.import_scene.sunder_run(directory={addon!r})
except RuntimeError as error:
    told["refused"] = str(error)
open({out!r}, "w").write(json.dumps(told))
"""


# The collections of an import, and those in each.
NAMES = """
import json, sys
sys.dont_write_bytecode = True
sys.path.insert(0, {addon!r})
import bpy
import sunder_run
there = set(bpy.data.collections)
sunder_run.load({folder!r})
told = {{c.name: [child.name for child in c.children] for c in bpy.data.collections if c not in there}}
open({out!r}, "w").write(json.dumps(told))
"""


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed; apt-get install --no-install-recommends blender")
class Blender(Parting):
    def setUp(self) -> None:
        super().setUp()
        self.write_scene()
        write_vtp(self.folder / "frames/cracks.vtp", [[1, 0, 0], [1, 1, 0]], segments=[[0, 1]], floats="f8", cell_data={
            "crack": np.zeros(1), "time": np.array([1.5 * self.STEP]), "shell": np.zeros(1)})
        listed = (self.folder / "frames.pvd").read_text()
        (self.folder / "frames.pvd").write_text(listed.replace("</Collection>", (
            f'<DataSet timestep="{5 * self.STEP!r}" part="1" file="frames/cracks.vtp"/></Collection>')))
        self.gltf = self.folder / "run.glb"
        self.gltf.write_bytes(animated_glb(story_of(self.frames, self.words, {}), np.arange(6.0) / 24.0, {}))

    def more_of(self, rest: np.ndarray) -> dict[str, np.ndarray]:
        return {"colour": np.column_stack([0.1 + 0.4 * rest[:, 0], 0.9 - 0.8 * rest[:, 1], np.full(len(rest), 0.25)])}

    def test_a_run_folder_is_imported(self) -> None:
        script, out = self.folder / "script.py", self.folder / "told.json"
        script.write_text(SCRIPT.format(addon=str(ADDON), folder=str(self.folder), gltf=str(self.gltf), out=str(out),
                                        name=self.folder.name))
        done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python", str(script)],
                              cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr[-2000:])
        told = json.loads(out.read_text())
        more, refused = told.pop("more"), told.pop("refused")
        self.assertEqual(sorted(map(int, told)), list(range(6)))
        for frame, things in told.items():
            self.assertEqual(set(things), {"pane_piece_1", "pane_piece_2"})
            for name, thing in things.items():
                wanted = self.film.seen(name, float(frame))
                self.assertEqual(set(thing["seen"]), set(wanted), f"{name} in frame {frame}")
                for material, corners in wanted.items():
                    np.testing.assert_allclose(thing["seen"][material], corners, atol=2e-6)
                if wanted:
                    np.testing.assert_allclose(thing["centre"], self.film.centre(name, float(frame)), atol=2e-6)
        self.assertEqual((more["fps"], more["keys"]), (24, ["Basis", "step_1", "step_2"]))
        self.assertEqual(more["collections"], sorted(["pane", self.folder.name]))
        np.testing.assert_allclose(more["rest"], [-0.5 * self.THICK, 0.5 * self.THICK], atol=1e-9)
        np.testing.assert_allclose(more["velocity"], self.placed(np.array(more["places"]), 0.0)[1], atol=1e-4)
        rest, uv = (np.array([pair[k] for pair in more["uv"]]) for k in (0, 1))
        np.testing.assert_allclose(uv, rest[:, :2] / self.SIDES, atol=1e-6)
        colours = np.array(more["colours"])
        np.testing.assert_allclose(colours[:, :3], self.more_of(np.array(more["places"]))["colour"], atol=1e-6)
        np.testing.assert_array_equal(colours[:, 3], 1.0)
        self.assertTrue({"rest_position", "Color"} <= set(more["shard"]) and not {"damage", "run_velocity"} & set(more["shard"]))
        np.testing.assert_allclose(more["born"], [1.5], atol=1e-6)
        self.assertEqual((more["transmission"], more["damage"]), (1.0, [0.0]))
        np.testing.assert_allclose(more["looks"], [GLASS.roughness, 0.0, GLASS_IOR], atol=1e-6)
        self.assertGreater(more["gltf"], 3)
        self.assertRegex(refused, "frames.pvd")


    def test_a_folder_with_the_name_of_a_shell(self) -> None:
        script, out, run = self.folder / "script.py", self.folder / "told.json", self.folder / "pane"
        run.mkdir()
        for name in ("frames", "frames.pvd", "scene.textproto", "command.json"):
            (run / name).symlink_to(self.folder / name)
        script.write_text(NAMES.format(addon=str(ADDON), folder=str(run), out=str(out)))
        done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python", str(script)],
                              cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr[-2000:])
        self.assertEqual(json.loads(out.read_text()), {"pane_run": ["pane"], "pane": []})


# Places of the corners of a body in all frames of a film.
TURNING = """
import json, sys
sys.dont_write_bytecode = True
sys.path.insert(0, {addon!r})
import bpy
import sunder_run
sunder_run.load({folder!r}, fps=10.0, speed=0.5)
scene, told = bpy.context.scene, []
body, = [thing for thing in bpy.data.objects if thing.type == "MESH" and thing.parent and thing.parent.name == "body_7"]
for frame in range(scene.frame_start, scene.frame_end + 1):
    scene.frame_set(frame)
    told.append([list(body.matrix_world @ body.data.vertices[loop.vertex_index].co) for loop in body.data.loops])
open({out!r}, "w").write(json.dumps(told))
"""


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed; apt-get install --no-install-recommends blender")
class Turning(InAFolder):
    def test_a_body_turns_evenly_between_two_frames(self) -> None:
        """By two radians: Blender's own straight lines between quaternions would be some hundredths of a radian off."""
        (self.folder / "frames").mkdir()
        (self.folder / SCENE_COPY).write_text(SCENE)
        corners, faces = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]), np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        listed = ""
        for k in (0, 1):
            turn = turn_of(np.array([0, 0, np.sin(k), np.cos(k)]))
            write_vtp(self.folder / f"frames/bodies_{k}.vtp", corners @ turn.T + k, faces, floats="f8",
                      cell_data={"body": np.full(4, 7.0), "kind": np.zeros(4)})
            listed += f'<DataSet timestep="{k}" part="2" file="frames/bodies_{k}.vtp"/>'
        (self.folder / "frames.pvd").write_text(f"<VTKFile><Collection>{listed}</Collection></VTKFile>")
        script, out = self.folder / "script.py", self.folder / "told.json"
        script.write_text(TURNING.format(addon=str(ADDON), folder=str(self.folder), out=str(out)))
        done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python", str(script)],
                              cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr[-2000:])
        told, (pictures, _) = json.loads(out.read_text()), film_frames(list_frames(self.folder), 10.0, 0.5)
        self.assertEqual(len(told), len(pictures))
        for found, picture in zip(told, pictures):
            bodies = picture.read(BODIES)
            assert bodies is not None
            wanted = bodies.points[bodies.triangles].reshape(-1, 3)
            np.testing.assert_allclose(np.sort(found, axis=0), np.sort(wanted, axis=0), atol=2e-6)


# Corners of what each object shows in each frame, after the script of coupler/README.md has made them.
CACHES = """
import json
import bpy
scene, told = bpy.context.scene, {{}}
for frame in range(6):
    scene.frame_set(frame)
    depsgraph, told[frame] = bpy.context.evaluated_depsgraph_get(), {{}}
    for thing in bpy.data.objects:
        if thing.modifiers:
            mesh = thing.evaluated_get(depsgraph).to_mesh()
            told[frame][thing.name] = [list(thing.matrix_world @ v.co) for v in mesh.vertices]
open({out!r}, "w").write(json.dumps(told))
"""


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed; apt-get install --no-install-recommends blender")
class MeshCache(test_pc2.Written):
    def test_the_script_of_the_page_plays_point_caches(self) -> None:
        """Points are those of the frames, and objects that are not to be seen are drawn together into a point."""
        page = (REPOSITORY / "coupler" / "README.md").read_text()
        script, = [block for block in re.findall(r"^```python[^\n]*\n(.*?)^```", page, re.MULTILINE | re.DOTALL) if "MESH_CACHE" in block]
        folder, out = self.written.folder, self.folder / "told.json"
        self.assertIn("/path/to/pane_caches", script)
        (self.folder / "script.py").write_text(script.replace("/path/to/pane_caches", str(folder)) + CACHES.format(out=str(out)))
        done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python",
                               str(self.folder / "script.py")], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True,
                              text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr[-2000:])
        told = json.loads(out.read_text())
        for frame in range(6):
            self.assertEqual(set(told[str(frame)]), set(self.written.meshes))
            for name, points in told[str(frame)].items():
                np.testing.assert_allclose(points, self.written.points(name, frame), atol=1e-6, err_msg=f"{name} in frame {frame}")


class Source(unittest.TestCase):
    def test_it_is_an_add_on(self) -> None:
        """What Blender reads without running the file."""
        text = Path(ADDON / "sunder_run.py").read_text()
        self.assertTrue(re.search(r"^bl_info = \{", text, re.MULTILINE))
        for needed in ("def register() -> None", "def unregister() -> None"):
            self.assertIn(needed, text)

    def test_its_reader_needs_numpy_only(self) -> None:
        """Blender's own Python has no PIL, protobuf or matplotlib."""
        script = ("import sys; sys.path.insert(0, 'coupler'); sys.modules.update(dict.fromkeys(('PIL', 'google', 'matplotlib')));"
                  + ";".join(f"import sunder_tools.{m}" for m in READ))
        done = subprocess.run(["/usr/bin/python3", "-B", "-c", script], cwd=REPOSITORY, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        text = Path(ADDON / "sunder_run.py").read_text()
        self.assertEqual(set(re.findall(r"from sunder_tools\.(\S+) import", text)), set(READ))


if __name__ == "__main__":
    unittest.main()
