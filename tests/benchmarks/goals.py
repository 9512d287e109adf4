"""Goals and limits of the numbers of `sunder bench`, `sunder bench --runs`, and of the suites `package` and `ci` of `report`.

A goal is what the number should come to. A limit is what it must not pass: beyond it the command fails. Both were set
before the measurement that is judged. A limit comes from one of three rules:

- STOOD: what the number was when the goal was set, the worse end of its range. Worse than that is a loss.
- NEAR: the goal was met when the limit was set. A quarter more than the goal is then a loss: minima over repetitions that
  take turns repeat within a tenth, beside other programs too.
- Where a third rule holds, it stands beside the number.
"""
from __future__ import annotations

import math
from dataclasses import dataclass

NEAR = 1.25
MET, MISSED, BEYOND = "met", "missed", "beyond the limit"  # how a number stands to its goal


@dataclass(frozen=True)
class Goal:
    """What a number should be at most, or at `least`, and the limit beyond which it is a failure."""
    goal: float
    limit: float
    unit: str
    least: bool = False

    def met(self, value: float) -> bool:
        """Whether the value is as good as the goal."""
        return value >= self.goal if self.least else value <= self.goal

    def within(self, value: float) -> bool:
        """Whether the value is not beyond the limit. One that is no number is beyond it."""
        return value >= self.limit if self.least else value <= self.limit

    @property
    def in_words(self) -> tuple[str, str]:
        """Goal and limit as a table has them."""
        sign = "≥" if self.least else "≤"
        return f"{sign} {self.goal:.3g}", f"{sign} {self.limit:.3g}"


def near(goal: float, unit: str) -> Goal:
    """A goal that was met when its limit was set."""
    return Goal(goal, NEAR * goal, unit)


BENCH_GOALS: dict[str, Goal] = {
    "share_of_fma_peak": Goal(0.35, 0.22, "of the peak", least=True),  # STOOD, at 0.22 to 0.25
    # A second thread may not make a run slower, whatever else the machine does.
    "thread_speedup_2": Goal(1.85, 1.0, "times", least=True),
    "two_threads_time_ratio": Goal(1.0 / 1.85, 1.0, "times"),
    "two_threads_time_ratio_beside": near(1.03, "times"),
    # 12 ns a layer point where one that no crack has touched takes 3.6; STOOD, at 110 ns beside 5.3
    "cracked_point_ratio": Goal(3.3, 110.0 / 5.3, "times an intact point"),
    # The border is gathered as cracked points are, so it may cost what these did at the better end, 60 ns beside 5.3.
    "trimmed_border_point_ratio": Goal(1.5, 60.0 / 5.3, "times a point within"),
    # "A trimmed patch costs at most 1.5 times a point": time over all points inside, of a disc in a sheet of 60 x 60 elements
    # with a tenth of its points beside the loop. The share of those falls with finer elements, and the ratio with it.
    # STOOD, at 1.55.
    "trimmed_point_ratio": Goal(1.5, 1.55, "times a point of a whole sheet"),
    # A loop along the edges of the patch leaves all of it to the rows, so both compute the same; 2 % for the clock.
    "whole_loop_time_ratio": near(1.02, "times"),
    "absent_time_ratio": near(1.02, "times"),
    "absent_memory_ratio": near(1.1, "times"),
    "absent_allocations_per_substep": near(0.5, "allocations"),
    "absent_but_idle_plasticity_time_ratio": Goal(1.3, 2.7, "times"),  # STOOD
    "absent_but_idle_fibres_time_ratio": near(1.5, "times"),
    "absent_but_idle_fibres_memory_ratio": near(1.5, "times"),
    "window_roundtrip_us_4k_p50": near(100.0, "us"),
    "window_roundtrip_us_4k_p99": near(500.0, "us"),
    "window_roundtrip_us_1000_fragments_p50": near(1000.0, "us"),
    "process_boundary_overhead_percent": near(3.0, "%"),
}

RUNS_GOALS: dict[str, Goal] = {
    "glass_processor_s": Goal(120.0, 380.0, "s of processor"),  # STOOD, at 190 s of both cores
    "glass_contact_sheet_s": Goal(3.0, 24.0, "s of processor"),  # STOOD, at 13 to 24
    # a picture of the sheet takes as long, and it has six panels and three views; limit: NEAR, of 63 s for 81
    "glass_film_s_a_picture": Goal(3.0 / 9.0, NEAR * 63.0 / 81.0, "s of processor"),
    # limit: half of the share that it had when pictures were copied from process to process
    "glass_film_system_share": Goal(0.10, 0.25, "of the film's processor time"),
    "glass_fracture_share": Goal(0.10, 0.51, "of the windows"),  # STOOD, at 0.02 to 0.51 over the shipped scenes
    "pressed_plate_fracture_share": Goal(0.10, 0.51, "of the windows"),
    "glass_ms_per_edge": Goal(0.15, 3.0, "ms"),  # STOOD, at 0.5 to 3
    "pressed_plate_ms_per_edge": Goal(0.15, 3.0, "ms"),
    "impactor_small_shell_contact_share": Goal(0.15, 0.53, "of the run"),  # STOOD, at 0.35 to 0.53
}

# A package may be slower than a build for the machine by no more than its goal.
PACKAGE_GOALS: dict[str, Goal] = {"package_force_time_ratio": Goal(1.05, 1.05, "times the native programs")}
CI_GOALS: dict[str, Goal] = {"ci_s": Goal(1200.0, 2100.0, "s")}  # 20 minutes of two cores; STOOD, at 1754

GOALS: dict[str, Goal] = BENCH_GOALS | RUNS_GOALS | PACKAGE_GOALS | CI_GOALS

# Goals of one number over another of the same run.
RATIOS = {"cracked_point_ratio": ("force_ns_per_layer_point_mls", "force_ns_per_layer_point")}


def with_ratios(numbers: dict[str, float]) -> dict[str, float]:
    """The numbers, and their ratios where both parts were measured."""
    return dict(sorted((numbers | {key: numbers[over] / numbers[under] for key, (over, under) in RATIOS.items()
                                   if over in numbers and under in numbers}).items()))


def standing(key: str, value: object) -> str:
    """How a number stands: `MET`, `MISSED` or `BEYOND`; '' where it has no goal."""
    if key not in GOALS:
        return ""
    if not isinstance(value, (int, float)) or not math.isfinite(value) or not GOALS[key].within(value):
        return BEYOND
    return MET if GOALS[key].met(value) else MISSED


def lines(numbers: dict[str, float]) -> list[str]:
    """A line for each number: its value and, where it has a goal, the goal, the limit and how it stands."""
    out = []
    for key, value in numbers.items():
        told = f"{key:<54} {value:>10.6g}"
        if key in GOALS:
            goal = GOALS[key]
            how = standing(key, value)
            told += f" {goal.unit}, goal {goal.in_words[0]}, limit {goal.in_words[1]}: {how.upper() if how == BEYOND else how}"
        out.append(told)
    return out


def beyond(numbers: dict[str, float]) -> list[str]:
    """Keys of the numbers that are beyond their limits."""
    return [key for key, value in numbers.items() if standing(key, value) == BEYOND]
