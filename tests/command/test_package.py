"""`report package` and `report ci`: a package of made-up programs, steps of .ci/run, and what is refused."""
from __future__ import annotations

import contextlib
import io
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from sunder_tools.errors import CommandError
from sunder_tools.launch.build import Executables
from tests.benchmarks import ci, goals, package

from . import REPOSITORY

NATIVE = Executables(Path("shell"), Path("rigid"), Path("single"))


def make_deb(folder: Path, command: str | None = "exit 0") -> Path:
    """A package with a command of these lines, and programs for the least level."""
    root = folder / "tree"
    (root / "DEBIAN").mkdir(parents=True)
    (root / "DEBIAN" / "control").write_text("Package: sunder\nVersion: 1\nArchitecture: all\nMaintainer: a <a@b.example>\n"
                                             "Description: of a test\n")
    files = {"libexec/sunder/x86-64-v2/sunder-shell": ""} | ({"bin/sunder": f"#!/bin/sh\n{command}\n"} if command else {})
    for name, text in files.items():
        path = root / "usr" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)
    out = folder / "sunder_1_all.deb"
    subprocess.run(["dpkg-deb", "--build", "--root-owner-group", str(root), str(out)], check=True, capture_output=True)
    return out


@unittest.skipUnless(shutil.which("dpkg-deb"), "dpkg-deb is not installed")
class Package(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = Path(temporary.name)
        out = contextlib.redirect_stdout(io.StringIO())
        out.__enter__()
        self.addCleanup(out.__exit__, None, None, None)

    def test_a_package_is_unpacked_run_and_compared(self) -> None:
        asked: list[Path] = []
        deb = make_deb(self.root, f'echo "$@" > {self.root}/asked')

        def force(executables: Executables) -> float:
            asked.append(executables.shell)
            return 2.0 if executables is NATIVE else 2.08

        with mock.patch.multiple(package, ensure_built=lambda: NATIVE, force_s=force, reads_cad=lambda path: False,
                                 level=lambda folder: folder / "x86-64-v2"):
            numbers = package.measure_package(deb)
        self.assertAlmostEqual(numbers["package_force_time_ratio"], 1.04)
        self.assertEqual(numbers["package_reads_cad"], 0.0)
        self.assertNotIn("package_build_s", numbers)
        self.assertEqual(goals.beyond(numbers), [])
        self.assertRegex((self.root / "asked").read_text(), r"^run /.*/usr/share/sunder/scenes/cut_pane.textproto --until 0.0005 --out /")
        self.assertTrue(all(path == NATIVE.shell or path.parent.name == "x86-64-v2" for path in asked))
        self.assertEqual(len(asked), 2 * package.ROUNDS)

    def test_the_least_of_rounds_in_turns_decides(self) -> None:
        times = iter((1.0, 2.0, 1.5, 1.2, 1.1, 1.9, 1.3, 1.4))
        order: list[bool] = []

        def force(executables: Executables) -> float:
            order.append(executables is NATIVE)
            return next(times)

        with mock.patch.multiple(package, force_s=force, ROUNDS=4):
            numbers = package.compared(Executables(Path("a"), Path("b"), Path("c")), NATIVE)
        self.assertEqual(order, [True, False, False, True] * 2)
        self.assertEqual(numbers, {"native_force_s": 1.0, "package_force_s": 1.3, "package_force_time_ratio": 1.3})
        self.assertEqual(goals.beyond(numbers), ["package_force_time_ratio"])

    def test_refused(self) -> None:
        with self.assertRaisesRegex(CommandError, "there is no such file; 'sunder report package' builds one"):
            package.measure_package(self.root / "none.deb")
        (self.root / "text.deb").write_text("no archive")
        with self.assertRaisesRegex(CommandError, "text.deb: is no package of Sunder; dpkg-deb: error"):
            package.measure_package(self.root / "text.deb")
        with self.assertRaisesRegex(CommandError, "is no package of Sunder; it has no usr/bin/sunder"):
            package.measure_package(make_deb(self.root, None))

    def test_a_command_that_fails_is_told_with_its_words(self) -> None:
        with self.assertRaisesRegex(CommandError, r"ended with status 3:\nlost the engine"):
            package.measure_package(make_deb(self.root, "echo lost the engine >&2; exit 3"))


class Steps(unittest.TestCase):
    def test_the_steps_are_those_of_the_script(self) -> None:
        script = (REPOSITORY / ".ci" / "run").read_text()
        self.assertEqual(tuple(re.findall(r"^step (\w+)", script, re.MULTILINE)), ci.STEPS)
        self.assertIn(f"build/{ci.FILE}", script)

    def test_a_run_to_the_end_is_read_and_any_other_refused(self) -> None:
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(ci, "commit", lambda: "0123456789+"):
            path = Path(folder) / ci.FILE
            with self.assertRaisesRegex(CommandError, "lacks programs, tests_built, tests: run '.ci/run' to its end"):
                ci.read(path)
            path.write_text("0123456789\nprograms 300\ntests_built 400\n")
            with self.assertRaisesRegex(CommandError, "lacks tests: "):
                ci.read(path)
            path.write_text("0123456789\nprograms 300\ntests_built 400\ntests 1401\n")
            numbers = ci.read(path)
            self.assertEqual(numbers, {"ci_programs_s": 300.0, "ci_tests_built_s": 400.0, "ci_tests_s": 1401.0, "ci_s": 2101.0})
            self.assertEqual(goals.beyond(numbers), ["ci_s"])
            path.write_text("ffffffffff\nprograms 300\ntests_built 400\ntests 1\n")
            with self.assertRaisesRegex(CommandError, r"tells of commit ffffffffff, and this is 0123456789\+: run '.ci/run' again"):
                ci.read(path)


if __name__ == "__main__":
    unittest.main()
