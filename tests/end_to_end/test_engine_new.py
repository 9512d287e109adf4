"""What `sunder engine new` writes: held to the suite, to a run of the exact engine, and its base class to its checks."""
from __future__ import annotations

import json
import math
import os
import shlex
import socket
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path
from typing import Any, Callable

TOP = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ["SUNDER_BUILD_DIR"])
SUNDER = str(TOP / "coupler" / "sunder")
sys.path.insert(0, str(TOP / "coupler"))
from sunder_engine import BAD_INPUT, ENGINE_FAILED, PEER_LOST, Engine  # noqa: E402
from sunder_engine.messages import exchange  # noqa: E402
from sunder_engine.session import Session  # noqa: E402
from sunder_engine.wire import GREETING, LOOK_S, READY, Lost, Wire  # noqa: E402

QUICK = ("rules_turn", "rules_window", "rules_end", "free_flight_sphere", "births", "deterministic")
WITH_CACHES = ("save_restore", "again", "solved_box", "rules_turn")
CACHES = '''
    def rows(self, window_s, motions, bodies):
        return []

    def save(self):
        return b""

    def restore(self, caches, motions):
        for motion in motions:
            self.move(self.moving[motion.id], motion)
'''


def sunder(*arguments: object, where: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([SUNDER, *map(str, arguments)], cwd=where, capture_output=True, text=True, timeout=1800, check=False)


def passes(case: unittest.TestCase, engine: str, cases: tuple[str, ...], where: Path) -> None:
    """Fails where a case of the suite fails or is skipped."""
    done = sunder("validate", "engines", "--rigid", engine, "--case", ",".join(cases), "--json", "rows.json", where=where)
    case.assertEqual(done.returncode, 0, done.stdout + done.stderr)
    (found,) = json.loads((where / "rows.json").read_text())["engines"].values()
    verdicts = {(row["name"].partition(".")[0], row["verdict"]) for row in found["cases"]}
    case.assertEqual(verdicts, {(name, "pass") for name in cases})


class Written(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.here = Path(temporary.name)
        done = sunder("engine", "new", "my_engine", where=self.here)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("--rigid ./my_engine", done.stdout)

    def test_it_passes_the_suite(self) -> None:
        passes(self, "./my_engine", QUICK, self.here)

    def test_it_takes_on_capabilities(self) -> None:
        text = (self.here / "my_engine").read_text()
        for old, new in (('"deterministic",', '"export_rows", "save_restore", "deterministic",'),
                         ("\n    def states", CACHES + "\n    def states")):
            self.assertIn(old, text)
            text = text.replace(old, new)
        (self.here / "more").write_text(text)
        (self.here / "more").chmod(0o755)
        passes(self, "./more", WITH_CACHES, self.here)

    def test_a_run_ends_as_with_the_exact_engine(self) -> None:
        hashes = []
        for engine in ("./my_engine", "freeflight"):
            out = self.here / Path(engine).name
            out = out.with_suffix(".run")
            done = sunder("run", TOP / "scenes" / "cut_pane.textproto", "--rigid", engine, "--until", "2e-3", "--out", out, "--quiet",
                          "--no-pictures", where=self.here)
            self.assertEqual(done.returncode, 0, done.stderr)
            hashes.append(json.loads((out / "run.json").read_text())["state_hash"])
        self.assertEqual(*hashes)

    def test_no_file_is_replaced_and_names_are_checked(self) -> None:
        before = (self.here / "my_engine").read_text()
        for arguments, says in ((["new", "my_engine"], "is there already"), (["new", "My-Engine"], "is no name of an engine"),
                                (["nwe", "x"], "did you mean"), (["new", "x", "--language", "cobol"], "none of python"),
                                (["new", "/proc/x"], "cannot write")):
            done = sunder("engine", *arguments, where=self.here)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(says, done.stderr)
        self.assertEqual((self.here / "my_engine").read_text(), before)


class Cpp(unittest.TestCase):
    def test_it_passes_the_suite(self) -> None:
        with tempfile.TemporaryDirectory() as folder:  # tests/CMakeLists.txt had it written and built
            passes(self, str(BUILD / "tests" / "written_engine" / "written_engine"), QUICK, Path(folder))

    def test_the_steps_that_it_names_lead_to_its_program(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            here = Path(name)
            done = sunder("engine", "new", "deep/mine", "--language", "cpp", where=here)
            self.assertEqual(done.returncode, 0, done.stderr)
            configure, build, validate, _ = [shlex.split(line) for line in done.stdout.splitlines()[1:]]
            self.assertIn(f"-DSUNDER_ENGINES={(here / 'deep' / 'mine').resolve()}", configure)
            self.assertEqual((configure[0], build[:2], validate[-1]), ("cmake", ["cmake", "--build"], "deep/mine/mine"))
            again = sunder("engine", "new", "deep/mine", "--language", "cpp", where=here)
            self.assertEqual(again.returncode, 2)
            self.assertIn("is there already", again.stderr)


class Node(unittest.TestCase):
    def test_it_passes_the_suite(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            here = Path(name)
            done = sunder("engine", "new", "my_engine", "--language", "node", where=here)
            if "Node.js" in done.stderr or "npm" in done.stderr:
                self.skipTest(f"no packages of Node.js here: {done.stderr}")  # they come from a registry
            self.assertIn("--rigid ./my_engine.mjs", done.stdout)
            passes(self, "./my_engine.mjs", QUICK, here)


class Balls(Engine):
    """Only spheres; `wrong` is what it makes of its states."""
    name, capabilities = "balls", ("spheres",)

    def __init__(self) -> None:
        self.held: list[Any] = []
        self.wrong: Callable[[list[Any]], Any] = lambda states: states

    def add(self, body: Any) -> None:
        self.held.append(self.state_of(body))

    def advance(self, window_s: float, predicted: Any, solved: Any) -> None:
        pass

    def states(self) -> Any:
        return self.wrong(self.held)


class Checks(unittest.TestCase):
    """What the session refuses beside the rules of the suite."""

    def setUp(self) -> None:
        self.engine = Balls()
        self.session = Session(self.engine)
        self.sent = 0
        self.ask(hello={"protocol_min": 2, "protocol_max": 2})

    def ask(self, **content: Any) -> Any:
        self.sent += 1
        reply = self.session.answer(exchange().Request(sequence=self.sent, **content).SerializeToString())
        return None if reply is None else exchange().Reply.FromString(reply)

    def body(self, number: int = 1, **changed: Any) -> dict[str, Any]:
        return {"id": number, "mass": 1.0, "principal_inertia": {"x": 1.0, "y": 1.0, "z": 1.0},
                "orientation": {"w": 1.0}, "sphere_radius_m": 0.1, **changed}

    def refused(self, kind: str, status: int, **content: object) -> None:
        reply = self.ask(**content)
        self.assertEqual((reply.error.kind, self.session.status), (kind, status), reply)

    def test_a_shape_that_is_not_declared(self) -> None:
        self.refused("bad_body", BAD_INPUT, load={"bodies": [self.body(sphere_radius_m=None, half_space=True)]})

    def test_bodies_that_cannot_be(self) -> None:
        wrong: list[dict[str, Any]] = [{"mass": 0.0}, {"principal_inertia": {"x": 1.0}}, {"sphere_radius_m": float("nan")}, {"id": 0}]
        for changed in wrong:
            self.setUp()
            self.refused("bad_message", PEER_LOST, load={"bodies": [self.body(**changed)]})

    def test_states_that_the_engine_may_not_give(self) -> None:
        def off(states: list[Any]) -> list[Any]:
            states[0].position.x = float("inf")
            return states

        for wrong in (lambda states: states[::-1], lambda states: states[:1], off):
            self.setUp()
            self.engine.wrong = wrong
            self.refused("engine_failed", ENGINE_FAILED, load={"bodies": [self.body(1), self.body(2)]})

    def test_states_of_other_bodies_are_named(self) -> None:
        due = [self.body(number, name=f"ball_{number}" if number != 13 else "") for number in range(1, 15)]
        of = "balls: states: {} for 14 bodies; {}; give one of each that moves, by ascending id"
        wrong: list[tuple[Callable[[list[Any]], Any], str, int]] = [
            (lambda s: [one for one in s if one.id != 12], of.format(13, "missing: id 12 'ball_12'"), 12),
            (lambda s: [one for one in s if one.id not in (13, 14)] + [exchange().BodyState(id=21)],
             of.format(13, "missing: id 13, 14 'ball_14'; surplus: id 21"), 13),
            (lambda s: [*s[:3], s[2], *s[3:]], of.format(15, "twice: id 3 'ball_3'"), 3),
            (lambda s: [*s[:5], s[6], s[5], *s[7:]], of.format(14, "out of order: id 6 'ball_6'"), 6),
            (lambda s: s[:3], of.format(3, "missing: id " + ", ".join(f"{k} 'ball_{k}'" for k in range(4, 13)) + " and 2 more"), 4)]
        for states, said, body in wrong:
            self.setUp()
            self.engine.wrong = states
            error = self.ask(load={"bodies": due}).error
            self.assertEqual((error.kind, error.message, error.body), ("engine_failed", said, body))

    def test_what_is_wrong_with_a_body_is_told_with_its_id(self) -> None:
        def off(states: list[Any]) -> list[Any]:
            states[0].orientation.w = 0.9
            return states

        self.engine.wrong = off
        error = self.ask(load={"bodies": [self.body(7, name="second")]}).error
        self.assertEqual((error.message, error.body),
                         ("balls: the state of body 7 'second': orientation has length 0.9, which must be 1", 7))
        self.setUp()
        self.assertEqual(self.ask(load={"bodies": [self.body(7, sphere_radius_m=None, half_space=True)]}).error.body, 7)

    def test_an_error_in_the_engine_is_told(self) -> None:
        self.engine.wrong = lambda states: 1 / 0
        self.refused("internal", ENGINE_FAILED, load={"bodies": [self.body()]})

    def test_a_failure_of_the_shell_has_no_reply(self) -> None:
        self.assertIsNone(self.ask(error={"kind": "unstable", "message": "it grows"}))
        self.assertEqual(self.session.status, PEER_LOST)
        self.assertIn("it grows", self.session.failure)

    def test_spans_where_hello_asks_for_them(self) -> None:
        self.session, self.sent = Session(self.engine), 0
        self.ask(hello={"protocol_min": 2, "protocol_max": 2, "trace": True})
        (span,) = self.ask(load={"bodies": [self.body()]}).spans
        self.assertEqual(span.name, "load")
        self.assertLessEqual(span.begin_ns, span.end_ns)


class OnTheWire(unittest.TestCase):
    def test_a_stranger_leaves_and_a_heartbeat_is_answered(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "link")
            wire = Wire(f"ipc://{path}")
            heard: list[bytes] = []
            server = threading.Thread(target=lambda: heard.append(wire.receive()))
            server.start()
            with socket.socket(socket.AF_UNIX) as stranger:
                stranger.connect(path)
                stranger.sendall(b"GET / HTTP/1.1\r\n" + bytes(64))
            with socket.socket(socket.AF_UNIX) as peer:
                peer.connect(path)
                peer.sendall(GREETING + bytes([4, len(READY)]) + READY + b"\x04\x0b\x04PING\x00\x00ctxt" + b"\x00\x05hello")
                server.join(60.0)
                self.assertEqual(heard, [b"hello"])
                came = b""
                while len(came) < len(GREETING) + 2 + len(READY) + 11:
                    came += peer.recv(1000)
                self.assertEqual(came[len(GREETING) + 2 + len(READY):], b"\x04\x09\x04PONGctxt")
            with self.assertRaisesRegex(Lost, "without a goodbye"):
                wire.receive()
            wire.close()
            self.assertEqual(os.listdir(folder), [])

    def test_a_limit_ends_the_wait_for_a_shell_and_without_one_only_the_parents_end_does(self) -> None:
        looks = iter([True, True, False])
        with tempfile.TemporaryDirectory() as folder:
            for k, (go_on, connect_s, why) in enumerate((
                    (lambda: True, LOOK_S, f"the shell process did not connect within {LOOK_S:g} s"),
                    (lambda: next(looks), math.inf, "the process that started this one is gone"))):
                wire = Wire(f"ipc://{folder}/{k}", go_on, connect_s)
                with self.assertRaisesRegex(Lost, why):
                    wire.receive()
                wire.close()
        self.assertEqual(list(looks), [])

    def test_an_address_that_others_can_reach_is_refused(self) -> None:
        with self.assertRaisesRegex(ValueError, "use ipc://PATH"):
            Wire("tcp://0.0.0.0:5555")


if __name__ == "__main__":
    unittest.main()
