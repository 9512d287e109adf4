"""One session of the two real processes with the relay between them: plays a cell and says what was wrong with it."""
from __future__ import annotations

import importlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from . import wire
from sunder_tools.launch.own_time import OwnTime

from .faults import BIRTHS, BYE, DISK, END_WITHIN_S, FAULTS, FIRST, HELLO, KILLED, LOAD, STOPPED_S, Cell, Ending
from .relay import LEAST_HELPING, RIGID, SHELL, Relay

REPOSITORY = Path(__file__).resolve().parents[2]
SCENE = Path(__file__).with_name("scene.textproto")
PATIENCE_S = 30.0          # of the processes' own time (own_time.py), for a phase to come and for both to end
STUCK_S = 1800.0           # after which a process hangs, whatever else the machine does
LOOK_S = 0.02
SLOW_HELPINGS = 15         # in which a message is read slowly
TMPFS_BYTES = 1 << 20
ROOM_FOR_RUN_JSON = 24576  # [bytes]; a frame of the scene takes 90000


def executable(side: str) -> str:
    """SUNDER_SHELL, SUNDER_RIGID, else those of build/release."""
    return os.environ.get(f"SUNDER_{side.upper()}") or str(REPOSITORY / "build" / "release" / side / f"sunder-{side}")


def exchange(folder: Path | None = None) -> ModuleType:
    """The messages of proto/exchange.proto; generated into `folder`, which must last, by the first call."""
    if folder is not None:
        proto = REPOSITORY / "proto"
        subprocess.run(["protoc", f"-I{proto}", f"--python_out={folder}", str(proto / "exchange.proto"),
                        str(proto / "geometry.proto")], check=True)
        sys.path.insert(0, str(folder))
    return importlib.import_module("exchange_pb2")


@dataclass
class Outcome:
    """What became of a cell."""
    cell: Cell
    wrong: list[str] = field(default_factory=list)  # empty: as it has to be
    skipped: str = ""                               # why
    said: str = ""                                  # statuses, kinds and seconds, for the table
    rerun: bool = False                             # was done and worked, where `wrong` is empty


class _Tmpfs:
    """A small disk at `path`. Raises OSError with the reason where it cannot be mounted."""

    def __init__(self, path: Path) -> None:
        self._path = path
        if os.geteuid() != 0:
            raise OSError("mounting a small disk needs root")
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={TMPFS_BYTES}", "tmpfs", str(path)],
                              stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode != 0:
            raise OSError(f"no small disk can be mounted: {done.stderr.strip()}")

    def fill(self, room: int) -> None:
        """Leaves `room` bytes."""
        with (self._path / "filler").open("wb", buffering=0) as sink:
            try:
                while True:
                    sink.write(bytes(4096))
            except OSError:
                sink.truncate(max(0, sink.tell() - room))

    def free(self) -> None:
        (self._path / "filler").unlink(missing_ok=True)

    def unmount(self) -> None:
        subprocess.run(["umount", "-l", str(self._path)], check=True)


class Session:
    """Plays one cell in a folder of its own."""

    def __init__(self, cell: Cell) -> None:
        self._cell, self._fault = cell, FAULTS[cell.fault]
        self._folder = Path(tempfile.mkdtemp(prefix="sunder_faults_"))
        self._out = self._folder / "out"
        self._out.mkdir()
        self._disk: _Tmpfs | None = None
        self._phase, self._windows, self._births = "", 0, 0
        self._at: float | None = None  # when it happened
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._ended: dict[str, float] = {}  # seconds after it happened

    def play(self, rerun: bool) -> Outcome:
        """`rerun`: then runs undisturbed in the same folder. Leaves nothing behind."""
        outcome = Outcome(self._cell)
        try:
            if self._cell.fault in DISK:
                try:
                    self._disk = _Tmpfs(self._out)
                except OSError as error:
                    outcome.skipped = str(error)
                    return outcome
            self._relay = Relay(self._folder / "shell", self._folder / "rigid", self._on_message)
            try:
                self._run()
            finally:
                self._kill_all()
                self._relay.close()
            self._judge(self._fault.ending(self._cell), outcome)
            if rerun and not outcome.wrong:
                self._rerun(outcome)
            return outcome
        finally:
            if self._disk:
                self._disk.unmount()
            shutil.rmtree(self._folder)

    # --- playing ---

    def _start(self, side: str, endpoint: Path) -> subprocess.Popen[bytes]:
        command = [executable(side), "--endpoint", f"ipc://{endpoint}", "--die-with-parent"]
        if side == SHELL:
            command += ["--scene", str(SCENE), "--out", str(self._out), "--quiet", "--threads", "1"]
        with (self._folder / f"{side}.log").open("wb") as log:
            return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)

    def _run(self) -> None:
        self._start_both(self._folder / "shell")
        descriptors = {}
        for side, process in self._processes.items():
            descriptors[side] = os.pidfd_open(process.pid)
            self._relay.watch(descriptors[side])
        had = OwnTime(*(process.pid for process in self._processes.values()))
        since: float | None = None  # what they had had when it happened
        continued = self._cell.fault not in ("stop", "pause")
        try:
            while len(self._ended) < 2 and had.look() - (since or 0.0) < PATIENCE_S:
                self._relay.turn(0.1 if since is None else LOOK_S)
                if self._at is not None and since is None:
                    since = had.look()
                for side, process in self._processes.items():
                    if side not in self._ended and process.poll() is not None:
                        self._ended[side] = had.look() - (since or 0.0)
                        self._relay.unwatch(descriptors[side])
                if self._at is not None and not continued and time.monotonic() > self._at + STOPPED_S:
                    continued = True
                    self._go_on()
        finally:
            for descriptor in descriptors.values():
                os.close(descriptor)

    def _go_on(self) -> None:
        if self._cell.fault == "pause":
            self._relay.go_on()
        else:
            self._processes[self._cell.side].send_signal(signal.SIGCONT)

    def _start_both(self, shell_endpoint: Path) -> None:
        self._processes = {RIGID: self._start(RIGID, self._folder / "rigid")}
        self._processes[SHELL] = self._start(SHELL, shell_endpoint)

    def _kill_all(self) -> None:
        for process in self._processes.values():
            if process.poll() is None:
                process.kill()
            process.wait()

    def _on_message(self, side: str, payload: bytes) -> list[bytes] | None:
        """The relay's question; sets the phase, and does the cell's fault when its time has come."""
        if side == SHELL:
            request = exchange().Request.FromString(payload) if self._at is None else None
            if request is not None:
                self._note_phase(request)
        if self._at is not None or self._phase != self._cell.phase:
            return None
        # a process is struck while the request is on its way: a reply to Bye would be the last that it says
        strikes = self._cell.fault in ("kill", "stop", *DISK)
        if side != (SHELL if strikes else self._cell.side):
            return None
        self._at = time.monotonic()
        return self._do(side, payload)

    def _note_phase(self, request: Any) -> None:
        kind = request.WhichOneof("kind")
        self._phase = {"hello": HELLO, "load": LOAD, "bye": BYE}.get(kind, "")
        if kind == "window":
            self._windows += 1
            self._births += len(request.window.births) > 0
            if self._windows == 1:
                self._phase = FIRST
            elif self._births == 1 and request.window.births:
                self._phase = BIRTHS

    def _do(self, side: str, payload: bytes) -> list[bytes] | None:
        cell, fault = self._cell, self._fault
        if fault.message is not None:
            message = (exchange().Request if side == SHELL else exchange().Reply).FromString(payload)
            fault.message(message, side, cell.phase)
            return [wire.frame(message.SerializeToString())]
        if fault.raw is not None:
            return fault.raw(payload)
        if cell.fault in ("kill", "stop"):
            self._processes[cell.side].send_signal(signal.SIGKILL if cell.fault == "kill" else signal.SIGSTOP)
            return [] if cell.fault == "kill" else None
        if cell.fault == "pause":
            self._relay.stand_still()
            return None
        if cell.fault == "cut frame":
            whole = wire.frame(payload)
            self._relay.send_and_cut(side, whole[:len(whole) // 2])
            return []
        if cell.fault == "slow":
            self._relay.sides[side].slow = SLOW_HELPINGS
            self._slow_bytes = len(wire.frame(payload))
            return None
        assert cell.fault in DISK and self._disk is not None, cell.fault
        self._disk.fill(ROOM_FOR_RUN_JSON if cell.fault == "disk full" else 0)
        return None

    # --- judging ---

    def _log(self, side: str) -> str:
        return (self._folder / f"{side}.log").read_text(errors="replace")

    def _judge(self, expected: Ending, outcome: Outcome) -> None:
        wrong = outcome.wrong
        if self._at is None:
            wrong.append(f"the phase never came: {self._log(SHELL)}{self._log(RIGID)}")
            return
        status = {side: process.returncode for side, process in self._processes.items()}
        run = self._run_json(wrong)
        error = run.get("error", {}) if run else {}
        if (status[SHELL], status[RIGID]) != (expected.shell, expected.rigid):
            wrong.append(f"ended with {status[SHELL]} and {status[RIGID]}, not {expected.shell} and {expected.rigid}")
        if (run.get("status") if run is not None else None) not in expected.run:
            wrong.append(f"run.json says {run and run.get('status')}, not {expected.run}")
        kinds = [kind for kind in expected.kinds if f"sunder-shell: {kind}: " in self._log(SHELL)]
        if expected.kinds and not kinds:
            wrong.append(f"the shell does not name {' or '.join(expected.kinds)}")
        if "failed" in expected.run and error.get("kind") not in kinds:
            wrong.append(f"run.json names {error.get('kind')}, the shell {kinds}")
        if "failed" in expected.run and not error.get("message"):
            wrong.append("run.json has no message")
        if expected.rigid_kind and f"sunder-rigid: {expected.rigid_kind}: " not in self._log(RIGID):
            wrong.append(f"the rigid process does not name {expected.rigid_kind}")
        for side in (SHELL, RIGID):
            if expected.kinds == () and status[side] == 0 and self._log(side):
                wrong.append(f"the {side} process complains, and all was well")
        if self._cell.fault == "slow" and self._relay.helpings < min(SLOW_HELPINGS, -(-self._slow_bytes // LEAST_HELPING)):
            wrong.append(f"was not slow: {self._relay.helpings} helpings")
        if status[RIGID] != KILLED and (self._folder / "rigid").exists():
            wrong.append("a stale socket is left")
        if status[SHELL] != KILLED and list(self._out.rglob("*.part")):
            wrong.append("half-written files are left")
        if wrong:
            wrong.append(f"\n  shell: {self._log(SHELL).strip()}\n  rigid: {self._log(RIGID).strip()}")
        self._judge_time(expected, outcome)
        kind = error.get("kind") or (kinds[0] if kinds else "")
        last = max(self._ended.values(), default=0.0)
        rigid = expected.rigid_kind if f": {expected.rigid_kind}: " in self._log(RIGID) else ""
        outcome.said = f"{status[SHELL]} {kind} | {status[RIGID]} {rigid} | {last:.2f} s".replace("  ", " ")

    def _judge_time(self, expected: Ending, outcome: Outcome) -> None:
        if self._cell.fault == "slow" or (expected.shell, expected.rigid) == (0, 0):
            return  # goes on to its end
        for side in (SHELL, RIGID):
            if not self._ended.get(side, 1e9) <= END_WITHIN_S:
                outcome.wrong.append(f"the {side} process took {self._ended.get(side, float('inf')):.2f} s of their own to "
                                     f"end, at most {END_WITHIN_S:.1f} s")

    def _run_json(self, wrong: list[str]) -> dict[str, Any] | None:
        try:
            return json.loads((self._out / "run.json").read_text())
        except FileNotFoundError:
            return None
        except ValueError as error:
            wrong.append(f"run.json is no JSON: {error}")
            return {}

    def _rerun(self, outcome: Outcome) -> None:
        if self._disk:
            self._disk.free()
        self._start_both(self._folder / "rigid")  # the very endpoint
        try:
            statuses = [self._processes[side].wait(STUCK_S) for side in (SHELL, RIGID)]
        except subprocess.TimeoutExpired:
            statuses = []
        self._kill_all()
        run = self._run_json(outcome.wrong)
        if statuses != [0, 0] or not run or run.get("status") != "done":
            outcome.wrong.append(f"run again in the same folder: {statuses}, {run and run.get('status')}\n"
                                 f"  {self._log(SHELL)}{self._log(RIGID)}")
        outcome.rerun = True


def play(cell: Cell, rerun: bool) -> Outcome:
    """Plays a cell; an error of the harness itself is what is wrong with it."""
    try:
        return Session(cell).play(rerun)
    except Exception as error:  # noqa: BLE001: one broken cell must not end the matrix
        return Outcome(cell, wrong=[f"the harness failed: {type(error).__name__}: {error}"])
