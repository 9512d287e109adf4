"""Rows of `validate extremes` that break: strengths, pieces, cuts."""
from __future__ import annotations

from typing import Sequence

from .bodies import AT
from .rows import Check, Outcome, Quantity, Refused, Row, Runner, Stable
from .scenes import CLAMPED, GLASS, ball, material, message, scene, sheet

BROKEN = 2e-2  # of the books with cracks: the program itself warns above
# What the program advises: these grids do not hold what such a strength stores, or such a speed brings.
COARSE = ".*refine$|cracks divided"
GRAVITY = -9.81
FALL_S = 0.02


def cut(*points: tuple[float, float]) -> str:
    return "\n".join(["cuts {", *(message("points", {"u": u, "v": v}) for u, v in points), "}"])


def square(middle: float, half: float) -> str:
    low, high = middle - half, middle + half
    return cut((low, low), (high, low), (high, high), (low, high), (low, low))


def grid(pieces: int, elements: int) -> str:
    """A free sheet of 1 m cut into pieces x pieces before it falls."""
    lines = [k / pieces for k in range(1, pieces)]
    cuts = [c for x in lines for c in (cut((x, 0.0), (x, 1.0)), cut((0.0, x), (1.0, x)))]
    return scene(FALL_S, 1e-4, material(**GLASS), sheet(1.0, 0.004, elements, *cuts), "fracture {\nmode: CUTS\n}",
                 gravity=GRAVITY)


def fallen(pieces: int) -> Check:
    """All of them come off with all of the mass, and their centre falls freely."""
    def check(found: Outcome, runner: Runner) -> Sequence[Quantity]:
        del runner
        mass = found.shards["mass"]
        middle = sum(m * z for m, z in zip(mass, found.shards["z"])) / sum(mass)
        return [Quantity("pieces", len(mass), pieces, 0.0), Quantity("mass", sum(mass), GLASS["density"] * 0.004, 1e-9),
                Quantity("fall", middle, 0.5 * GRAVITY * FALL_S ** 2, 2e-3)]  # window by window: less than half a one
    return check


def half_falls(found: Outcome, runner: Runner) -> Sequence[Quantity]:
    del runner
    return [Quantity("pieces", len(found.shards["mass"]), 1, 0.0),
            Quantity("mass", found.shards["mass"][0], 0.5 * GLASS["density"] * 0.004, 1e-9),
            Quantity("fall", found.shards["z"][0], 0.5 * GRAVITY * FALL_S ** 2, 2e-3)]


def cut_out(half: float) -> str:
    """A square about the Gauss point next to the middle, out of a pane that hangs in equilibrium."""
    return scene(FALL_S, 1e-4, material(**GLASS), sheet(1.0, 0.004, 16, CLAMPED, square(0.5 + AT / 16.0, half)),
                 "fracture {\nmode: CUTS\n}")


def one_piece(found: Outcome, runner: Runner) -> Sequence[Quantity]:
    del runner
    return [Quantity("pieces", len(found.shards["mass"]), 1, 0.0)]


def struck_pane(strength: float | None, energy: float = 8.0, speed: float = 10.0, scale: float = 1.0) -> str:
    """A clamped pane of 0.25 m and 4 mm times `scale`, hit by a steel ball; ends 0.4 ms times `scale` later.

    Lengths, times and fracture energy times the scale: the same motion and the same cracks."""
    breaks = {} if strength is None else {"strength": strength, "fracture_energy": energy * scale, "weibull_modulus": 8.0,
                                          "flaw_spacing_m": 0.004 * scale}
    radius = 0.015 * scale
    return scene(4e-4 * scale, 2e-5 * scale, material(**{**GLASS, **breaks}), material("steel", density=7800.0),
                 sheet(0.25 * scale, 0.004 * scale, 32, CLAMPED),
                 ball(radius, (0.0005 * scale, -0.0003 * scale, radius + 0.0021 * scale), (0.0, 0.0, -speed)),
                 f"fracture {{\nmode: TIPS\nseed: 1\nquiet_time_s: {5e-4 * scale!r}\n}}", probes=["ball"])


def never_breaks(found: Outcome, runner: Runner) -> Sequence[Quantity]:
    """No crack, and the ball as by a pane without a strength; steps differ, as what may crack takes shorter ones."""
    other = runner.compare_with(struck_pane(None))
    return [Quantity("cracks", found.series["cracks"][-1], 0.0, 0.0),
            Quantity("velocity", found.probes["ball_vz"][-1], other.probes["ball_vz"][-1], 0.02)]


def breaks(found: Outcome, runner: Runner) -> Sequence[Quantity]:
    del runner
    return [Quantity("cracked", float(found.series["cracks"][-1] > 0.25), 1.0, 0.0)]


def similar(scale: float, engine: str) -> Check:
    """Powers of two scale without round-off; the scene is written with 17 digits."""
    def check(found: Outcome, runner: Runner) -> Sequence[Quantity]:
        other = runner.compare_with(struck_pane(180e6), engine=engine)
        return [Quantity("cracks", found.series["cracks"][-1] / scale, other.series["cracks"][-1], 1e-6),
                Quantity("velocity", found.probes["ball_vz"][-1], other.probes["ball_vz"][-1], 1e-6)]
    return check


CRACKS: list[Row] = [
    Row("strength_never", struck_pane(1e15), Stable(1e-3), never_breaks),
    Row("strength_always", struck_pane(1.0), Stable(BROKEN, COARSE), breaks, limit_s=120.0),
    Row("strength_always_weak", struck_pane(1e6, 1e-3), Stable(BROKEN, COARSE), breaks, limit_s=120.0),
    # powers of two: all of it scales to the last digit, an engine's own lengths included (coupler/link/units.h)
    *(Row(f"cracks_at_{name}{end}", struck_pane(180e6, scale=scale), Stable(BROKEN, COARSE + lacks), similar(scale, engine),
          limit_s=120.0, engine=engine)
      for name, scale in (("1um", 2.0 ** -18), ("1km", 2.0 ** 12))
      for engine, end, lacks in (("bullet", "", ""),
                                 ("freeflight", "_without_engine", "|the engine 'freeflight' cannot do 'contact'"))),
    Row("cracks_1km_per_s", struck_pane(180e6, speed=1000.0), Stable(BROKEN, COARSE), breaks, limit_s=120.0),
    Row("fragments_1", scene(FALL_S, 1e-4, material(**GLASS), sheet(
        1.0, 0.004, 16, "supports { edges: U_MIN kind: CLAMPED }", cut((0.5, 0.0), (0.5, 1.0))),
        "fracture {\nmode: CUTS\n}", gravity=GRAVITY), Stable(BROKEN), half_falls),
    Row("fragments_256", grid(16, 32), Stable(BROKEN), fallen(256), limit_s=120.0),
    Row("fragments_5041", grid(71, 142), Stable(BROKEN), fallen(5041), limit_s=900.0, full=True),
    Row("fragment_of_one_point", cut_out(0.2 / 16.0), Stable(BROKEN), one_piece),
    Row("refused_fragment_of_no_point", cut_out(0.2 / 16.0).replace(square(0.5 + AT / 16.0, 0.2 / 16.0),
                                                                   square(0.5, 0.1 / 16.0)),
        Refused("shells[0].cuts[0]", "cuts {")),
]
