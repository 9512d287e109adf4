"""CAD files and meshes that others have published: each becomes shells, rests without strain, and is struck.

The files are in packages of Debian's archive and are fetched for the run; none is a part of this repository. So the case
needs `apt-get`, `dpkg` and the archive, and is skipped without them; files of a package that cannot be had are skipped alone.
"""
from __future__ import annotations

import gzip
import json
import math
import shutil
import subprocess
import tarfile
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.launch.build import Executables, ensure_built
from sunder_tools.launch.run import launch_once
from sunder_tools.pictures.vtp import read_vtp
from sunder_tools.report.columns import read_columns
from sunder_tools.words import command_line

from .trials import MOST_MISSING, Missing, Table

ARCHIVE = {"libcgal-demo": "usr/share/doc/libcgal-dev/data.tar.gz"}  # packages whose files are in an archive of their own
NO_CAD = "this build has no OpenCASCADE"  # says shell/io/cad_file.cpp
STEPS_OF_A_WINDOW = 20
RESTS, NEAR = 3, 3  # windows in which the part rests; more until the ball touches, which is felt somewhat before
CROSSINGS = 3.0  # time of the run, in times that a wave takes over the diagonal
SPEED = 15.0  # [m/s] of the ball
BALL = 1  # its number in frames
TOUCHED = 1e-4  # share of its free way by which a ball that touched falls short; frames are of single precision
DENSITY, YOUNG = 2400.0, 70e9  # [kg/m^3], [Pa] of the porcelain of scenes/rabbit.textproto
SCENE = """name: "{name}" end_time_s: {end!r} window_s: {window!r} gravity {{}}
materials {{ name: "porcelain" density: {density} youngs_modulus: {young} poisson_ratio: 0.2 strength: 70e6 weibull_modulus: 10
  fracture_energy: 15 crack_speed_onset: 0.44 toughening: 60 branch_drive: 10 }}
materials {{ name: "lead" density: {heavy!r} }}
shells {{ name: "part" material: "porcelain" thickness_m: {thickness!r}
  {kind} {{ path: {path} element_m: {element!r} {more} }} }}
bodies {{ name: "ball" material: "lead" sphere {{ radius_m: {radius!r} }}
  pose {{ position {{ x: {at[0]!r} y: {at[1]!r} z: {at[2]!r} }} }} twist {{ linear {{ z: {speed!r} }} }} }}
{seams}
fracture {{ seed: 1 latest_freeze_s: {end!r} }}
output {{ frame_interval_s: {end!r} }}
"""


@dataclass(frozen=True)
class PublicFile:
    """A file in a package of Debian's archive, and what is expected of it."""
    name: str
    package: str
    path: str              # in the package, or in its archive
    taken: int             # faces of a CAD file; charts of a mesh
    unit: float = 0.0      # [m] of a mesh
    tolerance: float = 1e-6  # of area and mass
    seams: str = "seams {}"
    struck: tuple[int, ...] = ()  # faces of the body that is run, where the file has several that touch; (): all
    element: float = 0.0    # [m] spacing; 0: as `inspect` chooses
    thickness: float = 0.0  # [m]; 0: as `inspect` chooses
    refused: str = ""       # words of the reason why nothing is taken


NETGEN, FREECAD = "usr/share/doc/netgen/examples/", "usr/share/freecad/Mod/Idf/Idflibs/"
GMSH = "usr/share/doc/gmsh-doc/doc/gmsh/demos/api/"
CGAL, STL = "data/meshes/", "usr/share/assimp/models/STL/"
FILES = (
    PublicFile("boxes", "gmsh-doc", GMSH + "step_boundary_colors.stp.gz", 6),
    PublicFile("screw", "netgen-doc", NETGEN + "screw.step", 10),
    PublicFile("inductor", "freecad-common", FREECAD + "EPL22_6_16.stp", 36),
    PublicFile("capacitor", "freecad-common", FREECAD + "1210_SMD.stp", 16, element=5e-5,  # strips of 0.1 mm
               struck=(5, 6, 7, 8, 9)),  # an end cap; along the creases of all trimmed faces each substep solves one dense system
    PublicFile("coil_iges", "freecad-common", FREECAD + "RLF_12545.igs", 47, seams="seams { tolerance_m: 1.5e-5 }",
               struck=tuple(range(10, 37)), thickness=5e-6),  # its faces have gaps of 10 micrometres
    PublicFile("hinge", "netgen-doc", NETGEN + "hinge.stl", 18, unit=1e-3, tolerance=0.02),
    PublicFile("part", "netgen-doc", NETGEN + "part1.stl", 9, unit=0.02, tolerance=0.02),
    PublicFile("head", "libcgal-demo", CGAL + "nefertiti.off", 1, unit=0.1, tolerance=0.02),
    PublicFile("blade", "libcgal-demo", CGAL + "blade.off", 2, unit=0.01, tolerance=0.02),
    PublicFile("bordered", "libcgal-demo", CGAL + "mesh_with_border.off", 1, unit=0.01, tolerance=0.02),
    PublicFile("cylinder", "libcgal-demo", CGAL + "cylinder.off", 1, unit=0.1, tolerance=0.02),
    PublicFile("mushroom", "libcgal-demo", CGAL + "mushroom.off", 3, unit=0.3, tolerance=0.02),
    PublicFile("patch", "libcgal-demo", CGAL + "patch-01.off", 5, unit=2e-3, tolerance=0.02),
    PublicFile("terrain", "gmsh-doc", GMSH + "terrain_stl_data.stl.gz", 1, unit=1e-4, tolerance=0.02),
    PublicFile("surface", "gmsh-doc", GMSH + "surface1.stl.gz", 1, unit=0.05, tolerance=0.02),
    PublicFile("holed", "assimp-testmodels", STL + "sphereWithHole.stl", 3, unit=0.1, tolerance=0.02),
    PublicFile("bull", "libcgal-demo", CGAL + "bull.off", 0, unit=0.3, refused="are too small for it"),
)


def public_files(table: Table, executables: Executables) -> None:
    """Fetches the packages, and takes each file as shells: area and mass, rest, a strike."""
    need_package_manager()
    executables = ensure_built(cad=True)
    with tempfile.TemporaryDirectory(prefix="validate-sunder-") as folder:
        packages: dict[str, Path | Missing] = {}
        for file in FILES:
            own = Path(folder) / file.name
            own.mkdir()
            try:
                if file.package not in packages:
                    packages[file.package] = _tried(file.package, Path(folder))
                package = packages[file.package]
                if isinstance(package, Missing):
                    raise package
                take(table, executables, file, copied(file, package, own), own)
            except Missing as missing:
                table.skip(f"public_{file.name}", str(missing))
            except (CommandError, KeyError, ValueError) as error:
                table.add(f"public_{file.name}", math.nan, 0.0, 0.0, 0.0, note=str(error))


def _tried(package: str, folder: Path) -> Path | Missing:
    try:
        return fetched(package, folder)
    except Missing as missing:
        return missing


def need_package_manager() -> None:
    """Raises Missing where this machine has none of Debian's."""
    lacks = [name for name in ("apt-get", "dpkg") if shutil.which(name) is None]
    if lacks:
        raise Missing(f"public: needs Debian's package manager, and this machine has no {' and no '.join(lacks)}")


def fetched(package: str, folder: Path) -> Path:
    """Downloads a package and unpacks it without installing it. Returns its folder. Raises Missing."""
    out = folder / package
    (folder / "deb").mkdir(exist_ok=True)
    for command in (["apt-get", "download", package], ["dpkg", "-x", "", str(out)]):
        if command[0] == "dpkg":
            found = next((folder / "deb").glob(f"{package}_*.deb"), None)
            if found is None:
                raise Missing(f"public: 'apt-get download {package}' ended well and left no {package}_*.deb")
            command[2] = str(found)
        try:
            ended = subprocess.run(command, cwd=folder / "deb", stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   errors="replace", check=False)
        except OSError as error:
            raise Missing(f"public: needs Debian's package manager: {error}") from None
        if ended.returncode != 0:
            raise Missing(f"public: needs Debian's archive, and {command_line(command)} failed; run 'apt-get update' and "
                          f"try again: {ended.stdout.strip()[-300:]}")
    return out


def copied(file: PublicFile, package: Path, folder: Path) -> Path:
    """Copies a file out of its package, uncompressed. Raises Missing where it is not there, as in another release."""
    name = Path(file.path).name.removesuffix(".gz")
    try:
        if file.package in ARCHIVE:
            with tarfile.open(package / ARCHIVE[file.package]) as archive:
                member = archive.extractfile(file.path)
                content = b"" if member is None else member.read()
        else:
            content = (package / file.path).read_bytes()
    except (OSError, KeyError) as error:
        raise Missing(f"public: the package {file.package} has no {file.path}: {error}") from None
    (folder / name).write_bytes(gzip.decompress(content) if file.path.endswith(".gz") else content)
    return folder / name


def take(table: Table, executables: Executables, file: PublicFile, path: Path, folder: Path) -> None:
    """Adds the rows of a file: what is taken, area, mass, strain at rest, energy of a strike."""
    start = time.monotonic()
    told = inspected(executables, path, file, folder / "frame")
    name = f"public_{file.name}"
    mesh = "charts" in told
    faces = told["charts"] if mesh else [face for face in told["faces"] if face["face"] in told["taken"]]
    told["thickness_m"] = file.thickness or told["thickness_m"]
    table.add(f"{name}_taken", taken_count(told, faces, file), file.taken, 0.0, time.monotonic() - start, note=taken_in_words(told, file))
    if not faces:
        return
    given, mass = sum(face["area_m2"] for face in faces), sum(face["area_of_shell_m2" if mesh else "area_of_shells_m2"] for face in faces)
    table.add(f"{name}_area", mass, given, file.tolerance, 0.0,
              note="of the shells' masses, against " + ("the triangles" if mesh else "OpenCASCADE"))
    if file.struck:
        told["taken"] = list(file.struck)
        faces = [told["faces"][number] for number in file.struck]
        mass = sum(face["area_of_shells_m2"] for face in faces)
    start = time.monotonic()
    scene = written(folder, path, file, told, faces)
    out = folder / "out"
    out.mkdir()
    run = launch_once(executables, scene, out, [])
    seconds = time.monotonic() - start
    series = read_columns(out / "series.csv")
    # a strain of e everywhere has at least E e^2/2 of energy in each volume
    volume = told["thickness_m"] * mass
    strain = max(math.sqrt(max(0.0, 2.0 * energy / (YOUNG * volume))) for energy in series["elastic [J]"][:RESTS])
    table.add(f"{name}_rest_strain", strain, 0.0, 1e-12, 0.0)
    energy, counts, cracks = run["energy"], run["counts"], series["cracks [m]"][-1]
    assert isinstance(energy, dict) and isinstance(counts, dict)
    broken = f"broken into {counts['fragments']} pieces" if counts["fragments"] > 1 else "in one piece"
    touched = _falls_short(out) > TOUCHED
    table.add(f"{name}_energy", energy["residual_relative"] if touched else math.nan, 0.0, MOST_MISSING, seconds,
              note=f"struck at {SPEED:g} m/s: {broken}, {cracks:.3g} m of cracks" if touched else "the ball missed it")


def taken_count(told: dict[str, Any], faces: list[dict[str, Any]], file: PublicFile) -> float:
    """The number of faces or charts that are taken; NaN where a file is refused for another reason than the expected one."""
    return math.nan if file.refused and file.refused not in str(told.get("refused")) else len(faces)


def _falls_short(out: Path) -> float:
    """Share of its free way that the ball is behind at the end of a run."""
    frames = [read_vtp(path) for path in sorted((out / "frames").glob("bodies_*.vtp"))]
    first, last = (np.mean(frame.points[frame.triangles[frame.cell_data["body"] == BALL].ravel(), 2]) for frame in (frames[0], frames[-1]))
    seconds = read_columns(out / "series.csv")["time [s]"][-1]
    return float(1.0 - (first - last) / (SPEED * seconds))


def inspected(executables: Executables, path: Path, file: PublicFile, frame: Path) -> dict[str, Any]:
    """What `sunder inspect` tells of a file, with a frame of its shells. Raises CommandError, and Missing where the build
    reads no such files."""
    frame.mkdir(exist_ok=True)
    command = [str(executables.shell), "inspect", str(path), "--frame", str(frame)]
    command += ["--unit", repr(file.unit)] if file.unit else []
    command += ["--element", repr(file.element)] if file.element else []
    ended = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace", check=False)
    if ended.returncode != 0:
        if NO_CAD in ended.stderr:
            raise Missing(f"public: {ended.stderr.strip()[-300:]}")
        raise CommandError(f"refused: {ended.stderr.strip()[-300:]}")
    told: dict[str, Any] = json.loads(ended.stdout)
    return told


def taken_in_words(told: dict[str, Any], file: PublicFile) -> str:
    """What was taken, approximated and refused of a file, with the reasons."""
    from_ = f"{Path(file.path).name.removesuffix('.gz')} of {file.package}"
    if "charts" in told:
        if told["refused"] is not None:
            return f"{from_}: refused: {told['refused']}"
        error = max(chart["error_m"] for chart in told["charts"])
        return f"{from_}: {told['triangles']} triangles, {len(told['charts'])} charts, off by {error:.2g} m at most"
    kinds: dict[str, int] = {}
    for face in told["faces"]:
        kinds[face["kind"]] = kinds.get(face["kind"], 0) + 1
    words = [f"{from_}: " + ", ".join(f"{count} {kind}" for kind, count in kinds.items())]
    near = [face["approximated_m"] for face in told["faces"] if face["refused"] is None and face["approximated_m"] > 0.0]
    if near:
        words.append(f"{len(near)} approximated to {max(near):.2g} m")
    words += [f"face {face['face']} refused: {face['refused']}" for face in told["faces"] if face["refused"] is not None]
    words += [f"face {face['face']} left out: {face['warning']}" for face in told["faces"] if face["refused"] is None and face["unfit"]]
    if told["seams_refused"] is not None:
        words.append(f"seams refused: {told['seams_refused']}")
    return "; ".join(words)


def written(folder: Path, path: Path, file: PublicFile, told: dict[str, Any], faces: list[dict[str, Any]]) -> Path:
    """Writes a scene of the part without gravity and a ball as heavy as the part, which falls on its highest place. In the
    first RESTS windows nothing touches the part."""
    frames = sorted((folder / "frame").rglob("shell_*.vtp"))  # none where the borders of faces have gaps
    edges = [edge["points_m"] for edge in told["edges"]["list"] if edge["faces"][0] in told["taken"]] if not frames else []
    points = np.concatenate([read_vtp(one).points for one in frames] or edges)
    top = points[np.argmax(points[:, 2])]
    diagonal, thickness = float(np.linalg.norm(told["size_m"])), told["thickness_m"]
    window = STEPS_OF_A_WINDOW * min(face["stable_step_s"] for face in faces)
    radius = 0.06 * diagonal
    mass = DENSITY * thickness * sum(face["area_m2"] for face in faces)
    at = top + np.array([0.0, 0.0, radius + 0.5 * thickness + (RESTS + NEAR) * window * SPEED])
    end = (RESTS + NEAR + math.ceil(CROSSINGS * diagonal / math.sqrt(YOUNG / DENSITY) / window)) * window
    mesh = "charts" in told
    more = f" unit_m: {file.unit!r}" if file.unit else ""
    if not mesh and len(told["taken"]) < len(told["faces"]):
        more += "".join(f" faces: {face}" for face in told["taken"])
    scene = folder / "scene.textproto"
    scene.write_text(SCENE.format(
        name=file.name, end=end, window=window, density=DENSITY, young=YOUNG, thickness=thickness, kind="mesh" if mesh else "cad",
        path=json.dumps(path.name), element=told["element_m"], more=more, radius=radius, at=[float(x) for x in at], speed=-SPEED,
        heavy=mass / (4.0 / 3.0 * math.pi * radius ** 3), seams=file.seams))
    return scene
