"""A scene in memory: read from a file, changed by field or by path, written, checked and run."""
from __future__ import annotations

import hashlib
import math
import re
import shutil
import subprocess
import tempfile
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Mapping, Sequence, SupportsFloat, Union

from google.protobuf import text_format

from sunder_tools.errors import DONE, CommandError
from sunder_tools.launch.needs import built_for
from sunder_tools.launch.fidelity import PRESETS, taken
from sunder_tools.launch.run import Job, run_scene
from sunder_tools.places import REPOSITORY
from sunder_tools.report.run_json import read_run
from sunder_tools.report.scene_text import SCENE_COPY, parse_text
from sunder_tools.words import did_you_mean, nearest

from .results import RunArrays
from .schema import assets_of, relative_asset, scene_class, with_preset

SCENES = REPOSITORY / "scenes"  # scenes of the project
SCENE_FILE = "scene.textproto"

Value = Union[float, int, bool, str]
Given = Union[Value, SupportsFloat]  # numpy's numbers too


class BadSetting(CommandError, ValueError):
    """A path that does not exist, or a value that its field cannot hold."""


class Scene:
    """A scene; `message` is the protobuf message of proto/scene.proto.

    Fields are set in the message, whose types are checked by protobuf (`scene.message.end_time_s = 2e-4`), or by a path
    as `sunder run --set` takes it (`scene["bodies[ball].twist.linear.z"] = -20`). Setting a path refuses a wrong type, a
    number that is not finite, and an unknown enumerator at once. What makes sense as a whole is checked before a run, by
    the shell process, as for every scene; the message names the scene and the field.
    """

    def __init__(self, message: Any, folder: Path) -> None:
        """Makes a scene. `folder` holds the files that the scene names."""
        self.message = message
        self.folder = Path(folder)

    @staticmethod
    def load(path: Path | str) -> "Scene":
        """Reads a scene file. Raises CommandError with file, line and column where it is not a scene."""
        path = Path(path)
        try:
            text = path.read_text()
        except (OSError, UnicodeDecodeError) as error:
            raise CommandError(f"{path}: cannot be read: {error}") from None
        message = scene_class()()
        try:
            text_format.Parse(text, message)
        except text_format.ParseError as error:
            raise CommandError(f"{path}:{error}") from None
        return Scene(message, path.parent)

    def copy(self) -> "Scene":
        """Returns a copy that can be changed independently."""
        message = type(self.message)()
        message.CopyFrom(self.message)
        return Scene(message, self.folder)

    def find(self, path: str) -> Any:
        """Returns the message at a path: `scene.find("shells[pane].plate").elements_x = 40`. Raises BadSetting."""
        at = self.message
        for step in path.split("."):
            at = _enter(at, step, path)
        return at

    def __getitem__(self, path: str) -> Value:
        """Returns the value of a single field, where it is absent that of the material's preset or the schema's default.
        Raises BadSetting."""
        at, field = self._field(path)
        if at.DESCRIPTOR.name == "Material":
            at = with_preset(at)
        value: Value = getattr(at, field.name)
        return field.enum_type.values_by_number[value].name if field.enum_type else value

    def __setitem__(self, path: str, value: Given) -> None:
        """Sets a single field and creates absent messages of its path. Raises BadSetting and then leaves the scene
        unchanged."""
        at, field = self._field(path)
        text = _text(value, field)
        scratch = type(at)()
        try:
            if field.type == field.TYPE_STRING:
                setattr(scratch, field.name, text)
            else:
                text_format.Parse(f"{field.name}: {text}", scratch)
        except (text_format.ParseError, ValueError, TypeError):
            scratch = None
        one_word = field.type == field.TYPE_STRING or len(text.split()) == 1
        known = scratch is None or _is_known(getattr(scratch, field.name), field)
        if scratch is None or not known or not one_word or any(f.name != field.name for f, _ in scratch.ListFields()):
            raise BadSetting(f"{path}={text}: '{text}' is no {_kind(field)}")
        setattr(at, field.name, getattr(scratch, field.name))

    def set(self, values: Mapping[str, Given]) -> "Scene":
        """Sets several paths; returns the scene itself. Raises BadSetting."""
        for path, value in values.items():
            self[path] = value
        return self

    def fidelity(self, name: str) -> "Scene":
        """Applies a preset as `sunder run --fidelity` does; returns the scene itself. Set own values afterwards.
        Raises BadSetting for an unknown preset."""
        if name not in PRESETS:
            raise BadSetting(f"fidelity '{name}': there are {', '.join(PRESETS)}")

        def accepted(settings: Sequence[str]) -> bool:
            try:
                self.copy().set(_pairs(settings)).check()
            except CommandError:
                return False
            return True

        return self.set(_pairs(taken(name, parse_text(self.text()), (), accepted).settings))

    def _field(self, path: str) -> tuple[Any, Any]:
        """Returns the message that holds the last field of `path`, and that field's descriptor."""
        *steps, last = path.split(".")
        at = self.message  # reading an absent message does not create it, so a refused path changes nothing
        for step in steps:
            at = _enter(at, step, path)
        field = at.DESCRIPTOR.fields_by_name.get(last)
        if field is None:
            raise _unknown(last, at, path)
        if field.label == field.LABEL_REPEATED or field.type == field.TYPE_MESSAGE:
            raise BadSetting(f"{path}: '{last}' is not a single value; set it in the message, scene.find(...)")
        return at, field

    def text(self) -> str:
        """Returns the scene as text; equal scenes give equal texts."""
        return str(text_format.MessageToString(self.message, as_utf8=True))

    def identity(self) -> str:
        """Returns the SHA-256 of the scene and the files that it names; equal hashes mean equal runs."""
        digest = hashlib.sha256(self.text().encode())
        for name in assets_of(self.message):
            digest.update(name.encode() + b"\0")
            digest.update(hashlib.sha256(relative_asset(name, self.folder).read_bytes()).digest())
        return digest.hexdigest()

    def save(self, folder: Path | str, name: str = SCENE_FILE) -> Path:
        """Writes the scene into a folder, with the files that it names beside it; returns its path.

        Raises CommandError where such a file is missing, OSError where the folder cannot be written.
        """
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for asset in assets_of(self.message):
            source, target = relative_asset(asset, self.folder), folder / asset
            if source != target.resolve():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, target)
        path = folder / name
        path.write_text(self.text())
        return path

    def check(self) -> str:
        """Returns the report of `sunder check`: sizes, stable step, minutes. Raises CommandError where the scene is
        refused."""
        with tempfile.TemporaryDirectory(prefix="check-sunder-") as folder:
            path = self.save(folder)
            done = subprocess.run([str(built_for(path).shell), "--scene", str(path), "--check"], text=True,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
            if done.returncode != DONE:
                raise CommandError(self._told(done.stderr, folder).strip() or
                                   f"the scene is refused with status {done.returncode}")
            return done.stdout

    def run(self, out: Path | str, engine: str = "bullet", threads: int | None = None, quiet: bool = True) -> "Results":
        """Runs the scene as `sunder run --out OUT` does, without pictures; an earlier run in the folder is replaced.

        The scene is kept in the folder. Only in the main thread of a program, as Ctrl-C is listened for. Raises
        CommandError with the status of `sunder run` where the run fails.
        """
        out = Path(out)
        with tempfile.TemporaryDirectory(prefix="scene-sunder-") as folder:
            job = Job(self.save(folder), engine, threads=str(threads) if threads else None)
            try:
                status = run_scene(job, out, quiet)
            except CommandError as error:
                raise CommandError(self._told(str(error), folder), error.status) from None
        if (out / "run.json").is_file():  # the folder alone is then enough to resume or repeat the run
            replace(job, scene=self.save(out)).write(out)
        if status != DONE:
            told = read_run(out).get("error") or {}
            raise CommandError(f"{out}: {self._told(str(told.get('message') or f'ended with status {status}'), folder)}", status)
        return Results(out)

    def _told(self, text: str, folder: str) -> str:
        """Returns a message of the programs with this scene in place of its file, line and column in a temporary folder,
        which no longer exists. The field stays; it is a path for `scene[...]`."""
        name = f"scene '{self.message.name}'" if self.message.name else "the scene"
        for place in (str(Path(folder).resolve()), folder):
            text = re.sub(re.escape(f"{place}/{SCENE_FILE}") + r"(:\d+:\d+)?", lambda _: name, text).replace(f"{place}/", "")
        return text


class Results(RunArrays):
    """A run folder, with the scene of the run."""

    @cached_property
    def scene(self) -> Scene:
        """Returns the scene of the run. Raises CommandError where the folder has none."""
        for place in (self.folder / SCENE_FILE, self.folder.parent / SCENE_FILE):
            if place.is_file():
                return Scene.load(place)
        job = Job.read(self.folder)
        if (self.folder / SCENE_COPY).is_file():  # the file that was run may have changed since
            return Scene(Scene.load(self.folder / SCENE_COPY).message, job.scene.parent)
        return Scene.load(job.scene).set(_pairs(job.settings))


def _pairs(settings: Sequence[str]) -> dict[str, Value]:
    """PATH=VALUE as `Scene.set` takes it."""
    return {path: value for path, value in (setting.split("=", 1) for setting in settings)}


def _enter(at: Any, step: str, path: str) -> Any:
    """Returns the message at one step of a path: a field, or `field[name or number]`."""
    name, bracket, element = step.partition("[")
    element = element[:-1] if bracket and element.endswith("]") else ""
    field = at.DESCRIPTOR.fields_by_name.get(name)
    if field is None:
        raise _unknown(name, at, path)
    if field.type != field.TYPE_MESSAGE:
        raise BadSetting(f"{path}: '{name}' has no fields of its own")
    value = getattr(at, name)
    if field.label != field.LABEL_REPEATED:
        if bracket:
            raise BadSetting(f"{path}: there is but one '{name}'; leave [{element}] out")
        return value
    names = [str(getattr(part, "name", "")) for part in value]
    for number, part in enumerate(value):
        if element and element in (names[number], str(number)):
            return part
    if not bracket:
        following = path.partition(f"{name}.")[2].split(".")[0]
        which = following if following in names or following.isdigit() and int(following) < len(names) else "NAME"
        raise BadSetting(f"{path}: '{name}' is a list; write {name}[{which}]; there are: {', '.join(names) or 'none'}")
    raise BadSetting(f"{path}: {name}[{element}] is not there; {_near(element, names, 'there are')}")


def _unknown(name: str, at: Any, path: str) -> BadSetting:
    """The error of a field that a message does not have."""
    names = [field.name for field in at.DESCRIPTOR.fields]
    return BadSetting(f"{path}: '{name}' is no field of {at.DESCRIPTOR.name}; {_near(name, names, 'it has')}")


def _near(word: str, names: list[str], all_of_them: str) -> str:
    """'did you mean 'thickness_m'?', or all names where none is like it."""
    return did_you_mean(word, names) if nearest(word, names) else f"{all_of_them}: {', '.join(names) or 'none'}"


def _text(value: Given, field: Any) -> str:
    """Returns a value in the text format; numpy's numbers count as Python's."""
    value = value.item() if hasattr(value, "item") else value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and value.is_integer() and field.cpp_type in (field.CPPTYPE_INT32, field.CPPTYPE_INT64):
        return str(int(value))  # 40.0 elements, as arithmetic gives them
    return repr(value) if isinstance(value, (int, float)) else str(value)


def _is_known(value: Any, field: Any) -> bool:
    """Tests a number for being finite, or one of the enumerators; text format takes any."""
    if field.enum_type:
        return value in field.enum_type.values_by_number
    return not isinstance(value, float) or math.isfinite(value)


def _kind(field: Any) -> str:
    if field.enum_type:
        return f"{field.enum_type.name}; it may be {', '.join(v.name for v in field.enum_type.values)}"
    return {field.CPPTYPE_DOUBLE: "finite number", field.CPPTYPE_BOOL: "true or false", field.CPPTYPE_STRING: "text"}.get(
        field.cpp_type, "whole number")
