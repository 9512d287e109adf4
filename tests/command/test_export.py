"""Exported meshes: what other programs would read, and sheets with their thickness."""
from __future__ import annotations

import json
import os
import re
import unittest

import numpy as np

from sunder_tools.pictures.export import glb_bytes
from sunder_tools.pictures.frames import BODIES, SHELL, list_frames
from sunder_tools.pictures.mesh import mesh_of
from sunder_tools.pictures.thick import EDGE, INSIDE, OUTSIDE, corner_normals, sheet_points, sheet_topology
from sunder_tools.report.scene_text import SCENE_COPY, Words

from .mesh_files import read_glb, read_ply
from .synthetic import THICKNESS_M, ball, write_vtp
from .test_render import OfARun
from .test_view import InAFolder

SCENE = '''materials { name: "glass" density: 2500 strength: 1 }
shells { name: "pane" material: "glass" thickness_m: 0.004 }
bodies { name: "ball" material: "steel" }'''


class Export(OfARun):
    def test_ply_has_what_the_frames_have(self) -> None:
        status, said = self.sunder("export")
        self.assertEqual(status, 0, said)
        frames = list_frames(self.folder)
        folder = self.folder / "export"
        self.assertEqual(len(list(folder.glob("*.ply"))), 9)
        times = (folder / "frame_times.csv").read_text().splitlines()
        self.assertEqual([float(row.split(",")[1]) for row in times[1:]], [f.time_s for f in frames])
        for k in (0, 4, 8):
            ply = read_ply((folder / f"frame_{k:06d}.ply").read_bytes())
            shell, bodies = frames[k].read(SHELL), frames[k].read(BODIES)
            assert bodies is not None
            n, m = (len(shell.points), len(shell.triangles)) if shell is not None else (0, 0)
            points = np.stack([ply[f"vertex.{a}"] for a in "xyz"], axis=1)
            np.testing.assert_allclose(points[n:], bodies.points, atol=1e-7)  # single precision
            np.testing.assert_array_equal(ply["face.vertex_indices"][m:] - n, bodies.triangles)
            np.testing.assert_array_equal(ply["face.kind"][m:], bodies.of_triangles("kind", 0))
            np.testing.assert_array_equal(ply["face.part"][m:], -1)
            if shell is not None:
                np.testing.assert_allclose(points[:n], shell.points, atol=1e-7)
                np.testing.assert_array_equal(ply["face.vertex_indices"][:m], shell.triangles)
                np.testing.assert_array_equal(ply["face.fragment"][:m], shell.of_triangles("fragment", 0))
                np.testing.assert_allclose(ply["face.damage"][:m], shell.of_triangles("damage", 0), rtol=1e-6)
        ball = read_ply((folder / "frame_000002.ply").read_bytes())
        mine = np.unique(ball["face.vertex_indices"][(ball["face.body"] == 0) & (ball["face.kind"] == 0)])
        np.testing.assert_allclose(ball["vertex.vz"][mine], -20.0, rtol=1e-5)

    def test_gltf_has_what_the_frames_have(self) -> None:
        status, said = self.sunder("export", "--format", "gltf", "--frames", "4,last")
        self.assertEqual(status, 0, said)
        frames = list_frames(self.folder)
        for k in (4, 8):
            nodes = read_glb((self.folder / "export" / f"frame_{k:06d}.glb").read_bytes())
            mesh = mesh_of(frames, k)
            corners = np.concatenate([node["POSITION"][node["index"].ravel()] for node in nodes.values()])
            wanted = mesh.points[mesh.triangles].reshape(-1, 3)[:, [0, 2, 1]] * [1, 1, -1]
            self.assertEqual(corners.shape, wanted.shape)
            self.assertEqual("shards" in nodes, k > 3)
            order = [np.lexsort(a.round(5).T) for a in (corners, wanted)]
            np.testing.assert_allclose(corners[order[0]], wanted[order[1]], atol=2e-5)

    def test_nothing_but_air(self) -> None:
        write_vtp(self.folder / "frames/shell_000000.vtp", [])
        write_vtp(self.folder / "frames/bodies_000000.vtp", [])
        for kind in ("ply", "gltf"):
            self.assertEqual(self.sunder("export", "--format", kind, "--frames", "0")[0], 0)
        ply = (self.folder / "export" / "frame_000000.ply").read_bytes()
        self.assertTrue(re.search(rb"element face 0\n", ply) and ply.endswith(b"end_header\n"))

    def test_where_it_cannot_write_it_says_so(self) -> None:
        (self.folder / "taken").write_text("a file")
        status, said = self.sunder("export", "--out", str(self.folder / "taken"))
        self.assertEqual(status, 2)
        self.assertRegex(said, "cannot write .*taken")


class Sheets(InAFolder):
    """A pane of 1 by 1 m with a crack along x = 0.5, whose faces are `GAP` apart."""
    GAP, THICK = 0.002, 0.01

    def setUp(self) -> None:
        super().setUp()
        (self.folder / "frames").mkdir()
        left, right = 0.5 - 0.5 * self.GAP, 0.5 + 0.5 * self.GAP
        corners: list[list[float]] = [[0, 0], [left, 0], [left, 1], [0, 1], [right, 0], [1, 0], [1, 1], [right, 1]]
        self.points = np.array([[x, y, 0.0] for x, y in corners])
        self.triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
        write_vtp(self.folder / "frames/shell.vtp", self.points, self.triangles, cell_data={
            "fragment": np.zeros(4), "damage": np.array([0.0, 0.5, 0, 1]), "shell": np.zeros(4)}, floats="f8")
        (self.folder / "frames.pvd").write_text('<VTKFile><Collection><DataSet timestep="0" part="0" file="frames/shell.vtp"/>'
                                                '</Collection></VTKFile>')

    def test_a_crack_is_an_open_gap_with_faces(self) -> None:
        mesh = mesh_of(list_frames(self.folder), 0, (self.THICK,))
        a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
        self.assertAlmostEqual(float((a * np.cross(b, c)).sum() / 6.0), (1.0 - self.GAP) * self.THICK, places=12)
        area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        for side, whole in ((OUTSIDE, 1.0 - self.GAP), (INSIDE, 1.0 - self.GAP), (EDGE, self.THICK * (6.0 - 2.0 * self.GAP))):
            self.assertAlmostEqual(float(area[mesh.side == side].sum()), whole, places=12)
        self.assertTrue((np.cross(b - a, c - a)[mesh.side == OUTSIDE][:, 2] > 0).all())
        directed = np.concatenate([mesh.triangles[:, [0, 1]], mesh.triangles[:, [1, 2]], mesh.triangles[:, [2, 0]]])
        there = {tuple(e) for e in directed.tolist()}
        self.assertEqual(len(there), len(directed), "an edge twice in one direction")
        self.assertTrue(all((j, i) in there for i, j in there), "not closed")
        np.testing.assert_array_equal(mesh.damage[mesh.side == OUTSIDE], [0, 0.5, 0, 1])

    def test_faces_of_a_curved_sheet_are_half_a_thickness_off(self) -> None:
        points, triangles = ball(1.0, 40)
        inner = np.abs(points[:, 2]) < 0.9  # poles are many points
        triangles = triangles[inner[triangles].all(axis=1)]
        thick = np.full(len(points), 0.02)
        made = sheet_points(points, triangles, thick)
        faces, side, _ = sheet_topology(triangles)
        for which, radius in ((OUTSIDE, 1.01), (INSIDE, 0.99)):
            used = np.unique(faces[side == which])
            # the normal is that of the facets: at the border it is off by half of what they turn, 4 degrees
            np.testing.assert_allclose(np.linalg.norm(made[used], axis=1), radius, atol=0.01 * (1 - np.cos(np.pi / 40)) * 2)

    def test_normals_are_smooth_but_at_edges(self) -> None:
        points, triangles = ball(1.0, 40)
        normals = corner_normals(points, triangles, np.arange(len(points)))
        self.assertGreater(float((normals * points[triangles]).sum(axis=2).min()), np.cos(1.5 * np.pi / 40))  # of one facet at a pole
        mesh = mesh_of(list_frames(self.folder), 0, (self.THICK,))
        normals = corner_normals(mesh.points, mesh.triangles, np.arange(len(mesh.points)))
        np.testing.assert_allclose(np.abs(normals[mesh.side == OUTSIDE][:, :, 2]), 1.0, atol=1e-12)
        np.testing.assert_allclose(normals[mesh.side == EDGE][:, :, 2], 0.0, atol=1e-12)

    def test_a_thickness_that_is_not_known_leaves_the_middle_surface(self) -> None:
        for known in ((), (np.nan,)):
            mesh = mesh_of(list_frames(self.folder), 0, known)
            np.testing.assert_array_equal(mesh.triangles, self.triangles)
            self.assertEqual(list(read_glb(glb_bytes(mesh, 0.0, Words(), {}))), ["shell_0"])


class ThickRuns(OfARun):
    def tell(self, *settings: str) -> None:
        """Makes the run one without a copy of its scene."""
        (self.folder / SCENE_COPY).unlink(missing_ok=True)
        (self.folder / "scene.textproto").write_text(SCENE)
        (self.folder / "command.json").write_text(json.dumps({"scene": str(self.folder / "scene.textproto"),
                                                              "settings": list(settings)}))

    def nodes(self, *arguments: str) -> dict[str, dict[str, np.ndarray]]:
        status, said = self.sunder("export", "--format", "gltf", "--frames", "4", *arguments)
        self.assertEqual(status, 0, said)
        return read_glb((self.folder / "export" / "frame_000004.glb").read_bytes())

    def thickness(self, pane: dict[str, np.ndarray]) -> float:
        """Distance of both points of a pair [m]: slots come outside, inside, edge, with the same triangles in each."""
        outside, inside = (pane["POSITION"][pane["index"].reshape(-1, 3)[pane["slot"] == f"glass_{s}"]] for s in ("outside",
                                                                                                                "inside"))
        return float(np.linalg.norm(outside - inside[:, ::-1], axis=2).mean())

    def test_slots_are_outside_inside_and_edge_of_shells_and_of_shards(self) -> None:
        self.tell()
        nodes = self.nodes()
        for name in ("pane", "shards"):
            self.assertEqual(set(nodes[name]["slot"]), {"glass_outside", "glass_inside", "glass_edge"})
        self.assertAlmostEqual(self.thickness(nodes["pane"]), THICKNESS_M, delta=1e-7)
        self.assertAlmostEqual(self.thickness(nodes["shards"]), THICKNESS_M, delta=1e-7)
        self.assertEqual(len(set(nodes["ball"]["slot"])) if "ball" in nodes else 1, 1)

    def test_the_thickness_is_that_of_the_run(self) -> None:
        for at in ("pane", "0"):
            self.tell(f"shells[{at}].thickness_m=0.01")
            self.assertAlmostEqual(self.thickness(self.nodes()["pane"]), 0.01, delta=1e-7)

    def test_the_copy_counts_whatever_became_of_the_scene(self) -> None:
        self.tell("shells[pane].thickness_m=0.01")
        (self.folder / SCENE_COPY).write_text(SCENE.replace("0.004", "0.02"))
        self.assertAlmostEqual(self.thickness(self.nodes()["pane"]), 0.02, delta=1e-7)
        (self.folder / "scene.textproto").unlink()
        self.assertAlmostEqual(self.thickness(self.nodes()["pane"]), 0.02, delta=1e-7)

    def test_a_scene_that_is_not_known_is_refused(self) -> None:
        self.tell()
        scene = self.folder / "scene.textproto"
        later = (self.folder / "command.json").stat().st_mtime + 2.0
        os.utime(scene, (later, later))
        for more in ((), ("--format", "gltf"), ("--gltf", str(self.folder / "a.glb")), ("--middle",)):
            status, said = self.sunder("export", *more)
            self.assertEqual(status, 2)
            self.assertRegex(said, f"no {SCENE_COPY}, and .*scene.textproto has changed since; .* put the scene as it was run")
        scene.unlink()
        self.assertRegex(self.sunder("export")[1], "scene.textproto: No such file")
        (self.folder / "command.json").unlink()
        self.assertRegex(self.sunder("export")[1], "no command.json that names the scene")
        self.assertFalse((self.folder / "export").exists())
        (self.folder / SCENE_COPY).write_text(SCENE)  # the remedy
        self.assertEqual(self.sunder("export")[0], 0)

    def test_middle_surfaces_on_request(self) -> None:
        self.tell()
        self.assertEqual(set(self.nodes("--middle")["pane"]["slot"]), {"glass"})


if __name__ == "__main__":
    unittest.main()
