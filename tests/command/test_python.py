"""What scripts import: installing it by pip without a network, its types, its help, and an example run cell by cell."""
from __future__ import annotations

import contextlib
import importlib.util
import io
import os
import pydoc
import re
import shutil
import subprocess
import tempfile
import unittest
import unittest.mock
from pathlib import Path

import sunder
from sunder_tools import places
from sunder_tools.version import version

from . import REPOSITORY

BUILD = Path(os.environ.get("SUNDER_BUILD_DIR") or REPOSITORY / "build" / "release").absolute()
NEEDED = {"pip": "python3-pip", "setuptools": "python3-setuptools", "wheel": "python3-wheel"}
EXAMPLE = REPOSITORY / "coupler" / "experiments" / "first_look.py"


def files_of(folder: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if "__pycache__" not in path.parts}


class Installed(unittest.TestCase):
    root: Path
    python: Path
    left: set[Path]

    @classmethod
    def setUpClass(cls) -> None:
        missing = [package for module, package in NEEDED.items() if importlib.util.find_spec(module) is None]
        if missing:
            raise unittest.SkipTest(f"{', '.join(missing)} not installed")
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.root = Path(holder.name)
        cls.python = cls.root / "V" / "bin" / "python"
        subprocess.run(["/usr/bin/python3", "-m", "venv", "--without-pip", "--system-site-packages", str(cls.root / "V")], check=True)
        before = files_of(REPOSITORY / "coupler")
        environment = {key: value for key, value in os.environ.items() if not key.startswith(("PIP_", "PYTHON"))}
        done = subprocess.run(["/usr/bin/python3", "-m", "pip", "--python", str(cls.python), "install", "--no-build-isolation",
                               "--no-index", "--quiet", str(REPOSITORY / "coupler")], env=environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        cls.left = files_of(REPOSITORY / "coupler") - before

    def run_python(self, script: str) -> subprocess.CompletedProcess[str]:
        environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        return subprocess.run([str(self.python), "-c", script], cwd=self.root, env=environment, capture_output=True, text=True,
                              check=False)

    def test_it_is_imported_from_anywhere_and_finds_the_checkout(self) -> None:
        done = self.run_python("import importlib.metadata, sunder; print(sunder.__file__); print(importlib.metadata.version('sunder'));"
                               "print(sunder.Scene.load(sunder.SCENES / 'cut_pane.textproto').message.name)")
        self.assertEqual(done.returncode, 0, done.stderr)
        where, number, scene = done.stdout.splitlines()
        self.assertTrue(Path(where).is_relative_to(self.root), where)
        self.assertEqual((number, scene), (version(), "cut_pane"))

    def test_nothing_is_left_in_the_checkout(self) -> None:
        self.assertEqual(self.left, set())

    def test_types_are_known(self) -> None:
        if shutil.which("mypy") is None:
            self.skipTest("mypy is not installed")
        (self.root / "script.py").write_text("import sunder\nreveal_type(sunder.Results('x').frames)\n"
                                             "area: str = sunder.pieces(sunder.Results('x')).mean_size()\n")
        environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "MYPY"))}
        done = subprocess.run(["mypy", "--python-executable", str(self.python), "--cache-dir", str(self.root / "cache"), "script.py"],
                              cwd=self.root, env=environment, capture_output=True, text=True, check=False)
        self.assertRegex(done.stdout, r"script\.py:2: note: Revealed type is .*list\[sunder_tools\.pictures\.frames\.Frame\]")
        self.assertRegex(done.stdout, r'script\.py:3: error: Incompatible types .*expression has type "float", variable has type "str"')
        self.assertNotIn("py.typed", done.stdout)

    def test_a_checkout_that_is_gone_is_told(self) -> None:
        package = next((self.root / "V" / "lib").glob("python3*/site-packages/sunder_tools"))
        kept = (package / "CHECKOUT").read_text()
        self.assertEqual(Path(kept.strip()), places.REPOSITORY)
        self.addCleanup((package / "CHECKOUT").write_text, kept)
        (package / "CHECKOUT").write_text("/nowhere/at/all\n")
        done = self.run_python("import sunder")
        self.assertIn("ImportError: sunder was installed from the checkout /nowhere/at/all, which is not there; install it again",
                      done.stderr)


class Help(unittest.TestCase):
    def test_it_names_everything(self) -> None:
        listed = set(re.findall(r"\w+", sunder.__doc__ or ""))
        self.assertEqual([name for name in sunder.__all__ if name not in listed], [])
        shown = pydoc.plain(pydoc.render_doc(sunder))
        for name in sunder.__all__:
            thing = getattr(sunder, name)
            if callable(thing):
                self.assertTrue((thing.__doc__ or "").strip(), f"{name} has no docstring")
                self.assertNotRegex(thing.__doc__, rf"^{thing.__name__}\(", f"{name} has but the docstring that dataclasses make")
                self.assertIn(name if name != "Error" else "CommandError", shown)


class Example(unittest.TestCase):
    def test_it_runs_cell_by_cell(self) -> None:
        if not os.access(BUILD / "shell" / "sunder-shell", os.X_OK):
            self.skipTest(f"{BUILD} is not built")
        cells = re.split(r"^# %%", EXAMPLE.read_text(), flags=re.MULTILINE)[1:]
        self.assertGreaterEqual(len(cells), 5)
        namespace: dict[str, object] = {}
        here = os.getcwd()
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(os.environ, {"SUNDER_BUILD_DIR": str(BUILD)}):
            os.chdir(folder)
            self.addCleanup(os.chdir, here)
            for number, cell in enumerate(cells):
                said = io.StringIO()
                with contextlib.redirect_stdout(said):
                    exec(compile("#" + cell, f"cell {number}", "exec"), namespace)  # noqa: S102
                self.assertTrue(number == 0 or said.getvalue().strip(), f"cell {number} says nothing")
            os.chdir(here)
        areas, tracks, results = namespace["areas"], namespace["tracks"], namespace["results"]
        self.assertGreater(len(areas), 5)  # type: ignore[arg-type]
        self.assertLessEqual(set(map(int, results.shards["id"])), set(tracks))  # type: ignore[attr-defined,call-overload]


if __name__ == "__main__":
    unittest.main()
