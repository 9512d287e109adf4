"""Plays the shell's side of a recorded session to an engine, and compares its replies with the recorded ones.

Each window of a recording has the predicted states that the shell sent then. So an engine starts each window at its own
states and ends it near the recorded ones: what it does differently in one window hardly changes the next.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Iterable, Protocol

from .engine import MOTION
from .messages import exchange, parsed
from .recording import Body, Exchange, Summary, exchanges
from .session import is_sound, named, unsound, wrong_ids

DOUBLE, SINGLE = 1e-9, 1e-4  # tolerances of engines with double_precision and without (rigid/README.md)
NOTHING_EXPORTED = "--set coupling.export_above=1e9"  # a run with it needs no export_rows
SAME, CLOSE, DIFFERS = "same", "close", "differs"


class Refusal(Exception):
    """The session cannot be played to this engine; the message says why and what to do."""


class _Wrong(Exception):
    """A reply with which the session cannot go on."""


class Connection(Protocol):
    """What a session is played over."""

    def send(self, message: bytes) -> None:
        """Sends a message."""

    def receive(self) -> bytes:
        """Waits for the next one."""


@dataclass
class Difference:
    """How far a body's state is from the recorded one. Impulses are those of the engine in the window: mass times velocity,
    and angular momentum, beyond the predicted state."""
    body: str
    position_m: float
    turn_rad: float
    velocity_m_per_s: float
    impulse_N_s: float                        # of this engine
    recorded_impulse_N_s: float
    angular_impulse_N_m_s: float              # of this engine
    recorded_angular_impulse_N_m_s: float
    angular_impulse_difference_N_m_s: float
    share: float                              # of the tolerance, of the worst of these
    quantity: str = ""                        # the worst: position, turn, velocity or angular momentum
    is_by: float = 0.0                        # how far it is off, in `unit`
    allowed: float = 0.0
    unit: str = ""


@dataclass
class Reply:
    """A reply that was compared."""
    kind: str
    request: int           # its number
    verdict: str = SAME    # to the bit; close: within the tolerance; differs
    window: int = -1       # its number from 0, as in run.json; -1: no window
    tick: int = 0
    ticks: int = 0
    window_s: float = 0.0
    bodies: int = 0        # in it
    bodies_differ: int = 0
    worst: Difference | None = None
    notes: list[str] = field(default_factory=list)  # differences that are no number of a body


@dataclass
class Played:
    """The result."""
    engine: str = ""
    version: str = ""
    capabilities: list[str] = field(default_factory=list)
    recorded: str = ""
    tolerance: float = 0.0
    replies: list[Reply] = field(default_factory=list)
    stopped: str = ""      # why the engine ended the session before its time: its Error, or a reply that cannot be
    skipped: int = 0       # requests for caches that it does not have

    @property
    def first(self) -> Reply | None:
        """The first reply that differs."""
        return next((reply for reply in self.replies if reply.verdict == DIFFERS), None)


class Player:
    """One session over a connection."""

    def __init__(self, path: Path, tolerance: float | None = None) -> None:
        """Reads the whole recording, so that nothing is started for one that is damaged. Raises BadRecording, OSError."""
        self._path = path
        self.summary = Summary(path)
        self.played = Played(recorded=self.summary.engine, tolerance=tolerance or 0.0)
        self.asked = "the connection"  # what is waited for
        self._sequence, self._window = 0, -1
        self._predicted: dict[int, Any] = {}
        self._names = {number: body.name for number, body in self.summary.bodies.items()}

    def play(self, engine: Connection) -> Played:
        """Plays all requests, or as many as the engine answers. Raises Refusal, and what the connection raises."""
        try:
            self._play(engine)
        except _Wrong as error:
            self.played.stopped = f"{self.asked}: {error}"
        except Refusal:
            try:
                self._bye(engine)  # an Error would be told by the engine as well
            except Exception:  # noqa: BLE001: why the session is refused matters more
                pass
            raise
        return self.played

    def _play(self, engine: Connection) -> None:
        ended = False
        for one in exchanges(self._path):
            if one.kind == "save" and "save_restore" not in self.played.capabilities:
                self.played.skipped += 1
                continue
            answer = self._ask(engine, one.request, one.number)
            ended = one.kind == "bye"
            if one.kind == "hello":
                self._greeted(one, answer)
            else:
                self._compare(one, answer)
        if not ended:  # the recorded run was interrupted or failed
            self._bye(engine)

    def _bye(self, engine: Connection) -> None:
        bye = exchange().Request()
        bye.bye.SetInParent()
        self._ask(engine, bye, self._sequence + 1)

    def _ask(self, engine: Connection, request: Any, number: int) -> Any:
        """The reply. Raises _Wrong."""
        self._sequence += 1
        kind = request.WhichOneof("kind")
        request.sequence = self._sequence
        if kind == "hello":
            request.hello.trace = False
        if kind == "window":
            self._window += not request.window.again
            self.asked = f"window {self._window} (request {number})"
        else:
            self.asked = f"{kind} (request {number})"
        engine.send(request.SerializeToString())
        answer = engine.receive()
        try:
            reply = parsed("Reply", answer)
        except ValueError as error:
            raise _Wrong(str(error)) from None
        if reply.WhichOneof("kind") == "error":
            raise _Wrong(f"refused with {reply.error.kind}: {reply.error.message}")
        if reply.WhichOneof("kind") != kind or reply.sequence != self._sequence:
            raise _Wrong(f"a reply of kind {reply.WhichOneof('kind')} and sequence {reply.sequence}; {kind} and {self._sequence} "
                         "are due")
        for state in reply.window.states if kind == "window" else ():
            if not is_sound(state):
                raise _Wrong(f"body {named(state.id, self._names)}: {unsound(state)}")
        return reply

    def _greeted(self, one: Exchange, reply: Any) -> None:
        """Looks whether the engine can play the session."""
        hello, played, summary = reply.hello, self.played, self.summary
        played.engine, played.version, played.capabilities = hello.engine_name, hello.engine_version, list(hello.capabilities)
        if hello.scene_hash != one.request.hello.scene_hash:
            raise _Wrong("scene_hash does not come back as it was sent")
        lacking = {word: number for word, number in summary.needs.items() if word not in played.capabilities}
        if lacking:
            words = ", ".join(f"{word} (request {number})" for word, number in lacking.items())
            other = ("the run so that it exports no body: sunder run SCENE --rigid ENGINE --record " + NOTHING_EXPORTED
                     if list(lacking) == ["export_rows"] else "a run of a scene that needs no more (sunder run SCENE --rigid ENGINE --record)")
            raise Refusal(f"the session needs {words}, which {hello.engine_name} does not declare; declare "
                          f"{'it' if len(lacking) == 1 else 'them'}, or record {other}")
        if summary.restores and summary.engine != f"{hello.engine_name} {hello.engine_version}".strip():
            raise Refusal(f"the session goes on from a checkpoint with caches of {summary.engine}, which only that engine reads; "
                          "record a run from its start")
        played.tolerance = played.tolerance or (DOUBLE if "double_precision" in played.capabilities else SINGLE)

    def _compare(self, one: Exchange, answer: Any) -> None:
        if one.reply is None or one.reply.WhichOneof("kind") == "error" or one.kind in ("save", "restore", "bye"):
            return  # nothing was recorded, or what only that engine reads
        then, now = getattr(one.reply, one.kind), getattr(answer, one.kind)
        found = Reply(one.kind, one.number)
        said = getattr(one.request, one.kind)
        if one.kind == "window":
            self._predicted = {motion.id: motion for motion in said.predicted}
            found.window = self._window
            found.tick, found.ticks, found.window_s = said.tick, said.ticks, said.window_s
            if now.tick != then.tick:
                found.notes.append(f"its tick is {now.tick}, and {then.tick} is due")
        if one.kind == "export":
            found.tick, found.window_s = said.tick, said.window_s
            self._compare_rows(found, then.rows, now.rows)
        else:
            self._compare_states(found, then.states, now.states)
        if found.notes:
            found.verdict = DIFFERS
        elif then.SerializeToString() != now.SerializeToString() and found.verdict == SAME:
            found.verdict = CLOSE
        self.played.replies.append(found)

    def _compare_states(self, found: Reply, then: Iterable[Any], now: Iterable[Any]) -> None:
        mine = list(now)
        recorded = {state.id: state for state in then}
        found.bodies = len(recorded)
        if [state.id for state in mine] != sorted(recorded):  # whatever order a recording has
            wrong, _ = wrong_ids([state.id for state in mine], sorted(recorded), self._names)
            found.notes.append(f"states: {len(mine)} for {len(recorded)} bodies; {wrong}")
        for state in mine:
            if state.id not in recorded:
                continue
            body, other = self.summary.bodies[state.id], recorded[state.id]
            if _share(abs(state.mass - other.mass), self.played.tolerance * other.mass) > 1.0:
                found.notes.append(f"{body.name}: its mass is {state.mass:g} kg, and {other.mass:g} kg as loaded")
            if all(getattr(state, part) == getattr(other, part) for part in MOTION):
                continue
            difference = self._difference(body, other, state)
            found.bodies_differ += difference.share > 1.0
            if found.worst is None or difference.share > found.worst.share:
                found.worst = difference
        if found.worst is not None:
            found.verdict = DIFFERS if found.bodies_differ else CLOSE

    def _difference(self, body: Body, then: Any, now: Any) -> Difference:
        """Limits are shares: of the body's size for places, of a radian for turns, of the fastest body for velocities."""
        position, velocity = _apart(now.position, then.position), _apart(now.velocity, then.velocity)
        turn, spin = _turn(now.orientation, then.orientation), _apart(now.angular_momentum, then.angular_momentum)
        fastest, tolerance = self.summary.fastest, self.played.tolerance
        share, quantity, is_by, allowed, unit = max(
            (_share(value, tolerance * scale), quantity, value, tolerance * scale, unit) for quantity, value, scale, unit in (
                ("position", position, body.size, "m"), ("turn", turn, 1.0, "rad"), ("velocity", velocity, fastest, "m/s"),
                ("angular momentum", spin, body.mass * body.size * fastest, "N m s")))
        predicted = self._predicted.get(now.id, then)
        return Difference(
            body.name, position, turn, velocity, body.mass * _apart(now.velocity, predicted.velocity),
            body.mass * _apart(then.velocity, predicted.velocity), _apart(now.angular_momentum, predicted.angular_momentum),
            _apart(then.angular_momentum, predicted.angular_momentum), spin, share, quantity, is_by, allowed, unit)

    def _compare_rows(self, found: Reply, then: Any, now: Any) -> None:
        """Contact rows of Export, in their order."""
        if len(then) != len(now):
            found.notes.append(f"{len(now)} contact rows instead of {len(then)}")
            return
        for number, (a, b) in enumerate(zip(then, now)):
            first, second = self.summary.bodies.get(a.first), self.summary.bodies.get(a.second)
            size = min([body.size for body in (first, second) if body is not None and body.size > 0.0], default=0.0)
            values = {"first_point [m]": (_apart(a.first_point, b.first_point), size),
                      "second_point [m]": (_apart(a.second_point, b.second_point), size),
                      "normal": (_apart(a.normal, b.normal), 1.0), "friction": (abs(a.friction - b.friction), 1.0),
                      "restitution": (abs(a.restitution - b.restitution), 1.0),
                      "allowance_m": (abs(a.allowance_m - b.allowance_m), size)}
            if (a.first, a.second) != (b.first, b.second):
                found.notes.append(f"contact row {number} is of bodies {b.first} and {b.second} instead of {a.first} and "
                                   f"{a.second}")
            for name, (value, scale) in values.items():
                if _share(value, self.played.tolerance * scale) > 1.0:
                    found.notes.append(f"contact row {number} (bodies {a.first} and {a.second}): {name} differs by {value:.2g}")
            if found.notes:
                return


def _share(value: float, limit: float) -> float:
    """How much of a limit a value is; infinite where the value is not a number."""
    if value == 0.0:
        return 0.0
    return value / limit if limit > 0.0 and not math.isnan(value) else math.inf


def _apart(a: Any, b: Any) -> float:
    return math.hypot(a.x - b.x, a.y - b.y, a.z - b.z)


def _turn(a: Any, b: Any) -> float:
    """The angle between two orientations [rad]; q and -q are one. By the difference: a cosine near 1 has no digits left."""
    apart = min(math.hypot(a.w - s * b.w, a.x - s * b.x, a.y - s * b.y, a.z - s * b.z) for s in (1.0, -1.0))
    return 4.0 * math.asin(min(0.5 * apart, 1.0)) if apart == apart else math.nan
