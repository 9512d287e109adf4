"""Sessions that are made here: an engine in Python answers requests that were written by hand."""
from __future__ import annotations

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path
from typing import Any

from sunder_engine.messages import exchange
from sunder_engine.session import Session

from . import REPOSITORY, sunder

WINDOW_S, TICKS, WINDOWS, RADIUS, MASS, GRAVITY = 1e-3, 10, 12, 0.05, 2.0, 9.81
FALL, MEETS = 2.0, 7  # [m/s] of the ball; the first window at whose end it would be in the floor
LINE = b"sunder recording 1\n"
# Balls above a floor at z = 0, which takes their velocity so that they come to rest on it. Not in the text: what goes wrong.
ENGINE = '''#!/usr/bin/python3
import os, sys
sys.dont_write_bytecode = True
sys.path.append({modules!r})
from sunder_engine import BAD_INPUT, Engine, Refused, main


class Floor(Engine):
    name, version = "floor", "1"
    capabilities = {capabilities!r}

    def __init__(self):
        self.moving, self.radius, self.window = {{}}, {{}}, 0

    def add(self, body):
        self.radius[body.id] = body.sphere_radius_m
        if not body.is_static:
            self.moving[body.id] = self.state_of(body)

    def advance(self, window_s, predicted, solved):
        self.window += 1
        for motion in predicted:
            state = self.moving[motion.id]
            self.move(state, motion)
            push = max(self.radius[motion.id] - motion.position.z, 0.0) / window_s
            {fault}
            state.velocity.z += push
            state.position.z += window_s * push

    def states(self):
        return [self.moving[number] for number in sorted(self.moving)]

    def save(self):
        return b"caches"

    def restore(self, caches, motions):
        pass


if __name__ == "__main__":
    sys.exit(main(Floor){end})
'''
WORDS = ["spheres", "half_spaces", "contact", "deterministic", "double_precision"]


def engine_text(fault: str = "pass", capabilities: list[str] | None = None, end: str = "") -> str:
    return ENGINE.format(modules=str(REPOSITORY / "coupler"), fault=fault, end=end,
                         capabilities=WORDS if capabilities is None else capabilities)


def body(number: int, height: float, speed: float, name: str = "") -> Any:
    made = exchange().RigidBody(id=number, name=name, mass=MASS, sphere_radius_m=RADIUS)
    made.principal_inertia.x = made.principal_inertia.y = made.principal_inertia.z = 0.4 * MASS * RADIUS ** 2
    made.position.z, made.velocity.z, made.orientation.w = height, -speed, 1.0
    return made


class Recorder:
    """The shell's side of a session, with an engine in this process, written as RecordingTransport does it."""

    def __init__(self, path: Path, text: str) -> None:
        space: dict[str, Any] = {"__name__": "floor"}
        exec(compile(text, "floor", "exec"), space)  # noqa: S102
        self._session, self._file, self._number = Session(space["Floor"]()), path.open("wb"), 0
        self._file.write(LINE)
        self.tick = 0
        self.states: list[Any] = []

    def record(self, mark: bytes, message: bytes) -> None:
        self._file.write(mark + len(message).to_bytes(8, "little") + message)

    def ask(self, kind: str, **content: Any) -> Any:
        self._number += 1
        request = exchange().Request(sequence=self._number)
        getattr(request, kind).SetInParent()
        for name, value in content.items():
            if isinstance(value, list):
                getattr(getattr(request, kind), name).extend(value)
            else:
                setattr(getattr(request, kind), name, value)
        self.record(b">", request.SerializeToString())
        answer = self._session.answer(request.SerializeToString())
        assert answer is not None
        self.record(b"<", answer)
        reply = exchange().Reply.FromString(answer)
        assert reply.WhichOneof("kind") == kind, reply
        return getattr(reply, kind)

    def begin(self, **load: Any) -> None:
        self.ask("hello", protocol_min=2, protocol_max=2, scene_hash=b"of a scene", trace=True)
        floor = exchange().RigidBody(id=1, name="floor", is_static=True, half_space=True)
        floor.orientation.w = 1.0
        self.states = list(self.ask("load", bodies=[floor, body(2, RADIUS + (MEETS - 0.5) * WINDOW_S * FALL, FALL, "ball"),
                                                    body(3, 1.0, 0.0, "high")], **load).states)

    def window(self, **more: Any) -> None:
        predicted = []
        for state in self.states:
            motion = exchange().PredictedState(id=state.id, orientation=state.orientation, angular_momentum=state.angular_momentum)
            motion.velocity.z = state.velocity.z - GRAVITY * WINDOW_S
            motion.position.z = state.position.z + WINDOW_S * motion.velocity.z
            predicted.append(motion)
        self.states = list(self.ask("window", tick=self.tick, ticks=TICKS, window_s=WINDOW_S, predicted=predicted, **more).states)
        self.tick += TICKS

    def close(self) -> None:
        self._file.close()


class Sessions(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.path = self.folder / "session.rec"

    def recorded(self, capabilities: list[str] | None = None, save: bool = False, bye: bool = True, **load: Any) -> Path:
        """A session of twelve windows; another ball is born in the third, and the ball meets the floor in the seventh."""
        recorder = Recorder(self.path, engine_text(capabilities=capabilities))
        recorder.begin(**load)
        for number in range(1, WINDOWS + 1):
            recorder.window(**({"births": [body(4, 3.0, 1.0, "shard_7")]} if number == 3 else {}))
            if save and number == 5:
                recorder.ask("save")
        if bye:
            recorder.ask("bye")
        recorder.close()
        return self.path

    def validate(self, fault: str = "pass", *arguments: str, capabilities: list[str] | None = None, end: str = "") -> tuple[
            int, str, dict[str, Any]]:
        """Exit status, what was said, and the JSON, of an engine with this fault."""
        program, report = self.folder / "my_engine", self.folder / "report.json"
        program.write_text(engine_text(fault, capabilities, end))
        program.chmod(0o755)
        report.unlink(missing_ok=True)
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            status = sunder(["validate", "engines", "--rigid", str(program), "--session", str(self.path), "--json", str(report),
                             *arguments])
        return status, said.getvalue(), json.loads(report.read_text()) if report.is_file() else {}
