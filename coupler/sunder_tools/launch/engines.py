"""The rigid side of a run: by name, as a program, at an address, or in the fracture process itself."""
from __future__ import annotations

import json
import os
import re
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from ..errors import BAD_INPUT, PEER_LOST, CommandError, how_it_ended
from ..places import REPOSITORY, has_packages, named_build, npm_folder
from ..words import command_line, did_you_mean
from .build import Executables, ensure_built, how_dart_comes
from .own_time import OwnTime
from .socket_dir import SocketDir

IN_PROCESS = "inprocess"
IPC = "ipc://"
DART = "dart"  # installed and built with its first run
NODE_SOURCES = REPOSITORY / "rigid" / "jolt"  # its packages serve both engines under Node.js
NODE_PROGRAMS = {name: REPOSITORY / "rigid" / name / f"sunder-rigid-{name}" for name in ("jolt", "mujoco")}
PERIOD_S = 0.02     # between two looks
LAST_WORDS_S = 2.0  # for either side to end after the other


@dataclass(frozen=True)
class Rigid:
    """Where the engine of a run is: exactly one of command, endpoint and in_process is given."""
    label: str
    command: tuple[str, ...] = ()  # to launch, without --endpoint
    endpoint: str = ""             # at which one waits already
    in_process: str = ""           # name of an engine of the fracture process's own

    @property
    def program(self) -> str:
        """What messages call the rigid side: its program's name, or the address where it waits."""
        return Path(self.command[0]).name if self.command else self.label


def in_process(text: str) -> str:
    """NAME of inprocess[:NAME], '' of anything else."""
    name, _, inner = text.partition(":")
    return (inner or "bullet") if name == IN_PROCESS else ""


def is_address(text: str) -> bool:
    """Whether this is the address at which an engine waits."""
    return re.match(r"(ipc|tcp)://", text) is not None


def is_path(text: str) -> bool:
    """Whether this is the path of a program, not a name or an address."""
    return "/" in text and not is_address(text) and not in_process(text)


def no_program(path: str) -> str:
    """Why there is no program at this path, and what to do; '' where there is one."""
    if os.path.isdir(path):
        return "is a folder"
    if not os.path.isfile(path):
        return "there is no such file"
    return "" if os.access(path, os.X_OK) else f"is not an executable file; to make it one: {command_line(['chmod', '+x', path])}"


def from_anywhere(text: str) -> str:
    """The same engine where paths in it do not depend on the working folder."""
    if text.startswith(IPC) and not text.startswith(IPC + "@"):
        return IPC + os.path.abspath(text.removeprefix(IPC))
    return os.path.abspath(text) if is_path(text) else text


def resolve(text: str, executables: Executables) -> Rigid:
    """NAME, inprocess[:NAME], the path of a program (with a '/'), or ipc://... or tcp://...

    Raises CommandError where there is no such program; names are for the engine's own --check.
    """
    if is_address(text):
        return Rigid(text, endpoint=text)
    inner = in_process(text)
    if inner:
        if not os.access(executables.single, os.X_OK):  # few want it: it is not built before
            check(text, Rigid(text, in_process=inner), executables)
            ensure_built(targets=("sunder-single",))
        return Rigid(text, in_process=inner)
    if is_path(text):
        if wrong := no_program(text):
            other = "" if os.path.isfile(text) else (
                "; give the path of a program that takes --engine NAME --endpoint ADDRESS, an engine's name (see 'sunder engines') "
                "or an address (ipc://... or tcp://...)")
            raise CommandError(f"--rigid {text}: {wrong}{other}")
        return Rigid(text, command=(os.path.abspath(text), "--engine", Path(text).stem))
    if text in _under_node():
        from .node import ensure_node
        ensure_node()
        return Rigid(text, command=(str(NODE_PROGRAMS[text]), "--engine", text))
    if text == DART:
        return Rigid(text, command=(str(ensure_built(dart=True).dart), "--engine", text))
    return Rigid(text, command=(str(executables.rigid), "--engine", text))


def check(text: str, rigid: Rigid, executables: Executables) -> None:
    """Raises CommandError where `text` names no engine, with the nearest names. Paths and addresses are not asked."""
    if rigid.endpoint or is_path(text):
        return
    command = [*(rigid.command or (str(executables.rigid), "--engine", rigid.in_process)), "--check"]
    found = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                           errors="replace", check=False)
    if found.returncode == BAD_INPUT:
        said = found.stderr.strip() or "refused without a reason"
        hint = did_you_mean(rigid.in_process or text, dict.fromkeys([*names(executables), DART]))
        if os.path.isfile(text) and not rigid.in_process:
            hint = f"did you mean ./{text}, the file here? A path needs a '/'"
        raise CommandError(f"{said}\n--rigid {text}: {hint} (see 'sunder engines')")
    if found.returncode != 0:
        raise CommandError(f"{found.stderr.strip()}\n{rigid.label} {how_it_ended(found.returncode)} while it was "
                           "checked".strip(), PEER_LOST if found.returncode < 0 else found.returncode)


def names(executables: Executables) -> list[str]:
    """Every engine that comes with the project; DART where it is built."""
    listed = subprocess.run([str(executables.rigid), "--list"], stdout=subprocess.PIPE, text=True, check=True).stdout
    return listed.split() + _under_node() + ([DART] if os.access(executables.dart, os.X_OK) else [])


def _under_node() -> list[str]:
    return [name for name, program in NODE_PROGRAMS.items() if program.is_file()]


def hello(rigid: Rigid, executables: Executables, keys: Path | None = None) -> dict[str, object]:
    """Launches or contacts an engine; returns its name, version and capabilities. Raises CommandError.

    An engine that ends is not waited for. How long one that lives may take is the shell process's matter: it counts the
    engine's own time.
    """
    with SocketDir() as socket, tempfile.TemporaryFile("w+", errors="replace") as said:
        endpoint = rigid.endpoint or socket.endpoint
        process = None
        if rigid.command:
            process = subprocess.Popen([*rigid.command, "--endpoint", endpoint, "--die-with-parent"],
                                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=said)
        asking = subprocess.Popen([str(executables.shell), "hello", "--endpoint", endpoint,
                                   *(["--rigid-process", str(process.pid)] if process is not None else []),
                                   *(["--keys", str(keys)] if keys else [])],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace")
        left: OwnTime | None = None  # of the asking process, once the engine has ended
        try:
            while asking.poll() is None:
                if left is None and process is not None and process.poll() is not None:
                    left = OwnTime(asking.pid)
                if left is not None and left.look() > LAST_WORDS_S:
                    asking.kill()
                time.sleep(PERIOD_S)
        finally:
            if asking.poll() is None:
                asking.kill()
            answered, refused = asking.communicate()
            ran_on = False  # the engine, after the shell's side had given up
            if process is not None:
                try:
                    process.wait(LAST_WORDS_S)
                except subprocess.TimeoutExpired:
                    ran_on = True
                    process.kill()
                    process.wait()
        said.seek(0)
        words = said.read().strip()
    if asking.returncode != 0:
        ended = f"it {how_it_ended(process.returncode)} without an answer" if process is not None else ""
        if ran_on and refused.strip():  # its own words are not why
            words = refused.strip() + (f"\nit said: {words}" if words else "")
        raise CommandError(f"{rigid.label}: {words or refused.strip() or ended or how_it_ended(asking.returncode)}")
    answer: dict[str, object] = json.loads(answered)
    return answer


def _lacking(name: str) -> str:
    """Why an engine under Node.js cannot be asked without a download into a build that SUNDER_BUILD_DIR names, and what
    gets it; '' where it can. A list downloads nothing there."""
    if name not in _under_node() or named_build() is None:
        return ""
    folder = npm_folder("node", NODE_SOURCES)
    return "" if has_packages(folder, NODE_SOURCES) else f"not here: --rigid {name} downloads it to {folder}"


def table(executables: Executables) -> str:
    """The table that `sunder engines` prints."""
    lines = []
    for name in names(executables):
        if lacking := _lacking(name):
            lines.append(f"{name:<12} -          {lacking}")
            continue
        try:
            who = hello(resolve(name, executables), executables)
            words = who["capabilities"]
            assert isinstance(words, list)
            lines.append(f"{name:<12} {who['version']!s:<10} {' '.join(words)}")
        except CommandError as error:
            lines.append(f"{name:<12} -          not here: {error}")
    if DART not in names(executables):
        lines.append(f"{DART:<12} -          {how_dart_comes()}")
    lines.append(f"{IN_PROCESS}[:NAME] runs one of those that are C++ in the fracture process itself")
    return "\n".join(lines)
