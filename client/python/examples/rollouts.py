"""Predicts 64 motions of the grippers in one call, and draws where a point of the object goes."""

import os

import matplotlib.pyplot as plt
import numpy as np

from bendtwin import Client, Keypoints, Returns

with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    twin = next(client.twins())  # the newest
    geometry = twin.geometry()
    from_hand = np.linalg.norm(geometry.rest_positions - geometry.controls.mean(axis=0), axis=1)
    node = int(np.abs(from_hand - 0.1).argmin())  # 10 cm from the hand

    # [B, K, C, 3]: each motion goes from where the control points are to another place.
    angles = np.linspace(0.0, 2 * np.pi, 64, endpoint=False)
    ways = 0.1 * np.stack([np.cos(angles), np.sin(angles), np.ones(64)], axis=1)
    motions = geometry.controls + np.array([0.0, 1.0])[:, None, None] * ways[:, None, None]

    goal = geometry.rest_positions[node] + [0.05, 0.05, 0.1]
    result = twin.rollout(
        trajectories=motions,
        frames=30,
        costs=[Keypoints(nodes=[node], targets=[goal])],
        returns=Returns(every_frames=1),
    )

best = int(result.costs.argmin())
print(f"{len(result.costs)} motions of {len(result.frames)} frames")
print(f"motion {best} ends {1000 * result.costs[best]:.0f} mm from the goal")
for motion, way in enumerate(result.positions[:, :, node]):
    plt.plot(
        *way[:, :2].T, color="C1" if motion == best else "C0", alpha=1 if motion == best else 0.3
    )
plt.plot(*goal[:2], "k+")
plt.gca().set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Ways of a point")
plt.savefig("rollouts.png", dpi=80)
