"""What can go wrong, at which phase and on which side, and how both processes have to end then."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable

from . import wire
from .relay import BOTH, RIGID, SHELL

HELLO, LOAD, FIRST, BIRTHS, BYE = PHASES = ("hello", "load", "first window", "births", "bye")
WINDOWS = (FIRST, BIRTHS)
MAX_MESSAGE = 256 << 20   # [bytes], kMaxMessage of coupler/link/messages.h
END_WITHIN_S = 2.0  # after the fault, in the processes' own time (own_time.py)
STOPPED_S = 2.5     # longer than a cut connection is waited for

DONE, BAD_INPUT, PEER_LOST, KILLED = 0, 2, 3, -9


@dataclass(frozen=True)
class Cell:
    """One fault at one phase, in what `side` says or does."""
    fault: str
    side: str
    phase: str

    def __str__(self) -> str:
        return f"{self.fault}, {self.side}, {self.phase}"


@dataclass(frozen=True)
class Ending:
    """How both have to end."""
    shell: int                       # exit status
    kinds: tuple[str, ...]           # of the error in run.json and on the shell's stderr; (): none
    rigid: int
    rigid_kind: str = ""             # on its stderr
    run: tuple[str | None, ...] = ("failed",)  # status in run.json; None: there is no run.json


# --- what is done to a message -------------------------------------------------------------------------------------

def _nan(message: Any, side: str, phase: str) -> None:
    nan = float("nan")
    if side == SHELL:
        if phase == LOAD:
            message.load.bodies[0].position.z = nan
        elif phase == FIRST:
            message.window.predicted[0].velocity.z = nan
        else:
            message.window.births[0].angular_momentum.x = nan
    elif phase == LOAD:
        message.load.states[0].position.x = nan
    elif phase == FIRST:
        message.window.states[0].orientation.w = nan
    else:
        message.window.states[-1].mass = nan


def _duplicate(message: Any, side: str, phase: str) -> None:
    if side == SHELL:
        listed = {LOAD: message.load.bodies, FIRST: message.window.predicted, BIRTHS: message.window.births}[phase]
    else:
        listed = message.load.states if phase == LOAD else message.window.states
    listed.append(listed[-1])


def _old_tick(message: Any, side: str, phase: str) -> None:
    (message.load if phase == LOAD else message.window).tick -= 1


def _version(message: Any, side: str, phase: str) -> None:
    if side == SHELL:
        message.hello.protocol_min = message.hello.protocol_max = 99
    else:
        message.hello.protocol = 99


def _hash(message: Any, side: str, phase: str) -> None:
    message.hello.scene_hash = b"another scene"


def _garbage(payload: bytes) -> list[bytes]:
    return [wire.frame(b"\xff" * 12 + bytes(range(7, 71)))]  # no tag of a field is so long


def _truncated(payload: bytes) -> list[bytes]:
    return [wire.frame(payload[:-1])]


def _oversized(payload: bytes) -> list[bytes]:
    return [wire.head_of(MAX_MESSAGE + 1) + bytes(1024)]


def _noise(payload: bytes) -> list[bytes]:
    return [b"\xff" * 64]  # no frame at all: its length would be 2^64 - 1


def _replay(payload: bytes) -> list[bytes]:
    return [wire.frame(payload)] * 2


# --- how it has to end ---------------------------------------------------------------------------------------------

def _after_bad_message(cell: Cell) -> Ending:
    if cell.side == SHELL:  # the rigid process refuses and says why
        return Ending(PEER_LOST, ("bad_message",), PEER_LOST, "bad_message")
    if cell.phase == BYE:  # it has said goodbye
        return Ending(PEER_LOST, ("bad_message",), DONE)
    return Ending(PEER_LOST, ("bad_message",), PEER_LOST, "peer_failed")


def _after_hash(cell: Cell) -> Ending:  # the engine repeats what it was told, the shell compares
    return Ending(PEER_LOST, ("bad_message",), PEER_LOST, "peer_failed")


def _after_replay(cell: Cell) -> Ending:
    if cell.phase == BYE:  # nobody is there to hear it a second time
        return Ending(DONE, (), DONE, run=("done",))
    return _after_bad_message(cell)


def _after_cut(cell: Cell) -> Ending:
    gone = cell.side == RIGID and cell.phase == BYE  # it has said goodbye
    return Ending(PEER_LOST, ("peer_lost",), DONE if gone else PEER_LOST, "" if gone else "peer_lost")


def _after_kill(cell: Cell) -> Ending:
    if cell.side == RIGID:
        return Ending(PEER_LOST, ("peer_lost",), KILLED)
    # what it had written stays as it was; the launcher settles it (coupler/sunder_tools/launch/run.py)
    return Ending(KILLED, (), PEER_LOST, "peer_lost", run=(None,) if cell.phase in (HELLO, LOAD) else ("running",))


def _after_stop(cell: Cell) -> Ending:  # the other side waits
    return Ending(DONE, (), DONE, run=("done",))


def _after_slow(cell: Cell) -> Ending:
    return Ending(DONE, (), DONE, run=("done",))


def _after_disk(cell: Cell) -> Ending:
    if cell.phase == BYE:  # the last frame is written, run.json fits
        return Ending(DONE, (), DONE, run=("done",))
    return Ending(BAD_INPUT, ("bad_output",), PEER_LOST, "peer_failed")


def _after_brim(cell: Cell) -> Ending:  # not even run.json can be replaced: the terminal has the reason, it stays whole
    bye = cell.phase == BYE
    return Ending(BAD_INPUT, ("bad_output",), DONE if bye else PEER_LOST, "" if bye else "peer_failed",
                  run=(None,) if cell.phase in (HELLO, LOAD) else ("running",))


@dataclass(frozen=True)
class Fault:
    """A row of the matrix, two with both sides."""
    name: str
    what: str
    ending: Callable[[Cell], Ending]
    phases: tuple[str, ...] = PHASES
    sides: tuple[str, ...] = BOTH
    elsewhere: str = ""  # why the other phases or sides have no such fault
    message: Callable[[Any, str, str], None] | None = None  # changes the decoded message
    raw: Callable[[bytes], list[bytes]] | None = None       # gives what goes over the wire in its place

    def cells(self) -> list[Cell]:
        return [Cell(self.name, side, phase) for side in self.sides for phase in self.phases]


FAULTS = {fault.name: fault for fault in (
    Fault("kill", "SIGKILL", _after_kill),
    Fault("stop", f"SIGSTOP, and SIGCONT after {STOPPED_S} s", _after_stop),
    Fault("pause", f"nothing goes over the connection for {STOPPED_S} s", _after_stop),
    Fault("garbage", "a message of garbage", _after_bad_message, raw=_garbage),
    Fault("noise", "garbage on the wire, no frame", _after_cut, raw=_noise),
    Fault("truncated", "a message without its last byte", _after_bad_message, raw=_truncated),
    Fault("cut frame", "half a frame, then the connection closes", _after_cut),
    Fault("oversized", "a message of kMaxMessage + 1 bytes", _after_cut, raw=_oversized),
    Fault("version", "another protocol version", _after_bad_message, phases=(HELLO,), message=_version,
          elsewhere="only Hello has versions"),
    Fault("hash", "another scene's hash", _after_hash, phases=(HELLO,), message=_hash,
          elsewhere="only Hello has a hash"),
    Fault("nan", "NaN in a field", _after_bad_message, phases=(LOAD, *WINDOWS), message=_nan,
          elsewhere="no numbers that could be NaN"),
    Fault("duplicate", "an id twice", _after_bad_message, phases=(LOAD, *WINDOWS), message=_duplicate,
          elsewhere="no ids"),
    Fault("replay", "the message twice", _after_replay, raw=_replay),
    Fault("old tick", "the tick before", _after_bad_message, phases=WINDOWS, message=_old_tick,
          elsewhere="no tick in both directions"),
    Fault("slow", "every message from here on takes 0.3 s to be read", _after_slow),
    Fault("disk full", "room for run.json, not for a frame", _after_disk, sides=(SHELL,),
          elsewhere="the rigid process writes nothing"),
    Fault("disk brim", "full to the last byte", _after_brim, sides=(SHELL,),
          elsewhere="the rigid process writes nothing"),
)}
DISK = ("disk full", "disk brim")
