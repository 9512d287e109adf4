"""`sunder replay`: a recorded session, played to one of its two sides."""
from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from ..errors import BAD_INPUT, CHECK_FAILED, DONE, PEER_LOST, CommandError, how_it_ended
from ..launch import engines
from ..launch.build import ensure_built
from ..launch.needs import built_for
from ..launch.run import RECORD_FILE, Job
from ..launch.socket_dir import SocketDir
from .parser import Subparsers, add_choice, add_command, add_run_folder

NAME = "replay"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder replay`."""
    parser = add_command(
        subparsers, NAME, "play a recorded run to one of its two sides alone",
        "Exit status 0 where that side says what was recorded, to the bit; else 1 and the first difference.")
    add_run_folder(parser, "folder of a run that was made with --record")
    add_choice(parser, "--side", ("shell", "rigid"), "who is played to (default: shell)", "shell")
    parser.add_argument("--rigid", metavar="ENGINE", help="with --side rigid: another engine than the recorded one")
    parser.add_argument("--keys", metavar="DIR", type=Path, help="with --rigid tcp://HOST:PORT: as for 'sunder run'")


def run(arguments: argparse.Namespace) -> int:
    """Plays the recording; returns the exit status. Raises CommandError."""
    job = Job.read(arguments.folder)
    recording = arguments.folder / RECORD_FILE
    if not recording.is_file():
        raise CommandError(f"{recording}: there is none; make the run with --record")
    if arguments.side == "shell":
        if arguments.rigid or arguments.keys:
            raise CommandError("--rigid and --keys are for --side rigid; leave them out")
        return _replay_shell(job, recording)
    return _replay_rigid(arguments.rigid or job.engine, recording, arguments.keys)


def _replay_shell(job: Job, recording: Path) -> int:
    executables = built_for(job.scene)
    with tempfile.TemporaryDirectory(prefix="replay-sunder-") as out:
        threads = ["--threads", job.threads] if job.threads else []
        status = subprocess.run([str(executables.shell), *job.shell_arguments(), *threads, "--out", out, "--quiet",
                                 "--replay", str(recording)], check=False).returncode
    if status == DONE:
        print("the fracture process asks what was recorded, to the bit")
    return status


def _replay_rigid(engine: str, recording: Path, keys: Path | None) -> int:
    executables = ensure_built()
    # What was recorded is a session; the same engine has one of its own.
    rigid = engines.resolve(engines.in_process(engine) or engine, executables)
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
                                     *(["--rigid-process", str(server.pid)] if server is not None else []),
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
