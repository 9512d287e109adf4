"""Text in pictures, with any available font."""
from __future__ import annotations

from PIL import Image, ImageDraw, ImageFont

TEXT = (38, 46, 54)


def _font(size: int) -> ImageFont.FreeTypeFont | None:
    for name in ("DejaVuSans.ttf", "LiberationSans-Regular.ttf", "FreeSans.ttf"):
        try:
            return ImageFont.truetype(name, size)
        except OSError:
            continue
    return None


def draw_text(image: Image.Image, at: tuple[int, int], text: str, size: int) -> None:
    """Draws text with its upper left corner at `at`; without other fonts, in PIL's own small font, enlarged."""
    font = _font(size)
    if font is not None:
        ImageDraw.Draw(image).text(at, text, fill=TEXT, font=font)
        return
    plain = ImageFont.load_default()
    text = text.encode("latin-1", "replace").decode("latin-1")  # the built-in font has only these characters
    mask = Image.new("L", plain.getbbox(text)[2:])
    ImageDraw.Draw(mask).text((0, 0), text, fill=255, font=plain)
    factor = max(size / 11.0, 1.0)
    mask = mask.resize((max(1, round(mask.width * factor)), max(1, round(mask.height * factor))), Image.BICUBIC)
    image.paste(Image.new("RGB", mask.size, TEXT), at, mask)
