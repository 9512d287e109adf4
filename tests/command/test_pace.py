"""The note that a film shows no crack growing, with a speed at which it does."""
from __future__ import annotations

import re
import unittest

import numpy as np

from sunder_tools.pictures.frames import Frame
from sunder_tools.pictures.pace import as_argument, fast_note, growth, pace_note

from .test_render import OfARun
from .test_view import InAFolder

BEGINS, ENDS, WINDOW = 2e-4, 1.2e-3, 1e-4  # [s]


def write_series(folder_run: InAFolder, begins: float = BEGINS, ends: float = ENDS, late: float = 0.01) -> None:
    """Writes crack lengths that grow evenly to 1 - `late` [m] between two times, and to 1 m at three times the second."""
    rows = []
    for k in range(1, 101):
        time = k * WINDOW
        length = (1.0 - late) * float(np.clip((time - begins) / (ends - begins), 0.0, 1.0)) + (late if time > 3.0 * ends else 0.0)
        rows.append(f"{time:.9g},{length:.9g}\n")
    (folder_run.folder / "series.csv").write_text("time [s],cracks [m]\n" + "".join(rows))


def frames_each(interval: float, count: int) -> list[Frame]:
    return [Frame(k * interval, {}) for k in range(count)]


class Notes(InAFolder):
    def test_growth_is_when_most_of_the_length_comes(self) -> None:
        self.assertIsNone(growth(self.folder))
        write_series(self)
        begin, end = growth(self.folder) or (0.0, 0.0)
        self.assertAlmostEqual(begin, BEGINS)
        self.assertTrue(1.1e-3 - 1e-9 < end < ENDS + 1e-9, end)
        (self.folder / "series.csv").write_text("time [s],cracks [m]\n1e-3,0\n2e-3,0\n")
        self.assertIsNone(growth(self.folder))

    def test_a_film_in_which_cracks_grow_within_a_picture_is_told_and_the_speed_helps(self) -> None:
        write_series(self)
        grown = growth(self.folder)
        assert grown is not None
        frames = frames_each(1e-5, 1001)
        for fps in (None, 60.0):
            note = pace_note(self.folder, frames, fps, 0.1)
            self.assertRegex(note, r"^cracks grow within one picture of the film, from 0.0002 s to 0.0012? s of the run; --speed ")
            self.assertNotIn("shell_frame_interval_s", note)
            found = re.search(r"--speed (\S+) spreads that over 24 pictures, and the film has (\d+)$", note)
            assert found is not None, note
            self.assertEqual(pace_note(self.folder, frames, fps, float(found[1])), "")
            shown = (grown[1] - BEGINS) * (fps or 24.0) / float(found[1])
            self.assertTrue(24.0 <= shown + 1e-6 and shown < 27.0, shown)
        self.assertIn("within 2.4 pictures", pace_note(self.folder, frames, 240.0, 0.1))

    def test_a_run_with_few_frames_of_the_growth_is_told_how_it_gets_more(self) -> None:
        write_series(self)
        note = pace_note(self.folder, frames_each(5e-4, 20), None, None)
        self.assertIn("within 2 pictures", note)
        self.assertRegex(note, r"it has 2 of that time: output \{ shell_frame_interval_s: 4\.?1?e-05 \} in its scene gives more$")
        self.assertEqual(pace_note(self.folder, frames_each(5e-5, 200), None, None), "")

    def test_a_film_that_would_be_too_long_is_of_some_frames(self) -> None:
        write_series(self)
        frames = [*frames_each(1e-4, 101), Frame(1e4, {})]
        note = pace_note(self.folder, frames, None, 0.1)
        self.assertRegex(note, r"--speed \S+ with --frames 2-1[12] shows that")
        self.assertEqual(pace_note(self.folder, frames, None, 0.1, some=False), "")

    def test_a_long_film_is_told_with_the_part_in_which_cracks_grow(self) -> None:
        write_series(self)
        frames = frames_each(1e-4, 601)
        note = pace_note(self.folder, frames, None, 0.1)
        found = re.search(r"the film has (\d+), or (\d+) with --frames (\d+)-(\d+)\.? ?", note)
        assert found is not None, note
        self.assertGreater(int(found[1]), 480)
        self.assertTrue(24 <= int(found[2]) <= 30, note)
        first, last = int(found[3]), int(found[4])
        self.assertTrue(frames[first].time_s <= BEGINS and frames[last].time_s >= 1.1e-3, note)
        self.assertNotIn(", or", pace_note(self.folder, frames_each(1e-5, 201), None, 0.1))
        self.assertIn('speed=0.001 spreads', pace_note(self.folder, frames, None, 0.1, True, as_argument))
        self.assertIn('frames="2-', pace_note(self.folder, frames, None, 0.1, True, as_argument))

    def test_a_film_faster_than_life_is_told(self) -> None:
        self.assertEqual(fast_note(20.0), "--speed 20 shows 20 s of the run in a second; --speed 0.05 is 20 times slower than life")
        self.assertEqual([fast_note(None), fast_note(1.0), fast_note(0.1)], ["", "", ""])

    def test_no_note_where_nothing_grows_or_the_time_is_a_load_step(self) -> None:
        self.assertEqual(pace_note(self.folder, frames_each(1e-3, 5), None, 0.1), "")
        write_series(self)
        self.assertEqual(pace_note(self.folder, [Frame(float(k), {}, True) for k in range(5)], None, 0.1), "")
        self.assertEqual(pace_note(self.folder, frames_each(1e-3, 5)[3:], None, 0.1), "")  # after the growth
        self.assertEqual(pace_note(self.folder, frames_each(1e-3, 1), None, 0.1), "")


class Told(OfARun):
    def test_exports_and_films_say_it(self) -> None:
        write_series(self)
        one = str(self.folder / "a.glb")
        film = ("--film", "--size", "64x48", "--jobs", "1", "--out", str(self.folder / "a.gif"))
        growing: list[list[str]] = [["export", "--gltf", one, "--speed", "0.5"], ["export", "--gltf", one],
                                    ["export", "--frames", "0-5", "--speed", "0.5"], ["render", *film]]
        for arguments in growing:
            status, said = self.sunder(*arguments)
            self.assertEqual(status, 0, said)
            self.assertRegex(said, "sunder: note: cracks grow within .*--speed", str(arguments))
        for arguments in (["export", "--frames", "0-3"], ["render", "--frames", "4", "--size", "64x48", "--jobs", "1"]):
            self.assertNotIn("note", self.sunder(*arguments)[1])


if __name__ == "__main__":
    unittest.main()
