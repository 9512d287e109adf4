"""Configures and builds what has changed. One process builds at a time."""
from __future__ import annotations

import errno
import fcntl
import os
import re
import shutil
import signal
import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Iterator

from ..errors import CommandError, how_it_ended
from ..places import BUILD_DIR_VARIABLE, CHECKOUT_ONLY, INSTALLED, PROGRAMS, REPOSITORY
from ..words import command_line
from . import first_use
from .install import CAD_PACKAGES, DART_PACKAGES, PACKAGES, TEST_PACKAGES, ensure_installed
from .level import level
from .logged import run_logged, tail

MEMORY_PER_JOB = 1.9e9  # [bytes]; files that are compiled together take about this much
LOG = "build.log"  # beside the lock
POLL_S, TELL_S = 0.2, 15.0  # [s] between looks at the lock of another builder, and between words of how far it is
STEP_LINES = 400  # of the log in which its last step is looked for: warnings stand between
NOT_WRITABLE = (errno.EACCES, errno.EPERM, errno.EROFS)
SOURCE_ROOMS, SOURCE_ENDINGS = ("proto", "coupler", "shell", "rigid"), (".cpp", ".h", ".proto")
OF_A_SHELL, INTERRUPTED_NINJA = 128, "interrupted by user"  # status beyond which a number of a signal is; what ninja says then
OF_A_RUN = ("sunder-shell", "sunder-rigid")
UNTESTED = (*OF_A_RUN, "sunder-single")  # all that is built without the packages of tests
DART = "sunder-rigid-dart"  # a program that is built on request only
# Options of CMake that the build tree remembers once they are asked for, and their packages.
OPTIONS = {"SUNDER_CAD": CAD_PACKAGES, "SUNDER_DART": DART_PACKAGES}


@dataclass(frozen=True)
class Executables:
    """Where the two programs are."""
    shell: Path
    rigid: Path
    single: Path  # both in one

    @property
    def dart(self) -> Path:
        """The engine of DART, which may not be built."""
        return self.rigid.with_name(DART)


def build_dir() -> Path:
    """The folder with the executables: SUNDER_BUILD_DIR, else build/release of this checkout."""
    return Path(os.environ.get(BUILD_DIR_VARIABLE) or REPOSITORY / "build" / "release").absolute()


def ensure_built(all_targets: bool = False, cad: bool = False, targets: tuple[str, ...] = (), dart: bool = False) -> Executables:
    """Installs packages and builds as far as needed; quick when nothing is. Raises CommandError.

    Always what a run needs; `targets` beside that, or all. The packages of tests are installed for these only.
    `cad`: with OpenCASCADE, now and, as the build tree remembers it, from now on; an installation and a build that
    SUNDER_BUILD_DIR names stay as they are. `dart`: with the engine of DART, likewise; where it is not in such a build,
    that is an error. A build that is finished serves users who may not write to it.
    """
    testing = all_targets or any(target not in UNTESTED for target in targets)
    targets += (DART,) if dart else ()
    options = [name for name, asked in zip(OPTIONS, (cad, dart)) if asked]
    if INSTALLED.is_file() and not os.environ.get(BUILD_DIR_VARIABLE):
        if testing or dart:
            raise CommandError(f"this {CHECKOUT_ONLY}")
        programs = level(PROGRAMS)
        return Executables(*(programs / name for name in UNTESTED))
    folder = build_dir()
    found = Executables(folder / "shell" / "sunder-shell", folder / "rigid" / "sunder-rigid",
                        folder / "coupler" / "single" / "sunder-single")
    if os.environ.get(BUILD_DIR_VARIABLE):
        for path in (found.shell, found.rigid):
            if not os.access(path, os.X_OK):
                raise CommandError(f"{path} is not an executable; {BUILD_DIR_VARIABLE} is {folder}, it must "
                                   "name a build folder, or be unset to build this checkout")
        missing = _missing(found, targets)
        if missing:
            raise CommandError(f"{folder} lacks {', '.join(missing)}, and {BUILD_DIR_VARIABLE} names it: nothing is built then; "
                               f"run: {by_cmake(folder, missing)}, or unset {BUILD_DIR_VARIABLE}")
        return found
    try:
        folder.parent.mkdir(exist_ok=True)
        with only_builder(folder.parent / "lock"):
            ensure_installed(folder.parent / "install.log",
                             PACKAGES + (TEST_PACKAGES if testing else ()) + sum((OPTIONS[name] for name in options), ()))
            _build(folder, folder.parent / LOG, [] if all_targets else [*OF_A_RUN, *targets], testing, options)
    except OSError as error:
        lacks = all_targets or not all(_has(folder, name) for name in options) or _missing(found, (*OF_A_RUN, *targets))
        if error.errno in NOT_WRITABLE and not lacks:
            _say_if_old(found)
            return found
        raise CommandError(f"cannot build in {folder.parent}: {error.strerror or error}: {error.filename}; mend that, or set "
                           f"{BUILD_DIR_VARIABLE} to a build folder whose programs are built") from None
    return found


def _missing(found: Executables, targets: tuple[str, ...]) -> list[str]:
    """Those of the targets that are no executables, of all that is built without the packages of tests."""
    places = zip((*UNTESTED, DART), (found.shell, found.rigid, found.single, found.dart))
    return [name for name, path in places if name in targets and not os.access(path, os.X_OK)]


def by_cmake(folder: Path, targets: list[str]) -> str:
    """The command that builds these targets in a configured folder."""
    build = command_line(["cmake", "--build", folder, "--target", *targets])
    if DART not in targets:
        return build
    return (f"{command_line(['cmake', '-S', REPOSITORY, '-B', folder, '-DSUNDER_DART=ON'])} && {build} (before that, as root: "
            f"apt-get install -y --no-install-recommends {' '.join(DART_PACKAGES)})")


def how_dart_comes() -> str:
    """Where the engine of DART is not built: what brings it here, in words that follow its name."""
    if INSTALLED.is_file():
        return "only from a checkout: 'coupler/sunder run SCENE --rigid dart' there installs and builds it"
    if os.environ.get(BUILD_DIR_VARIABLE):
        return f"not built, and {BUILD_DIR_VARIABLE} is set; run: {by_cmake(build_dir(), [DART])}"
    return "not built: --rigid dart installs and builds it"


def _say_if_old(found: Executables) -> None:
    """A note where sources are newer than the programs, which cannot be built anew."""
    built = min(found.shell.stat().st_mtime, found.rigid.stat().st_mtime)
    newer = next((path for room in SOURCE_ROOMS for path in (REPOSITORY / room).rglob("*")
                  if path.suffix in SOURCE_ENDINGS and path.stat().st_mtime > built), None)
    if newer is not None:
        print(f"sunder: note: {found.shell.parents[1]} may not be written to, and {newer.relative_to(REPOSITORY)} is newer than "
              f"its programs; they run as they are. {BUILD_DIR_VARIABLE} may name another build", file=sys.stderr, flush=True)


@contextmanager
def only_builder(path: Path) -> Iterator[None]:
    """Holds the lock file; waits while another `sunder` holds it, and says so and how far that is."""
    with path.open("a") as lock:
        if not _locks(lock):
            print("sunder: another sunder is building here; waiting for it", file=sys.stderr, flush=True)
            log, begun, told = path.with_name(LOG), time.time(), ""
            due = time.monotonic() + TELL_S
            while not _locks(lock):
                time.sleep(POLL_S)
                if time.monotonic() < due:
                    continue
                due += TELL_S
                step = _last_step(log, begun)
                if step and step != told:
                    print(f"sunder: waiting; the other one builds {step}", file=sys.stderr, flush=True)
                    told = step
        yield


def _locks(lock: IO[str]) -> bool:
    """Takes the lock if it is free; tells whether it has."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    except BlockingIOError:
        return False


def _last_step(log: Path, since: float) -> str:
    """The last step '[i/n]' of a log to which something was written since then [s], '' where there is none."""
    try:
        if log.stat().st_mtime < since:
            return ""
    except OSError:
        return ""
    found = re.findall(r"^\[\d+/\d+\](?! Re-)", tail(log, STEP_LINES), re.M)
    return found[-1] if found else ""


def _needs_configure(folder: Path) -> bool:
    """True if there is no usable build tree. A tree of another checkout (moved, copied) is removed."""
    cache = folder / "CMakeCache.txt"
    if not cache.exists():
        return True
    home = re.search(r"^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$", cache.read_text(errors="replace"), re.M)
    if home is None or os.path.realpath(home.group(1)) != str(REPOSITORY):
        shutil.rmtree(folder)
        return True
    ninja = folder / "build.ninja"
    presets = REPOSITORY / "CMakePresets.json"  # ninja itself does not watch this one
    return not ninja.exists() or (presets.exists() and presets.stat().st_mtime > ninja.stat().st_mtime)


def _has(folder: Path, option: str) -> bool:
    """True if the build tree was configured with this option."""
    cache = folder / "CMakeCache.txt"
    return cache.exists() and re.search(rf"^{option}:BOOL=ON$", cache.read_text(errors="replace"), re.M) is not None


def _jobs() -> int:
    """As many compilers as there are processors and memory for."""
    processors = len(os.sched_getaffinity(0))
    available = re.search(r"^MemAvailable:\s+(\d+) kB", Path("/proc/meminfo").read_text(), re.M)
    memory = float(available.group(1)) * 1024 if available else float("inf")
    return max(1, min(processors, int(min(memory / MEMORY_PER_JOB, 1e6))))


def _build(folder: Path, log: Path, targets: list[str], testing: bool, options: list[str]) -> None:
    """Configures if needed and builds the targets, all where none is named; the whole output goes to `log`."""
    start = time.monotonic()
    log.unlink(missing_ok=True)
    fresh = _needs_configure(folder)
    if fresh or not all(_has(folder, name) for name in options) or (testing and not _has(folder, "BUILD_TESTING")):
        print("sunder: configuring", file=sys.stderr, flush=True)
        tests = "ON" if testing or _has(folder, "BUILD_TESTING") else "OFF"
        _checked(["cmake", "--preset", "release", f"-DBUILD_TESTING={tests}", *(f"-D{name}=ON" for name in options)], log,
                 "configuring")
        os.utime(folder / "build.ninja")  # newer than the presets, even where cmake left it as it was
    progress = _Progress()
    try:
        _checked(["cmake", "--build", str(folder), *(["--target", *targets] if targets else []), "-j", str(_jobs())], log,
                 "building", progress)
    finally:
        progress.close()
    if progress.worked:
        if fresh and targets == list(OF_A_RUN):
            first_use.built(folder.parent, time.monotonic() - start, progress.steps)
        print(f"sunder: built in {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)


def _checked(command: list[str], log: Path, what: str, progress: "_Progress | None" = None) -> None:
    try:
        status = run_logged(command, log, REPOSITORY, progress)
    except FileNotFoundError as error:
        raise CommandError(f"{what} failed: {error.filename} not found") from None
    if status != 0:
        if progress:
            progress.close()
        killed = status if status < 0 else OF_A_SHELL - status if OF_A_SHELL < status < OF_A_SHELL + signal.NSIG else 0
        if killed or INTERRUPTED_NINJA in tail(log, 3):
            how = f" ({command[0]} {how_it_ended(killed)})" if killed else ""
            raise CommandError(f"{what} was interrupted{how}; run this again, and it goes on from there; the whole log is {log}")
        raise CommandError(f"{tail(log, 40)}\n{what} failed with status {status}; the whole log is {log}")


class _Progress:
    """Turns ninja's '[i/n] ...' lines into one line that is rewritten (terminal) or said once."""

    def __init__(self) -> None:
        self.worked = False
        self.steps = 0
        self._terminal = sys.stderr.isatty()
        self._open = False

    def __call__(self, line: str) -> None:
        count = re.match(r"\[(\d+)/(\d+)\] (?!Re-)", line)  # "[0/2] Re-checking globbed directories...": counts no steps yet
        if not count:
            return
        if self._terminal:
            print(f"\rsunder: building [{count[1]}/{count[2]}]\x1b[K", end="", file=sys.stderr, flush=True)
            self._open = True
        elif not self.worked:
            print(f"sunder: building {count[2]} steps", file=sys.stderr, flush=True)
        self.worked, self.steps = True, int(count[2])

    def close(self) -> None:
        """Ends the line that was being rewritten."""
        if self._open:
            print(file=sys.stderr, flush=True)
        self._open = False
