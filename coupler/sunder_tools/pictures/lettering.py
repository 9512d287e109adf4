"""Text in pictures, with any available font."""
from __future__ import annotations

import math

from PIL import Image, ImageDraw, ImageFont

TEXT = (38, 46, 54)


def _font(size: int) -> ImageFont.FreeTypeFont | None:
    for name in ("DejaVuSans.ttf", "LiberationSans-Regular.ttf", "FreeSans.ttf"):
        try:
            return ImageFont.truetype(name, size)
        except OSError:
            continue
    return None


PLAIN = {"µ": "u", "×": "x", "°": " deg"}  # what is written where a font has no such character


def _known(font: ImageFont.ImageFont | ImageFont.FreeTypeFont, text: str) -> str:
    """The text in characters that PIL's own font has: Latin-1 up to version 10, fewer after that."""
    text = text.encode("latin-1", "replace").decode("latin-1")
    missing = bytes(font.getmask("\uffff")) if isinstance(font, ImageFont.FreeTypeFont) else None
    return "".join(c if missing is None or c.isspace() or bytes(font.getmask(c)) != missing else PLAIN.get(c, "?") for c in text)


def draw_text(image: Image.Image, at: tuple[int, int], text: str, size: int) -> None:
    """Draws text with its upper left corner at `at`; without other fonts, in PIL's own small font, enlarged."""
    font = _font(size)
    if font is not None:
        ImageDraw.Draw(image).text(at, text, fill=TEXT, font=font)
        return
    plain = ImageFont.load_default()
    text = _known(plain, text)
    _, _, wide, high = plain.getbbox(text)
    mask = Image.new("L", (math.ceil(wide), math.ceil(high)))
    ImageDraw.Draw(mask).text((0, 0), text, fill=255, font=plain)
    factor = max(size / 11.0, 1.0)
    mask = mask.resize((max(1, round(mask.width * factor)), max(1, round(mask.height * factor))),
                       Image.Resampling.BICUBIC)
    image.paste(Image.new("RGB", mask.size, TEXT), at, mask)
