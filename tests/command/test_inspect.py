"""`sunder inspect`: its table, the scene that it writes, and what it refuses."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from typing import Any

from sunder_tools.command.inspect import report, write_scene
from sunder_tools.errors import BAD_INPUT, CommandError

TOLD: dict[str, Any] = {
    "file": "part.step", "unit": "millimetre", "low_m": [0.0, 0.0, -0.002], "size_m": [0.03, 0.02, 0.004],
    "element_m": 0.001,
    "faces": [
        {"face": 0, "kind": "plane", "degree": 2, "width_m": [0.03, 0.02], "area_m2": 5.2e-4, "approximated_m": 2e-8, "parts": 3, "parts_trimmed": 0,
         "holes": 1, "elements": [30, 20], "area_of_shells_m2": 5.2e-4, "shortest_element_m": 0.001, "refused": None},
        {"face": 1, "kind": "plane", "degree": 2, "width_m": [0.02, 0.004], "area_m2": 8e-5, "approximated_m": 0.0, "parts": 1, "parts_trimmed": 1,
         "holes": 0, "elements": [20, 4], "area_of_shells_m2": 8e-5, "shortest_element_m": 0.001, "refused": None},
        {"face": 2, "kind": "cylinder", "refused": "face 2 closes on itself along u; split it in the CAD program"}],
    "edges": {"shared": 5, "free": 1, "of_three_faces_or_more": 0, "widest_tolerance_m": 1e-10},
    "seams": {"joined": 1, "smooth": 0, "along_trims": 1}, "seams_refused": None}


class Inspect(unittest.TestCase):
    """The text and the scene, of what sunder-shell says."""

    def test_the_table_has_each_face_with_its_trims_or_its_refusal(self) -> None:
        text = report(TOLD)
        self.assertIn("part.step: 3 faces, 0.03 x 0.02 x 0.004 m, unit millimetre, elements of 0.001 m", text)
        lines = text.splitlines()
        self.assertRegex(lines[2], r"^ +0  plane .* 30 x 20  1 hole, in 3 parts, approximated to 2e-08 m$")
        self.assertRegex(lines[3], r"^ +1  plane .* 20 x 4  border$")
        self.assertRegex(lines[4], r"^ +2  cylinder +refused: face 2 closes on itself")
        self.assertIn("edges: 5 shared, 1 free, 0 of three faces or more; the widest tolerance is 1e-10 m", text)
        self.assertIn("seams: 1 joined, 0 of them smooth, 1 along trims", text)

    def test_seams_that_are_refused_are_told(self) -> None:
        self.assertIn("seams refused: faces 0 and 1 share an edge", report({**TOLD, "seams": None,
                                                                            "seams_refused": "faces 0 and 1 share an edge"}))

    def test_the_scene_has_the_faces_that_can_be_taken(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file, scene = Path(folder) / "cad" / "part.step", Path(folder) / "My part.textproto"
            write_scene(scene, file, TOLD)
            text = scene.read_text()
            self.assertIn('name: "my_part"', text)
            self.assertIn('cad { path: "cad/part.step" faces: 0 faces: 1 element_m: 0.001 }', text)
            self.assertIn("position { z: -0.0022 }", text)
            with self.assertRaisesRegex(CommandError, "exists; give another name") as caught:
                write_scene(scene, file, TOLD)
            self.assertEqual(caught.exception.status, BAD_INPUT)

    def test_all_faces_need_no_list(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder) / "a.textproto"
            write_scene(scene, Path(folder) / "part.step", {**TOLD, "faces": TOLD["faces"][:2]})
            self.assertNotIn("faces:", scene.read_text())

    def test_a_scene_that_is_not_beside_the_file_is_refused(self) -> None:
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as other:
            with self.assertRaisesRegex(CommandError, "is not beside"):
                write_scene(Path(other) / "a.textproto", Path(folder) / "part.step", TOLD)
            with self.assertRaisesRegex(CommandError, "no face of .* can be taken"):
                write_scene(Path(folder) / "a.textproto", Path(folder) / "part.step", {**TOLD, "faces": TOLD["faces"][2:]})


if __name__ == "__main__":
    unittest.main()
