"""Equilibria that are hard to find, with the real programs: small loads, snaps, places on edges."""
from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

TOP = Path(__file__).resolve().parents[2]
BUILD = os.environ["SUNDER_BUILD_DIR"]
sys.path.insert(0, str(TOP / "scenes"))
from splines import basis, open_knots  # noqa: E402

HEAD = """name: "still"
gravity {}
"""
TURNED = "pose { orientation { w: 0.9238795325112867 z: 0.3826834323650898 } }"
MIRRORS = """  supports { edges: U_MIN kind: SYMMETRY_Y }
  supports { edges: U_MAX kind: SYMMETRY_X }
  supports { edges: V_MIN kind: SYMMETRY_Z }
"""


def shell(name: str, patch: str, more: str, thickness: float, young: float, poisson: float) -> str:
    """A material and a shell of it."""
    return f"""materials {{ name: "m" density: 1 youngs_modulus: {young} poisson_ratio: {poisson} }}
shells {{
  name: "{name}" material: "m" thickness_m: {thickness} gauss_points: 3
  {patch}
{more}  equilibrium {{}}
}}
"""


def slit_ring_patch(spans: int) -> str:
    """A slit ring of radii 6 and 10 as one smooth patch, whose circle is a quadratic spline through exact points."""
    knots = open_knots(spans)
    at = 0.5 * (knots[1:-2] + knots[2:-1])  # Greville points
    angle = 2.0 * np.pi * at / spans
    points = np.linalg.solve(basis(knots, at)[0], np.stack([np.cos(angle), np.sin(angle)], axis=1))
    rows = "".join(f"    control_points {{ x: {r * x!r} y: {r * y!r} }}\n" for r in (6.0, 8.0, 10.0) for x, y in points.tolist())
    listed = " ".join(f"knots_u: {k / spans!r}" for k in knots.tolist())
    return f"nurbs {{ degree: 2\n    {listed}\n    knots_v: [0, 0, 0, 1, 1, 1] elements_u: {spans} elements_v: 6\n{rows}  }}"


def slit_ring(patch: str, edge: str, load: float) -> str:
    """A slit ring that is clamped at one side of its slit and lifted at the other (Sze, Liu, Lo 2004, 3.3)."""
    held = "U_MAX" if edge == "U_MIN" else "U_MIN"
    return HEAD + shell("ring", patch, f"  supports {{ edges: {held} kind: CLAMPED }}\n"
                        f"  loads {{ edge_force {{ edge: {edge} force_per_length {{ z: {load} }} }} }}\n", 0.03, 21e6, 0.0)


class Equilibria(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def sunder(self, text: str, command: str = "run") -> subprocess.CompletedProcess[str]:
        scene = self.folder / "scene.textproto"
        scene.write_text(text)
        options = ["--out", self.folder / "out", "--no-pictures", "--quiet"] if command == "run" else []
        return subprocess.run([TOP / "coupler" / "sunder", command, scene, *options], capture_output=True, text=True,
                              env={**os.environ, "SUNDER_BUILD_DIR": BUILD}, check=False)

    def found(self) -> dict[str, object]:
        told: list[dict[str, object]] = json.loads((self.folder / "out" / "run.json").read_text())["equilibrium"]
        return told[-1]

    def probe(self, column: str) -> float:
        with (self.folder / "out" / "probes.csv").open(newline="") as source:
            rows = list(csv.reader(source))
        return float(rows[-1][rows[0].index(column)])

    def test_small_loads_on_a_slit_ring_and_the_ring_of_sectors(self) -> None:
        one = slit_ring_patch(30)
        sectors = "annulus { inner_m: 6 outer_m: 10 element_m: 1 slit: true }"
        probe = 'output { probes { name: "a" shell: "NAME" at { u: 0 v: AT } } }\n'
        heights = {}
        for load in (0.0008, 0.008, 0.04):
            done = self.sunder(slit_ring(one, "U_MIN", load) + probe.replace("NAME", "ring").replace("AT", "0"))
            self.assertEqual(done.returncode, 0, done.stderr)
            heights[load] = self.probe("a_z [m]")  # at the inner rim
        self.assertLess(heights[0.0008], heights[0.008])
        self.assertLess(heights[0.008], heights[0.04])
        done = self.sunder(slit_ring(sectors, "U_MIN", 0.008) + probe.replace("NAME", "ring.1").replace("AT", "4"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertAlmostEqual(self.probe("a_z [m]") / heights[0.008], 1.0, delta=0.02)  # coarse, of other elements

    def test_a_snap_is_found_or_told(self) -> None:
        """An eighth of an open cylinder that is pulled out by a force near the one at which it snaps."""
        arc = f"cylinder {{ radius_m: 4.953 length_m: 5.175 angle_deg: 90 elements_u: 12 elements_v: 12 degree: 3 {TURNED} }}"
        text = HEAD + shell("cyl", arc, MIRRORS + "  loads { point { at { u: 0 v: 0 } force { x: 5250 } } }\n", 0.094, 10.5e6, 0.3125)
        done = self.sunder(text)
        self.assertIn(done.returncode, (0, 4), done.stderr)
        if done.returncode == 4:
            self.assertIn("it is the last frame", done.stderr)
            self.assertGreater(float(str(self.found()["share_of_loads"])), 0.1)
        else:
            self.assertIn(self.found()["found_by"], ("newton", "load_steps", "relaxation"))

    def test_places_on_edges_and_corners_are_inside(self) -> None:
        plate = "plate { size_x_m: 1.1 size_y_m: 1.1 elements_x: 24 elements_y: 24 }"
        corner = "  loads { point { at { u: 1.1 v: 1.1 } force { z: 1 } } }\n"
        arc = (f"cylinder {{ radius_m: 4.953 length_m: 5.175 angle_deg: 90 elements_u: 24 elements_v: 24 degree: 3 {TURNED} }}")
        probes = ('output { probes { name: "b" shell: "s" at { u: 7.7801541988349685 v: 0 } }\n'
                  'probes { name: "c" shell: "s" at { u: 7.7801541988349685 v: 5.174999994825 } } }\n')
        for text in (HEAD + shell("s", plate, corner, 0.01, 1e6, 0.0),
                     HEAD + shell("s", arc, MIRRORS, 0.094, 10.5e6, 0.3125) + probes,
                     HEAD + shell("s", arc, "  loads { point { at { u: 0 v: 5.175 } force { z: -50 } } }\n", 0.094, 1e7, 0.3)):
            done = self.sunder(text, "check")
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_short_window_is_told_how_long_it_must_be(self) -> None:
        text = HEAD + "end_time_s: 1e-5\nwindow_s: 1e-6\n" + shell(
            "strip", "plate { size_x_m: 1 size_y_m: 0.1 elements_x: 16 elements_y: 1 }",
            "  supports { edges: U_MIN kind: CLAMPED }\n", 0.01, 1.2e9, 0.0).replace("density: 1 ", "density: 1000 ")
        done = self.sunder(text)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertRegex(done.stderr, r"window_s: is 1e-06 s, shorter than the stable step of the shell.*; give at least 4\.\d+e-05 s")
        self.assertNotIn("multiple", done.stderr)


if __name__ == "__main__":
    unittest.main()
