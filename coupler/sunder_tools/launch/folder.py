"""Run folders: created exclusively, replaced only if a run made them, removed if the run left nothing."""
from __future__ import annotations

import errno
import fcntl
import json
import os
import time
from pathlib import Path

from ..errors import CommandError
from ..report.profile import PROFILE_FILE, PROFILE_PICTURE
from ..report.run_folder import not_a_run
from ..report.scene_text import SCENE_COPY

# What a run writes. Replacing a run removes these and nothing else that somebody put there.
RUN_FILES = ("run.json", "series.csv", "probes.csv", "shards.csv", "frames.pvd", "frames", "contact_sheet.png", "shell.log",
             "rigid.log", "command.json", "usage.json", "session.rec", "trace.json", PROFILE_FILE, PROFILE_PICTURE,
             SCENE_COPY, "checkpoint/state", "film.mp4", "film.gif", "stills", "export")
MADE = {"frames": "*.vtp*", "stills": "still_*.png", "export": "frame_*"}  # in the folders among them
TRIES = 20  # to take a folder that others make and remove at the same time
PROBE_BYTES = 1 << 20  # room that has to be there before anything is launched


class RunFolder:
    """A folder held by this run alone, by a lock on the folder itself (no file is left by it)."""

    def __init__(self, path: Path, created: list[Path]) -> None:
        self.path = path
        self._created = created  # outermost first
        self._handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if not os.path.samestat(os.fstat(self._handle), os.stat(path)):
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
        except BlockingIOError:
            os.close(self._handle)
            raise CommandError(_busy(path)) from None
        except OSError:  # another run that came to nothing has just removed the folder
            os.close(self._handle)
            raise

    def clear(self) -> None:
        """Removes the files of an earlier run."""
        for name in RUN_FILES:
            target = self.path / name
            if target.is_dir() and not target.is_symlink():
                for frame in target.glob(MADE.get(name, "*.vtp*")):  # what somebody else put there stays
                    frame.unlink()
                if not any(target.iterdir()):
                    target.rmdir()
            else:
                target.unlink(missing_ok=True)
        try:
            (self.path / "checkpoint").rmdir()
        except OSError:
            pass  # there is none, or somebody else's files are in it

    def has_frames(self) -> bool:
        """True if at least one frame was written."""
        return (self.path / "frames.pvd").exists() and any((self.path / "frames").glob("*.vtp"))

    def discard(self) -> None:
        """Removes what the run left, and the folders that were made for it, if nothing else is in them."""
        self.clear()
        for folder in reversed(self._created):
            try:
                folder.rmdir()
            except OSError:
                break

    def close(self) -> None:
        """Releases the lock on the folder."""
        os.close(self._handle)


def _busy(path: Path) -> str:
    return f"{path}: another run is writing there; choose another --out"


def _is_locked(path: Path) -> bool:
    """True if a run holds the folder."""
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return False
    except BlockingIOError:
        return True
    finally:
        os.close(handle)


def _is_run(path: Path) -> bool:
    """True if the folder's run.json is one that a run wrote."""
    try:
        return "schema" in json.loads((path / "run.json").read_text())
    except (OSError, ValueError, TypeError):
        return False


def refuse_foreign(path: Path) -> None:
    """Raises CommandError unless `path` can become a run folder: absent, empty, or an earlier run.

    A folder in which another run has just begun is told as such.
    """
    try:
        if path.exists() and not path.is_dir():
            raise CommandError(f"--out {path}: is a file, must be a folder")
        if path.is_dir() and any(path.iterdir()) and not _is_run(path):
            if _is_locked(path):  # it has not come to its run.json yet
                raise CommandError(_busy(path))
            raise CommandError(f"--out {path}: holds other files and no run.json of a run; give an empty or a new "
                               "folder, or one of an earlier run (which is then replaced)")
    except OSError as error:
        raise CommandError(f"--out {path}: {error.strerror}") from None


def refuse_own(out: Path, scene: Path) -> None:
    """Raises CommandError where the scene is a file of the run that is to be replaced."""
    if scene.resolve() == (out / SCENE_COPY).resolve():
        raise CommandError(f"--out {out}: its run would be replaced, and the scene {scene} is a file of it; give another --out, "
                           "or copy the scene elsewhere")


def open_folder(out: Path | None, scene: Path) -> RunFolder:
    """The folder of a new run: `out`, or runs/<scene>-<time>[-k], which no other run gets.

    Raises CommandError, and leaves nothing, where it cannot be made or written to.
    """
    created: list[Path] = []
    try:
        if out is None:
            path = _new_folder(Path("runs"), scene.stem, created)
            folder = RunFolder(path, created)
        else:
            path, folder = out, _take(out, created)
        try:
            if not os.access(path, os.W_OK | os.X_OK):  # before anything of an earlier run is removed
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
            folder.clear()
            _probe(path)
        except OSError:
            folder.close()
            raise
    except OSError as error:
        for made in reversed(created):
            try:
                made.rmdir()
            except OSError:
                pass
        where = error.filename or out or "runs"
        remedy = ("free some space or give --out on another disk" if error.errno in (errno.ENOSPC, errno.EDQUOT)
                  else "give --out a folder that you may write to")
        raise CommandError(f"cannot write the run folder: {where}: {error.strerror}; {remedy}") from None
    return folder


def _take(path: Path, created: list[Path]) -> RunFolder:
    """The folder at `path`, made where it is missing."""
    for attempt in range(TRIES):
        refuse_foreign(path)
        _make(path, created)
        try:
            return RunFolder(path, created)
        except FileNotFoundError:  # between the two another run, which came to nothing, has removed it
            if attempt == TRIES - 1:
                raise
    raise AssertionError("unreachable")


def reopen_folder(path: Path) -> RunFolder:
    """The folder of a run that is to go on; nothing in it is touched. Raises CommandError."""
    if not _is_run(path):
        raise CommandError(f"{path}: holds no run.json of a run; name the folder of a run that ended early")
    if not (path / "checkpoint" / "state").is_file():
        raise CommandError(f"{path}: holds no checkpoint: it ended before output.checkpoint_interval_s, or its engine "
                           "cannot do 'save_restore'; run the scene anew")
    return RunFolder(path, [])


def _make(path: Path, created: list[Path]) -> None:
    """mkdir -p that notes in `created` which folders are new."""
    for folder in [*reversed(path.parents), path]:
        try:
            folder.mkdir()
            created.append(folder)
        except FileExistsError:
            pass
        except OSError:
            if not folder.is_dir():  # e.g. '/' on a read-only disk says EROFS, not EEXIST
                raise


def _new_folder(parent: Path, name: str, created: list[Path]) -> Path:
    """parent/<name>-<time>, with -2, -3, ... where that is taken. mkdir decides who gets it."""
    _make(parent, created)
    stamp = time.strftime("%Y%m%d-%H%M%S")
    k = 1
    while True:
        path = parent / (f"{name}-{stamp}" if k == 1 else f"{name}-{stamp}-{k}")
        try:
            path.mkdir()
            created.append(path)
            return path
        except FileExistsError:
            k += 1
        except FileNotFoundError:  # another run that came to nothing has just removed `parent`
            _make(parent, created)


def _probe(path: Path) -> None:
    """Raises OSError where PROBE_BYTES cannot be written."""
    probe = path / f".probe-{os.getpid()}"
    try:
        with probe.open("wb") as sink:
            sink.write(bytes(PROBE_BYTES))
            sink.flush()
            os.fsync(sink.fileno())
    finally:
        probe.unlink(missing_ok=True)


def existing_run(path: Path, command: str) -> None:
    """Raises CommandError unless `path` is the folder of a run; frames may still be to come."""
    wrong = "" if _is_run(path) else not_a_run(path, "holds neither run.json nor frames.pvd")
    if wrong:
        raise CommandError(f"{command}: {wrong}")
