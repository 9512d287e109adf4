"""The folder of `sunder modes`: made where it is missing, emptied where earlier modes are in it."""
from __future__ import annotations

from pathlib import Path

from ..errors import BAD_INPUT, CommandError
from ..report.scene_text import SCENE_COPY

TABLE = "modes.json"
SHEET = "modes.png"


def open_modes_folder(path: Path) -> Path:
    """Returns the folder, without earlier modes. Raises CommandError where it holds other files, or cannot be written."""
    try:
        if path.is_dir() and any(path.iterdir()) and not (path / TABLE).is_file():
            raise CommandError(f"--out {path}: holds other files and no {TABLE}; give an empty or a new folder, or one of "
                               "earlier modes (which are then replaced)", BAD_INPUT)
        path.mkdir(parents=True, exist_ok=True)
        for name in (TABLE, SHEET, SCENE_COPY):
            (path / name).unlink(missing_ok=True)
        for folder in (path, *sorted(path.glob("mode_[0-9]*"))):
            _clear(folder)
            if folder != path and not any(folder.iterdir()):
                folder.rmdir()
    except OSError as error:
        raise CommandError(f"--out {error.filename or path}: {error.strerror}; give a folder that you may write to",
                           BAD_INPUT) from None
    return path


def _clear(folder: Path) -> None:
    """Removes frames, and nothing else that somebody put there."""
    (folder / "frames.pvd").unlink(missing_ok=True)
    frames = folder / "frames"
    for frame in frames.glob("*.vtp*"):
        frame.unlink()
    if frames.is_dir() and not any(frames.iterdir()):
        frames.rmdir()
