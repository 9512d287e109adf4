"""`validate coupling --case scenes`: checks that impulses and births close in every shipped scene with bodies, with
every engine."""
from __future__ import annotations

import math
import re
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from sunder_tools.errors import BAD_INPUT, CommandError
from sunder_tools.launch.build import Executables, ensure_built
from sunder_tools.launch.run import launch_once
from sunder_tools.launch.needs import reads_cad

from .trials import SCENES, Table, answering

MOST_IMPULSE = 1e-12  # share of the impulses of a window; round-off of 1e4 samples in double precision is 1e-14
MOST_BIRTH = 1e-10  # share of a piece's mass, momentum and angular momentum
COARSE_GLASS = ("shells[pane].plate.elements_x=40", "shells[pane].plate.elements_y=40", "fracture.latest_freeze_s=1.5e-3")


@dataclass(frozen=True)
class Shortened:
    """A scene and the time in which its contact or birth has happened."""
    scene: str
    end_s: float
    pushed: bool  # a body has touched a shell; otherwise the case proves nothing
    born: bool  # a piece has been handed off
    settings: tuple[str, ...] = ()


SHIPPED = (
    Shortened("acrylic", 2e-4, True, False),
    Shortened("bowl", 3e-4, True, True),
    Shortened("bullet_sheet", 0.03, True, True),
    Shortened("cad/windscreen", 3e-4, True, False),
    Shortened("cut_pane", 0.01, False, True),
    Shortened("dent", 2e-3, True, False),
    Shortened("falling_tree_small", 0.1106, True, False),  # the trunk meets the roof at 0.1102 s
    Shortened("glass", 2e-3, True, True, COARSE_GLASS),
    Shortened("impactor", 4e-3, True, False),  # like the small one, with 43,200 elements
    Shortened("impactor_small", 0.04, True, True),
    Shortened("intact_pane", 4e-3, True, False),
    Shortened("lamp", 1e-3, True, True),
    Shortened("rabbit", 3e-4, True, True),
    Shortened("round_pane", 5.2e-5, True, True),
    Shortened("round_window", 1.4e-4, True, True),
    Shortened("soft_ball", 0.06, True, False),
    Shortened("struck_glass", 6e-5, True, True),
    Shortened("torn_sheet", 5e-3, False, True),
    Shortened("vase", 3e-4, True, True),
    Shortened("zener", 1.6e-5, True, False),
)

REPEATED = ("falling_tree",)  # takes minutes until its bodies hit the car; falling_tree_small has the same bodies


def books_of(run: dict, wanted: Shortened) -> tuple[float, float]:
    """Returns the largest errors of the windows' impulses and of births; NaN where the expected event has not
    happened."""
    ledger, handoff = run["ledger"], run["handoff"]
    impulse = max(ledger["linear_max"], ledger["angular_max"])
    birth = max(handoff["mass_error_max"], handoff["momentum_error_max"], handoff["angular_momentum_error_max"])
    if wanted.pushed and impulse == 0.0:
        impulse = math.nan
    if wanted.born and run["counts"]["handed_off"] == 0:
        birth = math.nan
    return impulse, birth


def scenes(table: Table, executables: Executables) -> None:
    """Runs every scene with every engine. The books are the shell's, in double precision with any engine."""
    for name, words in answering(table, "scenes", executables):
        if "double_precision" not in words:
            table.lines.append(f"scenes {name}: declares no double precision; the books are the shell's and hold all the same")
        for wanted in SHIPPED:
            _one(table, executables, name, words, wanted)


def _one(table: Table, executables: Executables, engine: str, words: list[str], wanted: Shortened) -> None:
    start = time.monotonic()
    name = f"{wanted.scene.replace('/', '_')}_{engine}"
    settings = [f"end_time_s={wanted.end_s!r}", "output.frame_interval_s=10", "output.shell_frame_interval_s=10",
                "output.checkpoint_interval_s=0", *wanted.settings]
    with tempfile.TemporaryDirectory(prefix="validate-sunder-") as folder:
        try:
            scene = SCENES / f"{wanted.scene}.textproto"
            if reads_cad(scene.read_text()):
                executables = ensure_built(cad=True)
            run = launch_once(executables, scene, Path(folder), settings, engine)
        except CommandError as error:
            lacks = re.search(r"cannot do '(\w+)'", str(error))
            if error.status == BAD_INPUT and lacks and lacks[1] not in words:  # reported before the run
                table.lines.append(f"scenes {name}: left out: the engine does not declare {lacks[1]}")
                return
            table.add(f"{name}_impulse", math.nan, 0.0, MOST_IMPULSE, time.monotonic() - start)
            table.lines.append(f"scenes {name}: {error}")
            return
    impulse, birth = books_of(run, wanted)
    table.add(f"{name}_impulse", impulse, 0.0, MOST_IMPULSE, time.monotonic() - start)
    counts = run["counts"]
    assert isinstance(counts, dict)
    if wanted.born or counts["handed_off"]:
        table.add(f"{name}_birth", birth, 0.0, MOST_BIRTH, 0.0)
    table.lines.append(f"scenes {name}: {wanted.end_s:g} s, {run['time']['windows']} windows, "  # type: ignore[index]
                       f"{counts['handed_off']} pieces handed over")
