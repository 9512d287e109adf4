"""Running a helper program with its output in a log file."""
from __future__ import annotations

import os
import signal
import subprocess
import threading
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Callable, Iterator

from ..errors import Interrupted
from ..words import command_line


def run_logged(command: list[str], log: Path, cwd: Path | None = None,
               on_line: Callable[[str], None] | None = None) -> int:
    """Runs `command`, appends stdout and stderr to `log`, returns its exit status.

    `on_line` sees every line. On Ctrl-C or SIGTERM the program and its children get SIGINT, are
    waited for, and the interruption goes on upwards. So it is in a script that imports `sunder` and handles no signal.
    """
    # /usr/bin first: a cmake or ninja from a Python environment may not know Debian's packages.
    environment = {**os.environ, "PATH": "/usr/bin:/bin:" + os.environ.get("PATH", ""), "LC_ALL": "C.UTF-8"}
    with log.open("ab") as sink:
        sink.write(f"$ {command_line(command)}\n".encode())
        sink.flush()
        with _handled_here():
            process = subprocess.Popen(command, cwd=cwd, env=environment, stdin=subprocess.DEVNULL,
                                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
            assert process.stdout is not None
            try:
                for line in process.stdout:
                    sink.write(line)
                    sink.flush()  # whoever waits for this reads how far it is
                    if on_line:
                        on_line(line.decode(errors="replace").rstrip())
                return process.wait()
            except (KeyboardInterrupt, Interrupted):
                try:
                    os.killpg(process.pid, signal.SIGINT)
                except (ProcessLookupError, PermissionError):
                    pass
                process.wait()
                raise
            finally:
                process.stdout.close()


@contextmanager
def _handled_here() -> Iterator[None]:
    """Context: SIGTERM and SIGHUP raise Interrupted, where they would end this process at once and leave the program
    running."""
    mine = [number for number in (signal.SIGTERM, signal.SIGHUP)
            if threading.current_thread() is threading.main_thread() and signal.getsignal(number) is signal.SIG_DFL]

    def interrupt(number: int, frame: FrameType | None) -> None:
        del number, frame
        raise Interrupted

    for number in mine:
        signal.signal(number, interrupt)
    try:
        yield
    finally:
        for number in mine:
            signal.signal(number, signal.SIG_DFL)


def tail(log: Path, lines: int) -> str:
    """The last `lines` lines of a text file, '' if it cannot be read."""
    try:
        return "\n".join(log.read_text(errors="replace").splitlines()[-lines:])
    except OSError:
        return ""
