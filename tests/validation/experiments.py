"""Cases of `validate` that run whole scenes in two processes, and two groups of them: shells and cracks."""
from __future__ import annotations

import importlib
import json
import math
from dataclasses import dataclass
from typing import Callable

from sunder_tools.errors import CommandError, Interrupted
from sunder_tools.launch.build import Executables, ensure_built
from sunder_tools.report.run_json import read_run

from .trials import MOST_INJECTED, Missing, Table, injected, kept_run, run_scene


def zener(inelasticity: float, step: float = 1e-4) -> float:
    """Returns the restitution of a sphere on an infinite plate: s'' + (1 + lambda d/dt) s^3/2 = 0, s = 0, s' = 1
    (Zener 1941)."""
    def slope(s: float, u: float) -> tuple[float, float]:  # u = s' + lambda s^3/2
        f = max(s, 0.0) ** 1.5
        return u - inelasticity * f, -f

    s, u = 0.0, 1.0
    while True:
        a = slope(s, u)
        b = slope(s + 0.5 * step * a[0], u + 0.5 * step * a[1])
        c = slope(s + 0.5 * step * b[0], u + 0.5 * step * b[1])
        d = slope(s + step * c[0], u + step * c[1])
        s += step / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0])
        u += step / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1])
        if s <= 0.0:
            return -u


def restitution(table: Table, executables: Executables) -> None:
    """Runs balls of six radii on scenes/zener.textproto. Stiffness and rigidity are computed here independently."""
    steel, glass = (7800.0, 210e9, 0.3), (2500.0, 70e9, 0.22)  # density, Young's modulus, Poisson's ratio
    thickness, speed, gap = 0.004, 1.0, 1e-5
    rigidity = glass[1] * thickness ** 3 / 12.0 / (1.0 - glass[2] ** 2)
    x, computed, known = [], [], []
    for radius in (0.0022, 0.003, 0.004, 0.005, 0.0058, 0.0065):
        mass = steel[0] * 4.0 / 3.0 * math.pi * radius ** 3
        stiffness = 4.0 / 3.0 * math.sqrt(radius) / sum((1.0 - nu ** 2) / young for _, young, nu in (steel, glass))
        inelasticity = mass ** 0.6 * stiffness ** 0.4 * speed ** 0.2 / (
            8.0 * math.sqrt(glass[0] * thickness * rigidity))
        touch = 5.0 * (mass ** 2 / (stiffness ** 2 * speed)) ** 0.2  # with a margin
        found, rows, seconds = run_scene(executables, "zener.textproto", [
            f"bodies[ball].sphere.radius_m={radius}",
            f"bodies[ball].pose.position.z={radius + 0.5 * thickness + gap}",
            f"end_time_s={math.ceil((touch + gap / speed) / 2e-6) * 2e-6:.9g}", "output.frame_interval_s=1"])
        column = rows[0].index("ball_vz [m/s]")
        back = float(rows[-1][column]) / speed
        if float(rows[-2][column]) != float(rows[-1][column]):
            table.lines.append(f"restitution: at {radius} m the ball still touches at the end")
            back = math.nan
        reference = zener(inelasticity)
        table.add(f"restitution_lambda_{inelasticity:.2f}", back, reference, 0.03, seconds)
        table.lines.append(f"restitution: radius {radius} m, lambda {inelasticity:.3f}, {found['time']['substeps']} "
                           f"substeps, energy residual {found['energy']['residual_relative']:.1e}, ledger "
                           f"{found['ledger']['linear_max']:.0e}")
        x.append(inelasticity)
        computed.append(back)
        known.append(reference)
    for name, y in (("restitution", computed), ("restitution, Zener", known)):
        table.curves.append({"name": name, "x_label": "lambda", "y_label": "restitution", "x": x, "y": y,
                             "logarithmic": False})


def torn_area(table: Table, executables: Executables) -> None:
    """Runs scenes/torn_square.textproto with each stress model: the area that the sheet keeps; torn points count as
    lost."""
    for model in ("PLANE_STRESS", "PAPER_PROJECTION", "JGT17", "GHF18"):
        found, _, seconds = run_scene(executables, "torn_square.textproto", [f"shells[sheet].stress_model={model}",
                                                           "output.frame_interval_s=10"])
        surface, counts = found["surface"], found["counts"]
        # An area above one is as wrong as one below.
        tolerance = 0.01 if model == "PLANE_STRESS" else 0.05
        table.add(f"area_kept_{model.lower()}", surface["now_m2"], 1.0, tolerance, seconds)
        if model == "PLANE_STRESS":
            table.add("torn_square_injected", injected(found), 0.0, MOST_INJECTED, seconds)
        table.lines.append(f"torn_area {model}: {counts['fragments']} fragments, stretch of what bears "
                           f"{surface['now_m2'] / surface['rest_m2'] - 1.0:+.1e}, {counts['rubble_points']} of "
                           f"{counts['gauss_points']} points torn")
    table.lines.append("torn_area: the paper has 0.994 for its own model and 0.668 for JGT17 in its own scheme; here the "
                       "models are run in one scheme, and none loses area")


# frames are so frequent that a tip needs several for an edge
DENSE = ["window_s=1e-5", "output.shell_frame_interval_s=1e-5"]
FEWEST_GROWING = 10  # frames with new edges; fewer would prove little


def consistency(table: Table, executables: Executables) -> None:
    """Checks the cracks of both modes over time, and those of joined shells, from the written frames alone; and Fig.
    8."""
    from .crack_check import check_folder  # numpy and PIL only now
    from .stages import FINE, find_stages, write_stages
    glass = ["shells[pane].plate.elements_x=40", "shells[pane].plate.elements_y=40", "end_time_s=1.5e-3"]
    for name, settings in (("torn_sheet", ["end_time_s=1e-3", *DENSE]), ("glass", [*glass, *DENSE]),
                           ("impactor_small", ["output.shell_frame_interval_s=5e-4"])):
        with kept_run(executables, f"{name}.textproto", settings) as (folder, seconds):
            found = check_folder(folder)
            proven = found.growing >= FEWEST_GROWING
            for what, count in (("lost", found.lost), ("unconnected", found.unconnected), ("gaps", found.gaps),
                                ("in_pieces", found.apart), ("doubled", found.doubled)):
                table.add(f"{name}_cracks_{what}", count if proven else math.nan, 0.0, 0.0, seconds)
            if name == "torn_sheet":
                table.add(f"{name}_injected", injected(read_run(folder)) if proven else math.nan, 0.0,
                          MOST_INJECTED, seconds)
            table.lines.append(f"consistency {name}: {found.frames} frames, {found.growing} with new edges; "
                               f"{found.edges} edges of {found.cracks} cracks, {found.starts} started on their own")
            table.lines += [f"consistency {name}: {note}" for note in found.notes]
            if name != "torn_sheet":
                continue
            stages = find_stages(folder)
            table.lines.append(f"consistency {name}: of the middle line of the damage at the first of three stages, "
                               f"{100 * stages.share_moved():.1f} % is more than an element off the last one's, "
                               f"{100 * stages.share_moved(FINE):.1f} % more than {FINE} elements")
            if table.pictures is not None:
                write_stages(stages, table.pictures / "crack_stages.png")
                print(f"picture          {table.pictures / 'crack_stages.png'}", flush=True)


AFTER_S = 2.0  # time after the sheet has separated at which its stretch is measured
COMES_BACK = 0.3  # a larger remaining stretch is over-stretch
STAYS = 3.0  # least remaining stretch without cracks


def over_stretch(table: Table, executables: Executables) -> None:
    """Runs scenes/over_stretch.textproto as it is, with maximum damage, and both without cracks: the paper's Fig. 4."""
    from .stretch import separated_at, stretched_at, write_stretched  # numpy and PIL only now
    found = []
    parted = 0.0
    ways: tuple[tuple[str, str, list[str]], ...] = (
        ("healing", "damage heals", []),
        ("maximum", "maximum damage", ["fracture.healing=false"]),
        ("uncut", "damage heals, nothing is cut", ["fracture.extract_cracks=false"]),
        ("maximum_uncut", "maximum damage, nothing is cut", ["fracture.healing=false", "fracture.extract_cracks=false"]))
    for name, words, settings in ways:
        cut = not name.endswith("uncut")
        with kept_run(executables, "over_stretch.textproto", settings) as (folder, seconds):
            run = read_run(folder)
            if cut:
                parted = separated_at(folder)  # the motion is the same in all four
            one = stretched_at(folder, parted + AFTER_S)
            before = stretched_at(folder, parted - 0.1).largest() if cut else math.nan
        found.append((words, one))
        largest = one.largest() if run["time"]["frozen_at_s"] is None else math.nan
        if not cut:
            table.add(f"over_stretch_{name}_at_least", min(largest, STAYS), STAYS, 0.0, seconds)
        else:
            table.add(f"over_stretch_{name}", largest, 1.0, COMES_BACK, seconds)
        table.lines.append(f"over_stretch {words}: {largest:.4g} at {one.time_s:.2g} s, {AFTER_S:g} s after it parted; "
                           f"{one.beyond(1.0 + COMES_BACK):.1f} elements beyond {1.0 + COMES_BACK:g}"
                           + ("" if math.isnan(before) else f"; {before:.3g} shortly before")
                           + f"; injected {run['energy']['crack_injected']:.1e} of "
                           f"{run['energy']['dissipated_fracture']:.1e} J")
    table.lines.append("over_stretch: what is fully damaged is cut in the substep in which that completes, one Gauss "
                       "point to either side of the crack; nothing pulls on it then, so that maximum damage does not "
                       "over-stretch either. Damage without a crack does, and whether it heals changes nothing: a band that "
                       "is pulled on stays stretched. It is the cut, not healing, that lets what was stretched come back")
    if table.pictures is not None:
        write_stretched(found, table.pictures / "over_stretch.png")
        print(f"picture          {table.pictures / 'over_stretch.png'}", flush=True)


@dataclass(frozen=True)
class Experiment:
    """A validation case that runs scenes."""
    name: str
    what: str
    run: Callable[[Table, Executables], None]
    by_name: bool = False  # runs only where it is named


def _later(module: str, name: str) -> Callable[[Table, Executables], None]:
    """Loads a function of a module that needs numpy, which may not be installed before the first build."""
    def run(table: Table, executables: Executables) -> None:
        getattr(importlib.import_module(f".{module}", __package__), name)(table, executables)
    return run


EXPERIMENTS = {"shells": (
    Experiment("restitution", "a ball on a large plate, Hertz contact, two processes (Zener 1941)", restitution),
    Experiment("torn_area", "area kept by a torn sheet, four stress models (paper, Fig. 9)", torn_area),
), "cracks": (
    Experiment("consistency", "earlier cracks are part of later ones, no gaps, by the frames alone (paper, Fig. 8)",
               consistency),
    Experiment("modes", "a notched sheet drawn apart, and sheared (paper, Fig. 11)", _later("crack_paths", "modes")),
    Experiment("pressed_plate", "a simply supported plate under pressure: an X", _later("crack_paths", "pressed_plate")),
    Experiment("kalthoff", "70 degrees to the notch (Kalthoff and Winkler 1988)", _later("crack_paths", "kalthoff")),
    Experiment("branching", "when a running crack divides, three spacings (Borden 2012)", _later("crack_paths", "branching")),
    Experiment("mirror", "length, stress and speed at which a crack in glass divides, stretched and bent, three spacings",
               _later("mirrors", "mirror")),
    Experiment("trousers", "force that tears a sheet out of its plane, three spacings (trousers test)",
               _later("tearing", "trousers")),
    Experiment("flap", "the course of two cracks beside a pulled flap (Brau 2014)", _later("tearing", "flap")),
    Experiment("blunt_tool", "wavelength of the crack before a blunt tool, three widths, two speeds (Roman and others 2003)",
               _later("cutting", "blunt_tool")),
    Experiment("strip", "mean size of fragments of a strip over the rate at which it is stretched, six rates, both modes, "
               "two spacings (Zhou, Molinari, Ramesh 2006)", _later("fragments", "strip")),
    Experiment("expanding_ring", "the same of a ring that expands", _later("fragments", "expanding_ring")),
    Experiment("bent_section", "what a bent section takes until damage cuts it, 2 to 9 layers, two spacings",
               _later("bends", "bent_section")),
    Experiment("share", "what cracks cost while they grow, and with their number", _later("crack_paths", "share")),
    Experiment("many", "a thousand pieces of a pane that a blast breaks", _later("crack_books", "many")),
    Experiment("books", "energy that cracks add and that no book has, momentum that pieces carry, seven scenes",
               _later("crack_books", "books")),
    Experiment("over_stretch", "stretch beside a crack with healing, with maximum damage, and uncut (paper, Fig. 4)",
               over_stretch),
    Experiment("weakened_region", "cracks of a cloth start in a weakened region and go on beyond it (paper, Fig. 14)",
               _later("weakened", "weakened_region")),
    Experiment("round_pane", "the lattice must not show: 64 round panes, struck, the lattice turned",
               _later("impacts", "round_pane")),
    Experiment("stars", "arms of stars are straight, and no crack runs beside another along a border, three scenes",
               _later("stars", "stars")),
    Experiment("impact_speed", "radial cracks against speed (Vandenberghe, Vermorel, Villermaux 2013)",
               _later("impacts", "impact_speed")),
    Experiment("impact_speed_plates", "the same of glass, and of plates twice as thick",
               _later("impacts", "impact_speed_plates")),
    Experiment("refinement", "cracks and residual speed on three grids", _later("impacts", "refinement")),
    Experiment("snapped", "pieces of a plate that cracks as its fracture energy asks, on three grids: how many, how large",
               _later("impacts", "snapped")),
    Experiment("tough", "the same of a pane that shatters, on grids that resolve how cracks start", _later("impacts", "tough")),
    Experiment("heavy", "the same under a larger and slower ball, all pieces: off or in place", _later("impacts", "heavy")),
    Experiment("pieces", "the same of a struck pane, whose strength no grid resolves", _later("impacts", "pieces")),
), "coupling": (
    Experiment("scenes", "impulses and births of every shipped scene with bodies, with every engine",
               _later("scene_books", "scenes")),
    Experiment("glass", "the glass scene with every engine that has hulls and contact", _later("engine_glass", "glass")),
), "seams": (
    Experiment("crack", "a crack over a seam runs as in the single patch", _later("seam_runs", "crack")),
    Experiment("follow", "a crack along a seam runs as in the single patch", _later("seam_runs", "follow")),
    Experiment("piece", "a piece over a seam leaves as one body", _later("seam_runs", "piece")),
    Experiment("trim_crack", "a crack over a tie along a trim runs as in the single patch", _later("trim_runs", "trim_crack")),
    Experiment("trim_piece", "a piece over such a tie leaves as one body", _later("trim_runs", "trim_piece")),
), "surfaces": (
    Experiment("models", "mass of the shells of meshes of scenes against the sum over their triangles",
               _later("mesh_models", "mesh_models")),
    Experiment("mesh_files", "files of a sphere of quads and of a tube: area, mass, frequencies, order (Lamb 1882, Love 1888)",
               _later("mesh_files", "mesh_files")),
    Experiment("mutated", "forty thousand mutated meshes, two hundred mutated CAD files: read or refused, no crash",
               _later("mutated", "mutated")),
    Experiment("mutated_million", "the same of a million files", _later("mutated", "mutated_million"), by_name=True),
    Experiment("public", "CAD files and meshes that others published, fetched from Debian's archive, which it needs",
               _later("public_files", "public_files"), by_name=True),
)}


def run_experiments(chosen: tuple[Experiment, ...], table: Table) -> list[str]:
    """Runs the cases one after the other; returns the names of those that are left where the user interrupts them. A case
    that raises becomes a failed row, and a skipped one where it lacks what it needs. One that is interrupted leaves no
    row."""
    if not chosen:
        return []
    executables = ensure_built()
    if not table.headed:
        print(f"{'case':<34} {'computed':>13} {'reference':>13} {'error':>10} {'tolerance':>9} {'seconds':>8}")
    for k, experiment in enumerate(chosen):
        before, rows, curves = len(table.lines), len(table.rows), len(table.curves)
        try:
            experiment.run(table, executables)
        except (Interrupted, KeyboardInterrupt):
            del table.rows[rows:], table.curves[curves:]
            return [one.name for one in chosen[k:]]
        except Missing as missing:
            table.skip(experiment.name, str(missing))
        except (CommandError, OSError, KeyError, ValueError, IndexError, json.JSONDecodeError) as error:
            table.add(experiment.name, math.nan, 0.0, 0.0, 0.0)
            table.lines.append(f"{experiment.name}: {error}")
        table.ran[experiment.name] = len(table.rows) - rows
        for line in table.lines[before:]:
            print(f"  {line}", flush=True)
    return []
