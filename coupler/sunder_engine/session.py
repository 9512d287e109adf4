"""The rigid side of a session: checks requests, asks the engine, makes replies (as coupler/link/session.cpp, host.cpp)."""
from __future__ import annotations

import math
import time
import traceback
from typing import Any, Iterable, Iterator, Mapping, Sequence

from .engine import BAD_INPUT, ENGINE_FAILED, MOTION, PEER_LOST, Engine, Refused
from .messages import exchange, parsed

PROTOCOL = 2
MOST_NAMED = 9  # of wrong ids in a message
UNIT = 1e-9  # deviation of a quaternion from unit length: round-off of a window
SHAPES = {"sphere_radius_m": "spheres", "box_half_size_m": "boxes", "half_space": "half_spaces", "convex": "convex_hulls"}


def need(good: bool, why: str) -> None:
    """Refuses a message that cannot be."""
    if not good:
        raise Refused("bad_message", why)


def numbers(message: Any) -> Iterator[float]:
    """All numbers with a point in a message, whatever is in it."""
    for field, value in message.ListFields():
        parts = value if field.label == field.LABEL_REPEATED else (value,)
        if field.type == field.TYPE_MESSAGE:
            for part in parts:
                yield from numbers(part)
        elif field.type == field.TYPE_DOUBLE:
            yield from parts


def is_sound(message: Any) -> bool:
    """Whether all numbers are finite and the orientation has unit length."""
    q = message.orientation
    return all(map(math.isfinite, numbers(message))) and abs(math.hypot(q.w, q.x, q.y, q.z) - 1.0) < UNIT


def unsound(message: Any) -> str:
    """Says what is_sound() found: the field and its value."""
    for field, value in message.ListFields():
        if field.message_type is not None and field.label != field.LABEL_REPEATED:
            parts = value.DESCRIPTOR.fields
            flat = all(part.message_type is None and part.label != part.LABEL_REPEATED for part in parts)  # zeros are not listed
            inner = [getattr(value, part.name) for part in parts] if flat else list(numbers(value))
            if not all(map(math.isfinite, inner)):
                return f"{field.name} is ({', '.join(f'{x:g}' for x in inner)}): not finite"
        elif isinstance(value, float) and not math.isfinite(value):
            return f"{field.name} is {value:g}: not finite"
    q = message.orientation
    return f"orientation has length {math.hypot(q.w, q.x, q.y, q.z):.12g}, which must be 1"


def named(body: int, names: Mapping[int, str]) -> str:
    """A body's id, with its name where it has one."""
    return f"{body} '{names[body]}'" if names.get(body) else str(body)


def wrong_ids(ids: Sequence[int], due: Sequence[int], names: Mapping[int, str]) -> tuple[str, int]:
    """Says which of these ids are not those that are `due`, in ascending order; and the first of them. They differ from sorted(due)."""
    held = set(ids)
    found = {"missing": sorted(set(due) - held), "surplus": sorted(held - set(due)),
             "twice": [body for body in sorted(held) if ids.count(body) > 1] if len(ids) > len(held) else []}
    if not any(found.values()):
        found = {"out of order": [after for before, after in zip(ids, ids[1:]) if after < before]}
    words = [f"{word}: id {', '.join(named(body, names) for body in wrong[:MOST_NAMED])}"
             + (f" and {len(wrong) - MOST_NAMED} more" if len(wrong) > MOST_NAMED else "") for word, wrong in found.items() if wrong]
    return "; ".join(words), next(wrong[0] for wrong in found.values() if wrong)


class Session:
    """State of one session with an engine."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._known: dict[int, str] = {}  # names of bodies, '' of one without, by id
        self._moving: list[int] = []    # of those that are not static, ascending
        self._joints: set[int] = set()
        self._turn = "hello"
        self._sequence = self._tick = 0
        self._keeps = self._moved = self._traces = False
        self._last: tuple[int, bytes, list[Any]] | None = None  # before the last window: tick, caches, motions
        self.status: int | None = None  # with which the process has to end; None: the session goes on
        self.failure = ""               # why, '' after Bye

    def answer(self, data: bytes) -> bytes | None:
        """The reply to a request; None where the other side reported its own failure and reads none."""
        self._sequence += 1
        begin = time.monotonic_ns()
        try:
            reply = self._reply(data)
        except Refused as error:
            return self._end(error.kind, str(error), error.status, error.body)
        except Exception as error:  # noqa: BLE001: one in the engine; the other side is told too
            traceback.print_exc()  # for its author, in rigid.log
            return self._end("internal", f"{type(error).__name__}: {error}", ENGINE_FAILED)
        if reply is None:
            return None
        if self._traces:
            reply.spans.add(name=reply.WhichOneof("kind"), begin_ns=begin, end_ns=time.monotonic_ns())
        return bytes(reply.SerializeToString())

    def _end(self, kind: str, message: str, status: int, body: int = 0) -> bytes:
        self.status, self.failure = status, f"{kind}: {message}"
        reply = exchange().Reply(sequence=self._sequence)
        reply.error.kind, reply.error.message, reply.error.body = kind, message, body
        return bytes(reply.SerializeToString())

    def _reply(self, data: bytes) -> Any:
        try:
            request = parsed("Request", data)
        except ValueError:
            raise Refused("bad_message", "bytes that are no request") from None
        need(request.sequence == self._sequence, f"request {request.sequence}, expected {self._sequence}")
        kind = request.WhichOneof("kind")
        if kind == "error":
            self.status, self.failure = PEER_LOST, f"peer_failed: the shell process reports: {request.error.message}"
            return None
        need(kind is not None, "a request without content")
        later = ("window", "export", "save", "restore", "add_bodies")
        need(kind == self._turn or (kind == "bye" and self._turn != "hello") or (self._turn == "window" and kind in later),
             f"{kind} is out of turn: {self._turn} is due")
        reply = exchange().Reply(sequence=self._sequence)
        getattr(reply, kind).SetInParent()
        getattr(self, f"_{kind}")(getattr(request, kind), getattr(reply, kind))
        return reply

    def _hello(self, request: Any, reply: Any) -> None:
        need(request.protocol_min <= PROTOCOL <= request.protocol_max, f"protocol {request.protocol_min} to "
             f"{request.protocol_max} asked for, {PROTOCOL} is spoken here")
        reply.protocol, reply.scene_hash = PROTOCOL, request.scene_hash
        reply.engine_name, reply.engine_version = self._engine.name, self._engine.version
        reply.capabilities.extend(self._engine.capabilities)
        self._turn, self._traces = "load", request.trace

    def _load(self, request: Any, reply: Any) -> None:
        need(request.tick >= 0, f"load.tick is {request.tick}")
        if request.keep_windows:
            self._needs("save_restore", "load.keep_windows")
        if request.joints:
            self._needs("joints", "load.joints")
        need(all(map(math.isfinite, numbers(request))), "load has a number that is not finite")
        self._engine.set_contact_laws(request.contacts)
        self._add(request.bodies, "bodies")
        for joint in request.joints:
            need(joint.id not in self._joints and joint.id > 0, f"joints[{joint.id}]: comes twice, or has no id")
            need(joint.first in self._known and (joint.second == 0 or joint.second in self._known)
                 and joint.first != joint.second, f"joints[{joint.id}]: a body of it is not there")
            self._joints.add(joint.id)
            self._engine.add_joint(joint)
        self._tick, self._keeps, self._turn = request.tick, request.keep_windows, "window"
        reply.states.extend(self._states())

    def _window(self, request: Any, reply: Any) -> None:
        if request.again:
            need(self._last is not None, "window.again, and no window was kept")
            assert self._last is not None
            self._tick = self._last[0]
        need(request.tick == self._tick and request.ticks >= 1, f"window at tick {request.tick} (+{request.ticks}), "
             f"expected {self._tick}")
        self._check_motions(request.window_s, request.predicted)
        if request.solved:
            self._needs("export_rows", "window.solved")
        self._held(request.solved, "window.solved")
        if request.released:
            self._needs("release_joints", "window.released")
        for number in request.released:
            need(number in self._joints, f"released[{number}]: there is no such joint")
            self._engine.release_joint(number)
        if request.again:
            self._engine.restore(self._last[1], self._last[2])  # type: ignore[index]
        elif self._keeps:
            self._last = self._tick, self._engine.save(), self._motions()
        self._moved = True
        self._engine.advance(request.window_s, request.predicted, request.solved)
        self._add(request.births, "births")
        if request.births:
            self._last = None  # births cannot be undone
        self._tick += request.ticks
        reply.tick = self._tick
        reply.states.extend(self._states())

    def _export(self, request: Any, reply: Any) -> None:
        self._needs("export_rows", "Export")
        need(request.tick == self._tick, f"export at tick {request.tick}, expected {self._tick}")
        self._check_motions(request.window_s, request.motions)
        self._held(request.bodies, "export.bodies")
        reply.rows.extend(self._engine.rows(request.window_s, request.motions, request.bodies))

    def _add_bodies(self, request: Any, reply: Any) -> None:
        self._needs("save_restore", "AddBodies")
        self._add(request.bodies, "bodies")
        added = {body.id for body in request.bodies}
        reply.states.extend(state for state in self._states() if state.id in added)
        self._last = None

    def _save(self, request: Any, reply: Any) -> None:
        self._needs("save_restore", "Save")
        reply.caches = self._engine.save()

    def _restore(self, request: Any, reply: Any) -> None:
        self._needs("save_restore", "Restore")
        need(not self._moved, "Restore after a window")
        self._engine.restore(request.caches, self._motions())

    def _bye(self, request: Any, reply: Any) -> None:
        self.status = 0

    def _needs(self, capability: str, what: str) -> None:
        need(capability in self._engine.capabilities, f"{what}: the engine cannot do '{capability}'")

    def _held(self, ids: Iterable[int], what: str) -> None:
        for number in ids:
            need(number in self._known, f"{what}: body {number} is not held here")

    def _check_motions(self, window_s: float, motions: Sequence[Any]) -> None:
        need(0.0 < window_s < math.inf, f"window_s is {window_s}")
        need([motion.id for motion in motions] == self._moving,
             "there must be one predicted state for each moving body, by ascending id")
        for motion in motions:
            need(is_sound(motion), f"the predicted state of body {motion.id}: {'' if is_sound(motion) else unsound(motion)}")

    def _add(self, bodies: Sequence[Any], what: str) -> None:
        for body in bodies:
            name = f"{what}[{body.id}]"
            need(body.id > 0 and body.id not in self._known, f"{name}: comes twice, is held already, or has no id")
            need(is_sound(body), f"{name}: {'' if is_sound(body) else unsound(body)}")
            shape = body.WhichOneof("shape")
            need(shape is not None, f"{name} has no shape")
            i = body.principal_inertia
            need(body.is_static or (body.mass > 0.0 and min(i.x, i.y, i.z) > 0.0), f"{name}: mass and inertia must be positive")
            for part in body.convex.parts:
                need(len(part.corners) % 3 == 0 and len(part.corners) >= 12, f"{name}: a part without corners")
            word = "compound" if len(body.convex.parts) > 1 else SHAPES[shape]
            if word not in self._engine.capabilities:
                raise Refused("bad_body", f"{name}: {self._engine.name} has no {word}", BAD_INPUT, body.id)
            self._known[body.id] = body.name
            if not body.is_static:
                self._moving.append(body.id)
            self._engine.add(body)
        self._moving.sort()

    def _motions(self) -> list[Any]:
        return [exchange().PredictedState(id=state.id, **{field: getattr(state, field) for field in MOTION})
                for state in self._engine.states()]

    def _states(self) -> list[Any]:
        states = list(self._engine.states())
        ids = [state.id for state in states]
        if ids != self._moving:
            wrong, body = wrong_ids(ids, self._moving, self._known)
            raise Refused("engine_failed", f"{self._engine.name}: states: {len(ids)} for {len(self._moving)} bodies; {wrong}; "
                          "give one of each that moves, by ascending id", ENGINE_FAILED, body)
        for state in states:
            if not is_sound(state):
                raise Refused("engine_failed", f"{self._engine.name}: the state of body {named(state.id, self._known)}: "
                              f"{unsound(state)}", ENGINE_FAILED, state.id)
        return states
