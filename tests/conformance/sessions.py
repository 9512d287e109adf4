"""`sunder validate engines --rigid ENGINE --session FILE`: a recorded session played to an engine, window by window.

Neither the shell process nor the suite takes part, and nothing is built for a program of the user's.
"""
from __future__ import annotations

import json
import math
import subprocess
from dataclasses import asdict
from pathlib import Path

from sunder_engine.playing import CLOSE, DIFFERS, SAME, Difference, Played, Player, Refusal, Reply
from sunder_engine.recording import BadRecording
from sunder_engine.wire import Caller, Lost
from sunder_tools.errors import BAD_INPUT, CHECK_FAILED, DONE, PEER_LOST, CommandError, how_it_ended
from sunder_tools.launch import engines
from sunder_tools.launch.build import Executables, build_dir, ensure_built
from sunder_tools.launch.run import RECORD_FILE
from sunder_tools.launch.socket_dir import SocketDir

MOST_LINES = 12     # of windows that differ
LAST_WORDS_S = 2.0  # for the engine to end after Bye (rigid/README.md)


def play_session(session: Path, rigid: str, tolerance: float | None, report: Path | None) -> int:
    """Plays it, prints what differs, and returns the exit status. Raises CommandError."""
    path = session / RECORD_FILE if session.is_dir() else session
    if engines.in_process(rigid):
        raise CommandError(f"--rigid {rigid}: a session goes over the wire; leave '{engines.IN_PROCESS}:' out", BAD_INPUT)
    try:
        player = Player(path, tolerance)
    except BadRecording as error:
        raise CommandError(f"--session {error}", BAD_INPUT) from None
    except OSError as error:
        raise CommandError(f"--session {path}: {error.strerror}; name the run folder or {RECORD_FILE} of a run that was made with "
                           "--record", BAD_INPUT) from None
    except RuntimeError as error:  # no protoc
        raise CommandError(str(error), BAD_INPUT) from None
    try:
        played, ended = _played(player, rigid)
    except CommandError as error:
        if error.status == PEER_LOST and player.played.replies:
            print(told(path, rigid, player.played, ""), flush=True)
        raise
    print(told(path, rigid, played, ended), flush=True)
    if report is not None:
        try:
            report.write_text(json.dumps(as_json(path, played, ended), indent=1) + "\n")
        except OSError as error:
            raise CommandError(f"cannot write {report}: {error.strerror}", BAD_INPUT) from None
    return CHECK_FAILED if played.first is not None or played.stopped or ended else DONE


def _played(player: Player, rigid: str) -> tuple[Played, str]:
    """What came out, and what is wrong with how the engine ended. Raises CommandError."""
    own = "/" in rigid or rigid in engines.NODE_PROGRAMS
    built = build_dir()
    place = engines.resolve(rigid, Executables(built, built, built) if own else ensure_built())
    with SocketDir() as socket:
        endpoint = place.endpoint or socket.endpoint
        process = None
        if place.command:
            process = subprocess.Popen([*place.command, "--endpoint", endpoint, "--die-with-parent"], stdin=subprocess.DEVNULL)
        try:
            caller = Caller(endpoint, lambda: process is None or process.poll() is None)
        except ValueError:
            raise CommandError(f"--rigid {rigid}: a session is played on this machine, without keys; use ipc://PATH or "
                               "tcp://127.0.0.1:PORT", BAD_INPUT) from None
        try:
            played = player.play(caller)
        except Refusal as error:
            raise CommandError(f"{place.program}: {error}", BAD_INPUT) from None
        except Lost as error:
            raise CommandError(f"{place.program}: {player.asked}: {error}{_status(process)}", PEER_LOST) from None
        finally:
            caller.close()
            late = _ended_late(process)
    return played, late or _wrong_end(process, played)


def _status(process: subprocess.Popen[bytes] | None) -> str:
    """How a process that is lost has ended."""
    if process is None:
        return ""
    try:
        return f"; it {how_it_ended(process.wait(LAST_WORDS_S))}"
    except subprocess.TimeoutExpired:
        return ""


def _ended_late(process: subprocess.Popen[bytes] | None) -> str:
    """Waits for the end of the engine's process, and stops one that goes on."""
    if process is None:
        return ""
    try:
        process.wait(LAST_WORDS_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return f"it did not end within {LAST_WORDS_S:.0f} s after the session"
    return ""


def _wrong_end(process: subprocess.Popen[bytes] | None, played: Played) -> str:
    if process is None or played.stopped or process.returncode == DONE:
        return ""
    return f"it {how_it_ended(process.returncode)} after Bye; {DONE} is due"


def told(path: Path, rigid: str, played: Played, ended: str) -> str:
    """The report for people."""
    windows = [reply for reply in played.replies if reply.kind == "window"]
    differing = [reply for reply in played.replies if reply.verdict == DIFFERS]
    lines = [f"session    {path}, recorded with {played.recorded}",
             f"engine     {rigid} ({played.engine} {played.version})",
             f"tolerance  {played.tolerance:g} of a body's size, of a radian, and of the fastest body's speed"]
    lines += [_line(reply) for reply in differing[:MOST_LINES]]
    if len(differing) > MOST_LINES:
        lines.append(f"... and {len(differing) - MOST_LINES} more; --json FILE has all")
    count = {verdict: sum(reply.verdict == verdict for reply in windows) for verdict in (SAME, CLOSE, DIFFERS)}
    lines.append(f"{len(windows)} windows: {count[SAME]} the same to the bit, {count[CLOSE]} within the tolerance, "
                 f"{count[DIFFERS]} differ")
    if played.skipped:
        lines.append(f"{played.skipped} requests for caches were left out: the engine has none")
    first = played.first
    if first is not None:
        lines.append(f"first that differs: {_name(first)}")
    if played.stopped:
        lines.append(f"stopped at {played.stopped}")
    if ended:
        lines.append(f"the engine's process: {ended}")
    return "\n".join(lines)


def _name(reply: Reply) -> str:
    if reply.kind == "window":
        ticks = f"tick {reply.tick} to {reply.tick + reply.ticks}"
        return f"window {reply.window} (request {reply.request}, {ticks}, {reply.window_s:g} s)"
    return f"{reply.kind} (request {reply.request})"


def _line(reply: Reply) -> str:
    parts = list(reply.notes)
    if reply.bodies_differ and reply.worst is not None:
        parts.append(f"{reply.bodies_differ} of {reply.bodies} bodies differ, most {_numbers(reply.worst)}")
    return f"{_name(reply)}: {'; '.join(parts)}"


def _numbers(worst: Difference) -> str:
    linear = unlike(worst.impulse_N_s, worst.recorded_impulse_N_s)
    angular = unlike(worst.angular_impulse_N_m_s, worst.recorded_angular_impulse_N_m_s)
    return (f"{worst.body}: {worst.quantity} is off by {worst.is_by:.2g} {worst.unit}, {worst.allowed:.2g} allowed; of all: position by "
            f"{worst.position_m:.2g} m, turn {worst.turn_rad:.2g} rad, velocity {worst.velocity_m_per_s:.2g} m/s; impulse {linear[0]} N s "
            f"instead of {linear[1]}, angular {angular[0]} N m s instead of {angular[1]}")


def unlike(one: float, other: float) -> tuple[str, str]:
    """Two numbers with as many digits as tell them apart, four at least."""
    return next(pair for digits in range(4, 18) if (pair := (f"{one:.{digits}g}", f"{other:.{digits}g}")) and (
        pair[0] != pair[1] or one == other or digits == 17))


def as_json(path: Path, played: Played, ended: str) -> dict[str, object]:
    """Everything, a row for each reply; a number that is not finite is null."""
    first = played.first
    return {"session": str(path), "recorded_with": played.recorded, "engine": played.engine, "version": played.version,
            "capabilities": played.capabilities, "tolerance": played.tolerance,
            "first_that_differs": first.request if first is not None else None, "stopped": played.stopped, "ended": ended,
            "replies": [_finite(asdict(reply)) for reply in played.replies]}


def _finite(value: object) -> object:
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
