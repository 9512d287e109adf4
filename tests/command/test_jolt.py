"""Sessions with the Jolt engine. Skipped where node or its packages are missing; sunder_tools.launch.node gets them."""
from __future__ import annotations

import os
import signal
import subprocess
import time
import unittest

import numpy as np

from .node_session import (PATIENCE_S, PROTOCOL, EngineCase, JointedEngine, Message, Session, ball, body, floor, program,
                           quaternion, rotate, slab, why_not, wxyz, xyz)

SILENCE_S = 0.8  # a silent peer is still waited for


class JoltCase(EngineCase):
    engine = "jolt"
    why_not = why_not("jolt")


class Engine(JointedEngine, JoltCase):
    momentum = 1e-6  # single precision
    joint_windows, joint_gap, joint_axis, joint_turn = 300, 2e-4, 1e-5, 1e-2

    def test_engine_holds_what_was_loaded(self) -> None:
        flight = self.flight([slab(1, (0.02, 0.01, 0.002), (0, 0, 1))])
        flight.window()
        mass = flight.bodies[1]["mass"]
        self.assertAlmostEqual(flight.states[1]["mass"], mass, delta=1e-6 * mass)  # what the shell's side asks for

    def test_ball_comes_to_rest_on_a_half_space(self) -> None:
        flight = self.flight([ball(1, 0.05, 1.0, (0.3, 0.1, 0.06)), floor(2)])
        flight.run(300)
        # from -slop, 0.05 mm, to the round-off of single precision
        self.assertAlmostEqual(flight.at(1)[2], 0.05, delta=5.1e-5)
        self.assertLess(float(np.linalg.norm(flight.at(1, "velocity"))), 1e-6)
        self.assertLess(float(np.linalg.norm(flight.at(1)[:2] - (0.3, 0.1))), 1e-6)

    def test_friction_stops_a_box(self) -> None:
        start = slab(1, (0.05, 0.05, 0.02), (0, 0, 0.02), velocity=(1, 0, 0))
        flight = self.flight([start, floor(2)], laws=[{"friction": 0.5}])
        flight.run(300)
        self.assertLess(float(np.linalg.norm(flight.at(1, "velocity"))), 1e-6)
        # v^2 / (2 mu g), and up to one window's way for where the last one ends
        self.assertAlmostEqual(flight.at(1)[0], 1 / (2 * 0.5 * 9.81), delta=1e-3)

    def test_thin_shards_fall_flat_and_keep_their_thickness(self) -> None:
        for parts in (0, 1, 3):
            shard = slab(1, (0.02, 0.013, 0.0015), (0, 0, 0.03), parts=parts, orientation=(1, 0.5, 0.3, 0.1))
            flight = self.flight([shard, floor(2)])
            flight.run(500)
            self.assertAlmostEqual(flight.at(1)[2], 0.0015, delta=6e-5, msg=f"{parts} parts")  # slop
            self.assertLess(float(np.linalg.norm(flight.at(1, "velocity"))), 1e-3)
            up = rotate(quaternion(flight.states[1]["orientation"]), np.array([0, 0, 1]))
            self.assertGreater(abs(up[2]), 1 - 1e-4)

    def test_thin_plates_stack(self) -> None:
        plates = [slab(i + 1, (0.05, 0.04, 0.0015), (0.2, 0.1, 0.0015 + 0.003 * i), parts=1) for i in range(12)]
        flight = self.flight([*plates, floor(99)])
        flight.run(200)
        for i in range(12):
            # of the whole stack: 0.06 mm at 20 iterations; without warm starts it sinks by millimetres
            self.assertAlmostEqual(flight.at(i + 1)[2], 0.0015 + 0.003 * i, delta=3e-4)

    def test_fast_shards_do_not_pass_through_a_plate(self) -> None:
        plate = {**slab(1, (1, 1, 0.002), (0, 0, -0.002)), "is_static": True}
        # 20 mm a window: without casts most of them are never seen to touch
        shards = [slab(i + 2, (0.003, 0.002, 0.001), (0.05 * i, 0, 0.05 + 0.0025 * i), velocity=(0, 0, -20),
                       orientation=(1, 0.3 * i, 0.2 * (i % 3), 0.1)) for i in range(8)]
        flight = self.flight([plate, *shards])
        flight.run(100)
        for i in range(8):
            self.assertGreater(flight.at(i + 2)[2], 0.0)

    def test_newborn_neighbours_gain_no_energy(self) -> None:
        # overlapping by 0.2 mm, born at the end of a window
        shards = [slab(i + 10, (0.0101, 0.0101, 0.002), (0.02 * i, 0, 1), parts=1) for i in range(4)]
        flight = self.flight([ball(1, 0.01, 0.1, (0, 0, 3))], gravity=0.0)
        flight.window(births=shards)
        self.assertEqual(sorted(flight.states), [1, 10, 11, 12, 13])
        flight.run(100)
        for i in range(4):
            self.assertLess(float(np.linalg.norm(flight.at(i + 10, "velocity"))), 1e-6)
            self.assertLess(float(np.linalg.norm(flight.at(i + 10) - (0.02 * i, 0, 1))), 0.5e-3)

    def test_solved_bodies_touch_nothing(self) -> None:
        flight = self.flight([ball(1, 0.05, 1.0, (0, 0, 0.06)), ball(3, 0.05, 1.0, (1, 0, 0.06)), floor(2)])
        for _ in range(200):
            flight.window(solved=[1])
        self.assertLess(flight.at(1)[2], 0.0)
        self.assertGreater(flight.at(3)[2], 0.049)
        flight.run(1)  # and no longer than they are named
        self.assertGreater(flight.at(1, "velocity")[2], -1.0)

    def test_same_requests_give_the_same_bits(self) -> None:
        def states() -> dict[int, Message]:
            shards = [slab(i + 2, (0.012, 0.009, 0.002), (0.02 * (i % 4), 0.02 * (i // 4), 0.02 + 0.005 * (i % 3)), parts=1 + i % 2,
                           velocity=(0.1 * (i % 5), -0.2, -2), orientation=(1, 0.1 * i, 0.2, -0.1 * (i % 3))) for i in range(16)]
            self.sessions = None  # in a process of its own
            flight = self.flight([floor(1), *shards])
            flight.run(100)
            return flight.states
        self.assertEqual(states(), states())


class Refusals(JoltCase):
    LOAD: Message = {"load": {"bodies": [ball(1, 0.1, 2.0, (0, 0, 0))]}}
    BACK: Message = {"id": 1, "position": xyz((0, 0, 0)), "orientation": wxyz(np.array([1, 0, 0, 0])),
                     "velocity": xyz((0, 0, 0)), "angular_momentum": xyz((0, 0, 0))}

    def window(self, back: Message | None = None, **more: object) -> Message:
        return {"window": {"tick": 0, "ticks": 2, "window_s": 1e-3, "predicted": [{**self.BACK, **(back or {})}], **more}}

    def load(self, **more: object) -> Message:
        return {"load": {"bodies": [{**self.LOAD["load"]["bodies"][0], **more}]}}

    def check(self, requests: list[Message], says: str, status: int) -> None:
        with self.subTest(says):
            sessions = self.anew()
            *before, last = requests
            for request in before:
                reply = sessions.ask(request)
                self.assertEqual(reply["ends_with"], 0, reply)
            told = sessions.ask(last)
            self.assertEqual((told["kind"], told["ends_with"]), ("error", status), told)
            self.assertIn(says, told["error"]["message"])
            if status == 3:
                self.assertEqual(told["error"]["kind"], "bad_message")
            else:
                self.assertEqual(told["error"]["body"], 1)

    def test_out_of_turn(self) -> None:
        load, window = self.LOAD, self.window()
        cases: list[tuple[list[Message], str]] = [
            ([load], "before Hello"), ([PROTOCOL, PROTOCOL], "second Hello"), ([PROTOCOL, window], "Window before Load"),
            ([PROTOCOL, load, load], "second Load"), ([PROTOCOL, {}], "without content"),
            ([{"hello": {"protocol_min": 3, "protocol_max": 4}}], "protocol 3 to 4"),
            ([PROTOCOL, {"export": {}}], "Export before Load"),
            ([{**PROTOCOL, "sequence": 5}], "request 5, expected 1"),
            ([PROTOCOL, load, self.window(tick=7)], "window at tick 7"),
            ([PROTOCOL, load, self.window(ticks=0)], "window at tick 0 (+0)"),
            ([PROTOCOL, load, self.window(again=True)], "window.again"),
            ([PROTOCOL, {"load": {"keep_windows": True}}], "keep_windows: the engine cannot do 'save_restore'"),
            ([PROTOCOL, load, {"export": {}}], "Export: the engine cannot do 'export_rows'"),
            ([PROTOCOL, load, {"save": {}}], "Save: the engine cannot do 'save_restore'"),
            ([PROTOCOL, load, {"restore": {}}], "Restore: the engine cannot do 'save_restore'"),
            ([PROTOCOL, load, {"add_bodies": {}}], "AddBodies: the engine cannot do 'save_restore'"),
            # field 15, a message of no bytes: a request of some later protocol, sequence 2
            ([PROTOCOL, {"raw": "\x08\x02\x7a\x00"}], "a kind that is not known here"),
            ([PROTOCOL, load, self.window({"id": 9})], "predicted state of body 1: is missing"),
            ([PROTOCOL, load, {"window": {**window["window"], "predicted": []}}], "predicted state of body 1: is missing"),
            ([PROTOCOL, load, {"window": {**window["window"], "predicted": [self.BACK, {**self.BACK, "id": 9}]}}],
             "predicted state of body 9: names no moving body"),
            ([PROTOCOL, load, self.window(solved=[9])], "solved[9]: there is no such body"),
            ([PROTOCOL, load, self.window(births=[ball(1, 1, 1, (0, 0, 0))])], "births[1]: comes twice, or is held already"),
            ([PROTOCOL, {"load": {"tick": -1}}], "load.tick is -1"),
            ([{"raw": "\xff\xff\xff not a request"}], "no request")]
        for requests, says in cases:
            self.check(requests, says, 3)

    def test_out_of_range(self) -> None:
        load = self.LOAD
        nan = xyz((0, 0, 0)) | {"y": "NaN"}
        joint: Message = {"id": 1, "kind": 1, "first": 1, "first_frame": {"orientation": {"w": 1}}, "second_frame": {"orientation": {"w": 1}}}
        bodies = load["load"]["bodies"]
        cases: list[tuple[list[Message], str]] = [
            ([PROTOCOL, load, self.window(window_s="NaN")], "window_s is NaN"),
            ([PROTOCOL, load, self.window(window_s=-1)], "window_s is -1"),
            ([PROTOCOL, load, self.window({"position": nan})], "predicted[id 1].position is (0, NaN, 0)"),
            ([PROTOCOL, load, self.window({"angular_momentum": {"x": "Infinity"}})], "predicted[id 1].angular_momentum"),
            ([PROTOCOL, load, self.window({"orientation": {"w": 1, "x": 0.1}})], "orientation"),
            ([PROTOCOL, load, self.window({"orientation": {"w": "NaN"}})], "orientation"),
            ([PROTOCOL, load, {"window": {**self.window()["window"], "predicted": [self.BACK, self.BACK]}}], "out of order"),
            ([PROTOCOL, load, self.window(solved=[2, 1])], "solved[1]"),
            ([PROTOCOL, load, self.window(released=[2, 1])], "released[1]"),
            ([PROTOCOL, load, self.window(released=[1])], "released[1]: there is no such joint"),
            ([PROTOCOL, load, self.window(births=[{}])], "births[0].id is 0"),
            ([PROTOCOL, self.load(mass=0)], "mass 0"),
            ([PROTOCOL, self.load(mass="NaN")], "mass NaN"),
            ([PROTOCOL, self.load(principal_inertia=xyz((1, 0, 1)))], "inertia must be positive"),
            ([PROTOCOL, self.load(sphere_radius_m=-1)], "sphere_radius_m is -1"),
            ([PROTOCOL, self.load(name="x" * 256)], "name has 256 bytes"),
            ([PROTOCOL, {"load": {"bodies": [bodies[0], bodies[0]]}}], "comes twice"),
            ([PROTOCOL, {"load": {"bodies": [body(1, {}, 1, (1, 1, 1), (0, 0, 0))]}}], "has no shape"),
            ([PROTOCOL, {"load": {"bodies": [body(1, {"convex": {"parts": [{"corners": [0] * 11}]}}, 1, (1, 1, 1), (0, 0, 0))]}}],
             "11 coordinates"),
            ([PROTOCOL, {"load": {"contacts": [{"friction": -1}]}}], "friction is -1"),
            ([PROTOCOL, {"load": {"contacts": [{"restitution": "NaN"}]}}], "restitution is NaN"),
            ([PROTOCOL, {"load": {"bodies": bodies, "joints": [{**joint, "kind": 0}]}}], "kind is 0"),
            ([PROTOCOL, {"load": {"bodies": bodies, "joints": [{**joint, "second": 9}]}}], "between bodies 1 and 9"),
            ([PROTOCOL, {"load": {"bodies": bodies, "joints": [{**joint, "first_frame": {}}]}}], "first_frame")]
        for requests, says in cases:
            self.check(requests, says, 3)

    def test_what_the_engine_cannot(self) -> None:
        flat = {"convex": {"parts": [{"corners": [0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0]}]}}
        for requests, says in (
                ([PROTOCOL, {"load": {"bodies": [body(1, flat, 1, (1, 1, 1), (0, 0, 0))]}}], "is no hull"),
                ([PROTOCOL, {"load": {"bodies": [body(1, {"half_space": True}, 1, (1, 1, 1), (0, 0, 0))]}}], "half space that moves")):
            self.check(requests, says, 2)

    def test_a_server_says_so_and_ends_with_the_status(self) -> None:
        for requests, says, status in (([PROTOCOL, self.LOAD, self.window(tick=7)], "bad_message: window at tick 7", 3),
                                       ([PROTOCOL, self.load(half_space=True)], "bad_body: body 1", 2)):
            session = Session(self, "jolt")
            replies = [session.ask(request) for request in requests]
            self.assertEqual(replies[-1]["kind"], "error")
            ended, said = session.ended()
            self.assertEqual(ended, status)
            self.assertIn(says, said)

    def test_arguments(self) -> None:
        cases: list[tuple[list[str], str]] = [
            ([], "--endpoint is missing"), (["--fast"], "--fast: unknown option"), (["--engine"], "no value"),
            (["--endpoint", "tcp://192.0.2.1:5555"], "use ipc://PATH"), (["--endpoint", "ipc:///nowhere/at/all"], "bad_endpoint"),
            (["--endpoint", "ipc:///" + 107 * "x"], "its path has 108 bytes, a socket's at most 107")]
        for arguments, says in cases:
            done = subprocess.run([program("jolt"), *arguments], capture_output=True, text=True, timeout=PATIENCE_S,
                                  check=False)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(says, done.stderr)


class Peers(JoltCase):
    def test_goodbye_ends_with_0(self) -> None:
        session = Session(self, "jolt")
        hello = session.ask(PROTOCOL)["hello"]
        self.assertEqual((hello["engine_name"], hello["protocol"], hello["scene_hash"]), ("jolt", 2, "aGFzaA=="))
        self.assertIn("convex_hulls", hello["capabilities"])
        self.assertNotIn("double_precision", hello["capabilities"])
        self.assertEqual(session.ask(Refusals.LOAD)["load"]["states"][0]["id"], 1)
        self.assertEqual(session.ask({"bye": {}})["kind"], "bye")
        self.assertEqual(session.ended(), (0, ""))

    def test_spans_where_hello_asks_for_them(self) -> None:
        session = Session(self, "jolt")
        session.ask({"hello": {**PROTOCOL["hello"], "trace": True}})
        spans = session.ask(Refusals.LOAD)["spans"]
        self.assertEqual([s["name"] for s in spans], ["decode", "load"])
        self.assertTrue(all(0 < s["begin_ns"] <= s["end_ns"] for s in spans))

    def test_a_shell_that_failed_is_not_answered(self) -> None:
        session = Session(self, "jolt")
        session.ask(PROTOCOL)
        session.tell({"silent": {"error": {"kind": "ledger", "message": "it does not close"}}})
        status, said = session.ended()
        self.assertEqual(status, 3)
        self.assertIn("peer_failed: the shell process reports: it does not close", said)

    def test_a_peer_that_is_killed_is_lost(self) -> None:
        session = Session(self, "jolt")
        session.ask(PROTOCOL)
        session.client.send_signal(signal.SIGKILL)
        status, said = session.ended()
        self.assertEqual(status, 3, said)
        self.assertIn("without a goodbye", said)

    def test_a_peer_that_is_stopped_is_waited_for(self) -> None:
        session = Session(self, "jolt")
        session.ask(PROTOCOL)
        session.client.send_signal(signal.SIGSTOP)
        time.sleep(3 * SILENCE_S)
        session.client.send_signal(signal.SIGCONT)
        self.assertEqual(session.ask({"bye": {}})["kind"], "bye")
        self.assertEqual(session.ended()[0], 0)

    def test_who_computes_for_long_is_not_lost(self) -> None:
        # Boxes in one place, of more and more parts until a window takes longer than a silent peer is waited for.
        for parts in (8, 12, 18, 27):
            heap = [slab(i + 1, (0.05 + 1e-4 * i, 0.04, 0.03), (1e-4 * i, 0, 0), parts=parts) for i in range(60)]
            session = Session(self, "jolt")
            session.ask(PROTOCOL)
            session.ask({"load": {"bodies": heap}})
            keys = ("id", "position", "orientation", "velocity", "angular_momentum")
            window = {"ticks": 1, "window_s": 1e-3, "predicted": [{k: b[k] for k in keys} for b in heap]}
            start = time.monotonic()
            reply = session.ask({"window": window})
            took = time.monotonic() - start
            self.assertEqual(reply.get("kind"), "window", reply)
            self.assertEqual(session.ask({"bye": {}})["kind"], "bye")
            self.assertEqual(session.ended()[0], 0)
            if took > 2 * SILENCE_S:
                return
        self.skipTest(f"the longest window took {took} s")

    def test_dies_with_its_parent(self) -> None:
        # the parent says its child's number, and waits
        parents_words = "import subprocess, sys\np = subprocess.Popen(sys.argv[1:])\nprint(p.pid, flush=True)\np.wait()\n"
        parent = subprocess.Popen(["/usr/bin/python3", "-c", parents_words, program("jolt"), "--die-with-parent",
                                   "--endpoint", "ipc:///tmp/none"], stdout=subprocess.PIPE, text=True)
        self.addCleanup(parent.communicate)
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        time.sleep(1.0)  # it looks for its parent from then on
        parent.kill()
        end = time.monotonic() + PATIENCE_S
        while os.path.exists(f"/proc/{child}") and not self.is_zombie(child):
            self.assertLess(time.monotonic(), end, "it lives on")
            time.sleep(0.05)

    @staticmethod
    def is_zombie(pid: int) -> bool:
        try:
            with open(f"/proc/{pid}/stat", encoding="ascii") as stat:
                return stat.read().rpartition(")")[2].split()[0] == "Z"
        except OSError:
            return True


if __name__ == "__main__":
    unittest.main()
