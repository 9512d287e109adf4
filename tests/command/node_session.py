"""A session with an engine under Node.js for tests: the server, tests/rigid/node_client.mjs, and bodies that fly freely."""
from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import REPOSITORY

CLIENT = REPOSITORY / "tests" / "rigid" / "node_client.mjs"
PATIENCE_S = 1800.0  # after which a process hangs, whatever else the machine does

Message = dict[str, Any]
PROTOCOL: Message = {"hello": {"protocol_min": 2, "protocol_max": 2, "scene_hash": "aGFzaA=="}}


def program(engine: str) -> Path:
    return REPOSITORY / "rigid" / engine / f"sunder-rigid-{engine}"


def why_not(engine: str) -> str:
    """Why the engine cannot run here; '' if it can."""
    if not shutil.which("node"):
        return "there is no node"
    check = subprocess.run([program(engine), "--check"], capture_output=True, text=True, check=False)
    return check.stderr.strip() if check.returncode else ""


def xyz(v: Any) -> Message:
    return dict(zip("xyz", map(float, v)))


def vector(v: Message) -> np.ndarray:
    return np.array([v["x"], v["y"], v["z"]])


def quaternion(q: Message) -> np.ndarray:
    return np.array([q["w"], q["x"], q["y"], q["z"]])


def wxyz(q: np.ndarray) -> Message:
    return dict(zip("wxyz", map(float, q)))


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    u, v = a[1:], b[1:]
    return np.array([a[0] * b[0] - u @ v, *(a[0] * v + b[0] * u + np.cross(u, v))])


def rotate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return multiply(multiply(q, np.array([0.0, *v])), q * [1, -1, -1, -1])[1:]


def turn(v: np.ndarray) -> np.ndarray:
    angle = float(np.linalg.norm(v))
    return np.array([np.cos(angle / 2), *(np.sinc(angle / 2 / np.pi) / 2 * v)])


def body(number: int, shape: Message, mass: float, inertia: Any, position: Any, velocity: Any = (0, 0, 0),
         orientation: Any = (1, 0, 0, 0), momentum: Any = (0, 0, 0), group: int = 0) -> Message:
    q = np.array(orientation, float)
    return {"id": number, "name": f"body {number}", "mass": mass, "principal_inertia": xyz(inertia),
            "position": xyz(position), "orientation": wxyz(q / np.linalg.norm(q)), "velocity": xyz(velocity),
            "angular_momentum": xyz(momentum), "contact_group": group, **shape}


def ball(number: int, radius: float, mass: float, position: Any, velocity: Any = (0, 0, 0)) -> Message:
    return body(number, {"sphere_radius_m": radius}, mass, [0.4 * mass * radius**2] * 3, position, velocity)


def slab(number: int, half: Any, position: Any, parts: int = 0, **more: Any) -> Message:
    """Of glass: a box or, with `parts`, so many convex parts side by side along x."""
    half = np.array(half, float)
    mass = 2500 * 8 * float(half.prod())
    inertia = mass / 3 * (half @ half - half**2)
    shape: Message = {"box_half_size_m": xyz(half)}
    if parts:
        edges = np.linspace(-half[0], half[0], parts + 1)
        shape = {"convex": {"parts": [
            {"corners": [float(c) for x in edges[i:i + 2] for y in (-1, 1) for z in (-1, 1)
                         for c in (x, y * half[1], z * half[2])]} for i in range(parts)]}}
    return body(number, shape, mass, inertia, position, **more)


def floor(number: int) -> Message:
    return {**body(number, {"half_space": True}, 0, (0, 0, 0), (0, 0, 0)), "is_static": True}


class Sessions:
    """Sessions one after the other within the client's process; ends it, whatever the test did."""

    def __init__(self, case: unittest.TestCase, engine: str, *endpoint: str) -> None:
        self.client = subprocess.Popen(["node", CLIENT, engine, *endpoint], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                       text=True)
        case.addCleanup(self._end, self.client)

    @staticmethod
    def _end(process: subprocess.Popen[str]) -> None:
        if process.poll() is None:
            process.kill()
        process.communicate()

    def tell(self, request: Message) -> None:
        assert self.client.stdin is not None
        print(json.dumps(request), file=self.client.stdin, flush=True)

    def ask(self, request: Message) -> Message:
        assert self.client.stdout is not None
        self.tell(request)
        line = self.client.stdout.readline()
        assert line, "the client has ended"
        return json.loads(line)


class Session(Sessions):
    """A server of its own and its client."""

    def __init__(self, case: unittest.TestCase, engine: str) -> None:
        temporary = tempfile.TemporaryDirectory()
        case.addCleanup(temporary.cleanup)
        endpoint = f"ipc://{temporary.name}/socket"
        self.server = subprocess.Popen([program(engine), "--endpoint", endpoint], stderr=subprocess.PIPE, text=True)
        case.addCleanup(self._end, self.server)
        super().__init__(case, engine, endpoint)

    def ended(self) -> tuple[int, str]:
        """Exit status of the server, and what it said."""
        _, said = self.server.communicate(timeout=PATIENCE_S)
        return self.server.returncode, said


class Flight:
    """The bodies of a session, which fly freely under gravity to their predicted states."""

    def __init__(self, session: Sessions, bodies: list[Message], window_s: float = 1e-3, gravity: float = -9.81,
                 laws: list[Message] | None = None, joints: list[Message] | None = None) -> None:
        self.session, self.window_s, self.gravity, self.tick = session, window_s, np.array([0, 0, gravity]), 0
        self.bodies = {b["id"]: b for b in bodies}
        assert session.ask(PROTOCOL)["kind"] == "hello"
        reply = session.ask({"load": {"bodies": bodies, "contacts": laws or [], "joints": joints or []}})
        assert reply["kind"] == "load", reply
        self.states = self.by_id(reply["load"]["states"])

    @staticmethod
    def by_id(states: list[Message]) -> dict[int, Message]:
        return {s["id"]: s for s in states}

    def spin(self, number: int, q: np.ndarray, momentum: np.ndarray) -> np.ndarray:
        inverse = q * [1, -1, -1, -1]
        return rotate(q, rotate(inverse, momentum) / vector(self.bodies[number]["principal_inertia"]))

    def predicted(self) -> list[Message]:
        out, h = [], self.window_s
        for number, s in sorted(self.states.items()):
            v, q, momentum = vector(s["velocity"]), quaternion(s["orientation"]), vector(s["angular_momentum"])
            end = v + h * self.gravity
            middle = multiply(turn(h / 2 * self.spin(number, q, momentum)), q)
            q = multiply(turn(h * self.spin(number, middle / np.linalg.norm(middle), momentum)), q)
            out.append({"id": number, "position": xyz(vector(s["position"]) + h / 2 * (v + end)),
                        "orientation": wxyz(q / np.linalg.norm(q)), "velocity": xyz(end), "angular_momentum": xyz(momentum)})
        return out

    def window(self, **more: Any) -> list[Message]:
        """One window; returns its predicted states."""
        predicted = self.predicted()
        reply = self.session.ask({"window": {"tick": self.tick, "ticks": 3, "window_s": self.window_s,
                                             "predicted": predicted, **more}})
        assert reply["kind"] == "window", reply
        self.tick += 3
        assert reply["window"]["tick"] == self.tick
        for b in more.get("births", []):
            self.bodies[b["id"]] = b
        self.states = self.by_id(reply["window"]["states"])
        return predicted

    def run(self, windows: int) -> None:
        for _ in range(windows):
            self.window()

    def at(self, number: int, what: str = "position") -> np.ndarray:
        return vector(self.states[number][what])


class EngineCase(unittest.TestCase):
    """Tests of one engine, skipped where it cannot run."""
    engine = ""
    why_not = ""
    sessions: Sessions | None = None

    def setUp(self) -> None:
        if self.why_not:
            self.skipTest(self.why_not)

    def anew(self) -> Sessions:
        """The one client of a test, in a new session."""
        if self.sessions is None:
            self.sessions = Sessions(self, self.engine)
        else:
            self.sessions.tell({"anew": True})
        return self.sessions

    def flight(self, bodies: list[Message], **more: Any) -> Flight:
        return Flight(self.anew(), bodies, **more)


if TYPE_CHECKING:
    Mixed = EngineCase
else:
    Mixed = object  # as a test case it would run by itself, without an engine


class AnyEngine(Mixed):
    """What every engine does that these tests speak with. `momentum`: round-off of a momentum of the order of 1 kg m/s."""
    momentum = 0.0

    def test_what_nothing_touches_comes_back_to_the_bit(self) -> None:
        shard = slab(7, (0.02, 0.013, 0.0015), (0.1, -0.2, 5.0), parts=2, velocity=(1 / 3, 2, 3))
        # 4000 rad/s turns four radians a window
        for spin in (3.0, 4000.0):
            shard["angular_momentum"] = xyz(spin * vector(shard["principal_inertia"]) * (0.3, 0.5, 0.8))
            flight = self.flight([shard, floor(1)])
            for _ in range(50):
                motion, = flight.window()
                state = flight.states[7]
                self.assertEqual({key: state[key] for key in motion}, motion)

    def test_balls_part_by_their_restitution_and_keep_momentum(self) -> None:
        for restitution in (0.0, 0.4, 1.0):
            flight = self.flight([ball(1, 0.05, 0.3, (0, 0, 0), (2, 0, 0)), ball(2, 0.03, 0.7, (0.1013, 0, 0), (-1.1, 0, 0))],
                                 gravity=0.0, laws=[{"friction": 0.3, "restitution": restitution}])
            flight.run(60)
            a, b = flight.at(1, "velocity")[0], flight.at(2, "velocity")[0]
            self.assertAlmostEqual(b - a, restitution * 3.1, delta=1e-6)
            self.assertAlmostEqual(0.3 * a + 0.7 * b, 0.3 * 2.0 - 0.7 * 1.1, delta=self.momentum)

    def test_laws_belong_to_pairs_of_groups(self) -> None:
        def hop(group: int) -> float:
            dropped = ball(1, 0.05, 1.0, (0, 0, 0.051), (0, 0, -1))
            flight = self.flight([{**dropped, "contact_group": group}, floor(2)], gravity=0.0,
                                 laws=[{"first_group": 5, "second_group": 0, "restitution": 0.5}])
            flight.run(10)
            return float(flight.at(1, "velocity")[2])
        self.assertAlmostEqual(hop(5), 0.5, delta=1e-5)
        self.assertAlmostEqual(hop(6), 0.0, delta=1e-5)


class JointedEngine(AnyEngine):
    """An engine with joints: how far one opens [m], tilts [1 - cosine] and turns [rad] in so many windows."""
    joint_windows, joint_gap, joint_axis, joint_turn = 200, 1e-4, 1e-8, 1e-4

    def test_joints_hold_what_they_hold(self) -> None:
        # z of the joint, horizontal in the world: across gravity
        frame = {"w": np.sqrt(0.5), "x": np.sqrt(0.5)}
        for number, kind in enumerate(("BALL", "HINGE", "SLIDER", "FIXED"), 1):
            beam = slab(1, (0.05, 0.01, 0.01), (0.05, 0, 1), momentum=(0, 0, 1e-4))
            joint = {"id": 1, "name": kind, "kind": number, "first": 1, "second": 0,
                     "first_frame": {"position": xyz((-0.05, 0, 0)), "orientation": frame},
                     "second_frame": {"position": xyz((0, 0, 1)), "orientation": frame}}
            flight = self.flight([beam], joints=[joint])
            flight.run(self.joint_windows)
            q = quaternion(flight.states[1]["orientation"])
            end = flight.at(1) + rotate(q, np.array([-0.05, 0, 0]))
            turned = 2 * np.arccos(min(1.0, abs(q[0])))
            self.assertLess(float(np.linalg.norm((end - (0, 0, 1))[[0, 2]])), self.joint_gap, kind)  # the slider slides along y
            if kind in ("BALL", "HINGE"):
                self.assertGreater(turned, 0.5, kind)
                self.assertLess(abs(end[1]), self.joint_gap, kind)
            if kind != "BALL":
                self.assertGreater(float(rotate(q, np.array([0, -1, 0])) @ (0, -1, 0)), 1 - self.joint_axis, kind)
            if kind in ("SLIDER", "FIXED"):
                self.assertLess(turned, self.joint_turn, kind)


class DoubleEngine(JointedEngine):
    """An engine in double precision."""

    def test_a_hit_turns_a_body_by_its_own_inertia(self) -> None:
        # a ball without friction on a plate's end, off its centre: exchange of impulse p along z at x = a
        for factor in (1.0, 1.6):  # of the plate's inertia; it stays below the sum of the other two
            plate = slab(1, (0.1, 0.02, 0.005), (0, 0, 0), orientation=(1, 0, 0, 0))
            plate["principal_inertia"]["y"] *= factor
            ball_mass, arm, speed = 0.02, 0.06, 2.0
            flight = self.flight([plate, ball(2, 0.01, ball_mass, (arm, 0, 0.016), (0, 0, -speed))], gravity=0.0,
                                 laws=[{"friction": 0.0, "restitution": 0.0}])
            flight.run(10)
            inertia, mass = plate["principal_inertia"]["y"], plate["mass"]
            impulse = speed / (1 / ball_mass + 1 / mass + arm**2 / inertia)
            self.assertAlmostEqual(flight.at(1, "velocity")[2], -impulse / mass, delta=2e-3 * impulse / mass)
            self.assertAlmostEqual(flight.at(1, "angular_momentum")[1], impulse * arm, delta=2e-3 * impulse * arm)

    def test_a_slider_between_two_moving_bodies_keeps_momentum(self) -> None:
        frame = {"w": np.sqrt(0.5), "y": np.sqrt(0.5)}  # z of the joint along x
        rail = slab(1, (0.1, 0.01, 0.01), (0, 0, 0), velocity=(0, 0.3, 0))
        block = slab(2, (0.02, 0.02, 0.02), (0.03, 0, 0.05), velocity=(0.5, 0, 0.2))
        joint = {"id": 1, "kind": 3, "first": 1, "second": 2, "first_frame": {"orientation": frame},
                 "second_frame": {"position": xyz((0, 0, -0.05)), "orientation": frame}}
        flight = self.flight([rail, block], gravity=0.0, joints=[joint])
        mass = {k: flight.bodies[k]["mass"] for k in (1, 2)}

        def momenta() -> np.ndarray:
            linear = [mass[k] * flight.at(k, "velocity") for k in (1, 2)]
            turns = [np.cross(flight.at(k), p) + flight.at(k, "angular_momentum") for k, p in zip((1, 2), linear)]
            return np.concatenate([sum(linear), sum(turns)])

        start = momenta()
        flight.run(200)
        self.assertLess(float(np.linalg.norm((momenta() - start)[:3])), 1e-13)
        # moving poses together takes a share (omega H)^2 of the angular momentum
        self.assertLess(float(np.linalg.norm((momenta() - start)[3:])), 1e-3 * float(np.linalg.norm(start[3:])))
        q = {k: quaternion(flight.states[k]["orientation"]) for k in (1, 2)}
        anchor = flight.at(2) + rotate(q[2], np.array([0, 0, -0.05]))
        off = rotate(q[1] * [1, -1, -1, -1], anchor - flight.at(1))
        self.assertLess(float(np.linalg.norm(off[1:])), 1e-4)
        self.assertGreater(off[0], 0.1)  # it has slid
