"""Shells as solids in frames, and what pieces keep of them, with the real programs."""
from __future__ import annotations

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from sunder_tools.pictures.frames import BODIES, SHARD, SHELL, list_frames
from sunder_tools.pictures.motion import parameters, reference_points
from sunder_tools.pictures.vtp import PolyData, read_vtp

TOP = Path(__file__).resolve().parents[2]
BUILD = os.environ["SUNDER_BUILD_DIR"]
OUTSIDE, INSIDE, EDGE = 0, 1, 2
THICKNESS, SIZE = 0.004, 0.3  # [m] of the pane in the scene
ARRAYS = ["c_his", "damage", "face_kind", "fragment", "shell"]


def volume_of(mesh: PolyData, which: np.ndarray) -> float:
    a, b, c = mesh.points[mesh.triangles[which]].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def areas_of(mesh: PolyData) -> np.ndarray:
    a, b, c = mesh.points[mesh.triangles].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


class CutPane(unittest.TestCase):
    """A square is cut out of a pane at 4e-4 s; it leaves."""
    out: Path
    bare: Path

    @classmethod
    def setUpClass(cls) -> None:
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        scene = (TOP / "scenes" / "cut_pane.textproto").read_text().replace("end_time_s: 0.5", "end_time_s: 2e-3").replace(
            "time_s: 5e-4", "time_s: 4e-4").replace("frame_interval_s: 0.02 shell", "shell")
        cls.out, cls.bare = (cls.run_scene(Path(temporary.name) / name, scene.replace("output {", "output { " + more))
                             for name, more in (("thick", "thick_shells: true "), ("bare", "")))

    @classmethod
    def run_scene(cls, out: Path, text: str) -> Path:
        out.mkdir()
        (out / "given.textproto").write_text(text)
        subprocess.run([f"{BUILD}/coupler/single/sunder-single", "--engine", "bullet", "--scene", str(out / "given.textproto"),
                        "--out", str(out), "--quiet"], check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        return out

    def test_each_frame_has_solids_of_the_area_times_the_thickness(self) -> None:
        cut = 0
        for frame in list_frames(self.out):
            shell = frame.read(SHELL)
            if shell is None:
                continue
            solid = read_vtp(Path(str(frame.files[SHELL]).replace("shell_", "thick_")))
            self.assertEqual(sorted(solid.cell_data), ARRAYS)
            runs = np.concatenate([solid.triangles[:, [0, 1]], solid.triangles[:, [1, 2]], solid.triangles[:, [2, 0]]])
            there, back = (np.unique(pairs, axis=0, return_counts=True) for pairs in (runs, runs[:, ::-1]))
            np.testing.assert_array_equal(there[0], back[0])  # each edge is run along once in each direction
            self.assertEqual((there[1].max(), back[1].max()), (1, 1), "two faces an edge")
            kind, area = solid.of_triangles("face_kind", -1), areas_of(solid)
            piece, of_middle = solid.of_triangles("fragment", 0), shell.of_triangles("fragment", 0)
            for one in np.unique(of_middle):  # each piece is closed by itself
                wanted = areas_of(shell)[of_middle == one].sum() * THICKNESS
                self.assertAlmostEqual(volume_of(solid, piece == one) / wanted, 1.0, delta=1e-4)  # it bends by micrometres
            for side in (OUTSIDE, INSIDE):
                self.assertAlmostEqual(area[kind == side].sum() / areas_of(shell).sum(), 1.0, delta=1e-4)
            rim = area[kind == EDGE].sum() / THICKNESS
            if len(np.unique(of_middle)) == 2:  # both faces of the cut
                cut += 1
                self.assertAlmostEqual(rim, 4 * SIZE + 2 * 0.39145, delta=0.02)
            elif frame.time_s < 4e-4:
                self.assertAlmostEqual(rim, 4 * SIZE, delta=1e-3)
            rest = reference_points(solid)
            self.assertAlmostEqual(float(np.abs(rest[:, 2] - 0.1).max()), 0.5 * THICKNESS, places=9)
            np.testing.assert_allclose(np.unique(rest[:, 2].round(9)), 0.1 + THICKNESS * np.array([-0.5, 0.5]))
        self.assertGreater(cut, 0)

    def test_they_are_listed_by_themselves(self) -> None:
        listed, thick = ([(float(e.attrib["timestep"]), e.attrib["name"]) for e in ElementTree.parse(
            self.out / f"{name}.pvd").getroot().iter("DataSet")] for name in ("frames", "thick"))
        self.assertEqual({name for _, name in listed}, {"shell", "cracks", "bodies"})
        self.assertEqual([(t, "shell" if n == "thick" else n) for t, n in thick], [(t, n) for t, n in listed if n != "cracks"])

    def test_nothing_else_changes(self) -> None:
        self.assertFalse((self.bare / "thick.pvd").exists())
        self.assertEqual(list((self.bare / "frames").glob("thick_*")), [])
        for file in sorted((self.bare / "frames").iterdir()):
            self.assertEqual(file.read_bytes(), (self.out / "frames" / file.name).read_bytes(), file.name)
        asked, plain = (json.loads((folder / "run.json").read_text()) for folder in (self.out, self.bare))
        self.assertEqual(asked["state_hash"], plain["state_hash"])
        self.assertEqual([m["name"] for m in asked["models"] if m not in plain["models"] and m["name"] == "thick_shells"],
                         ["thick_shells"])

    def test_parameters_are_those_of_the_place_at_rest_in_the_shell_and_as_a_shard(self) -> None:
        left = 0
        for frame in list_frames(self.out):
            for part in (SHELL, BODIES):
                mesh = frame.read(part)
                if mesh is None or "uv" not in mesh.point_data:
                    continue
                used = np.unique(mesh.triangles if part == SHELL else mesh.triangles[mesh.of_triangles("kind", 0) == SHARD])
                uv, rest = parameters(mesh)[used], reference_points(mesh)[used]
                self.assertGreaterEqual(float(uv.min(initial=0.0)), 0.0)
                self.assertLessEqual(float(uv.max(initial=0.0)), 1.0)
                # the cut square lies between 0.1 and 0.21 m of one corner
                np.testing.assert_allclose(rest[:, :2] - self.corner(), SIZE * uv, atol=1e-12)
                if part == BODIES and len(used):
                    left += 1
                    self.assertTrue((uv > 0.3).all() and (uv < 0.71).all())
                    np.testing.assert_allclose(np.unique(rest[:, 2].round(9)), 0.1 + THICKNESS * np.array([-0.5, 0.5]))
        self.assertGreater(left, 0)

    def corner(self) -> np.ndarray:
        """The corner of the pane at rest at which its parameters are zero [m]."""
        shell = list_frames(self.out)[0].read(SHELL)
        assert shell is not None
        return reference_points(shell)[:, :2].min(axis=0)


if __name__ == "__main__":
    unittest.main()
