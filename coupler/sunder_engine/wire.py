"""The binding side of a ZeroMQ PAIR socket for one session on this machine: ZMTP 3.0 without keys, by sockets alone."""
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
LOOK_S = 0.5                   # between two looks at whether to go on waiting
LAST_WORDS_S = 1.0             # for the other side to read the last reply and to close


class Lost(Exception):
    """The other side is gone, did not come, or is none of ours."""


class Wire:
    """Accepts one connection and keeps it. `go_on` is asked while it waits: False ends the waiting."""

    def __init__(self, endpoint: str, go_on: Callable[[], bool] = lambda: True) -> None:
        """Binds. Raises ValueError for an address that cannot be, OSError where it cannot be bound."""
        self._go_on = go_on
        self._path = ""
        self._connection: socket.socket | None = None
        tcp = re.fullmatch(r"tcp://127\.0\.0\.1:([0-9]{1,5})", endpoint)
        if endpoint.startswith("ipc://"):
            self._path = endpoint.removeprefix("ipc://")
            self._listener = socket.socket(socket.AF_UNIX)
            self._listener.bind(self._path)
        elif tcp:
            self._listener = socket.create_server(("127.0.0.1", int(tcp[1])))
        else:
            raise ValueError(f"--endpoint {endpoint}: use ipc://PATH or tcp://127.0.0.1:PORT")
        self._listener.listen(4)
        self._listener.settimeout(LOOK_S)

    def receive(self) -> bytes:
        """The next message. Raises Lost."""
        while self._connection is None:
            self._accept()
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
        assert self._connection is not None
        self._write(self._connection, 0, message)

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

    def _accept(self) -> None:
        """One try to get a connection. One that leaves during the handshake is not the shell's: another may come."""
        for _ in range(int(CONNECT_S / LOOK_S)):  # looks are counted: while this process is stopped, no time passes
            try:
                connection, _ = self._listener.accept()
                break
            except TimeoutError:
                if not self._go_on():
                    raise Lost("the process that started this one is gone") from None
        else:
            raise Lost(f"the shell process did not connect within {CONNECT_S:.0f} s")
        connection.settimeout(LOOK_S)
        try:
            self._put(connection, GREETING)
            greeting = self._read(connection, len(GREETING))
            if greeting[0] != 0xFF or greeting[9] & 1 == 0 or greeting[10] < 3 or greeting[12:32].rstrip(b"\0") != b"NULL":
                raise Lost("it does not speak ZMTP 3 without keys")
            self._write(connection, COMMAND, READY)
            flags, payload = self._frame(connection)
            if not flags & COMMAND or not payload.startswith(b"\x05READY"):
                raise Lost("a handshake without READY")
        except Lost:
            connection.close()
            if not self._go_on():
                raise
            return
        self._connection = connection

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
                    raise Lost("the process that started this one is gone") from None
                continue
            except OSError:
                more = b""
            if not more:
                raise Lost("the shell process is gone: its connection closed without a goodbye")
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
                    raise Lost("the process that started this one is gone") from None
            except OSError:
                raise Lost("the shell process is gone: it takes no messages") from None
