#!/usr/bin/python3
"""Writes the garment of fig15.textproto: a top of ten panels around the body, and two shoulder straps.

    scenes/paper/make_garment.py [--spacing METRES] [SCENE...]

In each SCENE the lines between `# begin garment` and `# end garment` are replaced. The body is an ellipse at each height,
x to the wearer's left, y to the back. Panels of front and back go from the left side to the right one; their upper edges are arm
holes, strap ends and necklines. Each panel meets its neighbours along whole sides, and each strap one panel in front and
one behind.
"""
from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))
from scene_part import number, replace_part  # noqa: E402
from splines import basis, open_knots  # noqa: E402

SPACING_M = 0.003
# Height [m] above the hem, half width and half depth of the body there [m]: hip, waist, chest, shoulder.
BODY = [(0.00, 0.205, 0.150), (0.18, 0.165, 0.115), (0.38, 0.185, 0.130), (0.52, 0.165, 0.095)]
UNDERARM_M, STRAP_M, NECK_FRONT_M, NECK_BACK_M = 0.36, 0.50, 0.42, 0.46  # heights of upper edges
STITCHED = 0.9      # share of the height of the panels below straps from which they are reinforced
SHOULDER_M = 0.56   # height of the straps' middle
# Angles [degrees] from the left side on, where panels of front and back end: side, strap, neck, strap, side.
ENDS_DEG = (0.0, 52.0, 70.0, 110.0, 128.0, 180.0)
NAMES = ("side_left", "strap_left", "neck", "strap_right", "side_right")
SPANS_V, SPANS_STRAP = 12, 8
SPANS_U = {"side": 6, "strap": 3, "neck": 4}


@dataclass
class Panel:
    """A patch: its control points (v, u, 3) [m] over knots 0, 0, 0, 1, ... of each direction."""
    name: str
    net: np.ndarray
    held: str = ""  # what supports it

    def spans(self) -> tuple[int, int]:
        return self.net.shape[1] - 2, self.net.shape[0] - 2


def on_body(angle: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Returns points (..., 3) of the body [m]; angles in radians from the left side to the back."""
    known = np.array(BODY)
    wide, deep = (_smooth(height, known[:, 0], known[:, k]) for k in (1, 2))
    return np.stack([wide * np.cos(angle), deep * np.sin(angle), height], axis=-1)


def _smooth(at: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The polynomial through the points."""
    return np.polyval(np.polyfit(x, y, len(x) - 1), at)


def _top(name: str, share: np.ndarray, back: bool) -> np.ndarray:
    """Height [m] of a panel's upper edge at shares 0..1 of its width, from the side on."""
    if name.startswith("strap"):
        return np.full_like(share, STRAP_M)
    if name == "neck":
        low = NECK_BACK_M if back else NECK_FRONT_M
        return STRAP_M - (STRAP_M - low) * 4.0 * share * (1.0 - share)
    rise = share if name == "side_left" else 1.0 - share
    return UNDERARM_M + (STRAP_M - UNDERARM_M) * rise ** 2


def fitted(points: np.ndarray) -> np.ndarray:
    """Control points (v, u, 3) of the surface through points (v, u, 3) at Greville parameters."""
    def solve(values: np.ndarray) -> np.ndarray:
        matrix, _ = basis(open_knots(len(values) - 2), greville(len(values) - 2))
        return np.linalg.solve(matrix, values.reshape(len(values), -1)).reshape(values.shape)
    return np.swapaxes(solve(np.swapaxes(solve(points), 0, 1)), 0, 1)


def greville(spans: int) -> np.ndarray:
    knots = open_knots(spans)
    return 0.5 * (knots[1:-2] + knots[2:-1])


def panels() -> list[Panel]:
    """Returns the twelve patches. v goes up; on straps from the front over the shoulder to the back."""
    out: list[Panel] = []
    for back in (False, True):
        for k, name in enumerate(NAMES):
            spans = SPANS_U[name.partition("_")[0]]
            share, up = np.meshgrid(greville(spans) / spans, greville(SPANS_V) / SPANS_V)
            angle = np.radians(ENDS_DEG[k] + share * (ENDS_DEG[k + 1] - ENDS_DEG[k]))
            points = on_body(angle, up * _top(name, share, back))
            if not back:
                points = points[:, ::-1] * np.array([1.0, -1.0, 1.0])  # turned round, so that normals point outwards as well
            out.append(Panel(f"{'back' if back else 'front'}_{name}", fitted(points), "hem"))
    for side in ("left", "right"):
        front, behind = (next(p for p in out if p.name == f"{where}_strap_{side}").net[-1] for where in ("front", "back"))
        behind = behind[::-1]
        turn = np.pi * greville(SPANS_STRAP) / SPANS_STRAP
        middle, half = 0.5 * (front + behind), 0.5 * (front - behind)
        arc = np.array([middle + np.cos(t) * half + np.sin(t) * np.array([0.0, 0.0, SHOULDER_M - STRAP_M]) for t in turn])
        matrix, _ = basis(open_knots(SPANS_STRAP), greville(SPANS_STRAP))
        net = np.linalg.solve(matrix, arc.reshape(len(arc), -1)).reshape(arc.shape)  # rows are control points along u already
        net[0], net[-1] = front, behind
        out.append(Panel(f"shoulder_{side}", net, "shoulder"))
    return out


def lengths(panel: Panel) -> tuple[float, float]:
    """Returns mean lengths along u and v [m]."""
    net = panel.net
    return (float(np.linalg.norm(np.diff(net, axis=1), axis=2).sum(axis=1).mean()),
            float(np.linalg.norm(np.diff(net, axis=0), axis=2).sum(axis=0).mean()))


def scene_text(spacing_m: float) -> list[str]:
    """Returns the shells; the scene has the material `cloth`."""
    out = []
    for panel in panels():
        (nu, nv), (wide, high) = panel.spans(), lengths(panel)
        counts = [max(1, round(length / (spans * spacing_m))) * spans for length, spans in ((wide, nu), (high, nv))]
        out += ["shells {", f'  name: "{panel.name}"', '  material: "cloth"', "  thickness_m: 0.003", "  nurbs {",
                *(f"    knots_{axis}: [{', '.join(number(k) for k in open_knots(spans))}]" for axis, spans in
                  (("u", nu), ("v", nv))), f"    elements_u: {counts[0]} elements_v: {counts[1]}"]
        out += ["    " + " ".join(f"control_points {{ x: {number(x)} y: {number(y)} z: {number(z)} }}" for x, y, z in row)
                for row in panel.net.round(6)]
        strap = panel.name.partition("_")[2].startswith("strap")
        out += ["  }", *(_hem() if panel.held == "hem" else _shoulder(wide, high)),
                *(_reinforced(wide, STITCHED * high, high) if strap else _reinforced(wide, 0.0, high) if panel.held != "hem"
                  else []), "}"]
    return out


def _hem() -> list[str]:
    return ["  supports {", "    edges: V_MIN", "    kind: SIMPLY_SUPPORTED", "    motion { time_s: 0 }",
            "    motion { time_s: 1.2 displacement { z: -0.6 } }", "  }"]


def _shoulder(wide: float, high: float) -> list[str]:
    return ["  supports {", "    kind: SIMPLY_SUPPORTED",
            f"    regions {{ low {{ u: 0 v: {0.35 * high:.4f} }} high {{ u: {1.2 * wide:.4f} v: {0.65 * high:.4f} }} }}", "  }"]


def _reinforced(wide: float, low: float, high: float) -> list[str]:
    """Straps, and the cloth on which they are stitched, do not break: the tears are to be those of the top."""
    return [f"  strength_regions {{ low {{ u: 0 v: {low:.4f} }} high {{ u: {1.2 * wide:.4f} v: {1.2 * high:.4f} }} factor: 1000 }}"]


def made_by(spacing_m: float) -> str:
    return f"made by make_garment.py --spacing {spacing_m:g}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--spacing", type=float, default=SPACING_M, metavar="METRES", help="size of elements")
    parser.add_argument("scenes", nargs="*", type=Path, metavar="SCENE")
    arguments = parser.parse_args()
    for panel in panels():
        wide, high = lengths(panel)
        print(f"{panel.name:18} {wide:.3f} m by {high:.3f} m")
    for scene in arguments.scenes:
        replace_part(scene, "garment", made_by(arguments.spacing), scene_text(arguments.spacing))
    return 0


if __name__ == "__main__":
    sys.exit(main())
