#!/usr/bin/python3
"""Writes the car of car_shape.py into scenes, prints what it is made of, and checks it.

    scenes/make_car.py [--spacing METRES] [--step FILE] [SCENE...]

In each SCENE the lines between `# begin car` and `# end car` are replaced. Prints the patches, the seams between them
and the sizes of elements at the spacing; exits with status 1, nothing written, where the car is not in order.
"""
from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from car_shape import SPANS, Patch, car
from scene_part import number, replace_part
from splines import basis, open_knots, refined
from step_file import write_step

SPACING_M = 0.05
# largest distance of control points on both sides of a seam; double precision keeps 1e-15 of a car's length
SAME_M = 1e-12
SIDES = ("u_min", "u_max", "v_min", "v_max")
# Points inside the body: from the engine to the boot.
SKELETON = (np.array([0.8, 0.0, 0.45]), np.array([3.5, 0.0, 0.6]))

# Material, thickness [m] and layers of each patch; 0 layers: the default, for elastic materials. Left and right are
# alike. Layers of yielding materials take most of the time, so there are few where little yielding is expected.
SHELLS = {
    "front_bumper": ("bumper_plastic", 0.008, 0),
    "bonnet": ("painted_steel", 0.008, 5),
    "windscreen": ("window_glass", 0.010, 0),
    "roof": ("painted_steel", 0.008, 5),
    "rear_window": ("window_glass", 0.010, 0),
    "tailgate": ("painted_steel", 0.008, 3),
    "wing": ("painted_steel", 0.008, 5),
    "side": ("painted_steel", 0.008, 3),
    "greenhouse": ("painted_steel", 0.016, 3),
}
NOTES = {
    "front_bumper": "A cover: it hangs on wings and bonnet, and on two crash boxes behind it.",
    "tailgate": "Boot lid and rear bumper in one piece; held where it ends, on the rear panel of the floor.",
    "wing": "Its lower edge is bolted to sill and wheel housing.",
    "side": "Doors and rear quarter in one piece, on the sill and the rear wheel housing.",
    "greenhouse": "Side windows and pillars in one panel, thick as the pillars' two sheets: it carries the roof.",
}
HELD_BELOW = ("tailgate", "wing", "side")
# Crash boxes: squares of the bumper around these shares of u and v.
CRASH_BOXES, CRASH_BOX_M = ((0.22, 0.5), (0.78, 0.5)), 0.14


@dataclass
class Seam:
    """Two sides of patches that coincide; one runs backwards if `reversed`."""
    first: Patch
    first_side: str
    second: Patch
    second_side: str
    reversed: bool
    gap_m: float        # between the control points of both sides
    smoothness_m: float  # distance of the seam's row from the mean of the rows beside it
    angle_deg: tuple[float, float]  # turn of the surface, least and most along the seam

    @property
    def smooth(self) -> bool:
        return self.smoothness_m <= SAME_M


def elements(patches: list[Patch], spacing_m: float) -> dict[str, int]:
    """Returns the elements along each chain, a multiple of its spans, with a mean size as close to the spacing as
    possible."""
    lengths: dict[str, list[float]] = {chain: [] for chain in SPANS}
    for patch in patches:
        u, v = mean_lengths(patch)
        lengths[patch.chain_u].append(u)
        lengths[patch.chain_v].append(v)
    return {chain: spans * max(1, round(float(np.mean(lengths[chain])) / (spans * spacing_m)))
            for chain, spans in SPANS.items()}


def sampled(patch: Patch, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Evaluates positions and derivatives along u and v (len(v), len(u), 3) in the parameters of the coarse knots."""
    (bu, du), (bv, dv) = (basis(open_knots(SPANS[chain]), at) for chain, at in ((patch.chain_u, u), (patch.chain_v, v)))
    return (np.einsum("ai,bj,ijk->abk", bv, bu, patch.net), np.einsum("ai,bj,ijk->abk", bv, du, patch.net),
            np.einsum("ai,bj,ijk->abk", dv, bu, patch.net))


def mean_lengths(patch: Patch) -> tuple[float, float]:
    """Returns mean lengths along u and v [m], by 2 Gauss points, as the solver scales parameters."""
    def gauss(spans: int) -> np.ndarray:
        return (np.arange(spans)[:, None] + 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)).ravel()
    nu, nv = SPANS[patch.chain_u], SPANS[patch.chain_v]
    _, xu, xv = sampled(patch, gauss(nu), gauss(nv))
    return (nu * float(np.linalg.norm(xu, axis=2).mean()), nv * float(np.linalg.norm(xv, axis=2).mean()))


def refined_patch(patch: Patch, counts: dict[str, int]) -> tuple[Patch, np.ndarray, np.ndarray]:
    """Refines a patch as the solver does with `elements_u` and `elements_v`; also returns the knots of u and v."""
    ku, across = refined(open_knots(SPANS[patch.chain_u]), np.swapaxes(patch.net, 0, 1), counts[patch.chain_u])
    kv, net = refined(open_knots(SPANS[patch.chain_v]), np.swapaxes(across, 0, 1), counts[patch.chain_v])
    return Patch(patch.name, patch.chain_u, patch.chain_v, net), ku, kv


def _end_span(knots: np.ndarray, side: str) -> float:
    marks = np.unique(knots)
    return marks[1] - marks[0] if side.endswith("min") else marks[-1] - marks[-2]


def _normals_along(patch: Patch, side: str) -> np.ndarray:
    nu, nv = SPANS[patch.chain_u], SPANS[patch.chain_v]
    u = {"u_min": np.zeros(1), "u_max": np.array([float(nu)])}.get(side, np.linspace(0.0, nu, 25))
    v = {"v_min": np.zeros(1), "v_max": np.array([float(nv)])}.get(side, np.linspace(0.0, nv, 25))
    _, xu, xv = sampled(patch, u, v)
    normal = np.cross(xu, xv).reshape(-1, 3)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def find_seams(patches: list[Patch], counts: dict[str, int]) -> list[Seam]:
    """Finds pairs of sides with both corners in common, on the car refined to `counts`."""
    fine = [refined_patch(patch, counts) for patch in patches]
    seams = []
    sides = [(k, side) for k in range(len(patches)) for side in SIDES]
    for a, (first, first_side) in enumerate(sides):
        for second, second_side in sides[a + 1:]:
            (one, *knots_one), (other, *knots_other) = fine[first], fine[second]
            p, q = one.edge(first_side), other.edge(second_side)
            ends = [float(max(np.abs(p[0] - e[0]).max(), np.abs(p[-1] - e[-1]).max())) for e in (q, q[::-1])]
            if min(ends) > SAME_M:
                continue
            back = slice(None, None, -1 if ends[1] <= SAME_M else 1)
            gap = float(np.abs(p - q[back]).max()) if p.shape == q.shape else np.inf
            smoothness = np.inf
            if p.shape == q.shape:
                b, c = (1.0 / _end_span(knots[0 if side[0] == "u" else 1], side)
                        for knots, side in ((knots_one, first_side), (knots_other, second_side)))
                mean = (b * one.beside(first_side) + c * other.beside(second_side)[back]) / (b + c)
                smoothness = float(np.abs(p - mean).max())
            normals = _normals_along(patches[first], first_side), _normals_along(patches[second], second_side)[back]
            angle = np.degrees(np.arccos(np.clip((normals[0] * normals[1]).sum(axis=1), -1.0, 1.0)))
            seams.append(Seam(patches[first], first_side, patches[second], second_side, back.step == -1, gap,
                              smoothness, (float(angle.min()), float(angle.max()))))
    return seams


def faults(patches: list[Patch], seams: list[Seam]) -> list[str]:
    """Lists faults of the car in words; empty where there is none."""
    out = []
    names = [patch.name for patch in patches]
    if len(patches) != 12 or len(set(names)) != 12:
        out.append(f"{len(set(names))} patches of {len(patches)} names; a car has 12")
    for patch in patches:
        nu, nv = SPANS[patch.chain_u], SPANS[patch.chain_v]
        if patch.net.shape != (nv + 2, nu + 2, 3):
            out.append(f"{patch.name}: a net of {patch.net.shape} for {nu} x {nv} spans")
            continue
        x, xu, xv = sampled(patch, np.linspace(0, nu, 4 * nu + 1), np.linspace(0, nv, 4 * nv + 1))
        normal = np.cross(xu, xv)
        a, b = SKELETON
        share = np.clip(((x - a) @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0)[..., None]
        outward = ((x - (a + share * (b - a))) * normal).sum(axis=2)
        if outward.min() <= 0.0:
            at = x.reshape(-1, 3)[outward.argmin()]
            out.append(f"{patch.name}: the normal points into the car at {at.round(3)}")
        sine = np.linalg.norm(normal, axis=2) / (np.linalg.norm(xu, axis=2) * np.linalg.norm(xv, axis=2))
        if not sine.min() > 0.34:  # 20 degrees between parameter lines; a collapsed edge gives 0 or NaN
            out.append(f"{patch.name}: parameter lines meet at a sine of {sine.min():.3f}")
    for seam in seams:
        where = f"{seam.first.name} {seam.first_side} - {seam.second.name} {seam.second_side}"
        if not seam.gap_m <= SAME_M:
            out.append(f"{where}: {seam.gap_m:.3g} m apart")
        if not seam.smooth and seam.angle_deg[1] < 5.0:
            out.append(f"{where}: a crease of {seam.angle_deg[1]:.2f} degrees; is it meant to be smooth?")
    # A side is on the border or in one seam. Where three seams or more meet, corners meet: V - E + F = 1, as for a
    # disc.
    taken = [(seam.first.name, seam.first_side) for seam in seams] + [(s.second.name, s.second_side) for s in seams]
    if len(taken) != len(set(taken)):
        out.append("a side is in two seams")
    corners = {tuple(np.round(patch.net[j, i], 9)) for patch in patches for i in (0, -1) for j in (0, -1)}
    euler = len(corners) - (4 * len(patches) - len(seams)) + len(patches)
    if euler != 1:
        out.append(f"corners - sides + patches is {euler}, of a surface with one border 1: patches do not meet fully")
    everything = {tuple(p) for patch in patches for p in patch.net.reshape(-1, 3).round(9) + 0.0}
    if any((x, -y + 0.0, z) not in everything for x, y, z in everything):
        out.append("left and right are not mirror images")
    return out


def sizes(patch: Patch, counts: dict[str, int]) -> tuple[float, float, float, float, float]:
    """Returns, for the elements of a patch: shortest and longest side [m], mean and worst aspect ratio, least angle
    [degrees]."""
    nu, nv = SPANS[patch.chain_u], SPANS[patch.chain_v]
    mu, mv = counts[patch.chain_u], counts[patch.chain_v]
    _, xu, xv = sampled(patch, (np.arange(mu) + 0.5) * nu / mu, (np.arange(mv) + 0.5) * nv / mv)
    u, v = np.linalg.norm(xu, axis=2) * nu / mu, np.linalg.norm(xv, axis=2) * nv / mv
    aspect = np.maximum(u / v, v / u)
    sine = np.linalg.norm(np.cross(xu, xv), axis=2) / (np.linalg.norm(xu, axis=2) * np.linalg.norm(xv, axis=2))
    return (float(min(u.min(), v.min())), float(max(u.max(), v.max())), float(aspect.mean()), float(aspect.max()),
            float(np.degrees(np.arcsin(sine.min()))))


def report(patches: list[Patch], seams: list[Seam], counts: dict[str, int]) -> str:
    out = [f"{'patch':18} elements   sides [mm]     aspect mean, worst   least angle   u, v [m]"]
    total = 0
    for patch in patches:
        mu, mv = counts[patch.chain_u], counts[patch.chain_v]
        low, high, mean, worst, angle = sizes(patch, counts)
        u, v = mean_lengths(patch)
        total += mu * mv
        out.append(f"{patch.name:18} {mu:3} x {mv:3}  {1e3 * low:5.1f} to {1e3 * high:5.1f}      "
                   f"{mean:4.2f}, {worst:4.2f}          {angle:5.1f}         {u:.3f}, {v:.3f}")
    out += [f"{total} elements, {4 * total} Gauss points (2 x 2)", "",
            f"{'seam':60} kind   turns [degrees]  gap [m]  off the mean of its neighbours [m]"]
    for s in seams:
        name = f"{s.first.name} {s.first_side} - {s.second.name} {s.second_side}{' (reversed)' if s.reversed else ''}"
        out.append(f"{name:60} {'smooth' if s.smooth else 'crease'} {s.angle_deg[0]:5.1f} to {s.angle_deg[1]:5.1f}"
                   f"  {s.gap_m:.0e}  {s.smoothness_m:.0e}")
    return "\n".join(out)


def kind_of(name: str) -> str:
    """Returns a patch's name without its side."""
    return name.removeprefix("left_").removeprefix("right_")


def _supports(patch: Patch) -> list[str]:
    if kind_of(patch.name) in HELD_BELOW:
        return ["  supports { edges: V_MIN kind: SIMPLY_SUPPORTED }"]
    if patch.name != "front_bumper":
        return []
    u, v = mean_lengths(patch)
    half = 0.5 * CRASH_BOX_M
    return ["  supports {", "    kind: SIMPLY_SUPPORTED", *(
        f"    regions {{ low {{ u: {a * u - half:.3f} v: {b * v - half:.3f} }} "
        f"high {{ u: {a * u + half:.3f} v: {b * v + half:.3f} }} }}" for a, b in CRASH_BOXES), "  }"]


def shell_text(patch: Patch, counts: dict[str, int]) -> list[str]:
    """Writes the patch as a `shells` message in text, with one line for each row of control points."""
    kind = kind_of(patch.name)
    material, thickness, layers = SHELLS[kind]
    out = [f"# {NOTES[kind]}"] if kind in NOTES else []
    out += ["shells {", f'  name: "{patch.name}"', f'  material: "{material}"', f"  thickness_m: {thickness}"]
    out += [f"  layers: {layers}"] if layers else []
    out += ['  interlayer { material: "window_film" thickness_m: 0.002 }'] if kind == "windscreen" else []
    out += ["  nurbs {"]
    for name, chain in (("u", patch.chain_u), ("v", patch.chain_v)):
        out.append(f"    knots_{name}: [{', '.join(number(k) for k in open_knots(SPANS[chain]))}]")
    out.append(f"    elements_u: {counts[patch.chain_u]} elements_v: {counts[patch.chain_v]}")
    for row in patch.net:
        out.append("    " + " ".join(
            f"control_points {{ x: {number(x)} y: {number(y)} z: {number(z)} }}" for x, y, z in row))
    return [*out, "  }", *_supports(patch), "}"]


def seams_text(seams: list[Seam]) -> list[str]:
    """Writes a rule for each seam, so that a scene without a patch, or with a moved one, is refused."""
    pairs = dict.fromkeys((s.first.name, s.second.name) for s in seams)
    return ["seams {", *(f'  rules {{ first: "{first}" second: "{second}" }}' for first, second in pairs), "}"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", type=Path, metavar="SCENE")
    parser.add_argument("--spacing", type=float, default=SPACING_M, metavar="METRES",
                        help="mean size of elements; %(default)s by default, 0.1 for the coarse net itself, "
                             "0.019 for 170,000 Gauss points")
    parser.add_argument("--step", type=Path, metavar="FILE", help="the patches as faces of a STEP file, in this order")
    arguments = parser.parse_args()
    if not 0.002 <= arguments.spacing <= 1.0:
        parser.error(f"--spacing is {arguments.spacing} m; 0.002 to 1")
    patches = car()
    counts = elements(patches, arguments.spacing)
    seams = find_seams(patches, counts)
    print(report(patches, seams, counts))
    wrong = faults(patches, seams)
    for line in wrong:
        print(f"wrong: {line}", file=sys.stderr)
    if wrong:
        return 1
    lines = [line for patch in patches for line in shell_text(patch, counts)] + seams_text(seams)
    for scene in arguments.scenes:
        replace_part(scene, "car", f"made by make_car.py --spacing {arguments.spacing:g}", lines)
    if arguments.step:
        write_step(arguments.step, patches)
    return 0


if __name__ == "__main__":
    sys.exit(main())
