"""Draws the figures of sheets that are seen straight on: 4, 5, 8, 9 and 11, and the shares of time, 18."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from PIL import Image

from sunder_tools.pictures.contact_sheet import time_text
from sunder_tools.pictures.crack_lines import Graph, graph_of, grown, last_graph
from sunder_tools.pictures.flat import crack_pattern, shards_of
from sunder_tools.pictures.frames import CRACKS, SHELL, Frame, list_frames
from sunder_tools.pictures.meshes import reference_points
from sunder_tools.pictures.palette import ramp
from sunder_tools.pictures.raster import rasterise
from sunder_tools.pictures.strain import principal_stretch
from sunder_tools.pictures.views import as_bytes
from sunder_tools.pictures.vtp import PolyData, VtpError
from sunder_tools.report.run_json import read_run

from . import panels, skeleton
from .checks import Check
from .panels import Box, board, captions, crack_lines, growing, sheet_panel, shell_frames
from .runs import Runs

WIDE, NARROW = 620, 340  # [px] of a panel: two and four beside each other
CALM, FAR = np.array([0.80, 0.87, 0.88]), np.array([0.78, 0.10, 0.08])
MOST = 3.0               # stretch with the last colour
STAGES = (np.array([0.25, 0.80, 0.85]), np.array([0.30, 0.68, 0.30]), np.array([0.90, 0.45, 0.68]))  # cyan, green, pink
STAGE_NAMES = ("cyan", "green", "pink")
WHOLE = np.array([0.93, 0.94, 0.94])
AT_ONCE = 0.999          # damage that counts as complete
RASTER = 520             # [px] on which regions are thinned
FIRST = 0.12             # share of the cracks of the pressed plate that is shown first
NEAR = 2                 # [px] within which two skeletons are the same
MODELS = (("fig09_ours", "the paper's projection", (0.45, 0.72, 0.45)), ("fig09_plane_stress", "plane stress, the default here",
          (0.55, 0.75, 0.70)), ("fig09_jgt17", "JGT17", (0.85, 0.42, 0.38)), ("fig09_ghf18", "GHF18", (0.62, 0.50, 0.75)))


@dataclass
class Drawn:
    """Pictures of a figure with a sentence each, what came out, and what was measured on the way."""
    pictures: list[tuple[str, str]] = field(default_factory=list)
    found: list[str] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)

    def add(self, runs: Runs, name: str, image: Image.Image, words: str) -> None:
        """Writes a picture into the folder of the page."""
        panels.save(image, runs.folder / f"{name}.png")
        self.pictures.append((f"{name}.png", words))


def pieces(shell: PolyData) -> int:
    """The number of pieces of a sheet."""
    return len(np.unique(shell.of_triangles("fragment", 0)))


def parted(frames: list[Frame]) -> int:
    """The number of the first frame with the sheet in several pieces; the last one where it stays whole."""
    for k, frame in enumerate(frames):
        shell = frame.read(SHELL)
        if shell is not None and pieces(shell) > 1:
            return k
    return len(frames) - 1


def shells(frames: list[Frame]) -> list[PolyData]:
    """The sheets of frames. Raises VtpError where one has none."""
    found = [frame.read(SHELL) for frame in frames]
    if any(shell is None for shell in found):
        raise VtpError("a frame has no shell")
    return [shell for shell in found if shell is not None]


def of_layers(values: np.ndarray) -> np.ndarray:
    """The largest value of each triangle's layers."""
    return values.max(axis=1) if values.ndim == 2 else values


def figure_4(runs: Runs) -> Drawn:
    """Stretch with maximum damage that is not cut, with cuts, and with healing and cuts, at the same two instants."""
    out, made, words = Drawn(), [], []
    cases = (("fig04_maximum", "(a) maximum damage, not cut"), ("fig04_cut", "maximum damage, cut"),
             ("fig04_healing", "(b) damage heals, cut"))
    times = [f.time_s for f in shell_frames(runs.place("fig04_healing"))]
    part = times[parted(shell_frames(runs.place("fig04_healing")))]
    sheets = [(name, frame) for case, name in cases
              for frame in panels.at_times(shell_frames(runs.place(case)), (part + 0.1, times[-1]))]
    box = Box.around([shell.points for shell in shells([frame for _, frame in sheets])])
    first = shells(shell_frames(runs.place("fig04_healing"))[:1])[0]
    for name, frame in sheets:
        shell = shells([frame])[0]
        stretch = principal_stretch(shell)
        big = _area(shell) > 0.05 * float(np.median(_area(shell)))
        share = np.clip((stretch - 1.0) / (MOST - 1.0), 0.0, 1.0)[:, None]
        made.append(sheet_panel(shell, CALM + share * (FAR - CALM), first, box, WIDE, crack_lines(frame)))
        words.append(f"{name}, {time_text(frame.time_s)}: at most {stretch[big].max():.3g}")
        if frame.time_s > part + 0.2:
            out.found.append(f"{name}: largest stretch at the end {stretch[big].max():.3g}.")
    out.add(runs, "fig04", board(made, words, 2), f"Stretch, from 1 (pale) to {MOST:g} and more (red). Left shortly after the "
            "sheet has parted, right at the end.")
    return out


def _area(shell: PolyData) -> np.ndarray:
    corner = reference_points(shell)[shell.triangles]
    return 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)


def figure_5(runs: Runs) -> Drawn:
    """c_his above c at the same instants."""
    frames = shell_frames(runs.place("fig04_healing"))
    chosen = [*growing(frames, (0.02, 0.5, 1.0)), frames[-1]]
    sheets = shells(chosen)
    box, first = Box.around([shell.points for shell in sheets]), shells(frames[:1])[0]
    made, words, out = [], [], Drawn()
    for name, field_name in (("c_his", "c_his"), ("c", "damage")):
        for frame, shell, when in zip(chosen, sheets, captions(chosen)):
            values = of_layers(shell.of_triangles(field_name, 0.0))
            made.append(sheet_panel(shell, ramp(values), first, box, NARROW, crack_lines(frame)))
            words.append(f"{name}, {when}")
    share = [[float((of_layers(s.of_triangles(n, 0.0)) * _area(s)).sum() / _area(s).sum()) for s in sheets]
             for n in ("c_his", "damage")]
    out.found.append("Mean of c_his over the sheet at these instants: " + ", ".join(f"{100 * s:.2f} %" for s in share[0])
                     + "; of c: " + ", ".join(f"{100 * s:.2f} %" for s in share[1]) + ".")
    out.add(runs, "fig05", board(made, words, len(chosen)), "c_his above, c below: from 0 (grey) to 1 (dark). Crack lines in ink.")
    return out


def figure_8(runs: Runs) -> Drawn:
    """Damaged regions of three stages, their skeletons taken anew, and the crack lines here."""
    frames = shell_frames(runs.place("fig14_even"))
    chosen = growing(frames, (0.15, 0.45, 1.0))
    first, out = shells(frames[:1])[0], Drawn()
    box = Box.around([reference_points(first)])
    camera, height = panels.sheet_camera(first, box, RASTER)
    regions: list[np.ndarray] = []
    for shell in shells(chosen):
        done = of_layers(shell.of_triangles("c_his", 0.0)) >= AT_ONCE
        pixels, near = camera.project(reference_points(shell))
        region = (rasterise(pixels, near, shell.triangles[done], RASTER, height)[0] >= 0).reshape(height, RASTER)
        regions.append(region | regions[-1] if regions else region)  # pieces that have left were damaged before
    lines = [skeleton.thinned(region) for region in regions]
    graph = graph_of(chosen[-1].read(CRACKS), "fig14_even")
    made = [_painted(regions[::-1], STAGES[::-1]), _painted([skeleton.grown(line, 1) for line in lines[::-1]], STAGES[::-1]),
            _crack_stages(chosen, camera, height)]
    out.add(runs, "fig08", board(made, ["(a) damaged at three stages", "(b) skeletons, taken anew at each", "(c) crack lines here"], 3),
            "Stages at " + ", ".join(f"{time_text(f.time_s)} ({name})" for f, name in zip(chosen, STAGE_NAMES)) + ".")
    for k in (0, 1):
        out.found.append(f"{100 * skeleton.moved(lines[k], lines[k + 1], NEAR):.0f} % of the {STAGE_NAMES[k]} skeleton is gone from "
                         f"the {STAGE_NAMES[k + 1]} one.")
    early = [graph_of(frame.read(CRACKS), "fig14_even") for frame in chosen]
    kept = [set(one.keys()) <= set(other.keys()) for one, other in zip(early, early[1:])]
    out.found.append(f"All crack edges of earlier stages are edges of later ones: {'yes' if all(kept) else 'no'}. "
                     f"{len(grown(graph))} edges at the last stage.")
    return out


def _painted(regions: list[np.ndarray], colours: tuple[np.ndarray, ...]) -> Image.Image:
    picture = np.broadcast_to(WHOLE, (*regions[0].shape, 3)).copy()
    for region, colour in zip(regions, colours):
        picture[region] = colour
    return Image.fromarray(as_bytes(picture))


def _crack_stages(chosen: list[Frame], camera: panels.Camera, height: int) -> Image.Image:
    picture = np.broadcast_to(WHOLE, (height * RASTER, 3)).copy()
    for frame, colour in list(zip(chosen, STAGES))[::-1]:
        graph = graph_of(frame.read(CRACKS), "fig14_even")
        panels.draw_lines(picture, camera, graph.rest, RASTER, height, colour)
    return Image.fromarray(as_bytes(picture.reshape(height, RASTER, 3)))


def figure_9(runs: Runs) -> Drawn:
    """The torn sheet at rest with each model, and its area."""
    out, last = Drawn(), []
    for case, _, _ in MODELS:
        last.append(shell_frames(runs.place(case))[-1])
    sheets = shells(last)
    box, first = Box.around([s.points for s in sheets]), shells(shell_frames(runs.place(MODELS[0][0]))[:1])[0]
    made, words = [], []
    for (case, name, colour), frame, shell in zip(MODELS, last, sheets):
        made.append(sheet_panel(shell, np.broadcast_to(np.array(colour), (len(shell.triangles), 3)), first, box, NARROW,
                                crack_lines(frame)))
        surface = read_run(runs.place(case)).get("surface") or {}
        now, rest = float(surface.get("now_m2") or np.nan), float(surface.get("rest_m2") or np.nan)
        words.append(f"{name}: {now:.3f} m2")
        out.found.append(f"{name}: {now:.4f} m2 in {pieces(shell)} pieces, which have {rest:.4f} m2 at rest.")
    out.add(runs, "fig09", board(made, words, 4), "The sheet at the end of each run, and its area.")
    return out


def figure_11(runs: Runs) -> Drawn:
    """Crack paths under mode I and II, and of the pressed plate."""
    out, made, words = Drawn(), [], []
    for case, name in (("fig11_mode_one", "(a) mode I"), ("fig11_mode_two", "(b) mode II")):
        frame = shell_frames(runs.place(case))[-1]
        shell = shells([frame])[0]
        made.append(sheet_panel(shell, ramp(of_layers(shell.of_triangles("c_his", 0.0))), shell,
                                Box.around([reference_points(shell)]), 420, crack_lines(frame, at_rest=True), at_rest=True))
        words.append(f"{name}: c_his and crack")
        out.found.append(f"{name}: {_direction(frame)}")
    plate = shell_frames(runs.place("fig11_plate"))
    first, graph = shells(plate[:1])[0], last_graph(runs.place("fig11_plate"))
    early, grey = graph.some(born_first(graph, FIRST)), np.broadcast_to(WHOLE, (len(first.triangles), 3))
    made.append(sheet_panel(first, grey, first, Box.around([reference_points(first)]), 420, early.rest, at_rest=True))
    words.append(f"(c) plate under pressure, first {100 * FIRST:.0f} % of cracks")
    folder = runs.place("fig11_plate")
    drawn = crack_pattern(list_frames(folder), *shards_of(folder), 420 * panels.SAMPLES, made[0].height * panels.SAMPLES,
                          panels.MARGIN)
    if drawn is not None:
        made.append(Image.fromarray(as_bytes(drawn[0])).reduce(panels.SAMPLES))
        words.append("(c) at the end")
    began, ended = (1e3 * float(t) for t in (graph.born.min(initial=np.inf), graph.born.max(initial=-np.inf)))
    out.found.append(f"(c) cracks from {began:.3g} to {ended:.3g} ms, while the pressure grows.")
    out.add(runs, "fig11", board(made, words, 4), "Cracks on the sheets at rest.")
    return out


def born_first(graph: Graph, share: float) -> np.ndarray:
    """Which edges (n,) are born first and make up this share of the length of all."""
    length = np.linalg.norm(graph.rest[:, 1] - graph.rest[:, 0], axis=1)
    order = np.argsort(graph.born, kind="stable")
    out = np.zeros(len(graph), bool)
    out[order[np.cumsum(length[order]) <= share * length.sum()]] = True
    return out


def _direction(frame: Frame) -> str:
    """How the crack that grew leaves its notch, in words."""
    graph = grown(graph_of(frame.read(CRACKS), "fig11"))
    if len(graph) == 0:
        return "no crack grew."
    start = graph.ends[int(np.argmin(graph.born)), 0]
    away = graph.ends.reshape(-1, 2) - start
    near = away[np.linalg.norm(away, axis=1) < 0.03]  # [m] over which the direction is taken
    tip = near[int(np.argmax(np.linalg.norm(near, axis=1)))]
    return (f"{np.linalg.norm(graph.ends[:, 1] - graph.ends[:, 0], axis=1).sum():.3f} m of crack; over its first 3 cm it leaves "
            f"at {np.degrees(np.arctan2(tip[1], tip[0])):.0f} degrees to the notch.")


def figure_18(runs: Runs) -> Drawn:
    """The shares of time of the stages of the garment's run."""
    folder, out = runs.place("fig15"), Drawn()
    seconds = {str(k): float(v) for k, v in ((read_run(folder).get("time") or {}).get("stage_s") or {}).items()}
    whole = sum(seconds.values()) or 1.0
    shares = sorted(((name, s / whole) for name, s in seconds.items()), key=lambda one: -one[1])
    fracture = sum(share for name, share in shares if name == "crack_update")
    here = [(name.replace("_", " "), share) for name, share in shares if share >= 5e-4]
    image = panels.bars([*here, ("", 0.0), ("paper: elasto-dynamics", 0.85), ("paper: fracture, four parts", 0.15)], 900,
                        [(86, 120, 140)] * len(here) + [(255, 255, 255), (170, 120, 90), (170, 120, 90)])
    out.add(runs, "fig18", image, "Shares of the solver's time, of the run of Fig. 15.")
    out.found.append(f"Cracks take {100 * fracture:.1f} % of the time here, 15 % in the paper. Damage is computed with the stress "
                     "and counts as internal force.")
    return out


