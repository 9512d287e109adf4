"""Sessions with the engine of DART. Skipped where it is not built: `sunder run SCENE --rigid dart` installs and builds it."""
from __future__ import annotations

import subprocess
import tempfile
import unittest
from pathlib import Path

from typing import Any

import numpy as np
from google.protobuf import json_format

from sunder_engine.messages import exchange, parsed
from sunder_engine.wire import Caller
from sunder_tools.launch.build import DART, build_dir

from . import REPOSITORY
from .node_session import (PATIENCE_S, PROTOCOL, DoubleEngine, EngineCase, Message, ball, body, floor, quaternion, rotate, slab,
                           xyz)

PROGRAM = build_dir() / "rigid" / DART
SLACK_M = 5e-6  # overlap that stays


WHY_NOT = "" if PROGRAM.is_file() else (f"there is no {PROGRAM.name}: libdart-dev draws in 245 MB, so it comes on request: "
                                        "coupler/sunder run scenes/cut_pane.textproto --rigid dart")


def plain(message: Any) -> Message:
    """A message as the client of the other engines has it: numbers at their defaults, of a oneof what is set."""
    def value(field: Any, found: Any) -> Any:
        return plain(found) if field.type == field.TYPE_MESSAGE else found
    out: Message = {}
    for field in message.DESCRIPTOR.fields:
        found = getattr(message, field.name)
        if field.label == field.LABEL_REPEATED:
            out[field.name] = [value(field, one) for one in found]
        elif field.type != field.TYPE_MESSAGE or message.HasField(field.name):
            out[field.name] = value(field, found)
    return out


class Session:
    """An engine's process, and the shell's side of a session with it."""

    def __init__(self, case: unittest.TestCase) -> None:
        temporary = tempfile.TemporaryDirectory()
        case.addCleanup(temporary.cleanup)
        endpoint = f"ipc://{temporary.name}/socket"
        self.engine = subprocess.Popen([PROGRAM, "--endpoint", endpoint], stderr=subprocess.PIPE, text=True)
        self.caller = Caller(endpoint, lambda: self.engine.poll() is None)
        self.sequence = 0
        case.addCleanup(self.end)

    def end(self) -> None:
        self.caller.close()
        if self.engine.poll() is None:
            self.engine.kill()
        self.engine.communicate()

    def ask(self, request: Message) -> Message:
        self.sequence += 1
        self.caller.send(json_format.ParseDict({"sequence": self.sequence, **request}, exchange().Request()).SerializeToString())
        reply = parsed("Reply", self.caller.receive())
        assert reply.sequence == self.sequence
        return {"kind": reply.WhichOneof("kind"), **plain(reply)}

    def ended(self) -> tuple[int, str]:
        """Exit status of the engine's process, and what it said."""
        _, said = self.engine.communicate(timeout=PATIENCE_S)
        return self.engine.returncode, said


class DartCase(EngineCase):
    engine = "dart"
    why_not = WHY_NOT

    def anew(self) -> Session:  # type: ignore[override]
        return Session(self)


class Engine(DoubleEngine, DartCase):
    momentum = 1e-12

    def test_engine_says_what_it_is(self) -> None:
        session = self.anew()
        hello = session.ask(PROTOCOL)["hello"]
        self.assertEqual((hello["engine_name"], hello["protocol"], hello["scene_hash"]), ("dart", 2, b"hash"))
        self.assertRegex(hello["engine_version"], r"^6\.1[23]\.\d+$")
        self.assertIn("mass_ratios", hello["capabilities"])
        session.ask({"load": {"bodies": [ball(1, 0.1, 2.0, (0, 0, 0))]}})
        self.assertEqual(session.ask({"bye": {}})["kind"], "bye")
        self.assertEqual(session.ended(), (0, ""))
        self.assertEqual(subprocess.run([PROGRAM, "--check"], check=False).returncode, 0)

    def test_tiny_shards_are_solved_as_large_ones_are(self) -> None:
        # the library checks its matrix to a fixed 1e-6: a plate of 2.4 ng and one of 2400 kg fall alike
        for size in (1e-3, 10.0):
            plate = slab(1, np.array((0.1, 0.08, 0.015)) * size, (0, 0, 0.15 * size), orientation=(1, 0.3, 0.2, 0.1))
            flight = self.flight([plate, floor(2)], gravity=-9.81 * size)
            flight.run(900)
            self.assertAlmostEqual(flight.at(1)[2], 0.015 * size, delta=2 * SLACK_M)
            self.assertLess(float(np.linalg.norm(flight.at(1, "velocity"))), 1e-3 * size)

    def test_sliding_bodies_stop_by_coulombs_law(self) -> None:
        start = slab(1, (0.05, 0.05, 0.002), (0, 0, 0.002), velocity=(0.6, 0.8, 0))
        flight = self.flight([start, floor(2)], laws=[{"friction": 0.5}])
        flight.run(300)
        self.assertLess(float(np.linalg.norm(flight.at(1, "velocity"))), 1e-6)
        # v^2 / (2 mu g) along the slip, and up to one window's way for where the last one ends
        way = 1 / (2 * 0.5 * 9.81)
        self.assertLess(float(np.linalg.norm(flight.at(1)[:2] - way * np.array((0.6, 0.8)))), 1.2e-3)

    def test_shards_fall_flat_in_a_heap_and_none_below_the_floor(self) -> None:
        half = (0.02, 0.013, 0.0015)
        shards = [slab(i + 1, half, (0.012 * (i % 4), 0.011 * (i % 3), 0.03 + 0.012 * i), parts=1 + i % 3,
                       orientation=(1, 0.2 * (i % 5), 0.3 - 0.1 * i, 0.1)) for i in range(12)]
        flight = self.flight([*shards, floor(99)])
        flight.run(1500)
        corners = [np.array((x, y, z)) * half for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        for i in range(12):
            q = quaternion(flight.states[i + 1]["orientation"])
            lowest = min((flight.at(i + 1) + rotate(q, corner))[2] for corner in corners)
            self.assertGreater(lowest, -1e-4, f"shard {i + 1}")
            self.assertLess(float(np.linalg.norm(flight.at(i + 1, "velocity"))), 0.01, f"shard {i + 1}")

    def test_thin_plates_stack(self) -> None:
        plates = [slab(i + 1, (0.05, 0.04, 0.0015), (0.2, 0.1, 0.0015 + 0.003 * i), parts=1) for i in range(12)]
        flight = self.flight([*plates, floor(99)])
        flight.run(200)
        for i in range(12):
            self.assertAlmostEqual(flight.at(i + 1)[2], 0.0015 + 0.003 * i, delta=1e-5 * (i + 1))

    def test_same_requests_give_the_same_bits(self) -> None:
        def states() -> dict[int, Message]:
            shards = [slab(i + 2, (0.012, 0.009, 0.002), (0.02 * (i % 4), 0.02 * (i // 4), 0.02 + 0.005 * (i % 3)), parts=1 + i % 2,
                           velocity=(0.1 * (i % 5), -0.2, -2), orientation=(1, 0.1 * i, 0.2, -0.1 * (i % 3))) for i in range(16)]
            flight = self.flight([floor(1), *shards])
            flight.run(60)
            return flight.states
        self.assertEqual(states(), states())


class Refusals(DartCase):
    def test_what_the_engine_cannot(self) -> None:
        flat: dict[str, Any] = {"convex": {"parts": [{"corners": [0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0]}]}}
        for shape, says in ((flat, "must enclose some; leave flat parts out"), ({"half_space": True}, "half space that moves")):
            session = self.anew()
            session.ask(PROTOCOL)
            reply = session.ask({"load": {"bodies": [body(1, shape, 1, (1, 1, 1), (0, 0, 0))]}})
            self.assertEqual((reply["kind"], reply["error"]["kind"]), ("error", "bad_body"))
            self.assertIn(says, reply["error"]["message"])
            self.assertEqual(session.ended()[0], 2)


    def test_masses_that_no_number_holds_together(self) -> None:
        bodies = [ball(1, 0.1, 1e250, (0, 0, 0.3)), ball(2, 0.1, 1e-250, (0, 0, 0.1)), floor(3)]
        session = self.anew()
        session.ask(PROTOCOL)
        session.ask({"load": {"bodies": bodies}})
        keys = ("id", "orientation", "angular_momentum")
        fallen = [{**{k: b[k] for k in keys}, "position": xyz((0, 0, z)), "velocity": xyz((0, 0, -1))}
                  for b, z in zip(bodies, (0.29, 0.09))]
        reply = session.ask({"window": {"ticks": 1, "window_s": 1e-2, "predicted": fallen}})
        self.assertEqual((reply["kind"], reply["error"]["kind"]), ("error", "engine"))
        self.assertIn("bodies of 1e-250 and 1e+250 kg meet in a group of 2; dart holds ratios below 5e+15", reply["error"]["message"])
        self.assertEqual(session.ended()[0], 4)


class ARun(unittest.TestCase):
    @unittest.skipIf(WHY_NOT, WHY_NOT)
    def test_a_scene_runs_with_it(self) -> None:
        with tempfile.TemporaryDirectory() as out:
            done = subprocess.run([REPOSITORY / "coupler" / "sunder", "run", "scenes/cut_pane.textproto", "--rigid", "dart", "--until",
                                   "3e-3", "--out", Path(out) / "run", "--no-pictures"], cwd=REPOSITORY, capture_output=True,
                                  text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn('"dart"', (Path(out) / "run" / "run.json").read_text())


if __name__ == "__main__":
    unittest.main()
