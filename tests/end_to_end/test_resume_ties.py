"""A run whose crack has crossed ties along a trim resumes to the bit, with the real programs."""
from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path

from .test_resume import state, sunder

# A sheet with a disc let in is pulled. A crack from the sheet's notch runs over the disc's border.
SCENE = """name: "ties" end_time_s: 1e-3 window_s: 5e-6 gravity {}
materials { name: "plaster" density: 1000 youngs_modulus: 3e9 poisson_ratio: 0.2 strength: 8e6 fracture_energy: 12 }
fracture { mode: TIPS seed: 1 branch_ratio: 5 }
output { frame_interval_s: 1 checkpoint_interval_s: 5e-5 }
shells { name: "sheet" material: "plaster" thickness_m: 0.002
  plate { size_x_m: 0.1 size_y_m: 0.1 elements_x: 25 elements_y: 25 pose { position { x: 0.05 y: 0.05 } } }
  trims { hole: true circle { center { u: 0.07 v: 0.0507 } radius_m: 0.016 } }
  supports { edges: V_MIN kind: SIMPLY_SUPPORTED }
  supports { edges: V_MAX kind: SIMPLY_SUPPORTED
    motion { time_s: 0 displacement {} } motion { time_s: 1e-3 displacement { y: 3e-4 } } }
  cuts { points { u: 0 v: 0.0513 } points { u: 0.035 v: 0.0513 } } }
shells { name: "disc" material: "plaster" thickness_m: 0.002
  plate { size_x_m: 0.05 size_y_m: 0.05 elements_x: 13 elements_y: 13 pose { position { x: 0.07 y: 0.0507 } } }
  trims { circle { center { u: 0.025 v: 0.025 } radius_m: 0.016 } } }
seams {}
"""
END = "4e-4"


class ResumeOverTies(unittest.TestCase):
    def test_cracked_ties_go_on_to_the_bit(self) -> None:
        with tempfile.TemporaryDirectory() as place:
            here = Path(place)
            scene = here / "ties.textproto"
            scene.write_text(SCENE)
            whole = self._run(scene, here / "whole", END)
            end = json.loads((whole / "run.json").read_text())
            within = 0
            for until in ("1.3e-4", "1.7e-4", "2.1e-4"):
                part = self._run(scene, here / f"part_{until}", until)
                length = json.loads((part / "run.json").read_text())["cracks"]["length_m"]
                within += 0.055 < length < 0.9 * end["cracks"]["length_m"]  # beyond the border, at 0.054 m, and growing
                done = sunder("run", "--resume", str(part), "--until", END, "--quiet")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(state(part), state(whole), until)
                self.assertEqual((part / "series.csv").read_text(), (whole / "series.csv").read_text(), until)
            self.assertEqual(within, 2, "no checkpoint of a crack that grows beyond the border")
            self.assertLess(abs(end["energy"]["residual_relative"]), 0.01)  # of first order in the step

    def _run(self, scene: Path, folder: Path, until: str) -> Path:
        done = sunder("run", str(scene), "--out", str(folder), "--until", until, "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        return folder
