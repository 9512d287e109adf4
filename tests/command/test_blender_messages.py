"""What the Blender add-on says of what it does not take; skipped where there is no Blender."""
from __future__ import annotations

import json
import shutil
import subprocess
import unittest
from pathlib import Path

from . import REPOSITORY
from .test_render import OfARun

ADDON = REPOSITORY / "coupler" / "blender"
# The message of each call of `load` that is refused.
SCRIPT = """
import json, sys
sys.dont_write_bytecode = True
sys.path.insert(0, {addon!r})
import bpy
import sunder_run
told = []
for arguments in json.loads({calls!r}):
    try:
        sunder_run.load(**arguments)
        told.append("taken")
    except Exception as error:
        told.append(f"{{type(error).__name__}}: {{error}}")
sunder_run.register()
try:
    bpy.ops.import_scene.sunder_run(directory={folder!r} + "/empty/")
except RuntimeError as error:
    told.append(str(error))
open({out!r}, "w").write(json.dumps(told))
"""


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed; apt-get install --no-install-recommends blender")
class Messages(OfARun):
    def told(self, addon: Path, *calls: dict[str, object]) -> list[str]:
        script, out = self.folder / "script.py", self.folder / "told.json"
        script.write_text(SCRIPT.format(addon=str(addon), calls=json.dumps(calls), folder=str(self.folder), out=str(out)))
        done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python", str(script)],
                              cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr[-2000:])
        return json.loads(out.read_text())

    def test_what_is_no_run_and_numbers_that_are_none(self) -> None:
        (self.folder / "empty").mkdir()
        scene = self.folder / "pane.textproto"
        scene.write_text('name: "pane"')
        run = str(self.folder)
        told = self.told(ADDON, {"folder": f"{run}/empty"}, {"folder": f"{run}/nowhere"}, {"folder": str(scene)},
                         {"folder": f"{run}/frames.pvd"}, {"folder": run, "speed": -1.0}, {"folder": run, "fps": 0.0},
                         {"folder": run, "reader": str(REPOSITORY)})
        for found, wanted in zip(told, (
                f"ValueError: {run}/empty: holds no frames.pvd; {run} is the folder of a run",
                f"ValueError: {run}/nowhere: no such folder; name the folder of a run, the one that 'sunder run SCENE' says at its end",
                f"ValueError: {scene}: is a scene, and no run of it; run it first: {REPOSITORY}/coupler/sunder run {scene}, then name",
                f"ValueError: {run}/frames.pvd: is a file; name the folder of a run, the one that",
                "ValueError: speed is -1, must be above 0, such as 0.1 for a second in ten, or 0: a frame of the run is one here",
                "ValueError: fps is 0, must be 0.001 to 1000; 24 is usual", "taken",
                f"Error: {run}/empty: holds no frames.pvd")):
            self.assertTrue(found.startswith(wanted), f"{found}\nis not\n{wanted}")

    def test_a_reader_that_is_not_there_is_told_with_the_places(self) -> None:
        alone = self.folder / "addons"
        alone.mkdir()
        shutil.copy(ADDON / "sunder_run.py", alone)
        found, second, _ = self.told(alone, {"folder": str(self.folder), "reader": "/no/checkout"}, {"folder": str(self.folder)})
        self.assertRegex(found, rf"^ImportError: no reader of runs in /no/checkout or /no/checkout/coupler or {self.folder} \(.*\); name "
                                "the folder 'coupler' of a checkout of Sunder in the preferences of the add-on, where /no/checkout is named$")
        self.assertRegex(second, rf"^ImportError: no reader of runs in {self.folder} .*where nothing is named$")


if __name__ == "__main__":
    unittest.main()
