"""Runs the quick rows of `validate extremes`, and checks that the table rejects wrong runs."""
from __future__ import annotations

import contextlib
import io
import subprocess
import unittest
from dataclasses import replace

from sunder_tools.launch.build import ensure_built
from tests.validation.extremes import rows as extremes
from tests.validation.extremes.shells import SHELLS
from tests.validation.extremes.suite import ROWS

QUICK = ("thickness_1mm", "youngs_modulus_1e02", "youngs_modulus_1e12", "poisson_minus_0.5", "poisson_0.4999", "span_1um",
         "span_1km", "elements_1", "at_rest", "ball_at_rest", "speed_1km_per_s", "safety_1.0", "refused", "mass", "rebound", "fragments_1",
         "cracks_at_1um_without_engine")


class Extremes(unittest.TestCase):
    def rows(self, rows: list[extremes.Row]) -> tuple[list[dict[str, object]], bool]:
        with contextlib.redirect_stdout(io.StringIO()):
            found, good = extremes.run_rows(rows, ensure_built())
        self.assertEqual(list(found), ["cases"])
        return found["cases"], good  # type: ignore[return-value]

    def test_quick_rows_hold(self) -> None:
        rows = [row for name in QUICK for row in extremes.choose(ROWS, name, False)]
        cases, good = self.rows(rows)
        self.assertTrue(good, [case for case in cases if not case["pass"]])

    def test_what_is_not_as_expected_fails(self) -> None:
        rows = {row.name: row for row in SHELLS}
        runs, refused = rows["elements_1"], rows["refused_layers_1"]
        for row in (replace(runs, expected=extremes.Refused("window_s", "window_s:")),
                    replace(runs, expected=extremes.Stopped("unstable", "")),
                    replace(runs, expected=extremes.Stable(-1.0)),
                    replace(runs, expected=extremes.Stable(1.0, also="it warns of this")),
                    replace(refused, expected=extremes.Stable(1.0)),
                    replace(refused, expected=extremes.Refused("shells[0].layers", "thickness_m:")),
                    replace(rows["substeps_1e6"], limit_s=0.2),
                    replace(runs, check=lambda found, runner: [extremes.Quantity("way", float("nan"), 1.0, 1.0)])):
            cases, good = self.rows([row])
            self.assertFalse(good, cases)

    def test_who_waits_does_not_hang_and_who_computes_on_does(self) -> None:
        def until_it_ends(*command: str) -> str:
            with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
                try:
                    return extremes._until_it_ends(process, 0.5)
                finally:
                    process.kill()
        self.assertEqual(until_it_ends("sh", "-c", "sleep 1.5; echo awake >&2"), "awake\n")  # three times its limit
        with self.assertRaises(subprocess.TimeoutExpired):
            until_it_ends("sh", "-c", "while :; do :; done")
        with self.assertRaises(subprocess.TimeoutExpired):
            until_it_ends("sleep", "60")


if __name__ == "__main__":
    unittest.main()
