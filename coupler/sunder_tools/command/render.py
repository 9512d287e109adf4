"""`sunder render`: stills or a film of a run."""
from __future__ import annotations

import argparse
import os
from pathlib import Path

from ..errors import BAD_INPUT, CommandError
from .parser import Subparsers, add_choice, add_command, add_run_folder, count, number_above_zero, positive

NAME = "render"
SAMPLES = 128  # rays a pixel of Cycles


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder render`."""
    parser = add_command(
        subparsers, NAME, "stills or a film of a run",
        "Writes six stills, or those of --frames, to DIR/stills. With --film it writes DIR/film.mp4, or an animated\n"
        "GIF where ffmpeg cannot be installed.", "sunder render runs/car --film --view 200,15 --colour speed")
    add_run_folder(parser)
    parser.add_argument("--film", action="store_true", help="a film of all frames, or of those of --frames")
    parser.add_argument("--sheet", action="store_true", help="draw contact_sheet.png again, and nothing else")
    parser.add_argument("--frames", metavar="LIST", help="all, numbers such as 0,5,10-20,last,\nor times such as 7.5ms or 10ms-20ms")
    parser.add_argument("--out", metavar="PATH", type=Path,
                        help="folder of the stills; file of the film, .mp4, .webm, .gif or\n.png (animated)")
    parser.add_argument("--size", metavar="WxH", type=_size, default=(1280, 720), help="pixels (default: 1280x720)")
    parser.add_argument("--view", metavar="VIEW", type=_view,
                        help="position of the eye: front, back, left, right, top, or\n"
                             "AZIMUTH,ELEVATION in degrees, from +x (default: oblique, from the side that is hit)")
    parser.add_argument("--zoom", metavar="F", type=positive, default=1.0, help="magnification (default: 1)")
    parser.add_argument("--close", action="store_true", help="fill the picture with the shell alone")
    add_choice(parser, "--colour", ("part", "damage", "fragment", "speed"),
               "quantity that colours the shell (default: part)", "part")
    parser.add_argument("--cycles", metavar="N", type=count, nargs="?", const=SAMPLES,
                        help="draw with Blender's Cycles: glass, metal and cloth by the\nscene's materials; N rays a pixel "
                             f"(default: {SAMPLES}); takes\nminutes a picture")
    add_choice(parser, "--backdrop", ("light", "dark"), "ground and sky of --cycles (default: light)")
    parser.add_argument("--no-caption", action="store_true", help="no time in the corner")
    parser.add_argument("--rate", "--fps", metavar="FPS", type=positive,
                        help="pictures a second of the film (default: it lasts six\nseconds, within 4 to 30; with --speed 24)")
    parser.add_argument("--speed", metavar="F", type=number_above_zero,
                        help="how fast time runs in the film, e.g. 0.1; pictures between\nframes are made (default: a picture a frame)")
    parser.add_argument("--jobs", metavar="N", type=count, default=os.cpu_count() or 1,
                        help="processes (default: as many as processors)")


def run(arguments: argparse.Namespace) -> int:
    """Draws; returns the exit status. Raises CommandError."""
    from ..pictures.look import Look
    from ..pictures.render import Shot, render
    if arguments.sheet and (arguments.film or arguments.frames or arguments.out):
        raise CommandError("--sheet goes with none of --film, --frames and --out", BAD_INPUT)
    if arguments.sheet and arguments.cycles:
        raise CommandError("--sheet: goes without --cycles", BAD_INPUT)
    if arguments.backdrop and not arguments.cycles:
        raise CommandError("--backdrop: goes with --cycles only", BAD_INPUT)
    if arguments.speed is not None and not arguments.film:
        raise CommandError("--speed: goes with --film only", BAD_INPUT)
    shot = Shot(arguments.size, arguments.view, arguments.zoom, arguments.close, not arguments.no_caption,
                Look(arguments.colour), arguments.cycles, *([arguments.backdrop] if arguments.backdrop else []))
    return render(arguments.folder, arguments.out, arguments.film, arguments.sheet, arguments.frames, shot,
                  arguments.rate, arguments.jobs, arguments.speed)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    numbers = [int(n) if n.isascii() and n.isdigit() and len(n) < 6 else 0 for n in (width, height)]
    if not all(32 <= n <= 7680 for n in numbers):
        raise argparse.ArgumentTypeError(f"'{text}' is no size, e.g. 1280x720; each of 32 to 7680 pixels")
    return numbers[0], numbers[1]


def _view(text: str) -> tuple[float, float]:
    from ..pictures.render import VIEWS, parse_view
    try:
        return parse_view(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no view: {', '.join(VIEWS)}, or AZIMUTH,ELEVATION in degrees "
                                         "(elevation of -89 to 89)") from None
