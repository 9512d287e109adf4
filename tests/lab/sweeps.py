"""Small series for tests: a coarse plate, struck, for some windows. A run takes a third of a second."""
from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

from . import REPOSITORY

SUNDER = str(REPOSITORY / "coupler" / "sunder")

FILE = """
import sunder
scene = sunder.Scene.load(sunder.SCENES / "acrylic.textproto").set({{
    "shells[plate].plate.elements_x": 24, "shells[plate].plate.elements_y": 24, "end_time_s": {end},
    "output.frame_interval_s": 1}})
experiment = sunder.Experiment(
    name="small", scene=scene, parameters={parameters}, seeds=[1, 2],
    measure=[sunder.impact("pellet", interval_s=8e-6), sunder.fragments()],
    plots=[sunder.Plot("speed", "crack_length_m")])
"""
SPEEDS = 'dict(speed=sunder.Parameter({speeds}, {{"bodies[pellet].twist.linear.z": lambda v: -v}}))'


def write_file(path: Path, speeds: list[float], end: str = "3e-5", parameters: str = "") -> Path:
    """A sweep file: two seeds for each speed [m/s], unless `parameters` says otherwise."""
    path.write_text(FILE.format(end=end, parameters=parameters or SPEEDS.format(speeds=speeds)))
    return path


def start(*arguments: str, **environment: str) -> "subprocess.Popen[str]":
    """`sunder sweep`."""
    return subprocess.Popen([SUNDER, "sweep", *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, env={**os.environ, **environment})


def sweep(*arguments: str, **environment: str) -> tuple[int, str, str]:
    """Exit status, stdout, stderr of `sunder sweep`."""
    process = start(*arguments, **environment)
    out, err = process.communicate(timeout=1800)
    return process.returncode, out, err


def outcomes(folder: Path) -> dict[str, int]:
    """When each member ended [ns]."""
    return {path.parent.name: path.stat().st_mtime_ns for path in folder.glob("members/*/outcome.json")}


def kill_half_way(process: "subprocess.Popen[str]", folder: Path, after: int) -> dict[str, int]:
    """kill -9 once `after` members have ended; those that had ended."""
    end = time.monotonic() + 1800
    while len(outcomes(folder)) < after:
        if process.poll() is not None or time.monotonic() > end:
            raise AssertionError(f"nothing to kill: {process.communicate()}")
        time.sleep(0.005)
    process.kill()
    process.communicate()
    return outcomes(folder)
