"""Impact speed against number of cracks: a plate of acrylic glass struck by a steel pellet.

    coupler/sunder sweep coupler/experiments/radial_cracks.py
"""
import sunder

ELEMENTS = 60
HALF = 0.5 * 0.06 / ELEMENTS  # [m], half an element: where in its element the pellet strikes is chance

experiment = sunder.Experiment(
    name="radial_cracks",
    scene=sunder.Scene.load(sunder.SCENES / "acrylic.textproto").set({
        "shells[plate].plate.elements_x": ELEMENTS, "shells[plate].plate.elements_y": ELEMENTS,
        "end_time_s": 1.2e-4, "output.frame_interval_s": 1.2e-4}),
    parameters={"speed_m_per_s": sunder.Parameter(
        [15, 22, 30, 40, 57, 80, 120], {"bodies[pellet].twist.linear.z": lambda speed: -speed})},
    seeds=range(1, 7),
    scatter={"bodies[pellet].pose.position.x": HALF, "bodies[pellet].pose.position.y": HALF},
    measure=[sunder.impact("pellet"), sunder.fragments(), sunder.radial_cracks(centre=(0.03, 0.03), radius_m=4e-3)],
    plots=[sunder.Plot("speed_m_per_s", "radial_cracks", title="radial cracks, four thicknesses from the impact"),
           sunder.Plot("speed_m_per_s", "crack_length_m")],
)
