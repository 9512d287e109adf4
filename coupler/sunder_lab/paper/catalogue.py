"""What is run for the figures of the paper: cases, their sizes, and the rows of the paper's Table 2."""
from __future__ import annotations

from dataclasses import dataclass

from sunder_tools.launch.fidelity import PATCHES

from ..scene import SCENES, Scene

SIZES = ("small", "full")


@dataclass(frozen=True)
class Size:
    """How a scene's file becomes a size: a factor of all elements along a side, then settings as --set takes them."""
    elements: float = 1.0
    settings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Case:
    """One run. `scene` is its file below scenes/, without the ending; `settings` are those of both sizes."""
    name: str
    scene: str
    small: Size = Size()
    full: Size = Size()
    settings: tuple[str, ...] = ()

    def file(self) -> str:
        """The scene's path below the checkout."""
        return f"scenes/{self.scene}.textproto"

    def all_settings(self, size: str) -> list[str]:
        """All that --set gets in this size. Raises CommandError where the scene cannot be read."""
        chosen = self.small if size == "small" else self.full
        return [*scaled(Scene.load(SCENES / f"{self.scene}.textproto"), chosen.elements), *self.settings, *chosen.settings]

    def made(self, size: str) -> Scene:
        """The scene in this size. Raises CommandError."""
        scene = Scene.load(SCENES / f"{self.scene}.textproto")
        return scene.set({path: value for path, value in (s.split("=", 1) for s in self.all_settings(size))})


def scaled(scene: Scene, factor: float) -> list[str]:
    """Settings that multiply the elements along all sides of all shells."""
    found = []
    for shell in scene.message.shells if factor != 1.0 else ():
        for patch, counts in PATCHES.items():
            if shell.HasField(patch):
                part = getattr(shell, patch)
                found += [f"shells[{shell.name}].{patch}.{count}={max(1, round(getattr(part, count) * factor))}"
                          for count in counts if getattr(part, count)]
    return found


# The paper's characteristic length is sqrt(3) times the spacing of its grid. A finer net of elements keeps that length.
_WIDE_15MM, _WIDE_10MM = "fracture.damage_width_m=0.02598", "fracture.damage_width_m=0.01732"
_FINE = ("output.frame_interval_s=0.02",)
# Half the usual step: while a sheet tears, the energy that the books miss falls much faster than the step.
_CAREFUL = "time_step_safety=0.4"
_SQUARE = (Size(0.6, ("window_s=4e-3", _CAREFUL)), Size(1.41, (_WIDE_10MM,)))
_STRETCH = (Size(1.0, (_CAREFUL,)), Size(2.87, (_WIDE_15MM,)))

CASES = {case.name: case for case in (
    Case("fig01", "paper/fig01", Size(0.15, ("end_time_s=0.25",))),
    Case("fig04_maximum", "over_stretch", *_STRETCH, settings=(
        *_FINE, "fracture.healing=false", "fracture.extract_cracks=false")),
    Case("fig04_cut", "over_stretch", *_STRETCH, settings=(*_FINE, "fracture.healing=false")),
    Case("fig04_healing", "over_stretch", *_STRETCH, settings=_FINE),
    Case("fig09_ours", "torn_square", *_SQUARE, settings=("shells[sheet].stress_model=PAPER_PROJECTION",)),
    Case("fig09_plane_stress", "torn_square", *_SQUARE),
    Case("fig09_jgt17", "torn_square", *_SQUARE, settings=("shells[sheet].stress_model=JGT17",)),
    Case("fig09_ghf18", "torn_square", *_SQUARE, settings=("shells[sheet].stress_model=GHF18",)),
    Case("fig11_mode_one", "mode_one", full=Size(2.0, ("fracture.damage_width_m=0.00693",)), settings=("fracture.mode=DAMAGE",)),
    Case("fig11_mode_two", "mode_two", full=Size(2.0, ("fracture.damage_width_m=0.00693",)), settings=("fracture.mode=DAMAGE",)),
    Case("fig11_plate", "pressed_plate", full=Size(1.5)),
    # The bullet comes from the other side than in the scene: it leaves through the face on which light falls in the picture.
    Case("fig12", "bullet_sheet", full=Size(1.48, ("time_step_safety=0.1",)), settings=(
        "output.frame_interval_s=1e-3", "bodies[bullet].pose.position.x=0.03", "bodies[bullet].twist.linear.x=-40",
        "fracture.mode=DAMAGE", "fracture.healing=false")),
    Case("fig13", "paper/fig13", Size(0.4)),
    Case("fig14_even", "paper/fig14", Size(0.288, ("end_time_s=0.2",)), settings=("shells[cloth].strength_regions[0].factor=1",)),
    Case("fig14_weakened", "paper/fig14", Size(0.288, ("end_time_s=0.2",))),
    Case("fig15", "paper/fig15", Size(0.22)),
    Case("fig16", "paper/fig16", Size(0.23)),
    Case("fig17", "paper/fig17", Size(0.2026, ("window_s=1e-4",))),
)}


@dataclass(frozen=True)
class Row:
    """One row of the paper's Table 2. `others`: particles of the types I to III; `points`: quadrature points in layers."""
    figure: int
    case: str
    others: float
    points: float
    steps: int
    step_s: float  # of the clock, on `CORES` cores


CORES = 12    # of the paper's i9-7920X, which runs 24 threads; its text says 24 cores
THREADS = 24

TABLE_2 = (
    Row(1, "fig01", 170e3, 630e3, 12000, 2.73),
    Row(4, "fig04_healing", 23e3, 160e3, 4000, 1.29),
    Row(9, "fig09_ours", 20e3, 160e3, 3500, 1.08),
    Row(12, "fig12", 26e3, 160e3, 4500, 1.57),
    Row(13, "fig13", 19e3, 160e3, 8000, 1.23),
    Row(14, "fig14_weakened", 74e3, 500e3, 4000, 3.02),
    Row(15, "fig15", 103e3, 502e3, 6000, 2.80),
    Row(16, "fig16", 183e3, 502e3, 3400, 4.10),
    Row(17, "fig17", 60e3, 1.25e6, 4300, 4.02),
)
