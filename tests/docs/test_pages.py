"""Pages keep to their size, their links lead somewhere, and no measured figure is typed in one.

A measured figure is what a run gave: seconds that it took, an error, a share, a number of pieces. It is true of one machine
and one commit, so it belongs in a RESULTS.md, which a command writes. A figure that is given stays: a default, a limit, a
tolerance, a size in a scene. Text alone cannot always tell the two apart. MEASURED lists the forms that figures of runs
take; GIVEN lists the words that mark a given one in the same sentence or cell. Code, comments and output are not looked at.
"""
from __future__ import annotations

import re
import unittest
from pathlib import Path

from tests.docs.pairs import BEGIN, END
from tests.docs.snippets import TOP, readmes

PAGES = [*readmes(), TOP / "shell" / "fracture" / "DECISIONS.md", TOP / "shell" / "NOTATION.md"]
# reasons why a goal is not reached: bounds stand in a column of their own
REASONS = sorted((TOP / "tests").glob("*/known/*.txt"))
IN_REASONS = r"\d\.\d|\d ?%|\de-\d|\d ?(?:us|ms|ns|s|degrees)\b"

MOST_BYTES, MOST_LINES, MOST_IN_A_LINE = 10240, 160, 1200
MOST_LINES_OF_SHELL = 120
MOST_WORDS = 25  # of a sentence
NUMBER = r"\d[\d.,]*(?:e[-+]?\d+)?"
MEASURED = (
    rf"{NUMBER} ± {NUMBER}",                                            # scatter of a series
    rf"{NUMBER} ?%",                                                    # errors and shares
    rf"{NUMBER} (?:to|–|-) {NUMBER} ?(?:s|ms|µs|ns|min|minutes|seconds|hours)\b",  # how long something took
    rf"\b(?:takes?|took|costs?|within|after|in) (?:some |about )?{NUMBER} (?:s|ms|µs|ns|min|minutes|seconds|hours)\b",
    rf"{NUMBER} (?:ns|GFLOP/s|GB/s|substeps/s)\b",                      # speed
    r"\b\d(?:\.\d+)?e-\d+\b",                                           # residuals and round-off
    r"\b(?:of|all) \d{2,} (?:cases|rows|tests|faults)\b",
)
GIVEN = (r"\b(?:defaults?|at most|at least|limits?|tolerances?|margins?|bounds?|goals?|below|above|less than|more than"
         r"|refused?|allowed|promise[sd]?|required|round-off|share of|timeouts?)\b")


def prose(text: str) -> list[tuple[int, str]]:
    """Lines with their numbers, without fenced blocks, code in backticks, comments and targets of links."""
    out, fenced = [], False
    for number, line in enumerate(text.splitlines(), 1):
        if re.match(r"\s*```", line):
            fenced = not fenced
        elif not fenced:
            out.append((number, re.sub(r"`[^`]*`|<!--.*?-->|\]\([^)]*\)", "", line)))
    return out


def figures(text: str) -> list[tuple[int, str]]:
    """Measured figures in the text of a page: line and what stands there."""
    found = []
    for number, line in prose(text):
        for part in re.split(r"\||(?<=[.;:]) ", line):
            if re.search(GIVEN, part, re.IGNORECASE):
                continue
            found += [(number, match[0]) for pattern in MEASURED for match in re.finditer(pattern, part)]
    return found


def sentences(text: str) -> list[tuple[int, str]]:
    """Sentences of a page, each with the first line of its paragraph. Tables, headings, code and formulas are left out, and
    the list of pairs, which quotes refusals of the program. A piece of code in a sentence counts as a word."""
    paragraphs: list[tuple[int, str]] = []
    open_, fenced, quoted = False, False, False
    for number, line in enumerate(text.splitlines(), 1):
        fence, stripped = line.lstrip().startswith("```"), line.strip()
        fenced ^= fence
        quoted = stripped == BEGIN or quoted and stripped != END
        if fence or fenced or quoted or not stripped or line.startswith("    ") or stripped.startswith(("|", "#", "<!--", "![")):
            open_ = False
            continue
        if open_ and not re.match(r"(?:[-*]|\d+\.) ", stripped):
            paragraphs[-1] = (paragraphs[-1][0], f"{paragraphs[-1][1]} {stripped}")
        else:
            paragraphs.append((number, stripped))
        open_ = True
    return [(number, one) for number, paragraph in paragraphs
            for one in re.split(r"(?<=[.?!])[*)\"]*\s+", re.sub(r"`[^`]*`", "code", re.sub(r"\]\([^)]*\)", "]", paragraph)))]


def words(sentence: str) -> int:
    """Number of words; a line of links to sections has none."""
    return 0 if " · " in sentence else sum(bool(re.search(r"\w", word)) for word in sentence.split())


def reason(line: str) -> str:
    """The reason in a line of a list of known failures: NAME LARGEST_ERROR WHY."""
    return "" if line.startswith("#") else "".join(line.split(maxsplit=2)[2:])


def anchors(text: str) -> set[str]:
    """The anchors of the headings of a page."""
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")
            for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE)}


def broken_links(page: Path, text: str) -> list[str]:
    """Links of a page with this text to files and headings that are not there."""
    broken, fenced = [], False
    for number, line in enumerate(text.splitlines(), 1):
        fenced ^= line.lstrip().startswith("```")
        for target, heading in re.findall(r"\]\(([^)#\s]*)#?([^)\s]*)\)", line) if not fenced else ():
            path = (page.parent / target).resolve() if target else page
            if "://" in target:
                continue
            if heading:
                good = path == page or path.is_file()
                good = good and heading in anchors(text if path == page else path.read_text())
            else:
                good = path.exists()
            if not good:
                broken.append(f"{page.relative_to(TOP)}:{number}: {target}{'#' if heading else ''}{heading}")
    return broken


class Pages(unittest.TestCase):
    def test_the_first_page_is_short(self) -> None:
        text = (TOP / "README.md").read_bytes()
        self.assertLessEqual(len(text), MOST_BYTES)
        self.assertLessEqual(text.count(b"\n"), MOST_LINES)

    def test_the_first_page_is_in_the_order_of_a_strangers_questions(self) -> None:
        text = (TOP / "README.md").read_text()
        self.assertEqual(re.findall(r"^## (.*)$", text, re.MULTILINE),
                         ["Two commands", "A complete scene", "Where to read on", "A coupling window", "Status", "Limits", "The tree",
                          "Developing", "Licence"])
        self.assertIn("![", text.split("## Two commands")[0], "a picture comes first")
        limits = text.split("## Limits")[1].split("## ")[0]
        self.assertEqual(len(re.findall(r"^\d+\. ", limits, re.MULTILINE)), 6)
        window = text.split("## A coupling window")[1].split("## ")[0]
        self.assertEqual(len(re.findall(r"^\d+\. ", window, re.MULTILINE)), 8)

    def test_the_page_of_the_solver_is_short(self) -> None:
        self.assertLessEqual((TOP / "shell" / "README.md").read_bytes().count(b"\n"), MOST_LINES_OF_SHELL)

    def test_no_line_is_long(self) -> None:
        long = [f"{p.relative_to(TOP)}:{n}: {len(line)}" for p in readmes()
                for n, line in enumerate(p.read_text().splitlines(), 1) if len(line) > MOST_IN_A_LINE]
        self.assertEqual(long, [])

    def test_no_sentence_is_long(self) -> None:
        long = [f"{page.relative_to(TOP)}:{number}: {words(sentence)} words: {sentence}" for page in PAGES
                if page.parent.name != "proto"  # made from schemas
                for number, sentence in sentences(page.read_text()) if words(sentence) > MOST_WORDS]
        self.assertEqual(long, [], "one idea a sentence")

    def test_words_of_sentences_are_counted(self) -> None:
        page = ("# A title\n\nOne **two.** Three `four five`\nsix [seven](eight nine)!\n- Ten.\n\n    a = b c\n| a. b | c |\n"
                "```\nx y\n```\n* End\n")
        self.assertEqual([(number, words(sentence)) for number, sentence in sentences(page)], [(3, 2), (3, 4), (5, 1), (12, 1)])
        self.assertEqual([words(s) for _, s in sentences("word " * (MOST_WORDS + 1))], [MOST_WORDS + 1])
        self.assertEqual([s for _, s in sentences(f"One.\n{BEGIN}\n1. field: quoted\n\nTwo.\n{END}\nThree.")], ["One.", "Three."])

    def test_no_measured_figure_is_typed(self) -> None:
        found = [f"{p.relative_to(TOP)}:{n}: {figure}" for p in PAGES if p.parent.name != "proto"  # made from schemas
                 for n, figure in figures(p.read_text())]
        self.assertEqual(found, [], "figures of runs are written by 'coupler/sunder report'")

    def test_reasons_tell_no_measured_figure(self) -> None:
        self.assertGreater(len(REASONS), 4)
        found = [f"{path.relative_to(TOP)}:{number}: {match[0]}" for path in REASONS
                 for number, line in enumerate(path.read_text().splitlines(), 1)
                 for match in re.finditer(IN_REASONS, reason(line))]
        self.assertEqual(found, [], "say what limits the row; what a run gave is in RESULTS.md")

    def test_figures_in_reasons_are_found(self) -> None:
        for line in ("a 0.2  1.84 and 1.92 of five", "a 0.2  within 15 %", "a 0.2  from 42 to 33 us", "a.b  1e-6  5e-7 of the energy"):
            self.assertRegex(reason(line), IN_REASONS)
        for line in ("# NAME 0.5 WHY", "a 0.25  16 seeds, 80 x 80 elements"):
            self.assertNotRegex(reason(line), IN_REASONS)

    def test_figures_are_found(self) -> None:
        for typed in ("glass has 25 ± 3 pieces", "energy closes to 3e-5", "it takes 40 s", "20 to 40 s", "an error of 0.5 %",
                      "5.3 ns a layer point", "all 107 rows pass"):
            self.assertTrue(figures(typed), typed)
        for given in ("thickness of 4 mm", "at most 0.5 %", "`takes 40 s`", "the default is 1e-6", "windows of 0.5 ms",
                      "```text\nit took 40 s\n```", "Debian 12", "degree 2 or 3"):
            self.assertEqual(figures(given), [], given)

    def test_links_lead_somewhere(self) -> None:
        pages = [page for page in sorted(TOP.rglob("*.md"))
                 if not {"build", "node_modules", "runs"} & set(page.relative_to(TOP).parts)]
        self.assertGreater(len(pages), len(readmes()))
        self.assertEqual([found for page in pages for found in broken_links(page, page.read_text())], [])

    def test_broken_links_are_found(self) -> None:
        page = TOP / "tests" / "README.md"
        for good in ("[a](../README.md)", "[a](validation/README.md#cracks)", "[a](https://x.org/y)", "[a](#kinds)",
                     "[a](validation/RESULTS.md)", "```text\n[a](none.md)\n```"):
            self.assertEqual(broken_links(page, "## Kinds\n" + good), [], good)
        for bad in ("[a](none.md)", "[a](RESULTS.md)",
                    "[a](validation/README.md#none)", "[a](#none)"):
            self.assertEqual(len(broken_links(page, "## Kinds\n" + bad)), 1, bad)

    def test_every_picture_is_shown(self) -> None:
        text = "\n".join(p.read_text() for p in readmes())
        pictures = [p for room in ("scenes", "rigid", "coupler") for p in (TOP / room).rglob("*.png")]
        self.assertGreater(len(pictures), 3)
        self.assertEqual([p.name for p in pictures if f"{p.name})" not in text], [])


if __name__ == "__main__":
    unittest.main()
