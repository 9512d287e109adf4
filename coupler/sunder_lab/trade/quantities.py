"""What is compared between runs of a scene: deflection, impulse, energy taken, cracks, pieces."""
from __future__ import annotations

import random
from typing import Any

import numpy as np

from sunder_tools.errors import CommandError

from ..impact import STANDARD_GRAVITY, mass_of
from ..pieces import fragments
from ..scene import Results, Scene
from .knobs import breaks, moves

PREFIX = "trade_"                     # of the probes that are added
SAMPLES = 200                         # of a deflection over time
PLACES = ((0.5, 0.5), (0.3, 0.62))    # of probes, of the lengths of a patch: the middle, and one off all symmetry
SHAKE = 1e-3                          # of the strength, where it has no scatter of its own
# name: unit, of the number that stands in tables
UNITS = {"deflection": "m", "impulse": "N s", "energy_taken": "J", "crack_length": "m", "pieces": "-",
         "mean_piece": "m^2"}


def prepared(scene: Scene) -> Scene:
    """A copy with the probes that comparing takes, and frames at both ends only: pictures are no part of the cost."""
    out = scene.copy()
    message = out.message
    message.output.frame_interval_s = message.end_time_s
    message.output.ClearField("shell_frame_interval_s")
    probed = {p.body for p in message.output.probes if p.body}
    for body in message.bodies:
        if not body.is_static and body.WhichOneof("shape") != "half_space" and body.name not in probed:
            message.output.probes.add(name=PREFIX + body.name, body=body.name)
    if not any(p.shell for p in message.output.probes):
        for shell in message.shells:
            size = _lengths(shell)
            if size is None:
                continue
            for k, (u, v) in enumerate(PLACES):
                probe = message.output.probes.add(name=f"{PREFIX}{shell.name}_{k}", shell=shell.name)
                probe.at.u, probe.at.v = u * size[0], v * size[1]
    return out


def _lengths(shell: Any) -> tuple[float, float] | None:
    """Of the parameter domain [m], where the scene says it."""
    if shell.WhichOneof("patch") == "plate":
        return shell.plate.size_x_m, shell.plate.size_y_m
    if shell.WhichOneof("patch") == "cylinder":
        return shell.cylinder.radius_m * np.radians(shell.cylinder.angle_deg), shell.cylinder.length_m
    return None


def shaken(scene: Scene, seed: int) -> Scene:
    """A copy for another chance: another seed of the strength's scatter, or, without scatter, a strength that differs by up
    to a thousandth. Seed 0 is the scene as it is."""
    out = scene.copy()
    if seed == 0 or not breaks(scene):
        return out
    used = {s.material for s in out.message.shells}
    materials = [m for m in out.message.materials if m.name in used and m.HasField("strength")]
    if any(m.HasField("weibull_modulus") for m in materials):
        out.message.fracture.seed = scene.message.fracture.seed + seed
    else:
        for m in materials:
            m.strength *= 1.0 + SHAKE * random.Random(f"{m.name} {seed}").uniform(-1.0, 1.0)
    return out


def observed(results: Results) -> dict[str, np.ndarray]:
    """Each quantity as a vector; what a run does not have is not in it.

    `deflection` (3 k m,): displacements [m] of k probes at m times, where nothing has cracked. `impulse` (3 n,) [N s]: what
    all but gravity has given each of n bodies; `energy_taken` (1,) [J] that they lost together; both for a kilogram of
    each where a mass is not known. `crack_length` (1,) [m], `pieces` (1,), `mean_piece` (1,) [m^2] where something has.
    """
    out: dict[str, np.ndarray] = {}
    message = results.scene.message
    cracks = float(results.series["cracks"][-1]) if len(message.shells) else 0.0
    shells = [p.name for p in message.output.probes if p.shell]
    bodies = [p for p in message.output.probes if p.body]
    probes = results.probes if shells or bodies else None
    if probes is not None and shells and cracks == 0.0:
        at = np.linspace(0.0, float(probes["time"][-1]), SAMPLES + 1)[1:]
        out["deflection"] = np.array([np.interp(at, probes["time"], probes[name + axis])
                                      for name in shells for axis in ("_x", "_y", "_z")]).ravel()
    rigid = {body.name for body in message.bodies}
    bodies = [probe for probe in bodies if probe.body in rigid]  # the mass of a soft body is its particles'
    if probes is not None and bodies and moves(results.scene):
        out.update(_of_bodies(message, bodies, probes))
    if cracks > 0.0:
        found = fragments()(results)
        out["crack_length"] = np.array([cracks])
        out["pieces"] = np.array([float(found["pieces"])])
        out["mean_piece"] = np.array([found["mean_piece_m2"]])
    return out


def _of_bodies(message: Any, probed: list[Any], probes: Any) -> dict[str, np.ndarray]:
    pull = message.gravity if message.HasField("gravity") else None
    gravity = np.array([pull.x, pull.y, pull.z] if pull is not None else STANDARD_GRAVITY)
    named = {b.name: b for b in message.bodies}
    try:
        masses = [mass_of(message, named[p.body]) for p in probed]
    except CommandError:
        masses = [1.0] * len(probed)
    time, impulse, energy = probes["time"], [], 0.0
    for mass, probe in zip(masses, probed):
        v, x = probes.vector(probe.name, "_vx _vy _vz"), probes.vector(probe.name)
        impulse.append(mass * (v[-1] - v[0] - gravity * (time[-1] - time[0])))
        energy += mass * (0.5 * float(v[0] @ v[0] - v[-1] @ v[-1]) + float(gravity @ (x[-1] - x[0])))
    return {"impulse": np.concatenate(impulse), "energy_taken": np.array([energy])}


def in_short(name: str, vector: np.ndarray) -> float:
    """The number for a table: the largest displacement of a probe, the size of an impulse, else the value."""
    if name == "deflection":
        return float(np.linalg.norm(vector.reshape(-1, 3, SAMPLES), axis=1).max())
    return float(np.linalg.norm(vector)) if name == "impulse" else float(vector[0])


def measured(results: Results) -> dict[str, Any]:
    """Columns of results.csv."""
    return {f"{name}_{UNITS[name].replace(' ', '_').replace('^', '')}" if UNITS[name] != "-" else name: in_short(name, vector)
            for name, vector in observed(results).items()}
