"""Text in pictures, with any available font."""
from __future__ import annotations

import math

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from .palette import ramp

TEXT, PAPER = (38, 46, 54), (250, 250, 249)
HALO = 9  # [of the size of the text] its light border, where it stands on something dark
BAR = (0.28, 0.022)  # [of the height of the picture] length and height of a colour bar


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


def text_width(text: str, size: int) -> int:
    """Returns how wide `draw_text` writes [px]."""
    font = _font(size)
    if font is not None:
        return math.ceil(font.getlength(text))
    plain = ImageFont.load_default()
    return math.ceil(plain.getbbox(_known(plain, text))[2] * max(size / 11.0, 1.0))


def bar_box(image: Image.Image) -> tuple[int, int, int, int]:
    """Returns left, top, right and bottom [px] of the colour bar, in the lower right corner."""
    length, high = (max(round(share * image.height), least) for share, least in zip(BAR, (16, 3)))
    right, bottom = image.width - image.height // 20, image.height - 2 * _bar_text(image)
    return max(right - length, 0), bottom - high, right, bottom


def _bar_text(image: Image.Image) -> int:
    """Returns the size of the text at a colour bar [px]."""
    return max(image.height // 40, 8)


def draw_colour_bar(image: Image.Image, title: str, low: str, high: str) -> None:
    """Draws the colours of a quantity in the lower right corner: its title with unit above, its ends below."""
    left, top, right, bottom = bar_box(image)
    size = _bar_text(image)
    colours = (ramp(np.linspace(0.0, 1.0, right - left)) * 255.0 + 0.5).astype(np.uint8)
    image.paste(Image.fromarray(np.broadcast_to(colours, (bottom - top, right - left, 3)).copy()), (left, top))
    ImageDraw.Draw(image).rectangle((left - 1, top - 1, right, bottom), outline=TEXT)
    draw_text(image, (min(left, right - text_width(title, size)), top - 3 * size // 2), title, size)
    draw_text(image, (left, bottom + size // 4), low, size)
    draw_text(image, (right - text_width(high, size), bottom + size // 4), high, size)


def draw_text(image: Image.Image, at: tuple[int, int], text: str, size: int) -> None:
    """Draws text with its upper left corner at `at`; without other fonts, in PIL's own small font, enlarged."""
    font = _font(size)
    if font is not None:
        ImageDraw.Draw(image).text(at, text, fill=TEXT, font=font, stroke_width=size // HALO, stroke_fill=PAPER)
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
