"""`validate engines`: which suite is called for which engine, what becomes of its rows, and an
engine that cannot be had."""
from __future__ import annotations

import contextlib
import io
import json
import os
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools import errors
from sunder_tools.launch import engines
from sunder_tools.places import BUILD_DIR_VARIABLE
from tests.commands import test as command
from tests.conformance import suites as conformance
from tests.validation import measure, programs

from . import REPOSITORY, sunder

SUITE = """#!/usr/bin/python3
import json, os, signal, sys, time
options = sys.argv[1:]
engine = options[-1] if "--engine-arg" not in options else [b for a, b in zip(options, options[1:]) if a == "--engine-arg"][-1]
with open({log!r}, "a") as log:
    print(*options, file=log)
if "nonsense" in options:
    sys.exit(2)
rows, status = json.load(open({rows!r}))[engine]
if rows is not None:
    json.dump({{"engine": engine, "version": "1", "capabilities": [], "cases": rows, **({{"left": ["b", "c"]}} if status == 130 else {{}})}},
              open(options[options.index("--json") + 1], "w"))
if status == 130:
    os.kill(os.getppid(), signal.SIGINT)
    time.sleep(60)
sys.exit(status)
"""


def row(name: str, verdict: str, error: float | None = 0.0, note: str = "") -> dict[str, object]:
    return {"name": name, "needs": [], "computed": 1.0, "reference": 1.0, "error": error, "tolerance": 1e-3,
            "verdict": verdict, "note": note}


GOOD = [row("fall.height", "pass"), row("fall.speed", "pass"), row("stack", "skipped", None), row("cost.one", "reported")]
KNOWN = [row("fall.height", "known", 0.02, "it sinks; known: by 20 mm"), row("stack.drift", "pass")]
BAD = [row("fall.height", "fail", 0.5), row("fall.speed", "fail", None, "no reply")]


class Suites(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        for name in ("shell/sunder-shell", "rigid/sunder-rigid", "tests/sunder-conformance"):
            path = self.folder / "build" / name
            path.parent.mkdir(parents=True)
            path.write_text(SUITE.format(log=str(self.folder / "log"), rows=str(self.folder / "rows"))
                            if "conformance" in name else "#!/bin/sh\necho alpha beta\n")
            path.chmod(0o755)
        self.said, self.told = io.StringIO(), io.StringIO()
        under_node: Any = mock.patch.object(engines, "NODE_PROGRAMS", {})
        contexts: tuple[contextlib.AbstractContextManager[Any], ...] = (
            mock.patch.dict(os.environ, {BUILD_DIR_VARIABLE: str(self.folder / "build")}), under_node,
            mock.patch.object(conformance, "KNOWN", self.folder),
            contextlib.redirect_stdout(self.told), contextlib.redirect_stderr(self.said))
        for context in contexts:
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)

    def validate(self, outcomes: dict[str, tuple[list[dict[str, object]] | None, int]], *arguments: str) -> int:
        (self.folder / "rows").write_text(json.dumps(outcomes))
        return sunder(["validate", "engines", *arguments])

    def test_each_engine_is_a_column_and_its_list_is_handed_on(self) -> None:
        (self.folder / "beta.txt").write_text("fall.height by 20 mm\n")
        report = self.folder / "table.json"
        status = self.validate({"alpha": (GOOD, 0), "beta": (KNOWN, 0)}, "--case", "fall", "--json", str(report))
        self.assertEqual(status, 0, self.said.getvalue())
        alpha, beta = (self.folder / "log").read_text().splitlines()
        self.assertNotIn("--expect", alpha)
        self.assertIn(f"--expect {self.folder / 'beta.txt'} --case fall", beta)
        lines = self.told.getvalue().splitlines()
        self.assertIn(["case", "alpha", "beta"], [line.split() for line in lines])
        self.assertIn(["fall", "pass", "known", "height", "2.0e-02"], [line.split() for line in lines])
        self.assertIn(["stack", "skipped", "pass"], [line.split() for line in lines])
        self.assertIn("known beta: fall.height 0.02 (allowed 0.001): it sinks; known: by 20 mm", lines)
        self.assertEqual(json.loads(report.read_text())["engines"]["beta"]["cases"], KNOWN)

    def test_a_cell_keeps_whole_numbers(self) -> None:
        self.assertEqual(conformance.shortened("FAIL ahead_0.5 3.3e-14, ahead_1 2.0e-14"), "FAIL ahead_0.5...")
        self.assertEqual(conformance.shortened("known height 2.0e-02"), "known height 2.0e-02")

    def test_a_word_whose_cases_were_all_skipped_is_told(self) -> None:
        rows: list[dict[str, Any]] = [{**row("hinge", "skipped", None), "needs": ["joints", "boxes"]},
                                      {**row("fall.height", "pass"), "needs": ["spheres"]}]
        found = {"mine": {"cases": rows, "capabilities": ["joints", "spheres"]}}
        self.assertIn("note  mine: it declares 'joints', but no case of that ran: they also need boxes", conformance.table(found))
        self.assertNotIn("note", conformance.table({"mine": {"cases": rows, "capabilities": ["spheres"]}}))

    def test_a_row_that_fails_is_the_status(self) -> None:
        self.assertEqual(self.validate({"alpha": (GOOD, 0), "beta": (BAD, 1)}), 1)
        self.assertIn("FAIL  beta: fall.speed: no reply", self.told.getvalue())
        self.assertEqual(self.validate({"alpha": (None, 3), "beta": (GOOD, 0)}), 1)  # nobody spoke
        self.assertIn("alpha: the suite found no engine", self.told.getvalue())

    def test_an_interruption_keeps_what_ran(self) -> None:
        report = self.folder / "table.json"
        self.assertEqual(self.validate({"alpha": (BAD, 130), "beta": (GOOD, 0)}, "--json", str(report)), 130)
        told = self.told.getvalue()
        self.assertIn("FAIL  alpha: fall.speed: no reply", told)  # the table so far
        self.assertIn("not asked: beta\n", told)
        self.assertIn("interrupted: 1 case ran, 2 are left\n", told)
        self.assertEqual(json.loads(report.read_text())["engines"]["alpha"]["left"], ["b", "c"])

    def test_one_engine_alone(self) -> None:
        self.assertEqual(self.validate({"beta": (GOOD, 0)}, "--rigid", "beta"), 0)
        self.assertEqual(len((self.folder / "log").read_text().splitlines()), 1)
        for rigid, says in (("inprocess:alpha", "over the wire"), ("./nothing", "there is no such file")):
            self.assertEqual(self.validate({}, "--rigid", rigid), 2)
            self.assertIn(says, self.said.getvalue())

    def test_a_program_of_the_user_is_held_to_all_of_several_cases(self) -> None:
        mine = self.folder / "beta"
        mine.write_text("#!/bin/sh\n")
        mine.chmod(0o755)
        (self.folder / "beta.txt").write_text("fall.height by 20 mm\n")  # of the engine of that name
        self.validate({"beta": (GOOD, 0)}, "--rigid", str(mine), "--case", "fall,stack")
        asked = (self.folder / "log").read_text()
        self.assertNotIn("--expect", asked)
        self.assertIn(f"--engine {mine} --engine-arg --engine --engine-arg beta --case fall --case stack", asked)

    def test_a_list_of_known_failures_and_cases_to_leave_out_are_handed_on(self) -> None:
        mine, known = self.folder / "beta", self.folder / "mine.txt"
        mine.write_text("#!/bin/sh\n")
        mine.chmod(0o755)
        (self.folder / "alpha.txt").write_text("fall.height by 20 mm\n")
        for name in (str(mine), "alpha"):
            self.assertEqual(self.validate({"alpha": (KNOWN, 0), "beta": (KNOWN, 0)}, "--rigid", name, "--expect", str(known),
                                           "--leave-out", "cost_flight,stack"), 0)
        for asked in (self.folder / "log").read_text().splitlines():
            self.assertIn(f"--expect {known} --leave-out cost_flight --leave-out stack", asked)
            self.assertEqual(asked.count("--expect"), 1)

    def test_the_cases_are_listed(self) -> None:
        suite = self.folder / "build" / "tests" / "sunder-conformance"
        suite.write_text("#!/bin/sh\necho \"$@\" > $(dirname $0)/asked\n")
        self.assertEqual(sunder(["validate", "engines", "--list"]), 0)
        self.assertEqual((suite.parent / "asked").read_text(), "--list\n")

    def test_a_fresh_checkout_builds_the_suite(self) -> None:
        with mock.patch.object(programs, "ensure_built") as ensure, mock.patch.object(measure, "ensure_built"):
            self.validate({"alpha": (GOOD, 0)}, "--rigid", "alpha")
        ensure.assert_called_once_with(targets=("sunder-conformance",))

    def test_what_cannot_be_is_refused(self) -> None:
        self.assertEqual(self.validate({}, "--case", "nonsense"), 2)
        self.assertEqual(len((self.folder / "log").read_text().splitlines()), 1)  # the next engine is not asked
        self.assertEqual(self.validate({}, "--plots", str(self.folder / "plots.png")), 2)
        self.assertEqual(sunder(["validate", "shells", "--rigid", "alpha"]), 2)
        self.assertIn("only 'validate engines'", self.said.getvalue())
        for arguments in (["--list"], ["--leave-out", "a"], ["--expect", "a"]):
            self.assertEqual(sunder(["validate", "shells", *arguments]), 2)
            self.assertIn(f"{arguments[0]}: only 'validate engines' takes it", self.said.getvalue())
        self.assertEqual(self.validate({}, "--expect", "a"), 2)
        self.assertIn("--expect: is for one engine; give --rigid ENGINE too", self.said.getvalue())

    def test_an_engine_under_node_js_is_left_out_with_the_reason_where_it_cannot_be_had(self) -> None:
        programs = {"jolt": self.folder / "jolt", "mujoco": self.folder / "mujoco"}
        for program in programs.values():
            program.write_text("")
        with mock.patch.object(engines, "NODE_PROGRAMS", programs), \
                mock.patch("sunder_tools.launch.node.ensure_node", side_effect=errors.CommandError("no network")):
            self.assertEqual(self.validate({"alpha": (GOOD, 0), "beta": (GOOD, 0)}), 0)
        for name in programs:
            self.assertIn(f"{name}: left out: no network", self.told.getvalue())


class Testing(unittest.TestCase):
    def test_goes_on_without_a_registry_and_says_so(self) -> None:
        said = io.StringIO()
        with mock.patch.object(command, "ensure_node", side_effect=errors.CommandError("no network")) as ensure, \
                mock.patch.object(command, "ensure_installed", side_effect=errors.CommandError("no rights")) as install, \
                mock.patch.object(command, "ensure_built") as built, contextlib.redirect_stderr(said), \
                mock.patch.object(command.subprocess, "run") as run, mock.patch.dict(os.environ):
            os.environ.pop(BUILD_DIR_VARIABLE, None)
            run.return_value.returncode = 0
            self.assertEqual(sunder(["test", "-R", "vtp"]), 0)
            self.assertEqual(run.call_count, 1)
            self.assertIn("no network\nsunder: so the tests of the engines under Node.js are skipped", said.getvalue())
            for what in ("CAD files", "Slurm", "plots", "a German locale", "films", "Blender", "the viewer"):
                self.assertIn(f"no rights\nsunder: so the tests of {what} are skipped", said.getvalue())
            self.assertEqual([call.args[1] for call in install.call_args_list],
                             [command.CAD_PACKAGES, command.SLURM_PACKAGES, command.LINT_PACKAGES, command.PLOT_PACKAGES, command.LOCALE_PACKAGES,
                              command.FILM_PACKAGES, command.BLENDER_PACKAGES, command.BROWSER_PACKAGES])
            built.assert_called_once_with(all_targets=True, cad=False)
            os.environ[BUILD_DIR_VARIABLE] = str(REPOSITORY)
            self.assertEqual(sunder(["test"]), 0)
            self.assertEqual((ensure.call_count, install.call_count), (1, 8))  # no more: nothing is installed then

    def test_builds_with_cad_where_its_packages_can_be_had(self) -> None:
        with mock.patch.object(command, "ensure_node"), mock.patch.object(command, "ensure_installed"), \
                mock.patch.object(command, "_ensure_viewer"), mock.patch.object(command, "ensure_built") as built, \
                mock.patch.object(command.subprocess, "run") as run, mock.patch.dict(os.environ), \
                mock.patch.object(command.first_use, "failed") as failed, \
                mock.patch.object(command.first_use, "tested") as tested:
            os.environ.pop(BUILD_DIR_VARIABLE, None)
            os.environ[command.WITHIN_VARIABLE] = "1"  # as a test does that runs 'sunder test -R ...'
            run.return_value.returncode = 1
            self.assertEqual(sunder(["test", "-R", "vtp"]), 1)
            os.environ.pop(command.WITHIN_VARIABLE)
            self.assertEqual((failed.call_count, tested.call_count), (0, 0))
            cases: list[tuple[int, list[str], int]] = [(0, ["-R", "vtp"], 0), (1, [], 0), (0, [], 1)]
            for status, arguments, times in cases:
                run.return_value.returncode = status
                self.assertEqual(sunder(["test", *arguments]), status)
                self.assertEqual(run.call_args.kwargs["env"][command.WITHIN_VARIABLE], "1")
                self.assertEqual(tested.call_count, times, "of all tests, where they pass")
            built.assert_called_with(all_targets=True, cad=True)


class KnownFailures(unittest.TestCase):
    def test_are_lists_of_engines_that_there_are(self) -> None:
        lists = sorted(path.stem for path in (REPOSITORY / "tests" / "conformance" / "known").glob("*"))
        self.assertEqual(lists, ["bullet", "dart", "freeflight", "jolt", "mujoco", "ode"])


if __name__ == "__main__":
    unittest.main()
