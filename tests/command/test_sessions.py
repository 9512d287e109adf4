"""`validate engines --session`: which windows differ, by how much, and files that are no recordings.

The session is made here: an engine in Python answers requests that were written by hand.
"""
from __future__ import annotations

import contextlib
import io
import json
import random
import tempfile
import unittest
from pathlib import Path
from typing import Any

from sunder_engine.messages import exchange
from sunder_engine.playing import Player
from sunder_engine.recording import BadRecording, Summary, exchanges
from sunder_engine.session import Session, is_sound, unsound

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
SHIPPED = REPOSITORY / "tests" / "conformance" / "free_flight.rec"
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
        self.tick, self.states = 0, []

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


class Sound(unittest.TestCase):
    def test_what_is_wrong_with_a_motion_is_said_with_its_field_and_value(self) -> None:
        for values, words in (({"velocity": {"x": 1.0, "y": float("nan")}}, "velocity is (1, nan): not finite"),
                              ({"mass": float("inf")}, "mass is inf: not finite"),
                              ({"orientation": {"w": 0.9}}, "orientation has length 0.9, which must be 1")):
            with self.subTest(words):
                state = exchange().BodyState(**{"id": 1, "mass": 1.0, "orientation": {"w": 1.0}, **values})
                self.assertFalse(is_sound(state))
                self.assertEqual(unsound(state), words)


class Playing(Sessions):
    def test_a_state_that_is_not_finite_stops_it(self) -> None:
        self.recorded()
        status, said, found = self.validate("push *= float('nan')")
        self.assertEqual(status, 1, said)
        self.assertRegex(found["stopped"] + said, "not finite")

    def verdicts(self, found: dict[str, Any]) -> list[str]:
        return [reply["verdict"] for reply in found["replies"] if reply["kind"] == "window"]

    def test_the_engine_that_was_recorded_gives_the_same_bits(self) -> None:
        self.recorded()
        status, said, found = self.validate()
        self.assertEqual(status, 0, said)
        self.assertEqual(self.verdicts(found), ["same"] * WINDOWS)
        self.assertIn(f"{WINDOWS} windows: {WINDOWS} the same to the bit, 0 within the tolerance, 0 differ", said)
        self.assertEqual((found["recorded_with"], found["engine"], found["tolerance"]), ("floor 1", "floor", 1e-9))
        self.assertEqual((found["first_that_differs"], found["stopped"], found["ended"]), (None, "", ""))
        self.assertEqual([reply["bodies"] for reply in found["replies"]], [2] * 3 + [3] * 10)  # of Load, and of windows

    def test_round_off_is_within_the_tolerance(self) -> None:
        self.recorded()
        status, said, found = self.validate("push *= 1.0 + 1e-11")
        self.assertEqual(status, 0, said)
        self.assertEqual(self.verdicts(found), ["same"] * (MEETS - 1) + ["close"] * (WINDOWS - MEETS + 1))
        worst = found["replies"][MEETS]["worst"]
        self.assertEqual(worst["body"], "ball")
        self.assertLess(worst["share"], 1.0)

    def test_the_first_window_that_differs_is_named_with_body_and_impulse(self) -> None:
        self.recorded()
        status, said, found = self.validate("push *= 1.5")
        self.assertEqual(status, 1, said)
        self.assertEqual(self.verdicts(found)[:MEETS], ["same"] * (MEETS - 1) + ["differs"])
        self.assertEqual(found["first_that_differs"], MEETS + 2)
        one = found["replies"][MEETS]
        self.assertEqual((one["window"], one["tick"], one["ticks"], one["window_s"], one["bodies_differ"]),
                         (MEETS, (MEETS - 1) * TICKS, TICKS, WINDOW_S, 1))
        worst = one["worst"]
        recorded = [e for e in exchanges(self.path)][MEETS + 1]
        predicted, then = recorded.request.window.predicted[0], recorded.reply.window.states[0]
        impulse = MASS * (then.velocity.z - predicted.velocity.z)
        self.assertGreater(impulse, 0.1)
        self.assertAlmostEqual(worst["recorded_impulse_N_s"], impulse, places=12)
        self.assertAlmostEqual(worst["impulse_N_s"], 1.5 * impulse, places=12)
        self.assertAlmostEqual(worst["velocity_m_per_s"], 0.5 * impulse / MASS, places=12)
        self.assertAlmostEqual(worst["position_m"], 0.5 * impulse / MASS * WINDOW_S, places=12)
        ticks = f"tick {(MEETS - 1) * TICKS} to {MEETS * TICKS}"
        self.assertIn(f"first that differs: window {MEETS} (request {MEETS + 2}, {ticks}, 0.001 s)", said)
        self.assertRegex(said, rf"window {MEETS} .*: 1 of 3 bodies differ, most ball: position by .* impulse .* N s instead of")

    def test_a_wider_tolerance_is_taken_and_told(self) -> None:
        self.recorded()
        status, said, found = self.validate("push *= 1.0 + 1e-6")
        self.assertEqual(status, 1, said)
        status, said, found = self.validate("push *= 1.0 + 1e-6", "--tolerance", "1e-4")
        self.assertEqual((status, found["tolerance"]), (0, 1e-4), said)
        self.assertIn("tolerance  0.0001 ", said)
        words = [word for word in WORDS if word != "double_precision"]
        status, said, found = self.validate("push *= 1.0 + 1e-6", capabilities=words)
        self.assertEqual((status, found["tolerance"]), (0, 1e-4), said)

    def test_turns_and_masses_are_compared(self) -> None:
        self.recorded()
        for fault, told in (("state.orientation.w, state.orientation.x = 0.6, 0.8", "turn 1.9 rad"),
                            ("state.orientation.w *= -1.0", ""),  # q and -q are one
                            ("state.angular_momentum.x += 1e-3", "angular 0.001 N m s instead of 0"),
                            ("state.mass = 3.0", "its mass is 3 kg, and 2 kg as loaded")):
            status, said, found = self.validate(fault)
            self.assertEqual(status, 1 if told else 0, said)
            self.assertIn(told, said)

    def test_what_the_engine_refuses_is_told(self) -> None:
        self.recorded()
        fault = 'if self.window == 5: raise Refused("bad_predicted_state", "too far", BAD_INPUT)'
        status, said, found = self.validate(fault)
        self.assertEqual((status, found["stopped"]), (1, "request 7 (window): refused with bad_predicted_state: too far"), said)
        self.assertEqual(self.verdicts(found), ["same"] * 4)

    def test_an_engine_that_dies_is_lost(self) -> None:
        self.recorded()
        status, said, _ = self.validate("os._exit(9) if self.window == 5 else None")
        self.assertEqual(status, 3, said)
        self.assertRegex(said, r"my_engine: request 7 \(window\): the engine is gone: .*; it ended with status 9")
        status, said, _ = self.validate(end=" or os._exit(0)", fault="pass")  # after Bye: as it has to be
        self.assertEqual(status, 0, said)
        status, said, found = self.validate(end=" or 7")
        self.assertEqual((status, found["ended"]), (1, "it ended with status 7 after Bye; 0 is due"), said)

    def test_a_reply_that_cannot_be_stops_the_session(self) -> None:
        self.recorded()
        space: dict[str, Any] = {"__name__": "floor"}
        exec(compile(engine_text(), "floor", "exec"), space)  # noqa: S102

        class Wrong:
            """An engine in this process; its fifth reply is spoilt."""

            def __init__(self, spoil: Any, at: int) -> None:
                self._session, self._spoil, self._at, self._count = Session(space["Floor"]()), spoil, at, 0

            def send(self, message: bytes) -> None:
                self._answer = self._session.answer(message)

            def receive(self) -> bytes:
                self._count += 1
                reply = exchange().Reply.FromString(self._answer)
                return bytes(self._spoil(reply) if self._count == self._at else self._answer)

        def late(reply: Any) -> bytes:
            reply.sequence -= 1
            return bytes(reply.SerializeToString())

        def other(reply: Any) -> bytes:
            reply.save.SetInParent()
            return bytes(reply.SerializeToString())

        def lost(reply: Any) -> bytes:
            reply.hello.scene_hash = b""
            return bytes(reply.SerializeToString())

        def fewer(reply: Any) -> bytes:
            del reply.window.states[0]
            return bytes(reply.SerializeToString())

        for spoil, at, told in ((late, 5, "request 5 (window): a reply of kind window and sequence 4; window and 5 are due"),
                                (other, 5, "request 5 (window): a reply of kind save and sequence 5"),
                                (lambda reply: b"\xff", 5, "request 5 (window): bytes that are no Reply"),
                                (lost, 1, "request 1 (hello): scene_hash does not come back")):
            played = Player(self.path).play(Wrong(spoil, at))
            self.assertTrue(played.stopped.startswith(told), played.stopped)
            self.assertEqual(len(played.replies), max(at - 2, 0))
        played = Player(self.path).play(Wrong(fewer, 5))
        assert played.first is not None
        self.assertEqual((played.stopped, played.first.window, played.first.notes),
                         ("", 3, ["states of other bodies: missing [2], not due []"]))

    def test_one_that_never_speaks_is_told(self) -> None:
        self.recorded()
        program = self.folder / "my_engine"
        for text, told in (("#!/bin/sh\nexit 2\n", "the engine's process has ended; it ended with status 2"), (
                "#!/usr/bin/python3\nimport socket, sys\nserver = socket.socket(socket.AF_UNIX)\n"
                "server.bind(sys.argv[sys.argv.index('--endpoint') + 1].removeprefix('ipc://'))\nserver.listen()\n"
                "peer, _ = server.accept()\npeer.sendall(b'HTTP/1.1 400 Bad Request'.ljust(64))\npeer.recv(99)\n",
                "it does not speak ZMTP 3 without keys")):
            program.write_text(text)
            program.chmod(0o755)
            said = io.StringIO()
            with contextlib.redirect_stderr(said):
                status = sunder(["validate", "engines", "--rigid", str(program), "--session", str(self.path)])
            self.assertEqual(status, 3, said.getvalue())
            self.assertIn(f"my_engine: request 1 (hello): {told}", said.getvalue())

    def test_caches_are_no_matter_of_an_engine_without_them(self) -> None:
        self.recorded(capabilities=[*WORDS, "save_restore"], save=True)
        status, said, found = self.validate()
        self.assertEqual(status, 0, said)
        self.assertEqual(self.verdicts(found), ["same"] * WINDOWS)
        self.assertIn("1 requests for caches were left out", said)

    def test_a_session_that_needs_more_is_refused_before_it_begins(self) -> None:
        self.recorded(capabilities=[*WORDS, "save_restore"], keep_windows=True)
        status, said, found = self.validate()
        self.assertEqual((status, found), (2, {}))
        self.assertIn("the session needs save_restore (request 2), which floor does not declare; declare them, or", said)

    def test_a_session_from_a_checkpoint_is_for_its_own_engine(self) -> None:
        recorder = Recorder(self.path, engine_text(capabilities=[*WORDS, "save_restore"]))
        recorder.begin()
        recorder.ask("restore", caches=b"caches")
        recorder.window()
        recorder.ask("bye")
        recorder.close()
        words = [*WORDS, "save_restore"]
        self.assertEqual(self.validate(capabilities=words)[0], 0)
        text = (self.folder / "my_engine").read_text().replace('"floor", "1"', '"floor", "2"')
        (self.folder / "other").write_text(text)
        (self.folder / "other").chmod(0o755)
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            status = sunder(["validate", "engines", "--rigid", str(self.folder / "other"), "--session", str(self.folder)])
        self.assertEqual(status, 2)
        self.assertIn("with caches of floor 1, which only that engine reads; record a run from its start", said.getvalue())

    def test_a_run_that_was_interrupted_is_played_as_far_as_it_goes(self) -> None:
        self.recorded(bye=False)
        with self.path.open("ab") as file:
            told = exchange().Request()
            told.error.kind, told.error.message = "interrupted", "by the user"
            message = told.SerializeToString()
            file.write(b"!" + len(message).to_bytes(8, "little") + message)
        status, said, found = self.validate()
        self.assertEqual((status, len(self.verdicts(found))), (0, WINDOWS), said)

    def test_what_cannot_be_is_refused(self) -> None:
        self.recorded()
        for arguments, words in ((["engines", "--session", str(self.path)], "engines --rigid ENGINE"),
                                 (["shells", "--session", str(self.path)], "engines --rigid ENGINE"),
                                 (["engines", "--rigid", "./x", "--session", str(self.path), "--case", "a"], "which has no cases"),
                                 (["engines", "--rigid", "inprocess:bullet", "--session", str(self.path)], "over the wire"),
                                 (["engines", "--rigid", "./none", "--session", str(self.path)], "there is no such file"),
                                 (["engines", "--rigid", "tcp://1.2.3.4:5", "--session", str(self.path)], "without keys"),
                                 (["engines", "--tolerance", "1e-3"], "is for --session"),
                                 (["engines", "--rigid", "./x", "--session", str(self.folder / "none")], "--record")):
            said = io.StringIO()
            with contextlib.redirect_stderr(said):
                self.assertEqual(sunder(["validate", *arguments]), 2, arguments)
            self.assertIn(words, said.getvalue())


class Shipped(unittest.TestCase):
    def test_the_engine_that_is_written_for_a_start_plays_it_to_the_bit(self) -> None:
        with tempfile.TemporaryDirectory() as name, contextlib.redirect_stdout(io.StringIO()) as said:
            engine, report = Path(name) / "my_engine", Path(name) / "windows.json"
            self.assertEqual(sunder(["engine", "new", str(engine)]), 0)
            status = sunder(["validate", "engines", "--rigid", str(engine), "--session", str(SHIPPED), "--json", str(report)])
            self.assertEqual(status, 0, said.getvalue())
            found = json.loads(report.read_text())
        self.assertEqual({reply["verdict"] for reply in found["replies"]}, {"same"})
        self.assertEqual([found["replies"][k]["bodies"] for k in (0, -1)], [0, 1])  # a shard is born

    def test_it_is_of_the_scene_that_the_page_names(self) -> None:
        page = (REPOSITORY / "rigid" / "README.md").read_text()
        self.assertRegex(page, r"run scenes/cut_pane\.textproto --rigid freeflight --until 3e-3 --record")
        summary = Summary(SHIPPED)
        self.assertRegex(summary.engine, "^freeflight ")
        self.assertTrue(any(body.name.startswith("shard_") for body in summary.bodies.values()))
        self.assertLessEqual(set(summary.needs), {"convex_hulls", "compound", "half_spaces", "spheres", "boxes"})


class Reading(Sessions):
    def refused(self, content: bytes) -> str:
        """What a file with this content is refused with; '' where it is taken."""
        self.path.write_bytes(content)
        try:
            Summary(self.path)
        except BadRecording as error:
            return str(error)
        return ""

    def test_the_place_of_damage_is_told_with_the_remedy(self) -> None:
        good = self.recorded().read_bytes()
        starts = [one.at for one in exchanges(self.path)]
        size = starts[3] - starts[2]
        for content, told in (
                (b"", "byte 0: the file begins with b''"),
                (b'{"schema": 1, "status": "done"}', "byte 0: the file begins with"),
                (good.replace(b"recording 1", b"recording 2", 1), "byte 0"),
                (good[:starts[2] + 4], f"byte {starts[2]}: the file ends within this record"),
                (good[:starts[2] + size // 4], f"byte {starts[2]}: the file ends within this record"),
                (good[:starts[2]] + b"x" + good[starts[2] + 1:], f"byte {starts[2]}: b'x' begins no record"),
                (good[:starts[2]] + good[starts[3]:], f"byte {starts[2]}: request 3 is missing"),
                (good[:starts[1]], f"byte {starts[1]}: the session ends before Load"),
                (good + good[starts[2]:], f"byte {len(good)}: a record after the end"),
                (LINE + b">" + (1 << 60).to_bytes(8, "little"), f"byte {len(LINE)}: a record of {1 << 60} bytes"),
                (LINE + b"<" + bytes(8), f"byte {len(LINE)}: a reply without a request"),
                (LINE + b">" + (3).to_bytes(8, "little") + b"\xff\xff\xff", f"byte {len(LINE)}: the record holds no Request")):
            said = self.refused(content)
            self.assertIn(f"{self.path}: {told}", said)
            self.assertIn("take session.rec of a run that was made with 'coupler/sunder run SCENE --record'", said)

    def test_damage_anywhere_is_refused_or_does_no_harm(self) -> None:
        good = self.recorded().read_bytes()
        chance = random.Random(4)
        taken = 0
        for _ in range(400):
            damaged = bytearray(good)
            for _ in range(chance.randint(1, 3)):
                damaged[chance.randrange(len(damaged))] = chance.randrange(256)
            cut = bytes(damaged[:chance.randrange(len(damaged))] if chance.random() < 0.3 else damaged)
            taken += not self.refused(cut)
        self.assertGreater(taken, 20)  # most bytes are of numbers, which may be any

    def test_damaged_numbers_end_in_a_comparison(self) -> None:
        """Of a recorded reply: not a number, and a size that is none."""
        self.recorded()
        records = list(exchanges(self.path))
        content = bytearray(LINE)
        for one in records:
            if one.number == 5:
                one.reply.window.states[0].velocity.x = float("nan")
            for mark, message in ((b">", one.request), (b"<", one.reply)):
                raw = message.SerializeToString()
                content += mark + len(raw).to_bytes(8, "little") + raw
        self.path.write_bytes(content)
        status, said, found = self.validate()
        self.assertEqual((status, found["first_that_differs"]), (1, 5), said)
        self.assertIsNone(found["replies"][3]["worst"]["velocity_m_per_s"])
        records[1].request.load.bodies[1].sphere_radius_m = float("inf")
        raw = records[1].request.SerializeToString()
        head = content[:records[1].at]
        self.assertIn("a mass or a size that is not finite", self.refused(
            bytes(head) + b">" + len(raw).to_bytes(8, "little") + raw + b"<" + len(
                answer := records[1].reply.SerializeToString()).to_bytes(8, "little") + answer))

    def test_the_summary_knows_what_a_session_needs(self) -> None:
        self.recorded(capabilities=[*WORDS, "save_restore"], keep_windows=True)
        found = Summary(self.path)
        self.assertEqual((found.engine, found.windows, found.restores), ("floor 1", WINDOWS, False))
        self.assertEqual(found.needs, {"half_spaces": 2, "spheres": 2, "save_restore": 2})
        self.assertEqual([(number, one.name) for number, one in found.bodies.items()],
                         [(1, "floor"), (2, "ball"), (3, "high"), (4, "shard_7")])
        self.assertAlmostEqual(found.bodies[2].size, RADIUS)
        self.assertGreater(found.fastest, FALL)
        self.assertEqual(Player(self.path, 0.5).played.tolerance, 0.5)


if __name__ == "__main__":
    unittest.main()
