"""Follows the gradient of a cost with respect to the knots of an action."""

import os

import matplotlib.pyplot as plt
import numpy as np

from bendtwin import Client, GradientOptions, Keypoints, Returns

with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    twin = next(client.twins())  # the newest
    geometry = twin.geometry()
    from_hand = np.linalg.norm(geometry.rest_positions - geometry.controls.mean(axis=0), axis=1)
    node = int(np.abs(from_hand - 0.1).argmin())  # 10 cm from the hand
    goal = geometry.rest_positions[node] + [0.05, 0.0, 0.15]

    knots = np.repeat(geometry.controls[None, None], 4, axis=1)  # [1, K, C, 3], all at rest
    costs = []
    for _ in range(12):
        result = twin.rollout(
            trajectories=knots,
            frames=20,
            costs=[Keypoints(nodes=[node], targets=[goal], squared=True)],
            returns=Returns(action_gradients=True),
            # Where something touches the ground, its impacts are smoothed over a millimetre.
            gradient=GradientOptions(smoothing_m=0.001),
        )
        costs.append(float(result.costs[0]))
        slope = result.action_gradients.sum(axis=2, keepdims=True)  # The points move together.
        slope[:, 0] = 0.0  # Row 0 is where they are.
        knots = knots - 0.01 * slope / max(np.abs(slope).max(), 1e-9)
        knots[..., 2] = np.maximum(knots[..., 2], geometry.controls[:, 2])  # above the table

print(f"{1000 * costs[0] ** 0.5:.0f} mm from the goal at first,")
print(f"{1000 * min(costs) ** 0.5:.0f} mm after {len(costs)} steps")
plt.plot(1000 * np.sqrt(costs), "o-")
plt.gca().set(xlabel="step", ylabel="distance [mm]", title="Gradient descent")
plt.savefig("gradients.png", dpi=80)
