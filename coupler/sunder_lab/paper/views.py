"""Draws the figures that are seen in space: 1 and 12 to 17."""
from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from sunder_tools.pictures.contact_sheet import DIRECTION
from sunder_tools.pictures.crack_lines import Graph, graph_of, grown, within
from sunder_tools.pictures.flat import crack_pattern, shards_of
from sunder_tools.pictures.frames import BODIES, CRACKS, MOVING, SHELL, STATIC, Frame, list_frames
from sunder_tools.pictures.meshes import reference_points, weld
from sunder_tools.pictures.views import as_bytes
from sunder_tools.pictures.vtp import PolyData
from sunder_tools.report.columns import read_columns
from sunder_tools.report.run_json import read_run

from . import panels
from .catalogue import CASES
from .checks import Check
from .depth import outside
from .drawings import WHOLE, Drawn, shells
from .panels import Box, at_times, board, captions, growing, shell_frames, view_panels
from .runs import Runs

VIEW = (470, 352)  # [px]
TALL = (380, 560)
CAR_VIEW = (0.80, 0.50, -0.42)  # from the front, the left side and above
BULLET_VIEW = (0.80, 0.52, -0.28)
BULLET_S = (1e-3, 2e-3, 4e-3)  # instants [s]
FALLING = (0.35, 1.0)  # shares of the time
PIECE = 0.01       # share of the area from which a piece of the garment is counted
GREY = np.array([0.76, 0.77, 0.78])


def near_shell(frames: list[Frame], spare: float) -> Box:
    """A box [m] around the shell in frames, and the bodies that are within `spare` of its sizes."""
    found = [shell.points for frame in frames if (shell := frame.read(SHELL)) is not None]
    box = Box.around(found)
    reach = spare * float((box.high - box.low).max())
    for frame in frames:
        bodies = frame.read(BODIES)
        if bodies is None or not len(bodies.triangles):
            continue
        kind = bodies.of_triangles("kind", STATIC)
        points = bodies.points[np.unique(bodies.triangles[kind == MOVING])]
        found.append(points[((points > box.low - reach) & (points < box.high + reach)).all(axis=1)])
    return Box.around(found)


def figure_1(runs: Runs) -> Drawn:
    """The car before the hit, with the bumper broken, with the bonnet bent, and under the tree."""
    folder, out = runs.place("fig01"), Drawn()
    frames = list_frames(folder)
    last = frames[-1].time_s
    chosen = at_times(frames, (0.0, 0.03, 0.09, 0.15, 0.2, last))
    box = near_shell(chosen[:1], 0.0)
    made = view_panels(folder, chosen, VIEW, Box(box.low, box.high + np.array([0.0, 0.0, 0.5])), direction=CAR_VIEW)
    out.add(runs, "fig01", board(made, captions(chosen), 3), "One sequence: the impactor from the front, then the tree.")
    run = read_run(folder)
    area = _areas(folder)
    out.found.append(f"{run['counts']['patches']} patches, {run['counts']['layer_points']} points in layers; "
                     f"{run['counts']['handed_off']} pieces handed off, {len(area)} of them of 10 cm2 or more; "
                     f"{run['cracks']['length_m']:.2f} m of cracks; plastic work {run['energy']['dissipated_plastic']:.3g} J.")
    return out


def _areas(folder: Path, least_m2: float = 1e-3) -> list[float]:
    """Areas of shards [m^2], the larger ones."""
    table = read_columns(folder / "shards.csv")
    return [float(a) for a in table.get("area [m^2]", ()) if a >= least_m2]


def figure_12(runs: Runs) -> Drawn:
    """The bullet before, in and behind the sheet, seen close from where it flies to, and the sheet at the end."""
    folder, out = runs.place("fig12"), Drawn()
    with_shell = shell_frames(folder)
    sheet = Box.around([shells(with_shell[:1])[0].points])
    middle, half = 0.5 * (sheet.low + sheet.high), 0.15 * float((sheet.high - sheet.low).max())
    close = Box(middle - half, middle + half * np.array([0.6, 1.0, 1.0]))
    made = view_panels(folder, at_times(with_shell, BULLET_S), VIEW, close, direction=BULLET_VIEW)
    made += view_panels(folder, with_shell[-1:], VIEW, sheet, direction=BULLET_VIEW)
    out.add(runs, "fig12", board(made, captions([*at_times(with_shell, BULLET_S), with_shell[-1]]), 4),
            "The bullet comes through the sheet towards the eye; at the end the whole sheet.")
    run = read_run(folder)
    moved = np.linalg.norm(shells(with_shell[-1:])[0].point_data["displacement"], axis=1)
    out.found.append(f"{run['counts']['handed_off']} pieces fly off; plastic work {run['energy']['dissipated_plastic']:.3g} J; "
                     f"at the end a tenth of the points are off by {1e3 * np.quantile(moved, 0.9):.1f} mm or more; {run['cracks']['length_m']:.2f} m of cracks.")
    return out


def figure_13(runs: Runs) -> Drawn:
    """The sheet with its cut, and the spiral as it is pulled."""
    folder, out = runs.place("fig13"), Drawn()
    frames = shell_frames(folder)
    chosen = at_times(frames, (0.0, 0.2, 0.4, 0.6))
    made = view_panels(folder, chosen, VIEW)
    out.add(runs, "fig13", board(made, captions(chosen), 4), "The middle is pulled up, the rim is held.")
    run, box = read_run(folder), Box.around([shells(frames[-1:])[0].points])
    out.found.append(f"{run['cracks']['length_m']:.2f} m of cut, {run['counts']['fragments']} piece; at the end the sheet reaches "
                     f"over {box.high[2] - box.low[2]:.2f} m of height. Stable step {run['stable_step']['initial_s']:.3g} s before "
                     f"and {run['stable_step']['smallest_s']:.3g} s at its smallest.")
    return out


def figure_14(runs: Runs) -> Drawn:
    """Cloth and bunnies of both kinds, and the cracks on the cloth at rest."""
    out, made, words, flat = Drawn(), [], [], []
    region = CASES["fig14_weakened"].made(runs.size).find("shells[cloth].strength_regions[0]")
    low, high = np.array([region.low.u, region.low.v]), np.array([region.high.u, region.high.v])
    for case, name in (("fig14_even", "(a)"), ("fig14_weakened", "(b)")):
        folder = runs.place(case)
        frames = shell_frames(folder)
        chosen = at_times(frames, (0.0, 0.04, 0.08, 0.16))
        made += view_panels(folder, chosen, VIEW, near_shell(frames[:1], 0.4), direction=(-0.35, 0.72, -0.60))
        words += [f"{name} {when}" for when in captions(chosen)]
        graph = grown(graph_of(_last_cracks(frames), case))
        weak = (low, high) if case == "fig14_weakened" else None
        flat.append(_cracks_at_rest(frames, graph, weak))
        out.found.append(f"{name} {_share_inside(graph, low, high)} {read_run(folder)['counts']['fragments']} pieces of cloth.")
    out.add(runs, "fig14", board(made, words, 4), "(a) even cloth, (b) with a weakened band across the middle.")
    out.add(runs, "fig14_cracks", board(flat, ["(a) cracks on the cloth at rest", "(b) the weakened region is grey"], 2),
            "All cracks, on the cloth at rest.")
    return out


def _last_cracks(frames: list[Frame]) -> PolyData | None:
    return next((frame.read(CRACKS) for frame in reversed(frames) if CRACKS in frame.files), None)


def _share_inside(graph: Graph, low: np.ndarray, high: np.ndarray) -> str:
    """How much of the cracks is within a box of parameters, and where the first of them began."""
    found = within(graph, low, high)
    if found.length == 0.0:
        return "no crack grew."
    return (f"{found.length:.2f} m of cracks, {100.0 * found.share:.0f} % of it in the region; the first "
            f"begins {'inside' if found.first else 'outside'}.")


def _cracks_at_rest(frames: list[Frame], graph: Graph, weak: tuple[np.ndarray, np.ndarray] | None) -> Image.Image:
    """The cloth at rest, its cracks and, where there is one, its weakened region (low, high) in parameters."""
    first = shells(frames[:1])[0]
    rest = reference_points(first)
    base = np.broadcast_to(WHOLE, (len(first.triangles), 3)).copy()
    if weak is not None:
        middle = rest[first.triangles].mean(axis=1)[:, :2] - rest.min(axis=0)[:2]  # parameters of a plate begin at a corner
        base[((middle >= weak[0]) & (middle <= weak[1])).all(axis=1)] = GREY
    return panels.sheet_panel(first, base, first, Box.around([rest]), 2 * VIEW[0], graph.rest, at_rest=True)


class _ByPieces(Frame):
    """A frame whose fragments are the pieces of the drawn surface: what hangs together by points that are the same."""

    def read(self, part: int) -> PolyData | None:
        """As a frame reads, with other fragments of the shell."""
        mesh = super().read(part)
        if part == SHELL and mesh is not None:
            mesh.cell_data["fragment"] = hanging_together(mesh)
        return mesh


def hanging_together(shell: PolyData) -> np.ndarray:
    """A number from 0 on for each triangle, equal for those that are linked by shared points, also over seams."""
    triangles = weld(shell.points)[shell.triangles]
    label = np.arange(int(triangles.max(initial=0)) + 1)
    while True:  # the least label of each triangle spreads; then labels are followed to their ends
        before = label.copy()
        np.minimum.at(label, triangles.ravel(), np.repeat(label[triangles].min(axis=1), 3))
        label = label[label]
        if np.array_equal(label, before):
            return np.unique(label[triangles[:, 0]], return_inverse=True)[1]


def figure_15(runs: Runs) -> Drawn:
    """The garment from whole to torn; and its pieces."""
    folder, out = runs.place("fig15"), Drawn()
    frames = shell_frames(folder)
    chosen = [frames[0], *growing(frames, (0.3, 0.7)), frames[-1]]
    box = Box.around([shells(chosen[:1])[0].points])
    box = Box(box.low - np.array([0.05, 0.05, 0.2]), box.high + np.array([0.05, 0.05, 0.0]))
    made = view_panels(folder, chosen, (VIEW[0], 560), box, direction=(-0.35, 0.92, -0.15))
    last = _ByPieces(frames[-1].time_s, frames[-1].files)
    made += view_panels(folder, [last], (VIEW[0], 560), box, by="fragment", direction=(-0.35, 0.92, -0.15))
    out.add(runs, "fig15", board(made, [*captions(chosen), "pieces at the end"], 5), "Straps are held, the hem is pulled down. Each "
            "patch has a colour; in the last picture each piece, the largest white.")
    shell, cracks, run = shells([last])[0], _last_cracks(frames), read_run(folder)
    across = len(np.unique(cracks.cell_data["shell"])) if cracks is not None and len(cracks.line_points) else 0
    area = _piece_areas(shell)
    large = int((area > PIECE * area.sum()).sum())
    out.found.append(f"{large} pieces of a hundredth of the cloth or more, and {run['counts']['handed_off']} small ones handed to the "
                     f"rigid engine; cracks in {across} of {run['counts']['patches']} patches, {run['cracks']['length_m']:.2f} m long. "
                     f"{_held_together(run)}")
    return out


def _held_together(run: dict[str, Any]) -> str:
    """The parts of the shells that forces still hold together, from run.json."""
    areas = run.get("surface", {}).get("held_together_m2")
    if areas is None:  # a shell is frozen, or the run is of an older version
        return "What forces still hold together is not in run.json."
    return f"Forces hold {len(areas)} parts together: {', '.join(f'{area:.3g}' for area in areas[:6])} m^2."


def figure_16(runs: Runs) -> Drawn:
    """The mannequin in its dress, the dress as it tears, and its pieces at the end, from the front and from behind."""
    folder, out = runs.place("fig16"), Drawn()
    frames = shell_frames(folder)
    chosen = [frames[0], *growing(frames, (0.1, 0.4, 0.7)), frames[-1]]
    box = Box.around([shells(chosen[:1])[0].points])
    box = Box(box.low - np.array([0.12, 0.1, 0.18]), box.high + np.array([0.12, 0.1, 0.3]))
    last = _ByPieces(frames[-1].time_s, frames[-1].files)
    made, words = [], []
    for name, direction in (("", (0.30, 0.94, -0.12)), ("behind, ", (0.30, -0.94, -0.12))):
        made += view_panels(folder, chosen, TALL, box, direction=direction)
        made += view_panels(folder, [last], TALL, box, by="fragment", direction=direction)
        words += [name + when for when in [*captions(chosen), "pieces at the end"]]
    out.add(runs, "fig16", board(made, words, 6), "The body is inflated. Each patch of the dress has a colour; in the last "
            "picture each piece, the largest white.")
    run, area, cracks = read_run(folder), _piece_areas(shells([last])[0]), _last_cracks(frames)
    across = len(np.unique(cracks.cell_data["shell"])) if cracks is not None and len(cracks.line_points) else 0
    out.found.append(f"{int((area > PIECE * area.sum()).sum())} pieces of a hundredth of the cloth or more; cracks in {across} of "
                     f"{run['counts']['patches']} patches, {run['cracks']['length_m']:.2f} m long; "
                     f"{run['counts']['handed_off']} small pieces handed to the rigid engine. {_held_together(run)}")
    depth, deepest = _depths(frames, CASES["fig16"].made(runs.size).message.shells[0].thickness_m)
    out.found.append(depth)
    out.checks.append(deepest)
    return out


def _depths(frames: list[Frame], thickness_m: float) -> tuple[str, Check]:
    """How deep the face of the cloth has been in the body, over all frames, in words and against half a thickness."""
    deepest, when, share = -1.0, 0.0, 0.0
    for frame in frames:
        far = _off_body(frame)
        if 0.5 * thickness_m - float(far.min()) > deepest:
            deepest, when = 0.5 * thickness_m - float(far.min()), frame.time_s
        share = max(share, float((far < 0.0).mean()))
    words = (f"Over all frames the deepest point of the dress is {1e3 * deepest:.1f} mm in the body, counted from the face of the "
             f"cloth, at {when:.2f} s; at most {100.0 * share:.2f} % of the points of a frame are deeper than half a thickness, "
             f"{500.0 * thickness_m:g} mm.")
    return words, Check("fig16_depth", deepest, 0.5 * thickness_m, "the deepest point of the dress in the body, counted from the "
                        "face of the cloth [m], against half a thickness")


def _piece_areas(shell: PolyData) -> np.ndarray:
    """Area at rest [m^2] of each fragment."""
    corner = reference_points(shell)[shell.triangles]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return np.bincount(np.unique(shell.of_triangles("fragment", 0), return_inverse=True)[1], area)


def _off_body(frame: Frame) -> np.ndarray:
    """How far [m] the middle of the cloth is outside of bodies that engines do not move, at each of its points."""
    shell, bodies = frame.read(SHELL), frame.read(BODIES)
    if shell is None or bodies is None or not len(shell.triangles):
        return np.full(1, np.inf)
    held = bodies.triangles[bodies.of_triangles("kind", STATIC) == STATIC]
    return outside(shell.points[np.unique(shell.triangles)], bodies.points, held)


def figure_17(runs: Runs) -> Drawn:
    """The pane as it shatters and as its shards fall, and its crack pattern."""
    folder, out = runs.place("fig17"), Drawn()
    frames = list_frames(folder)
    with_shell = shell_frames(folder)
    breaking, falling = growing(with_shell, (0.3, 1.0)), at_times(frames, [share * frames[-1].time_s for share in FALLING])
    near = near_shell(frames[:1], 0.2)
    made = view_panels(folder, breaking, VIEW, near, direction=DIRECTION)
    made += view_panels(folder, falling, VIEW, Box(np.array([near.low[0], near.low[1], 0.0]), near.high), direction=DIRECTION)
    out.add(runs, "fig17", board(made, captions([*breaking, *falling]), 4), "The marble, the pane, its shards.")
    drawn = crack_pattern(frames, *shards_of(folder), 900 * panels.SAMPLES, 900 * panels.SAMPLES, panels.MARGIN)
    if drawn is not None:
        out.add(runs, "fig17_cracks", Image.fromarray(as_bytes(drawn[0])).reduce(panels.SAMPLES),
                "Crack pattern on the pane at rest; each piece has a colour.")
    run = read_run(folder)
    out.found.append(f"{run['counts']['handed_off']} shards handed to the rigid engine; {run['cracks']['length_m']:.2f} m of cracks; "
                     f"shell solved until {run['time'].get('frozen_at_s') or run['time']['simulated_s']:.3g} s.")
    return out

