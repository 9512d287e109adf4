"""`sunder bench --runs`: what whole runs of shipped scenes take, and which share of it goes where."""
from __future__ import annotations

import contextlib
import io
import math
import os
import resource
from pathlib import Path
from typing import Any

from sunder_tools.launch.build import Executables
from sunder_tools.launch.run import read_usage
from sunder_tools.pictures.contact_sheet import write_contact_sheet
from sunder_tools.pictures.crack_lines import last_graph
from sunder_tools.pictures.frames import list_frames
from sunder_tools.pictures.render import Shot, render
from sunder_tools.report.run_json import read_run

from ..validation.trials import kept_run

CRACKING = ("glass", "pressed_plate")
CAR = "impactor_small"
FILM_PICTURES = 81


def measure_runs(executables: Executables) -> dict[str, float]:
    """Runs the scenes one after the other; returns the numbers by their keys. Raises CommandError where a run fails."""
    numbers: dict[str, float] = {}
    for name in (*CRACKING, CAR):
        print(f"sunder: running {name}", flush=True)
        with kept_run(executables, f"{name}.textproto", []) as (folder, _):
            run = read_run(folder)
            if name in CRACKING:
                numbers |= of_cracks(name, run, len(last_graph(folder)))
            if name == "glass":
                before = _processor_s()
                write_contact_sheet(folder)
                sheet = _processor_s() - before
                numbers |= {"glass_processor_s": read_usage(folder).get("processor_s", math.nan) + sheet,
                            "glass_contact_sheet_s": sheet} | of_film("glass", folder)
            if name == CAR:
                numbers[f"{name}_shell_contact_share"] = run["time"]["stage_s"].get("shell_contact", 0.0) / run["time"]["wall_s"]
    return numbers


def of_cracks(name: str, run: dict[str, Any], edges: int) -> dict[str, float]:
    """The share of the crack update over the windows in which cracks grew, and its milliseconds for each edge. NaN where
    nothing cracked: a run without cracks meets no goal of theirs."""
    grew = run["time"]["cracks_grew"]
    return {f"{name}_fracture_share": grew["crack_update_s"] / grew["wall_s"] if grew["wall_s"] > 0.0 else math.nan,
            f"{name}_ms_per_edge": 1e3 * grew["crack_update_s"] / edges if edges > 0 else math.nan}


def of_film(name: str, folder: Path) -> dict[str, float]:
    """Processor time for each picture of a film of the run's first frames, at 720p and with its encoding [s], and the system's
    share of it."""
    count = min(FILM_PICTURES, len(list_frames(folder)))
    before, system_before = _processor_s(), _system_s()
    with contextlib.redirect_stdout(io.StringIO()):
        render(folder, folder / "film.mp4", True, False, f"0-{count - 1}", Shot(), None, os.cpu_count() or 1)
    used = _processor_s() - before
    return {f"{name}_film_s_a_picture": used / count, f"{name}_film_system_share": (_system_s() - system_before) / used}


def _usage() -> list[resource.struct_rusage]:
    """Of this process and of children that have ended."""
    return [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]


def _processor_s() -> float:
    return sum(each.ru_utime + each.ru_stime for each in _usage())


def _system_s() -> float:
    return sum(each.ru_stime for each in _usage())
