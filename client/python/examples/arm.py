"""Plans joints of an arm that lifts the object while its links keep clear of it, and draws both."""

import os

import matplotlib.pyplot as plt
import numpy as np

from bendtwin import Client, Keypoints, Returns
from bendtwin.planners import Cem, Task
from bendtwin.robots import EXAMPLE_URDF, JointSpace, Robot, Workcell

FRAMES = 24

with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    twin = next(client.twins())  # the newest
    geometry = twin.geometry()
    held = geometry.controls.mean(axis=0)
    along = geometry.rest_positions.mean(axis=0) - held
    along = np.array([*along[:2], 0.0]) / np.linalg.norm(along[:2])
    low = geometry.rest_positions[:, 2].min()
    weight = geometry.masses.sum() * np.linalg.norm(geometry.gravity)

    # The arm stands beyond the object and reaches over it, with its tool down, to the held end.
    yaw = np.arctan2(-along[1], -along[0])
    base = [*(held + 0.5 * along)[:2], low, 0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)]
    robot = Robot.from_urdf(EXAMPLE_URDF, tip="tool", base_pose=base)
    down = [*held, np.cos(yaw / 2 + np.pi / 2), np.sin(yaw / 2 + np.pi / 2), 0.0, 0.0]
    found = robot.inverse([down], robot.positions({"lift": 0.8, "elbow": 1.5, "pitch": 0.8}))
    if not found.reached:
        raise SystemExit("the arm does not reach the object")
    print(f"{len(robot.joints)} joints, tool within {1e3 * found.position_error_m:.1f} mm")

    cell = Workcell(robot, geometry, margin_m=0.01)
    space = JointSpace(cell, found.joints)
    from_hand = np.linalg.norm(geometry.rest_positions - held, axis=1)
    node = int(np.abs(from_hand - 0.1).argmin())  # 10 cm from the hand
    goal = geometry.rest_positions[node] + 0.15 * along + [0.0, 0.0, 0.2]
    lift = Keypoints(nodes=[node], targets=[goal], name="goal")
    clear = cell.clearance(margin_m=0.04, weight=100.0)
    for costs, how in (([lift], "reaching alone"), ([lift, *clear], "keeping clear")):
        task = Task(twin=twin, costs=costs, space=space, frames=FRAMES)
        plan = Cem(task, knots=4, samples=24, iterations=4, sigma=0.3, correlation=0.5).plan()
        result = twin.rollout(
            **plan.actions(), costs=task.costs, returns=Returns(every_frames=8, forces=True)
        )
        away = dict(zip(result.cost_names, result.cost_terms[0], strict=True))["goal"]
        presses = max(contact.largest[0] for contact in cell.contacts(result).values())
        print(f"{how}: {1e3 * away:.0f} mm from the goal,", end=" ")
        print(f"the arm presses the object with {presses / weight:.1f} times its weight")

    path = space.path(plan)
    print(path.faults(robot) or "all limits are kept", f"over {path.times_s[-1]:.2f} s")

poses = robot.link_poses(path.positions)[:, :8, :3]  # Origins of the links up to the tool.
for i, frame in enumerate([0, *result.frames]):
    nodes = geometry.rest_positions if frame == 0 else result.positions[0, i - 1]
    side = (poses[frame] - held) @ along
    plt.plot(side, poses[frame, :, 2], "-", color=f"C{i}", linewidth=4, alpha=0.5)
    plt.scatter((nodes - held) @ along, nodes[:, 2], s=6, color=f"C{i}", label=f"frame {frame}")
plt.plot((goal - held) @ along, goal[2], "k+", markersize=12)
plt.legend()
plt.gca().set(aspect="equal", xlabel="along the object [m]", ylabel="z [m]")
plt.title("An arm lifts the object, seen from the side")
plt.savefig("arm.png", dpi=80)
