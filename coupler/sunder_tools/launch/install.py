"""Debian packages: finds the missing ones and installs them."""
from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import time
from pathlib import Path

from ..errors import CommandError
from . import first_use
from .logged import run_logged, tail

PACKAGES = (
    "g++", "cmake", "ninja-build", "pkg-config", "libeigen3-dev", "libspectra-dev", "libcgal-dev", "libbullet-dev",
    "libode-dev", "libzmq3-dev", "cppzmq-dev", "libprotobuf-dev", "protobuf-compiler", "libfmt-dev", "libcli11-dev",
    "nlohmann-json3-dev", "libpng-dev", "libssl-dev", "python3", "python3-numpy", "python3-pil", "python3-protobuf",
)  # all that a run needs
TEST_PACKAGES = ("libgtest-dev", "libbenchmark-dev")  # all that tests, `validate` and `bench` cannot do without
LINT_PACKAGES = ("clang-format", "clang-tidy", "mypy", "pyflakes3")  # for a test only, of the sources
LOCALE_PACKAGES = ("locales",)  # for a test only, which makes a German one
SLURM_PACKAGES = ("munge", "slurmctld", "slurmd", "slurm-client")  # for a test only, which brings up one of its own
BROWSER_PACKAGES = ("chromium",)  # for a test only, of the viewer's page
FILM_PACKAGES = ("ffmpeg",)  # for `sunder render --film`
BLENDER_PACKAGES = ("blender",)  # for `sunder render --cycles`
PACKAGE_PACKAGES = ("dpkg-dev", "file")  # for cpack, which makes the Debian package
PLOT_PACKAGES = ("python3-matplotlib",)  # for plots of series, trades and validations
# OpenCASCADE. Its CMake files ask for those of TBB, and since 7.8 for fontconfig, on which its package does not depend.
CAD_PACKAGES = ("libocct-data-exchange-dev", "libtbb-dev", "libfontconfig-dev")
DART_PACKAGES = ("libdart-dev",)  # for `--rigid dart`; with all that it draws in, 245 MB
LOCK_WAIT_S = 300  # another apt may be at work, e.g. unattended-upgrades
# The names above are those of these distributions: ID and VERSION_ID of os-release, and whether a run was seen there.
DISTRIBUTIONS = {("debian", "12"): True, ("debian", "13"): True, ("ubuntu", "24.04"): False}
BY_HAND = ("a C++20 compiler, CMake 3.25, Ninja, pkg-config; with their headers Eigen 3.4, Spectra 1.0, CGAL 5.5, Bullet in "
           "double precision, ODE, ZeroMQ and cppzmq, Protobuf with protoc, fmt, libpng, OpenSSL, CLI11, nlohmann JSON; "
           "/usr/bin/python3 with numpy, Pillow and protobuf. Then 'cmake --preset release -DBUILD_TESTING=OFF && cmake --build build/release', and set "
           "SUNDER_BUILD_DIR to that folder")


def missing_packages(packages: tuple[str, ...] = PACKAGES) -> list[str]:
    """The packages of `packages` that dpkg does not list as installed.

    Raises CommandError where there is no dpkg: the names are of Debian and what is made from it.
    """
    try:
        listing = subprocess.run(
            ["dpkg-query", "-W", "-f=${Package} ${db:Status-Status}\n", *packages],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False).stdout
    except FileNotFoundError:
        raise CommandError(f"{_here()[2]} has no dpkg: packages are installed by name on {_supported()} only; install here: "
                           f"{BY_HAND}") from None
    installed = {line.split()[0] for line in listing.splitlines() if line.endswith(" installed")}
    return [name for name in packages if name not in installed]


def _here() -> tuple[str, str, str]:
    """ID, VERSION_ID and PRETTY_NAME of this distribution; ('', '', 'this system') where it does not say."""
    try:
        told = platform.freedesktop_os_release()
    except OSError:
        told = {}
    return told.get("ID", ""), told.get("VERSION_ID", ""), told.get("PRETTY_NAME", "this system")


def _supported() -> str:
    return ", ".join(f"{name.capitalize()} {number}{'' if tried else ' (names only, not tried)'}"
                     for (name, number), tried in DISTRIBUTIONS.items())


def _caution() -> str:
    """A sentence where nobody saw a run on this distribution; '' where somebody did."""
    name, number, words = _here()
    if DISTRIBUTIONS.get((name, number)):
        return ""
    known = "was not tried" if (name, number) in DISTRIBUTIONS else f"is none of {_supported()}"
    return f"{words} {known}; should a package be missing, install here: {BY_HAND}"


def _as_root() -> list[str] | None:
    """Prefix that makes a command run as root without a question; None if there is none."""
    if os.geteuid() == 0:
        return []
    if shutil.which("sudo") and subprocess.run(
            ["sudo", "-n", "true"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, check=False).returncode == 0:
        return ["sudo", "-n"]
    return None


def ensure_installed(log: Path, packages: tuple[str, ...] = PACKAGES) -> None:
    """Installs what is missing of `packages`; everything apt says goes to `log`. Raises CommandError."""
    missing = missing_packages(packages)
    if not missing:
        return
    command = f"apt-get update && apt-get install -y --no-install-recommends {' '.join(missing)}"
    prefix = _as_root()
    if prefix is None:
        raise CommandError(f"{len(missing)} Debian packages are missing and there is no right to install "
                           f"them without a password; run: sudo sh -c '{command}'" +
                           (f"\nnote: {_caution()}" if _caution() else ""))
    caution = _caution()
    if caution:
        print(f"sunder: note: {caution}", file=sys.stderr, flush=True)
    print(f"sunder: installing {len(missing)} packages: {' '.join(missing)}", file=sys.stderr, flush=True)
    start = time.monotonic()
    apt = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-o",
           f"DPkg::Lock::Timeout={LOCK_WAIT_S}"]
    log.unlink(missing_ok=True)
    for arguments in (["update"], ["install", "-y", "--no-install-recommends", *missing]):
        try:
            status = run_logged([*apt, *arguments], log)
        except FileNotFoundError as error:
            raise CommandError(f"{error.filename} not found; install by hand: {' '.join(missing)}") from None
        if status != 0:
            raise CommandError(f"{tail(log, 20)}\napt-get {arguments[0]} failed with status {status} (whole "
                               f"log: {log}); check network, disk and /etc/apt/sources.list, then run this "
                               f"again, or as root: {command}")
    still = missing_packages(packages)
    if still:
        raise CommandError(f"apt-get reported success but these are still missing: {' '.join(still)}; see {log}")
    if not set(missing).isdisjoint(PACKAGES):
        first_use.installed(log.parent, time.monotonic() - start)
    print(f"sunder: installed in {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
