"""Watching the two processes: who ends first, how long the other gets, what Ctrl-C does."""
from __future__ import annotations

import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from .own_time import OwnTime

PERIOD_S = 0.02          # between two looks
# Limits below are in the process's own time (own_time.py), so they last longer on a busy machine.
GRACE_S = 2.0            # for the other process to end by itself
AFTER_GOODBYE_S = 60.0   # the rigid side left in peace (status 0); the shell may still write frames and hashes
TERM_TO_KILL_S = 0.5
_EXITING = 0x4           # PF_EXITING among a thread's flags in /proc/PID/stat


@dataclass
class Ending:
    """How both processes ended: subprocess return codes, and what the launcher did to them."""
    shell: int = 0
    rigid: int = 0
    shell_was_signalled: bool = False  # SIGTERM or SIGKILL by the launcher, because its peer was gone
    rigid_was_signalled: bool = False
    rigid_first: bool = False          # the rigid process was seen to end while the shell still lived
    interrupted: bool = False
    killed_by_user: bool = False


def is_dying(pid: int) -> bool:
    """Whether a process is on its way out. It closes its connections before its parent can see its end, and on a busy
    machine the other process may notice and end in between."""
    state, flags = _state(pid)
    return state in "ZX" or bool(flags & _EXITING)


def _state(pid: int) -> tuple[str, int]:
    """State and flags of a process's main thread; "X" where there is none."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return "X", 0
    return fields[0], int(fields[6])


class _Deadline:
    """Ends one process: time to end by itself, then SIGTERM, then SIGKILL. One that is dying is left alone, and one
    that is stopped is waited for."""

    def __init__(self, process: subprocess.Popen[bytes], grace_s: float) -> None:
        self.process = process
        self._had = OwnTime(process.pid)
        self._limit_s = grace_s
        self.signalled = False
        self._told_stopped = False

    def look(self) -> None:
        if self.process.poll() is not None:
            return
        if not self._told_stopped and _state(self.process.pid)[0] in "Tt":
            self._told_stopped = True
            print("sunder: the other process has ended, and the one that is left is stopped. To let it end: kill -CONT "
                  f"{self.process.pid}", file=sys.stderr, flush=True)
        if self._had.look() < self._limit_s:
            return
        if is_dying(self.process.pid):
            return
        if not self.signalled:
            self.process.terminate()
            self.signalled = True
            self._limit_s += TERM_TO_KILL_S
        else:
            self.process.kill()


def watch(shell: subprocess.Popen[bytes], rigid: subprocess.Popen[bytes] | None, interrupts: list[int]) -> Ending:
    """Returns once both processes have ended. `rigid` is None where another program runs it. `interrupts` grows by one
    entry per Ctrl-C, SIGTERM or SIGHUP.

    The first interruption goes to the shell as SIGINT, which then ends the run and tells its peer;
    the second kills both.
    """
    ending = Ending()
    deadline: _Deadline | None = None
    while True:
        # The rigid process is polled first. Where it has ended and the shell still runs afterwards, it ended first,
        # however long this process waited between the two polls.
        rigid_ended = rigid is None or rigid.poll() is not None
        shell_ended = shell.poll() is not None
        if shell_ended and rigid_ended:
            break
        if interrupts and not ending.interrupted:
            ending.interrupted = True
            if not shell_ended:
                shell.send_signal(signal.SIGINT)
                line_end = "\n" if sys.stderr.isatty() else ""  # ends the progress line
                print(f"{line_end}sunder: stopping after this window; once more kills at once",
                      file=sys.stderr, flush=True)
        if len(interrupts) > 1 and not ending.killed_by_user:
            ending.killed_by_user = not shell_ended  # a run that is complete stays complete
            shell.kill()
            if rigid is not None:
                rigid.kill()
        if rigid is not None and deadline is None and (shell_ended or rigid_ended):
            if shell_ended:
                deadline = _Deadline(rigid, GRACE_S)
            else:
                ending.rigid_first = not is_dying(shell.pid)
                deadline = _Deadline(shell, AFTER_GOODBYE_S if rigid.returncode == 0 else GRACE_S)
        if deadline is not None:
            deadline.look()
        time.sleep(PERIOD_S)
    if deadline is not None and deadline.signalled:
        if deadline.process is shell:
            ending.shell_was_signalled = True
        else:
            ending.rigid_was_signalled = True
    ending.shell, ending.rigid = shell.returncode, rigid.returncode if rigid is not None else 0
    return ending
