"""Run folders with known answers: a body that a constant force slows while gravity pulls."""
from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import sunder
from tests.command.synthetic import write_vtp

FORCE, FALL = 12.0, 5.0  # [N] upwards, [m/s^2] downwards


def write_run(folder: Path, start: float = -40.0, rows: int = 21, step: float = 1e-4, force: float = FORCE,
              supports: bool = True, until: int | None = None) -> sunder.Results:
    """A steel pellet of 2 mm above a plate at z = 0, `force` acting for the first `until` rows (default: all)."""
    scene = sunder.Scene.load(sunder.SCENES / "acrylic.textproto")
    scene["gravity.z"] = -FALL
    scene["bodies[pellet].twist.linear.z"] = start
    if supports:
        scene.find("shells[plate]").supports.add(edges=["ALL"], kind="CLAMPED")
    scene.save(folder)
    mass = sunder_mass()
    z, v, lines = 0.00251, start, ["time [s],pellet_x [m],pellet_y [m],pellet_z [m],pellet_vx [m/s],pellet_vy [m/s],"
                                   "pellet_vz [m/s],reaction_x [N],reaction_y [N],reaction_z [N]"]
    for k in range(rows):
        lines.append(f"{k * step:.17g},0,0,{z:.17g},0,0,{v:.17g}" + (",,," if k > rows // 2 else ",0,0,0"))
        a = (force if until is None or k < until else 0.0) / mass - FALL
        z, v = z + v * step + 0.5 * a * step ** 2, v + a * step
    last = float(lines[-1].split(",")[6])
    (folder / "probes.csv").write_text("\n".join(lines) + "\n")
    (folder / "series.csv").write_text("time [s],cracks [m]\n0,0\n0.002,0.25\n")
    energy = dict.fromkeys(("kinetic", "elastic", "dissipated_fracture", "dissipated_plastic", "contact", "damping", "frozen",
                            "handoff_lost", "engine", "face_friction", "face_crushing", "healing", "transfer", "crack_injected", "external_work"), 0.0)
    energy.update(kinetic=0.5 * mass * last ** 2 + 0.5, elastic=1.0, dissipated_fracture=2.0, contact=4.0, external_work=0.25)
    (folder / "run.json").write_text(json.dumps({"schema": 1, "status": "done", "energy": energy, "time": {
        "simulated_s": 0.002, "frozen_at_s": None}}))
    return sunder.Results(folder)


def sunder_mass() -> float:
    """[kg] of the pellet."""
    return 7800 * 4.0 / 3.0 * np.pi * 0.002 ** 3


def write_pieces(folder: Path, frozen: bool = False) -> sunder.Results:
    """A strip of ten unit squares: at first one piece; at the end squares 0 to 5, 6 and 7, the others gone as shards."""
    (folder / "frames").mkdir(parents=True)
    points = np.array([[x, y, 0.0] for x in range(11) for y in range(2)])
    squares = np.arange(10)[:, None] * 2
    triangles = np.stack([squares + [0, 2, 3], squares + [0, 3, 1]], axis=1)
    for k, (count, number) in enumerate(((10, [0] * 10), (8, [0] * 6 + [3] + [7]))):
        write_vtp(folder / f"frames/shell_{k}.vtp", points + [0, 0, k], triangles[:count].reshape(-1, 3),
                  point_data={"displacement": np.zeros_like(points) + [0, 0, k]},
                  cell_data={"fragment": np.repeat(number, 2)})
    (folder / "frames.pvd").write_text(
        '<VTKFile><Collection><DataSet timestep="0" part="0" file="frames/shell_0.vtp"/>'
        '<DataSet timestep="0.002" part="0" file="frames/shell_1.vtp"/></Collection></VTKFile>')
    (folder / "shards.csv").write_text("id,birth [s],area [m^2]\n5,0.001,1.5\n6,0.001,0.5\n")
    (folder / "run.json").write_text(json.dumps({"schema": 1, "status": "done", "time": {
        "simulated_s": 0.002, "frozen_at_s": 0.001 if frozen else None}}))
    return sunder.Results(folder)


def write_dents(folder: Path) -> sunder.Results:
    """Two strips of ten unit squares, the second 5 m higher: one has moved by (0.1, 0, x - 4), the other nowhere."""
    (folder / "frames").mkdir(parents=True)
    scene = sunder.Scene.load(sunder.SCENES / "acrylic.textproto")
    scene.message.shells.add().CopyFrom(scene.message.shells[0])
    scene.message.shells[0].name, scene.message.shells[1].name = "hit", "whole"
    scene.save(folder)
    strip = np.array([[x, y, 0.0] for x in range(11) for y in range(2)])
    squares = np.arange(10)[:, None] * 2
    triangles = np.stack([squares + [0, 2, 3], squares + [0, 3, 1]], axis=1).reshape(-1, 3)
    moved = np.stack([np.full(22, 0.1), np.zeros(22), strip[:, 0] - 4.0], axis=1)
    write_vtp(folder / "frames/shell_0.vtp", np.concatenate([strip + moved, strip + [0, 0, 5]]),
              np.concatenate([triangles, triangles + 22]),
              point_data={"displacement": np.concatenate([moved, np.zeros_like(strip)])},
              cell_data={"shell": np.repeat([0, 1], 20)})
    (folder / "frames.pvd").write_text(
        '<VTKFile><Collection><DataSet timestep="0.5" part="0" file="frames/shell_0.vtp"/></Collection></VTKFile>')
    (folder / "run.json").write_text(json.dumps({"schema": 1, "status": "done"}))
    return sunder.Results(folder)
