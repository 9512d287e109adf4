"""The messages of proto/scene.proto as Python classes, made from the schema itself; there is no generated file."""
from __future__ import annotations

import subprocess
from functools import lru_cache
from pathlib import Path
from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

from sunder_tools.errors import CommandError
from sunder_tools.places import REPOSITORY

PROTO = REPOSITORY / "proto"


@lru_cache(maxsize=None)
def scene_class() -> Any:
    """Returns the class of message Scene. Raises CommandError where protoc is missing or refuses the schema."""
    try:
        done = subprocess.run(["protoc", f"-I{PROTO}", "--include_imports", "--descriptor_set_out=/dev/stdout",
                               str(PROTO / "scene.proto")], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, check=False)
    except FileNotFoundError:
        raise CommandError("protoc is not installed; 'coupler/sunder build' installs it (Debian: "
                           "protobuf-compiler)") from None
    if done.returncode != 0:
        raise CommandError(f"{PROTO / 'scene.proto'}: {done.stderr.decode(errors='replace').strip()}")
    pool = descriptor_pool.DescriptorPool()  # a separate pool: a script may have its own messages in the default one
    for file in descriptor_pb2.FileDescriptorSet.FromString(done.stdout).file:
        pool.Add(file)
    descriptor = pool.FindMessageTypeByName("sunder.proto.Scene")
    if hasattr(message_factory, "GetMessageClass"):  # from protobuf 4.22 on
        return message_factory.GetMessageClass(descriptor)
    return message_factory.MessageFactory(pool).GetPrototype(descriptor)


def assets_of(message: Any) -> list[str]:
    """Lists every file that a scene names, in order: string fields called `path`."""
    found: list[str] = []
    for field, value in message.ListFields():
        if field.type == field.TYPE_MESSAGE:
            for part in value if field.label == field.LABEL_REPEATED else (value,):
                found += assets_of(part)
        elif field.name == "path":
            found.append(str(value))
    return found


def relative_asset(name: str, where: Path) -> Path:
    """Returns the file `name` beside a scene in `where`. Raises CommandError where it does not exist or is not below
    that folder."""
    folder = where.resolve()
    path = (folder / name).resolve()
    if not path.is_relative_to(folder) or not path.is_file():
        raise CommandError(f"{where}: the scene names the file '{name}', which is not there or not below that folder")
    return path


def with_preset(material: Any) -> Any:
    """Returns a material with the values that its preset fills in."""
    filled = type(material)()
    preset = type(material).Preset.DESCRIPTOR.values_by_number.get(material.preset)
    if preset is not None:
        # The schema has a pool of its own, which keeps the one option of a preset as bytes: tag, length, material.
        option = preset.GetOptions().SerializeToString()
        for _ in range(2):
            if option:
                option = option[next(k for k, byte in enumerate(option) if byte < 128) + 1:]
        filled.ParseFromString(option)
    filled.MergeFrom(material)
    return filled
