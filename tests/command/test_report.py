"""`report`: pages and status lines from made-up JSON, and what is refused."""
from __future__ import annotations

import contextlib
import io
import json
import platform
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools.errors import PEER_LOST, CommandError
from sunder_tools.places import REPOSITORY
from sunder_tools.report import machine
from tests.commands import report
from tests.validation import known, results

from . import sunder

WITH: dict[str, Any] = {"commit": "abc", "date": "2000-01-02", "processor": "A | B", "cores": 2, "load": 0.1, "compiler": "c++ 1"}
CASES: dict[str, Any] = {"cases": [
    {"name": "roof", "computed": 1.01, "reference": 1.0, "error": 0.01, "tolerance": 0.1, "pass": True, "seconds": 2.5},
    {"name": "share", "computed": 0.5, "reference": 0.0, "error": 0.5, "tolerance": 0.1, "pass": False, "seconds": 1.0,
     "known": "coarse grid"},
    {"name": "gone", "computed": None, "reference": 0.0, "error": None, "tolerance": 0.0, "pass": False, "seconds": 0.0}]}
ENGINES: dict[str, Any] = {"engines": {"ode": {"engine": "ode", "version": "1", "cases": [
    {"name": "fall.height", "needs": [], "computed": 1.0, "reference": 1.0, "error": 0.0, "tolerance": 1e-3,
     "verdict": "pass", "note": ""},
    {"name": "stack", "needs": ["contact"], "computed": None, "reference": None, "error": None, "tolerance": None,
     "verdict": "skipped", "note": "needs contact"}]}}}


class Pages(unittest.TestCase):
    def test_a_row_has_its_verdict_and_its_reason(self) -> None:
        found = results.result_of("shells", CASES, 3.0, WITH)
        self.assertEqual(found.in_words(), "1 pass, 1 known, 1 fail")
        text = results.page("Results", [found])
        self.assertIn("| roof | 1.01 | 1 | 1.00e-02 | 1.0e-01 | pass | 2.5 |  |", text)
        self.assertIn("| share | 0.5 | 0 | 5.00e-01 | 1.0e-01 | known | 1.0 | coarse grid |", text)
        self.assertIn("| gone | - | 0 | - | 0.0e+00 | fail | 0.0 |  |", text)
        self.assertIn("| abc | 2000-01-02 | A \\| B | 2 | 0.1 | c++ 1 |", text)

    def test_rows_of_engines_are_told_by_engine(self) -> None:
        found = results.result_of("engines", ENGINES, 3.0, WITH)
        self.assertEqual(found.in_words(), "1 pass, 1 skipped")
        self.assertIn("| ode: stack | - | - | - | - | skipped | - | needs contact |", results.page("Results", [found]))

    def test_numbers_of_benchmarks_are_keys_and_values(self) -> None:
        found = results.result_of("bench", {"kernel_ns": 11.5, "peak": None, "share_of_fma_peak": 0.3}, 3.0, WITH)
        text = results.page("Results", [found])
        self.assertIn("| key | value | goal | limit | how it stands |\n", text)
        self.assertIn("| kernel_ns | 11.5 |  |  |  |\n| peak | - |  |  |  |\n| share_of_fma_peak | 0.3 | ≥ 0.35 | ≥ 0.22 | missed |\n", text)
        self.assertIn("3 numbers: 1 missed in 3 s", text)

    def test_what_is_kept_comes_back(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "results"
            found = results.result_of("shells", CASES, 3.0, WITH)
            results.write(found, folder)
            self.assertEqual(results.read_all(folder), [found])
            for text in ("{", "[]", '{"suite": "shells"}'):
                (folder / "bad.json").write_text(text)
                with self.assertRaisesRegex(CommandError, "bad.json: is no result of a suite"):
                    results.read_all(folder)

    def test_the_newest_of_one_day_was_recorded_last(self) -> None:
        def run(row: int, commit: str) -> results.Result:
            return results.result_of("shells", {"cases": [CASES["cases"][row]]}, 3.0, {**WITH, "commit": commit}, case=f"case {row}")

        both = run(0, "first").with_case(run(1, "second"))
        self.assertEqual(len(both.rows), 2)
        self.assertEqual(both.newest["commit"], "second")
        for row in (0, 1):
            self.assertEqual(both.with_case(run(row, "third")).newest["commit"], "third")

    def test_json_of_something_else_is_refused(self) -> None:
        others: list[dict[str, object]] = [{}, {"cases": [{"name": "x"}]}, {"engines": []}]
        for found in others:
            with self.assertRaisesRegex(CommandError, "has no cases"):
                results.result_of("shells", found, 0.0, WITH)


class Status(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.readme = Path(temporary.name) / "README.md"

    def test_only_what_is_between_the_marks_changes(self) -> None:
        self.readme.write_text(f"# Top\n\n{results.FIRST_TIMES}\nold\n{results.LAST_TIMES}\n\n{results.FIRST}\nold\n{results.LAST}\n\nend\n")
        results.put_status(self.readme, [results.result_of("shells", CASES, 90.0, WITH)])
        text = self.readme.read_text()
        self.assertTrue(text.startswith("# Top\n\n") and text.endswith(f"{results.LAST}\n\nend\n"))
        self.assertIn("| shells | 1 pass, 1 known, 1 fail (gone) | 1.5 | abc | 2000-01-02 |", text)
        self.assertNotIn("old", text)
        results.put_status(self.readme, [])
        self.assertIn("No suite has been reported yet.", self.readme.read_text())

    def test_rows_that_fail_are_named_up_to_a_few(self) -> None:
        rows = [{**CASES["cases"][2], "name": name} for name in "abcde"]
        for count, words in ((1, "1 fail (a)"), (2, "2 fail (a, b)"), (5, "5 fail (a, b and 3 more)")):
            told = results.status([results.result_of("shells", {"cases": [CASES["cases"][0], *rows[:count]]}, 6.0, WITH)])
            self.assertIn(f"| shells | 1 pass, {words} | 0.1 |", told)

    def test_a_page_without_a_place_is_refused_and_stays(self) -> None:
        both = (("status", results.FIRST, results.LAST), ("times", results.FIRST_TIMES, results.LAST_TIMES))
        for (name, first, last), (_, *other) in (both, both[::-1]):
            for text in ("", first, last, f"{last}\n{first}\n", f"{first}\n{first}\n{last}\n", f"{first}\n{last}\n{last}\n"):
                text = "\n".join(other) + f"\n{text}"
                self.readme.write_text(text)
                with self.assertRaisesRegex(CommandError, f"has no place for the {name}"):
                    results.put_status(self.readme, [])
                self.assertEqual(self.readme.read_text(), text)

    def test_the_times_of_both_commands_are_those_that_are_kept(self) -> None:
        kept = {"first_install_s": 60.0, "first_build_s": 150.0, "first_build_steps": 9.0, "first_picture_s": 299.0}
        told = results.times([results.result_of("first_use", {"debian_12": kept}, 299.0, WITH, "debian_12")])
        self.assertIn("\n- Debian 12, 2 cores: 5.0 min to the first picture (goal 5), 1.0 of installing and 2.5 of building. "
                      "Second command not timed (abc, 2000-01-02).\n", told)
        first = results.result_of("first_use", {"debian_12": kept}, 299.0, WITH, "debian_12")
        later = {**kept, "first_picture_s": 301.0, "first_test_s": 1200.0}
        told = results.times([first.with_numbers(results.result_of("first_use", {"debian_13": later}, 1.0, WITH, "debian_13"))])
        self.assertRegex(told, r"\n- Debian 12, [^\n]*\n- Debian 13, [^\n]*\. Second command 20.0 min \(")

    def test_rows_are_judged_by_the_list_as_it_is_now(self) -> None:
        folder = self.readme.parent
        rows: list[results.Row] = [{"case": name, "error": error, "verdict": verdict, "note": "old"} for name, error, verdict in (
            ("within", 0.2, "fail"), ("beyond", 0.4, "known"), ("gone", 0.1, "known"), ("nan", None, "known"),
            ("good", 0.01, "pass"), ("absent", None, "skipped"))]
        (folder / "cracks.txt").write_text("".join(f"{name} 0.3 why\n" for name in ("within", "beyond", "nan", "good", "absent")))
        beyond = "known to be off by 0.3 at most"
        self.assertEqual([(row["verdict"], row["note"]) for row in known.today("cracks", rows, folder)],
                         [("known", "why"), ("fail", beyond), ("fail", ""), ("fail", beyond), ("pass", "old"), ("skipped", "old")])
        self.assertEqual(known.today("engines", rows, folder), rows, "a suite that judges itself")

    def test_the_first_picture_is_judged_by_its_goal(self) -> None:
        for seconds, verdict in ((300.0, "pass"), (301.0, "known"), (1e4, "fail")):
            found = results.today([results.result_of("first_use", {"debian_12": {"first_picture_s": seconds}}, seconds, WITH, "debian_12")])
            self.assertEqual([row["verdict"] for row in found[0].rows], [verdict])
            self.assertIn(f"1 {verdict}; 1 numbers in", results.page("Results", found))

    def test_the_pages_are_those_of_what_is_kept(self) -> None:
        top = REPOSITORY / "tests"
        readme = (REPOSITORY / "README.md").read_text(encoding="utf-8")
        kept = [*report.kept(top, "validation"), *report.kept(top, "benchmarks")]
        self.assertIn(results.times(kept), readme, "coupler/sunder report --no-run")
        self.assertIn(results.status(kept), readme, "coupler/sunder report --no-run")
        for room, title in report.TITLES.items():
            self.assertEqual((top / room / "RESULTS.md").read_text(encoding="utf-8"), results.page(title, report.kept(top, room)),
                             "coupler/sunder report --no-run")


class Reporting(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.top = Path(temporary.name)
        self.said = io.StringIO()
        self.cases: list[str | None] = []
        self.rigid: str | None = None
        self.debs: list[Path | None] = []
        self.ratio = 1.01
        contexts: tuple[contextlib.AbstractContextManager[Any], ...] = (
            contextlib.redirect_stderr(self.said), contextlib.redirect_stdout(io.StringIO()),
            mock.patch.object(report, "circumstances", lambda build: WITH))
        for context in contexts:
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)

    def report(self, *suites: str, status: int = 0, found: object = None) -> int:
        def validate(suite: str, case: str | None, numbers: Path, plots: None, known: bool, rigid: str | None = None) -> int:
            self.assertEqual(known, suite not in ("engines", "extremes"))
            self.rigid = rigid
            self.cases.append(case)
            if found is not None:
                numbers.write_text(json.dumps(found))
            return status

        def bench(pattern: None, numbers: Path) -> int:
            numbers.write_text('{"kernel_ns": 11.5}')
            return 0

        def bench_runs(numbers: Path) -> int:
            numbers.write_text('{"glass_processor_s": 100.0}')
            return 0

        with mock.patch.object(report, "validate", validate), mock.patch.object(report, "bench", bench), \
                mock.patch.object(report, "bench_runs", bench_runs), \
                mock.patch.object(report, "measure_package", self.measured), \
                mock.patch.object(report, "case_names", lambda suite: ("roof", "share", "long", "longer")):
            return sunder(["report", *suites, "--json-dir", str(self.top)])

    def measured(self, deb: Path | None) -> dict[str, float]:
        self.debs.append(deb)
        return {"package_force_time_ratio": self.ratio}

    def page(self, room: str = "validation") -> str:
        return (self.top / room / "RESULTS.md").read_text()

    def test_a_suite_is_renewed_alone(self) -> None:
        self.assertEqual(self.report("contact", "shells", found=CASES), 0)
        self.assertEqual(self.report("engines", found=ENGINES), 0)
        self.assertEqual([line for line in self.page().splitlines() if line.startswith("## ")],
                         ["## shells", "## contact", "## engines"])
        self.assertEqual(self.report("bench"), 0)
        self.assertIn("kernel_ns", self.page("benchmarks"))
        self.assertEqual(self.report("bench_runs"), 0)
        self.assertIn("| glass_processor_s | 100 | ≤ 120 | ≤ 380 |", self.page("benchmarks"))
        before = self.page()
        (self.top / "validation" / "RESULTS.md").unlink()
        self.assertEqual(sunder(["report", "--no-run", "--json-dir", str(self.top)]), 0)
        self.assertEqual(self.page(), before)

    def test_a_case_is_renewed_alone(self) -> None:
        self.assertEqual(self.report("shells", found=CASES), 0)
        roof: dict[str, Any] = {**CASES["cases"][0], "computed": 1.02}
        made = {"share": {**WITH, "commit": "def", "date": "2000-01-03"}, "roof": WITH}
        for case in ("roof", "share"):
            found = {"cases": [roof] if case == "roof" else [{**CASES["cases"][1], "name": f"share_{k}"} for k in (1, 2)]}
            with mock.patch.object(report, "circumstances", lambda build, case=case: made[case]):
                self.assertEqual(self.report("shells", "--case", case, found=found), 0)
        self.assertEqual(self.cases, [None, "roof", "share"])
        rows = [line.split(" | ")[:2] for line in self.page().splitlines() if " pass " in line or " known " in line or " fail " in line]
        self.assertEqual(rows[1:], [["| roof", "1.02"], ["| share", "0.5"], ["| gone", "-"], ["| share_1", "0.5"], ["| share_2", "0.5"]])
        self.assertIn("| all others, roof | abc | 2000-01-02 |", self.page())
        self.assertIn("| share | def | 2000-01-03 |", self.page())
        self.assertEqual(results.read_all(self.top / "validation" / "results")[0].newest["commit"], "def")
        self.assertIn("| abc–def | 2000-01-02–03 |", results.status(results.read_all(self.top / "validation" / "results")))
        self.assertEqual(self.report("shells", "--case", "share", found={"cases": CASES["cases"][1:2]}), 0)  # its rows have other names now
        self.assertNotIn("share_1", self.page())
        self.assertEqual(self.report("shells", found=CASES), 0)  # the whole suite replaces all
        self.assertIn("| all | abc |", self.page())

    def test_an_engine_is_renewed_alone(self) -> None:
        def suite(name: str, *rows: dict[str, object]) -> dict[str, object]:
            return {name: {"engine": name, "version": "1", "cases": rows}}

        fall, stack = ENGINES["engines"]["ode"]["cases"]
        both = {"engines": {**suite("ode", fall, stack), **suite("jolt", fall, stack)}}
        self.assertEqual(self.report("engines", found=both), 0)
        self.assertIsNone(self.rigid)
        for name, rows in (("ode", (fall,)), ("mujoco", (fall, stack))):  # one of ode's cases is no more
            with mock.patch.object(report, "circumstances", lambda build: {**WITH, "commit": "def", "date": "2000-01-03"}):
                self.assertEqual(self.report("engines", "--rigid", name, found={"engines": suite(name, *rows)}), 0)
            self.assertEqual(self.rigid, name)
        kept = results.read_all(self.top / "validation" / "results")[0]
        self.assertEqual([row["case"] for row in kept.rows],
                         ["ode: fall.height", "jolt: fall.height", "jolt: stack", "mujoco: fall.height", "mujoco: stack"])
        self.assertEqual(list(kept.runs), ["", "ode", "mujoco"])
        self.assertIn("| all others | abc |", self.page())
        self.assertIn("| ode, mujoco | def |", self.page())
        cases: list[tuple[list[str], str]] = [
            (["shells"], "goes with the suite 'engines' alone"), (["engines", "--case", "fall"], "'engines' alone"),
            (["engines", "shells"], "'engines' alone"), ([], "'engines' alone")]
        for arguments, words in cases:
            self.assertEqual(self.report(*arguments, "--rigid", "ode"), 2)
            self.assertIn(words, self.said.getvalue())
        self.assertEqual(self.report("engines", "--rigid", "./mine"), 2)
        self.assertIn("sunder validate engines --rigid PROGRAM", self.said.getvalue())

    def test_an_interruption_renews_the_cases_that_ran(self) -> None:
        self.assertEqual(self.report("shells", found=CASES), 0)
        roof: dict[str, Any] = {**CASES["cases"][0], "computed": 1.03}
        self.assertEqual(self.report("shells", "contact", status=130, found={"cases": [roof], "ran": {"roof": 1}, "left": ["share"]}), 130)
        self.assertIn("interrupted; what ran is kept, not run: contact\n", self.said.getvalue())
        kept = results.read_all(self.top / "validation" / "results")
        self.assertEqual([result.suite for result in kept], ["shells"])
        self.assertEqual([(row["case"], row["computed"]) for row in kept[0].rows], [("roof", 1.03), ("share", 0.5), ("gone", None)])
        before = self.page()
        self.assertEqual(self.report("shells", status=130), 130)  # nothing had run
        self.assertEqual(self.page(), before)
        self.assertEqual(self.report("soft", status=130, found={"cases": [roof], "ran": {"roof": 1}, "left": ["share"]}), 130)
        self.assertIn("\nNot run yet: share.\n", self.page())
        one = {**ENGINES["engines"]["ode"], "cases": ENGINES["engines"]["ode"]["cases"][:1], "left": ["stack"]}
        self.assertEqual(self.report("engines", found=ENGINES), 0)
        self.assertEqual(self.report("engines", status=130, found={"engines": {"ode": one}}), 130)
        of_suite = {result.suite: result for result in results.read_all(self.top / "validation" / "results")}
        self.assertEqual([(row["case"], row["run"]) for row in of_suite["engines"].rows],
                         [("ode: fall.height", "ode, in part"), ("ode: stack", "")])

    def test_cases_that_no_run_has_had_are_named(self) -> None:
        self.assertEqual(self.report("shells", "--case", "roof", found={"cases": CASES["cases"][:1]}), 0)
        self.assertIn("\nNot run yet: share, long, longer.\n", self.page())
        self.assertEqual(self.report("shells", "--case", "long", found={"cases": CASES["cases"][2:]}), 0)
        self.assertIn("1 pass, 1 fail; 2 cases not run in ", self.page())
        self.assertIn("\nNot run yet: share, longer.\n", self.page())
        kept = results.read_all(self.top / "validation" / "results")[0]
        self.assertEqual(kept.left, ["share", "longer"])
        self.assertEqual(self.report("shells", found=CASES), 0)
        self.assertNotIn("Not run yet", self.page())
        self.assertEqual(self.report("shells", "--case", "roof", found={"cases": CASES["cases"][:1]}), 0)  # the rest is there
        self.assertNotIn("Not run yet", self.page())

    def test_all_are_run_where_none_is_named_and_one_that_fails_is_the_status(self) -> None:
        self.assertEqual(self.report(status=1, found=CASES), 1)
        self.assertEqual({path.stem for path in self.top.rglob("results/*.json")}, {*report.SUITES} - {*report.KEPT})
        self.assertIn(f"these suites fail: {', '.join(report.VALIDATIONS)}\n", self.said.getvalue())

    def test_the_first_use_of_a_new_checkout_is_kept(self) -> None:
        builds = self.top / "build"
        builds.mkdir()
        with mock.patch.object(report, "build_dir", lambda: builds / "release"):
            self.assertEqual(self.report("first_use"), 2)
            self.assertIn("does not tell of a first use: run 'coupler/sunder run", self.said.getvalue())
            times = {"first_install_s": 50.0, "first_build_s": 700.5, "first_build_steps": 190.0, "first_picture_s": 900.0}
            (builds / "first_use.json").write_text(json.dumps({**times, "made_with": WITH}))
            self.assertEqual(self.report("first_use"), 0)
            self.assertIn("| first_picture_s | 900 |", self.page("benchmarks"))
            self.assertNotIn("first_test_s |", self.page("benchmarks"))
            (builds / "first_use.json").write_text(json.dumps({**times, "first_test_s": 2000.0, "made_with": WITH}))
            self.assertEqual(self.report("first_use"), 0)
        self.assertIn("| first_test_s | 2000 |", self.page("benchmarks"))
        self.assertIn("6 numbers in 2900 s.", self.page("benchmarks"))
        self.assertIn(f"| {machine.system()} | {WITH['commit']} |", self.page("benchmarks"))
        self.assertNotIn("first_use", results.status(results.read_all(self.top / "benchmarks" / "results")))

    def test_times_of_two_distributions_stand_beside_one_another(self) -> None:
        builds = self.top / "build"
        builds.mkdir()
        times = {"first_install_s": 50.0, "first_build_s": 700.0, "first_build_steps": 190.0, "first_picture_s": 900.0}
        with mock.patch.object(report, "build_dir", lambda: builds / "release"), mock.patch.object(report, "system", lambda: "debian_13"):
            self.assertEqual(self.report_first(builds, times, WITH), 0)
            self.assertEqual(self.report_first(builds, {**times, "first_install_s": 60.0}, {**WITH, "system": "debian_12"}), 0)
            self.assertIn("| first_run_s | 140 | 150 |", self.page("benchmarks"))
            self.assertEqual(self.report_first(builds, {**times, "first_install_s": 70.0}, {**WITH, "system": "debian_13"}), 0)
            self.assertEqual(self.report_first(builds, {**times, "first_picture_s": 9000.0}, {**WITH, "system": "debian_13"}), 1)
        self.assertIn("| key | debian_12 | debian_13 |\n| --- | --: | --: |\n| first_install_s | 60 | 50 |\n", self.page("benchmarks"))
        self.assertRegex(self.page("benchmarks"), r"\| debian_12.first_picture_s \| 900 \| 300 \| .* known ")
        self.assertRegex(self.page("benchmarks"), r"\| debian_13.first_picture_s \| 9000 \| 300 \| .* fail ")
        self.assertIn("1 known, 1 fail; 10 numbers in ", self.page("benchmarks"))

    def report_first(self, builds: Path, times: dict[str, float], made_with: dict[str, object]) -> int:
        (builds / "first_use.json").write_text(json.dumps({**times, "made_with": made_with}))
        return self.report("first_use")

    def test_a_package_that_is_slower_is_the_status(self) -> None:
        self.assertEqual(self.report("package"), 0)
        self.assertIn("| package_force_time_ratio | 1.01 | ≤ 1.05 | ≤ 1.05 |", self.page("benchmarks"))
        self.ratio = 1.06
        self.assertEqual(self.report("package", "--deb", "made.deb"), 1)
        self.assertEqual(self.debs, [None, Path("made.deb")])
        self.assertIn("these suites fail: package\n", self.said.getvalue())

    def test_steps_of_ci_are_kept(self) -> None:
        builds = self.top / "build"
        builds.mkdir()
        with mock.patch.object(report, "build_dir", lambda: builds / "release"):
            self.assertEqual(self.report("ci"), 2)
            self.assertIn("ci.txt lacks programs, tests_built, tests: run '.ci/run' to its end", self.said.getvalue())
            for tests, status in ((1400, 0), (1401, 1)):
                (builds / "ci.txt").write_text(f"{machine.commit().rstrip('+')}\nprograms 300\ntests_built 400\ntests {tests}\n")
                self.assertEqual(self.report("ci"), status)
        self.assertIn("| ci_s | 2101 | ≤ 1.2e+03 | ≤ 2.1e+03 |", self.page("benchmarks"))

    def test_a_suite_that_breaks_leaves_the_earlier_result(self) -> None:
        self.assertEqual(self.report("shells", found=CASES), 0)
        before = self.page()
        self.assertEqual(self.report("shells", status=3), 1)
        self.assertIn("wrote no JSON", self.said.getvalue())
        with mock.patch.object(report, "validate", side_effect=CommandError("it died", PEER_LOST)):
            self.assertEqual(sunder(["report", "shells", "--json-dir", str(self.top)]), 1)
        self.assertEqual(self.page(), before)
        with mock.patch.object(report, "validate", side_effect=CommandError("no such program")):
            self.assertEqual(sunder(["report", "shells", "contact", "--json-dir", str(self.top)]), 2)

    def test_refused(self) -> None:
        for arguments, words in ((["shels"], "did you mean 'shells'"), (["bench", "--no-run"], "leave 'bench' out"),
                                 (["--case", "roof"], "goes with one suite"), (["bench", "--case", "x"], "goes with one suite"),
                                 (["shells", "soft", "--case", "x"], "goes with one suite"),
                                 (["shells", "--case", "x", "--no-run"], "leave 'shells' out"),
                                 (["shells", "--deb", "x.deb"], "--deb goes with the suite 'package' alone")):
            self.assertEqual(sunder(["report", *arguments, "--json-dir", str(self.top)]), 2)
            self.assertIn(words, self.said.getvalue())
        self.assertEqual(list(self.top.iterdir()), [])


class Machine(unittest.TestCase):
    def test_is_told_by_its_processor_and_compiler_and_never_by_its_name(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "cpuinfo").write_text("processor\t: 0\nmodel name\t: Some   CPU 3 GHz\nmodel name\t: Other\n")
            self.assertEqual(machine.processor(folder / "cpuinfo"), "Some CPU 3 GHz")
            self.assertEqual(machine.processor(folder / "none"), "unknown")
            (folder / "os-release").write_text('NAME="Some OS"\nVERSION_ID="13"\nVERSION="13 (x)"\nID=debian\n')
            self.assertEqual(machine.system(folder / "os-release"), "debian_13")
            self.assertEqual(machine.system(folder / "none"), "unknown")
            (folder / "c++").write_text("#!/bin/sh\necho c++ 1.2 $1\necho more\n")
            (folder / "c++").chmod(0o755)
            (folder / "CMakeCache.txt").write_text(f"CMAKE_CXX_COMPILER:FILEPATH={folder}/c++\n")
            self.assertEqual(machine.compiler(folder), "c++ 1.2 --version")
            self.assertEqual(machine.compiler(folder / "none"), "unknown")
            self.assertEqual(machine.commit(folder), "unknown")
            found = machine.circumstances(folder)
        self.assertGreaterEqual(int(str(found["cores"])), 1)
        self.assertNotIn(platform.node() or "no name", json.dumps(found))


if __name__ == "__main__":
    unittest.main()
