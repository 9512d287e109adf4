"""What READMEs show works: their commands run, their scenes pass.

Long commands are parsed only, and the files that they name must exist; such a block says so, with the reason.
"""
from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

from google.protobuf import text_format

from tests.docs.snippets import LANGUAGES, TOP, Snippet, dropped, merged, readmes, snippets

sys.path.insert(0, str(TOP / "coupler"))
sys.pycache_prefix = str(TOP / "build" / "pycache")
from sunder_lab.schema import scene_class  # noqa: E402
from sunder_tools.command.main import make_parser, subcommands  # noqa: E402
from sunder_tools.errors import CommandError  # noqa: E402

STUCK_S = 1800.0  # after which a block hangs, whatever else the machine does
COPIED = ("scenes", "coupler/experiments")  # what commands may write beside
LINKED = ("proto", "rigid", "shell", "tests")
MODULES = ("sunder", "sunder.py", "sunder_tools", "sunder_lab", "sunder_engine", "viewer", "VERSION")


def folder_of_a_reader(folder: Path) -> None:
    """What a reader has: the files of the checkout, of which scenes may be written beside."""
    (folder / "coupler").mkdir()
    for name in COPIED:
        shutil.copytree(TOP / name, folder / name, ignore=shutil.ignore_patterns("*.png", "__pycache__"))
    for name in (*LINKED, *(f"coupler/{module}" for module in MODULES)):
        if (TOP / name).exists():
            (folder / name).symlink_to(TOP / name)


def commands_of(text: str) -> list[list[str]]:
    """The commands of a block as words; comments, assignments and continued lines are understood."""
    lines = text.replace("\\\n", " ").splitlines()
    split = [shlex.split(line, comments=True) for line in lines]
    return [words for words in split if words]


class Snippets(unittest.TestCase):
    def _run(self, snippet: Snippet, command: list[str], folder: Path) -> None:
        environment = dict(os.environ, PYTHONPATH=str(TOP / "coupler"), PYTHONDONTWRITEBYTECODE="1")
        done = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, errors="replace", timeout=STUCK_S, env=environment,
                              check=False)
        self.assertEqual(done.returncode, 0, f"{snippet.place}: {' '.join(command)[:200]}\n{done.stdout[-3000:]}")

    def _scene(self, snippet: Snippet, folder: Path) -> None:
        name = snippet.option("file") or f"line_{snippet.line}.textproto"
        text = snippet.text
        if base := snippet.option("into"):
            scene: Any = text_format.Parse((folder / base).read_text(), scene_class()())
            gone = [path for path in (snippet.option("drop") or "").split(",") if path]
            # a reader sees the block, and not what its fence says
            told = f"# in {base}" + (f", without its {' and '.join(gone)}" if gone else "")
            self.assertEqual(text.splitlines()[0], told, snippet.place)
            for path in gone:
                dropped(scene, path)
            merged(scene, text_format.Parse(text, scene_class()()))
            text = text_format.MessageToString(scene)
            name = str(Path(base).parent / name)  # beside the base's files
        (folder / name).write_text(text)
        sunder = "coupler/sunder"
        self._run(snippet, [sunder, "check", name], folder)
        if snippet.is_run:
            until = snippet.option("until")
            self._run(snippet, [sunder, "run", name, *(("--until", until) if until else ()), "--no-pictures", "--quiet",
                                "--out", f"{name}.run"], folder)

    def _parsed(self, snippet: Snippet, folder: Path) -> None:
        """Arguments are understood, and the files that they name are there."""
        parser, _ = make_parser(subcommands(("sunder_tools.command", "tests.commands")))
        for words in commands_of(snippet.text):
            self.assertEqual(words[0], "coupler/sunder", f"{snippet.place}: only commands of sunder can be checked: {words}")
            try:
                parser.parse_args(words[1:])
            except (CommandError, SystemExit) as error:
                self.fail(f"{snippet.place}: {' '.join(words)}: {error}")
            for word in words[1:]:
                if re.match(r"(scenes|coupler|tests|rigid)/", word):
                    self.assertTrue((folder / word).exists(), f"{snippet.place}: {word} is not there")

    def _block(self, snippet: Snippet, folder: Path) -> None:
        """Does with a block what its info string asks for; fails, with its place, where that does not work."""
        if snippet.option("file") and snippet.language != "textproto":
            (folder / str(snippet.option("file"))).write_text(snippet.text)
        if snippet.mode == "norun":
            return
        if snippet.language == "textproto":
            self._scene(snippet, folder)
        elif snippet.language == "sh" and snippet.mode == "check":
            self._parsed(snippet, folder)
        elif snippet.language == "sh":
            self._run(snippet, ["bash", "-euo", "pipefail", "-c", snippet.text], folder)
        elif snippet.language == "python":
            compile(snippet.text, snippet.place, "exec")
            if snippet.is_run:
                self._run(snippet, ["/usr/bin/python3", "-c", snippet.text], folder)

    def _readme(self, readme: Path) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder_of_a_reader(Path(name))
            for snippet in snippets(readme):
                with self.subTest(place=snippet.place):
                    self._block(snippet, Path(name))

    def test_every_block_says_what_it_is(self) -> None:
        for readme in readmes():
            for snippet in snippets(readme):
                self.assertIn(snippet.language, LANGUAGES, f"{snippet.place}: name the language; output is text")
                if snippet.mode != "run":
                    self.assertGreater(len(snippet.reason), 8, f"{snippet.place}: say why it is not run")
                elif snippet.language == "textproto":
                    self.assertTrue(snippet.is_run, f"{snippet.place}: say until=SECONDS, or run")
                elif snippet.language == "python":
                    self.assertTrue(snippet.is_run, f"{snippet.place}: say run, or check: and why it is compiled only")
                self.assertFalse(snippet.language == "cpp" and snippet.mode != "check",
                                 f"{snippet.place}: say check: and which file of tests/ compiles these lines")

    def test_excerpts_of_cpp_are_compiled_by_a_test(self) -> None:
        """The lines of a block stand in the file that its reason names, but for their indent."""
        found = 0
        for readme in readmes():
            for snippet in (one for one in snippets(readme) if one.language == "cpp"):
                named = re.search(r"tests/[\w/]+_test\.cpp", snippet.reason)
                self.assertIsNotNone(named, f"{snippet.place}: name the file of tests/ that compiles it")
                assert named is not None
                text = " ".join((TOP / named[0]).read_text(encoding="utf-8").split())
                self.assertIn(" ".join(snippet.text.split()), text, f"{snippet.place}: {named[0]} has other lines")
                found += 1
        self.assertGreater(found, 0)

    def test_every_key_of_a_run_is_explained(self) -> None:
        """coupler/README.md has run.json key by key, two levels deep; roof starts in equilibrium."""
        page = (TOP / "coupler" / "README.md").read_text()
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            folder_of_a_reader(folder)
            for scene in ("intact_pane", "soft_ball", "roof"):
                self._run(Snippet(TOP / "coupler" / "README.md", 0, "sh", "", ""),
                          ["coupler/sunder", "run", f"scenes/{scene}.textproto", "--until", "5e-3", "--no-pictures",
                           "--quiet", "--out", scene], folder)
                run = json.loads((folder / scene / "run.json").read_text())
                keys = [f"{section}.{key}" for section, part in run.items() if isinstance(part, dict) for key in part]
                self.assertGreater(len(keys), 40)
                found = run.get("equilibrium", [])  # a list: the keys of an entry stand alone
                self.assertEqual(len(found), scene == "roof")
                missing = [key for key in [*run, *keys, *(key for entry in found for key in entry)] if f"`{key}`" not in page]
                self.assertEqual(missing, [], f"coupler/README.md does not explain these keys of {scene}")

    def test_a_part_goes_into_what_has_its_name(self) -> None:
        def scene(text: str) -> Any:
            return text_format.Parse(text, scene_class()())

        base = scene('shells { name: "a" thickness_m: 1 supports { kind: CLAMPED } plate { size_x_m: 2 } } shells { name: "b" }')
        dropped(base, "shells[a].supports")
        merged(base, scene('shells { name: "a" thickness_m: 3 cylinder { radius_m: 4 } } shells { name: "c" } end_time_s: 5'))
        self.assertEqual(base, scene('shells { name: "a" thickness_m: 3 cylinder { radius_m: 4 } } shells { name: "b" } '
                                     'shells { name: "c" } end_time_s: 5'))
        with self.assertRaises(KeyError):
            dropped(base, "shells[d].supports")

    def test_what_does_not_work_is_found(self) -> None:
        """Each block is refused, with its place."""
        blocks = (("sh", "", "coupler/sunder check scenes/none.textproto\n"),
                  ("sh", "check: long", "coupler/sunder run scenes/glass.textproto --quick\n"),
                  ("sh", "check: long", "coupler/sunder run scenes/none.textproto\n"),
                  ("textproto", "into=scenes/intact_pane.textproto", '# in scenes/intact_pane.textproto\nshells { name: "pane" thickness_m: -1 }\n'),
                  ("python", "run", "import nothing_of_that_name\n"))
        for language, info, text in blocks:
            with tempfile.TemporaryDirectory() as name:
                folder_of_a_reader(Path(name))
                with self.assertRaisesRegex(AssertionError, "README.md:7: "):
                    self._block(Snippet(TOP / "README.md", 7, language, info, text), Path(name))


def _add_tests() -> None:
    """A test for each README that shows something, so that one can be run alone."""
    for readme in readmes():
        if snippets(readme):
            name = re.sub(r"\W", "_", str(readme.relative_to(TOP).parent)).strip("_") or "root"

            def test(self: Snippets, readme: Path = readme) -> None:
                self._readme(readme)
            setattr(Snippets, f"test_{name}", test)


_add_tests()

if __name__ == "__main__":
    unittest.main()
