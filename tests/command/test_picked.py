"""Frames of a run by number and by time."""
from __future__ import annotations

import unittest

from sunder_tools.errors import CommandError
from sunder_tools.pictures.frames import Frame
from sunder_tools.pictures.picked import pick


def frames_at(*times: float, step: bool = False) -> list[Frame]:
    return [Frame(time, {}, step) for time in times]


EACH_MS = frames_at(*(k * 1e-3 for k in range(10)))


class Picked(unittest.TestCase):
    def test_numbers(self) -> None:
        self.assertEqual(pick("0,5,7-last", EACH_MS), [0, 5, 7, 8, 9])
        self.assertEqual(pick("all", EACH_MS[:3]), [0, 1, 2])
        self.assertEqual(pick("5,5, 4-5", EACH_MS), [4, 5])

    def test_times_are_those_of_the_nearest_frames(self) -> None:
        self.assertEqual(pick("3.4ms,0.0066s", EACH_MS), [3, 7])
        self.assertEqual(pick("2ms-5ms", EACH_MS), [2, 3, 4, 5])
        self.assertEqual(pick("2.1e-3s-4900us", EACH_MS), [3, 4])
        self.assertEqual(pick("6.5 ms-last,0", EACH_MS), [0, 7, 8, 9])
        late = frames_at(0, 1.00049e-3, 1.9996e-3)  # captions say 1 ms and 2 ms
        self.assertEqual(pick("2ms", late), [2])
        self.assertEqual(pick("1ms-2ms", late), [1, 2])
        self.assertEqual(pick("250\u00b5s,9000.000001us", EACH_MS), [0, 9])

    def test_what_is_no_frame(self) -> None:
        for spec, why in (("10", "not among the frames 0 to 9"), ("5-3", "not among"), ("x", "is no frame"), ("", "is no frame"),
                          ("-1", "is no frame"), ("1-2-3", "is no frame"), ("3min", "is no frame"), ("1.5", "is no frame"),
                          ("10ms", "not within the run's frames, 0 to 0.009 s"), ("5ms-3ms", "not within"),
                          ("1ms-5", "mixes a number and a time"), ("2.1ms-2.9ms", "no frame is within 2.1ms-2.9ms; the nearest are 0.002 and 0.003 s")):
            with self.assertRaisesRegex(CommandError, why):
                pick(spec, EACH_MS)
        for spec in ("0", "0s", "all"):
            with self.assertRaisesRegex(CommandError, "the run has no frame"):
                pick(spec, [])
        with self.assertRaisesRegex(CommandError, "are load steps; give numbers, 0 to 3"):
            pick("2s", frames_at(0, 1, 2, 3, step=True))


if __name__ == "__main__":
    unittest.main()
