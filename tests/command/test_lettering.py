"""Text in pictures where the machine has no fonts."""
from __future__ import annotations

import unittest
from unittest import mock

from PIL import Image, ImageFont

from sunder_tools.pictures import lettering


class Sparse(ImageFont.FreeTypeFont):
    """A font that has ASCII only: it draws the same box for all else."""

    def __init__(self) -> None:  # no file
        pass

    def getmask(self, text: str, *_: object, **__: object) -> bytes:  # type: ignore[override]
        return text.encode("ascii", "replace").replace(b"?", b"[]")


class Lettering(unittest.TestCase):
    def test_what_a_font_lacks_is_written_in_plain_letters(self) -> None:
        self.assertEqual(lettering._known(Sparse(), "350 µs, heights × 4.6, 20°"), "350 us, heights x 4.6, 20 deg")

    def test_the_bitmap_font_has_latin_1(self) -> None:
        self.assertEqual(lettering._known(mock.Mock(spec=ImageFont.ImageFont), "350 µs × \u2192"), "350 µs × ?")

    def test_text_is_drawn_without_any_font(self) -> None:
        image = Image.new("RGB", (80, 20), "white")
        with mock.patch.object(lettering, "_font", return_value=None):
            lettering.draw_text(image, (2, 2), "350 µs", 12)
        self.assertLess(min(image.convert("L").tobytes()), 128)


if __name__ == "__main__":
    unittest.main()
