"""Which models go together: each pair is put into one scene and run for a window, or refused.

    /usr/bin/python3 -B -m tests.docs.pairs      # writes the table into scenes/README.md

The table stands between the lines BEGIN and END. Its test makes it anew and compares.
"""
from __future__ import annotations

import itertools
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from google.protobuf import text_format

from tests.docs.snippets import TOP, merged

sys.path.insert(0, str(TOP / "coupler"))
sys.pycache_prefix = str(TOP / "build" / "pycache")
from sunder_lab.schema import scene_class  # noqa: E402
from sunder_tools.launch.build import ensure_built  # noqa: E402

PAGE = TOP / "scenes" / "README.md"
BEGIN, END = "<!-- pairs: made by tests/docs/pairs.py -->", "<!-- end of pairs -->"
RUNS, SELF = "·", " "
WINDOW_S = 5e-4

BASE = f"""
name: "pair" end_time_s: 0.01 window_s: {WINDOW_S} gravity {{}}
materials {{ name: "cloth" density: 1000 youngs_modulus: 1e7 poisson_ratio: 0.3 }}
shells {{ name: "sheet" material: "cloth" thickness_m: 0.004
  plate {{ size_x_m: 0.2 size_y_m: 0.2 elements_x: 10 elements_y: 10 }} supports {{ edges: U_MIN kind: CLAMPED }} }}
"""
STRENGTH = 'materials { name: "cloth" strength: 1e6 fracture_energy: 4e3 }'
BALL = 'bodies { name: "ball" material: "cloth" sphere { radius_m: 0.03 } pose { position { z: 0.033 } } twist { linear { z: -1 } } }'
CUBE = "cube.obj"

# Name in the table, the field that asks for it, and what it adds to the scene. Where both of a pair add a body, two are there.
MODELS = (
    ("tips", "strength", STRENGTH),
    ("damage", "fracture.mode DAMAGE", STRENGTH + " fracture { mode: DAMAGE }"),
    ("cuts", "cuts", 'shells { name: "sheet" cuts { points { u: 0.1 v: 0.05 } points { u: 0.1 v: 0.15 } until_s: 0.005 } }'),
    ("yield", "yield_stress", 'materials { name: "cloth" yield_stress: 2e5 }'),
    ("plies", "interlayer", 'materials { name: "film" density: 1000 youngs_modulus: 1e6 poisson_ratio: 0.4 } '
                            'shells { name: "sheet" interlayer { material: "film" thickness_m: 0.001 } }'),
    ("taper", "thickness_law", 'shells { name: "sheet" thickness_law { along: X points { at_m: -0.1 factor: 1 } '
                               'points { at_m: 0.1 factor: 0.5 } } }'),
    ("tempered", "surface_compression", 'shells { name: "sheet" layers: 4 surface_compression: 1e5 }'),
    ("linear", "bending LINEAR", 'shells { name: "sheet" bending: LINEAR }'),
    ("law", "stress_model", 'shells { name: "sheet" stress_model: PAPER_PROJECTION }'),
    ("fibres", "fibres", 'shells { name: "sheet" fibres { compression_modulus: 1e5 shear_modulus: 1e5 } } '
                         'contacts { first: "sheet" second: "sheet" }'),
    ("balance", "equilibrium", 'shells { name: "sheet" equilibrium {} loads { pressure: -10 } }'),
    ("seams", "seams", 'shells { name: "flap" material: "cloth" thickness_m: 0.004 plate { size_x_m: 0.2 size_y_m: 0.2 '
                       'elements_x: 10 elements_y: 10 pose { position { x: 0.2 } } } } seams {}'),
    ("tied", "seams along trims", 'shells { name: "flap" material: "cloth" thickness_m: 0.004 plate { size_x_m: 0.25 size_y_m: 0.2 '
                                  'elements_x: 12 elements_y: 10 pose { position { x: 0.175 } } } trims { points { u: 0.05 v: 0 } '
                                  'points { u: 0.25 v: 0 } points { u: 0.25 v: 0.2 } points { u: 0.05 v: 0.2 } points { u: 0.05 v: 0 } } } seams {}'),
    ("trims", "trims", 'shells { name: "sheet" trims { hole: true circle { center { u: 0.12 v: 0.1 } radius_m: 0.04 } } }'),
    ("grid", "transfer", "transfer { kind: APIC }"),
    ("hertz", "contacts.hertz", BALL + ' contacts { first: "sheet" second: "ball" hertz { stiffness: 1e5 } }'),
    ("joints", "joints", BALL + ' joints { name: "pin" kind: BALL first: "ball" position { z: 0.2 } }'),
    ("soft", "soft_bodies", 'materials { name: "rubber" density: 1000 youngs_modulus: 1e6 poisson_ratio: 0.4 } soft_bodies { '
                            'name: "lump" material: "rubber" sphere { radius_m: 0.03 } pose { position { x: -0.06 z: -0.04 } } spacing_m: 0.01 }'),
    ("motion", "bodies.motion", 'bodies { name: "punch" sphere { radius_m: 0.03 } motion { position { x: 0.06 z: 0.033 } } '
                                'motion { time_s: 0.01 position { x: 0.06 z: 0.02 } } }'),
    ("shapes", "bodies.deformation", f'bodies {{ name: "lung" mesh {{ path: "{CUBE}" surface: EXACT }} pose {{ position {{ y: 0.06 z: -0.033 }} }} '
                                     'deformation { inflate {} inflate { time_s: 0.01 distance_m: 0.004 } } }'),
    ("scaled", "mass_scaling", "mass_scaling { factor: 1.01 most_added: 0.1 }"),
    ("iterated", "coupling ITERATED", BALL + " coupling { scheme: ITERATED }"),
    ("sheared", "fibres.shear_strength", STRENGTH + ' fracture { mode: DAMAGE } shells { name: "sheet" fibres { compression_modulus: 1e5 '
                                         'shear_modulus: 1e5 shear_strength: 2e4 } } contacts { first: "sheet" second: "sheet" }'),
)


def cube() -> str:
    """A cube of 6 cm as an OBJ file."""
    corners = [f"v {0.03 * x} {0.03 * y} {0.03 * z}" for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    return "\n".join([*corners, *("f " + face for face in ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"))]) + "\n"


def scene_of(*texts: str) -> Any:
    """The base with these parts; a part that both have is there once."""
    scene = text_format.Parse(BASE, scene_class()())
    for text in texts:
        merged(scene, text_format.Parse(text, scene_class()()))
    for k in reversed(range(len(scene.contacts))):
        if scene.contacts[k] in scene.contacts[:k]:
            del scene.contacts[k]
    if scene.HasField("seams") and any(shell.HasField("equilibrium") for shell in scene.shells):
        for shell in scene.shells:  # it is found for all that seams join
            shell.equilibrium.SetInParent()
    return scene


def outcome(program: Path, folder: Path, *texts: str) -> str:
    """'' where the scene runs for a window; otherwise field and reason of its refusal. Raises RuntimeError where it fails."""
    path = folder / "pair.textproto"
    path.write_text(text_format.MessageToString(scene_of(*texts)))
    done = subprocess.run([str(program), "--scene", str(path), "--out", str(folder / "run"), "--engine", "bullet",
                           "--until", str(WINDOW_S), "--quiet"],
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode == 0:
        return ""
    said = done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ""
    refusal = re.search(r"pair\.textproto:\d+:\d+: (.*)", said)
    if done.returncode != 2 or refusal is None:
        raise RuntimeError(f"status {done.returncode}: {done.stderr[-500:]}\n{path.read_text()}")
    return re.sub(r"\[\d+\]", "", refusal[1])


def table(program: Path) -> str:
    """The table, a row for each model, and below it the reasons."""
    reasons: list[str] = []
    cell: dict[tuple[int, int], str] = {}
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / CUBE).write_text(cube())
        for i in range(len(MODELS)):
            if alone := outcome(program, Path(name), MODELS[i][2]):
                raise RuntimeError(f"'{MODELS[i][0]}' alone is refused: {alone}")
        for i, k in itertools.combinations(range(len(MODELS)), 2):
            why = outcome(program, Path(name), MODELS[i][2], MODELS[k][2])
            if why and why not in reasons:
                reasons.append(why)
            cell[i, k] = cell[k, i] = str(reasons.index(why) + 1) if why else RUNS
    head = ["", *(name for name, _, _ in MODELS)]
    rows = [[f"`{field}`", *(cell.get((i, k), SELF) for k in range(len(MODELS)))] for i, (_, field, _) in enumerate(MODELS)]
    lines = ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rows)]
    return "\n".join([*lines, "", *(f"{k}. {reason}" for k, reason in enumerate(reasons, 1))])


def parts_of(text: str) -> tuple[str, str, str]:
    """The page before the table, the table, and the page after it. Raises ValueError where the marks are not there."""
    before, begin, rest = text.partition(BEGIN + "\n")
    made, end, after = rest.partition("\n" + END)
    if not begin or not end:
        raise ValueError(f"{PAGE}: needs the lines {BEGIN} and {END}")
    return before + begin, made, end + after


def main() -> int:
    before, _, after = parts_of(PAGE.read_text())
    PAGE.write_text(before + table(ensure_built().single) + after)
    return 0


if __name__ == "__main__":
    sys.exit(main())
