"""The constants of fracture: in one file, each with unit, class and source; and one door for new edges."""
from __future__ import annotations

import re
import unittest

from . import REPOSITORY as TOP

FILE = TOP / "shell" / "fracture" / "constants.h"
CALIBRATED = TOP / "shell" / "fracture" / "calibrated_constants.h"
CLASSES = ("derived", "published", "numerical")
# where every constant is of that file, but for these: those of round-off, of cost and of memory, which decide nothing, and
# those of mechanics, which have unit, class and source where they stand
FOLDERS = ("shell/fracture", "shell/solver/cracking", "shell/solver/joining", "shell/solver/parting")
FILES = ("shell/solver/interlock.cpp", "shell/solver/interlock.h", "shell/solver/state.cpp", "shell/solver/surroundings.cpp",
         "shell/solver/surroundings.h", "shell/solver/trimming.cpp", "shell/mechanics/section.h")
ROUND_OFF, COST, LAYOUT = "round-off of comparisons", "time or memory, no result", "size of an array, a number of a bit or of infinity"
DRAWING = "what is drawn, no result"
HERE = "of joints, trims or stress of a shell without cracks: unit, class and source stand beside it"
ELSEWHERE = {
    "shell/fracture/conditioning.cpp": {"kMargin": ROUND_OFF, "kProduct": LAYOUT},
    "shell/fracture/conditioning.h": {"kChoices": LAYOUT},
    "shell/fracture/crack_graph.h": {"kTiedTrim": LAYOUT, "kTrim": LAYOUT},
    "shell/fracture/crack_loops.cpp": {"kBorder": LAYOUT},
    "shell/fracture/mls.cpp": {"kLanes": LAYOUT, "kMostSeen": LAYOUT, "kMostPacks": LAYOUT, "kSmallSteps": LAYOUT,
                               "kTried": LAYOUT, "kLinearTried": LAYOUT},
    "shell/fracture/visibility.cpp": {"kFew": COST, "kRemembered": COST, "kBeyond": ROUND_OFF, "kRoundOff": ROUND_OFF,
                                 "kLargestUncertainty": ROUND_OFF, "kPacks": LAYOUT, "kNone": LAYOUT, "kFar": LAYOUT},
    "shell/fracture/visibility.h": {"kMost": LAYOUT, "kReach": LAYOUT, "kAcross": LAYOUT},
    "shell/solver/cracking/crack_sides.cpp": {"kNear": DRAWING, "kInwards": DRAWING},
    "shell/solver/cracking/damage_cracks.cpp": {"kRoundOff": ROUND_OFF},
    "shell/solver/cracking/energy_release.cpp": {"kTaperStep": ROUND_OFF},
    "shell/solver/cracking/insertion.cpp": {"kTrials": COST, "kForget": COST},
    "shell/solver/cracking/nucleation.cpp": {"kRoundOff": ROUND_OFF},
    "shell/solver/cracking/tips.cpp": {"kFewTips": COST},
    "shell/solver/joining/seam_cracks.cpp": {"kAtEnds": ROUND_OFF},
    "shell/solver/joining/seam_ties.cpp": {"kTieSpacing": HERE, "kMostChange": HERE,
                                           "kNoWeight": ROUND_OFF, "kFlat": ROUND_OFF, "kRidge": ROUND_OFF,
                                           "kPasses": COST, "kAligned": ROUND_OFF, "kBendSteps": COST,
                                           "kBent": ROUND_OFF},
    "shell/solver/joining/tie_places.cpp": {"kSameWeight": ROUND_OFF, "kFewestClosed": HERE, "kReach": COST},
    "shell/solver/joining/stitching.cpp": {"kOnALine": ROUND_OFF, "kOnePlace": ROUND_OFF, "kSweeps": COST,
                                           "kSameLength": ROUND_OFF},
    "shell/solver/joining/seam_strength.cpp": {"kSameShare": ROUND_OFF},
    "shell/solver/joining/stitching.h": {"kLooseWeight": ROUND_OFF},
    "shell/solver/parting/bent_piece.h": {"kDrawnFlat": DRAWING, "kMostFlatParts": COST, "kDoublings": COST},
    "shell/solver/parting/bent_piece.cpp": {"kSections": COST, "kMore": ROUND_OFF},
    "shell/solver/parting/handoff.cpp": {"kAll": LAYOUT, "kRoundOff": ROUND_OFF, "kSameVelocity": ROUND_OFF},
    "shell/solver/surroundings.cpp": {"kFar": LAYOUT, "kSpare": COST, "kWhole": ROUND_OFF},
    "shell/solver/surroundings.h": {"kWays": LAYOUT, "kMost": COST, "kBytesOfCracks": COST},
    "shell/solver/trimming.cpp": {"kLeastContinuation": HERE, "kMostContinuation": HERE, "kContinuationStep": HERE,
                                  "kMostShares": HERE, "kMostMassShares": HERE, "kLeastMass": HERE,
                                  "kSingularShares": ROUND_OFF, "kOnPatchEdge": ROUND_OFF, "kTerms": LAYOUT},
    "shell/mechanics/section.h": {"kCrushed": HERE},
}
DEFINED = re.compile(r"^\s*(?:static |inline )*constexpr (?:double|float|int|std::size_t|std::int64_t) (k[A-Z].*)$", re.MULTILINE)


def names(text: str) -> list[str]:
    """Constants that are numbers and are defined in a source, also several in one line."""
    return [name for line in DEFINED.findall(text) for name in re.findall(r"\b(k[A-Z]\w*)(?:\[\w*\])* ?[={]", line)]


def with_comments(text: str) -> dict[str, list[str]]:
    """Each constant with the lines of the comment before it."""
    found: dict[str, list[str]] = {}
    comment: list[str] = []
    for line in text.splitlines():
        if line.startswith("/// "):
            comment.append(line[4:])
            continue
        for name in names(line):
            found[name] = comment
        comment = []
    return found


def complaints(comment: list[str]) -> list[str]:
    """What a constant's comment lacks of unit, class and source."""
    out: list[str] = []
    if not comment or not re.match(r"[^\[]*\[[^\]]+\]: \S", comment[0]):
        out.append("no unit in the first line: 'SYMBOL [UNIT]: MEANING'")
    starts = [k for k, line in enumerate(comment) if re.match(rf"({'|'.join(CLASSES)}|calibrated on \w+): \S", line)]
    if len(starts) != 1 or starts[0] == 0:
        out.append(f"no class and source: one of {', '.join(CLASSES)} or 'calibrated on CASE', after the meaning")
    return out


def calibrated(text: str) -> dict[str, str]:
    """Each calibrated constant and the case that changes it."""
    return {name: case.group(1) for name, comment in with_comments(text).items() for line in comment
            if (case := re.match(r"calibrated on (\w+):", line))}


class Constants(unittest.TestCase):
    def test_each_has_unit_class_and_source(self) -> None:
        found = with_comments(FILE.read_text())
        self.assertGreater(len(found), 100)
        for name, comment in found.items():
            self.assertEqual(complaints(comment), [], name)

    def test_a_comment_without_one_of_them_is_found(self) -> None:
        good = ["R [h]: a radius.", "numerical: chosen"]
        self.assertEqual(complaints(good), [])
        self.assertEqual(complaints(["[rad]: an angle.", "more of it.", "calibrated on bar: fitted"]), [])
        wrong: tuple[list[str], ...] = ([], good[:1], good[1:], ["R: a radius.", good[1]], [good[0], "numerical:"],
                                        [good[0], "guessed: so"], [good[0], "calibrated: fitted"])
        for bad in wrong:
            self.assertNotEqual(complaints(bad), [], str(bad))
        self.assertEqual(names("constexpr double kA = 1.0, kB = 2.0;\nconstexpr double kC[] = {1.0};\n  static constexpr int kD = 3;\n"),
                         ["kA", "kB", "kC", "kD"])

    def test_none_is_defined_elsewhere(self) -> None:
        sources = [p for folder in FOLDERS for p in sorted((TOP / folder).glob("*")) if p.suffix in (".h", ".cpp")]
        there: dict[str, set[str]] = {}
        for path in [*sources, *(TOP / f for f in FILES)]:
            if path != FILE and (found := set(names(path.read_text()))):
                there[str(path.relative_to(TOP))] = found
        self.assertEqual(there, {path: set(reasons) for path, reasons in ELSEWHERE.items()})

    def test_what_stays_where_it_is_has_unit_class_and_source_too(self) -> None:
        stay = [(path, name) for path, reasons in ELSEWHERE.items() for name, why in reasons.items() if why == HERE]
        self.assertGreater(len(stay), 5)
        for path, name in stay:
            self.assertEqual(complaints(with_comments((TOP / path).read_text())[name]), [], f"{path}: {name}")

    def test_each_name_is_defined_once(self) -> None:
        here = names(FILE.read_text())
        self.assertEqual(len(here), len(set(here)))
        for path in (TOP / "shell").rglob("*"):
            if path.suffix in (".h", ".cpp") and path != FILE:
                self.assertEqual(set(names(path.read_text())) & set(here), set(), path)

    def test_each_is_used(self) -> None:
        words = {word for p in (TOP / "shell").rglob("*") if p.suffix in (".h", ".cpp") and p != FILE
                 for word in re.findall(r"\bk[A-Z]\w*", p.read_text())}
        self.assertEqual(set(names(FILE.read_text())) - words, set())

    def test_sensitivity_changes_each_that_is_calibrated_on_its_case(self) -> None:
        text = FILE.read_text()
        members = re.findall(r"^  double (\w+) = (k\w+);", CALIBRATED.read_text(), re.MULTILINE)
        self.assertEqual({constant for _, constant in members}, set(calibrated(text)))
        case = (TOP / "tests" / "validation" / "sensitivity.cpp").read_text()
        for member, constant in members:
            self.assertEqual("k" + "".join(part.capitalize() for part in member.split("_")), constant)
            self.assertRegex(case, rf"&CalibratedConstants::{member}, \"{member}\", \w*{calibrated(text)[constant]}\b")

    def test_insertion_is_the_only_door(self) -> None:
        doors = {str(p.relative_to(TOP)) for p in (TOP / "shell").rglob("*.cpp") if re.search(r"\badd_edge\(", p.read_text())}
        self.assertEqual(doors, {"shell/fracture/crack_graph.cpp", "shell/solver/cracking/insertion.cpp"})

    def test_a_criterion_is_one_line_of_the_list(self) -> None:
        """Nothing but the rules asks for the mode by its flags."""
        text = (TOP / "shell" / "solver" / "cracking" / "criteria.cpp").read_text()
        for name in re.findall(r"^      (\w+)\(\),$", text, re.MULTILINE):
            where = [p.name for p in (TOP / "shell").rglob("*.cpp") if re.search(rf"^Criterion {name}\(\)", p.read_text(), re.MULTILINE)]
            self.assertEqual(len(where), 1, name)
        modes = {str(p.relative_to(TOP)) for p in (TOP / "shell").rglob("*.cpp") if "FractureMode::k" in p.read_text()}
        self.assertLessEqual(modes, {"shell/io/shell_setup.cpp", "shell/run/substep.cpp"})


if __name__ == "__main__":
    unittest.main()
