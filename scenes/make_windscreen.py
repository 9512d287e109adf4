"""Writes cad/windscreen.step: a curved windscreen, and the frame of four strips around it, as two bodies."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from step_file import write_bodies

ACROSS, UP = 9, 7              # control points of the pane
RIM = 3                        # and of the frame, across a strip
OUT_SIDE, OUT_TOP = 0.07, 0.09  # how far the frame goes on beyond the pane, in its parameters


@dataclass
class Strip:
    """A patch by its control points (along v, along u, 3) [m]."""
    name: str
    net: np.ndarray

    def edge(self, side: str) -> np.ndarray:
        """Returns the control points of an edge, along u or v."""
        return {"u_min": self.net[:, 0], "u_max": self.net[:, -1], "v_min": self.net[0], "v_max": self.net[-1]}[side]


def place(s: float, t: float) -> np.ndarray:
    """Returns the place [m] across, -1 to 1, and up, 0 to 1. The glass bulges forwards, against y, and leans back."""
    half = 0.70 - 0.12 * t
    return np.array([half * s, 0.11 * s * s + 0.62 * t - 0.05 * t * (1.0 - t), 0.46 * t + 0.06 * t * (1.0 - t) - 0.02 * s * s])


def greville(count: int) -> np.ndarray:
    """Returns the Greville points of a uniform quadratic spline, 0 to 1."""
    knots = np.concatenate([[0.0, 0.0], np.arange(count - 1), [count - 2.0] * 2]) / (count - 2.0)
    return 0.5 * (knots[1:-2] + knots[2:-1])


def main() -> None:
    """Writes the file."""
    s, t = 2.0 * greville(ACROSS) - 1.0, greville(UP)
    pane = Strip("pane", np.array([[place(a, b) for a in s] for b in t]))
    corner = np.array([[place(a, b) for a in (-1.0, 1.0)] for b in (0.0, 1.0)])
    assert np.allclose(pane.net[[0, 0, -1, -1], [0, -1, 0, -1]].reshape(2, 2, 3), corner)

    def strip(name: str, border: np.ndarray, outwards: list[tuple[float, float]]) -> Strip:
        """Goes from the outer edge to the border of the pane; `outwards` are the parameters of the outer edge."""
        outer = np.array([place(a, b) for a, b in outwards])
        share = greville(RIM)[:, None, None]
        return Strip(name, outer * (1.0 - share) + border * share)

    low = [(a * (1.0 + OUT_SIDE), -OUT_TOP) for a in s]
    high = [(a * (1.0 + OUT_SIDE), 1.0 + OUT_TOP) for a in s]
    side = [b * (1.0 + 2.0 * OUT_TOP) - OUT_TOP for b in t]
    frame = [strip("bottom", pane.edge("v_min"), low),
             strip("right", pane.edge("u_max"), [(1.0 + OUT_SIDE, b) for b in side]),
             strip("top", pane.edge("v_max")[::-1], high[::-1]),
             strip("left", pane.edge("u_min")[::-1], [(-1.0 - OUT_SIDE, b) for b in side[::-1]])]
    write_bodies(Path(__file__).parent / "cad" / "windscreen.step", "windscreen", {"glass": [pane], "frame": frame},
                 "make_windscreen.py")


if __name__ == "__main__":
    main()
