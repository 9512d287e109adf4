"""`validate engines --session`: which windows differ, by how much, and what is refused."""
from __future__ import annotations

import contextlib
import io
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from sunder_engine.messages import exchange
from sunder_engine.playing import Player, Reply
from sunder_engine.recording import exchanges
from sunder_engine.session import Session, is_sound, unsound, wrong_ids
from tests.conformance.sessions import unlike

from . import REPOSITORY, sunder
from .recorded import MASS, MEETS, TICKS, WINDOW_S, WINDOWS, WORDS, Recorder, Sessions, engine_text


# A launcher that tells its engine's number, and an engine that sleeps where it should make itself.
LAUNCHER = """
import subprocess, sys, time
engine = subprocess.Popen([sys.executable, "-c", sys.argv[1], "--endpoint", sys.argv[2], "--die-with-parent"])
print(engine.pid, flush=True)
time.sleep(3600)
"""
SLEEPER = """
import sys, time
sys.path.insert(0, {path!r})
from sunder_engine.serve import main
print("asleep", flush=True)
main(lambda: time.sleep(3600))
"""


def is_there(process: int) -> bool:
    """Whether a process lives; one that has ended and waits for its parent does not."""
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes() != b""
    except OSError:
        return False


class Orphan(unittest.TestCase):
    def test_an_engine_ends_with_its_launcher_whatever_it_does_then(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            launcher = subprocess.Popen([sys.executable, "-c", LAUNCHER, SLEEPER.format(path=str(REPOSITORY / "coupler")),
                                         f"ipc://{folder}/socket"], stdout=subprocess.PIPE, text=True)
            assert launcher.stdout is not None
            words = {launcher.stdout.readline().strip() for _ in range(2)}
            number, = words - {"asleep"}
            while not (Path(folder) / "socket").exists():  # it is bound, and asleep from then on
                time.sleep(0.02)
            launcher.kill()
            launcher.wait()
            launcher.stdout.close()
            while is_there(int(number)):
                time.sleep(0.02)  # for ever, where it stays


class Sound(unittest.TestCase):
    def test_what_is_wrong_with_a_motion_is_said_with_its_field_and_value(self) -> None:
        cases: list[tuple[dict[str, Any], str]] = [
            ({"velocity": {"x": 1.0, "y": float("nan")}}, "velocity is (1, nan, 0): not finite"),
            ({"mass": float("inf")}, "mass is inf: not finite"),
            ({"orientation": {"w": 0.9}}, "orientation has length 0.9, which must be 1")]
        for values, words in cases:
            with self.subTest(words):
                state = exchange().BodyState(**{"id": 1, "mass": 1.0, "orientation": {"w": 1.0}, **values})
                self.assertFalse(is_sound(state))
                self.assertEqual(unsound(state), words)

    def test_corners_of_a_shard_are_no_vector(self) -> None:
        shard = exchange().Load().bodies.add(id=4)
        shard.orientation.w = 0.9
        corners = shard.convex.parts.add().corners
        corners[:] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]
        self.assertEqual(unsound(shard), "orientation has length 0.9, which must be 1")
        corners[1] = float("inf")
        self.assertEqual(unsound(shard), "convex is (0, inf, 0, 1, 0, 0): not finite")

    def test_wrong_ids_are_named_by_what_is_wrong(self) -> None:
        names = {2: "ball"}
        for ids, words, first in (([1, 3], "missing: id 2 'ball'", 2), ([1, 2, 3, 9], "surplus: id 9", 9),
                                  ([1, 2, 2, 3], "twice: id 2 'ball'", 2), ([1, 3, 2], "out of order: id 2 'ball'", 2),
                                  ([3, 9], "missing: id 1, 2 'ball'; surplus: id 9", 1)):
            self.assertEqual(wrong_ids(ids, [1, 2, 3], names), (words, first))

    def test_a_recording_whose_states_are_in_another_order_is_compared_all_the_same(self) -> None:
        states = [exchange().BodyState(id=k, mass=1.0) for k in (2, 1)]
        player = SimpleNamespace(_names={}, summary=SimpleNamespace(bodies={1: "a", 2: "b"}), played=SimpleNamespace(tolerance=1e-9))
        reply = Reply("window", 7)
        with contextlib.suppress(AttributeError):  # of the stand-ins, once the order was judged
            Player._compare_states(player, reply, states, states[::-1])  # type: ignore[arg-type]
        self.assertEqual(reply.notes, [])


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
                         (MEETS - 1, (MEETS - 1) * TICKS, TICKS, WINDOW_S, 1))
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
        self.assertIn(f"first that differs: window {MEETS - 1} (request {MEETS + 2}, {ticks}, 0.001 s)", said)
        self.assertRegex(said, rf"window {MEETS - 1} .*: 1 of 3 bodies differ, most ball: velocity is off by .* m/s, .* allowed; of all: position by .* "
                                r"impulse .* N s instead of")

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
        self.assertEqual((status, found["stopped"]), (1, "window 4 (request 7): refused with bad_predicted_state: too far"), said)
        self.assertEqual(self.verdicts(found), ["same"] * 4)

    def test_an_engine_that_dies_is_lost(self) -> None:
        self.recorded()
        status, said, _ = self.validate("os._exit(9) if self.window == 5 else None")
        self.assertEqual(status, 3, said)
        self.assertRegex(said, r"my_engine: window 4 \(request 7\): the engine is gone: .*; it ended with status 9")
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
                assert self._answer is not None
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

        for spoil, at, told in ((late, 5, "window 2 (request 5): a reply of kind window and sequence 4; window and 5 are due"),
                                (other, 5, "window 2 (request 5): a reply of kind save and sequence 5"),
                                (lambda reply: b"\xff", 5, "window 2 (request 5): bytes that are no Reply"),
                                (lost, 1, "hello (request 1): scene_hash does not come back")):
            played = Player(self.path).play(Wrong(spoil, at))
            self.assertTrue(played.stopped.startswith(told), played.stopped)
            self.assertEqual(len(played.replies), max(at - 2, 0))
        played = Player(self.path).play(Wrong(fewer, 5))
        assert played.first is not None
        self.assertEqual((played.stopped, played.first.window, played.first.notes),
                         ("", 2, ["states: 2 for 3 bodies; missing: id 2 'ball'"]))

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
            self.assertIn(f"my_engine: hello (request 1): {told}", said.getvalue())

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
        self.assertIn("the session needs save_restore (request 2), which floor does not declare; declare it, or record a run of a scene "
                      "that needs no more", said)
        self.assertEqual(said.count("save_restore"), 1, said)  # the engine, which hears Bye, says nothing

    def test_a_session_with_exported_bodies_is_refused_once_with_the_setting_that_helps(self) -> None:
        recorder = Recorder(self.path, engine_text(capabilities=[*WORDS, "export_rows"]))
        recorder.begin()
        recorder.window(solved=[2])
        recorder.ask("bye")
        recorder.close()
        status, said, _ = self.validate()
        self.assertEqual(status, 2)
        self.assertIn("the session needs export_rows (request 3), which floor does not declare; declare it, or record the run so that "
                      "it exports no body: sunder run SCENE --rigid ENGINE --record --set coupling.export_above=1e9", said)
        program = self.folder / "my_engine"
        with subprocess.Popen(["/usr/bin/python3", "-c", "import sys; from tests.command import sunder; sys.exit(sunder(sys.argv[1:]))",
                               "validate", "engines", "--rigid", str(program), "--session", str(self.path)], cwd=REPOSITORY,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as asked:
            whole = asked.communicate()[0]
        self.assertEqual((asked.returncode, whole.count("export_rows (request"), whole.count("peer_failed")), (2, 1, 0), whole)

    def test_a_window_that_is_taken_again_keeps_its_number(self) -> None:
        recorder = Recorder(self.path, engine_text(capabilities=[*WORDS, "save_restore"]))
        recorder.begin(keep_windows=True)
        for again in (False, False, True, False):
            if again:
                recorder.tick -= TICKS
            recorder.window(again=again)
        recorder.ask("bye")
        recorder.close()
        status, said, found = self.validate(capabilities=[*WORDS, "save_restore"])
        self.assertEqual(status, 0, said)
        self.assertEqual([reply["window"] for reply in found["replies"]], [-1, 0, 1, 1, 2])

    def test_numbers_are_told_with_the_digits_that_differ(self) -> None:
        for one, other, told in ((6.41e-05, 6.41e-05, ("6.41e-05", "6.41e-05")), (1.0, 2.0, ("1", "2")),
                                 (6.41e-05, 6.4100001e-05, ("6.41e-05", "6.4100001e-05")),
                                 (1.0, 1.0 + 2.0**-52, ("1", "1.0000000000000002"))):
            self.assertEqual(unlike(one, other), told)
        for value, other in ((float("nan"), 1.0), (float("inf"), float("inf"))):
            self.assertEqual(unlike(value, other), (f"{value:g}", f"{other:g}"))

    def test_the_quantity_that_is_off_is_told(self) -> None:
        self.recorded()
        for fault, told in (("push *= 1.0 + 1e-6", "velocity is off by 1.3e-06 m/s, 2.1e-09 allowed; of all: position by 1.3e-09 m"),
                            ("state.position.x += 1e-7", "position is off by 1e-07 m, 5e-11 allowed"),
                            ("state.angular_momentum.x += 1e-3", "angular momentum is off by 0.001 N m s, ")):
            status, said, found = self.validate(fault)
            self.assertEqual(status, 1, said)
            self.assertIn(told, said)

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


if __name__ == "__main__":
    unittest.main()
