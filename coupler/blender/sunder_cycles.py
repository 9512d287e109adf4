"""Draws frames of a run with Cycles, in Blender without a window:

    blender --background --factory-startup --python sunder_cycles.py -- JOB.json

`sunder render --cycles` writes the job and reads the pictures (sunder_tools/pictures/cycles.py, which says what is in it).
Each picture that is done is told by a line DRAWN on standard output.
"""
from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy  # noqa: E402
import sunder_run  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

DRAWN = "sunder-drawn "
BOUNCES = 16          # of light: a pane of pieces is many sheets of glass, one behind another
SENSOR_MM = 36.0
SUN_SIZE = 0.12       # [rad]: soft shadows
# What is around a scene: colours of the sky from the horizon to the zenith, by the height of a direction; colour of the ground;
# exposure [stops]; most light that comes by glass or metal, as single grains brighter than that would not average out. Glass
# shows its edges where bright and dark stand side by side.
BACKDROPS: dict[str, dict[str, Any]] = {
    "light": {"sky": ((0.0, (0.20, 0.22, 0.25)), (0.10, (0.62, 0.66, 0.70)), (0.28, (0.30, 0.36, 0.44)),
                      (0.62, (0.55, 0.66, 0.82)), (0.80, (1.1, 1.1, 1.08))), "ground": (0.28, 0.285, 0.29), "exposure": -0.55,
              "brightest": 4.0},
    "dark": {"sky": ((0.0, (0.03, 0.04, 0.05)), (0.06, (0.30, 0.36, 0.44)), (0.22, (0.05, 0.07, 0.10)),
                     (0.60, (0.16, 0.20, 0.28)), (0.78, (1.2, 1.2, 1.15))), "ground": (0.035, 0.037, 0.042), "exposure": 0.0,
             "brightest": 1.0}}
EDGE_DEPTH = 0.6      # power of its colour that an edge of glass has
LEVEL = 1e-3          # [of the size of the scene] within which a body that is flat lies on the ground


def main() -> None:
    """Draws what the job asks for."""
    job = json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text(encoding="utf-8"))
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    sunder_run.load(job["folder"], job["fps"], job["speed"])
    for material in bpy.data.materials:
        _dress(material, job["looks"])
    _hide_floors(job["ground"], job["static"])
    backdrop = BACKDROPS[job["backdrop"]]
    _ground(job["ground"], backdrop["ground"])
    _light(job["light"], backdrop["sky"])
    _camera(job["camera"])
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples, scene.cycles.seed = job["samples"], 0
    scene.cycles.use_adaptive_sampling, scene.cycles.adaptive_threshold = True, 0.02
    # the release of Debian 12 is built without a denoiser
    scene.cycles.use_denoising = bool(getattr(bpy.app.build_options, "openimagedenoise", False))
    scene.cycles.max_bounces = scene.cycles.transmission_bounces = scene.cycles.transparent_max_bounces = BOUNCES
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = False
    scene.cycles.blur_glossy, scene.cycles.sample_clamp_indirect = 1.0, backdrop["brightest"]
    scene.render.use_persistent_data = True
    if job["threads"]:
        scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.view_settings.view_transform = "Filmic"
    scene.view_settings.look = "High Contrast"  # Filmic alone makes colours pale
    scene.view_settings.exposure = backdrop["exposure"]
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    for number, path in zip(job["frames"], job["pictures"]):
        scene.frame_set(number)
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        print(f"{DRAWN}{path}", flush=True)


def _dress(material: Any, looks: dict[str, dict[str, Any]]) -> None:
    """Gives a material the look of the scene's material whose name it begins with. One that the scene does not name keeps
    the look that the add-on gave it."""
    tree = material.node_tree
    shader = next((node for node in tree.nodes if node.type == "BSDF_PRINCIPLED"), None) if tree is not None else None
    if shader is None:
        return
    names = [name for name in looks if material.name == name or material.name.startswith(f"{name}_")]
    if not names:
        _put(shader, {"Specular": 0.4, "Specular IOR Level": 0.4})
        return
    look = looks[max(names, key=len)]
    kind, colour, rough = look["kind"], (*look["colour"], 1.0), look["roughness"]
    if kind == "glass":
        clear = (*sunder_run.clear_colour(look["colour"]), 1.0)
        _put(shader, {"Transmission": 1.0, "Transmission Weight": 1.0, "Roughness": rough, "Base Color": clear})
        if material.name.endswith("_edge"):  # light that has gone through the sheet lengthwise is coloured, and scattered
            _put(shader, {"Base Color": tuple(c ** EDGE_DEPTH for c in colour), "Roughness": 0.3, "Transmission": 0.6,
                          "Transmission Weight": 0.6})
        _let_light_through(tree, shader)
        return
    _put(shader, {"Base Color": colour, "Roughness": rough})
    if kind == "metal":
        _put(shader, {"Metallic": 1.0})
    elif kind == "cloth":
        _put(shader, {"Sheen": 0.3, "Sheen Weight": 0.3, "Specular": 0.1, "Specular IOR Level": 0.1})
    elif kind == "paint":
        _put(shader, {"Specular": 0.5, "Specular IOR Level": 0.5, "Clearcoat": 0.5, "Coat Weight": 0.5, "Clearcoat Roughness": 0.03,
                      "Coat Roughness": 0.03})
    else:
        _put(shader, {"Specular": 0.4, "Specular IOR Level": 0.4})


def _put(shader: Any, values: dict[str, Any]) -> None:
    """Sets those inputs that this release has: some were renamed in 4.0."""
    for name, value in values.items():
        if name in shader.inputs:
            shader.inputs[name].default_value = value


def _let_light_through(tree: Any, shader: Any) -> None:
    """Glass casts a light shadow: without caustics it would cast one like a stone's."""
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    path, clear, mix = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("LightPath", "BsdfTransparent", "MixShader"))
    clear.inputs["Color"].default_value = (0.92, 0.96, 0.94, 1.0)
    tree.links.new(path.outputs["Is Shadow Ray"], mix.inputs[0])
    tree.links.new(shader.outputs[0], mix.inputs[1])
    tree.links.new(clear.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])


def _hide_floors(ground: dict[str, Any], static: list[str]) -> None:
    """Hides static bodies that lie flat on the ground's height: the ground takes their place. Two planes in one place are black
    where each hides the other from the light."""
    for thing in bpy.data.objects:
        if thing.type != "MESH" or thing.parent is None or thing.parent.name not in static:
            continue
        box = [thing.matrix_world @ Vector(corner) for corner in thing.bound_box]
        flat = all(abs(corner.z - ground["z"]) < LEVEL * ground["size"] for corner in box)
        if flat:
            thing.hide_render = True
            if thing.animation_data is not None:
                thing.animation_data_clear()


def _ground(ground: dict[str, Any], colour: tuple[float, ...]) -> None:
    """Adds a matt plane that reaches to where the sky hides its end."""
    reach = 60.0 * ground["size"]
    x, y = ground["centre"]
    mesh = bpy.data.meshes.new("ground")
    mesh.from_pydata([(x + a * reach, y + b * reach, ground["z"]) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))], [],
                     [(0, 1, 2, 3)])
    material = bpy.data.materials.new("ground")
    material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    _put(shader, {"Base Color": (*colour, 1.0), "Roughness": 0.6, "Specular": 0.2, "Specular IOR Level": 0.2})
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("ground", mesh))


def _light(towards: list[float], sky: tuple[Any, ...]) -> None:
    """Adds a sun in the direction `towards`, and a sky of these colours."""
    lamp = bpy.data.lights.new("sun", "SUN")
    lamp.energy, lamp.angle = 4.2, SUN_SIZE
    thing = bpy.data.objects.new("sun", lamp)
    thing.rotation_mode = "QUATERNION"
    thing.rotation_quaternion = Vector(towards).to_track_quat("Z", "Y")
    bpy.context.scene.collection.objects.link(thing)
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    place, split, ramp = (nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "SeparateXYZ", "ValToRGB"))
    links.new(place.outputs["Generated"], split.inputs[0])
    links.new(split.outputs["Z"], ramp.inputs[0])
    stops = ramp.color_ramp.elements
    for k, (height, colour) in enumerate(sky):
        stop = stops[k] if k in (0, 1) else stops.new(height)
        stop.position, stop.color = height, (*colour, 1.0)
    back = next(node for node in nodes if node.type == "BACKGROUND")
    back.inputs["Strength"].default_value = 1.0
    links.new(ramp.outputs[0], back.inputs[0])
    bpy.context.scene.world = world


def _camera(told: dict[str, Any]) -> None:
    """Adds the camera of `sunder render`: pixels with a focal length, from an eye along three axes."""
    camera = bpy.data.cameras.new("camera")
    width, height = told["size"]
    camera.sensor_fit, camera.sensor_width = "HORIZONTAL", SENSOR_MM
    camera.lens = told["focal"] / width * SENSOR_MM
    camera.clip_start, camera.clip_end = told["near"], told["far"]
    thing = bpy.data.objects.new("camera", camera)
    right, down, forward = (Vector(axis) for axis in told["axes"])
    turn = Matrix((right, -down, -forward)).transposed()  # a camera looks along -z, and y is up
    thing.matrix_world = Matrix.Translation(Vector(told["eye"])) @ turn.to_4x4()
    scene = bpy.context.scene
    scene.collection.objects.link(thing)
    scene.camera = thing
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100


try:
    main()
except Exception as error:  # noqa: BLE001: Blender would end with status 0
    print(f"sunder-failed {type(error).__name__}: {error}", flush=True)
    sys.exit(1)
