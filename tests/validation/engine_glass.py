"""`validate coupling --case glass`: the glass scene with every engine that declares hulls and contact, side by side."""
from __future__ import annotations

import contextlib
import csv
import io
import math
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.launch.build import Executables
from sunder_tools.launch.run import launch_once
from sunder_tools.report.run_json import read_run

from .trials import SCENES, Table, answering

SEEDS = (1, 2, 3, 4)
END_S = 0.012
COARSE = tuple(f"shells[pane].plate.elements_{axis}=40" for axis in "xy")
ONE_SCHEME = ("coupling.export_above=1e9",)  # not all engines export rows; the case compares engines, not schemes
NEEDED = {"convex_hulls", "compound", "contact"}
BALL = 'output { probes { name: "ball" body: "ball" }'
# When shards collide in an engine, the last bit of a pose changes the pattern. Means over seeds can still be compared:
# to twice the standard error of their mean difference, plus a floor for quantities with little scatter.
# seeds, to twice the standard error of the mean of their differences, and a floor for what seeds hardly scatter.
MOST_APART = {"fragments": 0.05, "crack length [m]": 0.02, "impulse on the ball [N s]": 0.02}


@dataclass(frozen=True)
class Broken:
    """Results of one run of the pane."""
    rows: list[list[str]]       # of series.csv, the head left out
    met: int  # row of the engine's first change of a motion; the number of rows where there is none
    quantities: dict[str, float]
    residual: float
    impulse: float              # largest error of a window's impulses


def broken(folder: Path) -> Broken:
    """Reads the results of a run folder."""
    run = read_run(folder)
    table = list(csv.reader((folder / "series.csv").read_text().splitlines()))
    head, rows = table[0], table[1:]
    engine = head.index("engine [J]")
    met = next((k for k, row in enumerate(rows) if float(row[engine]) != 0.0), len(rows))
    probes = list(csv.reader((folder / "probes.csv").read_text().splitlines()))
    fall = probes[0].index("ball_vz [m/s]")
    mass = 7800.0 * 4.0 / 3.0 * math.pi * 0.02 ** 3
    length = float(rows[-1][head.index("cracks [m]")])
    return Broken(rows, met, {"fragments": float(run["counts"]["fragments"]), "crack length [m]": length,
                              "impulse on the ball [N s]": mass * (float(probes[-1][fall]) - float(probes[1][fall]))},
                  abs(run["energy"]["residual_relative"]), max(run["ledger"]["linear_max"], run["ledger"]["angular_max"]))


def same_until(first: Broken, second: Broken) -> int:
    """Counts equal rows of series.csv from the start."""
    return next((k for k, (a, b) in enumerate(zip(first.rows, second.rows)) if a != b),
                min(len(first.rows), len(second.rows)))


def apart(first: list[float], second: list[float]) -> tuple[float, float]:
    """Returns the difference of the means over seeds and twice its standard error, for pairs; both relative to the
    first mean."""
    difference = np.array(second) - np.array(first)
    mean = float(np.mean(first))
    return float(difference.mean()) / mean, 2.0 * float(difference.std(ddof=1)) / math.sqrt(len(difference)) / abs(mean)


def glass(table: Table, executables: Executables) -> None:
    """Runs four seeds to 12 ms with every engine, compared with the first engine; with pictures, one seed to the
    end."""
    text = (SCENES / "glass.textproto").read_text().replace("output {", BALL, 1)
    found: dict[str, list[Broken]] = {}
    with tempfile.TemporaryDirectory(prefix="validate-sunder-") as temporary:
        scene = Path(temporary) / "glass.textproto"
        scene.write_text(text)
        for name, words in answering(table, "glass", executables):
            if not NEEDED <= set(words):
                table.lines.append(f"glass {name}: left out, it declares no {', '.join(sorted(NEEDED - set(words)))}")
                continue
            start, found[name] = time.monotonic(), []
            for seed in SEEDS:
                folder = Path(temporary) / f"{name}_{seed}"
                folder.mkdir()
                settings = [*COARSE, *ONE_SCHEME, f"fracture.seed={seed}", f"end_time_s={END_S}",
                            "output.shell_frame_interval_s=1", "output.checkpoint_interval_s=0"]
                launch_once(executables, scene, folder, settings, name)
                found[name].append(broken(folder))
            table.add(f"glass_{name}_impulses", max(one.impulse for one in found[name]), 0.0, 1e-12, time.monotonic() - start)
            table.add(f"glass_{name}_residual", max(one.residual for one in found[name]), 0.0, 0.02, 0.0)
            for what in MOST_APART:
                table.lines.append(f"glass {name}: {what} " + " ".join(f"{one.quantities[what]:.4g}" for one in found[name]))
        _compare(table, found)
        if table.pictures is not None:
            _pictures(table.pictures / "glass_engines.png", list(found), scene, Path(temporary), executables)


def _compare(table: Table, found: dict[str, list[Broken]]) -> None:
    first = next(iter(found))
    for name, runs in found.items():
        if name == first:
            continue
        # Up to the first window in which an engine changes a motion: cracks, births, impulses, energies.
        early = sum(same_until(a, b) < min(a.met, b.met) for a, b in zip(found[first], runs))
        table.add(f"glass_{name}_differs_early", early, 0.0, 0.0, 0.0)
        table.lines.append(f"glass {name}: the same as {first} to the bit up to rows "
                           + " ".join(str(same_until(a, b)) for a, b in zip(found[first], runs))
                           + "; an engine first changes something in rows "
                           + " ".join(str(min(a.met, b.met)) for a, b in zip(found[first], runs)))
        for what, floor in MOST_APART.items():
            mean, noise = apart([one.quantities[what] for one in found[first]], [one.quantities[what] for one in runs])
            table.add(f"glass_{name}_{what.split(' [')[0].replace(' ', '_')}", mean, 0.0, max(floor, noise), 0.0)


def _pictures(path: Path, names: list[str], scene: Path, temporary: Path, executables: Executables) -> None:
    """Draws a row for each engine: the pane after cracking, and everything at rest."""
    from PIL import Image
    from sunder_tools.pictures.lettering import draw_text
    from sunder_tools.pictures.render import Shot, frames_of, render
    size, rows = (480, 360), []
    for name in names:
        folder = temporary / f"{name}_whole"
        folder.mkdir()
        try:
            launch_once(executables, scene, folder, [*COARSE, "output.checkpoint_interval_s=0"], name)
        except CommandError as error:
            raise ValueError(f"glass {name}: {error}") from None
        times = [frame.time_s for frame in frames_of(folder, "render")]
        numbers = [int(np.searchsorted(times, t * (1 - 1e-9))) for t in (5e-3, END_S, 0.3)] + [len(times) - 1]
        out = temporary / f"{name}_stills"
        with contextlib.redirect_stdout(io.StringIO()):  # suppresses its message about stills, which are temporary
            render(folder, out, False, False, ",".join(map(str, numbers)), Shot(size=size), None, 1)
        rows.append([Image.open(out / f"still_{k:06d}.png") for k in numbers])
        draw_text(rows[-1][0], (10, size[1] - 24), name, 16)
    image = Image.new("RGB", (size[0] * len(rows[0]), size[1] * len(rows)), "white")
    for j, row in enumerate(rows):
        for i, still in enumerate(row):
            image.paste(still, (i * size[0], j * size[1]))
    image.save(path)
    print(f"picture          {path}", flush=True)
