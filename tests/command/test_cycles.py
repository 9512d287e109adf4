"""Pictures by Blender's Cycles: what the script is told, what it draws, and what is refused."""
from __future__ import annotations

import os
import shutil
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from PIL import Image

from sunder_tools.errors import CommandError
from sunder_tools.pictures import cycles
from sunder_tools.pictures.ground import Ground
from sunder_tools.pictures.raster import perspective_camera
from sunder_tools.report.appearance import GLASS, STEEL, as_linear
from sunder_tools.report.scene_text import SCENE_COPY

from .synthetic import HEIGHT_M, write_vtp
from .test_render import OfARun

SCENE = """
materials { name: "window" preset: SODA_LIME_GLASS }
materials { name: "hull" density: 7800 }
shells { name: "pane" material: "window" thickness_m: 0.01 }"""
HAS_BLENDER = shutil.which("blender") is not None
SIZE = "160x96"
SUN_VIEW = "38,63"  # azimuth and elevation [degrees] from which a level mirror shows the sun (shadows.LIGHT)
SAME = 0.8  # share of the pixels of either picture that show the pane in both; our pictures draw dark lines along edges


class Jobs(OfARun):
    def test_the_script_is_told_what_the_rasteriser_would_draw(self) -> None:
        (self.folder / SCENE_COPY).write_text(SCENE)
        camera = perspective_camera(np.zeros(3), np.ones(3), np.array([1.0, 0.2, -0.5]), 320, 240)
        told = cycles.job_of(self.folder, cycles.Cycles(7, 25.0, None, 3), [2, 4], [Path("a"), Path("b")], camera,
                             Ground(-0.5, np.array([1.0, 2.0]), 3.0), (320, 240))
        self.assertEqual((told["frames"], told["samples"], told["fps"], told["speed"], told["threads"]), ([2, 4], 7, 25.0, 0.0, 3))
        self.assertEqual(told["ground"], {"z": -0.5, "centre": [1.0, 2.0], "size": 3.0})
        self.assertEqual(told["static"], ["body_1"])  # the floor; not the ball
        looks, view = told["looks"], told["camera"]
        assert isinstance(looks, dict) and isinstance(view, dict)
        self.assertEqual(looks, {"window": {"kind": "glass", "colour": as_linear(GLASS.colour), "roughness": 0.0},
                                 "hull": {"kind": "metal", "colour": as_linear(STEEL.colour), "roughness": STEEL.roughness}})
        self.assertEqual((view["focal"], view["size"]), (camera.scale[0], [320, 240]))


class Refused(OfARun):
    def refused(self, *arguments: str) -> str:
        status, said = self.sunder("render", "--cycles", "1", *arguments)
        self.assertEqual(status, 2, said)
        return said

    def test_what_it_does_not_draw(self) -> None:
        self.assertIn("--colour speed: Cycles draws materials as they are", self.refused("--colour", "speed"))
        self.assertIn("--sheet: goes without --cycles", self.refused("--sheet"))
        status, said = self.sunder("render", "--backdrop", "dark")
        self.assertEqual((status, "--backdrop: goes with --cycles only" in said), (2, True), said)
        self.assertIn("leave --frames out", self.refused("--film", "--speed", "0.1", "--frames", "0"))

    def test_without_blender_nothing_is_installed_into_a_build_of_the_users_own(self) -> None:
        with mock.patch.dict(os.environ, {"SUNDER_BUILD_DIR": str(self.folder)}), \
                mock.patch.object(cycles.shutil, "which", lambda name: None):
            with self.assertRaisesRegex(CommandError, "apt-get install --no-install-recommends blender"):
                cycles.find_blender()

    def test_a_blender_that_fails_is_told_with_its_last_words(self) -> None:
        camera = perspective_camera(np.zeros(3), np.ones(3), np.array([1.0, 0.2, -0.5]), 32, 32)
        ground = Ground(0.0, np.zeros(2), 1.0)
        with tempfile.TemporaryDirectory() as name:
            for text, wanted in (("echo torch; exit 7", r"(?s)ended with status 7 after 0 of 1 pictures.*torch"),
                                 ("echo sunder-failed OSError: no frames; exit 1", "Blender: OSError: no frames"),
                                 ("kill -9 $$", "was killed by SIGKILL")):
                program = Path(name) / "blender"
                program.write_text(f"#!/bin/sh\n{text}\n")
                program.chmod(0o755)
                with mock.patch.object(cycles, "find_blender", lambda program=program: str(program)):
                    with self.assertRaisesRegex(CommandError, wanted):
                        list(cycles.drawn(self.folder, cycles.Cycles(1, 24.0, None), [0], camera, ground, (32, 32)))


@unittest.skipUnless(HAS_BLENDER, "Blender is not installed; apt-get install --no-install-recommends blender")
class Drawn(OfARun):
    def still(self, *arguments: str, frame: int = 4) -> np.ndarray:
        status, said = self.sunder("render", "--size", SIZE, "--jobs", "1", "--frames", str(frame), "--no-caption", *arguments)
        self.assertEqual(status, 0, said)
        with Image.open(self.folder / "stills" / f"still_{frame:06d}.png") as image:
            return np.asarray(image.convert("RGB"), float) / 255.0

    def test_things_stand_where_the_rasteriser_has_them(self) -> None:
        (self.folder / SCENE_COPY).write_text('materials { name: "clay" density: 1 }\n'
                                              'shells { name: "pane" material: "clay" thickness_m: 1e-3 }')
        for view in ("30,40", "top"):
            masks = []
            for arguments in ((), ("--cycles", "16")):
                picture = self.still("--view", view, *arguments)
                warm = picture[..., 0] - picture[..., 2]  # the pane is the only thing with a colour
                smooth = sum(np.roll(warm, (a, b), (0, 1)) for a in (-1, 0, 1) for b in (-1, 0, 1)) / 9.0
                masks.append(smooth > np.percentile(smooth, (3, 97)).mean())
            both, either = (masks[0] & masks[1]).sum(), (masks[0] | masks[1]).sum()
            self.assertGreater(both, 800)
            self.assertGreater(both / either, SAME, view)

    def test_a_dark_backdrop_is_dark_and_lights_the_scene(self) -> None:
        (self.folder / SCENE_COPY).write_text('materials { name: "clay" density: 1 }\n'
                                              'shells { name: "pane" material: "clay" thickness_m: 1e-3 }')
        light, dark = (self.still("--view", "top", "--cycles", "16", "--backdrop", name) for name in ("light", "dark"))
        corner = (slice(0, 12), slice(0, 12))  # ground
        self.assertLess((dark[corner] ** 2.2).mean(), 0.35 * (light[corner] ** 2.2).mean(), "in linear light")
        self.assertGreater(dark.max(), 0.5 * light.max(), "the pane is lit")

    def test_glass_metal_and_cloth_look_like_it(self) -> None:
        """A sheet with a board under its left half, from above and from where a mirror shows the sun."""
        low, high = np.array([-0.25, -0.25, HEIGHT_M - 0.12]), np.array([0.0, 0.25, HEIGHT_M - 0.10])
        points = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
                 [1, 5, 7], [1, 7, 3]]
        write_vtp(self.folder / "frames" / "bodies_000001.vtp", points, faces,
                  cell_data={"body": np.zeros(len(faces)), "kind": np.zeros(len(faces))})
        seen = {name: self.sheet(name) for name in ("glass", "steel", "silk")}
        middle = seen["glass"][0].shape[1] // 2  # the board ends here
        halves = {name: float(above[:, middle + 2:middle + 10].mean() - above[:, middle - 10:middle - 2].mean())
                  for name, (above, _) in seen.items()}
        self.assertGreater(abs(halves["glass"]), 0.05, "what is under glass is seen")
        self.assertLess(max(abs(halves["steel"]), abs(halves["silk"])), 0.03, halves)  # a mirror has the sky's shades
        shine = {name: float(sun.mean() / above.mean()) for name, (above, sun) in seen.items()}
        self.assertGreater(shine["steel"], 1.3, "a metal mirrors the sun")
        self.assertLess(abs(shine["silk"] - 1.0), 0.1, "a cloth is as bright from every side")

    def sheet(self, material: str) -> tuple[np.ndarray, ...]:
        """Draws the middle of the pane of this material in both views."""
        (self.folder / SCENE_COPY).write_text(f'materials {{ name: "{material}" density: 1000 }} '
                                              f'shells {{ name: "pane" material: "{material}" thickness_m: 0.004 }}')
        return tuple(self.still("--view", view, "--close", "--cycles", "12", frame=1)[24:-24, 56:-56] for view in ("270,89", SUN_VIEW))


if __name__ == "__main__":
    unittest.main()
