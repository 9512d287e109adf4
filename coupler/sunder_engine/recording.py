"""Recorded sessions: the file `session.rec` of a run that was made with --record, as coupler/link/recording.h writes it.

The file is a line and then records: a character ('>' request, '<' reply, '!' a last message without reply), the length of
the message in eight bytes (little-endian), and the message.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Iterator

from .messages import parsed
from .session import SHAPES

FIRST_LINE = b"sunder recording 1\n"
REQUEST, REPLY, TOLD = b">", b"<", b"!"
LENGTH_BYTES = 8
MOST_BYTES = 256 << 20  # of a message
TURNS = {"hello": (1,), "load": (2,), "restore": (3,)}  # the numbers that these requests must have


class BadRecording(Exception):
    """A file that is no whole recording of a session: which, at which byte, and what to do."""

    def __init__(self, path: Path, at: int, what: str) -> None:
        super().__init__(f"{path}: byte {at}: {what}; take session.rec of a run that was made with 'coupler/sunder run SCENE "
                         "--record'")


@dataclass(frozen=True)
class Exchange:
    """A request of the shell, and the engine's reply; None where the recording ends before it."""
    number: int  # from 1
    at: int      # byte of the file at which the request's record begins
    kind: str    # hello, load, window, ...
    request: Any
    reply: Any


def exchanges(path: Path) -> Iterator[Exchange]:
    """Yields what was said, in its order. Raises BadRecording, OSError."""
    with path.open("rb") as file:
        line = file.read(len(FIRST_LINE))
        if line != FIRST_LINE:
            raise BadRecording(path, 0, f"the file begins with {line!r}, and a recording with {FIRST_LINE!r}")
        number, ended, told = 0, False, False
        while (record := _record(path, file)) is not None:
            at, mark, content = record
            if told or (ended and mark != TOLD):
                raise BadRecording(path, at, "a record after the end of the session")
            if mark == TOLD:
                told = True
                continue
            if mark == REPLY:
                raise BadRecording(path, at, "a reply without a request")
            number += 1
            request = _message(path, at, content, "Request")
            kind = _kind_of_request(path, at, number, request)
            answer = _record(path, file)
            reply = None
            if answer is not None:
                if answer[1] == REQUEST:
                    raise BadRecording(path, answer[0], "a request before the reply of the last one")
                if answer[1] == REPLY:
                    reply = _message(path, answer[0], answer[2], "Reply")
                    if reply.WhichOneof("kind") not in (kind, "error"):
                        raise BadRecording(path, answer[0], f"a reply to something else than the {kind} that was asked")
            told = answer is not None and answer[1] == TOLD
            ended = reply is None or kind == "bye" or reply.WhichOneof("kind") == "error"
            yield Exchange(number, at, kind, request, reply)
        if number < 2:
            raise BadRecording(path, file.tell(), "the session ends before Load")


def _record(path: Path, file: BinaryIO) -> tuple[int, bytes, bytes] | None:
    """The next record with the byte at which it begins; None at the end of the file."""
    at = file.tell()
    head = file.read(1 + LENGTH_BYTES)
    if not head:
        return None
    mark, size = head[:1], int.from_bytes(head[1:], "little")
    if mark not in (REQUEST, REPLY, TOLD):
        raise BadRecording(path, at, f"{mark!r} begins no record")
    if len(head) < 1 + LENGTH_BYTES:
        raise BadRecording(path, at, "the file ends within this record, as that of a run that was killed")
    if size > MOST_BYTES:
        raise BadRecording(path, at, f"a record of {size} bytes; {MOST_BYTES} at most")
    content = file.read(size)
    if len(content) < size:
        raise BadRecording(path, at, "the file ends within this record, as that of a run that was killed")
    return at, mark, content


def _message(path: Path, at: int, content: bytes, name: str) -> Any:
    try:
        return parsed(name, content)
    except ValueError:
        raise BadRecording(path, at, f"the record holds no {name}") from None


def _kind_of_request(path: Path, at: int, number: int, request: Any) -> str:
    kind = request.WhichOneof("kind")
    if kind is None or kind == "error" or request.sequence != number:
        raise BadRecording(path, at, f"request {number} is missing, or is none")
    due = {1: "hello", 2: "load"}.get(number, kind)
    if kind != due or number not in TURNS.get(kind, (number,)):
        raise BadRecording(path, at, f"request {number} is {kind}, which is out of turn")
    return str(kind)


class Summary:
    """What the whole of a recording tells before it is played. Raises BadRecording, OSError."""

    def __init__(self, path: Path) -> None:
        self.engine = ""                 # name and version of the engine that was recorded
        self.windows = 0
        self.restores = False            # the session goes on from a checkpoint, with caches of that engine
        self.needs: dict[str, int] = {}  # capabilities without which it cannot be played, and the first request that needs each
        self.fastest = 0.0               # [m/s] the largest speed of a body, or of its surface by its spin
        self.bodies: dict[int, Body] = {}
        for one in exchanges(path):
            self._look(path, one)

    def _look(self, path: Path, one: Exchange) -> None:
        said, answer = getattr(one.request, one.kind), None
        if one.reply is not None and one.reply.WhichOneof("kind") != "error":
            answer = getattr(one.reply, one.kind)
        if one.kind == "hello":
            self.engine = f"{answer.engine_name} {answer.engine_version}".strip() if answer is not None else ""
        self.windows += one.kind == "window"
        self.restores |= one.kind == "restore"
        for body in (*(said.bodies if one.kind in ("load", "add_bodies") else ()), *(said.births if one.kind == "window" else ())):
            if body.WhichOneof("shape") is None or body.id in self.bodies:
                raise BadRecording(path, one.at, f"body {body.id} comes twice, or has no shape")
            held = self.bodies[body.id] = Body.of(body)
            if not (math.isfinite(held.mass) and math.isfinite(held.size)):
                raise BadRecording(path, one.at, f"body {body.id} has a mass or a size that is not finite")
            self._need("compound" if len(body.convex.parts) > 1 else SHAPES[body.WhichOneof("shape")], one)
        for word, needed in (("joints", one.kind == "load" and len(said.joints) > 0),
                             ("save_restore", one.kind in ("add_bodies", "restore") or (one.kind == "load" and said.keep_windows)
                              or (one.kind == "window" and said.again)),
                             ("export_rows", one.kind == "export" or (one.kind == "window" and len(said.solved) > 0)),
                             ("release_joints", one.kind == "window" and len(said.released) > 0)):
            if needed:
                self._need(word, one)
        for state in getattr(answer, "states", ()):
            if state.id not in self.bodies:
                raise BadRecording(path, one.at, f"the reply to request {one.number} has body {state.id}, which is not there")
            self.fastest = max(self.fastest, self.bodies[state.id].speed(state))

    def _need(self, word: str, one: Exchange) -> None:
        self.needs.setdefault(word, one.number)


@dataclass(frozen=True)
class Body:
    """What comparing needs of a body."""
    name: str
    mass: float
    size: float  # [m] the largest distance of its surface from its centre; 0: not known

    @staticmethod
    def of(body: Any) -> "Body":
        """Reads a RigidBody."""
        half, shape = body.box_half_size_m, body.WhichOneof("shape")
        size = 0.0
        if shape == "sphere_radius_m":
            size = body.sphere_radius_m
        elif shape == "box_half_size_m":
            size = math.hypot(half.x, half.y, half.z)
        for part in body.convex.parts:
            corners = list(part.corners)
            size = max([size, *map(math.hypot, corners[::3], corners[1::3], corners[2::3])])
        return Body(body.name or f"body {body.id}", body.mass, size)

    def speed(self, state: Any) -> float:
        """The speed of its centre, or of its surface by its spin (about, from mass and size), whichever is larger [m/s]."""
        v, spin = state.velocity, state.angular_momentum
        turning = math.hypot(spin.x, spin.y, spin.z) / (self.mass * self.size) if self.mass * self.size > 0.0 else 0.0
        found = max(math.hypot(v.x, v.y, v.z), turning)
        return found if math.isfinite(found) else 0.0
