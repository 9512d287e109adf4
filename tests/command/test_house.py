"""The rules of the house: who may include whom, and how long a file may be."""
from __future__ import annotations

import re
import unittest
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
MOST_LINES = 500
SOURCES = sorted(p for room in ("shell", "rigid", "coupler") for p in (TOP / room).rglob("*") if p.suffix in (".h", ".cpp"))

# what a room may include besides itself
MAY = {
    "coupler/core": set(),
    "coupler/scene": {"coupler/core"},
    "coupler/link": {"coupler/core"},
    "shell/geometry": {"coupler/core"},
    "shell/grid": {"coupler/core"},
    "shell/mechanics": {"coupler/core", "shell/geometry"},
    "shell/fracture": {"coupler/core", "shell/geometry"},
    "shell/contact": {"coupler/core", "shell/geometry", "shell/grid"},
    "shell/solver": {"coupler/core", "shell/geometry", "shell/grid", "shell/mechanics", "shell/fracture",
                     "shell/contact"},
    "shell/soft": {"coupler/core", "shell/grid", "shell/contact", "shell/solver"},
    "shell/io": {"coupler/core", "coupler/scene", "coupler/link", "shell/geometry", "shell/mechanics", "shell/fracture",
                 "shell/contact", "shell/solver", "shell/soft"},
    "shell": {"coupler/link", "shell/io"},
    "coupler/single": {"coupler/link", "rigid/engine", "shell/io"},
    "rigid/engine": {"coupler/core", "coupler/link"},
    "rigid": {"coupler/core", "coupler/link", "rigid/engine"},
}


def includes(path: Path) -> list[str]:
    return re.findall(r'^#include [<"]([^">]+)[">]', path.read_text(), re.MULTILINE)


class House(unittest.TestCase):
    def test_includes_go_one_way(self) -> None:
        self.assertGreater(len(SOURCES), 50)
        for path in SOURCES:
            room = str(path.parent.relative_to(TOP))
            self.assertIn(room, MAY, f"{path}: a room that the house does not know")
            for name in includes(path):
                other = str(Path(name).parent)
                if other.split("/")[0] not in ("shell", "rigid", "coupler") or other == room:
                    continue
                self.assertIn(other, MAY[room], f"{path.relative_to(TOP)} includes {name}")

    def test_every_file_of_these_tests_is_run(self) -> None:
        named = re.search(r"foreach\(module ([^)]*)\)", (TOP / "tests" / "CMakeLists.txt").read_text())
        assert named is not None
        self.assertEqual(named[1].split(), sorted(p.stem.removeprefix("test_") for p in Path(__file__).parent.glob("test_*.py")))

    def test_libraries_are_named_where_they_belong(self) -> None:
        homes = {r"zmq": {"coupler/link/channel.cpp", "coupler/link/keys.cpp"}, r"CGAL/": {"shell/fracture/cdt.h", "shell/fracture/outline.cpp",
                                                            "shell/fracture/medial_axis.cpp", "shell/contact/hull.cpp",
                                                            "coupler/scene/closed_surface.cpp",
                                                            "coupler/scene/convex_parts.cpp"},
                 r".*\.hxx$": {"shell/io/cad_file.cpp"}}  # OpenCASCADE
        for path in SOURCES:
            for pattern, allowed in homes.items():
                if any(re.match(pattern, name) for name in includes(path)):
                    self.assertIn(str(path.relative_to(TOP)), allowed)
            if any(re.match(r"(LinearMath|Bullet|bt)", name) for name in includes(path)):
                self.assertTrue(path.name.startswith("bullet_"), f"{path} names the engine")
            if any(name.startswith("ode/") for name in includes(path)):
                self.assertEqual(path.name, "ode_solver.cpp", f"{path} names the engine")

    def test_python_goes_one_way(self) -> None:
        """The package of the command does not know that of experiments, but for the one line that starts a sweep."""
        users = [p.name for p in (TOP / "coupler" / "sunder_tools").glob("*.py") if "sunder_lab" in p.read_text()]
        self.assertEqual(users, ["command.py"])
        for path in (TOP / "coupler" / "experiments").glob("*.py"):  # what users copy
            self.assertNotRegex(path.read_text(), r"sunder_(lab|tools)")

    def test_no_file_is_long(self) -> None:
        long = [f"{p.relative_to(TOP)}: {n}" for room in ("shell", "rigid", "coupler", "tests")
                for p in (TOP / room).rglob("*") if p.suffix in (".h", ".cpp", ".py", ".mjs", ".js")
                if (n := len(p.read_text().splitlines())) > MOST_LINES]
        self.assertEqual(long, [])

    def test_every_folder_says_what_it_is_for(self) -> None:
        for room in ("proto", "coupler", "shell", "rigid", "scenes", "tests"):
            self.assertTrue((TOP / room / "README.md").is_file(), room)


if __name__ == "__main__":
    unittest.main()
