"""`sunder report package`: the Debian package beside the programs of this checkout.

The package is unpacked into a folder, not installed. Its command runs a scene there. Then the packaged programs for this
processor and the native ones run one scene in turns, and the least times of their force kernels are compared.
"""
from __future__ import annotations

import os
import subprocess
import tempfile
import time
from pathlib import Path

from sunder_tools.errors import BAD_INPUT, PEER_LOST, CommandError
from sunder_tools.launch.build import Executables, ensure_built, only_builder
from sunder_tools.launch.install import PACKAGE_PACKAGES, PACKAGES, ensure_installed
from sunder_tools.launch.level import level
from sunder_tools.launch.logged import run_logged, tail
from sunder_tools.launch.run import launch_once
from sunder_tools.places import REPOSITORY

PRESET = "package"
LOG = "package.log"
RUNS, PRINTED = "cut_pane.textproto", "0.0005"  # the scene of the installed command, and until when [s]
SCENE, SETTINGS = "pressed_plate.textproto", ["end_time_s=1e-4"]  # no crack yet: the force kernel takes most of it
ROUNDS = 20  # short ones: other programs only make a run slower, and some run is left in peace
CAD_LIBRARY = "libTKernel"  # what a program with OpenCASCADE is linked with


def measure_package(deb: Path | None) -> dict[str, float]:
    """Returns the numbers of a package, which is built where none is given. Raises CommandError."""
    numbers: dict[str, float] = {}
    if deb is None:
        start = time.monotonic()
        deb = build_package()
        numbers["package_build_s"] = time.monotonic() - start
    with tempfile.TemporaryDirectory(prefix="package-sunder-") as name:
        root = Path(os.path.realpath(name))
        unpack(deb, root)
        numbers["package_run_s"] = run_installed(root)
        packaged = level(root / "usr" / "libexec" / "sunder")
        numbers["package_megabytes"] = deb.stat().st_size / 1e6
        numbers["package_reads_cad"] = float(reads_cad(packaged / "sunder-shell"))
        return numbers | compared(Executables(*(packaged / each for each in ("sunder-shell", "sunder-rigid", "sunder-single"))),
                                  ensure_built())


def build_package() -> Path:
    """Builds the package by its preset; returns the file. Raises CommandError."""
    folder = REPOSITORY / "build"
    log = folder / LOG
    folder.mkdir(exist_ok=True)
    with only_builder(folder / "lock"):
        ensure_installed(folder / "install.log", PACKAGES + PACKAGE_PACKAGES)
        log.unlink(missing_ok=True)
        for command in (["cmake", "--preset", PRESET], ["cmake", "--build", "--preset", PRESET], ["cpack", "--preset", PRESET]):
            if run_logged(command, log, REPOSITORY, None) != 0:
                raise CommandError(f"{tail(log, 20)}\n'{' '.join(command)}' failed; the whole log is {log}", PEER_LOST)
    made = max(folder.glob("sunder_*.deb"), key=lambda path: path.stat().st_mtime, default=None)
    if made is None:
        raise CommandError(f"cpack has left no sunder_*.deb in {folder}; the whole log is {log}", PEER_LOST)
    return made


def unpack(deb: Path, root: Path) -> None:
    """Unpacks a package into an empty folder. Raises CommandError for a file that is none of this project."""
    if not deb.is_file():
        raise CommandError(f"--deb {deb}: there is no such file; 'sunder report package' builds one", BAD_INPUT)
    done = _said(["dpkg", "-x", str(deb), str(root)])
    if done.returncode != 0 or not (root / "usr" / "bin" / "sunder").exists():
        raise CommandError(f"--deb {deb}: is no package of Sunder; {done.stderr.strip() or 'it has no usr/bin/sunder'}; "
                           "'sunder report package' builds one", BAD_INPUT)


def run_installed(root: Path) -> float:
    """Runs a scene of the package by its command, with pictures; returns the seconds. Raises CommandError."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("SUNDER_")}
    environment["XDG_CACHE_HOME"] = str(root / "cache")
    start = time.monotonic()
    done = subprocess.run([str(root / "usr" / "bin" / "sunder"), "run", str(root / "usr" / "share" / "sunder" / "scenes" / RUNS),
                           "--until", PRINTED, "--out", str(root / "run")], cwd=root, env=environment, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", check=False)
    if done.returncode != 0:
        raise CommandError(f"the packaged 'sunder run' ended with status {done.returncode}:\n{done.stdout[-2000:].strip()}", PEER_LOST)
    return time.monotonic() - start


def _said(command: list[str]) -> subprocess.CompletedProcess[str]:
    """Runs a tool. Raises CommandError where it is not installed."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise CommandError(f"{command[0]}: {error.strerror}; apt-get install dpkg binutils", BAD_INPUT) from None


def reads_cad(shell: Path) -> bool:
    """Tells whether a program was built with OpenCASCADE. Raises CommandError where that cannot be told."""
    done = _said(["objdump", "-p", str(shell)])
    if done.returncode != 0:
        raise CommandError(f"{shell}: cannot be read: {done.stderr.strip()}", BAD_INPUT)
    return CAD_LIBRARY in done.stdout


def compared(packaged: Executables, native: Executables) -> dict[str, float]:
    """Runs both in turns; returns the least seconds of the force kernels of each, and their ratio."""
    seconds: dict[str, list[float]] = {"package": [], "native": []}
    for round_ in range(ROUNDS):
        both = [("package", packaged), ("native", native)]
        for name, executables in both if round_ % 2 else both[::-1]:
            print(f"sunder: round {round_ + 1} of {ROUNDS}, {name}", flush=True)
            seconds[name].append(force_s(executables))
    least = {name: min(each) for name, each in seconds.items()}
    return {"package_force_s": least["package"], "native_force_s": least["native"],
            "package_force_time_ratio": least["package"] / least["native"]}


def force_s(executables: Executables) -> float:
    """Runs the scene; returns the seconds of its force kernels. Raises CommandError."""
    with tempfile.TemporaryDirectory(prefix="package-sunder-") as folder:
        run = launch_once(executables, REPOSITORY / "scenes" / SCENE, Path(folder), SETTINGS)
    time_ = run["time"]
    assert isinstance(time_, dict)
    return float(time_["stage_s"]["internal_force"])
