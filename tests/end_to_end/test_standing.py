"""A pane that is held along its border breaks and is frozen: what stands is a static body of few parts, and the run ends."""
from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

TOP = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ["SUNDER_BUILD_DIR"])
sys.path.insert(0, str(TOP / "coupler"))
from sunder_engine.recording import exchanges  # noqa: E402

# The pane of Fig. 17 of the paper with fewer elements. At full size a part for each element is more than can be sent.
SCENE = """
name: "standing"
end_time_s: 0.1
window_s: 2e-5
settle_window_s: 1e-3
materials { name: "glass" density: 4000 youngs_modulus: 3.2e10 poisson_ratio: 0.18 strength: 2.2e7 fracture_energy: 140
  weibull_modulus: 8 flaw_spacing_m: 0.01 }
materials { name: "marble" density: 2700 }
shells {
  name: "pane" material: "glass" thickness_m: 0.01 layers: 5
  plate { size_x_m: 2.43 size_y_m: 2.43 elements_x: ELEMENTS elements_y: ELEMENTS pose { position { z: 1 } } }
  supports { edges: ALL kind: CLAMPED }
}
bodies { name: "ball" material: "marble" sphere { radius_m: 0.08 } pose { position { x: 0.003 y: -0.002 z: 1.086 } }
  twist { linear { z: -15 } } }
bodies { name: "floor" half_space {} }
fracture { mode: TIPS seed: 1 latest_freeze_s: 4.3e-3 }
output { frame_interval_s: 0.05 shell_frame_interval_s: 1e-3 }
"""


def standing_parts(elements: int) -> list[np.ndarray]:
    """Corners (n, 3) [m] of each convex part of what stands of a pane with so many elements along a side."""
    with tempfile.TemporaryDirectory() as name:
        scene, out = Path(name) / "standing.textproto", Path(name) / "run"
        scene.write_text(SCENE.replace("ELEMENTS", str(elements)))
        done = subprocess.run([TOP / "coupler" / "sunder", "run", str(scene), "--out", str(out), "--record", "--quiet",
                               "--no-pictures"], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        run = json.loads((out / "run.json").read_text())
        assert run["status"] == "done" and run["counts"]["handed_off"] > 0, run["counts"]
        births = [body for said in exchanges(out / "session.rec") if said.kind == "window" for body in said.request.window.births]
    standing = [body for body in births if body.is_static]
    assert len(standing) == 1, [body.name for body in standing]
    return [np.reshape(part.corners, (-1, 3)) for part in standing[0].convex.parts]


class Standing(unittest.TestCase):
    def test_what_stands_is_few_parts_and_the_run_goes_to_its_end(self) -> None:
        coarse, fine = standing_parts(40), standing_parts(80)
        # By outline: a few parts for each corner of the hole, which is some elements wide. By element there are over a
        # thousand, and four times as many on the fine grid.
        self.assertLess(len(coarse), 40 * 40 / 10)
        self.assertLess(len(fine), 80 * 80 / 20)
        self.assertLess(len(fine), 3 * len(coarse))
        for parts in (coarse, fine):
            self.assertGreater(len(parts), 3)  # it has a hole
            corners = np.concatenate(parts)
            farthest = max(float(np.linalg.norm(corners - corner, axis=1).max()) for corner in corners)
            self.assertAlmostEqual(farthest, math.hypot(2.43, 2.43), delta=0.02)  # from corner to corner of the border


if __name__ == "__main__":
    unittest.main()
