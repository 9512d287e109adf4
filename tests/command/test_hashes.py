"""The table of state hashes."""
from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path

from sunder_tools.errors import CommandError

from tests.validation import hashes
from tests.validation.hashes import Hashed


class Hashes(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = Path(folder.name) / "hashes.json"
        self.rows = [Hashed("glass", 1, "ab" * 32, 3, 0.5, 1.0), Hashed("glass", 2, "ab" * 32, 3, 0.5, 1.0)]

    def test_what_was_written_is_the_same(self) -> None:
        hashes.write(self.file, self.rows)
        self.assertEqual(hashes.unequal(self.rows, hashes.read(self.file)), [])
        self.assertTrue(hashes.line(self.rows[0], hashes.read(self.file)).endswith("same"))

    def test_a_change_and_a_number_of_threads_are_found(self) -> None:
        hashes.write(self.file, self.rows)
        other = [Hashed("glass", 1, "cd" * 32, 3, 0.5, 1.0)]
        self.assertEqual(hashes.unequal(other, hashes.read(self.file)), ["glass"])
        self.assertTrue(hashes.line(other[0], hashes.read(self.file)).endswith("DIFFERS"))
        self.assertEqual(hashes.unequal([self.rows[0], Hashed("glass", 2, "cd" * 32, 3, 0.5, 1.0)], {}), ["glass"])

    def test_a_file_of_something_else_is_refused_with_the_remedy(self) -> None:
        for text in ("[]", "{}", json.dumps({"hashes": [{"scene": "glass"}]}), "no json"):
            self.file.write_text(text)
            with self.assertRaisesRegex(CommandError, "has no hashes .* sunder hashes --json"):
                hashes.read(self.file)

    def test_every_scene_that_is_shortened_ships(self) -> None:
        self.assertLessEqual(set(hashes.UNTIL), set(hashes.names()))
        self.assertIn("paper/fig13", hashes.names())


if __name__ == "__main__":
    unittest.main()
