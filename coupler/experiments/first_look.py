# %% [markdown]
# A first look at a run, cell by cell: the same as a script, or as a notebook by `jupytext` or an editor that knows `# %%`.
# It needs a build (`coupler/sunder build`) and writes into ./first_look.

# %% A scene, changed
import numpy as np

import sunder

scene = sunder.Scene.load(sunder.SCENES / "struck_glass.textproto")
scene["bodies[ball].twist.linear.z"] = -20.0  # [m/s]
print(scene["shells[pane].thickness_m"], "m thick;", scene["end_time_s"], "s")

# %% Run it: some seconds
results = scene.run("first_look")
print(results.run["status"], results.run["counts"]["fragments"], "fragments")

# %% Columns of series.csv by their names, in SI units
elastic = results.series["elastic"]
print(f"largest elastic energy {elastic.max():.3g} J of {len(elastic)} windows")

# %% The last frame: points of the shell, and how far it has bent
shell = results.frames[-1].read(0)
bent = np.abs(shell.point_data["displacement"][:, 2]).max()
print(f"{len(shell.points)} points, bent by {1e3 * bent:.2g} mm")

# %% What the ball lost
ball = sunder.motion(results)
print(f"impulse {ball.impulse[-1].round(6)} N s; residual velocity {ball.residual_velocity:.3g} m/s")

# %% Pieces, and one of them through all frames by its id
areas = sunder.pieces(results).counted()
tracks = sunder.tracks(results)
shard = int(results.shards["id"][0])
print(f"{len(areas)} pieces, the largest of {1e6 * areas[0]:.3g} mm2; shard {shard} at {tracks[shard].centre[-1]} m")
