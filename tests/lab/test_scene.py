"""Scenes as messages: the same paths and the same checks as `sunder run --set`, and the same run."""
from __future__ import annotations

import json
import math
import os
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import SupportsFloat

import sunder
from sunder_tools.launch.build import build_dir
from sunder_tools.report.scene_text import SCENE_COPY, scene_words

from . import REPOSITORY

ACRYLIC = sunder.SCENES / "acrylic.textproto"
GOOD = ("bodies[pellet].twist.linear.z=-20", "bodies[0].pose.position.x=1e-3", "fracture.seed=7", "window_s=1e-6",
        "shells[plate].plate.elements_x=30", "fracture.mode=CUTS", "fracture.interlock=false", "gravity.y=-1",
        "fracture.branch_ratio=1.5", "name=other")
# refused by both; the last ones make no sense of what they are given
BAD = ("bodies[ball].twist.linear.z=-20", "bodie[pellet].mass=1", "bodies[pellet].mass=1", "window_s=x", "fracture.mode=TIP",
       "shells[plate].layers=2.5", "shells[plate].supports=1", "gravity=3", "window_s.x=3", "fracture.interlock=maybe",
       "bodies.twist.linear.z=1", "shells[plate]=1", "window_s=", "window_s=1 2")


class Paths(unittest.TestCase):
    def test_take_and_refuse_what_the_command_does(self) -> None:
        for setting in GOOD + BAD:
            with self.subTest(setting):
                path, _, value = setting.partition("=")
                said = subprocess.run([str(build_dir() / "shell" / "sunder-shell"), "--scene", str(ACRYLIC), "--check",
                                       "--set", setting], capture_output=True, text=True, check=False)
                scene = sunder.Scene.load(ACRYLIC)
                before = scene.text()
                if setting in BAD:
                    self.assertIn("bad_setting", said.stderr)
                    with self.assertRaises(sunder.BadSetting):
                        scene[path] = value
                    self.assertEqual(scene.text(), before)
                else:
                    self.assertEqual(said.returncode, 0, said.stderr)
                    scene[path] = value
                    self.assertNotEqual(scene.text(), before)
                    self.assertEqual(type(scene[path])(value) if not isinstance(scene[path], bool) else value == "true",
                                     scene[path])

    def test_say_what_there_is(self) -> None:
        scene = sunder.Scene.load(ACRYLIC)
        plate = r"'shells' is a list; write shells\[plate\]; there are: plate$"
        for path, words in (("bodies[ball].pose.position.z", "there are: pellet$"), ("bodies[pelet].mass", "did you mean 'pellet'\\?$"),
                            ("window", r"'window' is no field of Scene; did you mean 'window_s'\?$"), ("fracture.mod", "did you mean 'mode'"),
                            ("shells[plate].thicknes_m", "is no field of Shell; did you mean 'thickness_m' or [^:]*$"),
                            ("shels[plate].layers", "did you mean 'shells'"), ("colour", "'colour' is no field of Scene; it has: name, "),
                            ("shells.plate.thickness_m", plate), ("shells.0.layers", r"write shells\[0\]"),
                            ("shells.layers", r"write shells\[NAME\]; there are: plate$")):
            with self.subTest(path), self.assertRaisesRegex(sunder.BadSetting, words):
                scene[path] = 1
        with self.assertRaisesRegex(sunder.BadSetting, plate):
            scene.find("shells.plate")
        with self.assertRaisesRegex(sunder.BadSetting, "TIPS, CUTS, DAMAGE"):
            scene["fracture.mode"] = "TOPS"

    def test_numbers_that_are_none_are_refused_at_once(self) -> None:
        scene = sunder.Scene.load(ACRYLIC)
        before = scene.text()
        cases: list[tuple[str, float | str, str]] = [
            ("window_s", float("nan"), "no finite number"), ("window_s", float("inf"), "no finite number"),
            ("gravity.z", "-inf", "no finite number"), ("fracture.mode", 99, "TIPS, CUTS, DAMAGE"),
            ("shells[plate].layers", 2 ** 40, "no whole number"), ("shells[plate].layers", 2.5, "no whole number")]
        for path, value, words in cases:
            with self.assertRaisesRegex(sunder.BadSetting, words):
                scene[path] = value
        self.assertEqual(scene.text(), before)

    def test_numbers_are_kept_to_the_bit(self) -> None:
        import numpy as np
        scene = sunder.Scene.load(ACRYLIC)
        numbers: list[SupportsFloat] = [0.1 + 0.2, 1e-300, np.float64(1) / 3, np.float32(0.1)]
        for value in numbers:
            scene["window_s"] = value
            self.assertEqual(scene["window_s"], float(value))
            with tempfile.TemporaryDirectory() as folder:
                self.assertEqual(sunder.Scene.load(scene.save(folder))["window_s"], float(value))
        scene["shells[plate].layers"] = 4.0
        self.assertEqual(scene["shells[plate].layers"], 4)

    def test_typed_fields_refuse_what_does_not_fit(self) -> None:
        scene = sunder.Scene.load(ACRYLIC)
        with self.assertRaises(TypeError):
            scene.message.end_time_s = "long"
        with self.assertRaises(AttributeError):
            scene.find("shells[plate].plate").elements = 4
        scene.find("shells[plate]").supports.add(edges=["ALL"], kind="CLAMPED")
        self.assertIn("CLAMPED", scene.text())
        self.assertNotIn("CLAMPED", sunder.Scene.load(ACRYLIC).text())


class Files(unittest.TestCase):
    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.here = Path(self._folder.name)

    def test_a_fault_is_told_with_its_place(self) -> None:
        path = self.here / "wrong.textproto"
        path.write_text('name: "wrong"\nwindows: 3\n')
        with self.assertRaisesRegex(sunder.Error, r"wrong\.textproto:2:1 .*windows"):
            sunder.Scene.load(path)
        with self.assertRaisesRegex(sunder.Error, "cannot be read"):
            sunder.Scene.load(self.here / "none.textproto")

    def test_what_a_scene_names_goes_with_it_and_counts(self) -> None:
        scene = sunder.Scene.load(ACRYLIC)
        plain = scene.identity()
        scene.folder = self.here
        (self.here / "maps").mkdir()
        (self.here / "maps" / "grey.pgm").write_text("P2 2 2 255 0 1 2 3\n")
        scene.find("shells[plate].strength_map").path = "maps/grey.pgm"
        first = scene.identity()
        saved = sunder.Scene.load(scene.save(self.here / "copy"))
        self.assertEqual(saved.identity(), first)
        self.assertTrue((self.here / "copy" / "maps" / "grey.pgm").is_file())
        (self.here / "maps" / "grey.pgm").write_text("P2 2 2 255 0 1 2 4\n")
        self.assertEqual(len({plain, first, scene.identity()}), 3)
        scene.find("shells[plate].strength_map").path = "../outside.pgm"
        with self.assertRaisesRegex(sunder.Error, "not below that folder"):
            scene.identity()

    def test_check_refuses_with_field_and_remedy(self) -> None:
        scene = sunder.Scene.load(ACRYLIC)
        self.assertIn("stable step", scene.check())
        scene["shells[plate].thickness_m"] = -1
        for refuse in (scene.check, lambda: scene.run(self.here / "out")):
            with self.assertRaises(sunder.Error) as refused:
                refuse()
            self.assertIn("scene 'acrylic': shells[0].thickness_m: is -1; must be positive", str(refused.exception))
            self.assertNotRegex(str(refused.exception), "textproto|/tmp")
        self.assertEqual(scene["shells[0].thickness_m"], -1)  # the field of the message is a path

    def test_a_car_that_has_lost_a_patch_or_moved_one_is_refused(self) -> None:
        car = REPOSITORY / "scenes" / "impactor_small.textproto"
        lost = sunder.Scene.load(car)
        del lost.message.shells[[shell.name for shell in lost.message.shells].index("roof")]
        with self.assertRaisesRegex(sunder.Error, r"seams.rules\[6\].second: 'roof' is no shell of this scene"):
            lost.check()
        moved = sunder.Scene.load(car)
        for point in moved.find("shells[roof]").nurbs.control_points:
            point.z += 0.2
        with self.assertRaisesRegex(sunder.Error, r"seams.rules\[6\]: fastens 'windscreen' and 'roof', which have no whole"):
            moved.check()

    def test_runs_as_the_command_does_to_the_bit(self) -> None:
        settings: dict[str, float | int | bool | str] = {
            "shells[plate].plate.elements_x": 24, "shells[plate].plate.elements_y": 24, "end_time_s": 3e-5,
            "bodies[pellet].twist.linear.z": -50}
        one = sunder.Scene.load(ACRYLIC).set(settings).run(self.here / "one", threads=1)
        command = [str(REPOSITORY / "coupler" / "sunder"), "run", str(ACRYLIC), "--out", str(self.here / "two"), "--quiet"]
        for path, value in settings.items():
            command += ["--set", f"{path}={value}"]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ)
        self.assertEqual(done.returncode, 0, done.stderr)
        two = json.loads((self.here / "two" / "run.json").read_text())
        self.assertEqual(one.run["state_hash"], two["state_hash"])
        again = sunder.Results(self.here / "two")  # its scene by the copy in it
        self.assertEqual(again.scene["bodies[pellet].twist.linear.z"], -50)
        words = scene_words(self.here / "two")
        self.assertEqual((words.shells, words.bodies), (("plate",), ("pellet",)))
        self.assertEqual(words.thickness, (again.scene["shells[plate].thickness_m"],))
        copy = str(self.here / "two" / SCENE_COPY)
        own = subprocess.run([*command[:2], copy, *command[3:6]], capture_output=True, text=True, check=False, env=os.environ)
        self.assertEqual((own.returncode, Path(copy).is_file()), (2, True), own.stderr)
        self.assertIn("is a file of it; give another --out", own.stderr)
        self.assertEqual(sunder.impact()(again), sunder.impact()(one))

    def test_books_have_bodies_and_no_work_of_gravity(self) -> None:
        """As the page of run.json says: a free pane and a thrown ball fall, and nothing touches."""
        scene = sunder.Scene.load(sunder.SCENES / "intact_pane.textproto").set({
            "bodies[ball].pose.position.z": 5.0, "shells[pane].plate.elements_x": 20, "shells[pane].plate.elements_y": 20,
            "end_time_s": 2e-3, "gravity.z": -1000.0})
        del scene.find("shells[pane]").supports[:]
        energy = scene.run(self.here / "out", threads=1).energy
        pane, ball = 2500.0 * 0.004 * 0.3 ** 2, 7800.0 * 4.0 / 3.0 * math.pi * 0.01 ** 3  # [kg]
        # the ball comes with 3 m/s, and 1000 m/s^2 add 2 m/s to both; leapfrog is exact for a constant force
        self.assertAlmostEqual(energy["kinetic"] / (0.5 * pane * 2.0 ** 2 + 0.5 * ball * 5.0 ** 2), 1.0, delta=1e-6)
        self.assertEqual(energy["external_work"], 0.0)

    def test_a_run_that_is_refused_raises(self) -> None:
        scene = sunder.Scene.load(ACRYLIC)
        scene["bodies[pellet].pose.position.z"] = 0
        with self.assertRaisesRegex(sunder.Error, "inside shell 'plate'"):
            scene.run(self.here / "out")
        self.assertFalse((self.here / "out").exists())


if __name__ == "__main__":
    unittest.main()
