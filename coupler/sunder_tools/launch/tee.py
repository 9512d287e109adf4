"""Copies a process's stderr to the terminal and to a log, in a thread."""
from __future__ import annotations

import fcntl
import os
import sys
import termios
import threading
from pathlib import Path


class Tee:
    """Give `child_end` to the process as stderr, close it here with `started`, then `join`.

    If the user's stderr is a terminal the child gets a pseudo-terminal, so that it still rewrites
    its progress line. Of a line that was rewritten with '\\r' only the last state goes to the log.
    """

    def __init__(self, log: Path) -> None:
        self._terminal = sys.stderr.isatty()
        if self._terminal:
            self._own_end, self.child_end = os.openpty()
            modes = termios.tcgetattr(self.child_end)
            modes[1] &= ~termios.OPOST  # no '\n' -> '\r\n': the real terminal does that
            termios.tcsetattr(self.child_end, termios.TCSANOW, modes)
            try:
                size = fcntl.ioctl(sys.stderr.fileno(), termios.TIOCGWINSZ, bytes(8))
                fcntl.ioctl(self.child_end, termios.TIOCSWINSZ, size)
            except OSError:
                pass
        else:
            self._own_end, self.child_end = os.pipe()
        self._log = log.open("wb", buffering=0)
        self._last = b"\n"
        self._thread = threading.Thread(target=self._copy, daemon=True)

    def started(self) -> None:
        """Call this once the process has been started with `child_end`."""
        os.close(self.child_end)
        self._thread.start()

    def join(self, timeout_s: float = 2.0) -> None:
        """Waits until all was copied; a grandchild that keeps the pipe open is not waited for longer."""
        self._thread.join(timeout_s)
        if self._terminal and not self._last.endswith(b"\n"):
            self._show(b"\n")  # the progress line ended in the middle

    def _copy(self) -> None:
        line = b""
        while True:
            try:
                data = os.read(self._own_end, 65536)
            except OSError:  # a pseudo-terminal ends with EIO
                data = b""
            if not data:
                break
            self._show(data)
            *whole, line = (line + data).split(b"\n")
            line = line.rpartition(b"\r")[2] if not line.endswith(b"\r") else line
            for text in whole:
                self._keep(text.rstrip(b"\r").rpartition(b"\r")[2] + b"\n")
        if line:
            self._keep(line + b"\n")
        self._log.close()
        os.close(self._own_end)

    def _show(self, data: bytes) -> None:
        """Writes to the user's stderr, until that is closed."""
        self._last = data
        try:
            while data:
                data = data[os.write(2, data):]
        except OSError:
            pass

    def _keep(self, data: bytes) -> None:
        """Writes to the log; a full disk must not stop the messages."""
        try:
            self._log.write(data)
        except OSError:
            pass
