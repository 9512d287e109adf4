"""The script for Blender on the page of the command, and the choice of frames; skipped where there is no Blender."""
from __future__ import annotations

import json
import re
import shutil
import subprocess
import unittest
from pathlib import Path

from . import REPOSITORY
from .test_animated import Parting
from .test_pace import write_series

ADDON = REPOSITORY / "coupler" / "blender"
SOME = """
import json, sys
sys.dont_write_bytecode = True
sys.path.insert(0, {addon!r})
import bpy
import sunder_run
told = []
for arguments in ({{}}, {{"frames": "1-3"}}, {{"speed": 2.0}}):
    bpy.ops.wm.read_homefile(use_empty=True)
    notes = []
    found = sunder_run.load({folder!r}, notes=notes, **arguments)
    told.append([bpy.context.scene.frame_end, len(found), notes])
sunder_run.register()
bpy.ops.wm.read_homefile(use_empty=True)
bpy.ops.import_scene.sunder_run(directory={folder!r}, frames="1-3")
told.append(bpy.context.scene.frame_end)
open({out!r}, "w").write(json.dumps(told))
"""
LOOK = """
import bpy, sys
bpy.ops.wm.open_mainfile(filepath={blend!r})
names = [thing.name for thing in bpy.data.objects]
assert bpy.context.scene.camera.name == "camera" and "sun" in names and "Cube" not in names, names
assert "pane_piece_1" in names, names
"""


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed; apt-get install --no-install-recommends blender")
class Page(Parting):
    def setUp(self) -> None:
        super().setUp()
        self.write_scene()

    def blender(self, text: str, place: Path = REPOSITORY) -> str:
        script = self.folder / "script.py"
        script.write_text(text)
        done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python", str(script)],
                              cwd=place, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr[-2000:])
        return done.stdout + done.stderr

    def test_the_script_of_the_page_makes_a_shot(self) -> None:
        page = (REPOSITORY / "coupler" / "README.md").read_text()
        found = re.search(r"test_blender_page.py runs it\n(.*?)```", page, re.DOTALL)
        assert found is not None
        blend = self.folder / "shot.blend"
        text = found[1].replace('"runs/pane"', repr(str(self.folder))).replace('"shot.blend"', repr(str(blend)))
        self.assertEqual(text.count(str(self.folder)), 2)
        self.blender("import sys\nsys.dont_write_bytecode = True\n" + text)
        self.blender(LOOK.format(blend=str(blend)))

    def test_frames_are_chosen_and_notes_are_told(self) -> None:
        write_series(self, self.STEP, 2.0 * self.STEP)
        out = self.folder / "told.json"
        said = self.blender(SOME.format(addon=str(ADDON), folder=str(self.folder), out=str(out)))
        whole, some, fast, by_menu = json.loads(out.read_text())
        self.assertEqual([whole[0], some[0], by_menu], [5, 2, 2])
        self.assertGreaterEqual(whole[1], some[1])
        self.assertRegex(whole[2][0], r"^cracks grow within .*; speed=\S+ spreads that over 24 pictures")
        self.assertIn(f"sunder: note: {whole[2][0]}", said)
        self.assertEqual(fast[2][0], "speed=2 shows 2 s of the run in a second; speed=0.5 is 2 times slower than life")


if __name__ == "__main__":
    unittest.main()
