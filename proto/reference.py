#!/usr/bin/env python3
"""Writes proto/README.md from the comments of the .proto files.

    /usr/bin/python3 -B proto/reference.py

A comment of a field begins with its unit in brackets, where it has one, and says what the field is. The words Default:,
Excludes: and Needs: begin parts of their own. A field without a comment is an error.
"""
from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

from google.protobuf import descriptor_pb2 as pb

HERE = Path(__file__).resolve().parent
README = HERE / "README.md"
SCENE = ("scene", "shell", "boundary", "patch", "bodies", "geometry")  # in the order of the page
SESSION = ("exchange",)
PARTS = ("Default", "Excludes", "Needs")
PACKAGE = ".sunder.proto."

HEAD = """\
# proto: every field of a scene

<!-- Made by proto/reference.py from the comments of the .proto files; change those and run it again. -->
The schemas are the language of people (scene files) and of both processes (the session). To learn by example, read the
[cookbook](../scenes/README.md).

- **Units** are SI, z is up, angles are in degrees, quaternions are w x y z. The column *unit* has `-` for a pure number
  and is empty for names, switches and messages.
- **Default** is what holds where the field is absent. *required* fields have none: the check names the missing one.
- **Excludes** lists fields or values that may not be given together with this one. **Needs** lists what must be given
  too. A scene that breaks a rule is refused before it runs, with file, line, field, value and remedy.
- `--set` names a field by its path: `--set 'shells[pane].thickness_m=0.003'`, `--set 'bodies[ball].twist.linear.z=-10'`.

A new field takes these steps. There is no field that nothing reads.

1. **Field and documentation**: the `.proto` file, with a comment `[unit] text.`, then `Default: …`, `Excludes: …`, `Needs: …`
   (the head of `scene.proto` has the rules). This page is made from it by `/usr/bin/python3 -B proto/reference.py`.
   A comment repeats the default of the struct; keep both the same.
2. **Default**: a member with that value in the plain struct that the field is read into: `RunSetup` or `CouplingRules`
   (`shell/io/build.h`), `ShellSetup` (`shell/io/shell_setup.h`), `SoftSetup` (`shell/soft/soft_bodies.h`), or the rules that it holds. Those of a material are members
   of `ShellMaterial` (`shell/solver/model.h`), which `build_shell.cpp` fills. Defaults that depend on
   other fields, and some constant ones, stand in the reader.
3. **Reader**: `shell/io/build.cpp` for the run, bodies and output, `build_shell.cpp` and `shell_setup.cpp` for shells and
   fracture, `build_soft.cpp` for soft bodies,
   `build_driven.cpp` for motions and shapes of bodies, `build_seams.cpp` for seams, `build_mass_scaling.cpp` for added mass,
   `probes.cpp` for probes, `cuts.cpp`, `trims.cpp`, `strength_factors.cpp`, `thickness_factors.cpp` and `space_places.cpp`
   for what is drawn on shells, `ring_sectors.cpp` for rings, `cad_file.cpp` and `mesh_parts.cpp` for files.
4. **Check**: of the value alone in `coupler/scene/validate*.cpp`; against the model (spacing, other shells, supports) in its
   reader, by `scene.check`. A new source in
   `coupler/scene/` is listed in `coupler/CMakeLists.txt`. Fields of the session are checked in `coupler/link/messages.cpp`.
   A value of which the unit decides the size joins `kDecided` (`coupler/scene/unit_warnings.cpp`).
5. **Test**: a bad value is refused, in `tests/coupler/scene/`.
"""
SESSION_HEAD = """\
## The session

These messages go between the two processes (`exchange.proto`). [rigid/README.md](../rigid/README.md) says what an engine
does with each; [coupler/link/README.md](../coupler/link/README.md) says in which order they come. *Needs* is the capability
that an engine must declare.
"""


class NoComment(Exception):
    """A field, value or message that says nothing."""


@dataclass
class Comment:
    """What a comment says of a field."""
    unit: str = ""
    meaning: str = ""
    parts: dict[str, str] = field(default_factory=dict)


def parse(text: str) -> Comment:
    """The unit, meaning and parts of a comment as protoc gives it."""
    words = " ".join(line.strip() for line in text.strip().splitlines())
    unit = re.match(r"\[([^\]]+)\]\s*", words)
    rest = words[unit.end():] if unit else words
    pieces = re.split(rf"(?:^|\s)({'|'.join(PARTS)}): ", rest)
    out = Comment(unit[1] if unit else "", pieces[0].strip())
    for name, value in zip(pieces[1::2], pieces[2::2]):
        out.parts[name] = value.strip()
    return out


def _comments(file: pb.FileDescriptorProto) -> dict[tuple[int, ...], str]:
    """Comments by path in the descriptor."""
    return {tuple(place.path): place.leading_comments + place.trailing_comments
            for place in file.source_code_info.location if place.leading_comments or place.trailing_comments}


def descriptors(names: tuple[str, ...]) -> list[pb.FileDescriptorProto]:
    """The named schemas with their comments. Raises CalledProcessError where protoc refuses one."""
    done = subprocess.run(
        ["protoc", f"-I{HERE}", "--include_source_info", "--descriptor_set_out=/dev/stdout",
         *(str(HERE / f"{name}.proto") for name in names)], stdout=subprocess.PIPE, check=True)
    files = {file.name: file for file in pb.FileDescriptorSet.FromString(done.stdout).file}
    return [files[f"{name}.proto"] for name in names]


class Page:
    """Tables of the messages of some schemas."""

    def __init__(self, files: list[pb.FileDescriptorProto], session: bool) -> None:
        self.session = session
        self.lines: list[str] = []
        for file in files:
            comments = _comments(file)
            for index, message in enumerate(file.message_type):
                self._message(message, message.name, (4, index), comments)

    def _said(self, comments: dict[tuple[int, ...], str], path: tuple[int, ...], what: str) -> Comment:
        comment = parse(comments.get(path, ""))
        if not comment.meaning:
            raise NoComment(f"{what} has no comment")
        return comment

    def _type(self, f: pb.FieldDescriptorProto) -> str:
        if f.type in (f.TYPE_MESSAGE, f.TYPE_ENUM):
            name = f.type_name.removeprefix(PACKAGE)
            text = f"[{name}](#{name.replace('.', '').lower()})" if f.type == f.TYPE_MESSAGE else f"enum {name}"
        else:
            text = pb.FieldDescriptorProto.Type.Name(f.type).removeprefix("TYPE_").lower()
        return f"list of {text}" if f.label == f.LABEL_REPEATED else text

    def _message(self, m: pb.DescriptorProto, name: str, path: tuple[int, ...],
                 comments: dict[tuple[int, ...], str]) -> None:
        about = self._said(comments, path, f"message {name}")
        self.lines += ["", f"### {name}", "", about.meaning]
        if m.field:
            columns = ["field", "type", "unit"]
            columns += ["meaning", "needs"] if self.session else ["default", "meaning", "excludes", "needs"]
            self.lines += ["", _row(columns), _row(["---"] * len(columns))]
        for index, f in enumerate(m.field):
            comment = self._said(comments, (*path, 2, index), f"field {name}.{f.name}")
            part = comment.parts
            cells = [f"`{f.name}`", self._type(f), comment.unit]
            if self.session:
                if set(part) - {"Needs"}:
                    raise NoComment(f"field {name}.{f.name}: only Needs: is for the session")
                cells += [comment.meaning, part.get("Needs", "")]
            else:
                if "Default" not in part and (f.proto3_optional or not f.HasField("oneof_index")):
                    raise NoComment(f"field {name}.{f.name} does not say its Default:")
                cells += [part.get("Default", ""), comment.meaning, part.get("Excludes", ""), part.get("Needs", "")]
            self.lines.append(_row(cells))
        for k, enum in enumerate(m.enum_type):
            self.lines += ["", f"Values of `{name}.{enum.name}`:", ""]
            for index, value in enumerate(enum.value):
                said = self._said(comments, (*path, 4, k, 2, index), f"value {name}.{enum.name}.{value.name}")
                self.lines.append(f"- `{value.name}`: {said.meaning}")
        for index, nested in enumerate(m.nested_type):
            self._message(nested, f"{name}.{nested.name}", (*path, 3, index), comments)


def _row(cells: list[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def page() -> str:
    """The text of README.md. Raises NoComment where something has no comment."""
    scene = Page(descriptors(SCENE), session=False)
    session = Page(descriptors(SESSION), session=True)
    return "\n".join([HEAD + "\n## The scene", *scene.lines, "", SESSION_HEAD.rstrip(), *session.lines]) + "\n"


def main() -> int:
    try:
        README.write_text(page())
    except NoComment as error:
        print(f"reference: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
