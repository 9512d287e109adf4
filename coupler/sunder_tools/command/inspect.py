"""`sunder inspect`: what a STEP, IGES or mesh file holds, before there is a scene."""
from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import BAD_INPUT, DONE, PEER_LOST, CommandError, how_it_ended
from ..launch.build import ensure_built
from ..words import own_command
from .parser import MESHES, Subparsers, add_command, number_within

if TYPE_CHECKING:
    from ..report.gaps import Gap  # needs numpy, which a start does not

NAME = "inspect"
MOST_GAPS = 20  # that are listed
SCENE = """\
# {which} of {path} as {shells}. The part falls on a floor.
name: "{name}"
end_time_s: 0.02
window_s: 1e-4
materials {{ name: "steel" density: 7800 youngs_modulus: 2e11 poisson_ratio: 0.3 }}
shells {{
  name: "part"
  material: "steel"
  thickness_m: {thickness:.6g}
  {kind} {{ path: "{path}" {more}element_m: {element:.6g} }}
}}
bodies {{ name: "floor" half_space {{}} pose {{ position {{ z: {floor:.6g} }} }} }}
"""


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder inspect`."""
    parser = add_command(
        subparsers, NAME, "say what a STEP, IGES or mesh file holds",
        "Lists the faces of a file with kind, size, stable step, trims and the names of their shells, says which would\n"
        "be refused as shells, or be too slow, and why, counts the edges that they share, and finds gaps. Names bodies and\n"
        "layers. Builds the programs with OpenCASCADE where they are without. Of a mesh it tells counts, borders, gaps, size\n"
        "and the charts that become shells.",
        "sunder inspect part.step --element 0.002 --scene part.textproto")
    parser.add_argument("file", metavar="FILE", type=Path, help="a .step, .stp, .igs or .iges file,\nor a mesh: .obj, .off, .ply, .stl, .glb or .gltf")
    parser.add_argument("--element", metavar="M", type=_length,
                        help="spacing of shells [m] (default: a fortieth of the size)")
    parser.add_argument("--unit", metavar="M", type=_length, help="unit [m], 0.001 for millimetres: of a mesh (default: 1),\nor of a CAD file that says none")
    parser.add_argument("--weld", metavar="M", type=_length,
                        help="points of a mesh no further apart become one (default: only equal ones)")
    parser.add_argument("--json", action="store_true", help="print all as JSON")
    parser.add_argument("--picture", metavar="PNG", type=Path,
                        help="draw the shells with the edges that they share, free ones\nand gaps")
    parser.add_argument("--scene", metavar="SCENE", type=Path, help="write a scene of all faces that can be taken, and check it")


def run(arguments: argparse.Namespace) -> int:
    """Hands the file to sunder-shell inspect and prints what it says; returns the exit status. Raises CommandError."""
    if not arguments.file.is_file():
        raise CommandError(f"'{arguments.file}' is no file; name a STEP, IGES or mesh file", BAD_INPUT)
    program = ensure_built(cad=arguments.file.suffix.lower() not in MESHES).shell
    command = [str(program), "inspect", str(arguments.file)]
    for name in ("element", "unit", "weld"):
        if getattr(arguments, name) is not None:
            command += [f"--{name}", repr(getattr(arguments, name))]
    if arguments.picture is not None and (arguments.picture.suffix.lower() != ".png" or not arguments.picture.resolve().parent.is_dir()):
        raise CommandError(f"--picture {arguments.picture}: name a .png file in a folder that exists", BAD_INPUT)
    with tempfile.TemporaryDirectory() as folder:
        if arguments.picture is not None:
            command += ["--frame", folder]
        ended = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
        if ended.returncode < 0:
            raise CommandError(f"sunder-shell {how_it_ended(ended.returncode)} while it read {arguments.file}", PEER_LOST)
        if ended.returncode != DONE:
            return ended.returncode
        told = json.loads(ended.stdout)
        print(ended.stdout if arguments.json else report(told), end="")
        if arguments.picture is not None:
            from ..pictures.inspected import draw_inspected
            draw_inspected(Path(folder), told, gaps_in(told) or [], arguments.picture)
            if not arguments.json:
                print(arguments.picture)
    if arguments.scene is not None:
        write_scene(arguments.scene, arguments.file, told)
        cost = checked(program, arguments.scene)
        if not arguments.json:
            print(f"{arguments.scene} is written, and passes {own_command('check', arguments.scene)}\n{cost}",
                  end="")
    return DONE


def report(told: dict[str, Any]) -> str:
    """The text of what sunder-shell says of a file."""
    if "charts" in told:
        return mesh_report(told)
    faces = told["faces"]
    lines = [f"{told['file']}: {_count(len(faces), 'face')}, {' x '.join(f'{x:.4g}' for x in told['size_m'])} m, "
             f"unit {told['unit']}, elements of {told['element_m']:.3g} m",
             f"{'face':>4}  {'kind':22} {'size [m]':>21} {'area [m^2]':>11} {'elements':>11} {'step [s]':>9}  {'shells':18} trims"]
    for face in faces:
        head = f"{face['face']:>4}  {face['kind']:22} "
        if face["refused"] is not None:
            lines.append(f"{head}refused: {face['refused']}")
            continue
        size = " x ".join(f"{x:.4g}" for x in face["width_m"])
        elements = " x ".join(str(n) for n in face["elements"])
        lines.append(f"{head}{size:>21} {face['area_m2']:>11.4g} {elements:>11} {face['stable_step_s']:>9.2g}  "
                     f"{_names(face['shells']):18} {_trims(face)}")
    for face in faces:
        if face["refused"] is None and face["warning"] is not None:
            lines.append(f"face {face['face']} {'is unfit' if face['unfit'] else 'is slow'}: {face['warning']}")
    for kind in ("bodies", "layers"):
        if told[kind]:
            lines.append(f"{kind}: " + ", ".join(f"'{own['name']}' ({_count(len(own['faces']), 'face')})" for own in told[kind]))
    edges = told["edges"]
    lines.append(f"edges: {edges['shared']} shared, {edges['free']} free, {edges['of_three_faces_or_more']} of three "
                 f"faces or more; the widest tolerance is {edges['widest_tolerance_m']:.2g} m")
    lines += gap_lines(told)
    if told["seams"] is not None:
        seams = told["seams"]
        lines.append(f"seams: {seams['joined']} joined, {seams['smooth']} of them smooth, "
                     f"{seams['along_trims']} along trims")
    if told["seams_refused"] is not None:
        lines.append(f"seams refused: {told['seams_refused']}")
    return "\n".join(lines) + "\n"


def mesh_report(told: dict[str, Any]) -> str:
    """The text of what sunder-shell says of a mesh."""
    edges = told["edges"]
    lines = [f"{told['file']}: {_count(told['faces'], 'face')}, {_count(told['triangles'], 'triangle')}, "
             f"{_count(told['points'], 'point')}, {' x '.join(f'{x:.4g}' for x in told['size_m'])} m where its unit is "
             f"{told['unit_m']:.6g} m, area {told['area_m2']:.4g} m^2, elements of {told['element_m']:.3g} m",
             f"{_count(told['components'], 'component')}, {_count(edges['borders'], 'border')} of "
             f"{_count(edges['on_borders'], 'edge')}, {told['points_merged']} points merged, "
             f"{told['triangles_turned']} triangles turned over, {told['triangles_dropped']} with two corners in one place"]
    if told["points_parted"]:
        lines.append(f"the surface touches itself in {_count(told['points_parted'], 'point')}, where its sheets are parted")
    if told["warning"] is not None:
        lines.append(f"warning: {told['warning']}")
    for kind in ("groups", "usemtl"):
        if told[kind]:
            lines.append(f"{kind}: " + ", ".join(f"{own['name']} ({_count(own['triangles'], 'triangle')})" for own in told[kind]))
    if told["coloured"]:
        lines.append("points have colours, which strength_paint and thickness_paint may use")
    lines += gap_lines(told)
    if told["refused"] is not None:
        return "\n".join([*lines, f"refused: {told['refused']}"]) + "\n"
    lines.append(f"{'shell':12} {'triangles':>9} {'size [m]':>21} {'area [m^2]':>11} {'elements':>11} {'stretch':>8} "
                 f"{'off by [m]':>10} {'step [s]':>9}  trims")
    for chart in told["charts"]:
        trims = (["border"] if chart["trimmed"] else []) + ([_count(chart["holes"], "hole")] if chart["holes"] else [])
        size = " x ".join(f"{x:.4g}" for x in chart["width_m"])
        elements = " x ".join(str(n) for n in chart["elements"])
        lines.append(f"{chart['shell']:12} {chart['triangles']:>9} {size:>21} {chart['area_m2']:>11.4g} {elements:>11} "
                     f"{chart['stretch']:>8.3f} {chart['error_m']:>10.2g} {chart['stable_step_s']:>9.2g}  "
                     f"{', '.join(trims) or '-'}")
    lines += [f"{chart['shell']} is slow: {chart['warning']}" for chart in told["charts"] if chart["warning"] is not None]
    if told["seams"]["joined"]:
        lines.append(f"seams: {told['seams']['joined']} joined, {told['seams']['smooth']} of them smooth")
    return "\n".join(lines) + "\n"


def gaps_in(told: dict[str, Any]) -> list[Gap] | None:
    """Finds where borders nearly meet; of a mesh the widest place only. None where there are too many borders."""
    from ..report.gaps import gap_of_borders, gaps_of_edges
    if "charts" not in told:
        return gaps_of_edges(told["edges"]["list"], 0.5 * float(told["element_m"]))
    found = gap_of_borders(told["borders_m"])
    return None if found is None else [found[1]] if found[1] is not None else []


def gap_lines(told: dict[str, Any]) -> list[str]:
    """What a report says of gaps: a line for each pair of faces, or one for a mesh."""
    gaps = gaps_in(told)
    if gaps is None:
        return ["gaps: not looked for, as there are too many free edges"]
    place = [", ".join(f"{x:.4g}" for x in gap.at_m) for gap in gaps]
    if "charts" not in told:
        lines = [f"gap: faces {gap.faces[0]} and {gap.faces[1]} nearly meet, up to {gap.width_m:.3g} m apart at ({at}) m; "
                 f"seams {{ tolerance_m: {1.1 * gap.width_m:.2g} }} joins them" for gap, at in zip(gaps[:MOST_GAPS], place)]
        return lines + ([f"gap: {len(gaps) - MOST_GAPS} more"] if len(gaps) > MOST_GAPS else [])
    if not gaps:
        return []
    from ..report.gaps import gap_of_borders
    count = (gap_of_borders(told["borders_m"]) or (0, None))[0]
    weld = f"{1.1 * gaps[0].width_m:.2g}"
    return [f"gap: beside {_count(count, 'point')} of a border runs another border, up to {gaps[0].width_m:.3g} m off at "
            f"({place[0]}) m; " + (f"--weld {weld} joins points that are so near" if gaps[0].points_m <= float(weld) else
                                   f"their points are up to {gaps[0].points_m:.3g} m apart, so --weld does not join them: close "
                                   "it in the program that made the mesh")]


def write_scene(scene: Path, file: Path, told: dict[str, Any]) -> None:
    """Writes a scene of all faces that can be taken. Raises CommandError where the file is not below its folder."""
    try:
        path = file.resolve().relative_to(scene.resolve().parent)
    except ValueError as error:
        raise CommandError(f"'{scene}' is not beside '{file}', and scenes name files beside them; write it there",
                           BAD_INPUT) from error
    if scene.exists():
        raise CommandError(f"'{scene}' exists; give another name, or remove it", BAD_INPUT)
    mesh = "charts" in told
    everything = mesh or len(told["taken"]) == len(told["faces"])
    if told["refused"] is not None if mesh else not told["taken"]:
        raise CommandError(f"no face of '{file}' can be taken, so there is no scene to write", BAD_INPUT)
    if mesh:
        more = "".join(f"{name}: {told[name]:.6g} " for name, usual in (("unit_m", 1.0), ("weld_m", 0.0)) if told[name] != usual)
    else:
        more = "" if told["unit_m"] is None else f"unit_m: {told['unit_m']!r} "
        more += "" if everything else "".join(f"faces: {n} " for n in told["taken"])
    element = told["element_m"]
    thickness = told["thickness_m"]
    name = "".join(c if c.isascii() and c.isalnum() else "_" for c in scene.stem.lower())
    scene.write_text(SCENE.format(which="All faces" if everything else "Faces", path=path.as_posix(), name=name, thickness=thickness,
                                  more=more, element=element, kind="mesh" if mesh else "cad",
                                  shells="charts that are joined" if mesh else
                                  "shells, joined along the edges that they share",
                                  floor=told["low_m"][2] - thickness))


def checked(program: Path, scene: Path) -> str:
    """What a check says of the cost of a scene. Raises CommandError where it refuses the scene."""
    ended = subprocess.run([str(program), "--scene", str(scene), "--check"], stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE, text=True, check=False)
    if ended.returncode < 0:
        raise CommandError(f"sunder-shell {how_it_ended(ended.returncode)} while checking {scene}", PEER_LOST)
    if ended.returncode != DONE:
        why = ended.stderr.strip().removeprefix("sunder-shell: ")
        raise CommandError(f"'{scene}' is written, but 'sunder check' refuses it; change it there, or inspect again with "
                           f"another --element or --unit, into another --scene: {why}", BAD_INPUT)
    lines = [line for line in ended.stdout.splitlines() if line.startswith(("substeps ", "time ", "warning "))]
    return "".join(f"  {line}\n" for line in lines)


def _length(text: str) -> float:
    return number_within(text, 1e-6, 1e3)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _names(shells: list[str]) -> str:
    return " to ".join(dict.fromkeys([*shells[:1], *shells[-1:]])) or "-"


def _trims(face: dict[str, Any]) -> str:
    parts = (["border"] if face["parts_trimmed"] else []) + ([_count(face["holes"], "hole")] if face["holes"] else [])
    if face["parts"] > 1:
        parts.append(f"in {face['parts']} parts")
    if face["approximated_m"] > 0.0:
        parts.append(f"approximated to {face['approximated_m']:.2g} m")
    return ", ".join(parts) or "-"
