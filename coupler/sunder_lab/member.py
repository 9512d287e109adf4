"""One run of a series: a folder with its scene, run by its own process, on any machine.

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
from sunder_tools.replacing import replacing
from sunder_tools.report.run_json import read_run

from .scene import SCENE_FILE, Scene

MEMBER_FILE, OUTCOME_FILE, LOG_FILE, RUN_FOLDER = "member.json", "outcome.json", "member.log", "run"
KEEP = ("last", "all", "none")
DIE_WITH_PARENT = "--die-with-parent"
PR_SET_PDEATHSIG = 1  # <sys/prctl.h>


@dataclass(frozen=True)
class Member:
    """Identity of a run: its scene and its engine. Threads and stored files do not belong to it."""
    scene: Scene
    engine: str = "bullet"

    def identity(self) -> str:
        """Returns 16 hexadecimal digits. Runs with equal digits have equal results, to the bit."""
        text = json.dumps([self.scene.identity(), self.engine])
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def prepare(self, folder: Path, threads: int, keep: str) -> None:
        """Writes the files that the process needs; files of an earlier run in the folder do not change."""
        self.scene.save(folder)
        write_atomically(folder / MEMBER_FILE, {"engine": self.engine, "threads": threads, "keep": keep})


def write_atomically(path: Path, value: Any) -> None:
    """Writes JSON atomically."""
    with replacing(path) as part:
        part.write_text(json.dumps(value, indent=1) + "\n")


def read_json(path: Path) -> dict[str, Any]:
    """Reads a JSON object; {} where the file does not exist or holds none."""
    try:
        value = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return value if isinstance(value, dict) else {}


def outcome(folder: Path) -> dict[str, Any]:
    """Returns the outcome: status 'done' or 'failed', error, wall_s, processor_s of both processes, host, program.
    {} where the member has not ended."""
    return read_json(folder / OUTCOME_FILE)


def is_done(folder: Path) -> bool:
    """True where the member need not be run."""
    return outcome(folder).get("status") == "done"


def run_member(folder: Path) -> int:
    """Runs the member unless it is done, and returns the exit status of `sunder run`. Waits while another process
    runs it."""
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
        if status == INTERRUPTED:  # by the user, or by the end of the parent process: not an outcome of the scene
            return INTERRUPTED
        thin_out(folder / RUN_FOLDER, str(kept.get("keep", KEEP[0])))
        write_atomically(folder / OUTCOME_FILE, {
            "status": "done" if status == DONE else "failed", "exit": status,
            # The folder's path is not part of the result: the same series elsewhere has the same table.
            "error": error.replace(f"{folder}/", "").replace(f"{folder.resolve()}/", ""),
            "wall_s": round(time.time() - start, 3), "processor_s": read_usage(folder / RUN_FOLDER).get("processor_s"),
            "host": os.uname().nodename, "program": _program()})
        return status
    finally:
        os.close(handle)


def thin_out(run: Path, keep: str) -> None:
    """Removes large files. With 'last', all frames of shell and bodies except for the first and the last, and the
    checkpoint; with 'none', all frames. Crack lines are small and stay with 'last'."""
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
    """Returns a text that identifies the build of the solver."""
    return hashlib.sha256(ensure_built().shell.read_bytes()).hexdigest()[:12]


def _die_with_parent() -> None:
    """Asks the system for SIGTERM when the parent process ends, also when it is killed."""
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)


def main(arguments: list[str]) -> int:
    """Runs as the process of a member."""
    def interrupt(number: int, frame: object) -> None:
        del number, frame
        raise Interrupted

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupt)
    if arguments[:1] == [DIE_WITH_PARENT]:
        parent = int(arguments[1])
        _die_with_parent()
        if os.getppid() != parent:  # the parent ended before the request
            return INTERRUPTED
        arguments = arguments[2:]
    try:
        return run_member(Path(arguments[0]))
    except (Interrupted, KeyboardInterrupt):
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
