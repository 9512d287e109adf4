"""A file or folder of the wrong kind is told as what it is, with the command that takes it."""
from __future__ import annotations

import contextlib
import io
import unittest

from sunder_tools.command.main import main
from sunder_tools.report.run_folder import not_a_run

from .test_view import InAFolder


class NoRun(InAFolder):
    def said(self, *arguments: str) -> str:
        heard = io.StringIO()
        with contextlib.redirect_stderr(heard), contextlib.redirect_stdout(heard):
            self.assertEqual(main(list(arguments)), 2, heard.getvalue())
        return heard.getvalue()

    def test_a_scene_is_to_be_run_first(self) -> None:
        scene = self.folder / "my pane.textproto"
        scene.write_text('name: "pane"')
        for path in (scene, self.folder / "my pane"):
            for command in ("render", "export", "view"):
                self.assertRegex(self.said(command, str(path)), rf"^sunder: {command}: \S.*my pane\.textproto: is a scene, and no run of "
                                 rf"it; run it first: \S*sunder run '{scene}', then name the folder")

    def test_what_is_not_there_and_what_is_no_run(self) -> None:
        self.assertRegex(self.said("render", str(self.folder / "notrun")), r"notrun: no such folder; .* 'sunder run SCENE' says at its end")
        (self.folder / "note.txt").write_text("")
        self.assertRegex(self.said("export", str(self.folder / "note.txt")), r"note\.txt: is a file; name the folder of a run")
        (self.folder / "empty").mkdir()
        self.assertRegex(self.said("render", str(self.folder / "empty")), "empty: holds neither run.json nor frames.pvd; name the folder")

    def test_the_folder_of_a_run_that_is_near_is_named(self) -> None:
        run = self.folder / "runs" / "pane"
        (run / "frames").mkdir(parents=True)
        (run / "frames.pvd").write_text("")
        self.assertEqual(not_a_run(run), "")
        for path in (run / "frames", self.folder / "runs"):
            self.assertEqual(not_a_run(path), f"{path}: holds no frames.pvd; {run} is the folder of a run")
        self.assertRegex(self.said("render", str(run / "frames")), f"; {run} is the folder of a run$")

    def test_a_mesh_is_told_with_what_makes_a_scene_of_it(self) -> None:
        for name, kind in (("bowl.obj", "mesh"), ("bowl.STL", "mesh"), ("panel.step", "CAD file"), ("panel.igs", "CAD file")):
            file, scene = self.folder / name, (self.folder / name).with_suffix(".textproto")
            file.write_text("v 0 0 0")
            for command in ("run", "check", "modes"):
                self.assertRegex(self.said(command, str(file)), rf"^sunder: {file}: is a {kind}, and no scene; this writes a scene of it: "
                                 rf"\S*sunder inspect {file} --scene {scene}( \(a mesh has no unit: add --unit 0.001 .*)?$")
        for taken in ("bowl.textproto", "bowl_2.textproto"):  # inspect writes over none
            (self.folder / taken).write_text("")
        self.assertIn(f"--scene {self.folder / 'bowl_3.textproto'} (", self.said("run", str(self.folder / "bowl.obj")))

    def test_the_folder_of_a_run_has_its_scene(self) -> None:
        scene = self.folder / "scene_as_run.textproto"
        scene.write_text("")
        self.assertEqual(self.said("run", str(self.folder)), f"sunder: {self.folder}: is the folder of a run; its scene is {scene}\n")


if __name__ == "__main__":
    unittest.main()
