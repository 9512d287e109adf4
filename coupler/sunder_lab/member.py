"""One run of a series: a folder with its scene, run by a process of its own, wherever that is.

    cd coupler && python3 -m sunder_lab.member FOLDER

The folder is all that this process knows, so that a machine that shares it can run it. It holds `scene.textproto` and
`member.json`; `run/` and at last `outcome.json` come to be. A member with an outcome of 'done' is not run again.
"""
from __future__ import annotations

import ctypes
import fcntl
import hashlib
import json
import os
import shutil
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sunder_tools.errors import BAD_INPUT, DONE, INTERRUPTED, CommandError, Interrupted
from sunder_tools.launch.build import ensure_built
from sunder_tools.launch.run import Job, read_usage, run_scene
from sunder_tools.pictures.frames import BODIES, SHELL, list_frames
from sunder_tools.report.run_json import read_run

from .scene import SCENE_FILE, Scene

MEMBER_FILE, OUTCOME_FILE, LOG_FILE, RUN_FOLDER = "member.json", "outcome.json", "member.log", "run"
KEEP = ("last", "all", "none")
DIE_WITH_PARENT = "--die-with-parent"
PR_SET_PDEATHSIG = 1  # <sys/prctl.h>


@dataclass(frozen=True)
class Member:
    """What identifies a run: its scene and its engine. Threads and what is kept do not."""
    scene: Scene
    engine: str = "bullet"

    def identity(self) -> str:
        """16 hexadecimal digits; results are the same to the bit for the same."""
        text = json.dumps([self.scene.identity(), self.engine])
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def prepare(self, folder: Path, threads: int, keep: str) -> None:
        """Writes what the process needs; nothing that a run there has left is touched."""
        self.scene.save(folder)
        write_atomically(folder / MEMBER_FILE, {"engine": self.engine, "threads": threads, "keep": keep})


def write_atomically(path: Path, value: Any) -> None:
    """JSON, whole or not at all."""
    part = path.with_name(f".{path.name}.{os.getpid()}")
    part.write_text(json.dumps(value, indent=1) + "\n")
    os.replace(part, path)


def read_json(path: Path) -> dict[str, Any]:
    """{} where it is not there or no object."""
    try:
        value = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return value if isinstance(value, dict) else {}


def outcome(folder: Path) -> dict[str, Any]:
    """status 'done' or 'failed', error, wall_s, processor_s of both processes, host, program; {} where the member has not
    ended."""
    return read_json(folder / OUTCOME_FILE)


def is_done(folder: Path) -> bool:
    """True where it need not be run."""
    return outcome(folder).get("status") == "done"


def run_member(folder: Path) -> int:
    """Runs what the folder says, unless it is done; the exit status is that of `sunder run`. Waits while another does."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    try:
        if is_done(folder):
            return DONE
        (folder / OUTCOME_FILE).unlink(missing_ok=True)
        kept = read_json(folder / MEMBER_FILE)
        start = time.time()
        shutil.rmtree(folder / RUN_FOLDER, ignore_errors=True)
        error = ""
        try:
            job = Job(folder / SCENE_FILE, str(kept["engine"]), threads=str(kept["threads"]))
            status = run_scene(job, folder / RUN_FOLDER, quiet=True)
            if status != DONE:
                error = (read_run(folder / RUN_FOLDER).get("error") or {}).get("message") or f"ended with status {status}"
        except CommandError as refused:
            status, error = refused.status, str(refused)
            print(f"sunder: {refused}", file=sys.stderr)
        except (KeyError, OSError) as broken:
            status, error = BAD_INPUT, f"{type(broken).__name__}: {broken}"
        if status == INTERRUPTED:  # by the user or by the end of who started it: not an outcome of the scene
            return INTERRUPTED
        thin_out(folder / RUN_FOLDER, str(kept.get("keep", KEEP[0])))
        write_atomically(folder / OUTCOME_FILE, {
            "status": "done" if status == DONE else "failed", "exit": status,
            # A folder's place is no result: the same series elsewhere has the same table.
            "error": error.replace(f"{folder}/", "").replace(f"{folder.resolve()}/", ""),
            "wall_s": round(time.time() - start, 3), "processor_s": read_usage(folder / RUN_FOLDER).get("processor_s"),
            "host": os.uname().nodename, "program": _program()})
        return status
    finally:
        os.close(handle)


def thin_out(run: Path, keep: str) -> None:
    """Removes what takes room: with 'last' all frames of shell and bodies but the first and the last, and the
    checkpoint; with 'none' all frames. Crack lines of all times are small, and stay with 'last'."""
    shutil.rmtree(run / "checkpoint", ignore_errors=True)
    if keep == "all" or not (run / "frames.pvd").is_file():
        return
    frames = list_frames(run)
    for part in (SHELL, BODIES):
        of_part = [frame.files[part] for frame in frames if part in frame.files]
        for path in of_part if keep == "none" else of_part[1:-1]:
            path.unlink()
    if keep == "none":
        shutil.rmtree(run / "frames")
        (run / "frames.pvd").unlink()


def _program() -> str:
    """Tells builds of the solver apart."""
    return hashlib.sha256(ensure_built().shell.read_bytes()).hexdigest()[:12]


def _die_with_parent() -> None:
    """Asks for SIGTERM when the process that started this one is gone, killed for instance."""
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)


def main(arguments: list[str]) -> int:
    """The process."""
    def interrupt(number: int, frame: object) -> None:
        del number, frame
        raise Interrupted

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupt)
    if arguments[:1] == [DIE_WITH_PARENT]:
        parent = int(arguments[1])
        _die_with_parent()
        if os.getppid() != parent:  # it went before it could be asked
            return INTERRUPTED
        arguments = arguments[2:]
    try:
        return run_member(Path(arguments[0]))
    except (Interrupted, KeyboardInterrupt):
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
