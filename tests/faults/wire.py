"""ZMTP 3 as it lies on the wire: a greeting of fixed length, then frames that are messages or commands.

The relay stands below ZeroMQ. A relay of two ZeroMQ sockets would itself refuse the damaged bytes that it has to forward.
"""
from __future__ import annotations

GREETING_BYTES = 64
MORE, LONG, COMMAND = 1, 2, 4  # flags of a frame


def frame(payload: bytes) -> bytes:
    """A whole message as one frame."""
    if len(payload) < 256:
        return bytes([0, len(payload)]) + payload
    return bytes([LONG]) + len(payload).to_bytes(8, "big") + payload


def head_of(size: int) -> bytes:
    """The head of a message of `size` bytes, of which nothing need follow."""
    return bytes([LONG]) + size.to_bytes(8, "big")


class Splitter:
    """Cuts the bytes of one direction into pieces: (payload or None, the bytes as they came)."""

    def __init__(self) -> None:
        self._bytes = b""
        self._greeted = 0

    def feed(self, data: bytes) -> list[tuple[bytes | None, bytes]]:
        """What `data` completes; None as payload for what is no message: the greeting, heartbeats, READY."""
        pieces: list[tuple[bytes | None, bytes]] = []
        if self._greeted < GREETING_BYTES:
            part = data[:GREETING_BYTES - self._greeted]
            self._greeted += len(part)
            pieces.append((None, part))
            data = data[len(part):]
        self._bytes += data
        while len(self._bytes) >= 2:
            flags = self._bytes[0]
            head = 9 if flags & LONG else 2
            if len(self._bytes) < head:
                break
            size = int.from_bytes(self._bytes[1:head], "big")
            if len(self._bytes) < head + size:
                break
            raw, self._bytes = self._bytes[:head + size], self._bytes[head + size:]
            if flags & MORE:
                raise ValueError("a message of several frames; the exchange has none")
            pieces.append((None if flags & COMMAND else raw[head:], raw))
        return pieces
