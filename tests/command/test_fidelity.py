"""Presets of fidelity: what they come to for a scene, what they leave alone, and that the guide says the same."""
from __future__ import annotations

import json
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Sequence

from sunder_tools.launch.fidelity import PRESETS, Preset, Taken, _values, taken
from sunder_tools.report.scene_text import parse_text

from . import REPOSITORY
from .fakes import write_executables

PANE = """name: "pane" end_time_s: 1 window_s: 4e-5 settle_window_s: 1.2e-4
shells { name: "pane" plate { elements_x: 30 elements_y: 21 } }
shells { name: "roof" cylinder { elements_u: 5 elements_v: 1 } }
shells { name: "car" nurbs { knots_u: [0, 0, 0, 1, 1, 1] } }"""


class Presets(unittest.TestCase):
    def of(self, preset: Preset, text: str = PANE, given: Sequence[str] = ()) -> Taken:
        return _values("some", preset, parse_text(text), given)

    def test_they_are_factors_of_the_scene_s_own(self) -> None:
        found = self.of(Preset(0.5))
        self.assertEqual(found.settings, (
            "shells[pane].plate.elements_x=15", "shells[pane].plate.elements_y=10",  # 10.5 to the even one
            "shells[roof].cylinder.elements_u=2"))  # one element cannot be halved, and a car has those of its knots
        self.assertEqual(found.was, ("30", "21", "5"))
        self.assertIn("shells[pane].plate.elements_x=15 (was 30)", found.words())

    def test_patches_that_say_how_long_elements_are_have_longer_ones(self) -> None:
        rings = """shells { name: "ring" annulus { inner_m: 0.1 outer_m: 0.3 element_m: 0.02 } }
            shells { name: "face" cad { path: "f.step" element_m: 0.05 elements_u: 4 } }
            shells { name: "hare" mesh { path: "hare.ply" element_m: 0.004 } }"""
        self.assertEqual(self.of(Preset(0.5), rings).settings, (
            "shells[ring].annulus.element_m=0.04", "shells[face].cad.elements_u=2", "shells[face].cad.element_m=0.1",
            "shells[hare].mesh.element_m=0.008"))
        finer = self.of(PRESETS["reference"], rings, ["shells[0].annulus.element_m=0.01"])
        self.assertEqual(finer.kept, ("shells[ring].annulus.element_m",))
        self.assertIn("shells[hare].mesh.element_m=0.00282843", finer.settings)

    def test_windows_too_and_the_longest_one_stays_a_whole_number_of_them(self) -> None:
        found = self.of(Preset(window=4.0))
        self.assertEqual(found.settings, ("window_s=0.00016", "settle_window_s=0.00016"))  # 0.75 of one
        self.assertEqual(found.was, ("4e-05", "0.00012"))
        self.assertEqual(self.of(Preset(window=2.0)).settings, ("window_s=8e-05", "settle_window_s=0.00016"))
        self.assertEqual(self.of(Preset(window=4.0), PANE.replace("1.2e-4", "1e-3")).settings,
                         ("window_s=0.00016", "settle_window_s=0.00096"))
        own = self.of(Preset(window=4.0), given=["window_s=2e-5"])
        self.assertEqual((own.settings, own.kept), ((), ("window_s",)))

    def test_a_window_that_is_refused_is_halved_and_costs_no_elements(self) -> None:
        def accepted(settings: Sequence[str]) -> bool:
            return all(float(s.split("=")[1]) < 1e-4 for s in settings if s.startswith("window_s="))

        found = taken("draft", parse_text(PANE), (), accepted)
        self.assertIn("window_s=8e-05", found.settings)
        self.assertIn("shells[pane].plate.elements_x=15", found.settings)

    def test_standard_is_the_scene_as_it_is(self) -> None:
        self.assertEqual(PRESETS["standard"], Preset())
        self.assertEqual(taken("standard", parse_text(PANE), (), lambda _: True).settings, ())

    def test_what_the_user_sets_stays(self) -> None:
        for given in ("shells[pane].plate.elements_x=99", "shells[0].plate.elements_x=99"):
            found = self.of(Preset(2.0), given=[given, "window_s=1e-5"])
            self.assertEqual(found.settings, ("shells[pane].plate.elements_y=42", "shells[roof].cylinder.elements_u=10",
                                              "shells[roof].cylinder.elements_v=2"))
            self.assertEqual(found.kept, ("shells[pane].plate.elements_x",))
            self.assertIn("as you set them: shells[pane].plate.elements_x", found.words())

    def test_a_draft_that_is_refused_is_made_finer_until_it_is_not(self) -> None:
        asked: list[int] = []

        def accepted(settings: Sequence[str]) -> bool:
            elements = [int(s.split("=")[1]) for s in settings if "elements_x" in s]
            asked.extend(elements)  # none where it is the window that is asked about
            return all(n >= 20 for n in elements)

        found = taken("draft", parse_text(PANE), (), accepted)
        self.assertIn(f"shells[pane].plate.elements_x={asked[-1]}", found.settings)
        self.assertEqual(asked, sorted(asked))
        self.assertTrue(20 <= asked[-1] < 30)
        # what is refused even as it is, is left for the run to tell
        found = taken("draft", parse_text(PANE), (), lambda _: False)
        self.assertFalse([s for s in found.settings if "elements" in s])

    def test_the_guide_says_the_same(self) -> None:
        guide = (REPOSITORY / "coupler" / "experiments" / "README.md").read_text()
        rows = re.findall(r"^\| `(draft|standard|reference)`: elements × ([0-9.]+)(?:, window × ([0-9.]+))? \|", guide, re.M)
        self.assertEqual({name: (float(elements), float(window or 1)) for name, elements, window in rows},
                         {n: (float(f"{p.elements:.3g}"), p.window) for n, p in PRESETS.items()})


class Command(unittest.TestCase):
    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.here = Path(self._folder.name)
        (self.here / "pids").mkdir()
        write_executables(self.here / "build")
        self.scene = self.here / "pane.textproto"
        self.scene.write_text(PANE)

    def sunder(self, *arguments: str) -> tuple[int, str]:
        done = subprocess.run([REPOSITORY / "coupler" / "sunder", *arguments], cwd=self.here, capture_output=True, text=True,
                              check=False, timeout=1800, env={**os.environ, "SUNDER_BUILD_DIR": str(self.here / "build"),
                                                              "FAKE_PIDS": str(self.here / "pids")})
        return done.returncode, done.stderr

    def test_a_run_says_what_it_took_and_keeps_it(self) -> None:
        status, err = self.sunder("run", str(self.scene), "--fidelity", "draft", "--out", "out", "--set", "window_s=1e-5")
        self.assertEqual(status, 0, err)
        self.assertIn("sunder: fidelity draft: shells[pane].plate.elements_x=", err)
        kept = json.loads((self.here / "out" / "command.json").read_text())
        self.assertEqual(kept["fidelity"], "draft")
        self.assertEqual(kept["settings"][-1], "window_s=1e-5")
        self.assertIn("shells[pane].plate.elements_x=", kept["settings"][0])
        usage = json.loads((self.here / "out" / "usage.json").read_text())
        self.assertGreater(usage["processor_s"], 0.0)
        self.assertGreater(usage["wall_s"], 0.0)

    def test_an_unknown_preset_is_refused(self) -> None:
        status, err = self.sunder("run", str(self.scene), "--fidelity", "finest")
        self.assertEqual(status, 2)
        self.assertIn("none of draft, standard, reference", err)
        status, err = self.sunder("run", "--resume", "out", "--fidelity", "draft")
        self.assertEqual(status, 2)
        self.assertIn("leave --fidelity out", err)

    def test_a_scene_that_is_none_is_left_to_the_solver(self) -> None:
        self.scene.write_text("wrong: 1 }\n")
        status, err = self.sunder("run", str(self.scene), "--fidelity", "draft")
        self.assertEqual(status, 2, err)
        self.assertIn("pane.textproto:1:1: wrong", err)


if __name__ == "__main__":
    unittest.main()
