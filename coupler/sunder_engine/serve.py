"""The command line of an engine's program, and its one session."""
from __future__ import annotations

import argparse
import ctypes
import math
import os
import signal
import sys
from typing import Callable

from .engine import BAD_INPUT, PEER_LOST, Engine
from .session import Session
from .wire import CONNECT_S, Lost, Wire

PR_SET_PDEATHSIG = 1  # of linux/prctl.h


def main(make: Callable[[], Engine], arguments: list[str] | None = None) -> int:
    """Serves one session with the engine that `make` makes; returns the exit status, and says on stderr why it is not 0."""
    parser = argparse.ArgumentParser(description="Serves one session of Sunder with a rigid-body engine.")
    parser.add_argument("--endpoint", required=True, metavar="ADDRESS", help="ipc://PATH or tcp://127.0.0.1:PORT, to bind")
    parser.add_argument("--engine", metavar="NAME", help="taken and ignored")
    parser.add_argument("--die-with-parent", action="store_true", help="ends when the process that started this one does")
    given = parser.parse_args(arguments)
    parent = os.getppid()
    if given.die_with_parent:
        _die_with_parent()
    try:
        # one that ends with its parent waits for as long as that lives, which watches the other side too
        patient = given.die_with_parent and given.endpoint.startswith("ipc://")
        wire = Wire(given.endpoint, lambda: not given.die_with_parent or os.getppid() == parent,
                    math.inf if patient else CONNECT_S)
    except (OSError, ValueError) as error:
        return _told(f"bad_endpoint: --endpoint {given.endpoint}: {error}", BAD_INPUT)
    try:
        return _serve(wire, Session(make()))
    except Lost as error:
        return _told(f"peer_lost: {error}", PEER_LOST)
    finally:
        wire.close()


def _die_with_parent() -> None:
    """Has the system end this process with its parent, whatever it does then. Elsewhere than on Linux nothing happens."""
    try:
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    except (OSError, AttributeError):
        pass


def _serve(wire: Wire, session: Session) -> int:
    while session.status is None:
        reply = session.answer(wire.receive())
        if reply is not None:
            wire.send(reply)
    return _told(session.failure, session.status)


def _told(why: str, status: int) -> int:
    if why:
        print(f"{os.path.basename(sys.argv[0])}: {why}", file=sys.stderr, flush=True)
    return status
