"""Commands about the rigid side alone: engines, serve, keys, replay."""
from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from . import engines
from .build import ensure_built
from .errors import BAD_INPUT, CHECK_FAILED, DONE, PEER_LOST, CommandError, how_it_ended
from .run import RECORD_FILE, Job
from .socket_dir import SocketDir


def dispatch(options: argparse.Namespace) -> int:
    """Runs one of the four; returns the exit status. Raises CommandError."""
    executables = ensure_built()
    if options.command == "engines":
        print(engines.table(executables))
        return DONE
    if options.command == "keys":
        return subprocess.run([str(executables.rigid), "--make-keys", str(options.folder)], check=False).returncode
    if options.command == "serve":
        return _serve(options)
    job = Job.read(options.folder)
    recording = options.folder / RECORD_FILE
    if not recording.is_file():
        raise CommandError(f"{recording}: there is none; make the run with --record")
    if options.side == "shell":
        if options.rigid or options.keys:
            raise CommandError("--rigid and --keys are for --side rigid; leave them out")
        return _replay_shell(job, recording)
    return _replay_rigid(options.rigid or job.engine, recording, options.keys)


def _serve(options: argparse.Namespace) -> int:
    rigid = engines.resolve(options.rigid, ensure_built())
    if not rigid.command:
        raise CommandError(f"--rigid {options.rigid}: is no engine that can be launched; give a name or a program")
    keys = ["--keys", str(options.keys)] if options.keys else []
    return subprocess.run([*rigid.command, "--endpoint", options.endpoint, *keys, "--die-with-parent"],
                          check=False).returncode


def _replay_shell(job: Job, recording: Path) -> int:
    executables = ensure_built()
    with tempfile.TemporaryDirectory(prefix="sunder-replay-") as out:
        threads = ["--threads", job.threads] if job.threads else []
        status = subprocess.run([str(executables.shell), *job.shell_arguments(), *threads, "--out", out, "--quiet",
                                 "--replay", str(recording)], check=False).returncode
    if status == DONE:
        print("the fracture process asks what was recorded, to the bit")
    return status


def _replay_rigid(engine: str, recording: Path, keys: Path | None) -> int:
    executables = ensure_built()
    rigid = engines.resolve(engine, executables)
    if rigid.in_process:  # what was recorded is a session; the same engine has one of its own
        rigid = engines.resolve(rigid.in_process, executables)
    if keys and not rigid.endpoint:
        raise CommandError(f"--keys {keys}: is for an engine that waits at an address; leave it out")
    with SocketDir() as socket:
        endpoint = rigid.endpoint or socket.endpoint
        server = None
        if rigid.command:
            server = subprocess.Popen([*rigid.command, "--endpoint", endpoint, "--die-with-parent"],
                                      stdin=subprocess.DEVNULL)
        try:
            status = subprocess.run([str(executables.shell), "replay-rigid", str(recording), "--endpoint", endpoint,
                                     *(["--keys", str(keys)] if keys else [])],
                                    check=False).returncode
        finally:
            if server is not None:
                try:
                    server.wait(timeout=2.0)
                except subprocess.TimeoutExpired:
                    server.kill()
                    server.wait()
    if status < 0:
        raise CommandError(f"sunder-shell {how_it_ended(status)}", PEER_LOST)
    if status not in (DONE, CHECK_FAILED, BAD_INPUT, PEER_LOST):
        print(f"sunder: replay ended with status {status}", file=sys.stderr)
    return status
