"""Recordings of sessions: those that ship, what a file tells of its session, and files that are none."""
from __future__ import annotations

import contextlib
import io
import json
import random
import tempfile
import unittest
from pathlib import Path

from sunder_engine.playing import Player
from sunder_engine.recording import BadRecording, Summary, exchanges

from . import REPOSITORY, sunder
from .recorded import FALL, LINE, RADIUS, WINDOWS, WORDS, Sessions

FLOOR = REPOSITORY / "tests" / "conformance" / "spheres_floor.rec"
SHIPPED = REPOSITORY / "tests" / "conformance" / "free_flight.rec"


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


class SpheresOnAFloor(unittest.TestCase):
    """The recording with contacts, and engines that come with the project."""
    TOLERANCE = "1e-3"  # an overlap of 5 um, which some engines leave, is 2.5e-4 of the smaller sphere; rest_* allow 0.1 mm, 5e-3

    def played(self, engine: str, *arguments: str) -> tuple[int, str]:
        with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.redirect_stderr(said):
            status = sunder(["validate", "engines", "--rigid", engine, "--session", str(FLOOR), *arguments])
        return status, said.getvalue()

    def test_engines_with_contact_agree_and_one_without_does_not(self) -> None:
        status, said = self.played("ode")  # which was recorded; to round-off, which goes by the compiler
        self.assertEqual(status, 0, said)
        status, said = self.played("bullet", "--tolerance", self.TOLERANCE)
        self.assertEqual(status, 0, said)
        status, said = self.played("freeflight", "--tolerance", self.TOLERANCE)
        self.assertEqual(status, 1, said)
        self.assertIn("first that differs: window 4 (", said)

    def test_it_needs_no_more_than_the_page_says(self) -> None:
        summary = Summary(FLOOR)
        self.assertEqual(set(summary.needs), {"spheres", "half_spaces"})
        self.assertEqual([body.name for body in summary.bodies.values()], ["floor", "slider", "roller"])
        page = (REPOSITORY / "rigid" / "README.md").read_text()
        self.assertTrue(f"--session tests/conformance/spheres_floor.rec --tolerance {self.TOLERANCE}\n" in page)

    def test_it_is_of_the_scene_beside_it(self) -> None:
        with tempfile.TemporaryDirectory() as name, contextlib.redirect_stdout(io.StringIO()) as said:
            status = sunder(["run", str(FLOOR.with_suffix(".textproto")), "--rigid", "ode", "--record", "--out", name, "--no-pictures",
                             "--quiet"])
            self.assertEqual(status, 0, said.getvalue())
            made, shipped = list(exchanges(Path(name) / "session.rec")), list(exchanges(FLOOR))
        self.assertEqual(made[0].request.hello.scene_hash, shipped[0].request.hello.scene_hash)
        self.assertEqual([one.kind for one in made], [one.kind for one in shipped])


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
