"""`bench --runs`: what is made of run.json, and that every goal has a number. How fast anything is decides nothing here."""
from __future__ import annotations

import contextlib
import io
import math
import tempfile
import unittest
from pathlib import Path
from typing import Any, Iterator
from unittest import mock

from tests.benchmarks import goals, runs


def run_json() -> dict[str, Any]:
    """As run.json tells of time."""
    return {"time": {"wall_s": 50.0, "stage_s": {"shell_contact": 10.0}, "cracks_grew": {"wall_s": 8.0, "crack_update_s": 2.0}}}


class Runs(unittest.TestCase):
    def test_shares_and_ratios(self) -> None:
        self.assertEqual(runs.of_cracks("glass", run_json(), 400), {"glass_fracture_share": 0.25, "glass_ms_per_edge": 5.0})

    def test_a_run_in_which_it_did_not_happen_meets_no_goal(self) -> None:
        whole = run_json()
        whole["time"]["cracks_grew"] = {"wall_s": 0.0, "crack_update_s": 0.0}
        self.assertEqual(goals.beyond(runs.of_cracks("glass", whole, 0)), ["glass_fracture_share", "glass_ms_per_edge"])

    def test_every_goal_of_runs_gets_a_number(self) -> None:
        @contextlib.contextmanager
        def kept(executables: object, scene: str, settings: list[str]) -> Iterator[tuple[Path, float]]:
            del executables, settings
            asked.append(scene)
            yield Path(folder), 1.0

        asked: list[str] = []
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()), \
                mock.patch.multiple(runs, kept_run=kept, read_run=lambda path: run_json(), last_graph=lambda path: [0] * 400,
                                    write_contact_sheet=lambda path: path,
                                    of_film=lambda name, path: {f"{name}_film_s_a_picture": 0.3, f"{name}_film_system_share": 0.1},
                                    read_usage=lambda path: {"processor_s": 90.0}):
            numbers = runs.measure_runs(mock.sentinel.executables)
        self.assertEqual(asked, ["glass.textproto", "pressed_plate.textproto", "impactor_small.textproto"])
        self.assertEqual(set(numbers), set(goals.RUNS_GOALS))
        self.assertTrue(all(math.isfinite(value) for value in numbers.values()))
        self.assertAlmostEqual(numbers["impactor_small_shell_contact_share"], 0.2)
        self.assertGreaterEqual(numbers["glass_processor_s"], 90.0)

    def test_a_film_is_of_the_first_frames_with_its_time_a_picture_and_the_systems_share(self) -> None:
        for frames, last in ((200, 80), (40, 39)):
            used, system = iter((10.0, 10.0 + 2.0 * (last + 1))), iter((1.0, 1.0 + 0.5 * (last + 1)))
            with mock.patch.multiple(runs, list_frames=lambda path, n=frames: [None] * n, _processor_s=lambda: next(used),
                                     _system_s=lambda: next(system)), \
                    mock.patch.object(runs, "render") as drawn:
                self.assertEqual(runs.of_film("glass", Path("run")), {"glass_film_s_a_picture": 2.0, "glass_film_system_share": 0.25})
            self.assertEqual(drawn.call_args.args[1:5], (Path("run/film.mp4"), True, False, f"0-{last}"))
            self.assertEqual(drawn.call_args.args[5].size, (1280, 720))


if __name__ == "__main__":
    unittest.main()
