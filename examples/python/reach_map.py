"""Where can the CS66 put a tool that points down, and how does it get along a straight line there?

Runs from top to bottom, or cell by cell in an editor that knows `# %%`. Needs elitescript, numpy and matplotlib:

    python examples/python/reach_map.py [PICTURE.png]
"""

# %% The arm with a gripper of 150 mm, and a picture's worth of places for it
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from elitescript import Robot, d2r, interpolate_pose
from matplotlib.colors import BoundaryNorm

robot = Robot("cs66", tcp=[0, 0, 0.15, 0, 0, 0])
x = np.linspace(-1.1, 1.1, 221)
z = np.linspace(-0.6, 1.2, 181)
grid_x, grid_z = np.meshgrid(x, z)
poses = np.zeros((grid_x.size, 6))
poses[:, 0], poses[:, 1], poses[:, 2] = grid_x.ravel(), 0.2, grid_z.ravel()
poses[:, 3] = np.pi  # the tool's z axis points down

# %% In how many ways each place can be reached: forty thousand poses, every solution, without its own links in the way
solutions, counts = robot.get_all_inverse_kin(poses)
reached = np.isfinite(solutions[..., 0])
clear = np.zeros(reached.shape, dtype=bool)
clear[reached] = np.asarray(robot.self_collision_distance(solutions[reached])) > 0.0
ways = clear.sum(axis=1).reshape(grid_x.shape)

# %% A straight line of the tool, and where the joints are meanwhile
start, end = [-0.55, 0.2, 0.25, np.pi, 0, 0], [0.55, 0.2, 0.25, np.pi, 0, 0]
along = np.linspace(0, 1, 201)
line = interpolate_pose(start, end, along)
path = np.empty((len(line), 6))
q = np.array([2.2, -1.2, 1.9, -2.2, -1.6, 0.6])
for i, pose in enumerate(line):
    q = robot.get_inverse_kin(pose, qnear=q)
    path[i] = q

# %% How fast each joint must turn for a tool speed of 250 mm/s, against what it can
seconds = (along[1] - along[0]) * np.linalg.norm(np.subtract(end, start)[:3]) / 0.25
speeds = np.gradient(path, seconds, axis=0)
load = np.abs(speeds) / robot.speed_limits

# %% The picture
figure, (map_axes, joint_axes) = plt.subplots(1, 2, figsize=(13, 5), width_ratios=[1.2, 1], layout="constrained")
steps = BoundaryNorm(np.arange(0.5, 9), 256)
shown = map_axes.pcolormesh(x, z, np.where(ways > 0, ways, np.nan), cmap="YlGnBu", norm=steps, shading="nearest")
figure.colorbar(shown, ax=map_axes, label="solutions without self-collision", ticks=range(1, 9))
map_axes.plot(line[:, 0], line[:, 2], color="#d1495b", linewidth=2.5, label="straight line")
map_axes.plot(0, 0, marker="s", color="black", linestyle="none", label="base")
map_axes.set(title="Tool pointing down, at y = 0.2 m", xlabel="x / m", ylabel="z / m", aspect="equal")
map_axes.legend(loc="upper right")
for joint, name in enumerate(["base", "shoulder", "elbow", "wrist 1", "wrist 2", "wrist 3"]):
    joint_axes.plot(line[:, 0], 100 * load[:, joint], label=name, linestyle="--" if joint == 5 else "-")
joint_axes.set(title="Joint speeds along the line at 250 mm/s", xlabel="x / m", ylabel="share of the joint's limit / %")
joint_axes.set_ylim(bottom=0)
joint_axes.grid(alpha=0.3)
joint_axes.legend()

# %% Saved, and the figures in words
if __name__ == "__main__":
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=110)
    share = (ways > 0).mean()
    busiest = np.unravel_index(load.argmax(), load.shape)
    print(f"{share:.0%} of the places can be reached, {(ways == ways.max()).sum()} of them in {ways.max()} ways")
    print(f"joint {busiest[1] + 1} turns fastest, at x = {line[busiest[0], 0]:.2f} m: {load.max():.0%} of its limit")
    print(f"the base turns by {abs(path[-1, 0] - path[0, 0]) / d2r(1):.0f} degrees")
