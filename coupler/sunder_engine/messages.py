"""The messages of proto/exchange.proto as Python classes, made from the schema itself; there is no generated file."""
from __future__ import annotations

import os
import subprocess
import warnings
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

PROTO_VARIABLE = "SUNDER_PROTO"  # names another folder of the .proto files, where this package was copied alone


@lru_cache(maxsize=None)
def exchange() -> SimpleNamespace:
    """The classes by name. Raises RuntimeError where protoc is missing or refuses the schema."""
    folder = Path(os.environ.get(PROTO_VARIABLE) or Path(__file__).resolve().parents[2] / "proto")
    try:
        done = subprocess.run(["protoc", f"-I{folder}", "--include_imports", "--descriptor_set_out=/dev/stdout",
                               str(folder / "exchange.proto")], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, check=False)
    except FileNotFoundError:
        raise RuntimeError("protoc is not installed (Debian: protobuf-compiler)") from None
    if done.returncode != 0:
        raise RuntimeError(f"{folder}: {done.stderr.decode(errors='replace').strip()}; {PROTO_VARIABLE} names the "
                           "folder of exchange.proto")
    pool = descriptor_pool.DescriptorPool()  # a separate pool: an engine may have its own messages in the default one
    for file in descriptor_pb2.FileDescriptorSet.FromString(done.stdout).file:
        pool.Add(file)
    factory = message_factory.MessageFactory(pool)
    found = pool.FindFileByName("exchange.proto").message_types_by_name
    return SimpleNamespace(**{name: factory.GetPrototype(kind) for name, kind in found.items()})


def parsed(name: str, data: bytes) -> Any:
    """The message of this kind in `data`. Raises ValueError where there is none, or something after it."""
    message = getattr(exchange(), name)()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # protobuf warns of an end in the middle, and takes what was before
            read = message.MergeFromString(data)
    except Exception:  # noqa: BLE001: of the library's own kinds
        read = None
    if read != len(data):
        raise ValueError(f"bytes that are no {name}")
    return message
