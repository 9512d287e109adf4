"""The private folder of the ipc socket: 0700, fresh for every run, always removed."""
from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
import time
from pathlib import Path

from ..errors import CommandError

PREFIX = "sunder-link-"  # of no other temporary folder: an empty one of that name is swept up
LONGEST_SOCKET_PATH = 100  # [bytes]; the system's limit is 107
NAME_BYTES = 32            # of the path below the folder: /PREFIX, a random part, /link
STALE_AFTER_S = 60.0       # an unlocked folder younger than this may be one that is just being made


class SocketDir:
    """Context manager: makes the folder, holds a lock on it, removes it.

    A launcher that was killed with SIGKILL leaves its folder; the next one sweeps it up.
    """

    def __init__(self) -> None:
        """Makes the folder. Raises CommandError where no place is suitable."""
        self.path, self._named = _made()
        self._handle = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY)
        fcntl.flock(self._handle, fcntl.LOCK_EX)

    @property
    def endpoint(self) -> str:
        """What both processes get as --endpoint."""
        return f"ipc://{self._named}/link"

    def __enter__(self) -> "SocketDir":
        return self

    def __exit__(self, *exception: object) -> None:
        shutil.rmtree(self.path, ignore_errors=True)
        os.close(self._handle)


def _made() -> tuple[Path, str]:
    """A new folder in the first place that can be written to and leaves room for the socket's name, and its name for both
    processes. In the present folder, the last place, that is a relative one: it is short, and both processes start here.
    Raises CommandError."""
    tried = []
    for place in (os.environ.get("TMPDIR"), os.environ.get("XDG_RUNTIME_DIR"), "/tmp", "/dev/shm", "/var/tmp", "."):
        if not place or not (os.path.isabs(place) or place == "."):
            continue
        if len(os.fsencode(place)) + NAME_BYTES > LONGEST_SOCKET_PATH:
            tried.append(f"{place} (too long for a socket's name)")
            continue
        try:
            _sweep(Path(place))
            path = Path(tempfile.mkdtemp(prefix=PREFIX, dir=place)).absolute()
        except OSError as error:
            tried.append(f"{place} ({error.strerror})")
            continue
        return path, path.name if place == "." else str(path)
    raise CommandError(f"no place for the socket of a run: {', '.join(tried)}; set TMPDIR to a folder of your own with a "
                       f"path of at most {LONGEST_SOCKET_PATH - NAME_BYTES} bytes")


def _sweep(parent: Path) -> None:
    """Removes socket folders of this user whose launcher is gone (nobody holds the lock)."""
    for path in parent.glob(PREFIX + "*"):
        try:
            status = path.lstat()
            if (status.st_uid != os.getuid() or status.st_mode & 0o170777 != 0o040700
                    or time.time() - status.st_mtime < STALE_AFTER_S
                    or any(entry.name != "link" for entry in path.iterdir())):  # somebody else's
                continue
            handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        except OSError:
            continue
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(path, ignore_errors=True)
        except OSError:
            pass  # in use
        finally:
            os.close(handle)
