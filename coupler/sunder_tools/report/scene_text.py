"""What pictures need of the scene behind a run folder: names of shells and bodies, what is glass, masses of bodies.

Frames hold numbers only. The scene is read here as text, without protobuf, which may not be installed; it was checked
when it ran, and what is not understood is left out of a picture, no more.
"""
from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import BAD_INPUT, CommandError
from .appearance import Appearance, appearance_of
from .run_json import read_run

SCENE_COPY = "scene_as_run.textproto"  # in a run folder, with the settings of the run: shell/io/scene_copy.cpp

Message = dict[str, list[Any]]  # field: its values in order; a message, a number, a word or a string each
STANDARD_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2], proto/scene.proto
TOKEN = re.compile(r"""\s+|\#[^\n]*|("(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')|([{}<>\[\]:,;])|([^\s{}<>\[\]:,;#"']+)""")
PAIRS = {"{": "}", "<": ">"}


class SceneTextError(ValueError):
    """The text is no text-format message."""


def parse_text(text: str) -> Message:
    """The fields of a protobuf message in text format. Raises SceneTextError."""
    tokens: list[str] = []
    at = 0
    while at < len(text):
        found = TOKEN.match(text, at)
        if found is None:
            raise SceneTextError(f"unexpected {text[at]!r} at character {at}")
        tokens += [t for t in found.groups() if t is not None]
        at = found.end()
    return _fields(tokens, 0, None)[0]


def _fields(tokens: list[str], at: int, closing: str | None) -> tuple[Message, int]:
    message: Message = {}
    while at < len(tokens):
        name = tokens[at]
        at += 1
        if name == closing:
            return message, at
        if name in ",;":
            continue
        if not re.fullmatch(r"[A-Za-z_]\w*", name):
            raise SceneTextError(f"{name!r} where a field's name belongs")
        at += at < len(tokens) and tokens[at] == ":"
        if at < len(tokens) and tokens[at] == "[":
            at += 1
            while at < len(tokens) and tokens[at] != "]":
                if tokens[at] == ",":
                    at += 1
                    continue
                value, at = _value(tokens, at)
                message.setdefault(name, []).append(value)
            if at == len(tokens):
                raise SceneTextError("a ']' is missing at the end")
            at += 1
        else:
            value, at = _value(tokens, at)
            message.setdefault(name, []).append(value)
    if closing is not None:
        raise SceneTextError(f"a '{closing}' is missing at the end")
    return message, at


def _value(tokens: list[str], at: int) -> tuple[Any, int]:
    if at >= len(tokens):
        raise SceneTextError("a value is missing at the end")
    token = tokens[at]
    if token in PAIRS:
        return _fields(tokens, at + 1, PAIRS[token])
    if token[0] in "\"'":
        return token[1:-1], at + 1
    try:
        return float(token), at + 1
    except ValueError:
        return token, at + 1


def _one(message: Any, *path: str, default: Any = None) -> Any:
    """The last value of a nested field; `default` where it is not there or something else is."""
    for name in path:
        if not isinstance(message, dict) or not message.get(name):
            return default
        message = message[name][-1]
    return message


@dataclass(frozen=True)
class Words:
    """What the scene calls things; all empty where it was not found."""
    shells: tuple[str, ...] = ()          # by number
    materials: tuple[str, ...] = ()       # of each shell
    glass: tuple[bool, ...] = ()          # of each shell: its material is seen through
    breaks: tuple[bool, ...] = ()         # of each shell: its material has a strength
    surface_density: tuple[float, ...] = ()  # of each shell [kg/m^2]; NaN where not given
    thickness: tuple[float, ...] = ()     # of each shell [m]; NaN where not known
    bodies: tuple[str, ...] = ()          # of the scene, in order
    body_materials: tuple[str, ...] = ()  # of each body; '' where it names none
    probes: tuple[tuple[str, str], ...] = ()  # (probe, body) where a body moves under a probe
    masses: tuple[tuple[str, float], ...] = ()  # (body, [kg]) of spheres and boxes
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    appearances: tuple[tuple[str, Appearance], ...] = ()  # (material, how it looks)
    endless: bool = False                 # some body is a half space
    speeds: tuple[tuple[str, float], ...] = ()  # (body, [m/s] at the start) of bodies that move
    half_spaces: tuple[str, ...] = ()     # names of bodies

    def mass_under(self, probe: str) -> float | None:
        """[kg] of the body that the probe follows; None where that is not known."""
        return dict(self.masses).get(dict(self.probes).get(probe, ""))


def scene_words(folder: Path) -> Words:
    """Of the scene as it was run; empty where that is not known."""
    try:
        return _words_of_run(folder)
    except SceneTextError:
        return Words()


def known_words(folder: Path, command: str) -> Words:
    """The same for what must not guess names and thickness. Raises CommandError that says why they are not known."""
    try:
        return _words_of_run(folder)
    except SceneTextError as error:
        raise CommandError(f"{command}: {folder}: the scene of this run is not known: {error}; run it anew, or put the scene as "
                           f"it was run into the folder as {SCENE_COPY}", BAD_INPUT) from None


def _words_of_run(folder: Path) -> Words:
    """Reads the copy of the scene in a run folder, of a run without one the file that command.json names. Raises
    SceneTextError where there is neither, or the file has changed since."""
    copy = folder / SCENE_COPY
    path, settings = (copy, []) if copy.is_file() else _scene_file(folder)
    try:
        scene = parse_text(path.read_text())
        words = words_of(scene, settings)
    except (OSError, ValueError) as error:
        raise SceneTextError(f"{path} cannot be read ({error})") from None
    run = read_run(folder)
    counts = run.get("counts")
    patches = counts.get("patches") if isinstance(counts, dict) else None
    names = run.get("shells")
    if isinstance(names, list) and len(names) == patches:
        words = _with_own(_of_parts(words, [str(name) for name in names]), scene, run)
    if patches not in (None, len(words.shells)):
        raise SceneTextError(f"{path} has {len(words.shells)} shells, the run {patches}")
    return words


def _of_parts(words: Words, names: list[str]) -> Words:
    """The same for the shells of a run: a mesh or a CAD file becomes several, NAME.1, NAME.2, …, and each of these may
    again. `words` as they are where a name is of no shell of the scene."""
    index = []
    for name in names:
        whole = name
        while whole not in words.shells and "." in whole:
            whole = whole.rpartition(".")[0]
        if whole not in words.shells:
            return words
        index.append(words.shells.index(whole))

    def of(field: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(field[k] for k in index)

    return replace(words, shells=tuple(names), materials=of(words.materials), glass=of(words.glass), breaks=of(words.breaks),
                   surface_density=of(words.surface_density), thickness=of(words.thickness))


def _with_own(words: Words, scene: Message, run: dict[str, Any]) -> Words:
    """The same with the materials and thicknesses that shells of the run have: parts of a mesh have their own."""
    of, thick = run.get("shell_materials"), run.get("shell_thickness_m")
    if not isinstance(of, list) or not isinstance(thick, list) or not len(of) == len(thick) == len(words.shells):
        return words
    materials = {_one(m, "name"): m for m in scene.get("materials", [])}
    if any(name not in materials for name in of):
        return words
    thickness = [float(t) for t in thick]
    looks = _appearances(scene)
    return replace(words, materials=tuple(of), glass=tuple(looks[m].kind == "glass" for m in of),
                   breaks=tuple(_one(materials[m], "strength") is not None for m in of), thickness=tuple(thickness),
                   surface_density=tuple(_number(_one(materials[m], "density")) * t for m, t in zip(of, thickness)))


def _scene_file(folder: Path) -> tuple[Path, list[str]]:
    """The file that command.json names, and the settings, for a run without a copy. Raises SceneTextError."""
    told = folder / "command.json"
    try:
        kept = json.loads(told.read_text())
        path, settings = Path(kept["scene"]), [str(s) for s in kept["settings"]]
    except (OSError, ValueError, KeyError, TypeError):
        raise SceneTextError(f"there is no {SCENE_COPY}, and no command.json that names the scene") from None
    try:
        changed = path.stat().st_mtime > told.stat().st_mtime
    except OSError as error:
        raise SceneTextError(f"there is no {SCENE_COPY}, and {path}: {error.strerror}") from None
    if changed:
        raise SceneTextError(f"there is no {SCENE_COPY}, and {path} has changed since")
    return path, settings


def words_of(scene: Message, settings: list[str]) -> Words:
    """`settings`: --set of the run; one of a body or material may change masses, which are then not given."""
    materials, looks = {_one(m, "name"): m for m in scene.get("materials", [])}, _appearances(scene)
    shells = [s for s in scene.get("shells", []) if isinstance(s, dict)]
    of = [str(_one(s, "material", default="")) for s in shells]
    thickness = _thickness(shells, settings)
    density = [_number(_one(materials.get(m), "density")) * t for m, t in zip(of, thickness)]
    bodies = [b for b in scene.get("bodies", []) if isinstance(b, dict)]
    known = not any(re.match(r"(materials|bodies\[[^\]]*\]\.(material|sphere|box|mesh))", s) for s in settings)
    masses = [(str(_one(b, "name")), mass) for b in bodies if known and (mass := _mass(b, materials)) is not None]
    probes = [(str(_one(p, "name")), str(_one(p, "body"))) for o in scene.get("output", []) if isinstance(o, dict)
              for p in o.get("probes", []) if _one(p, "body")]
    speeds = [(str(_one(b, "name")), speed) for b in bodies if (speed := _speed(b)) > 0.0
              and not any(s.startswith("bodies") for s in settings)]
    pull = _one(scene, "gravity")
    x, y, z = STANDARD_GRAVITY if pull is None else (_number(_one(pull, a, default=0.0)) for a in "xyz")
    if any(s.startswith("gravity") for s in settings):
        masses = []  # the impulse of weight would be a wrong one
    return Words(tuple(str(_one(s, "name", default="")) for s in shells), tuple(of),
                 tuple(m in looks and looks[m].kind == "glass" for m in of),
                 tuple(_one(materials.get(m), "strength") is not None for m in of), tuple(density), tuple(thickness),
                 tuple(str(_one(b, "name", default="")) for b in bodies),
                 tuple(str(_one(b, "material", default="")) for b in bodies), tuple(probes), tuple(masses), (x, y, z),
                 tuple(looks.items()), any("half_space" in b for b in bodies), tuple(speeds),
                 tuple(str(_one(b, "name", default="")) for b in bodies if "half_space" in b))


def _appearances(scene: Message) -> dict[str, Appearance]:
    """Of each material."""
    return {str(_one(m, "name")): appearance_of(str(_one(m, "name")), str(_one(m, "preset", default="")), _number(_one(m, "density")),
                                                _number(_one(m, "youngs_modulus")), _one(m, "yield_stress") is not None, number)
            for number, m in enumerate(scene.get("materials", []))}


def _number(value: Any) -> float:
    return value if isinstance(value, float) else math.nan


def _thickness(shells: list[Message], settings: list[str]) -> list[float]:
    """Of each shell [m], as settings left it."""
    found = [_number(_one(s, "thickness_m")) for s in shells]
    names = [str(_one(s, "name", default="")) for s in shells]
    for setting in settings:
        path, _, value = setting.partition("=")
        told = re.fullmatch(r"shells\[([^\]]*)\]\.thickness_m", path.strip())
        if told is None:
            if re.match(r"shells(\[[^\]]*\])?\s*(\.thickness_m)?$", path.strip()):
                found = [math.nan] * len(found)  # a whole shell was replaced
            continue
        at = names.index(told[1]) if told[1] in names else int(told[1]) if told[1].isdigit() else -1
        if 0 <= at < len(found):
            try:
                found[at] = float(value)
            except ValueError:
                found[at] = math.nan
    return found


def _speed(body: Message) -> float:
    """[m/s] at the start."""
    launched = _number(_one(body, "launch", "speed", default=0.0))
    return launched if launched > 0.0 else math.hypot(*(_number(_one(body, "twist", "linear", a, default=0.0)) for a in "xyz"))


def _mass(body: Message, materials: dict[Any, Any]) -> float | None:
    density = _number(_one(materials.get(_one(body, "material")), "density"))
    radius = _number(_one(body, "sphere", "radius_m"))
    size = [_number(_one(body, "box", "size_m", a)) for a in "xyz"]
    mass = density * (math.prod(size) if "box" in body else 4.0 / 3.0 * math.pi * radius ** 3)
    return mass if math.isfinite(mass) and mass > 0.0 and _one(body, "is_static") != "true" else None
