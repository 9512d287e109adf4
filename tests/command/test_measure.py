"""`validate` and `bench`: what is handed to the programs, what is made of their numbers."""
from __future__ import annotations

import contextlib
import io
import json
import math
import os
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools import errors
from sunder_tools.launch import build
from sunder_tools.pictures.plots import there
from sunder_tools.places import BUILD_DIR_VARIABLE
from tests.benchmarks import goals
from tests.validation import experiments, measure, results, trials
from tests.validation.extremes import rows as extremes

from . import sunder
from .fakes import write_executables

NUMBERS: dict[str, Any] = {
    "cases": [{"name": "a", "computed": 1.0, "reference": 1.0, "error": 0.0, "tolerance": 0.1, "pass": True, "seconds": 0.0}],
    "curves": [{"name": "order", "x_label": "elements", "y_label": "error", "logarithmic": True,
                "x": [4, 8, 16, 0], "y": [0.1, 0.02, 0.005, 1.0]}]}


class Measuring(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        write_executables(self.folder / "build")
        self.said = io.StringIO()
        environment = mock.patch.dict(os.environ, {BUILD_DIR_VARIABLE: str(self.folder / "build")})
        none = mock.patch.dict(experiments.EXPERIMENTS, {"shells": ()})  # whole runs have tests of their own
        contexts: tuple[contextlib.AbstractContextManager[Any], ...] = (
            environment, none, contextlib.redirect_stderr(self.said), contextlib.redirect_stdout(io.StringIO()))
        for context in contexts:
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)

    def program(self, name: str, body: str) -> None:
        path = self.folder / "build" / "tests" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"#!/usr/bin/python3\nimport sys\n{body}\n")
        path.chmod(0o755)

    def validator(self, status: int) -> None:
        self.program("sunder-validate", "if '--list' in sys.argv: sys.exit(0)\nout = sys.argv[sys.argv.index('--json') + 1]\n"
                     f"open(out, 'w').write({json.dumps(json.dumps(NUMBERS))})\n"
                     f"open({str(self.folder / 'arguments')!r}, 'w').write(' '.join(sys.argv[1:]))\nsys.exit({status})")

    def test_the_table_and_the_plots_are_written_and_the_status_handed_on(self) -> None:
        for status in (0, 1):
            self.validator(status)
            table, plots = self.folder / "table.json", self.folder / "plots.png"
            drawn = ["--plots", str(plots)] if there() else []
            self.assertEqual(sunder(["validate", "shells", "--case", "roof", "--json", str(table), *drawn]), status)
            self.assertEqual(json.loads(table.read_text()), {"cases": NUMBERS["cases"]})
            if drawn:
                self.assertTrue(plots.read_bytes().startswith(b"\x89PNG"))
            self.assertIn("--case roof", (self.folder / "arguments").read_text())

    def test_what_cannot_be_validated_or_written_is_refused(self) -> None:
        self.validator(0)
        self.assertEqual(sunder(["validate", "cheese"]), 2)
        self.assertIn("there are shells, seams, cracks", self.said.getvalue())
        self.assertEqual(sunder(["validate", "shells", "--json", str(self.folder / "no" / "table.json")]), 2)
        self.assertEqual(sunder(["validate", "shells", "--plots", str(self.folder / "plots.cheese")]), 2)
        self.assertIn("'.cheese' is none of .png, .svg, .pdf", self.said.getvalue())
        self.assertEqual(sunder(["validate", "shells", "--case", ""]), 2)
        self.assertFalse((self.folder / "arguments").exists())  # all this before anything is run
        self.assertEqual(sunder(["bench", "--json", str(self.folder / "no" / "bench.json")]), 2)

    def test_an_unknown_case_leaves_no_file(self) -> None:
        self.program("sunder-validate", "raise SystemExit(2)")
        table = self.folder / "table.json"
        self.assertEqual(sunder(["validate", "shells", "--case", "cheese", "--json", str(table)]), 2)
        self.assertFalse(table.exists())

    def test_a_mistyped_case_is_answered_with_the_nearest_of_program_and_whole_runs(self) -> None:
        self.program("sunder-validate", "assert sys.argv[1:] == ['--list']\nprint('shells:\\n  roof    a roof')")
        mirror = experiments.Experiment("mirror", "a pane", lambda table, executables: None)
        for case, words in (("mirorr", "did you mean 'mirror'?"), ("rof", "did you mean 'roof'?"), ("xyz", "there are roof, mirror")):
            with mock.patch.dict(experiments.EXPERIMENTS, {"shells": (mirror,)}):
                self.assertEqual(sunder(["validate", "shells", "--case", case]), 2)
            self.assertIn(f"--case {case}: suite shells has no such case; {words}", self.said.getvalue())

    def test_cases_are_those_that_the_program_lists_and_whole_runs(self) -> None:
        self.program("sunder-validate", "assert sys.argv[1:] == ['--list']\n"
                     "print('shells:\\n  roof    a roof\\n  beam    and more\\nsoft:\\n  ball    one\\nsoft, by name:\\n  long    other')")
        bounce = experiments.Experiment("bounce", "a ball", lambda table, executables: None)
        afar = experiments.Experiment("afar", "fetched", lambda table, executables: None, by_name=True)
        with mock.patch.dict(experiments.EXPERIMENTS, {"shells": (bounce, afar), "soft": ()}):
            self.assertEqual(measure.case_names("shells"), ("roof", "beam", "bounce"))
            self.assertEqual(measure.cases_by_name("shells"), ("afar",))
            self.assertEqual(measure.case_names("soft"), ("ball",))
            self.assertEqual(measure.cases_by_name("soft"), ("long",))
            self.assertEqual(measure.case_names("engines"), ())

    def test_it_is_said_where_nothing_is_drawn(self) -> None:
        self.validator(0)
        with contextlib.redirect_stdout(io.StringIO()) as out:
            sunder(["validate", "shells", "--pictures", str(self.folder / "pictures")])
        self.assertIn("none: these cases draw none", out.getvalue())

    def test_a_program_that_is_missing_or_dies_is_named(self) -> None:
        self.assertEqual(sunder(["validate", "shells"]), 2)
        self.assertIn("sunder-validate", self.said.getvalue())
        self.program("sunder-bench", "import os, signal\nos.kill(os.getpid(), signal.SIGKILL)")
        self.assertEqual(sunder(["bench"]), 3)
        self.assertIn("sunder-bench", self.said.getvalue())


    def test_whole_runs_add_their_rows_and_a_broken_one_fails(self) -> None:
        def good(table: experiments.Table, executables: build.Executables) -> None:
            del executables
            table.add("bounce_1", 1.01, 1.0, 0.03, 0.5)
            table.curves.append(NUMBERS["curves"][0])

        def broken(table: experiments.Table, executables: build.Executables) -> None:
            del table, executables
            raise errors.CommandError("the ball is gone")

        runs = {"shells": (experiments.Experiment("bounce", "a ball", good),
                           experiments.Experiment("gone", "none", broken))}
        table, plots = self.folder / "table.json", self.folder / "plots.png"
        with mock.patch.dict(experiments.EXPERIMENTS, runs):
            drawn = ["--plots", str(plots)] if there() else []
            self.assertEqual(sunder(["validate", "shells", "--case", "bounce", "--json", str(table), *drawn]), 0)  # the other
            # program is not even needed
            self.assertEqual([row["name"] for row in json.loads(table.read_text())["cases"]], ["bounce_1"])
            self.assertEqual(plots.is_file(), there())
            self.validator(0)
            self.assertEqual(sunder(["validate", "shells", "--json", str(table)]), 1)
            rows = json.loads(table.read_text())["cases"]
            self.assertEqual([(row["name"], row["pass"]) for row in rows],
                             [("a", True), ("bounce_1", True), ("gone", False)])
            self.assertIsNone(rows[2]["computed"])

    def test_a_case_by_name_runs_only_so_and_what_it_lacks_skips_it(self) -> None:
        def lacks(table: experiments.Table, executables: build.Executables) -> None:
            del table, executables
            raise trials.Missing("needs the archive")

        runs = {"shells": (experiments.Experiment("afar", "fetched", lacks, by_name=True),)}
        table = self.folder / "table.json"
        self.validator(0)
        with mock.patch.dict(experiments.EXPERIMENTS, runs):
            self.assertEqual(sunder(["validate", "shells", "--json", str(table)]), 0)
            self.assertEqual([row["name"] for row in json.loads(table.read_text())["cases"]], ["a"])
            options: list[list[str]] = [[], ["--known"]]
            for known in options:
                self.assertEqual(sunder(["validate", "shells", "--case", "afar", "--json", str(table), *known]), 0)
                found = results.result_of("shells", json.loads(table.read_text()), 1.0, {})
                self.assertEqual(found.in_words(), "1 skipped")
                self.assertEqual(found.rows[0]["note"], "needs the archive")

    def bench(self, numbers: dict[str, float | None], *arguments: str) -> tuple[int, str]:
        self.program("sunder-bench", "out = sys.argv[sys.argv.index('--json') + 1]\n"
                     f"open(out, 'w').write({json.dumps(json.dumps(numbers))})")
        with contextlib.redirect_stdout(io.StringIO()) as out:
            return sunder(["bench", *arguments]), out.getvalue()

    def test_numbers_stand_beside_their_goals_and_one_beyond_its_limit_fails(self) -> None:
        key, goal = "share_of_fma_peak", goals.GOALS["share_of_fma_peak"]
        for value, how, status in ((goal.goal, "met", 0), (goal.limit, "missed", 0), (0.99 * goal.limit, "BEYOND", 1), (None, "BEYOND", 1)):
            ended, said = self.bench({"other": 7.0, key: value})
            self.assertEqual(ended, status, f"{value}")
            self.assertRegex(said, rf"other +7\n{key} .*goal ≥ 0.35, limit ≥ 0.22: {how}")
        self.assertIn(f"beyond the limit: {key}", self.said.getvalue())
        table = self.folder / "bench.json"
        self.assertEqual(self.bench({key: 0.1}, "--json", str(table))[0], 1)  # what is beyond is written too
        self.assertEqual(json.loads(table.read_text()), {key: 0.1})

    def test_a_cracked_point_is_judged_beside_an_intact_one(self) -> None:
        table = self.folder / "bench.json"
        numbers: dict[str, float | None] = {"force_ns_per_layer_point": 4.0, "force_ns_per_layer_point_mls": 12.0}
        ended, said = self.bench(numbers, "--json", str(table))
        self.assertEqual(ended, 0)
        self.assertRegex(said, r"cracked_point_ratio +3 .*goal ≤ 3.3, .*: met")
        self.assertEqual(json.loads(table.read_text()), {**numbers, "cracked_point_ratio": 3.0})
        self.assertEqual(self.bench({**numbers, "force_ns_per_layer_point_mls": 100.0})[0], 1)

    def test_every_limit_can_fail_and_is_no_stricter_than_its_goal(self) -> None:
        for key, goal in goals.GOALS.items():
            self.assertTrue(goal.within(goal.goal), key)
            self.assertFalse(goal.within(goal.limit * (0.99 if goal.least else 1.01)), key)
            self.assertEqual(goals.beyond({key: goal.limit * (0.99 if goal.least else 1.01)}), [key])
            self.assertEqual(goals.beyond({key: math.nan}), [key])
            self.assertEqual(goals.beyond({key: goal.limit}), [])

    def test_runs_are_measured_alone(self) -> None:
        for option in (["--filter", "x"], ["--profile", "x.png"]):
            self.assertEqual(sunder(["bench", "--runs", *option]), 2)
            self.assertIn(f"{option[0]} chooses among kernels", self.said.getvalue())
    def test_an_interruption_keeps_what_ran(self) -> None:
        """The program gives a row of its first case and is interrupted in the second, as by Ctrl-C in a terminal."""
        so_far = {**NUMBERS, "ran": {"a": 1}, "left": ["b", "c"]}
        self.program("sunder-validate", "import os, signal, time\n"
                     "if sys.argv[1:] == ['--list']:\n    print('shells:\\n  a  one\\n  b  two\\n  c  three')\n    sys.exit()\n"
                     f"if os.path.exists({str(self.folder / 'rows')!r}):\n"
                     f"    open(sys.argv[sys.argv.index('--json') + 1], 'w').write({json.dumps(json.dumps(so_far))})\n"
                     "os.kill(os.getppid(), signal.SIGINT)\ntime.sleep(60)")
        table = self.folder / "table.json"
        told = io.StringIO()
        whole = {"shells": (experiments.Experiment("bounce", "a ball", lambda table, executables: None),)}
        with mock.patch.dict(experiments.EXPERIMENTS, whole), contextlib.redirect_stdout(told):
            self.assertEqual(sunder(["validate", "shells", "--json", str(table)]), 130)
            self.assertIn("interrupted: 0 cases ran, 4 are left\n", told.getvalue())
            self.assertEqual(json.loads(table.read_text()), {"cases": [], "ran": {}, "left": ["a", "b", "c", "bounce"]})
            (self.folder / "rows").touch()
            self.assertEqual(sunder(["validate", "shells", "--json", str(table), "--known"]), 130)
        self.assertIn("interrupted: 1 case ran, 3 are left\n", told.getvalue())
        self.assertEqual(json.loads(table.read_text()),
                         {"cases": NUMBERS["cases"], "ran": {"a": 1}, "left": ["b", "c", "bounce"]})

    def test_an_interrupted_whole_run_leaves_no_row(self) -> None:
        def good(table: experiments.Table, executables: build.Executables) -> None:
            del executables
            table.add("bounce_1", 1.0, 1.0, 0.03, 0.5)

        def cut(table: experiments.Table, executables: build.Executables) -> None:
            del executables
            table.add("cut_1", 1.0, 1.0, 0.03, 0.5)
            table.curves.append(NUMBERS["curves"][0])
            raise errors.Interrupted

        runs = {"shells": tuple(experiments.Experiment(name, "", run) for name, run in (
            ("bounce", good), ("cut", cut), ("later", good)))}
        self.validator(1)  # and a row of it fails
        table = self.folder / "table.json"
        with mock.patch.dict(experiments.EXPERIMENTS, runs), contextlib.redirect_stdout(io.StringIO()) as told:
            self.assertEqual(sunder(["validate", "shells", "--json", str(table)]), 130)
        self.assertIn("interrupted: 1 case ran, 2 are left\n", told.getvalue())
        found = json.loads(table.read_text())
        self.assertEqual([row["name"] for row in found["cases"]], ["a", "bounce_1"])
        self.assertEqual((found["ran"], found["left"]), ({"bounce": 1}, ["cut", "later"]))

    def test_interrupted_benchmarks_and_extremes_keep_theirs(self) -> None:
        self.program("sunder-bench", "import os, signal, time\n"
                     "open(sys.argv[sys.argv.index('--json') + 1], 'w').write('{\"kernel_ns\": 11.5}')\n"
                     "os.kill(os.getppid(), signal.SIGINT)\ntime.sleep(60)")
        numbers = self.folder / "numbers.json"
        with contextlib.redirect_stdout(io.StringIO()) as told:
            self.assertEqual(sunder(["bench", "--json", str(numbers)]), 130)
            self.assertEqual(json.loads(numbers.read_text()), {"kernel_ns": 11.5})
            self.assertRegex(told.getvalue(), r"(?m)^kernel_ns +11\.5$")
            self.assertIn("interrupted: 1 number so far, others are left", told.getvalue())
            outcomes = iter([("fine", [{"name": "one", "pass": True, "seconds": 0.1}])])

            def run_row(row: extremes.Row, runner: extremes.Runner) -> tuple[str, list[dict[str, object]]]:
                del row, runner
                for outcome in outcomes:
                    return outcome
                raise errors.Interrupted

            with mock.patch.object(extremes, "run_row", run_row), mock.patch.object(measure, "ensure_built"):
                self.assertEqual(sunder(["validate", "extremes", "--case", "refused", "--json", str(numbers)]), 130)
        self.assertRegex(told.getvalue(), r"(?m)^interrupted: 1 row ran, [0-9]+ are left$")
        found = json.loads(numbers.read_text())
        self.assertEqual((found["cases"][0]["name"], len(found["ran"])), ("one", 1))
        self.assertGreater(len(found["left"]), 3)

    def test_zeners_equation_has_the_published_answers(self) -> None:
        for inelasticity, known in ((0.1, 0.8433), (0.5, 0.4369), (1.0, 0.1841)):
            self.assertAlmostEqual(experiments.zener(inelasticity, 1e-3), known, delta=5e-5)


if __name__ == "__main__":
    unittest.main()
