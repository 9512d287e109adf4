"""Rows of `validate extremes` about a shell by itself: thickness, stiffness, size, knots, poles, steps."""
from __future__ import annotations

import math
from typing import Any, Callable, Sequence

from .rows import Outcome, Quantity, Refused, Row, Runner, Stable, Stopped
from .scenes import CLAMPED, GLASS, SIMPLE, material, message, scene, sheet, shell

SMOOTH = 1e-5  # what the books miss without cracks and contact: round-off
SUDDEN = 1e-3  # of a swing: what bends by strains of 1e-12 is known to so many digits
BENDING = 0.03  # static deflection over thickness: linear to a thousandth
ELEMENTS = 8
# Lumped mass lowers a frequency by (k h)^2 / 6, 5 % of the first at eight elements, and the time of the way with it.
# The slope of the way is half the peak times the frequency, so that makes up to 4 % of the peak.
NAVIER = 0.06
ROUND_OFF = 1e-15  # [m]
ALIKE = 2e-3   # sheets of all thicknesses move alike but for terms of strain, here below this, and (thickness / length)^2


def bending(thickness: float, young: float, poisson: float) -> float:
    """Rigidity of a plate [N m]."""
    return young * thickness ** 3 / 12.0 / (1.0 - poisson ** 2)


def swing(thickness: float = 0.01, young: float = 70e9, poisson: float = 0.22, size: float = 1.0, degree: int | None = None,
          windows: int = 50, **fields: Any) -> str:
    """A simply supported plate under a pressure that is there at once, for 0.6 of its first period."""
    rigidity = bending(thickness, young, poisson)
    changed: dict[str, Any] = {"youngs_modulus": young, "poisson_ratio": poisson}
    pressure = BENDING * thickness * rigidity / (0.00406235 * size ** 4)  # static deflection: Navier
    period = size * size / math.pi * math.sqrt(GLASS["density"] * thickness / rigidity)
    glass = material(**GLASS | changed)
    return scene(0.6 * period, 0.6 * period / windows, glass,
                 sheet(size, thickness, ELEMENTS, SIMPLE, message("loads", {"pressure": pressure})),
                 probes=[f"{0.5 * size} {0.5 * size}"], **fields)


def navier(time: float) -> float:
    """Deflection of the middle over the static one, `time` in first periods; sudden pressure, modes to the 19th."""
    def mode(m: int, n: int) -> float:
        return math.sin(0.5 * m * math.pi) * math.sin(0.5 * n * math.pi) / (m * n * (m * m + n * n) ** 2)
    modes = [(m, n) for m in range(1, 20, 2) for n in range(1, 20, 2)]
    static = sum(mode(m, n) for m, n in modes)
    return sum(mode(m, n) * (1.0 - math.cos(math.pi * (m * m + n * n) * time)) for m, n in modes) / static


def swung(thickness: float, size: float = 1.0) -> Callable[[Outcome, Runner], Sequence[Quantity]]:
    """Against Navier, and much closer against the plate of 10 mm on 1 m: time in periods and deflection in thicknesses
    are the same for all of them (von Karman)."""
    def check(found: Outcome, runner: Runner) -> list[Quantity]:
        way = [z / thickness for z in found.probes["p0_z"]]
        other = [z / 0.01 for z in runner.compare_with(swing()).probes["p0_z"]]
        exact = [BENDING * navier(0.6 * k / (len(way) - 1)) for k in range(len(way))]
        largest = max(exact)
        return [Quantity("Navier", max(abs(a - b) for a, b in zip(way, exact)) / largest, 0.0, NAVIER),
                Quantity("alike", max(abs(a - b) for a, b in zip(way, other)) / largest if len(way) == len(other)
                         else math.nan, 0.0, ALIKE + thickness ** 2 / size ** 2)]
    return check


def flown(velocity: Sequence[float], end: float, at: str = "p0") -> Callable[[Outcome, Runner], Sequence[Quantity]]:
    """What flies freely is where it must be."""
    def check(found: Outcome, runner: Runner) -> list[Quantity]:
        del runner
        furthest = end * max(abs(v) for v in velocity)  # positions are added up to round-off of the largest
        return [Quantity(f"way {axis}", found.probes[f"{at}_{axis}"][-1], v * end, (1e-9 if v else 0.0) + ROUND_OFF * max(1.0, furthest) / abs(v * end or 1.0))
                for axis, v in zip("xyz", velocity)]
    return check


def free(*parts: str, end: float = 1e-2, window: float = 1e-4, **fields: Any) -> str:
    """Shells that fly; gravity and supports only where `parts` and `fields` say so."""
    return scene(end, window, material(**GLASS), *parts, **fields)


VELOCITY = "velocity {{ x: {0!r} y: {1!r} z: {2!r} }}"


def graded_knots(elements: int, ratio: float) -> list[float]:
    """Open quadratic knots whose spans grow evenly, the last `ratio` times the first; over [0, 1]."""
    spans = [ratio ** (k / (elements - 1)) for k in range(elements)]
    at, knots = 0.0, [0.0, 0.0, 0.0]
    for span in spans[:-1]:
        at += span / sum(spans)
        knots.append(at)
    return knots + [1.0, 1.0, 1.0]


def graded_sheet(ratio: float, thickness: float, *parts: str) -> str:
    """A flat square of 1 m with graded knots in both directions, its parameters its coordinates."""
    knots = graded_knots(24, ratio)
    greville = [0.5 * (knots[k + 1] + knots[k + 2]) for k in range(len(knots) - 3)]
    lines = ["nurbs {", *(f"knots_{d}: {k!r}" for d in "uv" for k in knots),
             *(message("control_points", {"x": x - 0.5, "y": y - 0.5}) for y in greville for x in greville), "}"]
    return shell("\n".join(lines), thickness, *parts)


def curved(patch: str, fields: dict[str, object]) -> str:
    """A shell of revolution with a pole that drums: pressure for a moment, then free."""
    drum = "loads {\npressure: 1e3\nfactor { time_s: 0 value: 0 }\nfactor { time_s: 1e-4 value: 1 }\n" \
           "factor { time_s: 2e-4 value: 0 }\n}"
    return free(shell(message(patch, fields), 0.01, drum), end=2e-3, window=1e-4)


def squeezed(poisson: float) -> str:
    """Held on one edge, the opposite one driven towards it by nine tenths of the length."""
    changed: dict[str, Any] = {"poisson_ratio": poisson}
    driven = "supports {\nedges: U_MAX\nkind: CLAMPED\nmotion { time_s: 0 }\n" \
             "motion { time_s: 0.01 displacement { x: -0.9 } }\n}"
    return scene(0.01, 1e-4, material(**GLASS | changed),
                 sheet(1.0, 0.01, 8, "supports {\nedges: U_MIN\nkind: CLAMPED\n}", driven))


RUBBER: dict[str, Any] = {"density": 1000.0, "youngs_modulus": 1e6, "poisson_ratio": 0.45}
SQUEEZED = {0.8: 0.02, 0.4: 0.01}  # what the books miss while a sheet snaps and folds, by time_step_safety


def squeezed_to(share: float, window: float = 2e-4, **fields: Any) -> str:
    """A rubber sheet whose opposite edges approach one another, smoothly, until it is `share` of its length. It folds
    once round-off has grown."""
    def motion(sign: float) -> str:
        ways = [(t, 3.0 * t * t - 2.0 * t ** 3) for t in (k / 20.0 for k in range(21))]
        return "\n".join(f"motion {{ time_s: {0.1 * t!r} displacement {{ x: {sign * 0.05 * (1.0 - share) * way!r} }} }}" for t, way in ways)
    edges = [f"supports {{\nedges: {edge}\nkind: CLAMPED\n{motion(sign)}\n}}" for edge, sign in (("U_MIN", 1.0), ("U_MAX", -1.0))]
    return scene(0.1, window, material(**RUBBER), sheet(0.1, 0.004, 20, *edges), **fields)


def graded_at_rest(ratio: float) -> str:
    """It starts in equilibrium under a pressure, and stays there."""
    pressure = BENDING * 0.01 * bending(0.01, 70e9, 0.22) / 0.00406235
    return scene(1e-4, 1e-5, material(**GLASS),
                 graded_sheet(ratio, 0.01, SIMPLE, message("loads", {"pressure": pressure}), "equilibrium {}"),
                 probes=["0.5 0.5"])


def graded_check(found: Outcome, runner: Runner) -> list[Quantity]:
    """The largest of 24 spans is 0.26 m, about as two elements a side: some per cent."""
    del runner
    way = [z / (0.01 * BENDING) for z in found.probes["p0_z"]]
    return [Quantity("deflection", way[0], 1.0, 0.05), Quantity("stays", max(way) - min(way), 0.0, 1e-4)]


def refused_material(field: str, value: str) -> Row:
    text = free(sheet()).replace(f"{field}: {GLASS[field]}", f"{field}: {value}")
    return Row(f"refused_{field}_{value.replace('-', 'minus_')}", text, Refused(f"materials[0].{field}", f"{field}:"))


def refused_sheet(name: str, field: str, line: str, text: str) -> Row:
    return Row(f"refused_{name}", text, Refused(field, line))


THICK = "shell 'sheet' is 0.1 times as thick as it is wide"
THICKNESSES = {"10um": 1e-5, "100um": 1e-4, "1mm": 1e-3, "10mm": 1e-2, "100mm": 0.1}
ANY = (3.0, -2.0, 5.0)  # [m/s]

SHELLS: list[Row] = [
    *(Row(f"thickness_{name}", swing(h, windows=50), Stable(SUDDEN, THICK if h == 0.1 else ""), swung(h), limit_s=150.0)
      for name, h in THICKNESSES.items()),
    *(Row(f"youngs_modulus_{young:.0e}".replace("+", ""), swing(young=young), Stable(SUDDEN), swung(0.01))
      for young in (1e2, 1e6, 1e12)),
    *(Row(f"poisson_{str(nu).replace('-', 'minus_')}", swing(poisson=nu), Stable(SUDDEN), swung(0.01))
      for nu in (-0.5, 0.0, 0.4999)),
    Row("span_1um", swing(1e-8, size=1e-6), Stable(SUDDEN), swung(1e-8, 1e-6)),
    Row("span_1km", swing(10.0, size=1e3), Stable(SUDDEN), swung(10.0, 1e3)),
    *(refused_material("youngs_modulus", value) for value in ("0", "-1.0", "nan", "inf", "1e16")),
    *(refused_material("poisson_ratio", value) for value in ("0.5", "-1.0", "nan")),
    *(refused_material("density", value) for value in ("0", "1e13")),
    *(refused_sheet(f"thickness_{value}".replace("-", "minus_"), "shells[0].thickness_m", "thickness_m:",
                    free(sheet()).replace("thickness_m: 0.01", f"thickness_m: {value}")) for value in ("0", "-0.01", "inf")),
    # a shell by itself, flying
    Row("elements_1", free(sheet(1.0, 0.01, 1, VELOCITY.format(*ANY)), window=1e-3, probes=["0.5 0.5"]), Stable(SMOOTH),
        flown(ANY, 1e-2)),
    Row("elements_1_cubic", free(sheet(1.0, 0.01, 1, VELOCITY.format(*ANY)).replace("elements_y: 1", "elements_y: 1\ndegree: 3"),
                                 window=1e-3, probes=["0.5 0.5"]), Stable(SMOOTH), flown(ANY, 1e-2)),
    Row("elements_1_clamped", free(sheet(1.0, 0.01, 1, CLAMPED)), Refused("shells[0].supports", "supports {")),
    Row("at_rest", free(sheet(), probes=["0.5 0.5"]), Stable(1e-3), flown((0.0, 0.0, 0.0), 1e-2)),
    *(Row(f"speed_{name}", free(sheet(1.0, 0.01, 8, VELOCITY.format(v, 0.0, 0.0)), probes=["0.5 0.5"]), Stable(SMOOTH),
          flown((v, 0.0, 0.0), 1e-2)) for name, v in (("1um_per_s", 1e-6), ("1km_per_s", 1e3))),
    Row("knots_1_to_1000", graded_at_rest(1000.0), Stable(SMOOTH), graded_check),
    Row("pole_of_a_sphere", curved("sphere", {"radius_m": 1.0, "angle_deg": 90.0, "from_deg": 0.0, "to_deg": 90.0,
                                              "elements_u": 8, "elements_v": 8}), Stable(1e-3)),
    Row("tip_of_a_cone", curved("cone", {"bottom_m": 1.0, "top_m": 0.0, "height_m": 1.0, "angle_deg": 90.0,
                                         "elements_u": 8, "elements_v": 8}), Stable(1e-3)),
    # what has no answer ends with the place, as soon as it has none
    *(Row(f"squeezed_to_{share:g}", squeezed_to(share), Stable(SQUEEZED[0.8])) for share in (0.5, 0.2)),
    # Folds snap within a window, and the step is measured between two. The message names two remedies, and each helps.
    Row("squeezed_in_long_windows", squeezed_to(0.2, 1e-2), Stopped("unstable", "lower time_step_safety, which is 0.8, or shorten window_s")),
    Row("squeezed_in_short_steps", squeezed_to(0.2, 1e-2, time_step_safety=0.2), Stable(SQUEEZED[0.4])),
    Row("squeezed_to_0.1", squeezed_to(0.1, time_step_safety=0.4), Stable(SQUEEZED[0.4])),
    Row("squeezed_poisson_minus_0.5", squeezed(-0.5), Stopped("compression", "plane stress bears no more below")),
    # steps
    *(Row(f"safety_{s}", swing(time_step_safety=s), Stable(SUDDEN), swung(0.01)) for s in (0.1, 0.95, 1.0)),
    *(refused_sheet(f"safety_{s}".replace("-", "minus_"), "time_step_safety", "time_step_safety:",
                    swing(time_step_safety=s)) for s in ("1.0001", "0", "nan")),
    refused_sheet("safety_1e-9", "window_s", "window_s:", swing(time_step_safety=1e-9)),
    refused_sheet("time_step_past_the_limit", "time_step_s", "time_step_s:", swing(time_step_s=2e-5)),
    refused_sheet("window_below_the_step", "window_s", "window_s:", free(sheet(), window=1e-6)),
    refused_sheet("windows_1e12", "window_s", "window_s:", free(sheet(), window=1e-14)),
    *(refused_sheet(f"layers_{n}", "shells[0].layers", "layers:", free(sheet(layers=n))) for n in (1, 17)),
    *(Row(f"substeps_{name}", free(sheet(1.0, 0.01, 2, VELOCITY.format(0.0, 0.0, 1e-3),
                                         "supports { corners: U_MIN_V_MIN kind: SIMPLY_SUPPORTED }"),
                                   end=end, window=end / 20), Stable(1e-3), limit_s=limit, full=full)
      for name, end, limit, full in (("1e6", 60.0, 120.0, False), ("1e7", 600.0, 1200.0, True))),
    Row("layer_points_1e6", free(sheet(1.0, 0.01, 250, SIMPLE, VELOCITY.format(0.0, 0.0, 1.0), layers=4), end=2e-4,
                                 window=1e-4), Stable(1e-3), limit_s=300.0, full=True),
]
