"""Values in a wrong unit, with the real programs: a refusal that they may decide names them, and a run warns of them."""
from __future__ import annotations

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
SCENE = TOP / "scenes" / "intact_pane.textproto"
STIFFNESS = "materials[glass].youngs_modulus"
WORDS = "Look at the units first: "


class Units(unittest.TestCase):
    def sunder(self, *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([TOP / "coupler" / "sunder", *words], capture_output=True, text=True, check=False,
                              env={**os.environ, "SUNDER_BUILD_DIR": os.environ["SUNDER_BUILD_DIR"]})

    def test_a_refusal_for_another_reason_names_the_unit(self) -> None:
        for command in ("check", "run"):
            with tempfile.TemporaryDirectory() as name:
                out = ("--out", f"{name}/run") if command == "run" else ()
                done = self.sunder(command, str(SCENE), "--set", f"{STIFFNESS}=70", *out)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(f"{WORDS}{STIFFNESS} is 70 Pa, softer than a gel; 70 GPa are 7e+10", done.stderr)

    def test_a_refusal_in_a_sound_scene_does_not(self) -> None:
        done = self.sunder("check", str(SCENE), "--set", "window_s=1e-12")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertNotIn(WORDS, done.stderr)

    def test_a_refusal_that_units_do_not_decide_does_not(self) -> None:
        probe = 'probes { name: "p" shell: "pane" at { u: 7 v: 0 } }'
        with tempfile.TemporaryDirectory() as name:
            scene = Path(name) / "probe.textproto"
            scene.write_text(SCENE.read_text().replace("output {", "output { " + probe))
            done = self.sunder("check", str(scene), "--set", "materials[glass].density=1")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("output.probes[0].at: (7, 0) lies outside the patch", done.stderr)
        self.assertNotIn(WORDS, done.stderr)

    def test_a_run_warns(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            done = self.sunder("run", str(SCENE), "--set", "materials[glass].density=2.5", "--set", "window_s=1e-4", "--until", "1e-4",
                               "--quiet", "--no-pictures", "--out", f"{name}/run")
            self.assertEqual(done.returncode, 0, done.stderr)
            warnings = json.loads((Path(name) / "run" / "run.json").read_text())["warnings"]
            self.assertTrue(any(w.startswith("materials[glass].density is 2.5 kg/m^3, about that of air") for w in warnings), warnings)


if __name__ == "__main__":
    unittest.main()
