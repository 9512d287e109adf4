"""What a run or a check warns of is told by the whole program, and the remedy that it names ends the warning."""
from __future__ import annotations

import json
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ["SUNDER_BUILD_DIR"])
# A heavy cube on a light one, a thousand to one.
STACK = """name: "stack"
end_time_s: 0.1
window_s: 2e-3
materials { name: "light" density: 20 }
materials { name: "heavy" density: 20000 }
bodies { name: "ground" box { size_m { x: 2 y: 2 z: 0.1 } } pose { position { z: -0.05 } } is_static: true }
bodies { name: "lower" material: "light" box { size_m { x: 0.2 y: 0.2 z: 0.2 } } pose { position { z: 0.1 } } }
bodies { name: "upper" material: "heavy" box { size_m { x: 0.2 y: 0.2 z: 0.2 } } pose { position { z: 0.3 } } }
contacts { friction: 0.8 restitution: 0 }
output { frame_interval_s: 0.1 }
"""
# A ball that is small beside the distance of the Gauss points falls on a coarse sheet.
COARSE = """name: "coarse"
end_time_s: 0.01
window_s: 1e-4
materials { name: "steel" density: 7800 youngs_modulus: 210e9 poisson_ratio: 0.3 }
shells {
  name: "sheet" material: "steel" thickness_m: 0.002
  plate { size_x_m: 1 size_y_m: 1 elements_x: 5 elements_y: 5 }
  supports { edges: ALL kind: CLAMPED }
}
bodies { name: "stone" material: "steel" sphere { radius_m: 0.12 } pose { position { z: 0.15 } } twist { linear { z: -5 } } }
"""


class Warnings(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def sunder(self, command: str, text: str, *options: str) -> str:
        """Runs a command; returns what it says."""
        scene = self.folder / "scene.textproto"
        scene.write_text(text)
        done = subprocess.run([TOP / "coupler" / "sunder", command, scene, *options], capture_output=True, text=True,
                              env={**os.environ, "SUNDER_BUILD_DIR": str(BUILD)}, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout + done.stderr

    def warned(self, text: str, *options: str) -> list[str]:
        """The warnings of a run."""
        out = Path(tempfile.mkdtemp(dir=self.folder))
        self.sunder("run", text, "--out", str(out), "--no-pictures", "--quiet", *options)
        told: list[str] = json.loads((out / "run.json").read_text())["warnings"]
        return told

    def test_a_mass_ratio_that_the_engine_does_not_hold_is_told_with_remedies_that_end_it(self) -> None:
        told = [w for w in self.warned(STACK) if re.match(r"'upper' lies on 'lower', which is (1000|1e\+03) times lighter", w)]
        self.assertEqual(len(told), 1)
        remedy = re.search(r"take --rigid ode, .*, or a window_s of ([0-9.e-]+) s or less", told[0])
        assert remedy is not None, told[0]
        self.assertEqual(self.warned(STACK, "--rigid", "ode"), [])
        self.assertEqual(self.warned(STACK, "--set", f"window_s={remedy[1]}"), [])

    def test_check_tells_of_a_body_that_sinks_between_gauss_points(self) -> None:
        self.assertRegex(self.sunder("check", COARSE), r"warning .*ball 'stone' may sink [0-9.e-]+ m into shell 'sheet' before it is felt")
        fine = COARSE.replace("elements_x: 5 elements_y: 5", "elements_x: 250 elements_y: 250")
        self.assertNotIn("may sink", self.sunder("check", fine))


if __name__ == "__main__":
    unittest.main()
