"""State hashes of the scenes that ship: whether two builds, or two numbers of threads, compute the same to the bit."""
from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from sunder_tools.errors import CommandError, how_it_ended
from sunder_tools.launch.shipped import SCENES

PAPER = "paper"  # folder of the paper's scenes; their names here are paper/fig01 and so on

# Simulated seconds after which a run ends. Each lasts until cracks, contact or hand-off have been at work.
UNTIL = {
    "acrylic": "1e-4", "branching": "4e-5", "bullet_sheet": "0.02", "cut_pane": "0.02", "dent": "0.002",
    "ductile_strip": "0.003", "falling_tree": "0.002", "falling_tree_small": "0.02", "glass": "0.0012",
    "impactor": "0.002", "impactor_small": "0.02", "intact_pane": "0.004", "kalthoff": "5e-5", "mirror": "1e-5", "mode_one": "6e-4",
    "mode_two": "6e-4", "over_stretch": "0.5", "pressed_plate": "3e-3", "roof": "0.2", "round_pane": "5.2e-5",
    "round_window": "6e-5", "soft_ball": "0.04", "struck_glass": "6e-5", "torn_sheet": "0.05", "torn_square": "0.5",
    "zener": "4e-5", "bowl": "1e-3", "lamp": "1e-3", "rabbit": "1e-3", "trousers": "0.02", "vase": "1e-3",
    "paper/fig01": "2e-4", "paper/fig13": "0.1", "paper/fig14": "0.001", "paper/fig15": "0.002", "paper/fig16": "0.002",
    "paper/fig17": "3e-4",
}


@dataclass(frozen=True)
class Hashed:
    """A run and its hash."""
    scene: str
    threads: int
    state_hash: str
    fragments: int
    cracks_m: float
    seconds: float


def names() -> list[str]:
    """All scenes that ship, those of the paper last."""
    return [path.relative_to(SCENES).with_suffix("").as_posix()
            for folder in (SCENES, SCENES / PAPER) for path in sorted(folder.glob("*.textproto"))]


def hash_of(program: Path, scene: str, threads: int) -> Hashed:
    """Runs a shipped scene in one process, `program` being sunder-single. Raises CommandError."""
    until = ["--until", UNTIL[scene]] if scene in UNTIL else []
    with tempfile.TemporaryDirectory(prefix="sunder-hash-") as folder:
        start = time.monotonic()
        ended = subprocess.run([str(program), "--scene", str(SCENES / f"{scene}.textproto"), "--out", folder, "--engine",
                                "bullet", "--threads", str(threads), "--quiet", *until], check=False,
                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                               env={**os.environ, "OMP_WAIT_POLICY": "passive"})
        if ended.returncode != 0:
            raise CommandError(f"{scene}: {program.name} {how_it_ended(ended.returncode)}: {ended.stderr.strip()[-400:]}")
        run = json.loads((Path(folder) / "run.json").read_text())
        return Hashed(scene, threads, run["state_hash"], run["counts"]["fragments"], run["cracks"]["length_m"],
                      time.monotonic() - start)


def write(path: Path, rows: list[Hashed]) -> None:
    """For a later `--against`."""
    path.write_text(json.dumps({"hashes": [asdict(row) for row in rows]}, indent=1) + "\n")


def read(path: Path) -> dict[tuple[str, int], str]:
    """Hashes by scene and threads. Raises CommandError where the file is none that `write` wrote."""
    try:
        rows = json.loads(path.read_text())["hashes"]
        return {(str(row["scene"]), int(row["threads"])): str(row["state_hash"]) for row in rows}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise CommandError(f"{path}: has no hashes ({error}); make it with: sunder hashes --json {path}") from None


def line(row: Hashed, against: dict[tuple[str, int], str]) -> str:
    """A row of the table; the last word says whether the hash is that of `against`."""
    before = against.get((row.scene, row.threads))
    verdict = "" if not against else "new" if before is None else "same" if before == row.state_hash else "DIFFERS"
    return (f"{row.scene:<20} {row.threads:>7}  {row.state_hash[:16]}  {row.fragments:>9}  {row.cracks_m:>8.3g}  "
            f"{row.seconds:>7.1f}  {verdict}").rstrip()


HEADER = f"{'scene':<20} {'threads':>7}  {'state hash':<16}  {'fragments':>9}  {'cracks m':>8}  {'seconds':>7}"


def unequal(rows: list[Hashed], against: dict[tuple[str, int], str]) -> list[str]:
    """Scenes whose hash depends on the number of threads, or is not that of `against`."""
    of_scene: dict[str, set[str]] = {}
    for row in rows:
        of_scene.setdefault(row.scene, set()).add(row.state_hash)
        before = against.get((row.scene, row.threads))
        if before is not None:
            of_scene[row.scene].add(before)
    return [scene for scene, hashes in of_scene.items() if len(hashes) > 1]
