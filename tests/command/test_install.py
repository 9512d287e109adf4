"""What `cmake --install` leaves: a command, an importable package, programs, scenes; and that its lists are whole."""
from __future__ import annotations

import json
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

from sunder_tools.launch.install import PACKAGES
from sunder_tools.version import version

from . import REPOSITORY

BUILD = Path(os.environ.get("SUNDER_BUILD_DIR") or REPOSITORY / "build" / "release").absolute()


class Installation(unittest.TestCase):
    root: Path
    environment: dict[str, str]

    @classmethod
    def setUpClass(cls) -> None:
        if not os.access(BUILD / "coupler" / "single" / "sunder-single", os.X_OK):
            raise unittest.SkipTest(f"{BUILD} is not built")
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.root = Path(os.path.realpath(temporary.name))
        subprocess.run(["cmake", "--install", str(BUILD), "--prefix", str(cls.root / "usr")], check=True,
                       stdout=subprocess.DEVNULL)
        cls.environment = {key: value for key, value in os.environ.items() if not key.startswith("SUNDER_")}
        cls.environment["XDG_CACHE_HOME"] = str(cls.root / "cache")

    def sunder(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([str(self.root / "usr" / "bin" / "sunder"), *arguments], cwd=self.root, env=self.environment,
                              capture_output=True, text=True, check=False)

    def test_command_and_programs_have_the_version(self) -> None:
        self.assertEqual(self.sunder("--version").stdout, f"sunder {version()}\n")
        for program in sorted((self.root / "usr" / "libexec" / "sunder").glob("*/*")):
            said = subprocess.run([str(program), "--version"], capture_output=True, text=True, check=True).stdout
            self.assertEqual(said, f"{program.name} {version()}\n")

    def test_a_scene_that_came_along_runs(self) -> None:
        scene = self.root / "usr" / "share" / "sunder" / "scenes" / "cut_pane.textproto"
        ran = self.sunder("run", str(scene), "--until", "0.0005", "--out", "out")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        run = json.loads((self.root / "out" / "run.json").read_text())
        self.assertEqual((run["status"], run["version"]), ("done", version()))
        self.assertTrue((self.root / "out" / "contact_sheet.png").is_file())

    def test_what_needs_the_sources_is_not_there(self) -> None:
        self.assertNotIn("validate", self.sunder("--help").stdout)
        built = self.sunder("build", "--cad")
        self.assertEqual(built.returncode, 2, built.stdout)
        self.assertIn("which an installation does not have", built.stderr)

    def test_scripts_import_it(self) -> None:
        packages = self.root / "usr" / "lib" / "python3" / "dist-packages"
        script = "import sunder; print(sunder.Scene.load(sunder.SCENES / 'cut_pane.textproto').message.name)"
        ran = subprocess.run(["/usr/bin/python3", "-c", script], env={**self.environment, "PYTHONPATH": str(packages)},
                             cwd=self.root, capture_output=True, text=True, check=False)
        self.assertEqual(ran.stdout, "cut_pane\n", ran.stderr)


class Container(unittest.TestCase):
    def test_it_installs_what_a_build_needs(self) -> None:
        words = set(re.findall(r"[\w+-]+", (REPOSITORY / "coupler" / "Containerfile").read_text()))
        at_run_time = {"python3-numpy", "python3-pil", "python3-protobuf"}
        self.assertEqual(set(PACKAGES) - words - at_run_time, set())
        depends = (REPOSITORY / "coupler" / "install.cmake").read_text()
        self.assertEqual([name for name in at_run_time if name not in depends], [])


if __name__ == "__main__":
    unittest.main()
