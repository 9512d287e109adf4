"""`sunder run`: check, launch both processes, watch them, tell how it went."""
from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Iterator

from . import report
from .build import Executables, ensure_built
from .errors import BAD_INPUT, DONE, INTERRUPTED, PEER_LOST, CommandError, Interrupted, how_it_ended
from .folder import RunFolder, open_folder, refuse_foreign
from .logged import tail
from .socket_dir import SocketDir
from .tee import Tee
from .watch import Ending, watch


def run_scene(scene: Path, out: Path | None, engine: str, settings: list[str], until: str | None,
              threads: str | None, quiet: bool) -> int:
    """Runs a scene from check to pictures; returns the exit status. Raises CommandError."""
    if out is not None:
        refuse_foreign(out)
    executables = ensure_built()
    rigid = _engine_command(engine, executables)
    set_arguments = [part for setting in settings for part in ("--set", setting)]
    # All that can be refused is, before anything of an earlier run in the folder is touched.
    until_arguments = ["--until", until] if until else []
    _check_quietly([str(executables.shell), "--scene", str(scene), "--check", *set_arguments, *until_arguments], scene)
    if "/" not in engine:
        _check_quietly([*rigid, "--check"], scene)
    folder = open_folder(out, scene)
    keep = False
    try:
        shell = [str(executables.shell), "--scene", str(scene), "--out", str(folder.path), *set_arguments]
        shell += until_arguments
        shell += ["--threads", threads] if threads else []
        shell += ["--quiet"] if quiet else []
        with _counted_interrupts() as interrupts:
            ending = _launch(shell, rigid, folder.path, interrupts)
        status, message = _verdict(ending, folder.path)
        # Refused, or interrupted before there was anything: as if the run had not been started.
        keep = folder.has_frames() or (status != BAD_INPUT and status != INTERRUPTED) or (
            status == INTERRUPTED and ending.shell == INTERRUPTED and (folder.path / "run.json").exists())
        if message:
            print(f"sunder: {message}", file=sys.stderr, flush=True)
        if keep:
            _settle_run_json(folder.path, status, message, ending)
            _finish(folder, quiet)
        return status
    finally:
        if not keep and not folder.has_frames():
            folder.discard()
        folder.close()


def launch_once(executables: Executables, scene: Path, folder: Path, settings: list[str]) -> dict[str, object]:
    """Runs a scene into an existing, empty folder without pictures; returns run.json. Raises CommandError."""
    set_arguments = [part for setting in settings for part in ("--set", setting)]
    shell = [str(executables.shell), "--scene", str(scene), "--out", str(folder), "--quiet", *set_arguments]
    with _counted_interrupts() as interrupts:
        ending = _launch(shell, _engine_command("bullet", executables), folder, interrupts)
    if ending.interrupted:
        raise Interrupted
    status, message = _verdict(ending, folder)
    if status != DONE:
        raise CommandError(f"{scene.name}: {message or tail(folder / 'shell.log', 3)}", status)
    return report.read_run(folder)


def _engine_command(engine: str, executables: Executables) -> list[str]:
    """The rigid process's command up to --engine; a path (with a '/') is a program of the user's."""
    if "/" not in engine:
        return [str(executables.rigid), "--engine", engine]
    if not (os.path.isfile(engine) and os.access(engine, os.X_OK)):
        raise CommandError(f"--rigid {engine}: not an executable file; give an engine's name or the path of a "
                           "program that takes --engine NAME --endpoint ADDRESS")
    return [os.path.abspath(engine), "--engine", Path(engine).stem]


def _check_quietly(command: list[str], scene: Path) -> None:
    """Raises CommandError with the process's words if it refuses."""
    result = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                            text=True, errors="replace", check=False)
    if result.returncode == 0:
        return
    if result.returncode == BAD_INPUT:
        raise CommandError(result.stderr.strip() or f"{scene}: refused without a reason")
    raise CommandError(f"{result.stderr.strip()}\n{Path(command[0]).name} {how_it_ended(result.returncode)} while checking "
                       f"{scene}".strip(), PEER_LOST if result.returncode < 0 else result.returncode)


@contextmanager
def _counted_interrupts() -> Iterator[list[int]]:
    """Within it Ctrl-C, SIGTERM and SIGHUP are only noted, one entry each, in the list it yields."""
    seen: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        del frame
        seen.append(number)

    numbers = [n for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
               if signal.getsignal(n) != signal.SIG_IGN]
    before = [signal.signal(number, note) for number in numbers]
    try:
        yield seen
    finally:
        for number, handler in zip(numbers, before):
            signal.signal(number, handler)


def _launch(shell: list[str], rigid: list[str], folder: Path, interrupts: list[int]) -> Ending:
    """Starts both, each in its own session so that Ctrl-C reaches only the launcher, and watches."""
    processes: list[subprocess.Popen[bytes]] = []
    with SocketDir() as socket:
        common = ["--endpoint", socket.endpoint, "--die-with-parent"]
        try:
            tee = Tee(folder / "shell.log")
            with (folder / "rigid.log").open("wb") as rigid_log:
                processes.append(subprocess.Popen([*rigid, *common], stdin=subprocess.DEVNULL, stdout=rigid_log,
                                                  stderr=subprocess.STDOUT, start_new_session=True))
            # Threads that spin while they wait for one another take the core that the other needs.
            patient = {"OMP_WAIT_POLICY": "passive", **os.environ}
            processes.append(subprocess.Popen([*shell, *common], stdin=subprocess.DEVNULL, stdout=tee.child_end,
                                              stderr=tee.child_end, start_new_session=True, env=patient))
            tee.started()
            ending = watch(processes[1], processes[0], interrupts)
            tee.join()
            return ending
        except OSError as error:
            raise CommandError(f"cannot launch: {error.filename}: {error.strerror}") from None
        finally:
            for process in processes:
                if process.poll() is None:
                    process.kill()
                    process.wait()


def _verdict(ending: Ending, folder: Path) -> tuple[int, str]:
    """Exit status of the run, and a sentence for the user ('' if the shell said all there is)."""
    shell, rigid = ending.shell, ending.rigid
    rigid_died = rigid != 0 and not ending.rigid_was_signalled
    of_rigid = f"the rigid-body process (sunder-rigid) {how_it_ended(rigid)}"
    if ending.killed_by_user:
        return INTERRUPTED, "killed at the second interruption; there is no last frame and no state hash"
    if ending.interrupted and (shell in (INTERRUPTED, -signal.SIGINT)):
        return INTERRUPTED, "" if shell == INTERRUPTED else "interrupted before the run had begun"
    if rigid_died and rigid == BAD_INPUT and (shell in (PEER_LOST, BAD_INPUT) or ending.shell_was_signalled):
        return BAD_INPUT, f"{tail(folder / 'rigid.log', 5)}\nthe rigid-body process refused to start".strip()
    if ending.shell_was_signalled:
        what = of_rigid if rigid_died else "the rigid-body process ended early"
        return PEER_LOST, f"{what}, the fracture process did not end by itself and was stopped; see {folder}/rigid.log"
    if shell < 0 and not (rigid_died and ending.rigid_first):
        return PEER_LOST, f"the fracture process (sunder-shell) {how_it_ended(shell)}; see {folder}/shell.log"
    if (shell == PEER_LOST or shell < 0) and rigid_died:
        return PEER_LOST, f"{of_rigid}; see {folder}/rigid.log"
    if shell == PEER_LOST:
        return PEER_LOST, f"the fracture process lost the rigid-body process; see {folder}/shell.log and rigid.log"
    if shell == DONE and rigid_died:
        return PEER_LOST, f"{of_rigid} after the run was complete; see {folder}/rigid.log"
    if shell == DONE and ending.rigid_was_signalled:
        return DONE, f"note: the rigid-body process did not end after goodbye and was stopped; see {folder}/rigid.log"
    return shell, ""


def _settle_run_json(folder: Path, status: int, message: str, ending: Ending) -> None:
    """Sees to it that run.json says how the run ended, where the shell could not."""
    written = report.read_run(folder).get("status")
    shell_was_cut = ending.shell < 0 or ending.shell_was_signalled or ending.killed_by_user
    try:
        if shell_was_cut:
            if status == INTERRUPTED:
                report.mark(folder, "interrupted", "", "")
            else:
                report.mark(folder, "failed", "peer_lost", message)
        elif written not in report.ENDED or (written == "done" and ending.shell != DONE):
            kind = {PEER_LOST: "peer_lost", BAD_INPUT: "bad_input"}.get(status, "unknown")
            if status == INTERRUPTED:
                report.mark(folder, "interrupted", "", "")
            else:
                report.mark(folder, "failed", kind, message or f"sunder-shell ended with status {ending.shell} "
                            "without finishing run.json; see shell.log")
    except OSError as error:
        print(f"sunder: cannot update {folder}/run.json: {error.strerror}", file=sys.stderr)


def _finish(folder: RunFolder, quiet: bool) -> None:
    """Pictures and summary. A picture that fails never changes the outcome of the run."""
    sheet: Path | None = None
    if folder.has_frames():
        try:
            if not quiet:
                print("sunder: drawing the pictures", file=sys.stderr, flush=True)
            from .pictures import write_contact_sheet  # numpy and PIL only now
            start = time.monotonic()
            sheet = write_contact_sheet(folder.path)
            if not quiet:
                print(f"sunder: drew them in {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
        except (Interrupted, KeyboardInterrupt):
            print("sunder: interrupted, no pictures", file=sys.stderr)
        except Exception as error:  # noqa: BLE001: whatever it is, the run itself stands
            print(f"sunder: no contact sheet: {type(error).__name__}: {error}", file=sys.stderr)
    if not quiet:
        print(report.summary(folder.path, sheet), flush=True)
