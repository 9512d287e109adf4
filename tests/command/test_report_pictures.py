"""`report pictures`: every picture of a page is listed, and is drawn from a made-up run."""
from __future__ import annotations

import contextlib
import io
import json
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from PIL import Image

from sunder_tools.errors import CommandError
from sunder_tools.pictures.contact_sheet import GAP, WIDTH
from tests.docs import pictures
from tests.docs.pictures import PICTURES, Picture, draw_pictures, scene_file, scene_name

from . import REPOSITORY, sunder
from .synthetic import SyntheticRun


class List(unittest.TestCase):
    def test_has_every_picture_of_the_repository_and_its_scenes(self) -> None:
        if not (REPOSITORY / ".git").exists():
            self.skipTest("no git checkout")
        listed = subprocess.run(["git", "-C", str(REPOSITORY), "ls-files", "*.png", "*.jpg"], check=True, capture_output=True,
                                text=True).stdout.split()
        self.assertEqual(sorted(picture.target for picture in PICTURES), sorted(listed))
        self.assertEqual(len({picture.name for picture in PICTURES}), len(PICTURES))
        with tempfile.TemporaryDirectory() as temporary:
            for picture in PICTURES:
                self.assertNotEqual(bool(picture.scene), bool(picture.command), picture.name)
                if picture.scene:
                    text = scene_file(picture.scene, Path(temporary)).read_text()
                    self.assertIn(f'name: "{scene_name(picture)}"', text)
            with self.assertRaisesRegex(CommandError, "README.md has no block that is marked file=nothing.textproto"):
                scene_file("README.md#nothing.textproto", Path(temporary))

    def test_pages_show_them(self) -> None:
        pages = [path for path in REPOSITORY.rglob("*.md") if "build" not in path.parts]
        shown = {(path.parent / name).resolve() for path in pages
                 for name in re.findall(r"\]\(([\w./]+\.(?:png|jpg))\)", path.read_text(encoding="utf-8"))}
        self.assertEqual([p.target for p in PICTURES if (REPOSITORY / p.target).resolve() not in shown], [])


    def test_blender_draws_those_of_the_first_page(self) -> None:
        shown = re.findall(r"\]\(([\w./]+\.(?:png|jpg))\)", (REPOSITORY / "README.md").read_text(encoding="utf-8"))
        listed = {picture.target: picture for picture in PICTURES}
        self.assertTrue(shown)
        for target in shown:
            self.assertTrue(listed[target].cycles, target)

    def test_no_picture_is_large(self) -> None:
        large = [picture.target for picture in PICTURES if (REPOSITORY / picture.target).stat().st_size > 250_000]
        self.assertEqual(large, [])


class Drawing(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.top, self.runs = Path(temporary.name) / "top", Path(temporary.name) / "runs"
        run = SyntheticRun(self.runs / "glass", elements=8, fragments=8, count=9)
        for k in range(9):
            run.write(k)
        run.write_run_json("done", 8)
        self.times = (run.time_s(1), run.time_s(6))

    def draw(self, *listed: Picture, names: list[str] | None = None, runs: Path | None = None) -> list[str]:
        self.said = io.StringIO()
        with mock.patch.object(pictures, "PICTURES", listed), contextlib.redirect_stdout(self.said), \
                contextlib.redirect_stderr(self.said):
            return draw_pictures(names or [], runs or self.runs, self.top)

    def opened(self, target: str) -> Image.Image:
        with Image.open(self.top / target) as image:
            return image.convert("RGB")

    def test_a_contact_sheet_and_stills_of_a_run_that_is_there(self) -> None:
        sheet = Picture("scenes/glass.png", "scenes/glass.textproto", width=400)
        stills = Picture("a/both.jpg", "scenes/glass.textproto", self.times, ("--size", "160x96", "--jobs", "1"), width=999)
        with mock.patch.object(pictures, "launch_once") as launched:
            self.assertEqual(self.draw(sheet, stills), [])
        launched.assert_not_called()
        self.assertIn("scenes/glass.png", self.said.getvalue())
        with Image.open(self.runs / "glass" / "contact_sheet.png") as whole:
            self.assertEqual(whole.width, WIDTH)
            self.assertEqual(self.opened("scenes/glass.png").size, (400, round(whole.height * 400 / WIDTH)))
        both = np.asarray(self.opened("a/both.jpg"), float)
        self.assertEqual(both.shape[:2], (96, 2 * 160 + GAP))
        self.assertGreater(np.abs(both[:, :160] - both[:, -160:]).mean(), 2.0, "the same frame twice")

    def test_a_run_that_is_not_there_is_made_and_kept(self) -> None:
        def launch(_: object, scene: Path, folder: Path, settings: list[str]) -> None:
            self.assertIn('name: "first"', scene.read_text())
            self.assertEqual(settings, ["fracture.seed=2"])
            shutil.copytree(self.runs / "glass", folder, dirs_exist_ok=True)

        made = Picture("first.png", "README.md#first.textproto", (0.0,), ("--size", "96x64", "--jobs", "1"), ("fracture.seed=2",))
        other = Picture("other.png", "scenes/glass.textproto")
        with mock.patch.object(pictures, "launch_once", launch), mock.patch.object(pictures, "ensure_built"):
            self.assertEqual(self.draw(made, other, names=["first"]), [])
        self.assertEqual(self.opened("first.png").size, (96, 64))
        self.assertTrue((self.runs / "first" / "frames.pvd").is_file())
        self.assertFalse((self.top / "other.png").exists(), "only what is named is drawn")

    def test_a_run_that_has_not_ended_is_no_picture(self) -> None:
        book = self.runs / "glass" / "run.json"
        book.write_text(json.dumps({**json.loads(book.read_text()), "status": "interrupted"}))
        with self.assertRaisesRegex(CommandError, "has not come to its end; remove the folder"):
            self.draw(Picture("glass.png", "scenes/glass.textproto"))
        self.assertFalse((self.top / "glass.png").exists())

    def test_a_picture_that_a_command_makes(self) -> None:
        def fake(arguments: list[str], more: list[str]) -> int:
            self.assertEqual((arguments[0], arguments[1], more), ("sweep", str(REPOSITORY / "coupler/x.py"), ["tests.commands"]))
            Image.new("RGB", (30, 20), (200, 10, 10)).save(Path(arguments[3]) / "plots.png")
            return 0

        plots = Picture("x.png", command=("sweep", "coupler/x.py", "--out", "{folder}"), made="plots.png")
        with mock.patch.object(pictures, "main", fake):
            self.draw(plots)
        self.assertEqual(self.opened("x.png").getpixel((3, 3)), (200, 10, 10))
        with mock.patch.object(pictures, "main", lambda *_: 3), self.assertRaisesRegex(CommandError, "ended with status 3"):
            self.draw(plots)

    def test_without_blender_its_pictures_stay_and_are_told(self) -> None:
        hero = Picture("hero.png", "scenes/glass.textproto", (0.0,), ("--cycles", "1"))
        sheet = Picture("sheet.png", "scenes/glass.textproto", width=400)
        with mock.patch.object(pictures, "find_blender", side_effect=CommandError("no Blender")):
            self.assertEqual(self.draw(hero, sheet), ["hero"])
        self.assertIn("hero.png stays as it is: no Blender", self.said.getvalue())
        self.assertEqual([path.name for path in self.top.iterdir()], ["sheet.png"])

    def test_what_is_refused(self) -> None:
        for arguments, why in ((["pictures", "shells"], "stands alone"), (["pictures", "--no-run"], "stands alone"),
                               (["shells", "--picture", "glass"], "go with 'sunder report pictures'"),
                               (["pictures", "--picture", "glas"], "no page shows it.*glass")):
            said = io.StringIO()
            with contextlib.redirect_stderr(said):
                self.assertEqual(sunder(["report", *arguments]), 2)
            self.assertRegex(said.getvalue(), why)


if __name__ == "__main__":
    unittest.main()
