"""What the pages of shell/ name is there: identifiers of NOTATION.md and of the tables of stages, and files of the tables
of files, which leave no source out. Sources and pages use terms of the field: none of the words in PRIVATE.
"""
from __future__ import annotations

import re
import unittest
from functools import cache
from pathlib import Path

from tests.docs.snippets import TOP

SHELL = TOP / "shell"
ROOMS = ("proto", "coupler", "shell", "rigid")
SOURCE = (".h", ".cpp", ".proto", ".py")
STAGES = "One substep"

# Private words, the field's term for each, and the folders ("": all) in which the word has no other meaning. "Tie" is no
# private word: a tie constraint joins meshes that do not match. Control points of shared knots are "dependent".
PRIVATE = (
    (r"hand_?back", "predicted state", ""),
    (r"\blet(s|ting)?[ _]go\b|Let(s|ting)?Go", "released", ""),
    (r"\bcrumbs?\b", "sliver", ""),
    (r"weakens for good", "irreversible damage", ""),
    (r"own ground|\bground\b", "energy-release zone", "shell/solver shell/fracture"),
    (r"line of sight|_sight\b|\bsight(_|\b)", "visibility", "shell tests"),
    (r"\bcarr(y|ies|ied) on\b", "propagate over seams", ""),
    (r"hardness", "stiffness ratio", "proto coupler shell rigid scenes"),
    (r"\bmasters?\b|\bleader\b|\bfollowers?\b", "dependent and independent", "shell coupler rigid scenes tests/shell tests/validation"),
    (r"\bcontrol points follow\b", "dependent", "shell"),
    (r"\bbrace[sd]?\b", "crease constraint", "shell coupler scenes tests/shell/solver"),
    (r"\bjump", "discontinuity", "shell/solver tests/shell/solver"),
    (r"\bsix\b(?=\s*[\[(.;,=)])", "face stresses", "shell/solver"),
    (r"\btables\.plane\b", "component stride", "shell tests"),
    (r"\bdoubt(s|ed|ful)?\b", "warning", "shell rigid coupler tests/shell tests/command"),
    (r"\bgone\b|(\.|->)left;|\bbool left\b", "detached, handed off", "shell/solver shell/mechanics shell/run"),
    (r"\bspared\b", "retained", ""),
)


@cache
def sources() -> dict[Path, str]:
    """Texts of all sources."""
    return {p: p.read_text() for room in ROOMS for p in sorted((TOP / room).rglob("*")) if p.suffix in SOURCE}


@cache
def words() -> frozenset[str]:
    """All words of the sources."""
    return frozenset(word for text in sources().values() for word in re.findall(r"\w+", text))


def inside(text: str, start: int) -> str:
    """What stands at the top level between the brace before `start` and its partner: without functions and inner types."""
    out, depth, at = [], 1, start
    for brace in re.finditer(r"[{}]", text[start:]):
        here = start + brace.start()
        if depth == 1:
            out.append(text[at:here])
        depth += 1 if brace[0] == "{" else -1
        at = here + 1
        if depth == 0:
            break
    return ";".join(out)


@cache
def members() -> dict[str, list[str]]:
    """Of each type of the C++ sources: what its definitions declare, its bases first."""
    found: dict[str, list[str]] = {}
    for path, text in sources().items():
        if path.suffix in (".h", ".cpp"):
            code = re.sub(r"//.*", "", text)
            for match in re.finditer(r"\b(?:struct|class) (\w+)\s*(?:final\s*)?(:[^:;{][^;{]*)?{", code):
                found.setdefault(match[1], []).append(f"{match[2] or ''};{inside(code, match.end())}")
            for match in re.finditer(r"\benum class (\w+)[^;{]*{([^}]*)}", code):
                found.setdefault(match[1], []).append(f";{match[2]}")
    return found


def has(kind: str, member: str) -> bool:
    """Whether a type, or one that it is derived from, declares a member."""
    for body in members().get(kind, []):
        bases, _, declared = body.partition(";")
        if re.search(rf"\b{member}\b", declared) or any(has(base, member) for base in re.findall(r"\b[A-Z]\w*", bases)):
            return True
    return False


def missing(code: str) -> list[str]:
    """Names in a piece of code that are not in the sources: words, and members that their type does not have."""
    out = [word for word in re.findall(r"(?<![\w.])[A-Za-z_]\w*", re.sub(r"\S*/\S*|\w+\.(?:h|cpp)\b", "", code))
           if word not in words()]
    for kind, member in re.findall(r"\b([A-Z]\w*)::(\w+)", code):
        if not has(kind, member):
            out.append(f"{kind}::{member}")
    return out


def private_words(path: str, text: str) -> list[str]:
    """Private words in a text of the file at this path: line, word and the term to take."""
    return [f"{path}:{text.count(chr(10), 0, match.start()) + 1}: '{match[0]}': say {term}"
            for word, term, folders in PRIVATE
            if any(path.startswith(f"{folder}/") for folder in folders.split()) or not folders
            for match in re.finditer(word, text, re.IGNORECASE)]


def codes(text: str) -> list[str]:
    """What stands in backticks."""
    return re.findall(r"`([^`]+)`", text)


def section(text: str, title: str) -> str:
    """The part of a page below a heading of the second level; '' where there is none."""
    found = re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    return found[1] if found else ""


def rows(text: str) -> list[list[str]]:
    """Cells of the tables of a text, without their rules."""
    return [[cell.strip() for cell in line.strip("|\n").split("|")] for line in text.splitlines()
            if line.startswith("|") and not set(line) <= set("|- ")]


def named_files(text: str) -> list[tuple[str, str]]:
    """Folder below the page and name of each file in its tables of files; a table whose head is 'folder' has files in
    its second column, others in the first."""
    out, by_folder = [], False
    for cells in rows(section(text, "Files")):
        if cells[0] in ("folder", "file"):
            by_folder = cells[0] == "folder"
        elif by_folder:
            folder = "".join(codes(cells[0])).strip("/")
            out += [(folder, name) for name in codes(cells[1])]
        else:
            out += [("", name) for name in codes(cells[0])]
    return out


def stems(folder: Path) -> set[str]:
    """Sources of a folder without their endings."""
    return {p.stem for p in folder.iterdir() if p.suffix in (".h", ".cpp")}


class Names(unittest.TestCase):
    def test_notation_names_what_there_is(self) -> None:
        lines = (SHELL / "NOTATION.md").read_text().splitlines()
        self.assertGreater(sum(len(codes(line)) for line in lines), 200)
        lost = [f"NOTATION.md:{n}: {name}" for n, line in enumerate(lines, 1)
                for code in codes(line) for name in missing(code)]
        self.assertEqual(lost, [])

    def test_tables_of_stages_name_what_there_is(self) -> None:
        table = rows(section((SHELL / "README.md").read_text(), STAGES))
        self.assertGreater(len(table), 20)
        for stage, calls, file, *_ in table:
            for code in codes(stage + calls):
                self.assertEqual(missing(code), [], f"README.md, {stage}")
            for path in codes(file):
                found = [top / path for top in (SHELL, TOP) if (top / path).exists()]
                self.assertTrue(found, f"README.md: no file {path}")
                if found[0].is_file():  # which holds what is called
                    for name in codes(calls)[:1]:
                        self.assertRegex(found[0].read_text(), rf"\b{name}\b", path)

    def test_tables_of_files_are_whole(self) -> None:
        pages = [p for p in sorted(SHELL.rglob("README.md")) if section(p.read_text(), "Files")]
        self.assertGreater(len(pages), 7)
        for page in pages:
            named = named_files(page.read_text())
            for folder in {folder for folder, _ in named}:
                there = stems(page.parent / folder)
                told = {name.removesuffix(".h").removesuffix(".cpp") for where, name in named if where == folder}
                self.assertEqual(told - there, set(), f"{page.relative_to(TOP)}: no such files in '{folder}'")
                self.assertEqual(there - told, set(), f"{page.relative_to(TOP)}: does not name files of '{folder}'")

    def test_every_folder_of_shell_has_its_files_told(self) -> None:
        told = {page.parent / folder for page in SHELL.rglob("README.md") for folder, _ in named_files(page.read_text())}
        there = {p.parent for p in SHELL.rglob("*.cpp")} - {SHELL}
        self.assertEqual({str(p.relative_to(TOP)) for p in there - told}, set())

    def test_no_private_word_comes_back(self) -> None:
        files = [p for room in (*ROOMS, "scenes", "tests") for p in sorted((TOP / room).rglob("*"))
                 if p.suffix in (*SOURCE, ".mjs", ".md", ".txt") and p != Path(__file__).resolve()]
        self.assertGreater(len(files), 500)
        found = [word for p in (TOP / "README.md", *files)
                 for word in private_words(str(p.relative_to(TOP)), p.read_text(encoding="utf-8"))]
        self.assertEqual(found, [])

    def test_private_words_are_found_where_they_have_no_other_meaning(self) -> None:
        self.assertEqual(private_words("shell/a.h", "a\n// it lets go"), ["shell/a.h:2: 'lets go': say released"])
        self.assertEqual(private_words("tests/a_test.cpp", "TEST(A, LetsGo)"), ["tests/a_test.cpp:1: 'LetsGo': say released"])
        self.assertEqual(private_words("shell/solver/a.h", "double six[6];"), ["shell/solver/a.h:1: 'six': say face stresses"])
        self.assertEqual(private_words("shell/solver/a.h", "// all six of them"), [])
        self.assertEqual(private_words("shell/solver/a.h", "g.left; // left"),
                         ["shell/solver/a.h:1: '.left;': say detached, handed off"])
        self.assertEqual(private_words("coupler/sunder_tools/a.py", "ground, crumble, jump, gone"), [])

    def test_what_is_not_there_is_found(self) -> None:
        self.assertEqual(missing("Motion::x"), [])
        self.assertEqual(missing("ShellState::x"), ["ShellState::x"])
        self.assertEqual(missing("no_such_function(dt)"), ["no_such_function"])
        self.assertEqual(missing("IndependentPoint::weight"), [])  # of its base
        table = "## Files\n\n| {} |\n| --- | --- |\n{}\n## Next\n| `x` | `y` |\n"
        self.assertEqual(named_files(table.format("folder | files", "| here | `a`, `b.h`: c |\n| `in/` | `d` |")),
                         [("", "a"), ("", "b.h"), ("in", "d")])
        self.assertEqual(named_files(table.format("file | holds", "| `a`, `b` | `c` |")), [("", "a"), ("", "b")])

    def test_places_that_decide_by_mode_are_listed(self) -> None:
        line = next(line for line in (SHELL / "README.md").read_text().splitlines() if "each place that decides by mode" in line)
        told = {(folder if folder.startswith("coupler/") else f"shell/{folder}") + stem
                for folder, stems in re.findall(r"`([a-z_/]+/){([a-z_,]+)}`", line) for stem in stems.split(",")}
        there = {str(path.relative_to(TOP).with_suffix("")) for path, text in sources().items()
                 if path.suffix in (".h", ".cpp") and re.search(r"\b(tips_run|damages|weakens)\(\)|\bFracture::[A-Z]+\b|\bFractureMode::k", text)}
        self.assertEqual(told, there)


if __name__ == "__main__":
    unittest.main()
