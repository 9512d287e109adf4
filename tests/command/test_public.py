"""Public files of `validate surfaces`: what is said of them, and of a machine without their packages."""
from __future__ import annotations

import contextlib
import gzip
import io
import os
import tarfile
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

from sunder_tools.errors import CommandError
from tests.validation import experiments, public_files
from tests.validation.known import holds, judge
from tests.validation.public_files import ARCHIVE, FILES, NO_CAD, PublicFile, copied, fetched, inspected, taken_count, taken_in_words
from tests.validation.trials import Missing

FILE = PublicFile("part", "tools-doc", "usr/part.step.gz", 3)


def face(number: int, kind: str, **fields: object) -> dict[str, object]:
    return {"face": number, "kind": kind, "refused": None, "unfit": False, "approximated_m": 0.0, "warning": None, **fields}


class Public(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = Path(folder.name)

    def program(self, name: str, body: str) -> None:
        path = self.top / "bin" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("#!/bin/sh\n" + body)
        path.chmod(0o755)

    def test_says_what_was_taken_approximated_and_refused(self) -> None:
        told = {"faces": [face(0, "plane"), face(1, "torus", approximated_m=2e-6), face(2, "plane", refused="is a sliver"),
                          face(3, "cone", unfit=True, warning="is too small")], "seams_refused": "they do not meet"}
        self.assertEqual(taken_in_words(told, FILE), "part.step of tools-doc: 2 plane, 1 torus, 1 cone; 1 approximated to 2e-06 m; "
                         "face 2 refused: is a sliver; face 3 left out: is too small; seams refused: they do not meet")
        mesh = {"charts": [{"error_m": 1e-3}, {"error_m": 2e-3}], "triangles": 12, "refused": None}
        self.assertIn("12 triangles, 2 charts, off by 0.002 m at most", taken_in_words(mesh, FILE))
        self.assertIn("refused: it is too rough", taken_in_words(mesh | {"refused": "it is too rough", "charts": []}, FILE))

    def test_nothing_is_taken_for_the_expected_reason_alone(self) -> None:
        bull = next(file for file in FILES if file.name == "bull")
        for reason, right in (("85 of 157 parts are too small for it", True), ("the file is cut off", False), (None, False)):
            count = taken_count({"refused": reason, "charts": []}, [], bull)
            self.assertEqual(count == bull.taken, right, reason)
        self.assertEqual(taken_count({"faces": []}, [{}, {}], FILE), 2)

    def test_a_file_s_own_spacing_is_asked_for(self) -> None:
        self.program("shell", 'echo "{\\"told\\": \\"$*\\"}"\n')
        shell, path = mock.Mock(shell=self.top / "bin" / "shell"), self.top / "part.step"
        self.assertIn("--element 0.001", inspected(shell, path, replace(FILE, element=1e-3), self.top / "frame")["told"])
        self.assertNotIn("--element", inspected(shell, path, FILE, self.top / "frame")["told"])

    def test_needs_the_archive_and_says_so(self) -> None:
        self.program("apt-get", "echo 'E: Unable to locate package'; exit 100\n")
        with mock.patch.dict(os.environ, PATH=str(self.top / "bin")), self.assertRaises(CommandError) as told:
            fetched("tools-doc", self.top)
        for part in ("needs Debian's archive", "apt-get download tools-doc", "apt-get update", "Unable to locate"):
            self.assertIn(part, str(told.exception))
        with mock.patch.dict(os.environ, PATH=str(self.top / "none")), self.assertRaises(CommandError) as told:
            fetched("tools-doc", self.top)
        self.assertIn("needs Debian's package manager", str(told.exception))

    def test_unpacks_a_file_from_a_package_and_from_an_archive_in_it(self) -> None:
        (self.top / "usr").mkdir()
        (self.top / FILE.path).write_bytes(gzip.compress(b"solid"))
        self.assertEqual(copied(FILE, self.top, self.top).read_bytes(), b"solid")
        self.assertEqual(copied(FILE, self.top, self.top).name, "part.step")
        package, inner = next(iter(ARCHIVE.items()))
        (self.top / inner).parent.mkdir(parents=True)
        with tarfile.open(self.top / inner, "w:gz") as archive:
            archive.add(self.top / FILE.path, "data/a.off")
        file = PublicFile("a", package, "data/a.off", 1)
        self.assertEqual(gzip.decompress(copied(file, self.top, self.top).read_bytes()), b"solid")
        for missing in (PublicFile("a", package, "data/b.off", 1), PublicFile("a", "tools-doc", "usr/b.off", 1)):
            with self.assertRaisesRegex(CommandError, "has no .*b.off"):
                copied(missing, self.top, self.top)

    def test_is_skipped_without_the_package_manager_and_package_by_package_without_the_archive(self) -> None:
        def rows() -> list[dict[str, object]]:
            table = experiments.Table(headed=True)
            with contextlib.redirect_stdout(io.StringIO()), mock.patch.object(experiments, "ensure_built"), \
                    mock.patch.object(public_files, "ensure_built"):
                experiments.run_experiments(tuple(e for e in experiments.EXPERIMENTS["surfaces"] if e.name == "public"), table)
            self.assertTrue(all(holds(row) for row in table.rows))
            self.assertEqual(judge(table.rows, {}, every=False), (True, []))
            return table.rows

        with mock.patch.dict(os.environ, PATH=str(self.top / "none")):
            self.assertEqual([(row["name"], row["verdict"]) for row in rows()], [("public", "skipped")])
        self.program("apt-get", "echo 'E: no route'; exit 100\n")
        self.program("dpkg", "exit 0\n")
        with mock.patch.dict(os.environ, PATH=str(self.top / "bin")):
            found = rows()
        self.assertEqual([row["name"] for row in found], [f"public_{file.name}" for file in FILES])
        for row in found:
            self.assertIn("E: no route", str(row["note"]))
        self.program("apt-get", "exit 0\n")  # and leaves nothing
        with mock.patch.dict(os.environ, PATH=str(self.top / "bin")):
            self.assertIn("left no gmsh-doc_*.deb", str(rows()[0]["note"]))

    def test_what_is_refused_fails_and_a_build_without_cad_skips(self) -> None:
        for said, error, kind in ((NO_CAD, Missing, "public: "), ("has no faces", CommandError, "refused: ")):
            self.program("shell", f"echo 'bad_input: {said}' >&2; exit 2\n")
            shell = mock.Mock(shell=self.top / "bin" / "shell")
            with self.assertRaisesRegex(CommandError, kind + "bad_input: " + said) as told:
                inspected(shell, self.top / "part.step", FILE, self.top / "frame")
            self.assertIs(type(told.exception), error)


if __name__ == "__main__":
    unittest.main()
