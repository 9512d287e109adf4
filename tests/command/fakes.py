"""Stand-ins for sunder-shell and sunder-rigid: same arguments and exit statuses, synthetic frames.

The two talk over a plain unix socket at the path of the ipc endpoint: closing it is losing the peer.
What a fake does wrong is asked for in the environment:
  FAKE_SHELL, FAKE_RIGID  'deaf': ignores SIGTERM, SIGINT and the loss of its peer
  FAKE_RIGID 'refuse'     ends with status 2 at once
  FAKE_FRAMES             frames to write, 0.05 s apart (default 3: every one is drawn)
  FAKE_PIDS               folder in which each writes <name>.pid
"""
from __future__ import annotations

import os
import select
import signal
import socket
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parents[2]


def write_executables(build: Path) -> None:
    """Puts both fakes where a build folder has the real ones."""
    for folder, name, call in (("shell", "sunder-shell", "shell"), ("rigid", "sunder-rigid", "rigid")):
        (build / folder).mkdir(parents=True)
        path = build / folder / name
        path.write_text(f"#!/usr/bin/python3\nimport sys\nsys.path.insert(0, {str(HERE)!r})\n"
                        f"from tests.command.fakes import {call}\nsys.exit({call}(sys.argv[1:]))\n")
        path.chmod(0o755)


def _start(name: str, arguments: list[str]) -> Path:
    if os.environ.get("FAKE_PIDS"):
        Path(os.environ["FAKE_PIDS"], name + ".pid").write_text(str(os.getpid()))
    if os.environ.get("FAKE_" + name.upper()) == "deaf":
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, signal.SIG_IGN)
    endpoint = arguments[arguments.index("--endpoint") + 1]
    assert endpoint.startswith("ipc://") and "--die-with-parent" in arguments
    return Path(endpoint.removeprefix("ipc://"))


def rigid(arguments: list[str]) -> int:
    """0 after goodbye, 2 if told to refuse, 3 if the peer is lost; --check knows every engine but 'bulet'."""
    if "--list" in arguments:
        print("bullet ode")
        return 0
    if "--check" in arguments:
        return 2 if "bulet" in arguments else 0
    link = _start("rigid", arguments)
    if os.environ.get("FAKE_RIGID") == "refuse":
        print(f"--engine {arguments[1]}: no such engine")
        return 2
    assert link.parent.stat().st_mode & 0o777 == 0o700
    server = socket.socket(socket.AF_UNIX)
    server.bind(str(link))
    server.listen()
    peer, _ = server.accept()
    print("peer is here", flush=True)
    word = peer.recv(10)
    if os.environ.get("FAKE_RIGID") == "deaf":
        time.sleep(60)
    return 0 if word == b"bye" else 3


def shell(arguments: list[str]) -> int:
    """--check refuses a scene that has the word 'wrong' in it; else writes frames."""
    scene = arguments[arguments.index("--scene") + 1]
    if "--check" in arguments:
        if "wrong" in Path(scene).read_text():
            print(f"{scene}:1:1: wrong: unknown field; remove it", file=sys.stderr)
            return 2
        print("report")
        return 0
    from .synthetic import SyntheticRun
    link = _start("shell", arguments)
    interrupted: list[int] = []
    if os.environ.get("FAKE_SHELL") != "deaf":
        signal.signal(signal.SIGINT, lambda number, frame: interrupted.append(number))
    peer = socket.socket(socket.AF_UNIX)
    for _ in range(100):
        try:
            peer.connect(str(link))
            break
        except OSError:
            time.sleep(0.02)
    else:
        return 3
    count = int(os.environ.get("FAKE_FRAMES", "3"))
    run = SyntheticRun(Path(arguments[arguments.index("--out") + 1]), elements=10, fragments=12, count=count)
    status, result, k = "done", 0, 0
    for k in range(count):
        run.write(k)
        run.write_run_json("running", k)
        print(f"frame {k}", file=sys.stderr, flush=True)
        readable = select.select([peer], [], [], 0.05)[0]
        if readable and os.environ.get("FAKE_SHELL") == "deaf":
            time.sleep(60)
        if readable:
            run.write_run_json("failed", k)
            print("lost the peer", file=sys.stderr)
            return 3
        if interrupted:
            status, result = "interrupted", 130
            break
    run.write_run_json(status, k)
    peer.sendall(b"bye")
    return result
