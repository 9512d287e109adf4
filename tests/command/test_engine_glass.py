"""`validate coupling --case glass`: what is read of a run, and what counts as the same."""
from __future__ import annotations

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

from tests.validation import engine_glass, trials
from tests.validation.engine_glass import Broken, apart, broken, same_until


HEAD = "time [s],cracks [m],engine [J]"


def run(rows: list[str], fragments: float = 20.0, impulse: float = 1.0) -> Broken:
    cells = [row.split(",") for row in rows]
    met = next((k for k, row in enumerate(cells) if float(row[2]) != 0.0), len(cells))
    return Broken(cells, met, {"fragments": fragments, "crack length [m]": 5.0, "impulse on the ball [N s]": impulse}, 0.0, 0.0)


class Reading(unittest.TestCase):
    def test_a_run(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "series.csv").write_text(HEAD + "\n1,0.5,0\n2,0.7,0\n3,0.9,-1e-9\n")
            (folder / "probes.csv").write_text("time [s],ball_vz [m/s]\n0,-8\n1,-8\n2,-3\n")
            (folder / "run.json").write_text(json.dumps({
                "status": "done", "counts": {"fragments": 7}, "energy": {"residual_relative": -0.01},
                "ledger": {"linear_max": 1e-15, "angular_max": 2e-15}}))
            found = broken(folder)
        self.assertEqual((found.met, found.residual, found.impulse), (2, 0.01, 2e-15))
        self.assertEqual((found.quantities["fragments"], found.quantities["crack length [m]"]), (7.0, 0.9))
        self.assertAlmostEqual(found.quantities["impulse on the ball [N s]"], 5.0 * 0.26138, places=4)

    def test_how_long_two_are_the_same(self) -> None:
        self.assertEqual(same_until(run(["1,2,0", "2,3,0"]), run(["1,2,0", "2,4,0"])), 1)
        self.assertEqual(same_until(run(["1,2,0", "2,3,0"]), run(["1,2,0", "2,3,0"])), 2)

    def test_how_far_apart_means_are(self) -> None:
        mean, noise = apart([1.0, 2.0, 3.0], [1.1, 2.1, 3.1])
        self.assertAlmostEqual(mean, 0.05)
        self.assertAlmostEqual(noise, 0.0)


class Rows(unittest.TestCase):
    def compare(self, *runs: Broken) -> dict[object, object]:
        table = trials.Table()
        with contextlib.redirect_stdout(io.StringIO()):
            engine_glass._compare(table, {"one": [run(["1,2,0", "2,3,0", "3,4,1"])] * 2, "two": list(runs)})
        return {row["name"]: row["pass"] for row in table.rows}

    def test_what_differs_before_an_engine_has_changed_anything_fails(self) -> None:
        same = run(["1,2,0", "2,3,0", "3,9,2"])
        self.assertTrue(all(self.compare(same, same).values()))
        self.assertFalse(self.compare(same, run(["1,2,0", "2,3.1,0", "3,4,1"]))["glass_two_differs_early"])

    def test_means_that_differ_fail(self) -> None:
        more = run(["1,2,0", "2,3,0", "3,4,1"], fragments=25.0)
        found = self.compare(more, more)
        self.assertFalse(found["glass_two_fragments"])
        self.assertTrue(found["glass_two_impulse_on_the_ball"])


if __name__ == "__main__":
    unittest.main()
