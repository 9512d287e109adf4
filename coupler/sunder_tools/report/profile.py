"""profile.json: the stages of a run beside what the machine needs for them at least."""
from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

PROFILE_FILE, PROFILE_PICTURE = "profile.json", "profile.png"


@dataclass(frozen=True)
class Work:
    """What a stage has to do, and the limits of the machine for it."""
    bytes: float        # of a pass
    operations: float   # of a pass
    passes: float
    gb_per_s: float     # of memory, for so many bytes
    limit: str          # 'memory' or 'operations'
    times_limit: float  # time over the least time


@dataclass(frozen=True)
class StageOfRun:
    """A stage. `work` is None where there is no model of it."""
    name: str
    seconds: float
    work: Work | None = None


@dataclass(frozen=True)
class Profile:
    """A profile.json. `peak_gflops` and `Work.gb_per_s` are those of `threads` threads."""
    threads: int
    substeps: float
    peak_gflops: float
    stages: list[StageOfRun]


def read_profile(folder: Path) -> Profile | None:
    """Reads the profile of a run folder; None where it has none or a damaged one."""
    try:
        found = json.loads((folder / PROFILE_FILE).read_text())
        return Profile(int(found["threads"]), float(found["substeps"]), float(found["fma_peak_gflops"]),
                       [_stage(s) for s in found["stages"]])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _stage(found: dict[str, Any]) -> StageOfRun:
    work = None
    if "passes" in found:
        work = Work(float(found["bytes"]), float(found["operations"]), float(found["passes"]),
                    float(found["memory_gb_per_s"]), str(found["limit"]), float(found["times_limit"]))
    return StageOfRun(str(found["stage"]), float(found["seconds"]), work)


def table(profile: Profile) -> str:
    """A line a stage, the longest first: its time and share, and where there is a model, what it does in a pass and how often
    longer it takes than the machine needs."""
    total = sum(s.seconds for s in profile.stages)
    lines = [f"{'stage':<15}{'seconds':>9}{'share':>7}{'µs a pass':>11}{'kB a pass':>11}{'kflop':>9}  limit"]
    for stage in sorted(profile.stages, key=lambda s: -s.seconds):
        line = f"{stage.name:<15}{stage.seconds:>9.3f}{stage.seconds / total:>7.0%}" if total > 0.0 else stage.name
        if stage.work is not None:
            w = stage.work
            line += (f"{1e6 * stage.seconds / w.passes:>11.1f}{1e-3 * w.bytes:>11.1f}{1e-3 * w.operations:>9.1f}"
                     f"  {w.times_limit:.1f} times that of {w.limit}")
        lines.append(line)
    lines.append(f"limits: {profile.peak_gflops:.1f} GFLOP/s, memory "
                 f"{', '.join(f'{s.work.gb_per_s:.1f} GB/s ({s.name})' for s in profile.stages if s.work)}; "
                 f"{profile.threads} thread{'s' * (profile.threads != 1)}, {profile.substeps:.0f} substeps")
    return "\n".join(lines)
