"""What is frozen and is of several shells: each has its material, and pictures have no lines along its seams."""
from __future__ import annotations

import json
import shutil
import struct
import subprocess

import numpy as np

from sunder_tools.pictures.export import glb_bytes
from sunder_tools.pictures.frames import list_frames
from sunder_tools.pictures.look import Look
from sunder_tools.pictures.mesh import mesh_of
from sunder_tools.pictures.meshes import load_scene
from sunder_tools.pictures.playback import pack_frame
from sunder_tools.pictures.story import story_of
from sunder_tools.report.scene_text import Words, parse_text, words_of

from . import REPOSITORY
from .mesh_files import read_glb
from .synthetic import write_vtp
from .test_view import InAFolder

SCENE = """materials { name: "plastic" density: 500 strength: 1 } materials { name: "window_glass" density: 300 strength: 1 }
    shells { name: "bumper" material: "plastic" thickness_m: 0.02 }
    shells { name: "window" material: "window_glass" thickness_m: 0.1 }"""
PIECE, THICK = 7, 0.02


class Frozen(InAFolder):
    """Two squares that a seam joins at x = 1: shells in frame 0, and in frame 1 one frozen piece that has sunk, and a box."""

    def setUp(self) -> None:
        super().setUp()
        (self.folder / "frames").mkdir()
        left = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
        right = left + [1.0, 0.0, 1e-9]  # a seam is as narrow as round-off
        square = np.array([[0, 1, 2], [0, 2, 3]])
        write_vtp(self.folder / "frames/shell.vtp", np.concatenate([left, right]), np.concatenate([square, square + 4]), floats="f8",
                  point_data={"displacement": np.zeros((8, 3)), "uv": np.zeros((8, 2))},
                  cell_data={"fragment": np.full(4, PIECE), "damage": np.zeros(4), "shell": np.array([0, 0, 1, 1])})
        up = np.array([0, 0, 0.5 * THICK])
        rest = np.concatenate([np.stack([part - way, part + way], axis=1).reshape(-1, 3)
                               for part, way in ((left, up), (right, 5.0 * up))])
        solid = np.concatenate([2 * square + 1, 2 * square[:, ::-1], *(
            [[2 * a, 2 * b, 2 * b + 1], [2 * a, 2 * b + 1, 2 * a + 1]] for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)))])
        box = np.array([[0, 0, 3], [1, 0, 3], [0, 1, 3], [0, 0, 4.0]])
        faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        n, m = len(solid), len(faces)
        write_vtp(self.folder / "frames/bodies.vtp", np.concatenate([rest - [0, 0, 0.3], box]),
                  np.concatenate([solid, solid + 8, faces + 16]), floats="f8",
                  point_data={"displacement": np.concatenate([np.tile([0, 0, -0.3], (16, 1)), np.zeros((4, 3))]),
                              "uv": np.zeros((20, 2))},
                  cell_data={"body": np.repeat([PIECE, 1], [2 * n, m]), "kind": np.repeat([3, 0], [2 * n, m]),
                             "shell": np.repeat([0, 1, -1], [n, n, m])})
        sets = [(0, 0, "shell"), (1, 2, "bodies")]
        (self.folder / "frames.pvd").write_text("<VTKFile><Collection>" + "".join(
            f'<DataSet timestep="{time}" part="{part}" file="frames/{name}.vtp"/>' for time, part, name in sets)
            + "</Collection></VTKFile>")
        self.words = words_of(parse_text(SCENE), [])
        self.frames = list_frames(self.folder)

    def test_exports_name_the_material_of_each_shell(self) -> None:
        for words, names in ((self.words, ("bumper", "window")), (Words(), ("shell_0", "shell_1"))):
            nodes = read_glb(glb_bytes(mesh_of(self.frames, 1), 1.0, words, {}))
            self.assertEqual(list(nodes)[:2], [f"shards_of_{name}" for name in names])
            self.assertEqual(len(nodes), 3)
            self.assertLessEqual(nodes[f"shards_of_{names[0]}"]["POSITION"][:, 0].max(), 1.0)

    def test_a_film_goes_on_with_the_materials_that_it_had(self) -> None:
        piece, box = story_of(self.frames, self.words, {})
        self.assertEqual(piece.name, f"bumper_piece_{PIECE}")
        shell, frozen = piece.shapes
        self.assertEqual({slot.material for slot in shell.slots}, {slot.material for slot in frozen.slots})
        self.assertEqual({slot.material for slot in frozen.slots}, {
            f"{name}_{side}" for name in ("plastic", "window_glass") for side in ("outside", "inside", "edge")})
        for slot in frozen.slots:
            x = frozen.rest[slot.first:slot.first + slot.count, 0]
            self.assertEqual((x.min(), x.max()), (0.0, 1.0) if slot.material.startswith("plastic") else (1.0, 2.0))
        self.assertEqual([slot.material for slot in box.shapes[0].slots], [box.name])

    def test_pictures_know_the_glass_and_draw_no_line_along_the_seam(self) -> None:
        look = Look.of_words(self.words)
        scene = load_scene(self.frames[1], look)
        self.assertEqual((len(scene.glass.triangles), len(scene.solid.triangles)), (12, 16))
        lines = scene.outlines
        self.assertFalse((np.abs(lines[:, :, 0] - 1.0) < 1e-6).all(axis=1).any())
        for place in (0.0, 2.0):  # where the piece ends
            self.assertEqual(int((np.abs(lines[:, :, 0] - place) < 1e-6).all(axis=1).sum()), 2, "both faces")
        self.assertEqual(len(lines), 12)

    def test_the_page_gives_each_shell_its_colour(self) -> None:
        packed = pack_frame(self.frames, 1)
        size, = struct.unpack_from("<I", packed)
        kind, at, count = json.loads(packed[4:4 + size])["arrays"]["bodies.part"]
        part = np.frombuffer(packed, "<" + kind, count, 4 + size + at)
        np.testing.assert_array_equal(part, np.repeat([0, 1, -1], [12, 12, 4]))
        program = shutil.which("node")
        if program is None:
            self.skipTest("there is no Node.js")
        page = f"""import {{ bodyColour }} from "{(REPOSITORY / 'coupler/viewer/colours.js').as_uri()}";
            const frame = {{ arrays: {{ "bodies.kind": [3, 3, 1], "bodies.body": [7, 7, 8], "bodies.part": [0, 1, -1] }} }};
            const look = {{ whole: new Set(), shardColour: (body, part) => [[1, 0, 0], [0, 1, 0]][part] ?? [0, 0, body] }};
            const of = bodyColour(frame, "part", 1, look);
            console.log(JSON.stringify([0, 1, 2].map((t) => of(t, 0))));"""
        (self.folder / "page.mjs").write_text(page)
        found = json.loads(subprocess.run([program, str(self.folder / "page.mjs")], check=True, capture_output=True).stdout)
        self.assertEqual(found[:2], [[1, 0, 0], [0, 1, 0]])
        self.assertGreater(found[2][2], 1e-9)
