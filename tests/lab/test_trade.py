"""The trade: what is varied, what fits a budget, what counts as an error, what is on the front; and one whole trade."""
from __future__ import annotations

import csv
import json
import math
import os
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Callable, Sequence

import numpy as np

from . import REPOSITORY
import sunder
from sunder_lab.trade.judge import Gap, Judged, alike, combinations, compared, front, fronts, gaps, own_errors
from sunder_lab.trade.knobs import Change, Setting, changes_of, elements, finer
from sunder_lab.trade.plan import Budget, reference_level, rounds
from sunder_lab.trade.quantities import in_short, observed, prepared, shaken
from sunder_lab.trade.report import panel, tell, write
from sunder_lab.trade.trade import Outcome, Row, Trade
from sunder_tools.pictures.plots import there

SUNDER = str(REPOSITORY / "coupler" / "sunder")
ROOT_2 = math.sqrt(2.0)


def load(name: str) -> sunder.Scene:
    return sunder.Scene.load(sunder.SCENES / f"{name}.textproto")


def change(knob: str, value: str, cost: float) -> Change:
    return Change(knob, value, cost, lambda scene: None)


def judged(label: str, cost: float, error: float, noise: float = 0.01) -> Judged:
    return Judged(label, cost, cost, {"impulse": Gap(error, noise)})


class Knobs(unittest.TestCase):
    def test_what_means_nothing_for_a_scene_is_left_out_with_its_reason(self) -> None:
        _, left = changes_of(load("roof"), "bullet")  # a shell alone, elastic
        self.assertLessEqual({"window", "scheme", "engine"}, set(left))
        self.assertIn("no body moves", left["scheme"])
        changes, left = changes_of(load("dent"), "bullet")  # it yields
        self.assertIn("yield", left["bending"])
        self.assertEqual([c.value for c in changes if c.knob == "layers"], ["2", "3", "7", "9"])  # its own: 5
        _, left = changes_of(load("impactor"), "bullet")
        self.assertIn("seams", left["transfer"])
        self.assertIn("file", left["degree"])
        for scene in ("roof", "glass"):  # there is no such field to be turned, and none is invented
            self.assertIn("no such setting", changes_of(load(scene), "bullet")[1]["extraction interval"])
            self.assertIn("double precision", changes_of(load(scene), "bullet")[1]["precision of tables"])

    def test_every_change_makes_another_scene_or_engine(self) -> None:
        for name, engine in (("glass", "bullet"), ("torn_sheet", "ode"), ("roof", "bullet")):
            scene = prepared(load(name))
            changes = [c for c in changes_of(scene, engine)[0] if c.knob != "fidelity"]  # may be one of the others
            seen = {(scene.text(), engine)}
            for one in changes:
                setting = Setting((one,))
                seen.add((setting.scene(scene).text(), setting.engine(engine)))
            self.assertEqual(len(seen), len(changes) + 1, name)
            self.assertEqual(scene.text(), prepared(load(name)).text())  # and leaves the first as it was

    def test_changes_do_what_they_say(self) -> None:
        scene = load("glass")
        changes = {c.label: c for c in changes_of(scene, "bullet")[0]}

        def after(*labels: str) -> sunder.Scene:
            return Setting(tuple(changes[label] for label in labels)).scene(scene)

        both = after("elements x0.707", "window x4")
        self.assertEqual((both["shells[pane].plate.elements_x"], both["shells[pane].plate.elements_y"]), (57, 57))
        self.assertEqual((both["window_s"], both["settle_window_s"]), (2e-4, 1e-3))
        bowl = load("bowl")  # of which the length of an element is given
        halves = {c.label: c for c in changes_of(bowl, "bullet")[0]}["elements x0.5"]
        self.assertEqual(Setting((halves,)).scene(bowl)["shells[bowl].mesh.element_m"], 2.0 * float(bowl["shells[bowl].mesh.element_m"]))
        self.assertEqual(after("bending LINEAR")["shells[pane].bending"], "LINEAR")
        self.assertEqual(after("gauss_points 3")["shells[pane].gauss_points"], 3)
        self.assertEqual(after("degree 3")["shells[pane].plate.degree"], 3)
        self.assertEqual(after("stress_model JGT17")["shells[pane].stress_model"], "JGT17")
        self.assertEqual(after("transfer APIC")["transfer.kind"], "APIC")
        self.assertEqual(after("time_step_safety 0.4")["time_step_safety"], 0.4)
        self.assertEqual(after("scheme EXPORTED")["coupling.scheme"], "EXPORTED")
        self.assertEqual(Setting((changes["engine ode"],)).engine("bullet"), "ode")
        self.assertEqual(Setting((changes["window x2"], changes["layers 3"])).label, "window x2, layers 3")

    def test_a_window_stays_a_divisor_of_the_settle_window(self) -> None:
        scene = load("glass").set({"window_s": 4e-4, "settle_window_s": 1.2e-3})
        for one in (c for c in changes_of(scene, "bullet")[0] if c.knob == "window"):
            made = Setting((one,)).scene(scene)
            ratio = float(made["settle_window_s"]) / float(made["window_s"])
            self.assertAlmostEqual(ratio, round(ratio), 9)
            self.assertGreaterEqual(round(ratio), 1)

    def test_the_reference_is_finer_in_all_that_converges(self) -> None:
        self.assertEqual(finer(load("glass"), 0).label, "own")
        self.assertEqual(finer(load("glass"), 2).label, "elements x2, window x0.25")
        self.assertEqual(finer(load("roof"), 1).label, "elements x1.41")  # no body: a window exchanges nothing
        self.assertEqual(finer(load("dent"), 2).scene(load("dent"))["shells[sheet].layers"], 9)  # 5 of its own
        self.assertEqual(finer(load("dent"), -1).scene(load("dent"))["shells[sheet].layers"], 3)


class Plans(unittest.TestCase):
    def level(self, k: int) -> Setting:
        return Setting((elements(ROOT_2 ** k),)) if k else Setting()

    def test_the_reference_takes_at_most_half_the_budget(self) -> None:
        # one run takes 1 s; a reference and its next finest 1 + 0.35, 2.8 + 1, 8 + 2.8, 22.6 + 8 s
        def none(setting: Setting) -> str:
            return ""

        for limit, level in ((2.8, 0), (7.5, 0), (7.8, 1), (21.5, 1), (21.8, 2), (61.0, 2), (62.0, 3), (1e6, 4)):
            self.assertEqual(reference_level(Budget(limit, 1, 1.0), self.level, none), level, limit)
        with self.assertRaisesRegex(sunder.Error, r"half of the budget; give --budget 0\.05, or shorten the scene"):
            reference_level(Budget(2.6, 1, 1.0), self.level, none)
        self.assertEqual(reference_level(Budget(21.8, 4, 1.0), self.level, none), 0)  # four runs of each

    def test_what_the_solver_refuses_is_no_reference(self) -> None:
        def refusing(labels: set[str]) -> Callable[[Setting], str]:
            return lambda s: s.label if s.label in labels else ""

        coarse, fine = {self.level(-1).label}, {self.level(2).label}
        for limit, bad, level in ((7.8, coarse, 1), (21.8, fine, 1), (1e6, fine, 4), (1e6, coarse | fine, 4), (61.0, fine, 1)):
            self.assertEqual(reference_level(Budget(limit, 1, 1.0), self.level, refusing(bad)), level, limit)
        with self.assertRaisesRegex(sunder.Error, r"own, 1 runs each.*give --budget 0\.14, or shorten"):
            reference_level(Budget(2.8, 1, 1.0), self.level, refusing(coarse))
        self.assertEqual(reference_level(Budget(60 * 0.14, 1, 1.0), self.level, refusing(coarse)), 1)
        with self.assertRaisesRegex(sunder.Error, "no setting can be held against a finer one: too coarse"):
            reference_level(Budget(2.8, 1, 1.0), self.level, lambda s: "too coarse")

    def test_cheapest_first_as_far_as_the_budget_goes(self) -> None:
        settings = [Setting((change("layers", str(n), float(n)),)) for n in (5, 2, 3, 9)]
        budget = Budget(13.0, 2, 1.0)
        ran: list[list[str]] = []

        def run(some: Sequence[Setting]) -> None:
            ran.append([s.label for s in some])
            for s in some:
                budget.spent[s.label] = 2.5  # whatever was guessed

        rounds(settings, budget, 1, run)
        self.assertEqual(ran, [["layers 2"], ["layers 3"]])  # 8 s are left for 10
        self.assertEqual(budget.left_out, {"layers 5": 10.0, "layers 9": 18.0})
        budget.limit_s = 16.0
        rounds(settings, budget, 1, run)  # what has been run costs nothing more, and a larger budget adds to it
        self.assertEqual(ran[2:], [["layers 2"], ["layers 3"], ["layers 5"]])
        self.assertEqual(list(budget.left_out), ["layers 9"])

    def test_several_at_once_do_not_pass_the_budget_together(self) -> None:
        budget = Budget(5.0, 1, 1.0)
        ran: list[int] = []

        def run(some: Sequence[Setting]) -> None:
            ran.append(len(some))
            budget.spent.update({s.label: s.guess for s in some})

        rounds([Setting((change("layers", str(n), 2.0),)) for n in range(4)], budget, 4, run)
        self.assertEqual((ran, len(budget.left_out)), ([2], 2))


class Errors(unittest.TestCase):
    def runs(self, name: str, *values: float) -> dict[int, dict[str, np.ndarray]]:
        return {seed: {name: np.array([value])} for seed, value in enumerate(values)}

    def test_differences_are_taken_seed_by_seed(self) -> None:
        """Seeds that scatter by more than the error, alike in both: the error is told to the bit."""
        reference, runs = self.runs("pieces", 10.0, 20.0, 30.0), self.runs("pieces", 11.0, 21.0, 31.0)
        error, half = compared(runs, reference, "pieces", True)
        self.assertAlmostEqual(error, 0.05, 12)
        self.assertAlmostEqual(half, 0.0, 12)
        # 1, -1, 3: a mean of 1 with a deviation of 2; t of two degrees is 4.303
        error, half = compared(self.runs("pieces", 11.0, 19.0, 33.0), reference, "pieces", True)
        self.assertAlmostEqual(error, 0.05, 12)
        self.assertAlmostEqual(half, 4.3027 * 2.0 / math.sqrt(3.0) / 20.0, 4)

    def test_one_run_is_enough_without_chance_only(self) -> None:
        one, reference = self.runs("impulse", 1.1), self.runs("impulse", 1.0)
        self.assertEqual(compared(one, reference, "impulse", False)[1], 0.0)
        self.assertEqual(compared(one, reference, "impulse", True)[1], math.inf)

    def test_a_motion_is_compared_as_a_whole(self) -> None:
        """Same peak, other phase: sin and cos are the root of two apart."""
        t = np.arange(0.0, 4.0 * np.pi, np.pi / 100)
        error, _ = compared({0: {"deflection": np.sin(t)}}, {0: {"deflection": np.cos(t)}}, "deflection", False)
        self.assertAlmostEqual(error, ROOT_2, 12)

    def test_what_is_within_its_noise_is_no_error(self) -> None:
        reference, beside = self.runs("impulse", 1.0), self.runs("impulse", 1.02)
        own = own_errors(reference, beside)
        self.assertAlmostEqual(own["impulse"], 0.02)
        self.assertFalse(gaps(self.runs("impulse", 0.985), reference, own, False)["impulse"].resolved)
        self.assertTrue(gaps(self.runs("impulse", 0.97), reference, own, False)["impulse"].resolved)
        self.assertEqual(gaps(self.runs("pieces", 5.0), reference, own, False), {})  # it lacks what is compared
        self.assertEqual(own_errors(self.runs("pieces", 0.0), self.runs("pieces", 0.0)), {})  # nothing to relate it to

    def test_several_quantities_count_by_their_root_mean_square(self) -> None:
        one = Judged("one", 1.0, 1.0, {"impulse": Gap(0.03, 0.01), "pieces": Gap(0.04, 0.2)})
        self.assertAlmostEqual(one.error, math.sqrt((0.03 ** 2 + 0.04 ** 2) / 2))
        self.assertAlmostEqual(one.height, math.sqrt((0.01 ** 2 + 0.2 ** 2) / 2))
        self.assertFalse(one.resolved)


class Front(unittest.TestCase):
    def test_none_of_the_front_is_beaten_and_all_else_is(self) -> None:
        rng = np.random.default_rng(3)
        cloud = [judged(str(k), *10.0 ** rng.uniform(-1, 1, 2)) for k in range(200)]
        found = front(cloud)
        for one in cloud:
            beaten = any(o.processor_s <= one.processor_s and o.height < one.height for o in cloud)
            self.assertEqual(one not in found, beaten)
        self.assertEqual(found, sorted(found, key=lambda j: j.processor_s))

    def test_below_the_noise_the_cheapest_wins(self) -> None:
        found = front([judged("a", 1.0, 0.009), judged("b", 2.0, 0.001), judged("c", 0.5, 0.2), Judged("failed", 0.0, 0.0)])
        self.assertEqual([j.label for j in found], ["c", "a"])

    def test_no_bound_is_on_the_front_and_no_error_takes_a_bound_off(self) -> None:
        """The scene's own, with a bound of 69 %, beside a coarser one that errs by 54 %: it may be better, or worse."""
        own, coarser = judged("own", 10.0, 0.5, 0.69), judged("coarser", 4.0, 0.54, 0.1)
        coarsest, slow = judged("coarsest", 1.0, 0.6, 0.88), judged("slow", 20.0, 0.8, 0.1)
        wide = judged("wide", 11.0, 0.5, 0.7)
        first, bounds = fronts([own, coarser, coarsest, slow, wide])
        self.assertEqual([j.label for j in first], ["coarser"])  # `slow` errs more than the bound of cheaper ones
        self.assertEqual([j.label for j in bounds], ["coarsest", "own"])
        self.assertEqual(fronts([judged("sure", 2.0, 0.2, 0.1), judged("bound", 1.0, 0.05, 0.1)])[0], [])  # 0.1 at most

    def test_what_scatter_explains_is_like_the_scene_s_own(self) -> None:
        def runs(*values: float) -> dict[int, dict[str, np.ndarray]]:
            return {seed: {"pieces": np.array([value])} for seed, value in enumerate(values)}
        own = runs(10.0, 20.0, 30.0, 40.0)
        self.assertTrue(alike(runs(12.0, 19.0, 33.0, 37.0), own, ["pieces"], True))
        self.assertFalse(alike(runs(12.0, 22.0, 32.0, 42.5), own, ["pieces"], True))
        self.assertTrue(alike(runs(10.0), runs(10.0), ["pieces"], False))
        self.assertFalse(alike(runs(10.0), runs(10.1), ["pieces"], False))
        self.assertFalse(alike({}, own, ["pieces"], True))

    def test_the_plot_has_a_front_of_errors_and_arrows_for_bounds(self) -> None:
        rows = [Row(judged("own", 10.0, 0.5, 0.69), "own", {}, 4, on_bounds=True), Row(judged("a", 4.0, 0.54, 0.1), "one", {}, 4, on_front=True),
                Row(judged("b", 5.0, 0.6, 0.1), "one", {}, 4, like_own=True), Row(judged("ref", 50.0, 0.0, 0.1), "reference", {}, 4)]
        found = Outcome("x", rows, "ref", "b", {"impulse": 0.1}, True, 4, 1.0, 2.0, {}, {}, {})
        front_line, one, _, own = panel(found).lines
        self.assertEqual((front_line.x, front_line.y, front_line.labels), ([4.0], [0.54], ["a"]))
        self.assertEqual((one.x, one.half, one.bound), ([4.0, 5.0], [0.1, 0.1], [False, False]))
        self.assertEqual((own.x, own.y, own.bound, own.labels), ([10.0], [0.69], [True], ["own (the scene's)"]))
        self.assertGreater(own.size, one.size)
        told = tell(found)
        self.assertIn("like own         b: of each quantity their difference is within its 95 % interval over 4 runs", told)
        self.assertRegex(told, r"bounds \(<\) +own: ")
        self.assertRegex(told, r"(?m)^< own .*<69%")
        self.assertRegex(told, r"(?m)^\* a .*54%")
        with tempfile.TemporaryDirectory() as folder:
            for plots, names in (("svg", {"trade.png", "trade.svg"}), ("png", {"trade.png"})):
                write(found, Path(folder), None, plots)
                drawn = {path.name for path in Path(folder).iterdir()} - {"trade.csv", "trade.json"}
                self.assertEqual(drawn, names if there() else set())

    def test_combinations_are_of_what_was_worth_it(self) -> None:
        own = judged("own", 10.0, 0.10)
        single = {"half": judged("half", 2.0, 0.20), "double": judged("double", 80.0, 0.03), "free": judged("free", 8.0, 0.10),
                  "bad": judged("bad", 11.0, 0.40), "worse half": judged("worse half", 3.0, 0.30)}
        knob = {"half": "elements", "double": "elements", "worse half": "elements", "free": "engine", "bad": "transfer"}
        found = combinations(own, single, knob)
        # "free" alone is on the guessed front, too, but is no combination
        self.assertEqual(found, [("half", "free"), ("double", "free")])
        self.assertEqual(combinations(own, single, knob, [frozenset({"elements", "engine"})]), [])
        self.assertEqual(combinations(Judged("own", 1.0, 1.0), single, knob), [])

    def test_what_replaces_a_law_takes_nothing_from_the_error(self) -> None:
        """A law that errs less than the one it replaces does so by luck: it is worth its time only."""
        own, lucky = judged("own", 10.0, 0.10), judged("lucky", 8.0, 0.02)
        half = judged("half", 2.0, 0.20)
        single, knob = {"half": half, "lucky": lucky}, {"half": "elements", "lucky": "stress_model"}
        self.assertEqual(combinations(own, single, knob, converging=["elements"]), [("half", "lucky")])
        slow = {**single, "lucky": judged("lucky", 12.0, 0.02)}
        self.assertEqual(combinations(own, slow, knob, converging=["elements"]), [])
        self.assertEqual(combinations(own, slow, knob), [("half", "lucky")])
        self.assertEqual([j.label for j in front([own, slow["lucky"], half])], ["half", "own", "lucky"])
        self.assertEqual([j.label for j in front([own, slow["lucky"], half], {"lucky": own.height})], ["half", "own"])
        both = Setting((change("elements", "x2", 8.0), change("stress_model", "JGT17", 1.0)))
        self.assertEqual((both.converging.label, both.converging.converging.label), ("elements x2", "elements x2"))


class Quantities(unittest.TestCase):
    def test_probes_are_added_where_there_are_none(self) -> None:
        roof, pane = prepared(load("roof")), prepared(load("intact_pane"))
        self.assertEqual([p.name for p in roof.message.output.probes], ["free_edge"])  # its own
        self.assertEqual([p.name for p in pane.message.output.probes], ["trade_ball", "trade_pane_0", "trade_pane_1"])
        self.assertAlmostEqual(pane.message.output.probes[1].at.u, 0.15)
        self.assertEqual(prepared(pane).text(), pane.text())
        self.assertNotIn("floor", {p.body for p in prepared(load("glass")).message.output.probes})
        pane.check()

    def test_seeds_shake_what_breaks_and_nothing_else(self) -> None:
        glass, sheet, pane = load("glass"), load("torn_sheet"), load("intact_pane")
        self.assertEqual([shaken(glass, k)["fracture.seed"] for k in range(3)], [1, 2, 3])
        strengths = [float(shaken(sheet, k)["materials[plaster].strength"]) for k in range(5)]
        self.assertEqual(strengths[0], 2e6)
        self.assertEqual(len(set(strengths)), 5)
        self.assertTrue(all(abs(s / 2e6 - 1.0) <= 1e-3 for s in strengths))
        self.assertEqual(shaken(pane, 3).text(), pane.text())

    def test_of_a_run_with_a_known_answer(self) -> None:
        from .made_up import FORCE, sunder_mass, write_run
        with tempfile.TemporaryDirectory() as folder:
            run = write_run(Path(folder))
            (Path(folder) / "series.csv").write_text("time [s],cracks [m]\n0,0\n0.002,0\n")
            found = observed(run)
        np.testing.assert_allclose(found["impulse"], [0.0, 0.0, FORCE * 2e-3], rtol=1e-9, atol=1e-12)
        z = -40.0 * 2e-3 + 0.5 * (FORCE / sunder_mass() - 5.0) * 4e-6
        np.testing.assert_allclose(found["energy_taken"], [-FORCE * z], rtol=1e-6)  # the work of the force, but for its sign
        self.assertNotIn("pieces", found)
        self.assertAlmostEqual(in_short("impulse", np.array([3.0, 4.0, 0.0])), 5.0)


class Whole(unittest.TestCase):
    """A coarse pane that holds, for a few windows: a run takes a tenth of a second."""
    COARSE = ("--set", "shells[pane].plate.elements_x=20", "--set", "shells[pane].plate.elements_y=20", "--until", "8e-4")

    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.here = Path(self._folder.name)
        self.out = self.here / "out"

    def trade(self, *arguments: str, scene: str = str(sunder.SCENES / "intact_pane.textproto")) -> tuple[int, str, str]:
        done = subprocess.run([SUNDER, "trade", scene, "--out", str(self.out), *arguments], stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, check=False, timeout=1800, env=dict(os.environ))
        return done.returncode, done.stdout, done.stderr

    def runs(self) -> list[dict[str, str]]:
        with (self.out / "results.csv").open(newline="") as source:
            return list(csv.DictReader(source))

    def test_what_cannot_be_traded_is_refused_before_anything_runs(self) -> None:
        pane, empty = load("intact_pane"), load("intact_pane")
        empty.message.ClearField("shells")
        for one, words in ((Trade(pane, 0.0), "--budget 0: must be a positive number"),
                           (Trade(pane, math.nan), "must be a positive number"),
                           (Trade(pane, 1e-6), "'sunder check'; give more, or shorten"),
                           (Trade(pane, 1.0, vary=["elements", "colour"]), "--vary colour: there are elements, layers"),
                           (Trade(pane, 1.0, seeds=0), "--seeds 0"), (Trade(empty, 1.0), "no shell"),
                           (Trade(pane.copy().set({"window_s": 0.0}), 1.0), "window_s")):
            with self.assertRaises(sunder.Error) as raised:
                one.run(sunder.Settings(self.out, quiet=True))
            self.assertIn(words, str(raised.exception))
            self.assertFalse(self.out.exists())
        for arguments, words in ((("--budget", "0"), "--budget 0: must be a positive number"),
                                 (("--set", "shells[door].layers=3"), "shells[door] is not there")):
            status, out, err = self.trade(*arguments)
            self.assertEqual((status, out), (2, ""), err)
            self.assertIn(words, err)
        self.assertIn("no such scene file", self.trade(scene="none.textproto")[2])

    def test_a_scene_that_fails_when_it_runs_is_told(self) -> None:
        # 6 mm thick, the pane would hold the ball from the start: found by the run, not by the check
        status, _, err = self.trade(*self.COARSE, "--budget", "0.05", "--set", "shells[pane].thickness_m=0.006")
        self.assertEqual(status, 2)
        self.assertRegex(err, "inside shell 'pane'")

    def test_from_scene_to_front_and_again(self) -> None:
        arguments = (*self.COARSE, "--jobs", "2", "--budget", "0.12", "--vary", "elements,engine", "--json", str(self.here / "all.json"))
        status, out, err = self.trade(*arguments)
        self.assertEqual(status, 0, err)
        found = json.loads((self.here / "all.json").read_text())
        self.assertEqual(found, json.loads((self.out / "trade.json").read_text()))
        rows = {row["setting"]: row for row in found["settings"]}
        with (self.out / "trade.csv").open(newline="") as source:
            self.assertEqual([row["setting"] for row in csv.DictReader(source)], list(rows))
        # the engine is another process's only: the same bits, and so the same error as the scene's own
        self.assertEqual(rows["engine inprocess"]["error"], rows["own"]["error"])
        # too coarse for the ball, which is known beforehand: it is not run, and has no row
        self.assertNotIn("elements x0.5", rows)
        self.assertRegex(found["not_applicable"]["elements x0.5"], "^bad_scene: .*take more elements")
        self.assertRegex(out, "not varied +elements x0.5: bad_scene: .*take more elements")
        self.assertEqual({planned["setting"] for planned in self.runs()}, set(rows))
        self.assertTrue(rows["engine inprocess"]["like_own"])
        self.assertRegex(out, "like own .*engine inprocess.*: their results are equal")
        self.assertEqual(rows[found["reference"]]["error"], 0.0)
        self.assertEqual(rows[found["next_finest"]]["quantities"]["impulse"]["error"], found["reference_own_error"]["impulse"])
        for name in ("deflection", "impulse", "energy_taken"):
            self.assertGreater(rows["own"]["quantities"][name]["mean"], 0.0)
        self.assertLessEqual(found["processor_s"], found["budget_s"])
        self.assertIn("crack_length", found["not_compared"])
        self.assertIn("not asked for", found["not_applicable"]["degree"])
        self.assertTrue(found["front"] or found["bounds"])
        for label in found["front"]:
            self.assertTrue(rows[label]["resolved"])
            self.assertIn(f"* {label}", out)
        for label in found["bounds"]:
            self.assertFalse(rows[label]["resolved"])
            self.assertIn(f"< {label}", out)
        self.assertEqual((self.out / "trade.png").is_file(), there())
        # again: nothing is run, and the same comes out
        before = {p: p.stat().st_mtime_ns for p in self.out.glob("members/*/run/usage.json")}
        table = (self.out / "trade.csv").read_bytes()
        status, _, err = self.trade(*arguments)
        self.assertEqual({p: p.stat().st_mtime_ns for p in self.out.glob("members/*/run/usage.json")}, before)
        self.assertEqual((self.out / "trade.csv").read_bytes(), table)
        self.assertNotIn("] done", err)


if __name__ == "__main__":
    unittest.main()
