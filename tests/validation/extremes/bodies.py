"""Rows of `validate extremes` with bodies: masses, speeds, restitution, friction."""
from __future__ import annotations

import math
from typing import Any, Callable, Sequence

from .rows import Outcome, Quantity, Refused, Row, Runner, Stable
from .scenes import CLAMPED, GLASS, ball, material, scene, sheet

GAP = 1e-4       # [m] between ball and sheet at the start
SINKS = "ball 'ball' may sink"  # these balls are small beside the distance of the Gauss points
HIT = 1e-3       # of the books with contact and without cracks
RECOVERY = 0.01  # [m/s]: an overlap with a body that the engine holds is taken back so fast at most
AT = 0.21132486540518713  # of an element: a Gauss point, so that the ball touches at the point nearest to it


def struck(ratio: float, speed: float, *parts: str, restitution: float | None = None, elements: int = 8,
           way: float = 2e-3, edges: str = "", sideways: float = 0.0, **fields: Any) -> str:
    """A ball of `ratio` times the mass of a free sheet of 1 m and 10 mm flies onto it over GAP; ends when it has
    flown, or would have flown, `way` [m]."""
    radius, at = 0.8 / elements, AT / elements
    lead = GAP * sideways / speed if sideways else 0.0  # over the Gauss point as it touches, or the normal leans
    density = ratio * GLASS["density"] * 0.01 / (4.0 / 3.0 * math.pi * radius ** 3)
    end = way / speed if speed > 0.0 else 1e-3
    window = end / max(1, min(max(20, math.ceil(end / 1e-4)), int(end / 2e-5)))  # no shorter than the stable step
    contact = [] if restitution is None else [f"contacts {{\nrestitution: {restitution!r}\n}}"]
    return scene(end, window, material(**GLASS), material("steel", density=density),
                 sheet(1.0, 0.01, elements, *([edges] if edges else [])),
                 ball(radius, (at - lead, at, radius + 0.005 + GAP), (sideways, 0.0, -speed)), *contact, *parts, probes=["ball"],
                 **fields)


def after(reference: float, tolerance: float, speed: float = 1.0) -> Callable[[Outcome, Runner], Sequence[Quantity]]:
    """Velocity of the ball at the end over the one it came with."""
    def check(found: Outcome, runner: Runner) -> list[Quantity]:
        del runner
        return [Quantity("velocity", found.probes["ball_vz"][-1] / speed, reference, tolerance)]
    return check


def untouched(found: Outcome, runner: Runner) -> list[Quantity]:
    del runner
    z = found.probes["ball_z"]
    return [Quantity("moved", max(z) - min(z), 0.0, 0.0)]


def with_friction(value: str) -> str:
    """So light a ball that the sheet is a wall to it: one of a hundredth of the sheet's mass bends it by 2 mrad."""
    return struck(1e-6, 1.0, f"contacts {{\nfriction: {value}\n}}", sideways=1.0)


def slid(found: Outcome, runner: Runner) -> list[Quantity]:
    """Without friction nothing takes the speed along the sheet: a coefficient of 0.01 would take 1e-2."""
    del runner
    return [Quantity("speed along", found.probes["ball_vx"][-1], found.probes["ball_vx"][0], 1e-4)]


def stuck(found: Outcome, runner: Runner) -> list[Quantity]:
    """A solid sphere that sticks rolls from then on. Impulses act on the middle surface, half a thickness below what the
    sphere touches: with 5/7 of its speed along a thin sheet, with 0.734 of it here."""
    del runner
    radius, lever = 0.1, 0.1 + 0.005  # [m]
    along = found.probes["ball_vx"]
    return [Quantity("speed along", along[-1], along[0] * lever ** 2 / (lever ** 2 + 0.4 * radius ** 2), 1e-4)]


BODIES: list[Row] = [
    # a ball so light that the sheet is a wall to it, and one that does not notice the sheet
    Row("mass_1e-6_elastic", struck(1e-6, 1.0, restitution=1.0), Stable(HIT, SINKS), after(1.0, 1e-3)),
    Row("mass_1e-6_inelastic", struck(1e-6, 1.0, restitution=0.0), Stable(HIT, SINKS), after(0.0, 1.1 * RECOVERY)),
    Row("mass_1", struck(1.0, 1.0), Stable(HIT, SINKS)),
    *(Row(f"mass_1e6_{name}", struck(1e6, 1.0, restitution=e), Stable(HIT, SINKS), after(-1.0, 4e-6))
      for name, e in (("elastic", 1.0), ("inelastic", 0.0))),
    Row("mass_1e6_two_processes", struck(1e6, 1.0), Stable(HIT, SINKS), after(-1.0, 4e-6), processes=2),
    # a ball at rest stays to the bit; slow ones bounce as fast ones do; the sheet of fast ones does not break
    Row("ball_at_rest", struck(1.0, 0.0), Stable(HIT, SINKS, "no moving body has touched a shell"), untouched),
    *(Row(f"rebound_{v:g}_m_per_s", struck(1e-6, v, restitution=1.0), Stable(HIT, SINKS), after(1.0, 1e-3, v))
      for v in (1e-3, 1e-2, 0.1, 10.0)),
    *(Row(f"ball_{v:.0f}_m_per_s", struck(0.01, v, elements=16, way=0.05, edges=CLAMPED), Stable(2e-2, SINKS))
      for v in (10.0, 100.0, 1000.0)),
    Row("refused_ball_1e7_m_per_s", struck(0.01, 1e7, way=1e4), Refused("bodies[0].twist", "twist {")),
    Row("friction_0", with_friction("0"), Stable(HIT, SINKS), slid),
    Row("friction_1e300", with_friction("1e300"), Stable(HIT, SINKS), stuck),
    *(Row(f"refused_friction_{value.replace('-', 'minus_')}", with_friction(value),
          Refused("contacts[0].friction", "friction:")) for value in ("inf", "nan", "-1")),
    *(Row(f"refused_restitution_{e}", struck(1.0, 1.0, restitution=e), Refused("contacts[0].restitution", "restitution:"))
      for e in (1.01, -0.1)),
]
