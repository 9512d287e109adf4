"""What materials look like: by name, preset and numbers; the same in pictures, exports and on the page."""
from __future__ import annotations

import re
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from sunder_tools.pictures.faces import Slot
from sunder_tools.pictures.frames import BODIES, SHELL, Frame
from sunder_tools.pictures.glb import Glb
from sunder_tools.pictures.look import Look
from sunder_tools.pictures.materials import OPACITY, colour_of, material_of_body, material_of_shards, material_of_shell
from sunder_tools.pictures.meshes import load_scene
from sunder_tools.pictures.playback import Playback
from sunder_tools.pictures.story import Shape, Thing
from sunder_tools.pictures.usda import usda_text
from sunder_tools.report.appearance import (ACRYLIC, BRASS, CLOTH, FLOOR, FOAM, GLASS, ICE, IRON, LEAD, NAMED, PAINT, PLASTER, PLASTIC,
                                            PORCELAIN, STEEL, UNKNOWN, WOOD, appearance_of, as_linear, unknown)
from sunder_tools.report.scene_text import SCENE_COPY, parse_text, words_of

from . import REPOSITORY
from .synthetic import write_vtp

SCENE = """
materials { name: "bowl_porcelain" density: 2400 strength: 1 } materials { name: "window" preset: SODA_LIME_GLASS }
materials { name: "hull" density: 7800 } materials { name: "sheet" density: 2700 yield_stress: 2e8 }
materials { name: "stuff" density: 1200 youngs_modulus: 2e9 } materials { name: "flag" density: 20 youngs_modulus: 3.2e3 }
materials { name: "painted_steel" density: 7800 yield_stress: 1e9 } materials { name: "environment" density: 1 }
shells { name: "bowl" material: "bowl_porcelain" thickness_m: 0.003 } shells { name: "door" material: "painted_steel" }
shells { name: "pane" material: "window" }
bodies { name: "ball" material: "hull" } bodies { name: "post" } bodies { name: "block" material: "stuff" }"""
LIGHT, DARK = 0.85, 0.30  # of a colour's largest part


class Table(unittest.TestCase):
    def test_a_material_looks_like_its_name_preset_or_numbers(self) -> None:
        looks = dict(words_of(parse_text(SCENE), []).appearances)
        self.assertEqual(looks, {"bowl_porcelain": PORCELAIN, "window": GLASS, "hull": STEEL, "sheet": STEEL,
                                 "stuff": looks["stuff"], "flag": CLOTH, "painted_steel": PAINT, "environment": looks["environment"]})
        self.assertEqual((looks["stuff"].colour, looks["stuff"].kind), (UNKNOWN[4], "plain"))
        self.assertEqual(looks["environment"].colour, UNKNOWN[7])  # "iron" is no part of its own
        self.assertEqual(words_of(parse_text(SCENE), []).glass, (False, False, True))

    def test_each_word_says_what_it_means(self) -> None:
        for look, words in NAMED:
            for word in words:
                for name in (word, f"old_{word}", f"{word.capitalize()}2"):
                    found = dict(words_of(parse_text(f'materials {{ name: "{name}" density: 7800 }}'), []).appearances)[name]
                    self.assertEqual(found, look, name)

    def test_plaster_is_not_glass_though_it_breaks(self) -> None:
        self.assertEqual(appearance_of("plaster", "", 1200.0, 5e9, False, 0), PLASTER)
        unnamed = dict(words_of(parse_text('materials { name: "a" density: 1200 youngs_modulus: 5e9 strength: 3e6 fracture_energy: 5 }'), []).appearances)["a"]
        self.assertNotEqual(unnamed.kind, GLASS.kind)
        self.assertEqual((PLASTER.kind, PLASTER.clear), ("plain", False))

    def test_short_words_count_as_whole_parts_alone(self) -> None:
        for name, look in (("carbon_steel", STEEL), ("CarbonFibre", PLASTIC), ("painted_glass", GLASS), ("glass_fibre", PLASTIC),
                           ("fibre_glass", PLASTIC), ("glass_wool", FOAM), ("ice", ICE), ("castIron", IRON), ("lead_foil", LEAD),
                           ("plywood", WOOD), ("reinforcement_steel", STEEL), ("lead_glass", GLASS), ("oak2", WOOD)):
            self.assertEqual(appearance_of(name, "", 1e3, 1e9, False, 0), look, name)
        for name in ("absorber", "spine", "pineapple", "embark", "leading_edge", "leader", "rocket", "cloak", "device", "airfoil",
                     "marigold", "displacement", "carbon"):
            self.assertEqual(appearance_of(name, "", 1e3, 1e9, False, 0), unknown(0), name)

    def test_colours_are_colours_and_none_is_black(self) -> None:
        for colour in (*(look.colour for look, _ in NAMED), *UNKNOWN):
            self.assertTrue(DARK < max(colour) <= 1.0 and min(colour) >= 0.0)
        self.assertGreater(min(PORCELAIN.colour), LIGHT)
        self.assertEqual(as_linear((0.0, 1.0, 0.5)), (0.0, 1.0, 0.21404114048223255))  # IEC 61966-2-1

    def test_scenes_that_ship_name_their_materials(self) -> None:
        """No scene of the project is drawn in a colour that stands for nothing known."""
        for path in sorted((REPOSITORY / "scenes").rglob("*.textproto")):
            for name, look in words_of(parse_text(path.read_text()), []).appearances:
                self.assertNotIn(look.colour, UNKNOWN, f"{path.name}: {name}")


class Pictures(unittest.TestCase):
    def test_shells_bodies_and_exports_have_one_colour(self) -> None:
        words = words_of(parse_text(SCENE), [])
        look = Look.of_words(words)
        self.assertEqual(look.colours, (PORCELAIN.colour, PAINT.colour, GLASS.colour))
        self.assertEqual([material_of_shell(k, words) for k in range(4)], [
            ("bowl_porcelain", PORCELAIN), ("painted_steel", PAINT), ("window", GLASS), ("shell_3", unknown(3))])
        self.assertEqual([colour_of(one) for one in (GLASS, PAINT)], [(*GLASS.colour, OPACITY), PAINT.colour])
        self.assertEqual(material_of_shards(-1, words), ("bowl_porcelain", PORCELAIN))
        self.assertEqual([material_of_body(k, words) for k in (1, 2, 3, 4)], [
            ("hull", STEEL), ("post", STEEL), ("stuff", unknown(4)), ("body_4", STEEL)])

    def test_gltf_and_usd_have_the_table_s_numbers(self) -> None:
        looks = {"glass": GLASS, "acrylic": ACRYLIC, "steel": STEEL, "porcelain": PORCELAIN}
        out = Glb("test", {})
        for name, look in looks.items():
            self.assertEqual(out.material(name, look), out.material(name, STEEL), "a name has one material")
        self.assertEqual(out.json["extensionsUsed"], ["KHR_materials_transmission", "KHR_materials_ior"])
        for name, look in looks.items():
            material, = [one for one in out.json["materials"] if one["name"] == name]
            surface, more = material["pbrMetallicRoughness"], material.get("extensions", {})
            self.assertEqual((surface["metallicFactor"], surface["roughnessFactor"]), (float(name == "steel"), look.roughness))
            clear = name in ("glass", "acrylic")  # light goes through two faces of a sheet
            np.testing.assert_allclose(np.array(surface["baseColorFactor"][:3]) ** (2 if clear else 1), as_linear(look.colour), atol=2e-4)
            self.assertEqual((material["alphaMode"], surface["baseColorFactor"][3]), ("OPAQUE", 1.0))
            self.assertEqual(more, {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": 1.52}}
                             if clear else {})
        slots = [Slot(name, look, 0, 3, np.array([[0, 1, 2]])) for name, look in looks.items()]
        none = np.full((3, 3), np.nan)
        shape = Shape(slots, 0, 0, [np.eye(3)], [np.eye(3)], none, none[:, 0], none[:, :2], none)
        text = usda_text([Thing("one", "", [0], [np.zeros(3)], [np.array([0.0, 0, 0, 1])], [shape])], np.zeros(1), 24.0, None)
        found = re.findall(r'Material "(\w+)".*?inputs:opacity = (\S+).*?inputs:metallic = (\S+).*?inputs:roughness = (\S+)', text, re.S)
        self.assertEqual({name: tuple(map(float, rest)) for name, *rest in found}, {
            name: (OPACITY if look.kind == "glass" else 1.0, float(look is STEEL), look.roughness) for name, look in looks.items()})

    def test_a_body_without_a_material_takes_no_material_s_name(self) -> None:
        words = words_of(parse_text("""materials { name: "glass" density: 2500 } materials { name: "plate" density: 900 }
            shells { name: "pane" material: "glass" } bodies { name: "glass" } bodies { name: "glass_edge" } bodies { name: "plate" }
            bodies { name: "block" material: "plate" } bodies { name: "floor" half_space {} }"""), [])
        self.assertEqual([material_of_body(k, words)[0] for k in range(1, 6)],
                         ["glass_body", "glass_edge_body", "plate_body", "plate", "floor"])
        self.assertEqual([material_of_body(k, words)[1] for k in (1, 5)], [STEEL, FLOOR])

    def test_the_page_is_told_the_same_colours(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            (Path(name) / SCENE_COPY).write_text(SCENE)
            state = Playback(Path(name)).state()
        self.assertEqual([shell["colour"] for shell in state["shells"]], [PORCELAIN.colour, PAINT.colour, GLASS.colour])
        self.assertEqual(list(state["body_colours"]), [STEEL.colour, (), UNKNOWN[4]])

    def test_a_frame_is_drawn_in_the_colours_of_its_materials(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            shell, bodies = Path(name) / "shell.vtp", Path(name) / "bodies.vtp"
            corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
            write_vtp(shell, corners, [[0, 1, 2]], cell_data={"fragment": np.zeros(1), "damage": np.zeros(1), "shell": np.zeros(1)})
            write_vtp(bodies, [[x, y, z - 1.0 - k] for k in range(4) for x, y, z in corners], np.arange(12).reshape(4, 3),
                      cell_data={"body": np.array([1.0, 2, 3, 9]), "kind": np.array([0.0, 0, 0, 1])})
            frame = Frame(0.0, {SHELL: shell, BODIES: bodies})
            for material, look in (("porcelain", PORCELAIN), ("plywood", WOOD), ("bumper_plastic", PLASTIC)):
                words = words_of(parse_text(f"""materials {{ name: "{material}" density: 900 }} materials {{ name: "brass" density: 8500 }}
                    shells {{ name: "one" material: "{material}" }} bodies {{ name: "a" material: "brass" }} bodies {{ name: "b" }}
                    bodies {{ name: "c" material: "{material}" }}"""), [])
                scene = load_scene(frame, Look.of_words(words, part_of={9: 0}))
                base = [look.colour, BRASS.colour, STEEL.colour, look.colour]
                whole = np.array(sorted(map(tuple, scene.solid.colours.round(6))))
                for colour in base:
                    self.assertLess(np.abs(whole - colour).max(axis=1).min(), 1e-6, material)
                self.assertEqual(len(whole), 5, "the shard too")
            clear = words_of(parse_text('materials { name: "acrylic" } shells { name: "one" material: "acrylic" }'), [])
            np.testing.assert_allclose(load_scene(frame, Look.of_words(clear)).glass.colours[0], ACRYLIC.colour)
            of_body = words_of(parse_text("""materials { name: "glass" } materials { name: "wood" }
                shells { name: "one" material: "wood" } bodies { name: "a" material: "glass" } bodies { name: "b" }"""), [])
            scene = load_scene(frame, Look.of_words(of_body))
            np.testing.assert_allclose(scene.glass.colours, [GLASS.colour])
            self.assertEqual(len(scene.solid.triangles), 4)
            self.assertEqual(material_of_body(1, of_body), ("glass", GLASS))

    def test_what_remains_of_several_shells_has_the_material_of_each(self) -> None:
        """A frozen piece of two shells: its pairs of points are as far apart as its shells are thick."""
        words = words_of(parse_text("""materials { name: "brass" } materials { name: "glass" strength: 1 } materials { name: "clay" }
            shells { name: "cap" material: "brass" thickness_m: 0.001 } shells { name: "globe" material: "glass" thickness_m: 0.002 }
            shells { name: "foot" material: "clay" thickness_m: 0.002 }"""), [])
        points = np.array([[x, 0.0, z] for thick in (0.001, 0.002, 0.005) for x in (0.0, 1.0, 2.0) for z in (0.0, thick)])
        triangles = np.array([[1, 3, 5], [7, 9, 11], [13, 15, 17], [0, 4, 2]])
        unknown = np.array([-1, -1, -1, 2])
        look = Look.of_words(words)
        np.testing.assert_array_equal(look.parts_by_thickness(points, triangles, unknown), [0, -1, -1, 2])  # glass or clay
        two = replace(look, thickness=(0.001, 0.002, 0.003))
        np.testing.assert_array_equal(two.parts_by_thickness(points, triangles, unknown), [0, 1, -1, 2])
        one = replace(look, colours=(look.colours[0],) * 3)
        np.testing.assert_array_equal(one.parts_by_thickness(points, triangles, unknown), [0, 0, 0, 2])
        np.testing.assert_array_equal(Look().parts_by_thickness(points, triangles, unknown), unknown)

    def test_what_is_frozen_has_the_material_of_the_shell_that_was_there(self) -> None:
        places = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
        look = replace(Look(), last=(places, np.array([4, 2])))
        points = np.array([[x, 0.1, z] for x in (0.1, 0.2, 0.3, 0.8, 0.9, 1.2) for z in (-0.01, 0.01)])
        triangles = np.array([[1, 3, 5], [7, 9, 11], [0, 4, 2], [6, 8, 10]])
        frozen, part = np.array([True, True, False, True]), np.array([-1, -1, -1, 1])
        np.testing.assert_array_equal(look.parts_of_frozen(points, triangles, part, frozen), [4, 2, -1, 1])
        np.testing.assert_array_equal(Look().parts_of_frozen(points, triangles, part, frozen), part)


if __name__ == "__main__":
    unittest.main()
