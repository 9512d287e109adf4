"""Frames of a run, with the real programs: each time once, and cracks of a time in the frame of that time."""
from __future__ import annotations

import os
import subprocess
import tempfile
import unittest
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from sunder_tools.pictures.crack_lines import graph_of
from sunder_tools.pictures.frames import BODIES, CARRIED, CRACKS, SHELL, list_frames
from sunder_tools.pictures.look import Look
from sunder_tools.pictures.meshes import load_scene
from sunder_tools.report.scene_text import parse_text, words_of

TOP = Path(__file__).resolve().parents[2]
BUILD = os.environ["SUNDER_BUILD_DIR"]
SCENE = TOP / "scenes" / "cut_pane.textproto"


class Frames(unittest.TestCase):
    def run_scene(self, out: Path, *arguments: str) -> None:
        done = subprocess.run([TOP / "coupler" / "sunder", "run", *arguments, "--quiet", "--no-pictures"], cwd=out.parent,
                              env={**os.environ, "SUNDER_BUILD_DIR": BUILD}, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def entries(self, folder: Path) -> list[tuple[float, int]]:
        """Time and part of each entry, as ParaView reads them."""
        root = ElementTree.parse(folder / "frames.pvd").getroot()
        return [(float(e.attrib["timestep"]), int(e.attrib["part"])) for e in root.iter("DataSet")]

    def test_each_time_is_there_once(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            # the end is a frame that is due, or between two of them; the shell lives to the end, or is frozen before
            for out, until, settings in (("due", "6e-4", ("output.checkpoint_interval_s=1e-4",)), ("between", "7e-4", ()),
                                         ("frozen", "4e-3", ("fracture.latest_freeze_s=1e-3", "output.frame_interval_s=1e-3")),
                                         ("once", "2e-4", ("output.shell_frame_interval_s=1",))):
                folder = Path(name) / out
                self.run_scene(folder, str(SCENE), "--until", until, "--out", str(folder),
                               *(word for setting in settings for word in ("--set", setting)))
                found = self.entries(folder)
                self.assertEqual([entry for entry, count in Counter(found).items() if count > 1], [], out)
                self.assertEqual(max(time for time, _ in found), float(until), out)
                self.assertEqual(len(list((folder / "frames").glob("bodies_*.vtp"))), len(list_frames(folder)), out)
            self.assertEqual([frame.time_s for frame in list_frames(Path(name) / "due")], [0.0, 2e-4, 4e-4, 6e-4])
            self.run_scene(Path(name) / "due", "--resume", str(Path(name) / "due"), "--until", "6e-4")
            self.assertEqual([frame.time_s for frame in list_frames(Path(name) / "due")], [0.0, 2e-4, 4e-4, 6e-4])

    def test_cuts_are_in_the_frame_of_their_time(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            for when, frames in (("0", 0), ("4e-4", 2)):
                folder = Path(name) / when
                self.run_scene(folder, str(SCENE), "--until", "6e-4", "--out", str(folder), "--set",
                               f"shells[pane].cuts[0].time_s={when}")
                found = list_frames(folder)
                self.assertEqual([frame.time_s for frame in found], [0.0, 2e-4, 4e-4, 6e-4])
                for k, frame in enumerate(found):
                    lines, shell = graph_of(frame.read(CRACKS), ""), frame.read(SHELL)
                    assert shell is not None
                    self.assertEqual(len(lines) > 0, k >= frames, f"cut at {when} s, frame {k}")
                    if k == frames:
                        self.assertEqual(len(set(shell.of_triangles("fragment", 0).tolist())), 2)
                        self.assertEqual(set(lines.born.tolist()), {float(when)})

    def test_a_laminate_takes_its_cracks_along_when_it_becomes_a_body(self) -> None:
        film = """materials { name: "film" density: 1070 youngs_modulus: 2e7 poisson_ratio: 0.45 }
            shells { interlayer { material: "film" thickness_m: 0.00076 }"""
        scene = SCENE.read_text().replace("time_s: 5e-4", "time_s: 0").replace("shells {", film, 1)
        with tempfile.TemporaryDirectory() as name:
            for out, support in (("held", True), ("falls", False)):
                folder, file = Path(name) / out, Path(name) / f"{out}.textproto"
                file.write_text(scene if support else scene.replace("supports { edges: ALL kind: CLAMPED }", ""))
                self.run_scene(folder, str(file), "--until", "9e-3", "--out", str(folder), "--set",
                               "fracture.latest_freeze_s=3e-3", "--set", "output.frame_interval_s=1e-3")
                found = list_frames(folder)
                before = [frame.read(CRACKS) for frame in found if CRACKS in frame.files][-1]
                after = [frame for frame in found if SHELL not in frame.files]
                self.assertGreater(len(after), 4, out)
                height = []
                assert before is not None
                self.assertGreater(len(before.segments()), 0)
                for frame in after:
                    carried, bodies = frame.read(CARRIED), frame.read(BODIES)
                    assert carried is not None and bodies is not None
                    np.testing.assert_array_equal(carried.cell_data["crack"], before.cell_data["crack"])
                    np.testing.assert_allclose(carried.points - carried.point_data["displacement"],
                                               before.points - before.point_data["displacement"], atol=1e-12)
                    of_piece = np.unique(bodies.triangles[bodies.of_triangles("body", 0) > 1])
                    middle = 0.5 * (bodies.points[of_piece].min(0) + bodies.points[of_piece].max(0))
                    height.append(carried.points[:, 2].mean())
                    self.assertAlmostEqual(height[-1], middle[2], delta=2e-4)  # of a pane of 4 mm
                fallen = 0.0 if support else 0.5 * 9.81 * (after[-1].time_s ** 2 - after[0].time_s ** 2)
                self.assertAlmostEqual(height[0] - height[-1], fallen, delta=1e-5)
                drawn = load_scene(after[-1], Look.of_words(words_of(parse_text(file.read_text()), [])))
                self.assertEqual(len(drawn.cracks), len(before.segments()))
                self.assertEqual(drawn.thickness_m, 0.004)


if __name__ == "__main__":
    unittest.main()
