"""The sources as tools see them: layout, suspicious C++, unused and undefined names, types.

Each is skipped, with the reason, where its tool is not installed; `sunder test` installs them.
"""
from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from . import REPOSITORY

FORMAT_VERSION = "14"  # clang-format of Debian 12: others lay out a few lines in other ways
# Rooms that clang-tidy reads, but for files that include CGAL, and the one of Eigen's solvers, which take minutes.
SOLVERS = "coupler/core/dense.cpp"
TIDY = ("coupler/core", "shell/geometry", "shell/grid")
TIDY_FLAGS = ("-std=c++20", f"-I{REPOSITORY}", "-isystem", "/usr/include/eigen3", "-DFMT_SHARED", "-DSUNDER_VERSION=\"0\"")


class Sources(unittest.TestCase):
    def run_tool(self, name: str, *command: str, cwd: Path = REPOSITORY) -> str:
        """What it says, where that is no praise."""
        if shutil.which(name) is None:
            self.skipTest(f"{name} is not installed")
        done = subprocess.run(command, cwd=cwd, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        return "" if done.returncode == 0 else done.stdout + done.stderr

    @staticmethod
    def files(*endings: str, rooms: tuple[str, ...] = ("coupler", "shell", "rigid", "tests")) -> list[str]:
        return sorted(str(p) for room in rooms for p in (REPOSITORY / room).rglob("*") if p.suffix in endings)

    def test_layout(self) -> None:
        files = self.files(".cpp", ".h")
        self.assertGreater(len(files), 200)
        if shutil.which("clang-format"):
            told = subprocess.run(["clang-format", "--version"], capture_output=True, text=True, check=True).stdout
            if not re.search(rf"version {FORMAT_VERSION}\.", told):
                self.skipTest(f"clang-format {FORMAT_VERSION} lays these sources out; here is: {told.strip()}")
        self.assertEqual(self.run_tool("clang-format", "clang-format", "--dry-run", "-Werror", *files), "",
                         "mend it with: clang-format -i FILE")

    def test_suspicious_cpp(self) -> None:
        # Headers take nearly all of its time: the files of a room are read as one, as they are compiled (coupler/join.cmake).
        for room in TIDY:
            files = [path for path in self.files(".cpp", rooms=(room,)) if "<CGAL/" not in Path(path).read_text(encoding="utf-8") and not path.endswith(SOLVERS)]
            self.assertGreater(len(files), 1)
            with tempfile.TemporaryDirectory() as folder:
                joined = Path(folder) / "joined.cpp"
                joined.write_text("".join(f'#include "{path}"\n' for path in files), encoding="utf-8")
                self.assertEqual(self.run_tool("clang-tidy", "clang-tidy", "--quiet", "--warnings-as-errors=*",
                                               f"--config-file={REPOSITORY}/.clang-tidy", "--checks=-bugprone-suspicious-include",
                                               str(joined), "--", *TIDY_FLAGS), "")

    def test_names_of_python(self) -> None:
        self.assertEqual(self.run_tool("pyflakes3", "pyflakes3", "coupler", "tests", "scenes"), "")

    def test_types_of_python(self) -> None:
        with tempfile.TemporaryDirectory() as cache:
            self.assertEqual(self.run_tool("mypy", "mypy", "--config-file", ".mypy.ini", "--cache-dir", cache,
                                           "coupler/sunder_tools", "coupler/sunder_lab", "coupler/sunder.py", "coupler/sunder_engine",
                                           "proto/reference.py", "tests"), "")


if __name__ == "__main__":
    unittest.main()
