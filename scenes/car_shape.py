"""The body of a car as 12 quadratic B-spline patches, from hand-made curves.

x runs from the nose to the tail, y to the car's right, z up from the ground [m]; the car is symmetric about y = 0.
Control points are the curves taken at Greville abscissae: that follows them closely, without wiggles.

The lower body is one band, smooth from the front of one wing round the tail to the other, and cut where wings, sides
and tail meet; the bumper closes it with a crease at either end. Bonnet, screens, roof and the greenhouses on both sides
hang between its upper edge and a few curves more. Where three patches meet all three seams have to be creases: two
edges that ran on smoothly would give the third patch a corner of 180 degrees.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Spans of the coarse net along the five chains of opposite edges. Patches along one chain share its knots.
SPANS = {
    "across": 14,  # bumper, bonnet, both screens, roof, tail: from side to side
    "height": 6,   # bumper, wings, sides, tail: upwards
    "bonnet": 10,  # bonnet and wings: rearwards
    "screen": 6,   # windscreen, rear window, greenhouses: upwards
    "roof": 20,    # roof, greenhouses, sides: rearwards
}
GRID_M = 1e-5  # control points are rounded to this, which keeps the text short and means of two points exact

# Cuts of the band: t counts its spans from the left wing's front edge.
WING, TAIL = SPANS["bonnet"], SPANS["bonnet"] + SPANS["roof"]
MIDDLE = TAIL + SPANS["across"] // 2

# Upper edge of the band's left half: t, then x, distance from the middle, z [m].
SHOULDER = [
    (0, 0.335, 0.695, 0.665), (2.5, 0.60, 0.725, 0.755), (5, 0.875, 0.745, 0.825), (WING, 1.42, 0.765, 0.915),
    (15, 2.03, 0.785, 0.940), (20, 2.65, 0.790, 0.960), (25, 3.27, 0.765, 0.985), (28, 3.62, 0.730, 1.000),
    (TAIL, 3.80, 0.680, 1.010), (31.7, 3.90, 0.540, 1.018), (34.4, 3.965, 0.270, 1.025), (MIDDLE, 3.98, 0.0, 1.027)]
# Lower edge, in the same columns, without the wheel arches.
SILL = [
    (0, 0.350, 0.760, 0.225), (0.5, 0.430, 0.785, 0.225), (8.7, 1.190, 0.800, 0.225), (WING, 1.390, 0.800, 0.225),
    (19.5, 2.950, 0.800, 0.225), (29, 3.710, 0.790, 0.240), (TAIL, 3.900, 0.760, 0.250),
    (31.75, 4.080, 0.660, 0.260), (33.5, 4.140, 0.430, 0.270), (MIDDLE, 4.165, 0.0, 0.280)]
ARCHES = ((0.5, 8.7), (19.5, 29.0))  # t from and to
ARCH_HEIGHT_M = 0.38                 # above the sill
ARCH_ROUNDNESS = 0.45  # share of an ellipse along the arch: 1 is an ellipse with upright ends, 0 a sine
ARCH_FLARE_M = 0.015
# Swelling of the band between its edges: t, swelling [m], and a power of the height that moves the swelling up, to form
# the edge of the boot lid at the tail.
SWELL = [(0, 0.045, 1.0), (1, 0.045, 1.0), (4.5, 0.025, 1.0), (8, 0.05, 1.0), (WING, 0.065, 1.0), (18, 0.075, 1.0),
         (24.5, 0.055, 1.2), (TAIL, 0.075, 1.6), (33.5, 0.120, 2.4), (MIDDLE, 0.130, 2.5)]

# Half curves across the car, from the left to the middle: x, distance from the middle, z [m]. The first point is a
# corner.
BUMPER_TOP = [(0.19, 0.46, 0.700), (0.11, 0.22, 0.722), (0.09, 0.0, 0.728)]
BUMPER_FOOT = [(0.17, 0.52, 0.205), (0.09, 0.26, 0.198), (0.07, 0.0, 0.195)]
COWL = [(1.325, 0.52, 0.945), (1.25, 0.26, 0.965), (1.225, 0.0, 0.970)]
ROOF_FRONT = [(1.985, 0.560, 1.315), (1.935, 0.40, 1.360), (1.905, 0.20, 1.385), (1.895, 0.0, 1.392)]
ROOF_REAR = [(3.380, 0.540, 1.325), (3.440, 0.38, 1.367), (3.475, 0.19, 1.386), (3.485, 0.0, 1.392)]
# Curves between corners, on the left side.
WINDSCREEN_PILLAR = [(1.705, 0.690, 1.130)]
REAR_PILLAR = [(3.605, 0.635, 1.180)]
ROOF_EDGE = [(2.33, 0.590, 1.352), (2.70, 0.595, 1.361), (3.06, 0.580, 1.353)]

# Swelling of panels off the mean of their edges [m].
SWELL_OF = {"front_bumper": 0.085, "bonnet": 0.035, "windscreen": 0.030, "roof": 0.030, "rear_window": 0.020,
            "greenhouse": 0.012}


@dataclass
class Patch:
    """A quadratic patch with all weights 1 and knots 0, 0, 0, 1, 2, ... n, n, n."""
    name: str
    chain_u: str
    chain_v: str
    net: np.ndarray  # (spans of v + 2, spans of u + 2, 3) [m]

    def edge(self, side: str) -> np.ndarray:
        """Control points (n, 3) of 'u_min', 'u_max', 'v_min' or 'v_max', in the order of the other parameter."""
        return {"u_min": self.net[:, 0], "u_max": self.net[:, -1],
                "v_min": self.net[0], "v_max": self.net[-1]}[side]

    def beside(self, side: str) -> np.ndarray:
        """Control points one row in from an edge."""
        return {"u_min": self.net[:, 1], "u_max": self.net[:, -2],
                "v_min": self.net[1], "v_max": self.net[-2]}[side]


def greville(spans: int) -> np.ndarray:
    """(spans + 2,) abscissae of the control points over knots 0, 1, ... spans."""
    return np.concatenate([[0.0], np.arange(spans) + 0.5, [float(spans)]])


def rounded(points: np.ndarray) -> np.ndarray:
    return np.round(np.asarray(points, float) / GRID_M) * GRID_M


def cubic_through(at: np.ndarray, values: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Evaluates the natural cubic spline through values (n, 3) at `at` (n,), at the places `wanted` (m,): (m, 3)."""
    step, rise = np.diff(at), np.diff(values, axis=0)
    n = len(at)
    matrix, rates = np.eye(n), np.zeros((n, values.shape[1]))
    for i in range(1, n - 1):
        matrix[i, i - 1:i + 2] = step[i - 1], 2.0 * (step[i - 1] + step[i]), step[i]
        rates[i] = 6.0 * (rise[i] / step[i] - rise[i - 1] / step[i - 1])
    second = np.linalg.solve(matrix, rates)
    k = np.clip(np.searchsorted(at, wanted, side="right") - 1, 0, n - 2)
    h, a, b = step[k][:, None], (at[k + 1] - wanted)[:, None], (wanted - at[k])[:, None]
    return ((second[k] * a ** 3 + second[k + 1] * b ** 3) / (6.0 * h) + (values[k] / h - second[k] * h / 6.0) * a
            + (values[k + 1] / h - second[k + 1] * h / 6.0) * b)


def curve(points: list, spans: int) -> np.ndarray:
    """Returns control points (spans + 2, 3) of a curve through `points`; its parameter is close to its length."""
    values = np.asarray(points, float)
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(values, axis=0), axis=1))])
    dense = np.linspace(0.0, at[-1], 400)
    drawn = cubic_through(at, values, dense)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(drawn, axis=0), axis=1))])
    wanted = np.interp(greville(spans) / spans * length[-1], length, dense)
    out = rounded(cubic_through(at, values, wanted))
    out[0], out[-1] = values[0], values[-1]  # other patches share the corners, to the last bit
    return out


def mirrored(points: np.ndarray) -> np.ndarray:
    return np.asarray(points, float) * np.array([1.0, -1.0, 1.0])


def left(points: list) -> np.ndarray:
    """Returns points on the left from hand-made points with distances from the middle."""
    return mirrored(np.asarray(points, float))


def across(half: list, corner: np.ndarray | None = None) -> np.ndarray:
    """Returns control points of a symmetric curve from left to right; `corner` is put before `half`."""
    start = left(half) if corner is None else np.vstack([corner, left(half)])
    out = curve(np.vstack([start, mirrored(start[-2::-1])]), SPANS["across"])
    out[len(out) // 2:] = mirrored(out[:len(out) // 2][::-1])
    return out


def _foot(t: np.ndarray) -> np.ndarray:
    """Returns the lower edge of the band's left half at t: (n, 3), distances from the middle positive."""
    table = np.asarray(SILL, float)
    out = np.stack([np.interp(t, table[:, 0], table[:, k]) for k in (1, 2, 3)], axis=1)
    for start, end in ARCHES:
        share = np.clip((t - start) / (end - start), 0.0, 1.0)
        x0, x1 = (np.interp(v, table[:, 0], table[:, 1]) for v in (start, end))
        inside = (t > start) & (t < end)
        across = share + ARCH_ROUNDNESS * (0.5 - 0.5 * np.cos(np.pi * share) - share)
        out[inside, 0] = (x0 + (x1 - x0) * across)[inside]
        out[:, 2] += ARCH_HEIGHT_M * np.sin(np.pi * share)
        out[:, 1] += ARCH_FLARE_M * np.sin(np.pi * share)
    return out


def _band() -> np.ndarray:
    """Returns the control net (height + 2, spans + 2, 3) of the lower body, from the left wing round the tail to the
    right wing."""
    spans = 2 * MIDDLE
    t = greville(spans)[:spans // 2 + 1]
    table = np.asarray(SHOULDER, float)
    whole = np.vstack([table, np.column_stack([spans - table[-2::-1, 0], mirrored(table[-2::-1, 1:])])])
    top, foot = cubic_through(whole[:, 0], whole[:, 1:], t), _foot(t)
    middle = 0.5 * (top + foot)
    along = np.gradient(middle, t, axis=0)[:, :2]
    out = np.column_stack([-along[:, 1], along[:, 0], np.zeros(len(t))])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    table = np.asarray(SWELL, float)
    swell, power = (np.interp(t, table[:, 0], table[:, k]) for k in (1, 2))
    h = np.linspace(0.0, 1.0, 200)[:, None]
    dense = foot + h[..., None] * (top - foot) + (4.0 * h ** power * (1.0 - h ** power) * swell)[..., None] * out
    length = np.linalg.norm(np.diff(dense, axis=0), axis=2).cumsum(axis=0)
    length = np.vstack([np.zeros(len(t)), length]) / length[-1]
    wanted = greville(SPANS["height"]) / SPANS["height"]  # in equal steps of the length upwards, for even elements
    net = np.stack([[np.interp(wanted, length[:, i], dense[:, i, k]) for k in range(3)] for i in range(len(t))])
    half = rounded(mirrored(np.moveaxis(net, 2, 0)))
    return np.concatenate([half, mirrored(half[:, ::-1])], axis=1)


def _pieces(band: np.ndarray, cuts: list[int]) -> list[np.ndarray]:
    """Cuts the band at knots by inserting each once more: the new control point lies half way between its
    neighbours."""
    seams = {s: np.round(0.5 * (band[:, s] + band[:, s + 1]), 9) for s in cuts}
    ends = [0, *cuts, band.shape[1] - 2]
    out = []
    for a, b in zip(ends, ends[1:]):
        first = band[:, :1] if a == 0 else seams[a][:, None]
        last = band[:, -1:] if b == ends[-1] else seams[b][:, None]
        out.append(np.concatenate([first, band[:, a + 1:b + 1], last], axis=1))
    return out


def _panel(v_min: np.ndarray, v_max: np.ndarray, u_min: np.ndarray, u_max: np.ndarray, swell_m: float) -> np.ndarray:
    """Returns a control net between four edges (Coons), swollen along its outward normal; the edges do not change."""
    gu, gv = greville(len(v_min) - 2), greville(len(u_min) - 2)
    u, v = (gu / gu[-1])[None, :, None], (gv / gv[-1])[:, None, None]
    net = ((1 - v) * v_min[None] + v * v_max[None] + (1 - u) * u_min[:, None] + u * u_max[:, None]
           - (1 - v) * ((1 - u) * v_min[0] + u * v_min[-1]) - v * ((1 - u) * v_max[0] + u * v_max[-1]))
    normal = np.cross(np.gradient(net, axis=1), np.gradient(net, axis=0))
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    net = rounded(net + swell_m * 16.0 * u * (1 - u) * v * (1 - v) * normal)
    net[0], net[-1], net[:, 0], net[:, -1] = v_min, v_max, u_min, u_max
    return net


def _mirrored_patch(patch: Patch, name: str) -> Patch:
    """Mirrors a patch, with u reversed so that u cross v still points outwards."""
    return Patch(name, patch.chain_u, patch.chain_v, mirrored(patch.net[:, ::-1]))


def _symmetric(net: np.ndarray, axis: int) -> np.ndarray:
    """Makes a panel's net exactly symmetric; before, it is symmetric up to rounding."""
    net = net.copy()
    n = net.shape[axis] // 2
    lower, upper = [slice(None)] * 2, [slice(None)] * 2
    lower[axis], upper[axis] = slice(0, n), slice(n, None)
    net[tuple(upper)] = mirrored(np.flip(net[tuple(lower)], axis))
    return net


def car() -> list[Patch]:
    """Returns the 12 patches. On the lower body u runs round the car, counter-clockwise from above, and v upwards.
    On panels across the car u runs rearwards and v to the right."""
    wing, side, tail, _, _ = _pieces(_band(), [WING, TAIL, 2 * MIDDLE - TAIL, 2 * MIDDLE - WING])
    tail = _symmetric(tail, 1)
    nose_corner, cowl_corner, tail_corner = wing[-1, 0], wing[-1, -1], side[-1, -1]
    top, foot = across(BUMPER_TOP, nose_corner), across(BUMPER_FOOT, wing[0, 0])
    cowl = across(COWL, cowl_corner)
    roof_front, roof_rear = across(ROOF_FRONT), across(ROOF_REAR)
    pillar = curve([cowl_corner, *left(WINDSCREEN_PILLAR), roof_front[0]], SPANS["screen"])
    rear_pillar = curve([roof_rear[0], *left(REAR_PILLAR), tail_corner], SPANS["screen"])
    roof_edge = curve([roof_front[0], *left(ROOF_EDGE), roof_rear[0]], SPANS["roof"])

    def lying(name: str, chain: str, front: np.ndarray, rear: np.ndarray, edge: np.ndarray) -> Patch:
        net = _panel(edge, mirrored(edge), front, rear, SWELL_OF[name])
        return Patch(name, chain, "across", _symmetric(net, 0))

    bumper = _panel(foot[::-1], top[::-1], mirrored(wing[:, 0]), wing[:, 0], SWELL_OF["front_bumper"])
    left_wing = Patch("left_wing", "bonnet", "height", wing)
    left_side = Patch("left_side", "roof", "height", side)
    left_greenhouse = Patch("left_greenhouse", "roof", "screen", _panel(
        side[-1], roof_edge, pillar, rear_pillar[::-1], SWELL_OF["greenhouse"]))
    return [
        Patch("front_bumper", "across", "height", _symmetric(bumper, 1)),
        lying("bonnet", "bonnet", top, cowl, wing[-1]),
        lying("windscreen", "screen", cowl, roof_front, pillar),
        lying("roof", "roof", roof_front, roof_rear, roof_edge),
        lying("rear_window", "screen", roof_rear, tail[-1], rear_pillar),
        Patch("tailgate", "across", "height", tail),
        left_wing, _mirrored_patch(left_wing, "right_wing"),
        left_side, _mirrored_patch(left_side, "right_side"),
        left_greenhouse, _mirrored_patch(left_greenhouse, "right_greenhouse"),
    ]
