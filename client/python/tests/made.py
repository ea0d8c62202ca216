"""Twins by hand at a real server, ready without a fit."""

from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
from scenes import dragged, twin_file
from server import running

from bendtwin import Client, Returns
from bendtwin.robots import EXAMPLE_URDF, Robot


@contextmanager
def sheet_at_rest(folder):
    """A sheet that two control points of one hand hold by its edge; most lies on the ground."""
    file, _ = dragged()
    (folder / "sheet.twin").write_bytes(file.encode())
    with running(folder) as address, Client(address) as client:
        twin = client.import_twin(folder / "sheet.twin")
        hold = np.repeat(twin.geometry().controls[None, None], 2, axis=1)
        end = twin.rollout(trajectories=hold, frames=20, returns=Returns(final_state=True))
        yield SimpleNamespace(client=client, twin=twin, hold=hold, start=end.state(0))


def rope_file():
    """A rope along x on the ground, 0.38 m long, whose first two nodes a hand holds."""
    count = 20
    nodes = np.stack([0.02 * np.arange(count), np.zeros(count), np.full(count, 0.005)], axis=1)
    springs = [[a, b] for a in range(count) for b in range(max(0, a - 2), a)]
    triplets = [[a, a + 1, a + 2] for a in range(count - 2)]
    return twin_file(nodes, springs, nodes[:1], triplets=triplets, pins=[[0, 0], [1, 0]])


@contextmanager
def rope_and_arm(folder):
    """The rope at rest, and the example arm behind its held end, whose tool holds it there."""
    (folder / "rope.twin").write_bytes(rope_file().encode())
    with running(folder) as address, Client(address) as client:
        twin = client.import_twin(folder / "rope.twin")
        controls = twin.geometry().controls
        hold = np.repeat(controls[None, None], 2, axis=1)
        end = twin.rollout(trajectories=hold, frames=20, returns=Returns(final_state=True))
        robot = Robot.from_urdf(EXAMPLE_URDF, tip="tool", base_pose=[-0.35, 0, 0, 0, 0, 0, 1])
        # The tool points down.
        wanted = [[*controls[0], 0, 1, 0, 0]]
        found = robot.inverse(wanted, robot.positions({"lift": 0.6, "elbow": 1.2, "pitch": 1.2}))
        assert found.reached
        yield SimpleNamespace(
            client=client, twin=twin, start=end.state(0), robot=robot, joints=found.joints
        )
