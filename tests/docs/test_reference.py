"""proto/README.md is what the comments of the .proto files say, and every field has one."""
from __future__ import annotations

import importlib.util
import re
import sys
import tempfile
import unittest
from pathlib import Path
from types import ModuleType
from typing import Any

TOP = Path(__file__).resolve().parents[2]


def load_reference() -> ModuleType:
    """proto/reference.py as a module."""
    spec = importlib.util.spec_from_file_location("reference", TOP / "proto" / "reference.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["reference"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


REFERENCE: Any = load_reference()


class Reference(unittest.TestCase):
    def test_the_page_is_that_of_the_schemas(self) -> None:
        self.assertEqual((TOP / "proto" / "README.md").read_text(), REFERENCE.page(),
                         "run /usr/bin/python3 -B proto/reference.py")

    def test_every_field_is_read(self) -> None:
        """By its name, so that a field passes where something else of that name is read. Checks of a scene do not count."""
        text = "\n".join(path.read_text() for room in ("coupler", "shell", "rigid") for path in sorted((TOP / room).rglob("*"))
                         if path.suffix in (".cpp", ".h", ".py", ".mjs")
                         and not path.name.startswith(("validate", "unit_warnings")))
        # calls NAME(), has_NAME(), NAME_size(); members of Python's and JavaScript's messages; names in quotes; an extension
        read = set(re.findall(r"\b(?:has_|mutable_)?(\w+?)(?:_size)?\(|\.(\w+)|\"(\w+)\"|proto::(\w+)", text))
        names = {name for found in read for name in found}
        fields = {match[1] for path in (TOP / "proto").glob("*.proto")
                  for match in re.finditer(r"^\s+(?:optional |repeated )?(?:map<[^>]*>|[\w.]+) (\w+) = \d+", path.read_text(), re.MULTILINE)}
        self.assertGreater(len(fields), 250)
        self.assertEqual(fields - names, {"slit"}, "fields that nothing reads but checks")  # `slit`: is_closed is among them

    def test_every_schema_is_in_it(self) -> None:
        self.assertEqual(sorted(p.stem for p in (TOP / "proto").glob("*.proto")),
                         sorted(REFERENCE.SCENE + REFERENCE.SESSION))

    def test_every_link_leads_to_a_message(self) -> None:
        page = REFERENCE.page()
        headings = {h.replace(".", "").lower() for h in re.findall(r"^### (\S+)$", page, re.MULTILINE)}
        links = set(re.findall(r"\]\(#([^)]+)\)", page))
        self.assertGreater(len(links), 30)
        self.assertEqual(links - headings, set())

    def test_the_page_of_engines_says_which_number_a_reply_has(self) -> None:
        # rules_turn.sequence of the conformance suite holds engines to it
        page = (TOP / "rigid" / "README.md").read_text()
        self.assertIn("A reply has the number that was due. A request with another number is refused, and the refusal still has the "
                      "number that was due.", page)

    def test_parts_of_a_comment(self) -> None:
        said = REFERENCE.parse(" [m/s] Of the ball.\n Default: 0\n Excludes: launch, is_static\n Needs: a name\n")
        self.assertEqual((said.unit, said.meaning), ("m/s", "Of the ball."))
        self.assertEqual(said.parts, {"Default": "0", "Excludes": "launch, is_static", "Needs": "a name"})

    def _refused(self, text: str) -> str:
        """What a schema with this body of a message is refused with."""
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "scene.proto").write_text(f'syntax = "proto3";\npackage sunder.proto;\n{text}\n')
            here, REFERENCE.HERE = REFERENCE.HERE, Path(folder)
            try:
                REFERENCE.Page(REFERENCE.descriptors(("scene",)), session=False)
            except REFERENCE.NoComment as error:
                return str(error)
            finally:
                REFERENCE.HERE = here
        return ""

    def test_what_has_no_comment_is_refused(self) -> None:
        good = "// A ball.\nmessage Ball {\n  // [m] Its radius.\n  // Default: required\n  optional double radius_m = 1;\n}"
        self.assertEqual(self._refused(good), "")
        self.assertEqual(self._refused(good.replace("// A ball.\n", "")), "message Ball has no comment")
        self.assertEqual(self._refused(re.sub(r"  //.*\n", "", good)), "field Ball.radius_m has no comment")
        self.assertEqual(self._refused(good.replace("  // Default: required\n", "")),
                         "field Ball.radius_m does not say its Default:")
        kind = "// A ball.\nmessage Ball {\n  enum Kind {\n    HARD = 0;\n  }\n}"
        self.assertEqual(self._refused(kind), "value Ball.Kind.HARD has no comment")

    def test_lengths_times_and_angles_have_their_unit(self) -> None:
        """A name that ends in a unit has the same unit in its comment."""
        units = {"_m": "m", "_s": "s", "_deg": "deg", "_per_s": "1/s"}
        for line in REFERENCE.page().splitlines():
            cells = [cell.strip() for cell in line.split("|")]
            ending = re.search(r"(_per_s|_m|_s|_deg)`$", cells[1]) if len(cells) > 4 else None
            if ending:
                self.assertEqual(cells[3], units[ending[1]], line)


KIND = re.compile(r"(?:Error|Failure)(?:\s+\w+)?\s*[({]\s*Exit(?:::k|\.)(\w+),\s*[\"'](\w+)[\"']")
STATUS = re.compile(r"\bk(\w+) = (\d+)")


def kinds(text: str) -> set[tuple[str, str]]:
    """Kinds of Error in a source, with the name of their status in small letters."""
    return {(kind, status.lower()) for status, kind in KIND.findall(text)}


class Kinds(unittest.TestCase):
    """The table of kinds in rigid/README.md has every Error of the sources, with its status and whose it is."""

    def test_the_table_is_that_of_the_sources(self) -> None:
        status = {name.lower(): number for name, number in STATUS.findall((TOP / "coupler" / "core" / "error.h").read_text())}
        found: dict[tuple[str, str], set[str]] = {}
        for room in ("coupler", "rigid", "shell"):
            for path in (TOP / room).rglob("*"):
                if path.suffix in (".cpp", ".h", ".mjs"):
                    for kind, name in kinds(path.read_text()):
                        found.setdefault((kind, status[name]), set()).add(room)
        rows = re.findall(r"^\| `(\w+)` \| (\d+) \| (both|engine|shell) \|", (TOP / "rigid" / "README.md").read_text(), re.MULTILINE)
        self.assertEqual(sorted((kind, number) for kind, number, _ in rows), sorted(found))
        for kind, number, by in rows:
            rooms = found[kind, number]
            self.assertTrue({"engine": "shell" not in rooms, "shell": "rigid" not in rooms, "both": bool(rooms)}[by], (kind, by, rooms))

    def test_kinds_are_found(self) -> None:
        self.assertEqual(kinds('throw Error(\n Exit::kPhysics, "one", x); Error e{Exit::kBadInput, "two"}; '
                               "new Failure(Exit.peerLost, 'three', `x`)"),
                         {("one", "physics"), ("two", "badinput"), ("three", "peerlost")})


if __name__ == "__main__":
    unittest.main()
