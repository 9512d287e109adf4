"""The rules of the house: who may include whom, and how long a file may be."""
from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from . import REPOSITORY as TOP
from .function_lengths import of_cpp, of_python
from .python_imports import cycle, imports, modules, of_packages

MOST_LINES = 500
MOST_IN_A_FUNCTION = 120
MOST_IN_A_SUBJECT = 72  # characters: what `git log --oneline` shows on a line of 80
SINCE = "d01ae8edad34b53c471707b991be59372ee80ece"  # later subjects are judged; some earlier ones are longer
LONGER = {"shell/fracture/constants.h": 700}  # all constants of fracture stand in one file
SOURCES = sorted(p for room in ("shell", "rigid", "coupler") for p in (TOP / room).rglob("*") if p.suffix in (".h", ".cpp"))

BELOW_SOLVER = {"coupler/core", "shell/geometry", "shell/grid", "shell/mechanics", "shell/fracture", "shell/contact"}
SOLVER = {"shell/solver", *(f"shell/solver/{room}" for room in ("cracking", "joining", "contact", "parting", "statics",
                                                                "stepping"))}

# what a room may include besides itself
MAY: dict[str, set[str]] = {
    "coupler/core": set(),
    "coupler/scene": {"coupler/core"},
    "coupler/link": {"coupler/core"},
    "shell/geometry": {"coupler/core"},
    "shell/grid": {"coupler/core"},
    "shell/meshes": {"coupler/core", "shell/geometry"},
    "shell/mechanics": {"coupler/core", "shell/geometry"},
    "shell/fracture": {"coupler/core", "shell/geometry"},
    "shell/contact": {"coupler/core", "shell/geometry", "shell/grid"},
    "shell/solver": {"coupler/core", "shell/geometry", "shell/grid", "shell/mechanics", "shell/fracture",
                     "shell/contact"},
    "shell/solver/cracking": {*BELOW_SOLVER, "shell/solver"},
    "shell/solver/joining": {*BELOW_SOLVER, "shell/solver", "shell/solver/cracking"},
    "shell/solver/contact": {*BELOW_SOLVER, "shell/solver", "shell/solver/joining"},
    "shell/solver/parting": {*BELOW_SOLVER, "shell/solver", "shell/solver/cracking"},
    "shell/solver/statics": {*BELOW_SOLVER, "shell/solver", "shell/solver/joining"},
    "shell/solver/stepping": {*BELOW_SOLVER, "shell/solver", "shell/solver/joining"},
    "shell/soft": {"coupler/core", "shell/grid", "shell/contact", *SOLVER},
    "shell/io": {"coupler/scene", "coupler/link", *BELOW_SOLVER, *SOLVER, "shell/meshes", "shell/soft"},
    "shell/run": {"coupler/scene", "coupler/link", *BELOW_SOLVER, *SOLVER, "shell/soft", "shell/io"},
    "shell": {"coupler/core", "coupler/link", "shell/run"},
    "coupler/single": {"coupler/link", "rigid/engine", "shell/run"},
    "rigid/engine": {"coupler/core", "coupler/link"},
    "rigid": {"coupler/core", "coupler/link", "rigid/engine"},
}

# what a package of Python may import besides itself; "sunder_tools" alone is errors.py and places.py
MAY_PYTHON: dict[str, set[str]] = {
    "sunder_tools": set(),
    "sunder_tools.report": {"sunder_tools"},
    "sunder_tools.launch": {"sunder_tools", "sunder_tools.report"},
    "sunder_tools.pictures": {"sunder_tools", "sunder_tools.report", "sunder_tools.launch"},
    "sunder_lab": {"sunder_tools", "sunder_tools.report", "sunder_tools.launch", "sunder_tools.pictures"},
    "sunder_lab.trade": {"sunder_tools", "sunder_tools.launch", "sunder_tools.pictures", "sunder_lab"},
    "sunder_lab.paper": {"sunder_tools", "sunder_tools.report", "sunder_tools.launch", "sunder_tools.pictures", "sunder_lab"},
    "sunder_tools.command": {"sunder_tools", "sunder_tools.report", "sunder_tools.launch", "sunder_tools.pictures",
                             "sunder_lab", "sunder_lab.trade", "sunder_lab.paper"},
    "sunder": {"sunder_tools", "sunder_lab"},
    "sunder_engine": set(),  # may be copied alone
}
PRODUCT = ["sunder_tools", "sunder_lab", "sunder", "sunder_engine"]


def includes(path: Path) -> list[str]:
    return re.findall(r'^#include [<"]([^">]+)[">]', path.read_text(), re.MULTILINE)


def names_its_module(test: Path) -> bool:
    """Whether a test, by its path below tests/, begins with the name of a module of the folder that it is for."""
    modules_there = {p.stem for p in (TOP / test.parent).glob("*") if p.suffix in (".h", ".cpp")}
    return any(f"{test.stem}_".startswith(f"{module}_") for module in modules_there)


def long_subjects(repository: Path, since: str = SINCE) -> list[str]:
    """Subjects of commits since the last tag that are too long; without a tag since a commit, or where that is not there, as in a
    shallow clone, of the last one."""
    def git(*arguments: str) -> str:
        return subprocess.run(["git", "-c", "safe.directory=*", "-C", str(repository), *arguments], capture_output=True, text=True,
                              check=False).stdout.strip()
    start = git("describe", "--tags", "--abbrev=0") or git("rev-parse", "--verify", "--quiet", f"{since}^{{commit}}")
    subjects = git("log", "--format=%s", *([f"{start}..HEAD"] if start else ["-1"])).splitlines()
    return [subject for subject in subjects if len(subject) > MOST_IN_A_SUBJECT]


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
        self.assertEqual(cycle(MAY), [])

    def test_every_test_module_is_run_by_ctest(self) -> None:
        text = (TOP / "tests" / "CMakeLists.txt").read_text()
        run = set(re.findall(r"-m unittest (?:-v )?(tests\.[\w.]+)(?=[ )])", text))
        for variable, values, body in re.findall(r"foreach\((\w+) ([^)]*)\)(.*?)endforeach", text, re.DOTALL):
            for name in re.findall(r"-m unittest (?:-v )?(tests\.[\w.]+_)\$\{" + variable + r"\}", body):
                run |= {name + value for value in values.split()}
        there = {".".join(p.relative_to(TOP).with_suffix("").parts) for p in (TOP / "tests").rglob("test_*.py")}
        self.assertEqual(run, there)

    def test_what_compiles_starts_before_other_tests(self) -> None:
        text = (TOP / "tests" / "CMakeLists.txt").read_text()
        cost = {name: int(number) for names, number in re.findall(r"set_tests_properties\(([\w ]+) PROPERTIES COST (\d+)\)", text)
                for name in names.split()}
        self.assertEqual(max(cost, key=lambda name: cost[name]), "sanitized_build")
        self.assertIn("command_sources", cost)

    def test_libraries_are_named_where_they_belong(self) -> None:
        homes = {r"zmq": {"coupler/link/channel.cpp", "coupler/link/keys.cpp"}, r"CGAL/": {"shell/fracture/cdt.h", "shell/fracture/outline.cpp",
                                                            "shell/fracture/medial_axis.cpp", "shell/contact/hull.cpp",
                                                            "coupler/scene/closed_surface.cpp",
                                                            "coupler/core/convex_surface.cpp"},
                 r"Spectra/": {"shell/solver/statics/modes.cpp"},
                 r".*\.hxx$": {"shell/io/cad_file.cpp", "shell/io/cad_face.cpp", "shell/io/cad_face.h",
                               "shell/io/cad_crossings.cpp", "shell/io/cad_crossings.h",
                               "shell/io/cad_names.cpp", "shell/io/cad_names.h"}}  # OpenCASCADE
        for path in SOURCES:
            for pattern, allowed in homes.items():
                if any(re.match(pattern, name) for name in includes(path)):
                    self.assertIn(str(path.relative_to(TOP)), allowed)
            if any(re.match(r"(LinearMath|Bullet|bt)", name) for name in includes(path)):
                self.assertTrue(path.name.startswith("bullet_"), f"{path} names the engine")
            if any(name.startswith("ode/") for name in includes(path)):
                self.assertEqual(path.name, "ode_solver.cpp", f"{path} names the engine")
            if any(name.startswith("dart/") for name in includes(path)):
                self.assertEqual(path.name, "dart_solver.cpp", f"{path} names the engine")

    def test_python_goes_one_way(self) -> None:
        found = modules(TOP / "coupler", PRODUCT)
        self.assertGreater(len(found), 60)
        for package, others in of_packages(imports(found), found).items():
            self.assertIn(package, MAY_PYTHON, "a package that the house does not know")
            self.assertLessEqual(others, MAY_PYTHON[package], f"{package} imports what it may not")
        self.assertEqual(cycle(MAY_PYTHON), [])

    def test_python_modules_import_in_no_circle(self) -> None:
        found = {**modules(TOP / "coupler", PRODUCT), **modules(TOP, ["tests"])}
        self.assertGreater(len(found), 120)
        self.assertEqual(cycle(imports(found)), [])

    def test_a_circle_is_found_also_where_an_import_is_inside_a_function(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            package = Path(folder) / "one"
            (package / "inner").mkdir(parents=True)
            for name, text in (("__init__", ""), ("a", "from .inner import b\n"), ("c", "import os\n"),
                               ("inner/__init__", ""), ("inner/b", "def f():\n    from ..a import x\n")):
                (package / f"{name}.py").write_text(text)
            found = modules(Path(folder), ["one"])
            graph = imports(found)
            self.assertEqual(cycle(graph), ["one.a", "one.inner.b", "one.a"])
            self.assertEqual(of_packages(graph, found), {"one": {"one.inner"}, "one.inner": {"one"}})
            self.assertEqual(cycle({"one.a": set(), "one.c": {"one.a"}}), [])

    def test_the_product_does_without_tests(self) -> None:
        """`coupler/sunder` alone looks whether there are any, for their subcommands."""
        for path in [*SOURCES, *(TOP / "coupler").rglob("*.py"), *(TOP / "coupler" / "viewer").glob("*.js")]:
            self.assertNotRegex(path.read_text(), r"\btests(/\w|\.\w)|\bimport tests\b|\"tests\"", f"{path}: names tests/")

    def test_what_users_copy_imports_sunder_only(self) -> None:
        for path in (TOP / "coupler" / "experiments").glob("*.py"):
            self.assertNotRegex(path.read_text(), r"sunder_(lab|tools)")

    def test_a_test_of_cpp_has_the_name_of_its_module(self) -> None:
        """tests/ROOM/FOLDER/X_test.cpp: X is a module of ROOM/FOLDER, or begins with one and '_'. Tests of several modules
        are in tests/scenarios."""
        tests = [path for room in ("shell", "rigid", "coupler") for path in (TOP / "tests" / room).rglob("*_test.cpp")]
        self.assertGreater(len(tests), 80)
        self.assertEqual([str(path.relative_to(TOP)) for path in tests if not names_its_module(path.relative_to(TOP / "tests"))], [])

    def test_a_test_without_a_module_is_found(self) -> None:
        for good in ("coupler/scene/validate_test.cpp", "coupler/scene/validate_seams_test.cpp", "coupler/link/rigid_link_test.cpp"):
            self.assertTrue(names_its_module(Path(good)), good)
        for bad in ("coupler/scene/crack_scene_test.cpp", "coupler/scene/validated_test.cpp", "coupler/none/load_test.cpp"):
            self.assertFalse(names_its_module(Path(bad)), bad)

    def test_no_file_is_long(self) -> None:
        long = [f"{name}: {n}" for room in ("proto", "shell", "rigid", "coupler", "tests")
                for p in (TOP / room).rglob("*") if p.suffix in (".h", ".cpp", ".proto", ".py", ".mjs", ".js")
                if (n := len(p.read_text().splitlines())) > LONGER.get(name := str(p.relative_to(TOP)), MOST_LINES)]
        self.assertEqual(long, [])

    def test_no_function_is_long(self) -> None:
        found = [(path, first, length) for room in ("proto", "shell", "rigid", "coupler", "scenes", "tests")
                 for path in (TOP / room).rglob("*") if path.suffix in (".h", ".cpp", ".py")
                 for first, length in (of_python if path.suffix == ".py" else of_cpp)(path.read_text(encoding="utf-8"))]
        self.assertGreater(len(found), 5000)
        self.assertEqual([f"{path.relative_to(TOP)}:{first}: {length}" for path, first, length in found
                          if length > MOST_IN_A_FUNCTION], [])

    def test_functions_are_found_with_their_lengths(self) -> None:
        text = ('namespace a {  // {\nstruct B : C {\n  int d() const { return 1; }\n  int e{2};\n};\nconst char* f = "}{";\n'
                'template <class T>\nT g(T x,\n    T y) {\n  auto h = [&] {\n    return R"(})";\n  };\n  return h();\n}\n'
                "constexpr int kTable[] = {\n    1,\n    1'000};\n}\n")
        self.assertEqual(of_cpp(text), [(3, 1), (7, 8)])
        self.assertEqual(of_python("class A:\n    def f(self):\n        return 1\n\n\nasync def g():\n    pass\n"), [(6, 2), (2, 2)])
        for bad in ("void f() {\n", "}\n"):
            with self.assertRaises(ValueError):
                of_cpp(bad)

    @unittest.skipUnless((TOP / ".git").exists() and shutil.which("git"), "no repository of git")
    def test_no_subject_of_a_commit_is_long(self) -> None:
        self.assertEqual(long_subjects(TOP), [])

    @unittest.skipUnless(shutil.which("git"), "git is not installed")
    def test_a_long_subject_is_found_after_the_last_tag_only(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            def git(*arguments: str) -> None:
                subprocess.run(["git", "-C", folder, "-c", "user.name=a", "-c", "user.email=a@b.example", *arguments],
                               capture_output=True, check=True)

            git("init")
            for letter, tagged in (("a", False), ("b", True), ("c", False), ("d", False)):
                git("commit", "--allow-empty", "-m", letter * (MOST_IN_A_SUBJECT + (letter != "d")) + "\n\n" + "body " * 30)
                last = [letter * (MOST_IN_A_SUBJECT + 1)]
                self.assertEqual(long_subjects(Path(folder)), last if letter != "d" else ["c" * (MOST_IN_A_SUBJECT + 1)])
                if letter == "a":
                    first = subprocess.run(["git", "-C", folder, "rev-parse", "HEAD"], capture_output=True, text=True, check=True).stdout.strip()
                if letter == "b":
                    self.assertEqual(long_subjects(Path(folder), first), last)
                if tagged:
                    git("tag", "v1")
                    self.assertEqual(long_subjects(Path(folder)), [])

    def test_every_folder_says_what_it_is_for(self) -> None:
        for room in ("proto", "coupler", "shell", "rigid", "scenes", "tests"):
            self.assertTrue((TOP / room / "README.md").is_file(), room)


if __name__ == "__main__":
    unittest.main()
