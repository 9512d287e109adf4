"""Time of a process's own, which other work on the machine cannot use up."""
from __future__ import annotations

import os
import time
from pathlib import Path

MOST_OF_A_LOOK_S = 0.1  # most that counts between two looks: this process may have been stopped or starved itself
_TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")
_WAITING = "RDTt"  # states of a thread that has a processor, waits for one or for a disk, or is stopped


class OwnTime:
    """Seconds of their own that processes have had since the first look.

    Processor time counts, and so does the time in which all threads sleep. The time in which a thread waits for a
    processor or a disk, or is stopped, does not count: then the machine is late, not the process.
    """

    def __init__(self, *pids: int) -> None:
        self._pids = pids
        self._seconds = 0.0
        self._looked = time.monotonic()
        self._used, _ = self._read()

    def look(self) -> float:
        """The seconds so far. Call it every few hundredths of a second."""
        now = time.monotonic()
        used, asleep = self._read()
        since, run = min(now - self._looked, MOST_OF_A_LOOK_S), max(used - self._used, 0.0)
        self._looked, self._used = now, used
        self._seconds += since if asleep and run == 0.0 else min(run, since)
        return self._seconds

    def _read(self) -> tuple[float, bool]:
        """Processor time of all processes [s], and whether all threads sleep. A process that has ended sleeps."""
        used, asleep = 0.0, True
        for pid in self._pids:
            for thread in Path(f"/proc/{pid}/task").glob("*/stat"):
                try:
                    fields = thread.read_text().rpartition(")")[2].split()
                except OSError:  # the thread has ended meanwhile
                    continue
                asleep = asleep and fields[0] not in _WAITING
                used += _TICK_S * (int(fields[11]) + int(fields[12]))
        return used, asleep
