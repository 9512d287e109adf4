"""Both sides of a ZeroMQ PAIR socket for one session on this machine: ZMTP 3.0 without keys, by sockets alone."""
from __future__ import annotations

import os
import re
import socket
import time
from typing import Callable

GREETING = b"\xff" + bytes(8) + b"\x7f" + b"\x03\x00" + b"NULL".ljust(20, b"\0") + bytes(32)
READY = b"\x05READY" + b"\x0bSocket-Type" + (4).to_bytes(4, "big") + b"PAIR"
MORE, LONG, COMMAND = 1, 2, 4  # flags of a frame
MOST_BYTES = 256 << 20         # of a message
CONNECT_S = 120.0              # for the other side to come
RETRY_S = 0.02                 # between two tries to connect
LOOK_S = 0.5                   # between two looks at whether to go on waiting
LAST_WORDS_S = 1.0             # for the other side to read the last reply and to close


class Lost(Exception):
    """The other side is gone, did not come, or is none of ours."""


def _address(endpoint: str) -> tuple[str, int]:
    """The path of ipc://PATH and 0, or '' and the port of tcp://127.0.0.1:PORT. Raises ValueError."""
    tcp = re.fullmatch(r"tcp://127\.0\.0\.1:([0-9]{1,5})", endpoint)
    if not endpoint.startswith("ipc://") and not tcp:
        raise ValueError(f"--endpoint {endpoint}: use ipc://PATH or tcp://127.0.0.1:PORT")
    return ("", int(tcp[1])) if tcp else (endpoint.removeprefix("ipc://"), 0)


class _Messages:
    """Messages over one connection. `go_on` is asked while it waits: False ends the waiting, for which `gone` says why."""

    def __init__(self, other: str, gone: str, go_on: Callable[[], bool]) -> None:
        self._other, self._gone, self._go_on = other, gone, go_on
        self._connection: socket.socket | None = None

    def _open(self) -> None:
        """Gets the connection where there is none yet. Raises Lost."""
        raise NotImplementedError

    def receive(self) -> bytes:
        """The next message. Raises Lost."""
        while self._connection is None:
            self._open()
        while True:
            flags, payload = self._frame(self._connection)
            if flags & MORE:
                raise Lost("a message of several frames; the exchange has none")
            if not flags & COMMAND:
                return payload
            if payload.startswith(b"\x04PING"):
                self._write(self._connection, COMMAND, b"\x04PONG" + payload[7:])  # two bytes of it are a time

    def send(self, message: bytes) -> None:
        """Sends a message. Raises Lost."""
        while self._connection is None:
            self._open()
        self._write(self._connection, 0, message)

    def _shake_hands(self, connection: socket.socket) -> None:
        """Raises Lost where the other side is no PAIR socket without keys."""
        connection.settimeout(LOOK_S)
        self._put(connection, GREETING)
        greeting = self._read(connection, len(GREETING))
        if greeting[0] != 0xFF or greeting[9] & 1 == 0 or greeting[10] < 3 or greeting[12:32].rstrip(b"\0") != b"NULL":
            raise Lost("it does not speak ZMTP 3 without keys")
        self._write(connection, COMMAND, READY)
        flags, payload = self._frame(connection)
        if not flags & COMMAND or not payload.startswith(b"\x05READY"):
            raise Lost("a handshake without READY")

    def _frame(self, connection: socket.socket) -> tuple[int, bytes]:
        flags = self._read(connection, 1)[0]
        size = int.from_bytes(self._read(connection, 8 if flags & LONG else 1), "big")
        if size > MOST_BYTES or flags > MORE | LONG | COMMAND:
            raise Lost(f"a message of {size} bytes; {MOST_BYTES} at most")
        return flags, self._read(connection, size)

    def _read(self, connection: socket.socket, size: int) -> bytes:
        got = bytearray()
        while len(got) < size:
            try:
                more = connection.recv(min(size - len(got), 1 << 20))
            except TimeoutError:
                if not self._go_on():
                    raise Lost(self._gone) from None
                continue
            except OSError:
                more = b""
            if not more:
                raise Lost(f"{self._other} is gone: its connection closed without a goodbye")
            got += more
        return bytes(got)

    def _write(self, connection: socket.socket, flags: int, payload: bytes) -> None:
        head = bytes([flags, len(payload)]) if len(payload) < 256 else bytes([flags | LONG]) + len(payload).to_bytes(8, "big")
        self._put(connection, head + payload)

    def _put(self, connection: socket.socket, data: bytes) -> None:
        left = memoryview(data)
        while left:
            try:
                left = left[connection.send(left):]
            except TimeoutError:
                if not self._go_on():
                    raise Lost(self._gone) from None
            except OSError:
                raise Lost(f"{self._other} is gone: it takes no messages") from None


class Wire(_Messages):
    """The binding side: an engine's. Accepts one connection and keeps it."""

    def __init__(self, endpoint: str, go_on: Callable[[], bool] = lambda: True, connect_s: float = CONNECT_S) -> None:
        """Binds. The shell process has `connect_s` seconds to come; infinite: no limit. Raises ValueError for an address that
        cannot be, OSError where it cannot be bound."""
        super().__init__("the shell process", "the process that started this one is gone", go_on)
        self._path, port = _address(endpoint)
        if self._path:
            self._listener = socket.socket(socket.AF_UNIX)
            self._listener.bind(self._path)
        else:
            self._listener = socket.create_server(("127.0.0.1", port))
        self._listener.listen(4)
        self._listener.settimeout(LOOK_S)
        self._connect_s = connect_s

    def close(self) -> None:
        """Waits until the other side has read all and closes, and takes the socket's file away."""
        if self._connection is not None:
            end = time.monotonic() + LAST_WORDS_S
            try:
                self._connection.shutdown(socket.SHUT_WR)
                self._connection.settimeout(LAST_WORDS_S)
                while time.monotonic() < end and self._connection.recv(1 << 16):
                    pass
            except OSError:  # it has closed already
                pass
            self._connection.close()
        self._listener.close()
        if self._path:
            try:
                os.unlink(self._path)
            except FileNotFoundError:
                pass

    def _open(self) -> None:
        """One try to get a connection. One that leaves during the handshake is not the shell's: another may come."""
        waited_s = 0.0  # looks are counted: while this process is stopped, no time passes
        while True:
            try:
                connection, _ = self._listener.accept()
                break
            except TimeoutError:
                waited_s += LOOK_S
                if not self._go_on():
                    raise Lost(self._gone) from None
                if waited_s >= self._connect_s:
                    raise Lost(f"the shell process did not connect within {self._connect_s:g} s") from None
        try:
            self._shake_hands(connection)
        except Lost:
            connection.close()
            if not self._go_on():
                raise
            return
        self._connection = connection


class Caller(_Messages):
    """The connecting side: the shell process's. Sends first."""

    def __init__(self, endpoint: str, go_on: Callable[[], bool] = lambda: True) -> None:
        """Raises ValueError for an address that cannot be."""
        super().__init__("the engine", "the engine's process has ended", go_on)
        self._path, self._port = _address(endpoint)

    def close(self) -> None:
        """Closes the connection."""
        if self._connection is not None:
            self._connection.close()

    def _open(self) -> None:
        for _ in range(int(CONNECT_S / RETRY_S)):
            connection = socket.socket(socket.AF_UNIX if self._path else socket.AF_INET)
            try:
                connection.connect(self._path or ("127.0.0.1", self._port))
                self._shake_hands(connection)
                self._connection = connection
                return
            except OSError:  # it has not bound yet
                connection.close()
            except Lost:
                connection.close()
                raise
            if not self._go_on():
                raise Lost(self._gone)
            time.sleep(RETRY_S)
        raise Lost(f"the engine did not bind its endpoint within {CONNECT_S:.0f} s")
