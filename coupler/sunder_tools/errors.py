"""Exit statuses of the command, and the error that carries one."""
from __future__ import annotations

import signal

DONE = 0
CHECK_FAILED = 1
BAD_INPUT = 2  # also: cannot install, cannot build, cannot write
PEER_LOST = 3
PHYSICS = 4
INTERRUPTED = 130


class CommandError(Exception):
    """Ends the command: the message goes to stderr, `status` is the exit status."""

    def __init__(self, message: str, status: int = BAD_INPUT) -> None:
        super().__init__(message)
        self.status = status


class Interrupted(Exception):
    """SIGINT, SIGTERM or SIGHUP arrived while no run was being watched."""


def how_it_ended(returncode: int) -> str:
    """A subprocess return code in words: 'was killed by SIGKILL' or 'ended with status 3'."""
    if returncode >= 0:
        return f"ended with status {returncode}"
    try:
        name = signal.Signals(-returncode).name
    except ValueError:
        name = f"signal {-returncode}"
    return f"was killed by {name}"
