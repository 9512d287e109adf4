"""Load steps and modes, with the real programs: files, and the last frame of a search that fails."""
from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

from sunder_tools.pictures.frames import SHELL, Frame, list_frames
from sunder_tools.report.scene_text import scene_words

TOP = Path(__file__).resolve().parents[2]
BUILD = os.environ["SUNDER_BUILD_DIR"]
# A strip that bends under its weight, and a rubber membrane that a pressure may burst.
STRIP = """name: "strip"
materials { name: "steel" density: 7800 youngs_modulus: 210e9 poisson_ratio: 0.3 }
shells {
  name: "strip"
  material: "steel"
  thickness_m: 0.002
  plate { size_x_m: 0.5 size_y_m: 0.05 elements_x: 16 elements_y: 2 }
  supports { edges: U_MIN kind: CLAMPED }
  equilibrium { load_factors: [0.5, 1, 2] }
}
output { probes { name: "tip" shell: "strip" at { u: 0.5 v: 0.025 } } }
"""
MEMBRANE = """name: "membrane"
gravity {}
materials { name: "rubber" density: 1000 youngs_modulus: 1e6 poisson_ratio: 0.45 }
shells {
  name: "membrane"
  material: "rubber"
  thickness_m: 0.01
  plate { size_x_m: 1 size_y_m: 1 elements_x: 4 elements_y: 4 }
  supports { edges: ALL kind: SIMPLY_SUPPORTED }
  loads { pressure: 1e5 }
  equilibrium { load_factors: [0.01, 1] }
}
"""
# A ring of four sectors that its inner rim holds.
RING = """name: "ring"
gravity {}
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.3 }
shells {
  name: "ring"
  material: "glass"
  thickness_m: 0.002
  annulus { inner_m: 0.1 outer_m: 0.3 element_m: 0.04 }
  supports { edges: INNER kind: CLAMPED }
  loads { pressure: -10 }
  equilibrium { tolerance: 1e-12 load_factors: [1, 2] }
}
output { probes { name: "rim" shell: "ring.2" at { u: 0 v: 0 } } }
"""


def height(frame: Frame) -> float:
    """The largest displacement along z in a frame [m]."""
    shell = frame.read(SHELL)
    assert shell is not None
    return float(np.abs(shell.points[:, 2]).max())


class Statics(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def sunder(self, text: str, command: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Runs a command with a scene; the results are in self.folder / 'out'."""
        scene = self.folder / "scene.textproto"
        scene.write_text(text)
        return subprocess.run([TOP / "coupler" / "sunder", command, scene, "--out", self.folder / "out", *arguments],
                              capture_output=True, text=True, env={**os.environ, "SUNDER_BUILD_DIR": BUILD}, check=False)

    def rows(self, name: str) -> list[list[str]]:
        with (self.folder / "out" / name).open(newline="") as source:
            return list(csv.reader(source))

    def test_each_load_step_has_a_frame_and_a_row(self) -> None:
        done = self.sunder(STRIP, "run", "--no-pictures", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        frames = list_frames(self.folder / "out")
        self.assertEqual([frame.time_s for frame in frames], [1, 2, 3])
        self.assertEqual([row[0] for row in self.rows("series.csv")], ["time [s]", "1", "2", "3"])
        probes = self.rows("probes.csv")
        heights = [abs(float(row[probes[0].index("tip_z [m]")])) for row in probes[1:]]
        np.testing.assert_allclose([height(frame) for frame in frames], heights, rtol=1e-3)  # bends across its width too
        weight = 7800 * 0.5 * 0.05 * 0.002 * 9.81
        forces = [float(row[probes[0].index("strip_support_0_u_min_z [N]")]) for row in probes[1:]]
        np.testing.assert_allclose(forces, [0.5 * weight, weight, 2 * weight], rtol=1e-5)
        told = json.loads((self.folder / "out" / "run.json").read_text())["equilibrium"]
        self.assertEqual([(e["step"], e["load_factor"], e["found_by"] is not None) for e in told],
                         [(1, 0.5, True), (2, 1.0, True), (3, 2.0, True)])

    def test_the_last_equilibrium_of_a_failed_search_is_the_last_frame(self) -> None:
        done = self.sunder(MEMBRANE, "run", "--no-pictures", "--quiet")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("it is the last frame", done.stderr)
        first, last = list_frames(self.folder / "out")
        share = json.loads((self.folder / "out" / "run.json").read_text())["equilibrium"][-1]["share_of_loads"]
        self.assertEqual(first.time_s, 1.0)
        self.assertAlmostEqual(last.time_s, 1.0 + share, places=6)
        self.assertGreater(height(last), height(first))

    def test_a_start_that_is_not_found_has_a_frame_too(self) -> None:
        text = MEMBRANE.replace("load_factors: [0.01, 1]", "").replace("gravity {}", "gravity {}\nend_time_s: 1\nwindow_s: 0.1")
        done = self.sunder(text, "run", "--no-pictures", "--quiet")
        self.assertEqual(done.returncode, 4, done.stderr)
        frame, = list_frames(self.folder / "out")
        self.assertEqual(frame.time_s, 0.0)
        self.assertGreater(height(frame), 0.05)

    def test_the_remedies_of_failed_searches_help(self) -> None:
        done = self.sunder(MEMBRANE, "run", "--no-pictures", "--quiet")
        told = re.search(r"found at [0-9.]+ of the way from the step before: give ([0-9.]+) of it or less", done.stderr)
        assert told is not None, done.stderr
        less = 0.01 + float(told[1]) * (1.0 - 0.01)
        done = self.sunder(MEMBRANE.replace("[0.01, 1]", f"[0.01, {less}]"), "run", "--no-pictures", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        loose = STRIP.replace("  supports { edges: U_MIN kind: CLAMPED }\n", "")
        done = self.sunder(loose, "run", "--no-pictures", "--quiet")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("support it so that it cannot move as a whole", done.stderr)
        done = self.sunder(STRIP, "run", "--no-pictures", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_shells_that_seams_join_are_in_equilibrium_together(self) -> None:
        done = self.sunder(RING, "run", "--no-pictures", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads((self.folder / "out" / "run.json").read_text())["equilibrium"]
        self.assertEqual({e["shell"] for e in told}, {"ring.1", "ring.2", "ring.3", "ring.4"})
        self.assertEqual({e["found_by"] for e in told}, {"newton"})
        probes = self.rows("probes.csv")
        for row, factor in zip(probes[1:], (1, 2), strict=True):
            borne = float(row[probes[0].index("reaction_z [N]")])
            self.assertAlmostEqual(borne / (factor * 10 * np.pi * (0.09 - 0.01)), 1.0, delta=1e-6)  # follows the surface
        first, second = (abs(float(row[probes[0].index("rim_z [m]")])) for row in probes[1:])
        self.assertAlmostEqual(second / first, 2.0, delta=0.02)

    def test_a_shell_joined_to_one_without_equilibrium_is_refused(self) -> None:
        other = RING.replace("shells {", "seams {}\nshells {", 1) + """shells {
  name: "flap" material: "glass" thickness_m: 0.002
  plate { size_x_m: 1 size_y_m: 1 elements_x: 4 elements_y: 4 } equilibrium { load_factors: [1, 2] } }
shells {
  name: "wing" material: "glass" thickness_m: 0.002
  plate { size_x_m: 1 size_y_m: 1 elements_x: 4 elements_y: 4 pose { position { x: 1 } } } }
"""
        done = self.sunder(other.replace("load_factors: [1, 2]", "").replace("gravity {}", "gravity {}\nend_time_s: 1\nwindow_s: 0.1"),
                           "run", "--no-pictures")
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"shells\[1\]\.equilibrium: is given, and shell 'wing', .* give it to both")

    def test_modes_of_a_ring_are_of_all_its_sectors(self) -> None:
        done = self.sunder(RING, "modes", "--count", "2", "--no-pictures")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads((self.folder / "out" / "modes.json").read_text())
        self.assertEqual([s["shell"] for s in told["shells"]], ["ring.1+ring.2+ring.3+ring.4"])

    def test_modes_have_a_table_frames_and_a_picture(self) -> None:
        done = self.sunder(STRIP, "modes", "--count", "3")
        self.assertEqual(done.returncode, 0, done.stderr)
        out = self.folder / "out"
        told = json.loads((out / "modes.json").read_text())
        self.assertEqual([mode["mode"] for mode in told["modes"]], [1, 2, 3])
        for mode in told["modes"]:
            self.assertIn(f"{mode['frequency_Hz']:.6g}", done.stdout)
            frames = list_frames(out / Path(mode["frames"]).parent)
            self.assertEqual(len(frames), 24)
            self.assertAlmostEqual(frames[12].time_s, 0.5 / mode["frequency_Hz"], places=6)
        self.assertEqual([frame.time_s for frame in list_frames(out)], [1, 2, 3])
        rest, drawn = (frame.read(SHELL) for frame in (list_frames(out / "mode_01")[0], list_frames(out)[0]))
        assert rest is not None and drawn is not None
        moved = np.linalg.norm(drawn.points - rest.points, axis=1).max()
        # control points have the amplitude; at the free end of the strip the surface has it too
        self.assertAlmostEqual(moved / told["drawn_amplitude_m"], 1.0, places=3)
        self.assertTrue((out / "modes.png").is_file())
        self.assertEqual(told["warnings"], [])
        self.assertEqual(scene_words(out).thickness, (0.002,))
        self.assertEqual(self.sunder(STRIP, "modes", "--count", "2").returncode, 0)
        self.assertFalse((out / "mode_03").exists(), "earlier modes are replaced")

    def test_modes_of_a_thick_shell_warn(self) -> None:
        done = self.sunder(STRIP.replace("thickness_m: 0.002", "thickness_m: 0.05"), "modes", "--count", "1", "--no-pictures")
        self.assertEqual(done.returncode, 0, done.stderr)
        warning, = json.loads((self.folder / "out" / "modes.json").read_text())["warnings"]
        self.assertRegex(warning, r"shell 'strip' is 0\.\d+ times as thick as it is wide: .* its frequencies too high")
        self.assertIn(f"warning: {warning}", done.stdout)

    def test_elements_that_are_too_large_for_a_mode_are_told_with_a_remedy(self) -> None:
        warnings = []
        for across in (2, 4):  # the second follows the remedy
            scene = STRIP.replace("elements_x: 16 elements_y: 2", f"elements_x: {8 * across} elements_y: {across}")
            done = self.sunder(scene, "modes", "--count", "20", "--no-pictures")
            self.assertEqual(done.returncode, 0, done.stderr)
            told = json.loads((self.folder / "out" / "modes.json").read_text())
            high = [mode["mode"] for mode in told["modes"] if mode["frequency_Hz"] > 1.25 * mode["frequency_in_run_Hz"]]
            named = re.search(r"elements are too large for modes ([\d, ]+), whose .*; take smaller ones", str(told["warnings"]))
            self.assertEqual([int(number) for number in named[1].split(",")] if named else [], high)
            warnings.append(told["warnings"])
        self.assertEqual([len(some) for some in warnings], [1, 0])

    def test_a_scene_for_modes_alone_is_told_which_command_takes_it(self) -> None:
        scene = re.sub(r"  equilibrium \{.*\n", "", STRIP)
        done = self.sunder(scene, "run", "--no-pictures")
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"end_time_s: is missing; .* only 'sunder modes' takes this scene")
        self.assertEqual(self.sunder(scene, "modes", "--count", "1", "--no-pictures").returncode, 0)

    def test_modes_in_a_foreign_folder_are_refused(self) -> None:
        (self.folder / "out").mkdir()
        (self.folder / "out" / "mine").touch()
        done = self.sunder(STRIP, "modes")
        self.assertEqual((done.returncode, "holds other files" in done.stderr), (2, True), done.stderr)


if __name__ == "__main__":
    unittest.main()
