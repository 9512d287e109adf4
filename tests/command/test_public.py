"""Public files of `validate surfaces`: what is said of them, and of a machine without their packages."""
from __future__ import annotations

import gzip
import os
import tarfile
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from sunder_tools.errors import CommandError
from tests.validation.public_files import ARCHIVE, FILES, PublicFile, copied, fetched, taken_in_words

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

    def test_names_are_told_apart(self) -> None:
        self.assertEqual(len({file.name for file in FILES}), len(FILES))
        self.assertGreaterEqual(sum(file.taken > 0 for file in FILES), 10)


if __name__ == "__main__":
    unittest.main()
