"""`sunder new`: a scene to start from."""
from __future__ import annotations

import argparse
import re
import shutil
from pathlib import Path

from ..errors import BAD_INPUT, DONE, CommandError
from ..launch.shipped import ENDING, FOLDERS, SCENES
from ..words import own_command
from .parser import Subparsers, add_command, need_scene

NAME = "new"
STARTER = """\
# A pane of glass, held along its border, hit by a steel ball. Lengths are metres, times seconds, z points up.
name: "{name}"
end_time_s: 0.3    # what is simulated
window_s: 5e-5     # the two processes exchange once per window
settle_window_s: 1e-3  # the same once cracking has ended and only rigid pieces move

materials {{
  name: "glass"
  preset: SODA_LIME_GLASS  # density, stiffness, fracture_energy and how cracks run; a field of your own replaces its
  strength: 60e6           # [Pa]; without it nothing breaks
}}
materials {{ name: "steel" density: 7800 }}

shells {{
  name: "pane"
  material: "glass"
  thickness_m: 0.004
  plate {{                # a rectangle in the plane z = 0, moved by its pose
    size_x_m: 0.3
    size_y_m: 0.3
    elements_x: 30       # more elements: finer cracks, and a shorter time step
    elements_y: 30
    pose {{ position {{ z: 0.2 }} }}
  }}
  supports {{ edges: ALL kind: SIMPLY_SUPPORTED }}      # held, and free to turn, as in a soft gasket
}}

bodies {{
  name: "ball"
  material: "steel"
  sphere {{ radius_m: 0.02 }}
  pose {{ position {{ x: 0.01 y: -0.02 z: 0.2222 }} }}
  twist {{ linear {{ z: -8 }} }}                        # [m/s]
}}
bodies {{ name: "floor" half_space {{}} }}

fracture {{ mode: TIPS seed: 1 latest_freeze_s: 0.01 }}  # cracks run from their tips, driven by fracture_energy
output {{ frame_interval_s: 0.01 shell_frame_interval_s: 2.5e-4 }}
"""


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder new`."""
    parser = add_command(subparsers, NAME, "write a scene to start from",
                         "Writes NAME.textproto, a small commented scene, or a copy of another scene.\n"
                         "Refuses to replace a file.", "sunder new my_pane && sunder run my_pane.textproto")
    parser.add_argument("name", metavar="NAME", type=Path, help="name of the scene, with a folder before it if you like")
    parser.add_argument("--from", metavar="SCENE", dest="source", type=Path,
                        help="copy this scene and its files: a path, or a name that 'sunder scenes' lists")


def run(arguments: argparse.Namespace) -> int:
    """Writes the scene and says how to run it; returns the exit status. Raises CommandError."""
    target = arguments.name.with_name(arguments.name.name.removesuffix(ENDING) + ENDING)
    name = target.name.removesuffix(ENDING)
    _check_name(name)
    if arguments.source is None:
        _write(target, STARTER.format(name=name), [])
    else:
        source = _source(arguments.source)
        text = source.read_text(encoding="utf-8")
        _write(target, re.sub(r'^name: *("[^"\n]*"|\'[^\'\n]*\')', f'name: "{name}"', text, count=1, flags=re.MULTILINE),
               _assets(text, source))
    print(f"{target} is written; run it with: {own_command('run', target)}")
    return DONE


def _check_name(name: str) -> None:
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        better = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
        hint = f", e.g. {better}" if re.match(r"[a-z]", better) else ""
        raise CommandError(f"new: '{name}' is no name of a scene: it has small letters, digits and '_' and starts with a "
                           f"letter{hint}", BAD_INPUT)


def _source(given: Path) -> Path:
    """A file, or the shipped scene of that name. Raises CommandError where there is neither."""
    shipped = SCENES / given.parent / (given.name.removesuffix(ENDING) + ENDING)
    if not given.is_file() and str(given.parent) in (".", *FOLDERS) and shipped.is_file():
        return shipped
    need_scene(given)
    return given


def _assets(text: str, scene: Path) -> list[Path]:
    """The files beside the scene that it names."""
    named = re.findall(r'^[^#\n]*?\bpath: *"([^"\n]+)"', text, re.MULTILINE)
    return [scene.parent / name for name in dict.fromkeys(named)]


def _write(target: Path, text: str, assets: list[Path]) -> None:
    """Writes all or nothing. Raises CommandError where a file is there already or cannot be written."""
    copies = [(asset, target.parent / asset.name) for asset in assets
              if asset.resolve() != (target.parent / asset.name).resolve()]
    for path in (target, *(copy for _, copy in copies)):
        if path.exists():
            raise CommandError(f"{path}: is there already, and is not replaced; choose another name or folder", BAD_INPUT)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        for asset, copy in copies:
            shutil.copyfile(asset, copy)
        with target.open("x", encoding="utf-8") as sink:
            sink.write(text)
    except OSError as error:
        raise CommandError(f"cannot write {target}: {error.strerror or error}: {error.filename}", BAD_INPUT) from None
