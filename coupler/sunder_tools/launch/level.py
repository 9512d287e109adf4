"""Which of the installed programs this processor can run: a folder for each level of x86-64."""
from __future__ import annotations

import re
from pathlib import Path

from ..errors import CommandError

CPUINFO = Path("/proc/cpuinfo")
HERE = "native"  # of an installation on the machine that built it; no other runs it
# As the x86-64 psABI has them, by the names of /proc/cpuinfo; each level needs those below it too.
NEEDS = {
    "x86-64-v2": {"cx16", "lahf_lm", "popcnt", "sse4_1", "sse4_2", "ssse3"},
    "x86-64-v3": {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "xsave"},
    "x86-64-v4": {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"},
}


def level(folder: Path, cpuinfo: Path = CPUINFO) -> Path:
    """The folder of the highest level below `folder` that this processor has. Raises CommandError where there is none."""
    if (folder / HERE / "sunder-shell").is_file():
        return folder / HERE
    listed = re.search(r"^flags\s*:(.*)$", cpuinfo.read_text(), re.MULTILINE)
    flags = set(listed[1].split()) if listed else set()
    best: Path | None = None
    missing: list[str] = []
    for name, needs in NEEDS.items():
        if not needs <= flags:
            missing = sorted(needs - flags)
            break
        if (folder / name / "sunder-shell").is_file():
            best = folder / name
    if best is None:
        there = " ".join(sorted(path.name for path in folder.glob("*"))) or "none"
        lacks = f"this processor lacks {' '.join(missing)}" if missing else "there are none for this processor"
        raise CommandError(f"no programs in {folder} for this processor: it has those of {there}, and {lacks}; build from "
                           "the sources on this machine instead")
    return best
