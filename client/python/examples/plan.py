"""Plans a motion that brings a point of the object to a goal, with two planners, and draws it."""

import os

import matplotlib.pyplot as plt
import numpy as np

from bendtwin import Client, Keypoints, Returns
from bendtwin.planners import Bounds, Cem, Mppi, Task, Together

with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    twin = next(client.twins())  # the newest
    geometry = twin.geometry()
    from_hand = np.linalg.norm(geometry.rest_positions - geometry.controls.mean(axis=0), axis=1)
    node = int(np.abs(from_hand - 0.1).argmin())  # 10 cm from the hand
    goal = geometry.rest_positions[node] + [0.1, 0.05, 0.15]

    task = Task(
        twin=twin,
        costs=[Keypoints(nodes=[node], targets=[goal])],
        space=Together(geometry.controls),
        frames=20,
    )
    bounds = Bounds(low=[-0.3, -0.3, 0.0], speed=1.0)
    plans = {
        "MPPI": Mppi(task, samples=32, iterations=4, sigma=0.06, bounds=bounds).plan(),
        "CEM": Cem(task, samples=32, iterations=4, sigma=0.06, bounds=bounds).plan(),
    }
    for name, plan in plans.items():
        there, before = 1000 * plan.cost, 1000 * plan.nominal_cost
        print(f"{name}: {there:.0f} mm from the goal instead of {before:.0f}")
    best = min(plans.values(), key=lambda plan: plan.cost)
    result = twin.rollout(**best.actions(), returns=Returns(every_frames=5))

for frame, nodes in zip(result.frames, result.positions[0], strict=True):
    plt.scatter(*nodes[:, [0, 2]].T, s=6, label=f"frame {frame}")
plt.plot(*goal[[0, 2]], "k+", markersize=12)
plt.legend()
plt.gca().set(aspect="equal", xlabel="x [m]", ylabel="z [m]", title="The plan, and the goal")
plt.savefig("plan.png", dpi=80)
