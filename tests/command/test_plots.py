"""Plots: labels with units that suit, lines told apart, nothing over anything; and what is said without matplotlib."""
from __future__ import annotations

import importlib.util
import math
import os
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.pictures import plots
from sunder_tools.pictures.plots import COLOURS, Curve, Line, Panel, draw, there, write_panels, write_plots
from sunder_tools.pictures.units import label, scale, valued, words_and_unit
from sunder_tools.places import BUILD_DIR_VARIABLE

WITHOUT = "matplotlib is not installed; apt-get install python3-matplotlib"


class Units(unittest.TestCase):
    def test_names_of_columns_and_labels(self) -> None:
        for name, wanted in (("crack_length_m", ("crack length", "m")), ("residual_velocity_m_per_s", ("residual velocity", "m/s")),
                             ("impulse_N_s", ("impulse", "N s")), ("energy_fracture_J", ("energy to fracture", "J")), ("pieces", ("number of pieces", "")),
                             ("time [s]", ("time", "s")), ("opening [um]", ("opening", "µm")), ("k H^2 / M", ("k H² / M", "")),
                             ("convex parts [-]", ("convex parts", "")), ("seed", ("seed", "")), ("pieces_s", ("pieces", "s"))):
            self.assertEqual(words_and_unit(name), wanted)

    def test_units_suit_the_largest_value(self) -> None:
        for unit, largest, factor, wanted in (
                ("m", 0.613, 1e3, "mm"), ("m", 2.0, 1.0, "m"), ("m", 4e-6, 1e6, "µm"), ("s", 1.4e-4, 1e6, "µs"), ("s", 3600.0, 1.0, "s"),
                ("Pa", 7e10, 1e-9, "GPa"), ("N s", 6e-4, 1e6, "µN s"), ("kg", 0.012, 1e3, "g"), ("m²", 2e-4, 1e6, "mm²"),
                ("m/s", 0.02, 1e3, "mm/s"), ("m/s", 40.0, 1.0, "m/s"), ("", 1e9, 1.0, ""), ("m", 0.0, 1.0, "m"), ("m", 1e-3, 1e3, "mm"),
                ("m", 999.9, 1.0, "m"), ("furlong", 1e-9, 1.0, "furlong")):
            found = scale(unit, [0.0, -largest, math.nan])
            self.assertEqual(found[1], wanted, (unit, largest))
            self.assertAlmostEqual(found[0] / factor, 1.0, places=12)
        self.assertEqual(label("time", ""), "time")
        self.assertEqual([valued(*pair) for pair in (("thickness_m", 0.004), ("thick", 3), ("law", "brittle"), ("on", True))],
                         ["thickness 4 mm", "thick 3", "law brittle", "on True"])


class Without(unittest.TestCase):
    def test_it_is_said_what_to_install(self) -> None:
        with mock.patch.object(plots, "there", return_value=False), mock.patch.object(plots, "ensure_installed") as install, \
                mock.patch.dict(os.environ, {BUILD_DIR_VARIABLE: "/somewhere"}):
            with self.assertRaisesRegex(CommandError, "there is no matplotlib, and SUNDER_BUILD_DIR is set: nothing is installed "
                                                      "then; as root run: apt-get install -y .*python3-matplotlib"):
                write_panels([], Path("never.png"))
            install.assert_not_called()
            del os.environ[BUILD_DIR_VARIABLE]
            with self.assertRaisesRegex(CommandError, "not for this Python"):  # installed, and still not there
                write_panels([], Path("never.png"))
            self.assertEqual(install.call_args.args[1], ("python3-matplotlib",))

    def test_it_is_looked_for_without_importing_it(self) -> None:
        self.assertEqual(there(), importlib.util.find_spec("matplotlib") is not None)


@unittest.skipUnless(there(), WITHOUT)
class Plots(unittest.TestCase):
    LINES = [Line(f"line {k}", [10.0, 20.0, 30.0], [0.2 + 0.001 * k, 0.3, 0.4 + 0.001 * k], [0.05] * 3) for k in range(3)]

    def axes(self, panel: Panel) -> Any:
        return draw([panel]).axes[0]

    def test_axes_have_units_that_suit(self) -> None:
        axes = self.axes(Panel("p", "speed_m_per_s", "crack_length_m", self.LINES))
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), ("speed [m/s]", "crack length [mm]"))
        low, high = axes.get_ylim()
        self.assertTrue(125 < low < 150 and 452 < high < 475, (low, high))  # bars of 150 to 452 mm, and a margin
        for tick in axes.get_yticklabels():
            self.assertRegex(tick.get_text().replace("\N{MINUS SIGN}", "-"), r"^-?\d+(\.\d+)?$")
        self.assertEqual(axes.yaxis.get_offset_text().get_text(), "")

    def test_bars_and_names_do_not_hide_one_another(self) -> None:
        figure = draw([Panel("p", "x", "y", self.LINES)])
        axes = figure.axes[0]
        middles = []
        for bars in axes.containers:
            caps = bars.lines[1][0]
            middles.append(caps.get_transform().transform(caps.get_xydata())[0][0])
        middles.sort()
        self.assertEqual(len(middles), 3)
        self.assertGreater(min(b - a for a, b in zip(middles, middles[1:])), 4.0)  # pixels
        names = [text for text in axes.texts if text.get_text().startswith("line")]
        self.assertEqual([text.get_color() for text in sorted(names, key=lambda t: t.get_text())], list(COLOURS[:3]))
        renderer = figure.canvas.get_renderer()
        boxes = [text.get_window_extent(renderer) for text in names]
        for k, one in enumerate(boxes):
            self.assertGreaterEqual(one.x0, axes.get_window_extent(renderer).x1)  # beside the axes, and on the sheet
            self.assertLessEqual(one.x1, figure.bbox.x1)
            self.assertFalse(any(one.overlaps(other) for other in boxes[k + 1:]))
        self.assertIsNone(axes.get_legend())

    def test_bars_are_told_and_end_where_the_quantity_does(self) -> None:
        line = [Line("", [1.0, 2.0, 3.0], [0.002, 0.004, 0.004], [0.005, 0.001, math.nan])]
        for least, low in ((None, -3.0), (0.0, 0.0)):
            axes = self.axes(Panel("p", "x", "crack_length_m", line, bars="mean ± 95 % interval, 2 runs", least=least))
            self.assertEqual(axes.get_ylabel(), "crack length [mm]\nmean ± 95 % interval, 2 runs")
            segments = axes.containers[0].lines[2][0].get_segments()
            np.testing.assert_allclose([segment[:, 1] for segment in segments], [[low, 7.0], [3.0, 5.0]], atol=1e-9)
            self.assertTrue(low - 1.0 < axes.get_ylim()[0] < low + 1e-9 if least is None else -1.0 < axes.get_ylim()[0] <= 0.0)

    def test_hollow_markers_are_told(self) -> None:
        line = Line("", [1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [0.1] * 3, dots=[(1.0, 0.9)], hollow=[False, True, False],
                    hollow_dots=[(2.0, 1.9), (2.0, 2.1)])
        axes = self.axes(Panel("p", "x", "y", [line], hollow="not ended"))
        open_ones = {tuple(one.get_xdata()) for one in axes.lines if one.get_marker() not in ("None", "")
                     and one.get_markerfacecolor() in ("none", plots.PAPER)}
        self.assertEqual(open_ones, {(2.0,), (2.0, 2.0), ()})  # the mean, its runs, and the sign in the legend
        self.assertEqual([text.get_text() for text in axes.get_legend().get_texts()], ["not ended"])
        joined = [list(one.get_xdata()) for one in axes.lines if one.get_linestyle() == "-" and one.get_marker() == ""]
        self.assertIn([1.0, 2.0, 3.0], joined)
        self.assertIsNone(self.axes(Panel("p", "x", "y", [Line("", [1.0], [1.0])], hollow="not ended")).get_legend())

    def test_upper_bounds_are_arrows_that_point_down(self) -> None:
        line = Line("all", [1.0, 2.0], [0.5, 0.25], [0.1, 0.1], bound=[False, True], joined=False)
        axes = self.axes(Panel("p", "cost [s]", "error", [line], True))
        arrows = [text for text in axes.texts if text.arrow_patch is not None]
        self.assertEqual([text.xy for text in arrows], [(2.0, 0.25)])
        tail = arrows[0].xyann
        self.assertLess(tail[1], 0.0)  # [points] from its place
        self.assertEqual([len(bars.lines[2][0].get_segments()) for bars in axes.containers], [1])  # a bound has no bar
        self.assertEqual([text.get_text() for text in axes.get_legend().get_texts()], ["all"])
        self.assertFalse([one for one in axes.lines if one.get_linestyle() == "-" and len(one.get_xdata()) > 1])

    def test_labels_of_points_are_apart_and_on_the_sheet(self) -> None:
        line = Line("front", [1.0, 1.05, 1.1, 10.0], [1.0, 0.98, 0.97, 0.1], labels=["first", "second", "third", "last"])
        figure = draw([Panel("p", "cost [s]", "error", [line, Line("others", [], [], dots=[(2.0, 0.5)])], True)])
        renderer, axes = figure.canvas.get_renderer(), figure.axes[0]
        boxes = [plots._box_of_text(text, renderer) for text in axes.texts if text.get_text() in line.labels]
        self.assertEqual(len(boxes), 4)
        for k, a in enumerate(boxes):
            self.assertFalse(any(a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3] for b in boxes[k + 1:]))
        self.assertEqual([text.get_text() for text in axes.get_legend().get_texts()], ["others"])
        self.assertEqual((axes.get_xscale(), axes.get_xlabel()), ("log", "cost [s]"))
        told = {text.get_text() for text in [*axes.get_yticklabels(), *axes.get_yticklabels(minor=True)]}
        self.assertTrue({"0.1", "0.2", "1"} <= told and not any("10^" in text or "e-0" in text for text in told), told)

    def test_only_what_can_be_drawn_is(self) -> None:
        axes = self.axes(Panel("p", "x", "y", [Line("a", [0.0, 1.0, 2.0], [1.0, math.nan, 2.0])], True))
        self.assertEqual([list(line.get_xdata()) for line in axes.lines], [[2.0]])
        self.assertFalse(self.axes(Panel("empty", "x", "y", [Line("", [math.nan], [1.0])])).axison)
        self.assertEqual(self.axes(Panel("p", "x", "y", [Line("", [1.0, 2.0], [8.0, 9.0])], from_zero=True)).get_ylim()[0], 0.0)

    def test_curves_of_one_panel_share_its_axes(self) -> None:
        def curve(name: str, y: float, panel: str = "both") -> Curve:
            return Curve(name, "spacing", "speed", [1.0, 2.0], [y, y + 1.0], logarithmic=False, panel=panel)

        curves = [curve("low", 8.0), curve("high", 9.0), curve("low", 8.0, panel="")]
        with tempfile.TemporaryDirectory() as folder:
            for ending, start in ((".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")):
                path = Path(folder) / f"plots{ending}"
                write_plots(curves, path)
                self.assertTrue(path.read_bytes().startswith(start))
                again = Path(folder) / f"again{ending}"
                write_plots(curves, again)
                self.assertEqual(again.read_bytes(), path.read_bytes())
            self.assertEqual(len(list(Path(folder).iterdir())), 6)


if __name__ == "__main__":
    unittest.main()
