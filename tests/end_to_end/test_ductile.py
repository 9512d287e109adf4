"""Metal that yields, weakens and parts in mode DAMAGE, in one shell and in two that a seam joins, with the real programs."""
from __future__ import annotations

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np

from sunder_tools.pictures.frames import SHELL, list_frames

TOP = Path(__file__).resolve().parents[2]
BUILD = os.environ["SUNDER_BUILD_DIR"]

HEAD = """name: "strip"
end_time_s: 0.0052
window_s: 2e-5
gravity {}
materials {
  name: "metal" density: 1000 youngs_modulus: 2e9 poisson_ratio: 0.3
  yield_stress: 2e7 hardening_modulus: 2e8 strength: 3e7 fracture_energy: 3000
}
fracture { mode: DAMAGE healing: false }
output { frame_interval_s: 5.2e-3 }
"""


def part(name: str, low: float, high: float, elements: int, held: str = "") -> str:
    """A strip of 0.1 m that is pulled along x, from y = low to high [m], a tenth weaker across its middle."""
    return f"""shells {{
  name: "{name}" material: "metal" thickness_m: 0.002 layers: 5
  plate {{
    size_x_m: 0.1 size_y_m: {high - low!r} elements_x: 20 elements_y: {elements}
    pose {{ position {{ y: {0.5 * (low + high)!r} }} }}
  }}
  supports {{ edges: U_MIN kind: SIMPLY_SUPPORTED axes: X axes: Z }}
  supports {{
    edges: U_MAX kind: SIMPLY_SUPPORTED axes: X axes: Z
    motion {{ time_s: 0 }} motion {{ time_s: 0.0052 displacement {{ x: 0.0052 }} }}
  }}
  {held}
  strength_regions {{ low {{ u: 0.045 v: 0 }} high {{ u: 0.055 v: {high - low!r} }} factor: 0.9 }}
}}
"""


CORNER = "supports { corners: U_MIN_V_MIN kind: SIMPLY_SUPPORTED }"


class Ductile(unittest.TestCase):
    def pulled(self, shells: str) -> tuple[dict[str, Any], list[set[int]]]:
        """run.json, and the pieces of each shell in the last frame."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "scene.textproto").write_text(HEAD + shells)
            done = subprocess.run([TOP / "coupler" / "sunder", "run", folder / "scene.textproto", "--out", folder / "out", "--no-pictures",
                                   "--quiet"], capture_output=True, text=True, env={**os.environ, "SUNDER_BUILD_DIR": BUILD}, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            last = list_frames(folder / "out")[-1].read(SHELL)
            assert last is not None
            shell, piece = last.of_triangles("shell", 0), last.of_triangles("fragment", 0)
            return json.loads((folder / "out" / "run.json").read_text()), [
                set(piece[shell == k].astype(int)) for k in np.unique(shell)]

    def test_a_seam_changes_neither_flow_nor_tear(self) -> None:
        one, _ = self.pulled(part("whole", -0.02, 0.02, 8, CORNER))
        two, pieces = self.pulled(part("low", -0.02, 0.005, 5, CORNER) + part("high", 0.005, 0.02, 3) + "seams {}\n")
        self.assertEqual(one["counts"]["fragments"], 2)
        self.assertEqual(two["counts"]["fragments"], 2)
        self.assertEqual(len(pieces), 2)
        self.assertEqual(pieces[0], pieces[1], "both halves of the seam belong to both pieces")
        self.assertEqual(len(pieces[0]), 2)
        both = [run["energy"] for run in (one, two)]
        for name, share in (("external_work", 1e-3), ("dissipated_plastic", 0.01), ("dissipated_fracture", 0.1)):
            self.assertGreater(both[0][name], 0.01 * both[0]["external_work"])
            self.assertLess(abs(both[1][name] / both[0][name] - 1.0), share, name)
        for energy in both:
            self.assertLess(abs(energy["residual_relative"]), 2e-3)


if __name__ == "__main__":
    unittest.main()
