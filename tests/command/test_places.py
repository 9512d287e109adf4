"""What exports carry of each vertex: place at rest, parameters on the shell, velocity."""
from __future__ import annotations

import unittest

import numpy as np

from sunder_tools.pictures.between import Interval
from sunder_tools.pictures.export import glb_bytes, ply_bytes
from sunder_tools.pictures.frames import BODIES
from sunder_tools.pictures.mesh import mesh_of
from sunder_tools.pictures.motion import reference_points
from sunder_tools.pictures.pc2 import caches_of, obj_text
from sunder_tools.pictures.story import story_of
from sunder_tools.pictures.thick import normal_rates, vertex_normals
from sunder_tools.pictures.usda import usda_text

from .mesh_files import read_glb, read_obj, read_ply
from .synthetic import write_vtp
from .test_animated import SINGLE, Parting
from .usda_file import Usda

UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # from y up to z up: vectors in rows, from the right


class Places(Parting):
    def of_rest(self, rest: np.ndarray) -> np.ndarray:
        """The parameters that belong to places at rest."""
        return rest[:, :2] / self.SIDES

    def check_glb(self, attributes: dict[str, np.ndarray]) -> np.ndarray:
        """Returns places at rest, after a look at the texture coordinates of the same vertices."""
        rest, uv = attributes["_REST"] @ UP, attributes["TEXCOORD_0"] * [1, -1] + [0, 1]  # v goes down
        np.testing.assert_allclose(uv, self.of_rest(rest), atol=SINGLE)
        self.assertGreaterEqual(float(attributes["TEXCOORD_0"].min()), 0.0)
        self.assertLessEqual(float(attributes["TEXCOORD_0"].max()), 1.0)
        np.testing.assert_allclose(np.abs(rest[:, 2]), 0.5 * self.THICK, atol=1e-8)
        return rest

    def test_one_gltf(self) -> None:
        """In the shell, cracked and as a shard; velocities are those of the first frame of a mesh."""
        for name, frame, moving in (("pane_piece_1_shape_0", 0, True), ("pane_piece_2_shape_0", 2, True),
                                    ("pane_piece_2_shape_1", 3, False)):
            mesh = self.film.json["meshes"][self.film.json["nodes"][self.film.names.index(name)]["mesh"]]
            for primitive in mesh["primitives"]:
                attributes = {n: self.film.values(k) for n, k in primitive["attributes"].items()}
                rest = self.check_glb(attributes)
                self.assertEqual("_VELOCITY" in attributes, moving, name)
                self.assertEqual("_DAMAGE" in attributes, moving, name)
                if moving:
                    _, wanted = self.placed(rest, frame * self.STEP)
                    np.testing.assert_allclose(attributes["_VELOCITY"] @ UP, wanted, atol=1e-4)  # of 30 m/s

    def test_a_gltf_a_frame(self) -> None:
        for k, names in ((2, {"pane"}), (4, {"pane", "shards"})):
            nodes = read_glb(glb_bytes(mesh_of(self.frames, k, (self.THICK,)), 0.0, self.words, {}))
            self.assertEqual(set(nodes), names)
            for name, attributes in nodes.items():
                rest = self.check_glb(attributes)
                now, velocity = self.placed(rest, k * self.STEP)
                np.testing.assert_allclose(attributes["POSITION"] @ UP, now, atol=4 * SINGLE)
                if name == "pane":
                    np.testing.assert_allclose(attributes["_VELOCITY"] @ UP, velocity, atol=1e-4)

    def test_ply_and_obj(self) -> None:
        mesh = mesh_of(self.frames, 4, (self.THICK,))
        ply = read_ply(ply_bytes(mesh, 0.0))
        np.testing.assert_allclose(np.stack([ply["vertex.s"], ply["vertex.t"]], axis=1), self.of_rest(mesh.rest), atol=SINGLE)
        for cache in caches_of(story_of(self.frames, self.words, {}), len(self.frames)):
            obj = read_obj(obj_text(cache))
            np.testing.assert_allclose(obj["vt"], self.of_rest(cache.shape.rest), atol=SINGLE)

    def test_usd_velocities_are_differences_of_points(self) -> None:
        """Against the piece's own centre, in seconds of the film: here 24 pictures a second, a millisecond each."""
        film = np.arange(6.0) / 24.0
        stage = Usda(usda_text(story_of(self.frames, self.words, {}), film, 24.0, None, self.STEP * np.arange(6.0)))
        checked = 0
        for path, prim in stage.prims.items():
            if prim.kind != "Mesh":
                continue
            self.assertEqual((prim.types["primvars:st"], prim.meta["primvars:st.interpolation"]), ("texCoord2f[]", "vertex"))
            np.testing.assert_allclose(prim.values["primvars:st"], self.of_rest(np.array(prim.values["primvars:rest"])), atol=SINGLE)
            if not isinstance(prim.values["points"], dict):
                self.assertNotIn("velocities", prim.values)  # it is rigid: its Xform moves
                continue
            points, velocities = prim.values["points"], prim.values["velocities"]
            self.assertEqual((prim.types["velocities"], set(velocities)), ("vector3f[]", set(points)))
            codes = sorted(points)
            if not path.endswith("pane_piece_1/shape_1"):  # another shape follows: the last sample is on the way there
                way = 24.0 * (np.array(points[codes[-1]]) - np.array(points[codes[-2]]))
                np.testing.assert_allclose(velocities[codes[-1]], way, atol=1e-4)
                continue
            for before, code, after in zip(codes, codes[1:], codes[2:]):
                change = 12.0 * (np.array(points[after]) - np.array(points[before]))
                speed = self.SPIN * self.STEP * 24.0
                bend = (self.SPIN * self.STEP) ** 2 / 6.0 * speed * 1.2  # of a central difference; a square is 1.12 m wide
                np.testing.assert_allclose(velocities[code], change, atol=bend + 1e-3)
                self.assertGreater(float(np.abs(change).max()), 0.3 * speed)
                checked += 1
        self.assertGreater(checked, 0)

    def test_a_speed_scales_velocities_of_the_film(self) -> None:
        things = story_of(self.frames, self.words, {})
        fast, slow = (Usda(usda_text(things, np.arange(6.0), 24.0, speed)).prims["/run/pane/pane_piece_1/shape_0"].values["velocities"]
                      for speed in (1.0, 0.25))
        for code in fast:
            np.testing.assert_allclose(0.25 * np.array(fast[code]), slow[code], atol=1e-6)

    def test_bodies_between_frames_keep_their_places_at_rest(self) -> None:
        bodies, between = self.frames[4].read(BODIES), Interval(self.frames[4], self.frames[5]).bodies_at(0.3)
        assert bodies is not None and between is not None
        self.assertGreater(float(np.abs(between.points - bodies.points).max()), 1e-4)
        np.testing.assert_allclose(reference_points(between), reference_points(bodies), atol=1e-12)

    def test_older_frames_have_none(self) -> None:
        for k, frame in enumerate(self.frames):
            for part, path in frame.files.items():
                mesh = frame.read(part)
                assert mesh is not None
                write_vtp(path, mesh.points, mesh.triangles, floats="f8", cell_data={
                    name: values.astype(float) for name, values in mesh.cell_data.items()})
        things = story_of(self.frames, self.words, {})
        stage = Usda(usda_text(things, np.arange(6.0), 24.0, 1.0))
        for prim in stage.prims.values():
            self.assertFalse({"velocities", "primvars:st"} & set(prim.values))
        nodes = read_glb(glb_bytes(mesh_of(self.frames, 4, (self.THICK,)), 0.0, self.words, {}))
        self.assertNotIn("TEXCOORD_0", nodes["shards"])


class Colours(Parting):
    """Points of a mesh file with colours."""

    def more_of(self, rest: np.ndarray) -> dict[str, np.ndarray]:
        return {"colour": self.of_rest(rest)}

    @staticmethod
    def of_rest(rest: np.ndarray) -> np.ndarray:
        x, y = rest[:, 0], rest[:, 1]
        return np.stack([0.1 + 0.4 * x, 0.9 - 0.8 * y, 0.3 + 0.2 * x * y], axis=1)

    def test_one_gltf(self) -> None:
        for name in ("pane_piece_1_shape_0", "pane_piece_2_shape_0", "pane_piece_2_shape_1"):  # in the shell, cut, and a shard
            mesh = self.film.json["meshes"][self.film.json["nodes"][self.film.names.index(name)]["mesh"]]
            for primitive in mesh["primitives"]:
                attributes = {n: self.film.values(k) for n, k in primitive["attributes"].items()}
                np.testing.assert_allclose(attributes["COLOR_0"], self.of_rest(attributes["_REST"] @ UP), atol=SINGLE)

    def test_a_mesh_a_frame(self) -> None:
        for k, names in ((2, {"pane"}), (4, {"pane", "shards"})):
            mesh = mesh_of(self.frames, k, (self.THICK,))
            nodes = read_glb(glb_bytes(mesh, 0.0, self.words, {}))
            self.assertEqual(set(nodes), names)
            for attributes in nodes.values():
                np.testing.assert_allclose(attributes["COLOR_0"], self.of_rest(attributes["_REST"] @ UP), atol=SINGLE)
            ply = read_ply(ply_bytes(mesh, 0.0))
            colour = np.stack([ply[f"vertex.{name}"] for name in ("red", "green", "blue")], axis=1)
            np.testing.assert_allclose(colour, self.of_rest(mesh.rest), atol=SINGLE)

    def test_bodies_of_the_scene_have_none(self) -> None:
        mesh = mesh_of(self.frames, 4, (self.THICK,))
        mesh.colour[:3] = np.nan
        ply = read_ply(ply_bytes(mesh, 0.0))
        np.testing.assert_array_equal(ply["vertex.red"][:3], 1.0)


class NoColours(Parting):
    def test_files_without_colours_have_no_such_attribute(self) -> None:
        mesh = mesh_of(self.frames, 4, (self.THICK,))
        self.assertNotIn("vertex.red", read_ply(ply_bytes(mesh, 0.0)))
        for attributes in read_glb(glb_bytes(mesh, 0.0, self.words, {})).values():
            self.assertNotIn("COLOR_0", attributes)


class Normals(unittest.TestCase):
    def test_rates_are_differences(self) -> None:
        random = np.random.default_rng(5)
        points, velocity = random.normal(size=(9, 3)), random.normal(size=(9, 3))
        triangles = np.array([[0, 1, 2], [0, 2, 3], [3, 4, 5], [5, 6, 7], [2, 6, 3]])  # point 8 has none
        h = 1e-6
        wanted = (vertex_normals(points + h * velocity, triangles) - vertex_normals(points - h * velocity, triangles)) / (2 * h)
        np.testing.assert_allclose(normal_rates(points, velocity, triangles), wanted, atol=1e-7 * np.abs(wanted).max())


if __name__ == "__main__":
    unittest.main()
