"""The command line: what is found, the version, and what a mistyped word is answered with."""
from __future__ import annotations

import argparse
import contextlib
import io
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from sunder_tools import version, words
from sunder_tools.command import parser
from sunder_tools.command.main import OF_SOURCES, main, make_parser, subcommands
from sunder_tools.errors import CommandError
from sunder_tools.places import COUPLER

from . import REPOSITORY, sunder
from .fakes import write_executables


class Words(unittest.TestCase):
    def test_the_nearest_come_first(self) -> None:
        self.assertEqual(words.nearest("drft", ["reference", "draft"]), ["draft"])
        self.assertEqual(words.nearest("--Untl", ["--out", "--until"]), ["--until"])
        self.assertEqual(words.nearest("falling-tree", ["falling_tree"]), ["falling_tree"])

    def test_where_none_is_near_all_are_named(self) -> None:
        self.assertEqual(words.nearest("xyz", ["run", "check"]), [])
        self.assertEqual(words.did_you_mean("xyz", ["run", "check"]), "there are run, check")
        self.assertEqual(words.did_you_mean("rnu", ["run", "check"]), "did you mean 'run'?")

    def test_a_command_line_can_be_pasted(self) -> None:
        said = words.command_line(["sunder", "run", Path("my scene's.textproto")])
        done = subprocess.run(["sh", "-c", f"printf '%s|' {said}"], stdout=subprocess.PIPE, text=True, check=True)
        self.assertEqual(done.stdout, "sunder|run|my scene's.textproto|")

    def test_the_command_is_named_as_a_shell_finds_it(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            bare, folder = Path(name) / "bare", Path(name) / "my bin"
            for where in (bare, folder):
                where.mkdir()
            script = folder / "sunder"
            script.write_text("#!/bin/sh\nprintf '%s|' \"$0\" \"$@\"\n")
            script.chmod(0o755)
            with mock.patch.dict(os.environ, {"PATH": f"{bare}:/bin"}), mock.patch.object(words.sys, "argv", [str(script)]):
                said = words.own_command("run", "a b")
                done = subprocess.run(["/bin/sh", "-c", said], stdout=subprocess.PIPE, text=True, check=True)
                self.assertEqual(done.stdout, f"{script}|run|a b|")
                with contextlib.chdir(folder), mock.patch.object(words.sys, "argv", ["sunder"]):  # sh sunder run
                    self.assertEqual(words.own_command("run"), "./sunder run")
                os.environ["PATH"] = f"{folder}:/bin"
                self.assertEqual(words.own_command("run"), "sunder run")
                with mock.patch.object(words.sys, "argv", [str(Path(name) / "my_script.py")]):  # a library there
                    self.assertEqual(words.own_program(), str(COUPLER / "sunder"))
                    with mock.patch.object(words, "COUPLER", Path(name)):
                        self.assertEqual(words.own_program(), "sunder")


class Version(unittest.TestCase):
    def test_is_that_of_the_project(self) -> None:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            self.assertEqual(main(["--version"]), 0)
        self.assertRegex(out.getvalue(), r"^sunder \d+\.\d+\.\d+\n$")
        self.assertIn(f"VERSION {out.getvalue().split()[1]} ", (REPOSITORY / "CMakeLists.txt").read_text())

    def test_of_an_installed_product_is_in_its_file(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "VERSION"
            file.write_text("1.2.3\n")
            with mock.patch.object(version, "INSTALLED", file):
                self.assertEqual(version.version(), "1.2.3")
                file.write_text("soon\n")
                with self.assertRaisesRegex(CommandError, "'soon' is no version"):
                    version.version()

    def test_a_project_without_one_is_refused(self) -> None:
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(version, "CHECKOUT", Path(folder) / "CMakeLists.txt"):
            with self.assertRaisesRegex(CommandError, "cannot be read"):
                version.version()
            version.CHECKOUT.write_text("project(sunder LANGUAGES CXX)\nfind_package(other VERSION 1.2.3)\n")
            with self.assertRaisesRegex(CommandError, "is no version"):
                version.version()


class Mistyped(unittest.TestCase):
    def refused(self, *arguments: str) -> str:
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            self.assertEqual(sunder(list(arguments)), 2, arguments)
        return said.getvalue()

    def test_the_nearest_is_named(self) -> None:
        glass = "scenes/glass.textproto"
        for arguments, near in ((["rnu"], "'run'"), (["valdate"], "'validate'"), (["run", "--untl", "3", glass], "'--until'"),
                                (["serve", "--endpont", "ipc://x"], "'--endpoint'"), (["--versoin"], "'--version'"),
                                (["run", glass, "--fidelity", "drft"], "'draft'"), (["sweep", "x", "--keep", "lst"], "'last'"),
                                (["sweep", "x", "--executor=slrum"], "'slurm'"), (["export", "x", "--format", "gtlf"], "'gltf'"),
                                (["render", "x", "--colour", "damge"], "'damage'"), (["replay", "x", "--side", "shel"], "'shell'"),
                                (["validate", "shels"], "'shells'"), (["fuzz", "--target", "scne"], "'scene'"),
                                (["validate", "shells", "--knwon"], "'--known'")):
            self.assertIn(f"did you mean {near}", self.refused(*arguments))

    def test_a_scene_is_looked_for_beside_it_and_among_those_that_ship(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "my_pane.textproto").write_text("")
            self.assertIn(f"{folder}/my_pane.textproto?", self.refused("check", f"{folder}/my_pan.textproto"))
            for typed in (f"{folder}/glas.textproto", "glas", "scenes/glass"):
                self.assertRegex(self.refused("check", typed), r"no such scene file; did you mean \S*scenes/glass.textproto")
            self.assertIn("'sunder scenes' lists those that ship", self.refused("check", "zzzzzz"))

    def test_an_engine_is_looked_for_among_those_there_are(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            write_executables(Path(folder) / "build")
            (Path(folder) / "pane.textproto").write_text("name: 'pane'\n")
            with mock.patch.dict(os.environ, {"SUNDER_BUILD_DIR": f"{folder}/build"}):
                for engine in ("bulet", "inprocess:bulet"):
                    said = self.refused("run", f"{folder}/pane.textproto", "--out", f"{folder}/out", "--rigid", engine)
                    self.assertIn(f"--rigid {engine}: did you mean 'bullet'?", said)
                said = self.refused("serve", "--endpoint", "ipc://x", "--rigid", "bulet")
                self.assertIn("did you mean 'bullet'?", said)
            self.assertFalse((Path(folder) / "out").exists())

    def test_what_follows_two_dashes_is_no_option(self) -> None:
        found = parser.Parser(prog="sunder run")
        found.add_argument("--until")
        found.check_options(["--until=3", "--", "--untl"])
        with self.assertRaisesRegex(CommandError, "unknown option '--untl' of 'sunder run'"):
            found.check_options(["--untl=3"])

    def test_nothing_and_options_alone_are_refused(self) -> None:
        self.assertIn("usage: sunder", self.refused())
        self.assertIn("ignored explicit argument", self.refused("--version=x"))


class Subcommands(unittest.TestCase):
    def test_each_has_a_line_of_help_and_one_of_its_own(self) -> None:
        found = subcommands(["sunder_tools.command", "tests.commands"])
        self.assertTrue({"run", "check", "new", "scenes", "validate", "test"} <= set(found))
        whole, parsers = make_parser(found)
        for name in found:
            self.assertIn(f"\n    {name} ", whole.format_help())
            self.assertTrue(parsers[name].description, name)
        with self.assertRaises(argparse.ArgumentTypeError):
            parser.one_of("a", "b")("c")

    def test_an_installed_product_has_none_that_need_tests(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            installed = Path(folder) / "coupler"
            installed.mkdir()
            shutil.copy(REPOSITORY / "coupler" / "sunder", installed)
            shutil.copytree(REPOSITORY / "coupler" / "sunder_tools", installed / "sunder_tools")
            (Path(folder) / "coupler" / "VERSION").write_text("3.2.1\n")
            done = [subprocess.run([sys.executable, installed / "sunder", *arguments], stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, check=False)
                    for arguments in (["--help"], ["--version"], ["validate", "shells"])]
        self.assertIn("\n    run ", done[0].stdout)
        self.assertNotIn("\n    validate ", done[0].stdout)
        self.assertEqual(done[1].stdout, "sunder 3.2.1\n")
        self.assertEqual(set(OF_SOURCES), set(subcommands(["tests.commands"])))
        self.assertIn("'validate' needs the tests", done[2].stdout)

    def test_a_start_needs_neither_numpy_nor_pil(self) -> None:
        code = ("import sys; sys.path.insert(0, 'coupler'); from sunder_tools.command.main import main, subcommands\n"
                "subcommands(['sunder_tools.command', 'tests.commands']); sys.exit('numpy' in sys.modules or 'PIL' in sys.modules)")
        self.assertEqual(subprocess.run([sys.executable, "-c", code], cwd=REPOSITORY, check=False).returncode, 0)


if __name__ == "__main__":
    unittest.main()
