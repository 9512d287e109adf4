"""One run: checks the scene, launches both processes, watches them, settles the outcome."""
from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Callable, Iterator

from ..errors import BAD_INPUT, DONE, INTERRUPTED, PEER_LOST, CommandError, Interrupted, how_it_ended
from ..report import run_json
from ..report.profile import PROFILE_FILE, PROFILE_PICTURE, read_profile, table
from ..report.summary import summary
from ..words import own_command
from . import engines, first_use
from .build import Executables
from .needs import built_for
from .folder import RunFolder, open_folder, refuse_foreign, refuse_own, reopen_folder
from .logged import tail
from .socket_dir import SocketDir
from .tee import Tee
from .watch import Ending, watch

COMMAND_FILE, RECORD_FILE, TRACE_FILE = "command.json", "session.rec", "trace.json"
USAGE_FILE = "usage.json"
DEFAULT_ENGINE = "bullet"
Draw = Callable[[Path], Path]


@dataclass(frozen=True)
class Job:
    """What is to be run, as `command.json` in the run folder keeps it."""
    scene: Path
    engine: str = DEFAULT_ENGINE
    settings: tuple[str, ...] = ()
    until: str | None = None
    threads: str | None = None
    keys: Path | None = None
    record: bool = False
    trace: bool = False
    fidelity: str | None = None  # of which preset some of the settings are
    profile: bool = False
    pictures: bool = True        # whether they are to be drawn at the end, also when the run goes on

    def shell_arguments(self) -> list[str]:
        """Arguments of the fracture process, without --out and the rigid side."""
        out = ["--scene", str(self.scene)]
        for setting in self.settings:
            out += ["--set", setting]
        out += ["--profile"] if self.profile else []
        return out + (["--until", self.until] if self.until else [])

    def write(self, folder: Path) -> None:
        """Writes command.json, from which the run can be resumed or replayed."""
        (folder / COMMAND_FILE).write_text(json.dumps(
            {"scene": str(self.scene.resolve()), "engine": engines.from_anywhere(self.engine), "settings": list(self.settings),
             "until": self.until, "threads": self.threads, "fidelity": self.fidelity, "pictures": self.pictures},
            indent=2) + "\n")

    @staticmethod
    def read(folder: Path) -> "Job":
        """Reads command.json. Raises CommandError where it is missing or incomplete."""
        path = folder / COMMAND_FILE
        try:
            kept = json.loads(path.read_text())
            return Job(Path(kept["scene"]), str(kept["engine"]), tuple(str(s) for s in kept["settings"]),
                       kept["until"], kept["threads"], fidelity=kept.get("fidelity"),
                       pictures=kept.get("pictures", True) is not False)
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise CommandError(f"{path}: does not say what was run ({error}); name the folder of a run") from None


def run_scene(job: Job, out: Path | None, quiet: bool, resume: Path | None = None, draw: Draw | None = None,
              draw_profile: Draw | None = None) -> int:
    """Runs a scene from check to pictures; returns the exit status. Raises CommandError.

    `draw` draws the pictures of a run folder and returns the file; there are none without it. `draw_profile` draws that of
    its profile.json, where the job asks for one.
    """
    if out is not None:
        refuse_foreign(out)
        refuse_own(out, job.scene)
    executables = built_for(job.scene)
    rigid = engines.resolve(job.engine, executables)
    if job.keys and not rigid.endpoint:
        raise CommandError(f"--keys {job.keys}: is for an engine that waits at an address, --rigid tcp://HOST:PORT; "
                           "leave it out, this run's own is reached through a folder that only you may enter")
    # All that can be refused is, before anything of an earlier run in the folder is touched.
    _check_quietly([str(executables.shell), *job.shell_arguments(), "--check"], job.scene)
    engines.check(job.engine, rigid, executables)
    folder = reopen_folder(resume) if resume else open_folder(out, job.scene)
    keep = resume is not None
    try:
        if not resume:
            job.write(folder.path)
        shell = [*job.shell_arguments(), "--out", str(folder.path)]
        shell += ["--threads", job.threads] if job.threads else []
        shell += ["--quiet"] if quiet else []
        shell += ["--resume"] if resume else []
        shell += ["--record", str(folder.path / RECORD_FILE)] if job.record else []
        shell += ["--trace", str(folder.path / TRACE_FILE)] if job.trace else []
        if job.profile:  # that of an earlier start is not of this one
            for name in (PROFILE_FILE, PROFILE_PICTURE):
                (folder.path / name).unlink(missing_ok=True)
        shell += ["--rigid-program", rigid.program] if job.trace and rigid.command else []
        shell += ["--keys", str(job.keys)] if job.keys else []
        with _counted_interrupts() as interrupts:
            ending = _launch(shell, rigid, executables, folder.path, interrupts)
        status, message = _verdict(ending, folder.path, rigid.program)
        # Refused, or interrupted before there was anything: as if the run had not been started.
        keep = keep or folder.has_frames() or (status != BAD_INPUT and status != INTERRUPTED) or (
            status == INTERRUPTED and ending.shell == INTERRUPTED and (folder.path / "run.json").exists())
        if message:
            print(f"sunder: {message}", file=sys.stderr, flush=True)
        going_on = ""
        if status != DONE and (folder.path / "checkpoint" / "state").is_file():
            going_on = ("the run can go on from its last checkpoint: "
                        f"{own_command('run', '--resume', folder.path)}")
        if keep and not (resume and status == BAD_INPUT):
            _settle_run_json(folder.path, status, message, ending, going_on)
            _finish(folder, quiet, draw)
            if job.profile:
                _show_profile(folder.path, quiet, draw_profile)
        if going_on:
            print(f"sunder: {going_on}", file=sys.stderr)
        return status
    finally:
        if not keep and not folder.has_frames():
            folder.discard()
        folder.close()


def launch_once(executables: Executables, scene: Path, folder: Path, settings: list[str],
                engine: str = DEFAULT_ENGINE) -> dict[str, object]:
    """Runs a scene into an existing, empty folder without pictures; returns run.json. Raises CommandError."""
    job = Job(scene, engine, tuple(settings))
    rigid = engines.resolve(engine, executables)
    with _counted_interrupts() as interrupts:
        ending = _launch([*job.shell_arguments(), "--out", str(folder), "--quiet"],
                         rigid, executables, folder, interrupts)
    if ending.interrupted:
        raise Interrupted
    status, message = _verdict(ending, folder, rigid.program)
    if status != DONE:
        raise CommandError(f"{scene.name}: {message or tail(folder / 'shell.log', 3)}", status)
    return run_json.read_run(folder)


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
    """Context: Ctrl-C, SIGTERM and SIGHUP each add an entry to the list it yields, and do nothing else."""
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


def _launch(shell: list[str], rigid: engines.Rigid, executables: Executables, folder: Path,
            interrupts: list[int]) -> Ending:
    """Starts the processes and watches them. Each has its own session, so that Ctrl-C reaches only the launcher."""
    processes: list[subprocess.Popen[bytes]] = []
    before, start = _processor_s(), time.monotonic()
    with SocketDir() as socket:
        endpoint = rigid.endpoint or socket.endpoint
        try:
            tee = Tee(folder / "shell.log")
            with (folder / "rigid.log").open("wb") as rigid_log:
                if rigid.command:
                    processes.append(subprocess.Popen(
                        [*rigid.command, "--endpoint", endpoint, "--die-with-parent"], stdin=subprocess.DEVNULL,
                        stdout=rigid_log, stderr=subprocess.STDOUT, start_new_session=True))
            where = ["--engine", rigid.in_process] if rigid.in_process else ["--endpoint", endpoint]
            where += ["--rigid-process", str(processes[0].pid)] if processes else []
            program = executables.single if rigid.in_process else executables.shell
            # Threads that spin while they wait for one another take the core that the other needs. Threads that sleep at
            # once wake late. A new crack edge is a few loops of tens of microseconds, so they spin for as long.
            patient = {"OMP_WAIT_POLICY": "passive", "GOMP_SPINCOUNT": "2000"}
            environment = os.environ if patient.keys() & os.environ.keys() else {**os.environ, **patient}
            processes.append(subprocess.Popen([str(program), *shell, *where, "--die-with-parent"],
                                              stdin=subprocess.DEVNULL, stdout=tee.child_end, stderr=tee.child_end,
                                              start_new_session=True, env=environment))
            tee.started()
            ending = watch(processes[-1], processes[0] if rigid.command else None, interrupts)
            tee.join()
            _write_usage(folder, _processor_s() - before, time.monotonic() - start)
            return ending
        except OSError as error:
            raise CommandError(f"cannot launch: {error.filename}: {error.strerror}") from None
        finally:
            for process in processes:
                if process.poll() is None:
                    process.kill()
                    process.wait()


def _processor_s() -> float:
    """Processor time of all children that have ended, also of other threads [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def read_usage(folder: Path) -> dict[str, float]:
    """`processor_s` of both processes and `wall_s` [s], summed over all starts of the run; {} where it is not known."""
    try:
        kept = json.loads((folder / USAGE_FILE).read_text())
        return {name: float(kept[name]) for name in ("processor_s", "wall_s")}
    except (OSError, ValueError, KeyError, TypeError):
        return {}


def _write_usage(folder: Path, processor_s: float, wall_s: float) -> None:
    """Writes usage.json. A resumed run adds to the usage of its earlier starts."""
    earlier = read_usage(folder)
    total = {"processor_s": earlier.get("processor_s", 0.0) + processor_s, "wall_s": earlier.get("wall_s", 0.0) + wall_s}
    try:
        (folder / USAGE_FILE).write_text(json.dumps(total) + "\n")
    except OSError as error:  # of a full disk the solver has spoken already
        print(f"sunder: {folder / USAGE_FILE}: {error.strerror}", file=sys.stderr)


def _verdict(ending: Ending, folder: Path, program: str) -> tuple[int, str]:
    """Exit status of the run, and a sentence for the user, '' where the shell process has said everything.

    `program`: the rigid side's, as messages call it.
    """
    shell, rigid = ending.shell, ending.rigid
    rigid_died = rigid != 0 and not ending.rigid_was_signalled
    of_rigid = f"the rigid-body process ({program}) {how_it_ended(rigid)}"
    if ending.killed_by_user:
        return INTERRUPTED, "killed at the second interruption; there is no last frame and no state hash"
    if ending.interrupted and (shell in (INTERRUPTED, -signal.SIGINT)):
        return INTERRUPTED, "" if shell == INTERRUPTED else "interrupted before the run had begun"
    if rigid_died and rigid == BAD_INPUT and (shell in (PEER_LOST, BAD_INPUT) or ending.shell_was_signalled):
        windows = (run_json.read_run(folder).get("time") or {}).get("windows") or 0
        refused = f"refused to go on after {windows} windows" if windows else "refused to start"
        return BAD_INPUT, f"{tail(folder / 'rigid.log', 5)}\nthe rigid-body process ({program}) {refused}".strip()
    if ending.shell_was_signalled:
        what = (f"{of_rigid}{_last_words(folder / 'rigid.log')}" if rigid_died
                else f"the rigid-body process ({program}) ended early")
        return PEER_LOST, f"{what}, the fracture process did not end by itself and was stopped; see {folder}/rigid.log"
    if shell < 0 and (not (rigid_died and ending.rigid_first) or rigid == PEER_LOST):  # status 3 says that the shell ended first
        return PEER_LOST, f"the fracture process (sunder-shell) {how_it_ended(shell)}; see {folder}/shell.log"
    if (shell == PEER_LOST or shell < 0) and rigid_died:
        told = (run_json.read_run(folder).get("error") or {}).get("kind", "peer_lost") != "peer_lost"  # by the shell's side
        return PEER_LOST, f"{of_rigid}{'' if told else _last_words(folder / 'rigid.log')}; see {folder}/rigid.log"
    if shell == PEER_LOST:
        return PEER_LOST, f"the fracture process lost the rigid-body process ({program}); see {folder}/shell.log and rigid.log"
    if shell == DONE and rigid_died:
        return PEER_LOST, f"{of_rigid} after the run was complete; see {folder}/rigid.log"
    if shell == DONE and ending.rigid_was_signalled:
        return DONE, f"note: the rigid-body process ({program}) did not end after goodbye and was stopped; see {folder}/rigid.log"
    return shell, ""


def _last_words(log: Path) -> str:
    """The last line of a log, as a part of a sentence; '' where there is none."""
    last = tail(log, 1).strip()
    return f" and said last: {last}" if last else ""


def _settle_run_json(folder: Path, status: int, message: str, ending: Ending, going_on: str) -> None:
    """Completes run.json where the shell process could not say how the run ended. Where a process was lost, its message
    also says `going_on`."""
    written = run_json.read_run(folder).get("status")
    shell_was_cut = ending.shell < 0 or ending.shell_was_signalled or ending.killed_by_user
    try:
        if shell_was_cut:
            if status == INTERRUPTED:
                run_json.mark(folder, "interrupted", "", "")
            else:
                run_json.mark(folder, "failed", "peer_lost", message)
        elif written not in run_json.ENDED or (written == "done" and ending.shell != DONE):
            kind = {PEER_LOST: "peer_lost", BAD_INPUT: "bad_input"}.get(status, "unknown")
            if status == INTERRUPTED:
                run_json.mark(folder, "interrupted", "", "")
            else:
                run_json.mark(folder, "failed", kind, message or f"sunder-shell ended with status {ending.shell} "
                            "without finishing run.json; see shell.log")
        if status == PEER_LOST and going_on:
            run_json.extend_message(folder, going_on)
    except OSError as error:
        print(f"sunder: cannot update {folder}/run.json: {error.strerror}", file=sys.stderr)


def _finish(folder: RunFolder, quiet: bool, draw: Draw | None) -> None:
    """Draws pictures and prints the summary. A failed picture does not change the outcome of the run."""
    sheet: Path | None = None
    if draw is None:  # one of before it was resumed would show another state
        (folder.path / "contact_sheet.png").unlink(missing_ok=True)
    if draw is not None and folder.has_frames():
        try:
            if not quiet:
                print("sunder: drawing the pictures", file=sys.stderr, flush=True)
            start = time.monotonic()
            sheet = draw(folder.path)
            first_use.drawn()
            if not quiet:
                print(f"sunder: drew them in {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
        except (Interrupted, KeyboardInterrupt):
            print("sunder: interrupted, no pictures", file=sys.stderr)
        except Exception as error:  # noqa: BLE001: whatever it is, the run itself stands
            print(f"sunder: no contact sheet: {type(error).__name__}: {error}", file=sys.stderr)
    if not quiet:
        print(summary(folder.path, sheet), flush=True)


def _show_profile(folder: Path, quiet: bool, draw: Draw | None) -> None:
    """Prints the table of profile.json and draws its picture. The solver writes none of a run that fails."""
    profile = read_profile(folder)
    if profile is None:
        print(f"sunder: no profile: the run did not come to its {PROFILE_FILE}", file=sys.stderr)
        return
    if not quiet:
        print(table(profile), flush=True)
    try:
        if draw is not None:
            draw(folder)
    except (CommandError, OSError) as error:  # the run and its numbers stand
        print(f"sunder: no {PROFILE_PICTURE}: {error}", file=sys.stderr)
