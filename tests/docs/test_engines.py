"""The table of engines in rigid/README.md is what the engines declare."""
from __future__ import annotations

import unittest

from tests.docs.engines import BEGIN, END, FAILS, HAS, PAGE, columns_of, declared, known_failures, parts_of, table, words_of
from sunder_tools.launch.build import ensure_built
from sunder_tools.launch.engines import DART, NODE_PROGRAMS

WORDS = ["spheres", "contact"]


class Engines(unittest.TestCase):
    def test_the_page_has_what_each_engine_declares(self) -> None:
        text = PAGE.read_text(encoding="utf-8")
        found, written = declared(ensure_built()), parts_of(text)[1]
        self.assertEqual(written, table(words_of(text), found, written), "run /usr/bin/python3 -B -m tests.docs.engines")
        self.assertEqual(list(columns_of(written))[1:], ["bullet", "ode", "freeflight", *NODE_PROGRAMS, DART])
        for name in ("bullet", "ode", "freeflight"):
            self.assertIn("spheres", found[name] or [], name)

    def test_a_column_is_what_is_said_or_what_was_written(self) -> None:
        made = table(WORDS, {"one": ["spheres"], "two": ["contact", "spheres"]}, "")
        self.assertEqual(columns_of(made), {"capability": ["`spheres`", "`contact`", FAILS], "one": [HAS, "", ""], "two": [HAS, HAS, ""]})
        self.assertEqual(table(WORDS, {"one": None, "two": None}, made), made)
        self.assertEqual(columns_of(table(WORDS, {"one": [], "new": None}, made)), {
            "capability": ["`spheres`", "`contact`", FAILS], "one": ["", "", ""], "new": ["", "", ""]})
        self.assertIn("collision_compounds.gain", known_failures("bullet"))
        self.assertEqual(known_failures("none"), [])

    def test_what_is_refused(self) -> None:
        with self.assertRaisesRegex(ValueError, "one declares flight, which README.md does not explain"):
            table(WORDS, {"one": ["flight"]}, "")
        self.assertEqual(parts_of(f"a\n{BEGIN}\nb\n{END}\nc"), (f"a\n{BEGIN}\n", "b", f"{END}\nc"))
        with self.assertRaisesRegex(ValueError, "needs the lines"):
            parts_of(f"a\n{BEGIN}\nb")


if __name__ == "__main__":
    unittest.main()
