"""The speed at which half of the plates are perforated: a clamped plate of acrylic glass, a steel pellet.

    coupler/sunder sweep coupler/experiments/ballistic_limit.py
"""
import sunder

plate = sunder.Scene.load(sunder.SCENES / "acrylic.textproto").set({
    "shells[plate].plate.size_x_m": 0.04, "shells[plate].plate.size_y_m": 0.04,
    "shells[plate].plate.elements_x": 40, "shells[plate].plate.elements_y": 40,
    "end_time_s": 8e-4, "output.frame_interval_s": 1})
plate.find("shells[plate]").supports.add(edges=["ALL"], kind="CLAMPED")

limit = sunder.V50(name="ballistic_limit", scene=plate, speed={"bodies[pellet].twist.linear.z": lambda speed: -speed},
                   low=30, high=60, tolerance=2, seeds=range(1, 10), body="pellet")
