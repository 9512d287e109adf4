"""What the parsers of all subcommands share: one class, one epilogue, the types of arguments."""
from __future__ import annotations

import argparse
import itertools
from pathlib import Path
from typing import Any, Callable, NoReturn, Sequence

from ..errors import BAD_INPUT, CommandError
from ..launch.shipped import ENDING, SCENES
from ..places import BUILD_DIR_VARIABLE
from ..report.scene_text import SCENE_COPY
from ..words import did_you_mean, nearest, own_command

# What `inspect` makes scenes of.
MESHES, CAD_FILES = (".obj", ".off", ".ply", ".stl", ".glb", ".gltf"), (".step", ".stp", ".igs", ".iges")
EPILOG = f"""\
exit status:
  0 done, 1 a check failed, 2 bad input (also: cannot install, build or write),
  3 one of the two processes was lost, 4 physics or ledger, 130 interrupted

environment:
  {BUILD_DIR_VARIABLE}  use the executables of this build folder (shell/sunder-shell,
                    rigid/sunder-rigid); nothing is built then, and no
                    Debian package is installed
"""

Subparsers = Any  # argparse._SubParsersAction, which has no public name


class Parser(argparse.ArgumentParser):
    """An ArgumentParser whose complaint is a CommandError that names the help and the nearest options."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self.options: list[str] = []
        self.valued: set[str] = set()  # those of them that take a value
        super().__init__(*arguments, **options)

    def add_argument(self, *names: Any, **options: Any) -> argparse.Action:
        """As ArgumentParser has it; remembers the long options."""
        long = [name for name in names if name.startswith("--")]
        self.options += long
        action = super().add_argument(*names, **options)
        if action.nargs != 0:
            self.valued.update(long)
        return action

    def check_options(self, arguments: Sequence[str]) -> None:
        """Raises CommandError for the first long option that there is not."""
        for argument in arguments:
            name = argument.partition("=")[0]
            if argument == "--" or "-" not in self.prefix_chars:
                return
            if name.startswith("--") and name not in self.options:
                raise CommandError(f"unknown option '{name}' of '{self.prog}'; {did_you_mean(name, self.options)} "
                                   f"(see '{self.prog} --help')", BAD_INPUT)

    def error(self, message: str) -> NoReturn:
        raise CommandError(f"{message}; see '{self.prog} --help'", BAD_INPUT)


def add_command(subparsers: Subparsers, name: str, short: str, description: str, example: str = "",
                **options: Any) -> Parser:
    """The parser of a subcommand. `short` is its line in 'sunder --help', `example` a command line."""
    epilog = f"example:\n  {example}\n\n{EPILOG}" if example else EPILOG
    return subparsers.add_parser(name, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False,
                                 help=short, description=description, epilog=epilog, **options)


def one_of(*choices: str) -> Callable[[str], str]:
    """The type of an argument that is one of these words."""
    def choice(text: str) -> str:
        if text not in choices:
            hint = f"; {did_you_mean(text, choices)}" if nearest(text, choices) else ""
            raise argparse.ArgumentTypeError(f"'{text}' is none of {', '.join(choices)}{hint}")
        return text
    return choice


def add_choice(parser: argparse.ArgumentParser, name: str, choices: Sequence[str], words: str,
               default: str | None = None) -> None:
    """Adds an option that takes one of a few words."""
    parser.add_argument(name, metavar="{" + ",".join(choices) + "}", type=one_of(*choices), default=default, help=words)


def setting(text: str) -> str:
    """Checks that an argument has the form PATH=VALUE."""
    path, equals, _ = text.partition("=")
    if not equals or not path:
        raise argparse.ArgumentTypeError(f"'{text}' is not PATH=VALUE, e.g. bodies[ball].twist.linear.z=-20")
    return text


def positive_seconds(text: str) -> str:
    """A positive number [s], as it was given."""
    try:
        good = 0.0 < float(text) < float("inf")
    except ValueError:
        good = False
    if not good:
        raise argparse.ArgumentTypeError(f"'{text}' is not a positive number of seconds")
    return text


def threads(text: str) -> str:
    """A whole number of at least 1, as it was given."""
    if not text.isascii() or not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least 1")
    return text


def count(text: str) -> int:
    """A whole number of at least 1."""
    return int(threads(text))


def number_within(text: str, least: float, most: float) -> float:
    """A number of `least` to `most`, both above 0."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if value != value:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of {least:g} to {most:g}")
    if not least <= value <= most:
        raise argparse.ArgumentTypeError(f"'{text}' is out of range: {least:g} to {most:g}")
    return value


def positive(text: str) -> float:
    """A number of 0.001 to 1000."""
    return number_within(text, 1e-3, 1e3)


def number_above_zero(text: str) -> float:
    """A finite number above zero."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number above 0")
    return value


def add_scene(parser: argparse.ArgumentParser, **options: Any) -> None:
    """Adds the argument SCENE."""
    parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (.textproto)", **options)


def add_settings(parser: argparse.ArgumentParser, words: str) -> None:
    """Adds the option --set, which may be repeated."""
    parser.add_argument("--set", metavar="PATH=VALUE", dest="settings", action="append", default=[], type=setting,
                        help=words)


def add_run_folder(parser: argparse.ArgumentParser, words: str = "folder of a run") -> None:
    """Adds the argument DIR, the folder of a run."""
    parser.add_argument("folder", metavar="DIR", type=Path, help=words)


def need_scene(path: Path) -> None:
    """Raises CommandError where there is no such file, or one of another kind; names the nearest scenes beside it and among those
    that ship."""
    if path.is_file():
        kind = "mesh" if path.suffix.lower() in MESHES else "CAD file" if path.suffix.lower() in CAD_FILES else ""
        if kind:
            unit = " (a mesh has no unit: add --unit 0.001 where it is in millimetres)" if kind == "mesh" else ""
            raise CommandError(f"{path}: is a {kind}, and no scene; this writes a scene of it: "
                               f"{own_command('inspect', path, '--scene', _free_name(path))}{unit}", BAD_INPUT)
        return
    if (path / SCENE_COPY).is_file():
        raise CommandError(f"{path}: is the folder of a run; its scene is {path / SCENE_COPY}", BAD_INPUT)
    wanted = path.name.removesuffix(ENDING)
    beside = {scene.name.removesuffix(ENDING): scene for scene in sorted(path.parent.glob("*" + ENDING))}
    shipped = {scene.name.removesuffix(ENDING): scene for scene in sorted(SCENES.glob("*" + ENDING))}
    found = {**shipped, **beside}
    near = [_as_typed(found[name]) for name in nearest(wanted, found)]
    hint = f"did you mean {' or '.join(near)}?" if near else "'sunder scenes' lists those that ship"
    raise CommandError(f"{path}: no such scene file; {hint}", BAD_INPUT)


def _free_name(file: Path) -> Path:
    """A scene beside the file that is not there yet."""
    names = (file.with_name(f"{file.stem}{f'_{k}' if k > 1 else ''}{ENDING}") for k in itertools.count(1))
    return next(name for name in names if not name.exists())


def _as_typed(path: Path) -> str:
    """The path as it is typed from here."""
    try:
        return str(path.resolve().relative_to(Path.cwd()))
    except ValueError:
        return str(path)
