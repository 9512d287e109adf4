"""The man in the middle of one session: forwards both ways and does one thing wrong, once."""
from __future__ import annotations

import selectors
import socket
import time
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

from . import wire

BOTH = SHELL, RIGID = "shell", "rigid"  # whose bytes
PACE_S = 0.02       # between two helpings of a slow reader
LEAST_HELPING = 16  # [bytes]; a heartbeat goes into one, so that they do not pile up


@dataclass
class Side:
    """One connection, and what comes from it."""
    name: str
    socket: socket.socket | None = None
    came: wire.Splitter = field(default_factory=wire.Splitter)
    waiting: deque[bytes] = field(default_factory=deque)  # for the other side, when it is read slowly
    closed: bool = False  # by the process
    slow: int = 0  # helpings in which a message is read; 0: at once


class Relay:
    """Listens where the shell connects to, connects to where the rigid process is bound.

    `on_message(side, payload)` says what goes on in place of a message: None for as it came, else raw pieces.
    """

    def __init__(self, shell_path: Path, rigid_path: Path,
                 on_message: Callable[[str, bytes], list[bytes] | None]) -> None:
        self._rigid_path = rigid_path
        self._on_message = on_message
        self._selector = selectors.DefaultSelector()
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listener.bind(str(shell_path))
        self._listener.listen(8)
        self._listener.setblocking(False)
        self._shell_path = shell_path
        self._listens = False
        self.sides = {name: Side(name) for name in BOTH}
        self.stands_still = False  # as a relay that is stopped: connections stay open, nothing comes
        self.helpings = 0  # that a slow reader took
        self._next_helping = 0.0
        self._had_both = False

    def watch(self, descriptor: int) -> None:
        """Makes `turn` return when this descriptor is ready, e.g. that of a process that ends."""
        self._selector.register(descriptor, selectors.EVENT_READ, descriptor)

    def unwatch(self, descriptor: int) -> None:
        self._selector.unregister(descriptor)

    def turn(self, seconds: float) -> None:
        """Waits for whatever happens next, at most so long, and does it."""
        if any(side.waiting for side in self.sides.values()):
            seconds = min(seconds, PACE_S)
        if not self._listens:
            seconds = min(seconds, PACE_S)
            if self._rigid_path.exists():  # before, a connection could only be closed again
                self._selector.register(self._listener, selectors.EVENT_READ, None)
                self._listens = True
        for key, _ in self._selector.select(seconds):
            if key.fileobj is self._listener:
                self._accept()
            elif isinstance(key.data, Side) and key.data.socket is not None and not self.stands_still:
                self._read(key.data)
        self._help()
        if any(side.closed and not side.waiting for side in self.sides.values()):
            self.cut()

    def _accept(self) -> None:
        connection, _ = self._listener.accept()
        if self._had_both or self.stands_still:
            connection.close()  # ZeroMQ connects again by itself; a session has one connection
            return
        rigid = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            rigid.connect(str(self._rigid_path))
        except OSError:  # not bound yet
            connection.close()
            rigid.close()
            return
        self._had_both = True
        for name, s in ((SHELL, connection), (RIGID, rigid)):
            self.sides[name].socket = s
            self._selector.register(s, selectors.EVENT_READ, self.sides[name])

    def _read(self, side: Side) -> None:
        assert side.socket is not None
        try:
            data = side.socket.recv(1 << 20)
        except ConnectionResetError:
            data = b""
        if not data:
            self._selector.unregister(side.socket)
            side.closed = True
            return
        for payload, raw in side.came.feed(data):
            instead = None if payload is None else self._on_message(side.name, payload)
            for piece in [raw] if instead is None else instead:
                self._send(side, piece)
            if self.stands_still or side.socket is None:
                return

    def _send(self, side: Side, data: bytes) -> None:
        if side.slow or side.waiting:
            share = max(LEAST_HELPING, -(-len(data) // max(1, side.slow)))
            side.waiting.extend(data[i:i + share] for i in range(0, len(data), share))
        else:
            self._write(side, data)

    def _write(self, side: Side, data: bytes) -> None:
        other = self.sides[RIGID if side.name == SHELL else SHELL]
        if other.socket is None:
            return
        try:
            other.socket.sendall(data)
        except (BrokenPipeError, ConnectionResetError):  # it has gone; its end is read soon
            pass

    def _help(self) -> None:
        now = time.monotonic()
        if now < self._next_helping:
            return
        for side in self.sides.values():
            if side.waiting:
                self._write(side, side.waiting.popleft())
                self.helpings += 1
        self._next_helping = now + PACE_S

    def stand_still(self) -> None:
        """From now on nothing is read, written or closed."""
        self.stands_still = True
        for side in self.sides.values():
            if side.socket is not None and not side.closed:
                self._selector.unregister(side.socket)

    def go_on(self) -> None:
        """Ends `stand_still`, and forwards the bytes that have piled up."""
        self.stands_still = False
        for side in self.sides.values():
            if side.socket is not None and not side.closed:
                self._selector.register(side.socket, selectors.EVENT_READ, side)

    def send_and_cut(self, side: str, data: bytes) -> None:
        """Sends on what `side` has begun to say, then closes both connections."""
        self._write(self.sides[side], data)
        self.cut()

    def cut(self) -> None:
        """Closes both connections, as happens to both where one side closes its own."""
        for side in self.sides.values():
            if side.socket is not None:
                if not self.stands_still and not side.closed:
                    self._selector.unregister(side.socket)
                side.socket.close()
                side.socket = None
            side.closed = False

    def close(self) -> None:
        self.cut()
        self._listener.close()
        self._shell_path.unlink()
        self._selector.close()
