"""Blender add-on: File > Import > Sunder run. Reads a run folder into named objects with keyframes.

An empty for each piece (pane_piece_17) and body, with its place over time, in a collection for its shell; meshes under it,
with shape keys where they bend, material slots (glass_outside, glass_inside and glass_edge of sheets of glass), a UV map of the
shell's parameters, and attributes `rest_position`, `damage` and `run_velocity` [m/s]. Crack lines are edges with an attribute
`born`, in film frames. Sizes are metres, z is up, frame 0 is the first of the run.

The reader is the project's (sunder_tools.pictures), found in the checkout that holds this file, in the folder that the
preferences of the add-on name, or where `pip install` has put it. It needs numpy only, which Blender has.
"""
from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any, Sequence

import bpy
import numpy as np

bl_info = {"name": "Sunder run", "author": "The Sunder developers", "version": (0, 9, 0), "blender": (3, 4, 0),
           "location": "File > Import > Sunder run", "category": "Import-Export",
           "description": "Imports a run folder: pieces, bodies, materials, thickness, cracks"}

LINEAR, CONSTANT = 1, 0  # interpolation of keyframes, as foreach_set takes it
TURN = 0.02              # [rad] between two keys of a rotation: its third power, some 1e-7 rad, is the error half way
LEAST_FPS, MOST_FPS = 1e-3, 1e3  # as `sunder export` has them
CLEAREST = 0.12          # share of its colour that a sheet of glass has where it is looked through


def _find_reader(folder: str) -> None:
    """Puts the project's Python on the path; `folder` may be the checkout too. Raises ImportError that says what to do."""
    named = Path(bpy.path.abspath(folder)) if folder else None
    tried = [*([named, named / "coupler"] if named is not None else []), Path(__file__).resolve().parents[1]]
    for place in tried:
        if (place / "sunder_tools" / "pictures" / "story.py").is_file() and str(place) not in sys.path:
            sys.path.insert(0, str(place))
    try:
        importlib.import_module("sunder_tools.pictures.story")
    except ImportError as error:
        raise ImportError(f"no reader of runs in {' or '.join(map(str, tried))} ({error}); name the folder 'coupler' of a checkout "
                          f"of Sunder in the preferences of the add-on, where {named or 'nothing'} is named") from None


def load(folder: str, fps: float = 24.0, speed: float = 0.0, middle: bool = False, reader: str = "", frames: str = "",
         notes: list[str] | None = None) -> list[Any]:
    """Imports a run folder into the present scene; returns the objects of its pieces and bodies.

    `speed` says how fast time runs; 0: each frame of the run is a frame here. `frames` says which, as `sunder export --frames`;
    "": all. What is worth a note, such as cracks that grow within a picture, is printed, and added to `notes`. Raises ImportError,
    OSError, ValueError, and CommandError or VtpError of the reader.
    """
    if not 0.0 <= speed < float("inf"):
        raise ValueError(f"speed is {speed:g}, must be above 0, such as 0.1 for a second in ten, or 0: a frame of the run is one here")
    if not LEAST_FPS <= fps <= MOST_FPS:
        raise ValueError(f"fps is {fps:g}, must be {LEAST_FPS:g} to {MOST_FPS:g}; 24 is usual")
    _find_reader(reader)
    from sunder_tools.pictures.between import key_frames
    from sunder_tools.pictures.frames import list_frames
    from sunder_tools.pictures.look import origins
    from sunder_tools.pictures.pace import as_argument, tell_pace
    from sunder_tools.pictures.picked import pick
    from sunder_tools.pictures.story import story_of
    from sunder_tools.report.run_folder import not_a_run
    from sunder_tools.report.scene_text import known_words
    run = Path(bpy.path.abspath(folder))
    wrong = not_a_run(run)
    if wrong:
        raise ValueError(wrong)
    chosen = list_frames(run)
    if frames:
        chosen = [chosen[k] for k in pick(frames, chosen)]
    told = tell_pace(run, chosen, fps, speed or None, not frames, as_argument)
    if notes is not None:
        notes += told
    shown, times = key_frames(chosen, fps, speed or None)
    words = known_words(run, "import")
    things = story_of(shown, words, origins(run, words), middle)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = max(round(fps), 1), max(round(fps), 1) / fps
    scene.frame_start, scene.frame_end = 0, int(np.ceil(times[-1] * fps - 1e-6))
    top = bpy.data.collections.new(_name_of_run(run.resolve().name, {thing.group for thing in things}))
    scene.collection.children.link(top)
    groups: dict[str, Any] = {"": top}
    found = []
    for thing in things:
        if thing.group not in groups:
            groups[thing.group] = bpy.data.collections.new(thing.group)
            top.children.link(groups[thing.group])
        found.append(_add_thing(thing, groups[thing.group], times * fps))
    _add_cracks(shown, times * fps, words.shells, groups, top)
    scene.frame_set(0)
    return found


def _name_of_run(folder: str, shells: set[str]) -> str:
    """Returns the name of a run's collection: that of its folder, and of no shell, which Blender would number."""
    name = folder
    while name in shells:
        name += "_run"
    return name


def _add_thing(thing: Any, collection: Any, at: np.ndarray) -> Any:
    """Adds an empty with the place of a thing, and its shapes under it."""
    empty = bpy.data.objects.new(thing.name, None)
    empty.empty_display_size = 0.0
    empty.rotation_mode = "QUATERNION"
    collection.objects.link(empty)
    codes = at[thing.keys]
    turn = np.array(thing.turn)[:, [3, 0, 1, 2]]
    empty.location, empty.rotation_quaternion = thing.centre[0], turn[0]
    if len(codes) > 1:
        action = _action(empty)
        _curves(action, "location", codes, np.array(thing.centre))
        if np.ptp(turn, axis=0).any():
            _curves(action, "rotation_quaternion", *_evenly(codes, turn))
    for number, shape in enumerate(thing.shapes):
        _add_shape(f"{thing.name}_shape_{number}", shape, empty, collection, at)
    return empty


def _evenly(codes: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Adds keys to those of unit quaternions (n, 4) where much is turned between two: components go straight here, and a body
    would turn faster half way. There is at most one a frame of the film."""
    half = np.arccos(np.clip(np.einsum("ij,ij->i", turn[:-1], turn[1:]), -1.0, 1.0))
    all_codes, all_turns = [codes[:1]], [turn[:1]]
    for k, angle in enumerate(half):
        steps = int(np.ceil(2.0 * angle / TURN))
        between = np.arange(np.floor(codes[k]) + 1, codes[k + 1])  # whole frames of the film
        if len(between) + 1 > steps:
            between = np.linspace(codes[k], codes[k + 1], max(steps, 1) + 1)[1:-1]
        share = ((between - codes[k]) / (codes[k + 1] - codes[k]))[:, None]
        if len(between):
            all_turns.append((np.sin((1.0 - share) * angle) * turn[k] + np.sin(share * angle) * turn[k + 1]) / np.sin(angle))
        all_codes += [between, codes[k + 1:k + 2]]
        all_turns.append(turn[k + 1:k + 2])
    return np.concatenate(all_codes), np.concatenate(all_turns)


def _add_shape(name: str, shape: Any, parent: Any, collection: Any, at: np.ndarray) -> None:
    """Adds a mesh with slots, attributes, shape keys, and the frames in which it is seen."""
    mesh = bpy.data.meshes.new(name)
    corners = np.concatenate([slot.first + slot.triangles for slot in shape.slots]).astype(np.int32)
    which = np.repeat(np.arange(len(shape.slots), dtype=np.int32), [len(slot.triangles) for slot in shape.slots])
    kept, vertex = np.arange(len(shape.points[0])), corners
    if len(shape.point):  # of a body, whose triangles share no vertices: here they do, so that edges are closed
        _, kept, back = np.unique(shape.point, return_index=True, return_inverse=True)
        vertex = back.reshape(-1)[corners].astype(np.int32)
        area = (vertex != np.roll(vertex, 1, axis=1)).all(axis=1)  # triangles at the poles of a ball have none
        corners, vertex, which = corners[area], vertex[area], which[area]
    count = len(corners)
    mesh.vertices.add(len(kept))
    mesh.vertices.foreach_set("co", _flat(shape.points[0][kept]))
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", vertex.ravel())
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", 3 * np.arange(count, dtype=np.int32))
    if bpy.app.version < (4, 1, 0):
        mesh.polygons.foreach_set("loop_total", np.full(count, 3, np.int32))
    for slot in shape.slots:
        mesh.materials.append(_material(slot.material, slot.look))
    mesh.polygons.foreach_set("material_index", which)
    mesh.polygons.foreach_set("use_smooth", np.ones(count, bool))
    mesh.update(calc_edges=True)
    if np.isfinite(shape.uv).all():
        mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", _flat(shape.uv[corners.ravel()]))
    if np.isfinite(shape.colour).all():
        rgba = np.column_stack([shape.colour[kept], np.ones(len(kept))])
        mesh.color_attributes.new("Color", "FLOAT_COLOR", "POINT").data.foreach_set("color", _flat(rgba))
    if np.isfinite(shape.rest).all():
        mesh.attributes.new("rest_position", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", _flat(shape.rest[kept]))
    if shape.velocity:  # not named `velocity`: Cycles would blur all frames by this one
        start = _flat(shape.velocity[0] + shape.drift[0])
        mesh.attributes.new("run_velocity", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", start)
    if np.isfinite(shape.damage).all():
        mesh.attributes.new("damage", "FLOAT", "POINT").data.foreach_set("value", _flat(shape.damage[kept]))
    if len(shape.point):  # sharp edges are in the normals of corners
        mesh.normals_split_custom_set(shape.normals[0][corners.ravel()].tolist())
        if hasattr(mesh, "use_auto_smooth"):  # until 4.0
            mesh.use_auto_smooth = True
    thing = bpy.data.objects.new(name, mesh)
    thing.parent = parent
    collection.objects.link(thing)
    if not shape.rigid:
        _add_keys(thing, shape, at)
    seen = [(0.0, 1.0)] if shape.first > 0 else []  # 1: hidden
    seen.append((float(at[shape.first]), 0.0))
    if shape.last + 1 < len(at):
        seen.append((float(at[shape.last + 1]), 1.0))
    if len(seen) > 1:
        codes, values = np.array(seen).T
        for path in ("hide_viewport", "hide_render"):
            _curves(_action(thing), path, codes, values[:, None], CONSTANT)


def _add_keys(thing: Any, shape: Any, at: np.ndarray) -> None:
    """Adds a shape key for each position after the first, one after another over time."""
    thing.shape_key_add(name="Basis", from_mix=False)
    keys = []
    for step, points in enumerate(shape.points[1:], start=1):
        key = thing.shape_key_add(name=f"step_{step}", from_mix=False)
        key.data.foreach_set("co", _flat(points))
        keys.append(key.name)
    action = _action(thing.data.shape_keys)
    codes = at[shape.first:shape.first + len(shape.points)]
    for step, key in enumerate(keys, start=1):
        near = slice(step - 1, min(step + 2, len(codes)))
        values = (np.arange(len(codes)) == step).astype(float)[near]
        _curves(action, f'key_blocks["{key}"].value', codes[near], values[:, None])


def _add_cracks(frames: list[Any], at: np.ndarray, shells: tuple[str, ...], groups: dict[str, Any], top: Any) -> None:
    """Adds the crack lines of the last frame with any, at rest, as edges of a mesh for each shell; not rendered."""
    from sunder_tools.pictures.frames import CRACKS
    last = next((frame for frame in reversed(frames) if CRACKS in frame.files), None)
    lines = last.read(CRACKS) if last is not None else None
    if lines is None or not len(lines.segments()) or "time" not in lines.cell_data:
        return
    pairs = lines.segments()
    of = np.asarray(lines.cell_data.get("shell", np.zeros(len(pairs)))).astype(int)
    run_times = np.array([frame.time_s for frame in frames])
    born = np.interp(lines.cell_data["time"], run_times, at)
    for shell in np.unique(of):
        name = shells[shell] if shell < len(shells) else f"shell_{shell}"
        mine = pairs[of == shell]
        mesh = bpy.data.meshes.new(f"{name}_cracks")
        mesh.vertices.add(2 * len(mine))
        mesh.vertices.foreach_set("co", _flat(lines.points[mine]))
        mesh.edges.add(len(mine))
        mesh.edges.foreach_set("vertices", np.arange(2 * len(mine), dtype=np.int32))
        mesh.attributes.new("born", "FLOAT", "EDGE").data.foreach_set("value", _flat(born[of == shell]))
        mesh.update()
        thing = bpy.data.objects.new(f"{name}_cracks", mesh)
        thing.hide_render = True
        groups.get(name, top).objects.link(thing)


def clear_colour(colour: Sequence[float]) -> tuple[float, ...]:
    """Returns the colour of glass with this one, as it is looked through."""
    return tuple(1.0 - CLEAREST * (1.0 - c) for c in colour)


def _material(name: str, look: Any) -> Any:
    """Returns the material of this name; a new one has the look, which is an entry of the project's table."""
    from sunder_tools.pictures.materials import OPACITY
    from sunder_tools.report.appearance import GLASS_IOR
    there = bpy.data.materials.get(name)
    if there is not None:
        return there
    material = bpy.data.materials.new(name)
    material.diffuse_color = (*look.linear, OPACITY if look.clear else 1.0)
    material.use_nodes = True
    shader = next((node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"), None)
    if shader is not None:
        shader.inputs["Base Color"].default_value = (*(clear_colour(look.linear) if look.clear else look.linear), 1.0)
        shader.inputs["Roughness"].default_value, shader.inputs["Metallic"].default_value = look.roughness, look.metallic
        for words, value in (("Transmission", 1.0), ("Transmission Weight", 1.0), ("IOR", GLASS_IOR)):  # before and since 4.0
            if look.clear and words in shader.inputs:
                shader.inputs[words].default_value = value
    return material


def _action(owner: Any) -> Any:
    """Returns the action of an object or of shape keys, a new one where it has none."""
    data = owner.animation_data or owner.animation_data_create()
    if data.action is None:
        data.action = bpy.data.actions.new(f"{owner.name}_action")
    return data.action


def _curves(action: Any, path: str, codes: np.ndarray, values: np.ndarray, how: int = LINEAR) -> None:
    """Adds keyframes of a property; `values` (n, components)."""
    for index in range(values.shape[1]):
        curve = action.fcurves.new(path, index=index)
        curve.keyframe_points.add(len(codes))
        curve.keyframe_points.foreach_set("co", _flat(np.column_stack([codes, values[:, index]])))
        curve.keyframe_points.foreach_set("interpolation", np.full(len(codes), how, np.int32))
        curve.update()


def _flat(values: np.ndarray) -> np.ndarray:
    """Returns single-precision numbers in a row, as foreach_set takes them."""
    return np.ascontiguousarray(values, np.float32).ravel()


# Properties by name: annotations are text here, which linters would read as types.
_READER = bpy.props.StringProperty(name="Folder 'coupler' of a checkout", subtype="DIR_PATH")
_DIRECTORY = bpy.props.StringProperty(subtype="DIR_PATH")
_FPS = bpy.props.FloatProperty(name="Frames a second", default=24.0, min=1.0)
_SPEED = bpy.props.FloatProperty(name="Speed", default=0.0, min=0.0, precision=6,
                                 description="How fast time runs; 0: each frame of the run is a frame")
_FRAMES = bpy.props.StringProperty(name="Frames of the run", description="As 0-20,last or 3ms-20ms; empty: all")
_MIDDLE = bpy.props.BoolProperty(name="Middle surfaces of shells", default=False)


class SunderPreferences(bpy.types.AddonPreferences):
    """Where the reader is."""
    bl_idname = __name__
    reader: _READER

    def draw(self, context: Any) -> None:
        """Shows the setting."""
        self.layout.prop(self, "reader")


class ImportSunderRun(bpy.types.Operator):
    """Import the folder of a run"""
    bl_idname, bl_label, bl_options = "import_scene.sunder_run", "Import Sunder run", {"UNDO"}
    directory: _DIRECTORY
    fps: _FPS
    speed: _SPEED
    frames: _FRAMES
    middle: _MIDDLE

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Asks for the folder."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Any) -> set[str]:
        """Imports it; reports what is wrong."""
        addon = context.preferences.addons.get(__name__)
        notes: list[str] = []
        try:
            load(self.directory, self.fps, self.speed, self.middle, addon.preferences.reader if addon else "", self.frames, notes)
        except Exception as error:  # noqa: BLE001: whatever it is, the user is to see it
            said = str(error) or type(error).__name__
            self.report({"ERROR"}, said if self.directory.rstrip("/") in said else f"{self.directory}: {said}")
            return {"CANCELLED"}
        for note in notes:
            self.report({"INFO"}, note)
        return {"FINISHED"}


def _menu(self: Any, context: Any) -> None:
    self.layout.operator(ImportSunderRun.bl_idname, text="Sunder run")


def _mend_numpy() -> None:
    """Blender 3.4's own glTF importer takes np.bool, which numpy 1.24 of Debian 12 does not have any more."""
    if "bool" not in vars(np):
        np.bool = bool  # type: ignore[attr-defined]


def register() -> None:
    """Called by Blender."""
    _mend_numpy()
    bpy.utils.register_class(SunderPreferences)
    bpy.utils.register_class(ImportSunderRun)
    bpy.types.TOPBAR_MT_file_import.append(_menu)


def unregister() -> None:
    """Called by Blender."""
    bpy.types.TOPBAR_MT_file_import.remove(_menu)
    bpy.utils.unregister_class(ImportSunderRun)
    bpy.utils.unregister_class(SunderPreferences)
