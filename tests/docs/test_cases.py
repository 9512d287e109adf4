"""tests/validation/README.md names every case of every suite, and no case that is not there."""
from __future__ import annotations

import re
import sys
import unittest

from tests.docs.snippets import TOP

sys.path.insert(0, str(TOP / "coupler"))
from tests.validation.measure import VALIDATIONS, case_names, cases_by_name  # noqa: E402

PAGE = TOP / "tests" / "validation" / "README.md"
ROWS = ("engines", "extremes")  # whose rows are their cases


def named(text: str, suite: str) -> set[str]:
    """The names in the first column of the tables below the heading of a suite."""
    part = text.partition(f"\n## {suite}\n")[2].partition("\n## ")[0]
    cells = [line.split("|")[1] for line in part.splitlines() if line.startswith("| ")]
    return {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}


def pattern(name: str) -> str:
    """What a name on the page stands for: capitals are any word, as in map_HOLD."""
    return re.sub(r"[A-Z]+", lambda _: r"\w+", name)


class Cases(unittest.TestCase):
    def test_every_case_is_on_the_page_and_no_other(self) -> None:
        text = PAGE.read_text()
        for suite in VALIDATIONS:
            if suite in ROWS:
                continue
            with self.subTest(suite=suite):
                cases, told = {*case_names(suite), *cases_by_name(suite)}, named(text, suite)
                self.assertGreater(len(cases), 3)
                missing = [case for case in sorted(cases) if not any(re.fullmatch(pattern(name), case) for name in told)]
                self.assertEqual(missing, [], f"{PAGE.relative_to(TOP)} has no row of these cases of {suite}")
                unknown = [name for name in sorted(told) if not any(re.fullmatch(pattern(name), case) for case in cases)]
                self.assertEqual(unknown, [], f"{suite} has no such cases")

    def test_names_are_read_from_the_first_column(self) -> None:
        text = "a\n\n## soft\n\n| case | rows |\n| --- | --- |\n| `sag`; `map_HOLD` (by name) | `sag_*` |\n\n## other\n\n| `no` | |\n"
        self.assertEqual(named(text, "soft"), {"sag", "map_HOLD"})
        self.assertEqual(named(text, "shells"), set())
        self.assertTrue(re.fullmatch(pattern("map_HOLD"), "map_clamped"))


if __name__ == "__main__":
    unittest.main()
