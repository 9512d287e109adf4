"""What a measurement was made with: system, processor, load, compiler, commit. Never the name of the machine."""
from __future__ import annotations

import os
import re
import subprocess
from datetime import date
from pathlib import Path

from ..places import REPOSITORY

UNKNOWN = "unknown"


def processor(cpuinfo: Path = Path("/proc/cpuinfo")) -> str:
    """Model of the processor, 'unknown' where the system does not say."""
    try:
        found = re.search(r"^model name\s*:\s*(.+)$", cpuinfo.read_text(), re.MULTILINE)
    except OSError:
        return UNKNOWN
    return " ".join(found[1].split()) if found else UNKNOWN


def system(release: Path = Path("/etc/os-release")) -> str:
    """Distribution and its version as a key, such as 'debian_13'; 'unknown' where the system does not say."""
    try:
        said = dict(re.findall(r'^(\w+)="?([^"\n]*)"?$', release.read_text(), re.MULTILINE))
    except OSError:
        return UNKNOWN
    return "_".join(said[key] for key in ("ID", "VERSION_ID") if said.get(key)) or UNKNOWN


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0))


def compiler(build: Path) -> str:
    """First line of what the compiler of a build folder says of itself, 'unknown' where there is none."""
    try:
        cache = (build / "CMakeCache.txt").read_text(errors="replace")
        found = re.search(r"^CMAKE_CXX_COMPILER:\w+=(.+)$", cache, re.MULTILINE)
        lines = _said([found[1], "--version"]).splitlines() if found else []
    except OSError:
        return UNKNOWN
    return lines[0] if lines else UNKNOWN


def commit(repository: Path = REPOSITORY) -> str:
    """Short name of the commit, with '+' where files differ from it; 'unknown' outside a repository."""
    try:
        name = _said(["git", "-c", "safe.directory=*", "-C", str(repository), "rev-parse", "--short=10", "HEAD"]).strip()
        changed = _said(["git", "-c", "safe.directory=*", "-C", str(repository), "status", "--porcelain", "--untracked-files=no"]).strip()
    except OSError:
        return UNKNOWN
    return (name or UNKNOWN) + ("+" if name and changed else "")


def circumstances(build: Path) -> dict[str, object]:
    """All of it, the date, and the load of the last minute: what else kept the cores busy."""
    return {"commit": commit(), "date": date.today().isoformat(), "system": system(), "processor": processor(), "cores": cores(),
            "load": round(os.getloadavg()[0], 1), "compiler": compiler(build)}


def _said(command: list[str]) -> str:
    return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                          errors="replace", check=False).stdout
