"""Bending of a sheet that damage weakens: what a section takes until it is cut."""
from __future__ import annotations

import math
import tempfile
from pathlib import Path

from sunder_tools.launch.build import Executables
from sunder_tools.report.run_json import read_run

from .trials import Table, kept_run

LENGTH, WIDTH, THICKNESS = 0.1, 0.025, 0.004  # [m]
YOUNG, DENSITY, STRENGTH = 3e9, 1e3, 1.5e5
FRACTURE_ENERGY = 20.0 * THICKNESS * STRENGTH ** 2 / YOUNG  # [J/m^2]: softening is longer than the strip is thick
GRIDS = (16, 32)      # elements along the strip, even: two of them are in the middle
LAYERS = (2, 5, 9)
BAND = 1.43           # [spacings]: width over which damage takes G_f (case `bar`)
TURN = 0.03           # [rad] between both halves at the end
TRANSITS = 300        # passages of a wave over the strip while it is bent
DAMPING = 0.04        # [of the lowest rate of such a passage]
GRIP = 5.0            # factor of the strength beside the two, so that one band of damage forms; it is two elements wide
WITHIN = 0.15


def scene_of(elements: int, layers: int) -> str:
    """Returns the text of a strip on two lines at its ends that two lines between them bend."""
    h, speed, middle = LENGTH / elements, math.sqrt(YOUNG / DENSITY), elements // 2
    end = TRANSITS * LENGTH / speed
    inner = (round(0.3 * elements - 0.5) + 0.5) * h

    def region(low: float, high: float) -> str:
        return f"{{ low {{ u: {low:.9g} v: 0 }} high {{ u: {high:.9g} v: {WIDTH} }}"

    lines = [f"regions {region(u - 0.1 * h, u + 0.1 * h)} }}" for u in (inner, LENGTH - inner)]
    return "\n".join([
        'name: "bent"', f"end_time_s: {end:.9g}", f"window_s: {end / 2000.0:.9g}", "gravity {}",
        f'materials {{ name: "soft" density: {DENSITY} youngs_modulus: {YOUNG} poisson_ratio: 0 strength: {STRENGTH} '
        f"fracture_energy: {FRACTURE_ENERGY:.9g} mass_damping_per_s: {DAMPING * speed / LENGTH:.9g} }}",
        "shells {", f'  name: "strip" material: "soft" thickness_m: {THICKNESS} layers: {layers}',
        f"  plate {{ size_x_m: {LENGTH} size_y_m: {WIDTH} elements_x: {elements} elements_y: {elements // 4} }}",
        f"  strength_regions {region(0.0, (middle - 1) * h)} factor: {GRIP} }}",
        f"  strength_regions {region((middle + 1) * h, LENGTH)} factor: {GRIP} }}",
        f"  supports {{ kind: SIMPLY_SUPPORTED axes: X axes: Z regions {region(0.0, 0.01 * h)} }} }}",
        f"  supports {{ kind: SIMPLY_SUPPORTED axes: Z regions {region(LENGTH - 0.01 * h, LENGTH)} }} }}",
        f"  supports {{ kind: SIMPLY_SUPPORTED axes: Z {' '.join(lines)} motion {{ time_s: 0 }} "
        f"motion {{ time_s: {end:.9g} displacement {{ z: {-0.5 * TURN * inner:.9g} }} }} }}", "}",
        f"fracture {{ mode: DAMAGE damage_width_m: {BAND * h:.9g} healing: false quiet_time_s: {end:.9g} }}",
        f"output {{ frame_interval_s: {0.5 * end:.9g} }}", ""])


def bent_section(table: Table, executables: Executables) -> None:
    """Bends strips in mode DAMAGE until they part, of 2, 5 and 9 layers on two grids."""
    for elements in GRIDS:
        for layers in LAYERS:
            with tempfile.TemporaryDirectory(prefix="validate-sunder-") as place:
                scene = Path(place) / "bent.textproto"
                scene.write_text(scene_of(elements, layers))
                with kept_run(executables, str(scene), []) as (folder, seconds):
                    run = read_run(folder)
            name = f"bent_section_{layers}_{elements}"
            taken = run["energy"]["dissipated_fracture"] / (FRACTURE_ENERGY * WIDTH * THICKNESS)
            table.add(f"{name}_taken", taken, 1.0, WITHIN, seconds)
            table.add(f"{name}_pieces", run["counts"]["fragments"], 2.0, 0.0, 0.0)
    table.lines.append("bent_section: a section is cut as soon as one layer is fully damaged. What the layers below it still bear "
                       "then is released with the cut, and counts as taken by it")
