"""The pictures that pages show, and how each is drawn: `sunder report pictures`."""
from __future__ import annotations

import contextlib
import io
import re
import sys
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from PIL import Image

from sunder_tools.command.main import main
from sunder_tools.errors import BAD_INPUT, CommandError
from sunder_tools.launch.build import ensure_built
from sunder_tools.launch.run import launch_once
from sunder_tools.pictures.contact_sheet import GAP, PAPER, write_contact_sheet
from sunder_tools.pictures.cycles import find_blender
from sunder_tools.pictures.render import frames_of, put_in_place
from sunder_tools.places import REPOSITORY
from sunder_tools.report.run_json import read_run
from sunder_tools.words import did_you_mean

DONE_RUN = "done"
QUALITY = 88   # of JPEG
RAYS = "192"   # of a pixel: with fewer, thin glass in front of glass is grainy
COLOURS = 256  # of PNG
KINDS: dict[str, dict[str, Any]] = {".png": {"format": "PNG", "optimize": True}, ".jpg": {"format": "JPEG", "quality": QUALITY, "optimize": True}}


@dataclass(frozen=True)
class Picture:
    """One picture of a page. It is of a run: the contact sheet, or stills beside one another; or a command makes it."""
    target: str                        # file in the repository
    scene: str = ""                    # file in the repository, or PAGE#FILE for a block of a page that is marked file=FILE
    times: tuple[float, ...] = ()      # [s] of stills, each of the frame that is nearest; none: the contact sheet
    options: tuple[str, ...] = ()      # of `sunder render`
    settings: tuple[str, ...] = ()     # of `sunder run`, --set
    width: int = 1000                  # [px]
    command: tuple[str, ...] = ()      # of `sunder`; {folder} is where it may write
    made: str = ""                     # file in that folder

    @property
    def name(self) -> str:
        """What --picture calls it."""
        return Path(self.target).stem

    @property
    def cycles(self) -> bool:
        """Whether Blender draws it."""
        return "--cycles" in self.options


def _plots(name: str) -> Picture:
    """The plots of a series."""
    return Picture(f"coupler/experiments/{name}.png", command=("sweep", f"coupler/experiments/{name}.py", "--out", "{folder}/series"),
                   made="series/plots.png")


def _trade(name: str, scene: str, *arguments: str) -> Picture:
    """The plot of a trade, with the arguments that its page names."""
    return Picture(f"coupler/experiments/{name}.png", made="trade/trade.png",
                   command=("trade", f"scenes/{scene}.textproto", *arguments, "--out", "{folder}/trade"))


PICTURES = (
    Picture("scenes/first.jpg", "README.md#first.textproto", (5e-4, 0.024, 0.163),
            ("--cycles", RAYS, "--size", "560x420", "--zoom", "1.3", "--no-caption"), width=1358),
    Picture("scenes/glass.png", "scenes/glass.textproto"),
    Picture("scenes/glass_cycles.jpg", "scenes/glass.textproto", (0.118,),
            ("--cycles", RAYS, "--view", "20,22", "--size", "760x580", "--no-caption"), width=760),
    Picture("scenes/bowl.png", "scenes/bowl.textproto"),
    Picture("scenes/rabbit.jpg", "scenes/rabbit.textproto", (0.0, 0.025),
            ("--cycles", RAYS, "--size", "748x630", "--zoom", "1.3", "--no-caption"), width=1000),
    Picture("scenes/vase.jpg", "scenes/vase.textproto", (2e-3, 0.055),
            ("--cycles", RAYS, "--size", "640x560", "--close", "--no-caption"), width=1288),
    Picture("scenes/windscreen.jpg", "scenes/cad/windscreen.textproto", (3e-3,),
            ("--cycles", RAYS, "--size", "1000x700", "--close", "--no-caption")),
    Picture("scenes/car_cycles.jpg", "scenes/impactor.textproto", (0.12,),
            ("--cycles", RAYS, "--size", "760x500", "--no-caption"), width=760),
    Picture("scenes/cloth_cycles.jpg", "scenes/paper/fig14.textproto", (0.16,),
            ("--cycles", RAYS, "--size", "760x540", "--no-caption"),
            ("end_time_s=0.16", "output.frame_interval_s=0.005", "shells[cloth].plate.elements_x=90", "shells[cloth].plate.elements_y=90"),
            width=760),
    Picture("scenes/impactor.png", "scenes/impactor.textproto"),
    Picture("rigid/engines.png", command=("validate", "coupling", "--case", "glass", "--known", "--pictures", "{folder}"),
            made="glass_engines.png", width=1280),
    *map(_plots, ("ballistic_limit", "energy_taken", "fragment_sizes", "radial_cracks")),
    _trade("trade_glass", "glass", "--until", "3e-4", "--seeds", "8", "--budget", "16", "--vary", "elements,window"),
    _trade("trade_intact_pane", "intact_pane", "--budget", "3"),
)


def draw_pictures(names: list[str], runs: Path | None, top: Path = REPOSITORY) -> list[str]:
    """Draws the pictures named, all where none is, into `top`; returns those that this machine cannot draw, which stay as they
    are. A run is taken from `runs`/NAME of its scene where it is there, and kept there. Raises CommandError."""
    known = {picture.name: picture for picture in PICTURES}
    for name in names:
        if name not in known:
            raise CommandError(f"--picture {name}: no page shows it; {did_you_mean(name, tuple(known))}", BAD_INPUT)
    left = []
    with tempfile.TemporaryDirectory(prefix="pictures-sunder-") as temporary:
        for picture in [known[name] for name in names] or PICTURES:
            print(f"sunder: {picture.target}", file=sys.stderr, flush=True)
            try:
                if picture.cycles:
                    find_blender()
            except CommandError as error:
                print(f"sunder: {picture.target} stays as it is: {error}", file=sys.stderr, flush=True)
                left.append(picture.name)
                continue
            image = _by_command(picture, Path(temporary)) if picture.command else _of_run(picture, runs or Path(temporary))
            target = top / picture.target
            target.parent.mkdir(parents=True, exist_ok=True)
            colours = image.convert("RGB")
            if target.suffix == ".png":
                colours = colours.quantize(COLOURS)  # a third of the bytes
            put_in_place(target, partial(colours.save, **KINDS[target.suffix]))
            print(f"written          {target}")
    return left


def scene_name(picture: Picture) -> str:
    """The name of the run's folder."""
    return Path(picture.scene.rpartition("#")[2]).stem


def _of_run(picture: Picture, runs: Path) -> Image.Image:
    folder = runs / scene_name(picture)
    if (folder / "frames.pvd").is_file() and read_run(folder).get("status") != DONE_RUN:
        raise CommandError(f"report: {folder}: the run there has not come to its end; remove the folder, and it is run anew")
    if not (folder / "frames.pvd").is_file():
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix="scene-sunder-") as temporary:
            launch_once(ensure_built(), scene_file(picture.scene, Path(temporary)), folder, list(picture.settings))
    if not picture.times:
        with Image.open(write_contact_sheet(folder)) as sheet:
            return _wide(sheet.convert("RGB"), picture.width)
    return _wide(_beside(_stills(folder, picture.times, picture.options)), picture.width)


def _stills(folder: Path, times: tuple[float, ...], options: tuple[str, ...]) -> list[Image.Image]:
    """Stills of the frames at these times, all with one camera."""
    frames = frames_of(folder, "report")
    numbers = [min(range(len(frames)), key=lambda k: abs(frames[k].time_s - time_s)) for time_s in times]
    with tempfile.TemporaryDirectory(prefix="stills-sunder-") as temporary:
        with contextlib.redirect_stdout(io.StringIO()):  # their place, which is temporary
            _sunder("render", str(folder), "--frames", ",".join(map(str, numbers)), "--out", temporary, *options)
        stills = []
        for number in numbers:
            with Image.open(Path(temporary) / f"still_{number:06d}.png") as still:
                stills.append(still.convert("RGB"))
        return stills


def scene_file(scene: str, temporary: Path) -> Path:
    """The scene's file; a block of a page is written to `temporary`. Raises CommandError where the page has none."""
    page, _, block = scene.rpartition("#")
    if not page:
        return REPOSITORY / scene
    found = re.search(rf"^```textproto file={re.escape(block)}(?: [^\n]*)?\n(.*?)^```$", (REPOSITORY / page).read_text(encoding="utf-8"),
                      re.MULTILINE | re.DOTALL)
    if found is None:
        raise CommandError(f"report: {page} has no block that is marked file={block}")
    (temporary / block).write_text(found[1], encoding="utf-8")
    return temporary / block


def _by_command(picture: Picture, temporary: Path) -> Image.Image:
    with tempfile.TemporaryDirectory(dir=temporary) as folder:
        _sunder(*(str(REPOSITORY / word) if word.startswith(("coupler/", "scenes/")) else word.replace("{folder}", folder)
                  for word in picture.command))
        with Image.open(Path(folder) / picture.made) as image:
            return image.convert("RGB")


def _sunder(*arguments: str) -> None:
    status = main(list(arguments), ["tests.commands"])
    if status:
        raise CommandError(f"report: 'sunder {' '.join(arguments)}' ended with status {status}")


def _beside(stills: list[Image.Image]) -> Image.Image:
    """Stills of one size in a row."""
    width, height = stills[0].size
    row = Image.new("RGB", (len(stills) * (width + GAP) - GAP, height), PAPER)
    for k, still in enumerate(stills):
        row.paste(still, (k * (width + GAP), 0))
    return row


def _wide(image: Image.Image, width: int) -> Image.Image:
    """The picture as wide as this; a smaller one stays."""
    if image.width <= width:
        return image
    return image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)
