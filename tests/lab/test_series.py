"""Whole series with the real programs: what is told beforehand, what fails, what is killed, and where V50 lies."""
from __future__ import annotations

import csv
import json
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any, Callable, cast

from . import REPOSITORY, sweeps
import sunder
from sunder_lab.impact import ENERGIES
from sunder_lab.sweep import _few, _unsettled, _warnings, series_of
from sunder_lab.table import Table
from sunder_tools.pictures.plots import there

from .made_up import write_dents, write_pieces, write_run

ACRYLIC = sunder.SCENES / "acrylic.textproto"


def coarse() -> sunder.Scene:
    return sunder.Scene.load(ACRYLIC).set({
        "shells[plate].plate.elements_x": 24, "shells[plate].plate.elements_y": 24, "end_time_s": 4e-6})


class Sweeps(unittest.TestCase):
    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.here = Path(self._folder.name)
        self.out = self.here / "out"

    def results(self, out: Path | None = None) -> list[dict[str, str]]:
        with ((out or self.out) / "results.csv").open(newline="") as source:
            return list(csv.DictReader(source))

    def test_a_bad_name_is_told_before_anything_runs(self) -> None:
        file = sweeps.write_file(self.here / "bad.py", [], parameters="""{
            "shells[plate].thickness": [1e-3], "speed": sunder.Parameter([1, 2], "bodies[ball].twist.linear.z"),
            "seed": sunder.Parameter([1], "fracture.seed"), "shells[plate].layers": [2, "two"]}""")
        status, out, err = sweeps.sweep(str(file), "--out", str(self.out))
        self.assertEqual((status, out), (2, ""))
        for words in ("'thickness' is no field of Shell", "there are: pellet", "'seed': every table has a column",
                      "'two' is no whole number"):
            self.assertIn(words, err)
        self.assertFalse(self.out.exists())

    def test_what_is_no_sweep_file_is_refused_with_its_line(self) -> None:
        for text, words in (("x = 1\n", "defines no sunder.Experiment"), ("\nx = 1 / 0\n", "bad.py:2: ZeroDivisionError"),
                            ("\n\nx = (\n", "bad.py:3: SyntaxError"),
                            ("import sunder\nsunder.Scene.load('none.textproto')\n", "none.textproto: cannot be read")):
            (self.here / "bad.py").write_text(text)
            with self.assertRaises(sunder.Error) as raised:
                series_of(self.here / "bad.py")
            self.assertIn(words, str(raised.exception))
        status, _, err = sweeps.sweep(str(self.here / "none.py"))
        self.assertEqual(status, 2)
        self.assertIn("no such file", err)

    def test_a_failed_member_is_a_row_and_the_rest_goes_on(self) -> None:
        # 2 mm thick, the plate would hold the pellet from the start on; a measure of one's own may fail, too
        file = sweeps.write_file(self.here / "some.py", [], parameters='{"shells[plate].thickness_m": [2e-3, 1e-3]}')
        file.write_text(file.read_text().replace("measure=[", "measure=[lambda run: dict(odd=1 / (run.scene['fracture.seed'] - 2)), ")
                        .replace('"speed", "crack', '"shells[plate].thickness_m", "crack'))
        status, out, err = sweeps.sweep(str(file), "--out", str(self.out), "--jobs", "2")
        self.assertEqual(status, 1, err)
        rows = self.results()
        self.assertEqual([row["status"] for row in rows], ["failed", "failed", "done", "not measured"])
        self.assertIn("inside shell 'plate', whose faces are ", rows[0]["error"])
        self.assertNotIn(str(self.here), rows[0]["error"])
        self.assertIn("ZeroDivisionError", rows[3]["error"])
        self.assertIn("1 of 4 runs done", out)
        self.assertRegex(out, "move it [0-9.e-]+ m along")
        self.assertGreater(float(rows[2]["energy_lost_J"]), 0.0)
        # within what the books of the run miss
        self.assertLess(abs(float(rows[2]["energy_missing_J"])), 0.02 * float(rows[2]["energy_lost_J"]))
        base = sqlite3.connect(self.out / "results.sqlite")
        self.addCleanup(base.close)
        self.assertEqual(base.execute("select count(*) from results natural join times where wall_s > 0").fetchone(), (4,))
        # failed ones are tried again, done ones are not
        before = sweeps.outcomes(self.out)
        sweeps.sweep(str(file), "--out", str(self.out), "--quiet")
        self.assertEqual([row["member"] for row in rows if before[row["member"]] == sweeps.outcomes(self.out)[row["member"]]],
                         [rows[2]["member"], rows[3]["member"]])

    def test_killed_half_way_it_goes_on_and_ends_the_same(self) -> None:
        file = sweeps.write_file(self.here / "some.py", [60, 80])
        self.assertEqual(sweeps.sweep(str(file), "--out", str(self.here / "whole"))[0], 0)
        process = sweeps.start(str(file), "--out", str(self.out), "--jobs", "2")
        done = sweeps.kill_half_way(process, self.out, 1)
        self.assert_nothing_runs()
        seen, done = done, sweeps.outcomes(self.out)  # what ran beside may have ended in the moment of the kill
        self.assertTrue(set(seen.items()) <= set(done.items()))
        self.assertLess(len(done), 4)
        self.assertFalse((self.out / "results.csv").exists())
        status, _, err = sweeps.sweep(str(file), "--out", str(self.out))
        self.assertEqual(status, 0, err)
        self.assertIn(f"4 runs, {len(done)} of them done already", err)
        self.assertTrue(set(done.items()) <= set(sweeps.outcomes(self.out).items()), "a member that was done ran again")
        self.assertEqual((self.out / "results.csv").read_bytes(), (self.here / "whole" / "results.csv").read_bytes())
        force = sunder.motion(sunder.member(self.out, self.results()[0]["member"])).largest_mean_force(8e-6)
        self.assertEqual(float(self.results()[0]["mean_force_N"]), force)
        self.assertEqual(float(self.results()[0]["mean_force_interval_s"]), 8e-6)
        first = sunder.Table.read(self.out / "results.csv").rows[0]  # a row's scene, to run or to trade it alone
        saved = sunder.Scene.load(sunder.member(self.out, first["member"]).scene.save(self.here / "one"))
        self.assertEqual((-float(saved["bodies[pellet].twist.linear.z"]), saved["fracture.seed"]), (first["speed"], first["seed"]))
        self.assertEqual(len({row["energy_fracture_J"] for row in self.results()}), 4)  # seeds and speeds differ, in cracks
        self.assertEqual((self.out / "plots.png").is_file(), there())
        self.assertEqual("plots.png is not drawn: there is no matplotlib" in err, not there(), err)
        # another speed is two more members of the same folder
        status, _, err = sweeps.sweep(str(sweeps.write_file(file, [60, 80, 5])), "--out", str(self.out))
        self.assertIn("6 runs, 4 of them done already", err)

    def assert_nothing_runs(self) -> None:
        """No process has the folder in its arguments, soon."""
        end = time.monotonic() + 1800.0
        while True:
            left = [p for p in Path("/proc").glob("[0-9]*/cmdline") if str(self.out).encode() in _read(p)]
            if not left:
                return
            self.assertLess(time.monotonic(), end, f"left behind: {[_read(p) for p in left]}")
            time.sleep(0.05)

    def test_interrupted_it_says_so_and_leaves_nothing(self) -> None:
        file = sweeps.write_file(self.here / "long.py", [], parameters='{"end_time_s": [4e-6, 2e-3]}')
        file.write_text(file.read_text().replace('"speed", "crack', '"end_time_s", "crack').replace("8e-6", "4e-6").replace(
            '"end_time_s": 3e-5,', '"window_s": 1e-6,'))
        process = sweeps.start(str(file), "--out", str(self.out), "--jobs", "2")
        while len(list(self.out.glob("members/*/run/shell.log"))) < 3:
            self.assertIsNone(process.poll(), process.stderr)
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=1800)
        self.assertEqual(process.returncode, 130, err)
        self.assert_nothing_runs()
        self.assertEqual(len(sweeps.outcomes(self.out)), 2)
        self.assertTrue(err.endswith(f"sunder: 2 of 4 runs done, in {self.out}/results.csv; the same command goes on\n"
                                     "sunder: interrupted\n"), err)
        rows = self.results()
        self.assertEqual([row["status"] for row in rows], ["done", "done", "not run", "not run"])
        self.assertEqual([row["impulse_N_s"] != "" for row in rows], [True, True, False, False])

    def test_a_folder_is_for_one_series(self) -> None:
        file = sweeps.write_file(self.here / "some.py", [30], end="5e-2")  # it is killed long before
        (self.here / "mine").mkdir()
        (self.here / "mine" / "letter.txt").touch()
        self.assertIn("holds other files", sweeps.sweep(str(file), "--out", str(self.here / "mine"))[2])
        process = sweeps.start(str(file), "--out", str(self.out))
        self.addCleanup(self.assert_nothing_runs)  # or its run writes into the folder while that is removed
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        while not list(self.out.glob("members/*")):
            self.assertIsNone(process.poll())
            time.sleep(0.05)
        self.assertIn("another series is running there", sweeps.sweep(str(file), "--out", str(self.out))[2])

    def test_a_script_runs_without_the_command(self) -> None:
        script = self.here / "script.py"
        script.write_text("import sunder\n"
                          f"scene = sunder.Scene.load({str(ACRYLIC)!r})\n"
                          "scene['end_time_s'] = 4e-6\n"
                          f"results = scene.run({str(self.out)!r}, threads=1)\n"
                          "print(sunder.motion(results).force(1e-9)[1].shape, results.frames[0].read(0).points.shape[1])\n")
        done = subprocess.run(["/usr/bin/python3", "-B", str(script)], capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONPATH": str(REPOSITORY / "coupler")})
        self.assertEqual((done.stdout, done.stderr), ("(2, 3) 3\n", ""))


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:  # it has ended
        return b""


FIRST_LOOK = REPOSITORY / "coupler" / "experiments" / "first_look.py"  # one run, cell by cell: tests/command/test_python.py


class Shipped(unittest.TestCase):
    def test_every_experiment_can_be_planned_and_has_its_picture(self) -> None:
        files = sorted(set((REPOSITORY / "coupler" / "experiments").glob("*.py")) - {FIRST_LOOK})
        self.assertEqual(len(files), 4)
        for file in files:
            for series in series_of(file):
                self.assertGreater(len({planned.member.identity() for planned in series.plan()}), 15)
                self.assertEqual(series.name, file.stem)
            self.assertTrue(file.with_suffix(".png").is_file())

    def test_the_script_in_the_guide_is_the_one_that_ships(self) -> None:
        text = (REPOSITORY / "coupler" / "experiments" / "radial_cracks.py").read_text()
        page = (REPOSITORY / "coupler" / "experiments" / "README.md").read_text()
        self.assertTrue(re.search(r"```python[^\n]*\n" + re.escape(text) + "```", page), "radial_cracks.py is not in the guide")
        self.assertLess(len(text.splitlines()), 30)


    def test_the_guide_has_every_energy_of_an_impact(self) -> None:
        page = (REPOSITORY / "coupler" / "experiments" / "README.md").read_text()
        cells = re.search(r"\| NAME \|.*?\n\n", page, re.S)
        assert cells is not None
        names = [name for row in cells[0].strip().splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])]
        self.assertEqual(sorted(names), sorted(ENERGIES))


class Plans(unittest.TestCase):
    def test_scatter_is_within_its_bounds_and_the_same_for_a_seed_and_repeat(self) -> None:
        path = "bodies[pellet].pose.position.x"
        one = sunder.Experiment("one", coarse(), {}, seeds=range(8), repeats=3, scatter={path: 1e-3})
        places = [float(planned.member.scene[path]) for planned in one.plan()]
        self.assertEqual(len(set(places)), 24)
        self.assertTrue(all(abs(x) <= 1e-3 for x in places) and max(places) > 5e-4 and min(places) < -5e-4)
        self.assertEqual(places, [planned.member.scene[path] for planned in one.plan()])
        self.assertEqual(coarse()[path], 0.0)

    def test_repeats_of_the_same_are_refused(self) -> None:
        with self.assertRaisesRegex(sunder.Error, "gives the same results to the bit"):
            sunder.Experiment("one", coarse(), {}, repeats=2).plan()

    def test_a_member_is_its_scene_and_engine(self) -> None:
        def identity(value: float, engine: str = "bullet") -> str:
            planned, = sunder.Experiment("one", coarse(), {"window_s": [value]}, engine=engine).plan()
            return planned.member.identity()
        self.assertEqual(identity(2e-6), identity(2e-6))
        self.assertEqual(len({identity(2e-6), identity(1e-6), identity(2e-6, "ode")}), 3)


class Pretended(sunder.Settings):
    """Settings by which nothing is run: every member has a made-up run and an outcome at once."""
    rounds: list[int] = []

    def make(self) -> "Pretended":
        return self

    def run(self, folders: list[Path], ended: Callable[[Path], None]) -> None:
        self.rounds.append(len(folders))
        for folder in folders:
            write_run(folder / "run")
            shutil.copy(folder / "scene.textproto", folder / "run")
            (folder / "outcome.json").write_text('{"status": "done"}')
            ended(folder)


class OneByOne(Pretended):
    """As Pretended, a member after the other."""

    def run(self, folders: list[Path], ended: Callable[[Path], None]) -> None:
        for folder in folders:
            super().run([folder], ended)


class Warned(Pretended):
    """As Pretended; the run with a speed of 2 warns of two things."""

    def run(self, folders: list[Path], ended: Callable[[Path], None]) -> None:
        super().run(folders, ended)
        for folder in folders:
            if sunder.Results(folder / "run").scene["bodies[pellet].twist.linear.z"] == 2.0:
                told = json.loads((folder / "run" / "run.json").read_text())
                (folder / "run" / "run.json").write_text(json.dumps(told | {"warnings": ["5 % is rubble", "coarse"]}))


class Names(unittest.TestCase):
    """Names of columns and plots are found before anything runs: nothing is left in the folder of the series."""

    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.out = Path(self._folder.name) / "out"

    def series(self, **changed: object) -> sunder.Experiment:
        scene = sunder.Scene.load(ACRYLIC)
        return sunder.Experiment(**{"name": "one", "scene": scene, "parameters": {  # type: ignore[arg-type]
            "speed": sunder.Parameter([1, 2], {"bodies[pellet].twist.linear.z": lambda v: -v}),
            "law": sunder.Parameter(["CUTS", "TIPS"], "fracture.mode")},
            "measure": [sunder.impact("pellet"), sunder.fragments()], **changed})

    def refused(self, words: str, **changed: object) -> None:
        with self.assertRaisesRegex(sunder.Error, words) as raised:
            self.series(**changed).run(Pretended(self.out, quiet=True))
        self.assertEqual(raised.exception.status, 2)
        self.assertEqual(list(self.out.glob("members/*/run")), [])

    def test_a_plot_of_no_column_is_told_with_the_nearest_names(self) -> None:
        for plot, words in ((sunder.Plot("speed", "crack_lenght_m"), "no column 'crack_lenght_m'; did you mean 'crack_length_m'"),
                            (sunder.Plot("Speed", "pieces"), "no column 'Speed'; did you mean 'speed'"),
                            (sunder.Plot("speed", "pieces", by="laws"), "no column 'laws'; did you mean 'law'"),
                            (sunder.Plot("speed", "repeat"), "no column 'repeat'"),
                            (sunder.Plot("law", "pieces"), "column 'law' holds text; a plot draws numbers"),
                            (sunder.Plot("speed", "status"), "column 'status' holds text")):
            with self.subTest(words):
                self.refused(f"nothing was run\n(?s:.*){words}", plots=[plot])
        self.assertEqual(len(self.series(plots=sunder.Plot("speed", "pieces", by="law")).plan()), 4)

    def test_a_plot_of_an_own_measure_is_checked_at_once_where_its_columns_are_stated(self) -> None:
        @sunder.gives("height_m", "width_m")
        def size(results: object) -> dict[str, float]:
            del results
            return {"height_m": 1.0}

        self.refused("no column 'hight_m'; did you mean 'height_m'", measure=size, plots=[sunder.Plot("speed", "hight_m")])
        done = self.series(measure=size, plots=[sunder.Plot("speed", "width_m")]).run(Pretended(self.out, quiet=True))
        self.assertEqual([(row["height_m"], row["width_m"]) for row in done], [(1.0, None)] * 4)
        done = self.series(measure=sunder.gives("other")(lambda _: {"hight": 1})).run(Pretended(self.out, quiet=True))
        self.assertIn("does not state: hight", done.rows[0]["error"])

    def test_a_plot_of_an_unstated_measure_ends_with_the_first_run(self) -> None:
        def height(results: object) -> dict[str, float]:
            del results
            return {"height_m": 1.0}

        settings = OneByOne(self.out, quiet=True)
        for runs in (1, 1):  # the second time before anything runs
            with self.assertRaisesRegex(sunder.Error, "no column 'hight_m'; did you mean 'height_m'(?s:.*)sunder.gives"):
                self.series(measure=height, plots=[sunder.Plot("speed", "hight_m")]).run(settings)
            self.assertEqual(len(list(self.out.glob("members/*/run"))), runs)
        self.assertEqual(len(self.series(measure=height, plots=[sunder.Plot("speed", "height_m")]).run(settings)), 4)

    def test_a_force_without_its_interval_is_told(self) -> None:
        with_it = sunder.impact("pellet", interval_s=1e-5)
        for measure, name, words in ((sunder.impact("pellet"), "peak_force_N", "take interval_s in sunder.impact"),
                                     (sunder.impact("pellet"), "mean_force_N", "sunder.impact gives it with interval_s"),
                                     (with_it, "peak_force_N", "grew without limit"),
                                     (with_it, "mean_force", "did you mean 'mean_force_N'")):
            self.refused(f"no column '{name}'; (?s:.*){words}", measure=measure, plots=[sunder.Plot("speed", name)])
        self.refused("interval_s is -1", measure=sunder.impact("pellet", interval_s=-1.0))

    def test_what_runs_warn_of_is_told_once_for_each_kind(self) -> None:
        for member, warnings in (("a", ["1.5 % of the points are rubble"]), ("b", ["16 % of the points are rubble", "cracks"]),
                                 ("c", [])):
            folder = self.out / "members" / member / "run"
            folder.mkdir(parents=True)
            (folder / "run.json").write_text(json.dumps({"status": "done", "warnings": warnings}))
        rows = Table([{"member": member, "speed": 2.5 * k, "seed": 7 + k, "status": "done"}
                      for k, member in enumerate(("a", "b", "c", "lost"))])
        self.assertEqual(_warnings(self.out, rows), [
            "warning          2 of 4 runs, first speed 0.0, seed 7 (a): 1.5 % of the points are rubble",
            "warning          1 of 4 runs, first speed 2.5, seed 8 (b): cracks"])
        self.assertEqual(_unsettled(rows), [])

    def test_the_table_has_the_number_of_warnings(self) -> None:
        self.refused("'warnings'", measure=[sunder.gives("warnings")(lambda _: {"warnings": 1})])
        series = self.series(parameters={"speed": sunder.Parameter([1.0, 2.0], "bodies[pellet].twist.linear.z")},
                             measure=lambda _: {"height_m": 1.0})
        table = series.run(Warned(self.out, quiet=True))
        self.assertEqual(list(zip(table["speed"], table["warnings"])), [(1.0, 0), (2.0, 2)])
        self.assertIn(",warnings,height_m", (self.out / "results.csv").read_text().splitlines()[0])
        self.assertRegex(_warnings(self.out, table)[1], r"^warning +1 of 2 runs, first speed 2.0, seed \d+ \([0-9a-f]{16}\): coarse$")

    def test_runs_that_end_during_the_impact_are_told(self) -> None:
        rows = Table([
            {"member": name, "status": status, "settled": settled}
            for name, status, settled in (("a", "done", 1.0), ("b", "done", 0.0), ("c", "failed", None))])
        line, = _unsettled(rows)
        self.assertIn("1 of 2 runs end before the body has arrived or while it is still pushed", line)

    def test_too_few_seeds_are_told(self) -> None:
        def rows(seeds: int, crack: float = 0.0) -> Table:
            return Table([{"member": f"{v}{s}", "speed": v, "seed": s, "status": "done", "crack_length_m": crack}
                          for v in (1.0, 2.0) for s in range(seeds)])
        self.assertRegex(_few(rows(2))[0], r"^warning +2 runs of the same values: half of the 95 % interval of their mean is 12.7 "
                                           r"standard errors; take 4 seeds or more$")
        self.assertIn("is 4.3 standard errors", _few(rows(3))[0])
        self.assertEqual([_few(rows(4)), _few(rows(1)), _few(Table([]))], [[], [], []])  # alone, and nothing cracks
        self.assertIn("1 run of the same values: nothing is known of their scatter; take 4", _few(rows(1, 0.1))[0])

    def test_plots_are_also_written_for_print(self) -> None:
        series = self.series(plots=[sunder.Plot("speed", "residual_velocity_m_per_s", by="law")], measure=sunder.impact("pellet"))
        with self.assertRaisesRegex(sunder.Error, "plots 'eps': there are png, svg, pdf"):
            series.run(Pretended(self.out, quiet=True, plots="eps"))
        for plots, names in (("svg", {"plots.png", "plots.svg"}), ("png", {"plots.png"}), ("pdf", {"plots.png", "plots.pdf"})):
            series.run(Pretended(self.out, quiet=True, plots=plots))
            self.assertEqual({path.name for path in self.out.glob("plots.*")}, names if there() else set())

    def test_an_interval_of_less_than_four_rows_is_told_before_a_run(self) -> None:
        rows = float(coarse()["window_s"])
        words = f"rows of the probe are {rows:g} s apart; give at least {4 * rows:g}, or lower window_s"
        self.refused(words, measure=sunder.impact("pellet", interval_s=3.9 * rows))
        self.assertTrue(self.series(measure=sunder.impact("pellet", interval_s=4.0 * rows)).plan())
        said = " ".join(str(sunder.impact.__doc__).split())
        self.assertIn("It is at least four rows of the probe, better ten. A row is a window", said)
        self.assertIn("the force over a window grows without limit as windows get shorter", said)

    def test_what_measures_refuse_is_told_beside_other_faults(self) -> None:
        self.refused("(?s:'lineer' is no field.*)no body 'pelet'; did you mean 'pellet'",
                     parameters={"speed": sunder.Parameter([1.0], "bodies[pellet].twist.lineer.z")},
                     measure=sunder.impact("pelet"))

    def test_an_interval_of_text_is_refused(self) -> None:
        self.refused("interval_s is '2e-4', which is no number", measure=sunder.impact("pellet", interval_s=cast(Any, "2e-4")))

    def test_a_column_is_found_by_the_begin_of_its_name(self) -> None:
        self.refused("no column 'residual'; did you mean 'residual_velocity_m_per_s'",
                     measure=sunder.impact("pellet"), plots=[sunder.Plot("speed", "residual")])

    def test_measures_that_share_columns_are_told_in_one_line(self) -> None:
        words = "'pieces': there is one of that name already, and of 4 more; leave a measure out, or choose other names, of a measure by sunder.gives"
        self.refused(words, measure=[sunder.fragments(), sunder.fragments()])

    def test_names_that_differ_in_case_only_are_refused(self) -> None:
        self.refused("'Pieces': differs from 'pieces' in case only", measure=[sunder.fragments(), sunder.gives("Pieces")(lambda _: {})])
        self.refused("'SPEED': differs from 'speed' in case only", measure=sunder.gives("SPEED")(lambda _: {}))
        self.refused("'pieces': there is one of that name already", measure=[sunder.fragments(), sunder.fragments()])
        done = self.series(measure=lambda _: {"height": 1, "Status": 2}).run(Pretended(self.out, quiet=True))
        self.assertIn("in case only: 'Status' beside 'status'", done.rows[0]["error"])

    def test_a_measure_of_no_body_or_shell_is_told(self) -> None:
        self.refused("no body 'pelet'; did you mean 'pellet'", measure=sunder.impact("pelet"))
        self.refused("no shell 'plates'; did you mean 'plate'", measure=sunder.dent("plates"))
        self.refused("must be a function", measure=["pieces"])
        with self.assertRaisesRegex(sunder.Error, "no body 'pelet'; did you mean 'pellet'"):
            sunder.V50("limit", coarse(), "bodies[pellet].twist.linear.z", 10, 20, [1], body="pelet").plan()

    def test_an_unknown_engine_is_told(self) -> None:
        self.refused("bulet(?s:.*)did you mean 'bullet'", engine="bulet")

    def test_every_measure_states_what_it_gives(self) -> None:
        self.out.mkdir()
        dents = write_dents(self.out / "dents")
        whole = write_pieces(self.out / "pieces")
        for measure, results in ((sunder.impact("pellet"), write_run(self.out / "run")),
                                 (sunder.impact("pellet", interval_s=5e-4), write_run(self.out / "force")), (sunder.dent("hit"), dents),
                                 (sunder.fragments(), whole), (sunder.radial_cracks((0, 0), 1e-3), whole)):
            self.assertEqual(tuple(measure.of(results)), measure.columns)


class Ballistics(unittest.TestCase):
    def test_bisection_finds_each_pane_s_limit(self) -> None:
        """Panes whose limit is known: `through` says so of the speed in the scene. One never breaks, one always does,
        one is never decided, and of one pane both ends take longer."""
        limits: dict[int, float | None] = {1: 23.0, 2: 34.0, 3: 28.5, 4: 1e9, 5: 0.0, 6: None}
        end = float(coarse()["end_time_s"])

        def through(results: sunder.Results) -> bool | None:
            scene = results.scene
            limit, speed = limits[int(scene["fracture.seed"])], -float(scene["bodies[pellet].twist.linear.z"])
            if limit == 23.0 and speed in (20, 40) and float(scene["end_time_s"]) < 3 * end:
                return None  # until it has been doubled twice
            return None if limit is None else speed > limit

        with tempfile.TemporaryDirectory() as folder:
            settings = Pretended(Path(folder) / "out", quiet=True)
            settings.rounds = []
            found = sunder.V50("limit", coarse(), {"bodies[pellet].twist.linear.z": lambda v: -v}, 20.0, 40.0, list(limits),
                               tolerance=0.7, through=through).run(settings)
            self.assertEqual(len(found.limits), 5)
            for value, limit in zip(found.limits, (23.0, 34.0, 28.5)):
                self.assertLessEqual(abs(value - limit), found.resolution)
            self.assertEqual(found.limits[3:], [float("inf"), 0.0])
            self.assertEqual(found.resolution, 0.3125)  # 20 m/s halved five times, and once more
            self.assertEqual(found.v50, found.limits[2])  # the middle one of five
            self.assertEqual((found.low, found.high), (0.0, float("inf")))  # five panes bound nothing with 95 %
            # both ends of six; then two are bisected while both ends of two more are run for longer, once more, and
            # again for the one that is never decided while the third catches up
            self.assertEqual(settings.rounds, [12, 2 + 4, 2 + 4, 3 + 2, 3, 3, 1, 1])
            with (Path(folder) / "out" / "results.csv").open(newline="") as source:
                rows = list(csv.DictReader(source))
            self.assertEqual({row["doubled"] for row in rows if not row["perforated"]}, {"0", "1", "2", "3"})
            self.assertEqual(json.loads((Path(folder) / "out" / "v50.json").read_text())["lost_seeds"], [6])

    def test_a_range_that_makes_no_sense_is_refused(self) -> None:
        cases: list[tuple[float, float, list[int], str]] = [
            (30, 20, [1], "must rise"), (10, 20, [], "seeds"), (10, 20, [1, 1], "seeds")]
        for low, high, seeds, words in cases:
            with self.assertRaisesRegex(sunder.Error, words):
                sunder.V50("limit", coarse(), "bodies[pellet].twist.linear.z", low, high, seeds).plan()


if __name__ == "__main__":
    unittest.main()
