"""What the impact experiments are made of."""
from __future__ import annotations

import contextlib
import io
import json
import math
import tempfile
import unittest
from pathlib import Path
from typing import cast
from unittest import mock

import numpy as np

from sunder_tools.pictures.crack_lines import Graph
from tests.validation import bends, crack_books, crack_paths, cutting, experiments, fragments, impacts, mirrors, tearing, trials

from .synthetic import write_vtp


def graph(edges: list[tuple[float, float, float, float, float]]) -> Graph:
    """Edges u v u v and birth."""
    rows = np.array(edges, float)
    ends = np.round(rows[:, :4], 9).reshape(-1, 2, 2)  # shared points are the same to the last bit
    return Graph(ends, np.concatenate([ends, np.zeros((len(rows), 2, 1))], axis=2), np.zeros(len(rows), int), rows[:, 4])


class Beside(unittest.TestCase):
    def test_is_within_half_an_element_and_the_same_for_a_seed(self) -> None:
        for seed in range(20):
            offsets = [float(s.split("=")[1]) for s in impacts._beside(seed)]
            self.assertTrue(all(abs(o) <= 0.5 * impacts.SIDE / impacts.ELEMENTS for o in offsets))
            self.assertEqual(impacts._beside(seed), impacts._beside(seed))
        self.assertNotEqual(impacts._beside(1), impacts._beside(2))


class Divisions(unittest.TestCase):
    def fork(self) -> Graph:
        stem = [(0.05 + 1e-3 * k, 0.02, 0.051 + 1e-3 * k, 0.02, 1e-6 * k) for k in range(8)]
        arms = [(0.058 + 1e-3 * k, 0.02 + s * 6e-4 * k, 0.059 + 1e-3 * k, 0.02 + s * 6e-4 * (k + 1), 1e-6 * (8 + k))
                for s in (-1, 1) for k in range(10)]
        return graph(stem + arms)

    def test_are_found_where_a_crack_runs_on_in_two_directions(self) -> None:
        place, when = crack_paths.first_division(self.fork())
        self.assertAlmostEqual(place, 0.058)
        self.assertAlmostEqual(when, 8e-6)
        place, _ = crack_paths.lasting_division(self.fork(), 0.051, 0.095)
        self.assertTrue(0.058 < place < 0.061)

    def test_are_none_in_a_straight_crack(self) -> None:
        straight = graph([(0.05 + 1e-3 * k, 0.02, 0.051 + 1e-3 * k, 0.02, 1e-6 * k) for k in range(20)])
        self.assertTrue(np.isnan(crack_paths.first_division(straight)[1]))
        self.assertTrue(np.isnan(crack_paths.lasting_division(straight, 0.051, 0.095)[1]))

    def test_speed_is_that_of_the_front(self) -> None:
        mean, fastest = crack_paths.front_speed(self.fork(), 7e-6)
        self.assertAlmostEqual(mean, 1000.0, delta=1.0)
        self.assertAlmostEqual(fastest, 1000.0, delta=1.0)

    def test_what_leaves_a_place_is_what_hangs_together_with_it(self) -> None:
        two = graph([(0, 0, 1, 0, 1), (1, 0, 2, 1, 2), (5, 5, 6, 6, 1)])
        self.assertEqual(len(crack_paths.leaving(two, np.zeros(2))), 4)


class Books(unittest.TestCase):
    def rows(self, injected: float, residual: float, ledger: float, born: float) -> dict[str, bool]:
        run = {"energy": {"crack_injected": injected, "dissipated_fracture": 2.0, "residual_relative": residual},
               "ledger": {"linear_max": ledger, "angular_max": 0.0},
               "handoff": {"mass_error_max": 0.0, "momentum_error_max": born, "angular_momentum_error_max": 0.0}}
        table = trials.Table()
        with contextlib.redirect_stdout(io.StringIO()):
            trials.add_books(table, "run", run)
            trials.add_momentum(table, "run", run)
        return {str(row["name"]): bool(row["pass"]) for row in table.rows}

    def test_each_fault_fails_its_own_row(self) -> None:
        self.assertTrue(all(self.rows(0.01, -5e-3, 1e-14, 1e-15).values()))
        for fault, name in (((0.1, 0.0, 0.0, 0.0), "run_injected"), ((0.0, -0.02, 0.0, 0.0), "run_energy"),
                            ((0.0, 0.0, 1e-9, 0.0), "run_impulses"), ((0.0, 0.0, 0.0, 1e-7), "run_handoffs")):
            self.assertEqual([row for row, good in self.rows(*fault).items() if not good], [name])

    def test_a_run_without_cracks_proves_nothing(self) -> None:
        self.assertTrue(np.isnan(trials.injected({"energy": {"crack_injected": 0.0, "dissipated_fracture": 0.0}})))


class Pieces(unittest.TestCase):
    def test_in_place_are_measured_at_rest_and_without_the_largest(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            entries = ""
            for k, of_piece in enumerate(([0] * 5, [4, 4, 7, 9, 11])):
                points = np.array([[0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 1, 0], [4, 5, 0], [1, 4, 0]], float)
                moved = np.array([[0, 0, 5.0 * j] for j in range(6)])
                # of 4, 8, 4 and 2 m^2, reaching 2/3, 4/3, 5/3 and 1/3 m from the border
                triangles = np.array([[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5], [0, 1, 2]])
                write_vtp(folder / f"shell_{k}.vtp", points + moved, triangles,
                          point_data={"displacement": moved}, cell_data={"fragment": np.array(of_piece, float)})
                entries += f'<DataSet timestep="{k}" part="0" file="shell_{k}.vtp"/>'
            (folder / "frames.pvd").write_text(f"<VTKFile><Collection>{entries}</Collection></VTKFile>")
            inside, left = impacts._in_place(folder, 0.5)
            near, at_border = impacts._in_place(folder, 1.5)
        np.testing.assert_allclose(inside, [4.0, 4.0], rtol=1e-6)
        np.testing.assert_allclose(left, [2.0], rtol=1e-6)
        np.testing.assert_allclose(near, [4.0], rtol=1e-6)
        np.testing.assert_allclose(at_border, [2.0, 4.0], rtol=1e-6)


class Energy(unittest.TestCase):
    def test_is_that_of_the_worst_run_and_fails_where_one_has_none(self) -> None:
        for residuals, good in (([1e-3, -9e-3], True), ([1e-3, -2e-2, 0.0], False), ([0.0, float("nan"), 0.0], False)):
            table = trials.Table()
            with contextlib.redirect_stdout(io.StringIO()):
                impacts._add_energy(table, "series", residuals)
            self.assertEqual([(row["name"], row["pass"]) for row in table.rows], [("series_energy", good)])


class Rows(unittest.TestCase):
    def test_are_written_whatever_numbers_they_come_from(self) -> None:
        table = trials.Table()
        with contextlib.redirect_stdout(io.StringIO()):
            table.add("share", cast(float, np.float64(0.5)), 0.0, cast(float, np.float32(0.25)), 1.0)
        self.assertEqual(json.loads(json.dumps(table.rows))[0], {
            "name": "share", "computed": 0.5, "reference": 0.0, "error": 0.5, "tolerance": 0.25, "pass": False, "seconds": 1.0})


class Equivalence(unittest.TestCase):
    def passed(self, *means: float, scatter: float = 1e-3, paired: bool = False) -> list[bool]:
        """Rows for these means on three grids. Seeds scatter around each, alike on all grids only where `paired`."""
        table = trials.Table()
        alike = np.array([-1.0, -1.0, 1.0, 1.0] * (impacts.SEEDS // 4))
        spreads = [alike, alike if paired else np.roll(alike, 1), alike if paired else -alike]
        grids = [[float(v) for v in mean * (1.0 + scatter * spread)] for mean, spread in zip(means, spreads)]
        with contextlib.redirect_stdout(io.StringIO()):
            found = impacts._add_equivalence(table, "count", grids, 0.1, 1.0)
        np.testing.assert_allclose(found, means)
        self.assertEqual([row["name"] for row in table.rows], ["count", "count_over_three"])
        return [bool(row["pass"]) for row in table.rows]

    def test_asks_for_the_last_step_and_for_the_trend(self) -> None:
        self.assertEqual(self.passed(50.0, 54.0, 56.0), [True, True])
        self.assertEqual(self.passed(50.0, 54.0, 62.0), [False, False])
        self.assertEqual(self.passed(50.0, 60.0, 65.0), [True, False])
        self.assertEqual(self.passed(50.0, 50.0, 50.0, scatter=0.5), [False, False])  # scatter cannot hide a difference
        self.assertEqual(self.passed(50.0, 50.0, 50.0, scatter=0.5, paired=True), [True, True])  # nor is it one, seed by seed
        self.assertEqual(self.passed(50.0, 54.0, 62.0, scatter=0.5, paired=True), [False, False])


class Taken(unittest.TestCase):
    def passed(self, taken: list[float]) -> list[tuple[str, bool]]:
        table = trials.Table()
        with contextlib.redirect_stdout(io.StringIO()):
            impacts._add_taken(table, "snapped", taken)
        return [(str(row["name"]), bool(row["pass"])) for row in table.rows]

    def test_is_the_fracture_energy_on_the_mean(self) -> None:
        self.assertEqual(self.passed([0.85, 1.12]), [("snapped_taken_over_G_f", True)])

    def test_far_from_it_or_without_cracks_fails(self) -> None:
        for taken in ([3.0, 3.0], [1.2, 1.2], [0.5, 0.5], [0.0, 0.0], [float("nan"), 1.0]):
            self.assertEqual(self.passed(taken), [("snapped_taken_over_G_f", False)], taken)

    def test_is_asked_of_both_series_whose_grids_resolve_it(self) -> None:
        """From end to end, on runs that are made up."""
        def run(executables: object, what: impacts.Shattering, elements: int, seed: int, picture: object) -> tuple:
            numbers = {key: 1.0 + 1e-3 * seed for key in (
                "count", "surface", "large_pieces", "length", "residual_speed", "area_off", "seconds")}
            areas = np.arange(1.0, 9.0) * 1e-6
            return {**numbers, "taken": 3.0, "residual": 0.0}, areas, areas

        with mock.patch.object(impacts, "_shattered", run), mock.patch.object(impacts, "ProcessPoolExecutor", Inline), \
                mock.patch.object(impacts, "_sizes"), \
                mock.patch.object(impacts, "quantile_bounds", return_value=(1.0, 1.0, 1.0)), \
                contextlib.redirect_stdout(io.StringIO()):
            for series in (impacts.SNAPPED, impacts.HEAVY, impacts.STRUCK):
                table = trials.Table()
                impacts._pieces_of(table, mock.Mock(), series)
                failed = [row["name"] for row in table.rows if not row["pass"]]
                self.assertEqual(failed, [] if series is impacts.STRUCK else [f"{series.name}_taken_over_G_f"])


class Inline:
    """A pool of processes that is none."""

    def __init__(self, *_: object, **__: object) -> None:
        self.map = map

    def __enter__(self) -> "Inline":
        return self

    def __exit__(self, *_: object) -> None:
        pass


class Fragments(unittest.TestCase):
    def test_sizes_fall_with_the_rate_by_the_power_of_grady(self) -> None:
        self.assertAlmostEqual(fragments.published_size(1e-9), 4.5, places=4)
        self.assertAlmostEqual(fragments.published_size(8e9) / fragments.published_size(1e9), 0.25, places=4)

    def test_distance_from_rayleigh(self) -> None:
        share = (np.arange(1000) + 0.5) / 1000
        rayleigh = np.sqrt(-np.log(1.0 - share))
        self.assertLess(fragments.from_rayleigh(5.0 * rayleigh), 0.01)
        self.assertGreater(fragments.from_rayleigh(np.ones(100)), 0.4)
        self.assertGreater(fragments.from_rayleigh(-np.log(1.0 - share)), 0.1)

    def test_flaws_are_those_of_the_places_on_any_grid(self) -> None:
        coarse, fine = fragments.Strip("damage", 1.0, 10), fragments.Strip("damage", 1.0, 15)
        self.assertAlmostEqual(coarse.length, fine.length)
        places = np.linspace(0.0, fragments.EXPECTED, 50)
        np.testing.assert_array_equal(fragments.flaws(coarse, places), fragments.flaws(fine, places))
        self.assertAlmostEqual(float(fragments.flaws(coarse, (np.arange(600) + 0.5) / 10).mean()), 1.0)

    def test_a_bar_solved_alone_breaks_into_what_is_published(self) -> None:
        sizes = fragments.solved(fragments.Strip("damage", 0.3, fragments.FINER))
        self.assertLess(abs(sizes.mean() / fragments.published_size(0.3) - 1.0), fragments.WITHIN)


class Flap(unittest.TestCase):
    def test_exponent_of_two_cracks(self) -> None:
        left = np.linspace(0.0, 0.02, 50)
        for power in (8 / 11, 1.0):
            width = 0.01 * (left / 0.02) ** power
            sides = [np.stack([0.03 - left, 0.015 + sign * 0.5 * width], axis=1) for sign in (-1, 1)]
            ends = np.concatenate([np.stack([a[:-1], a[1:]], axis=1) for a in sides])
            self.assertAlmostEqual(tearing.flap_exponent(ends, 0.015, 0.012), power, places=6)
        self.assertTrue(math.isnan(tearing.flap_exponent(ends[:1], 0.015, 0.012)))


class BluntTool(unittest.TestCase):
    def test_wavelength_of_a_wave_behind_a_straight_start(self) -> None:
        u = np.concatenate([np.linspace(0.0, 0.02, 20), np.linspace(0.02, 0.1, 200)[1:]])
        v = np.where(u < 0.02, 0.0, 0.01 * np.sin(2.0 * np.pi * (u - 0.02) / 0.05)) + 1e-5 * u
        ends = np.stack([np.column_stack([u[:-1], v[:-1]]), np.column_stack([u[1:], v[1:]])], axis=1)
        graph = Graph(ends, np.zeros((len(ends), 2, 3)), np.zeros(len(ends), int), np.arange(1.0, len(ends) + 1.0))
        self.assertAlmostEqual(cutting.wavelength(graph), 0.05, delta=0.002)
        self.assertTrue(math.isnan(cutting.wavelength(graph.some(np.arange(len(ends)) < 5))))


class Registry(unittest.TestCase):
    def test_every_experiment_that_comes_later_exists(self) -> None:
        for module, names in ((impacts, ("round_pane", "impact_speed", "refinement", "snapped", "tough", "heavy", "pieces")),
                              (crack_books, ("books", "many")),
                              (crack_paths, ("modes", "pressed_plate", "kalthoff", "branching", "share")),
                              (mirrors, ("mirror",)), (tearing, ("trousers", "flap")),
                              (fragments, ("strip", "expanding_ring")), (bends, ("bent_section",)), (cutting, ("blunt_tool",))):
            for name in names:
                self.assertTrue(callable(getattr(module, name)))
                self.assertIn(name, [e.name for e in experiments.EXPERIMENTS["cracks"]])

