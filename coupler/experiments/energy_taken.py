"""Angle and thickness against the energy taken from the ball: a clamped plate of acrylic glass, a steel pellet at 40 m/s.

    coupler/sunder sweep coupler/experiments/energy_taken.py
"""
import math

import sunder

SPEED, RADIUS, GAP = 40.0, 2e-3, 1e-5  # [m/s], [m], [m]


def aim(scene: sunder.Scene, angle_deg: float) -> None:
    """The pellet comes from so far off the normal, and touches the plate soon; to be called once the thickness is set."""
    pellet = scene.find("bodies[pellet]")
    pellet.ClearField("twist")
    launch = pellet.launch
    launch.speed, launch.angle_deg, launch.target = SPEED, angle_deg, "plate"
    height = RADIUS + 0.5 * scene["shells[plate].thickness_m"] + GAP
    scene["bodies[pellet].pose.position.z"] = height / math.cos(math.radians(angle_deg))


plate = sunder.Scene.load(sunder.SCENES / "acrylic.textproto").set({
    "shells[plate].plate.size_x_m": 0.04, "shells[plate].plate.size_y_m": 0.04,
    "shells[plate].plate.elements_x": 36, "shells[plate].plate.elements_y": 36,
    "end_time_s": 1e-3, "output.frame_interval_s": 1e-3, "fracture.latest_freeze_s": 1e-3})
plate.find("shells[plate]").supports.add(edges=["ALL"], kind="CLAMPED")

experiment = sunder.Experiment(
    name="energy_taken",
    scene=plate,
    parameters={"thickness_m": sunder.Parameter([0.7e-3, 1e-3, 1.5e-3], "shells[plate].thickness_m"),
                "angle_deg": sunder.Parameter([0, 20, 40, 60], aim)},
    seeds=range(1, 6),
    measure=[sunder.impact("pellet"), sunder.fragments()],
    plots=[sunder.Plot("angle_deg", "energy_lost_J", by="thickness_m", title="energy that the pellet lost"),
           sunder.Plot("angle_deg", "energy_fracture_J", by="thickness_m", title="energy that cracks took")],
)
