"""Scatter of the strength against fragment sizes: a clamped pane of glass, a heavy ball.

    coupler/sunder sweep coupler/experiments/fragment_sizes.py

The strength of a place as large as flaw_spacing_m stays: a small modulus makes weak places weaker, and a pane with them.
"""
import sunder

SIZE, THICKNESS, RADIUS = 0.2, 2e-3, 0.02  # [m]
END = 1.5e-3                               # [s]

pane = sunder.Scene.load(sunder.SCENES / "glass.textproto").set({
    "shells[pane].plate.size_x_m": SIZE, "shells[pane].plate.size_y_m": SIZE, "shells[pane].thickness_m": THICKNESS,
    "shells[pane].plate.elements_x": 50, "shells[pane].plate.elements_y": 50,
    "bodies[ball].pose.position.z": 0.4 + RADIUS + 0.5 * THICKNESS + 2e-5,
    "end_time_s": END, "window_s": 1e-5, "fracture.latest_freeze_s": END,
    "output.frame_interval_s": END, "output.shell_frame_interval_s": END})
pane.message.output.probes.add(name="ball", body="ball")

experiment = sunder.Experiment(
    name="fragment_sizes",
    scene=pane,
    parameters={"weibull_modulus": sunder.Parameter([3, 5, 8, 16, 32], "materials[glass].weibull_modulus")},
    seeds=range(1, 7),
    measure=[sunder.impact("ball"), sunder.fragments()],
    plots=[sunder.Plot("weibull_modulus", "pieces", logarithmic=True, title="pieces of at least a thousandth of the pane"),
           sunder.Plot("weibull_modulus", "median_piece_m2", logarithmic=True, title="their median area")],
)
