"""`scenes` and `new`: what ships, how long it takes, and what a new scene is made of."""
from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from sunder_tools.command import new, scenes
from sunder_tools.command.main import main
from sunder_tools.errors import CommandError
from sunder_tools.launch import shipped
from sunder_tools.launch.build import build_dir
from sunder_tools.report.scene_text import parse_text

from . import REPOSITORY
from .fakes import write_executables


class InAFolder(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.said, self.told = io.StringIO(), io.StringIO()
        for context in (contextlib.redirect_stdout(self.told), contextlib.redirect_stderr(self.said)):
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)

    def refused(self, *arguments: str) -> str:
        self.assertEqual(main(list(arguments)), 2, arguments)
        return self.said.getvalue()


class Scenes(InAFolder):
    def setUp(self) -> None:
        super().setUp()
        (self.folder / "pane.textproto").write_text("# A pane of Fig. 3, 1.5 m\n# wide. It breaks.\nname: 'pane'\n# later\n")
        (self.folder / "sheet.textproto").write_text("name: 'sheet'\n")

    def test_a_scene_is_told_by_the_first_sentence_of_its_comment(self) -> None:
        pane, sheet = shipped.shipped(self.folder)
        self.assertEqual((pane.about, sheet.about), ("A pane of Fig. 3, 1.5 m wide.", ""))
        self.assertIn("\npane ", scenes.table([pane, sheet], 80))

    def test_every_scene_that_ships_says_what_it_shows(self) -> None:
        listed = shipped.shipped()
        self.assertIn("cad/windscreen", [scene.name for scene in listed])
        self.assertEqual(len(listed), len(list((REPOSITORY / "scenes").rglob("*.textproto"))))
        for scene in listed:
            self.assertGreater(len(scene.about), 20, scene.name)
        self.assertEqual(main(["scenes"]), 0)
        for name in ("glass", "cad/windscreen", "paper/fig01"):
            self.assertIn(f"\n{name} ", self.told.getvalue())

    def test_seconds_are_measured_kept_and_blank_where_they_are_not(self) -> None:
        write_executables(self.folder / "build")
        with mock.patch.dict(os.environ, {"SUNDER_BUILD_DIR": str(self.folder / "build")}):
            shipped.measure(["pane"], self.folder)
        kept = json.loads((self.folder / shipped.SECONDS).read_text())
        self.assertEqual(list(kept), ["pane"])
        self.assertEqual(set(kept["pane"]), {"processor_s", "commit", "date", "system", "processor", "cores", "load", "compiler"})
        self.assertGreater(kept["pane"]["processor_s"], 0.0)
        pane, sheet = shipped.shipped(self.folder)
        self.assertEqual((pane.seconds, sheet.seconds), (kept["pane"]["processor_s"], None))
        self.assertEqual(sorted(p.name for p in self.folder.iterdir() if p.name.startswith(".")), [])

    def test_what_cannot_be_measured_or_read_is_refused(self) -> None:
        with self.assertRaisesRegex(CommandError, "no scene 'pan' ships; did you mean 'pane'"):
            shipped.measure(["sheet", "pan"], self.folder)
        self.assertFalse((self.folder / shipped.SECONDS).exists())
        (self.folder / shipped.SECONDS).write_text("{")
        with self.assertRaisesRegex(CommandError, "seconds.json: cannot be read"):
            shipped.shipped(self.folder)
        self.assertIn("names go with --measure only", self.refused("scenes", "glass"))


class New(InAFolder):
    def test_the_starter_is_a_commented_scene_of_that_name(self) -> None:
        self.assertEqual(main(["new", str(self.folder / "made" / "my_pane")]), 0)
        path = self.folder / "made" / "my_pane.textproto"
        self.assertIn(f"sunder run {path}", self.told.getvalue())
        scene = parse_text(path.read_text())
        self.assertEqual(scene["name"], ["my_pane"])
        self.assertGreater(path.read_text().count("#"), 8)
        self.assertEqual({"materials", "shells", "bodies", "fracture", "output"} - set(scene), set())

    def test_a_copy_has_the_new_name_and_the_files_of_the_scene(self) -> None:
        self.assertEqual(main(["new", str(self.folder / "my_tree.textproto"), "--from", "falling_tree_small"]), 0)
        text = (self.folder / "my_tree.textproto").read_text()
        self.assertEqual(parse_text(text)["name"], ["my_tree"])
        shipped_text = (REPOSITORY / "scenes" / "falling_tree_small.textproto").read_text()
        self.assertEqual(text.replace('name: "my_tree"', 'name: "falling_tree_small"'), shipped_text)
        self.assertTrue((self.folder / "tree_trunk.off").is_file())
        beside = self.folder / "other"  # a path, in the same folder: nothing to copy
        self.assertEqual(main(["new", str(beside), "--from", str(self.folder / "my_tree.textproto")]), 0)

    def test_each_scene_that_is_listed_can_be_copied(self) -> None:
        for number, scene in enumerate(shipped.shipped()):
            self.assertEqual(main(["new", str(self.folder / f"f{number}" / "mine"), "--from", scene.name]), 0, scene.name)

    def test_nothing_is_replaced(self) -> None:
        path = self.folder / "pane.textproto"
        path.write_text("mine")
        self.assertIn("is not replaced", self.refused("new", str(self.folder / "pane")))
        self.assertEqual(path.read_text(), "mine")
        (self.folder / "tree_trunk.off").write_text("mine")
        self.refused("new", str(self.folder / "tree"), "--from", "falling_tree_small")
        self.assertEqual((self.folder / "tree_trunk.off").read_text(), "mine")
        self.assertFalse((self.folder / "tree.textproto").exists())

    def test_names_and_sources_that_cannot_be_are_refused(self) -> None:
        self.assertIn("e.g. my_pane", self.refused("new", str(self.folder / "My-Pane")))
        self.assertIn("'9' is no name", self.refused("new", str(self.folder / "9")))
        self.assertIn("scenes/glass.textproto", self.refused("new", str(self.folder / "pane"), "--from", "glas"))
        (self.folder / "file").write_text("")
        self.assertIn("cannot write", self.refused("new", str(self.folder / "file" / "pane")))
        self.assertEqual([p.name for p in self.folder.iterdir()], ["file"])


class Starter(unittest.TestCase):
    def test_runs_as_it_is(self) -> None:
        """The solver takes it: on a build only, else what it is made of is held above."""
        shell = build_dir() / "shell" / "sunder-shell"
        if not shell.is_file():
            self.skipTest(f"{shell} is not built")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "pane.textproto"
            path.write_text(new.STARTER.format(name="pane"))
            done = subprocess.run([shell, "--scene", path, "--check"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
