"""Messages of random content never crash the node, and what follows them works."""

from __future__ import annotations

import numpy as np
import pytest
from server import needs_server

from bendtwin_ros.logic import TwinNode
from bendtwin_ros.messages.basic import (
    Header,
    JointState,
    Point,
    PointCloud2,
    PointField,
    Pose,
    PoseStamped,
    Quaternion,
    Time,
)
from bendtwin_ros.messages.own import PlanGoal, RegisterRequest
from bendtwin_ros.messages.scene import (
    CollisionObject,
    Mesh,
    MeshTriangle,
    Plane,
    PlanningScene,
    PlanningSceneWorld,
    SolidPrimitive,
)
from bendtwin_ros.poses import SECOND, nanoseconds
from made_ros import START_NS, Cable, cloud_at

pytestmark = needs_server
ROUNDS = 60


class Random:
    """Messages that are allowed by their types and by nothing else."""

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)

    def some(self, *values):
        return values[self.random.integers(len(values))]

    def number(self):
        return self.some(
            0.0, 1.0, -1.0, 1e-320, 1e308, float("nan"), float("inf"), self.random.normal()
        )

    def integer(self, most=2**32 - 1):
        return int(self.some(0, 1, 2, 3, 12, most, self.random.integers(most)))

    def header(self):
        stamp = Time(int(self.some(0, -5, 2**31 - 1, 1000, 1001)), self.integer(999_999_999))
        return Header(
            stamp, self.some("", "camera", "twin", "left_tcp", "nowhere", "\0", "é" * 1000)
        )

    def pose(self):
        at = Point(*(self.number() for _ in range(3)))
        return Pose(at, Quaternion(*(self.number() for _ in range(4))))

    def cloud(self):
        names = [self.some("x", "y", "z", "rgb", "") for _ in range(self.integer(5))]
        if self.random.random() < 0.5:
            names = ["x", "y", "z"]
        small = self.random.random() < 0.7
        size = self.integer(8) if small else self.integer()
        width = self.integer(40) if small else self.integer()
        return PointCloud2(
            self.header(),
            self.integer(3),
            width,
            [
                PointField(
                    n, self.some(4 * i, self.integer()), self.some(7, 7, 8, self.integer(255))
                )
                for i, n in enumerate(names[:20])
            ],
            bool(self.random.integers(2)),
            self.some(12, 16, size),
            self.some(12 * min(width, 10**6), self.integer()),
            self.random.bytes(int(self.random.integers(2000))),
        )

    def scene(self):
        def solids(make):
            return [make() for _ in range(self.random.integers(3))]

        one = CollisionObject(
            self.header(),
            self.pose(),
            self.some("a", "b", ""),
            solids(
                lambda: SolidPrimitive(
                    self.integer(6), [self.number() for _ in range(self.random.integers(4))]
                )
            ),
            solids(self.pose),
            solids(
                lambda: Mesh(
                    [MeshTriangle([self.integer(5) for _ in range(3)])] * self.integer(3),
                    [self.pose().position for _ in range(self.random.integers(6))],
                )
            ),
            solids(self.pose),
            solids(lambda: Plane([self.number() for _ in range(4)])),
            solids(self.pose),
            bytes([self.integer(4)]),
        )
        return PlanningScene("", PlanningSceneWorld([one]), bool(self.random.integers(2)))

    def goal(self):
        """A goal that is possible, but for at most two of its fields."""
        goal = PlanGoal(nodes=[3], targets=[Point(0.1, 0.1, 0.3)], horizon_s=0.1)
        goal.samples, goal.iterations, goal.deadline_s = 4, 2, 0.5
        others = {
            "header": self.header(),
            "nodes": [self.integer()],
            "skin_points": [self.integer(30)],
            "targets": [self.pose().position],
            "target_cloud": self.cloud(),
            "horizon_s": self.number(),
            "knots": self.integer(),
            "samples": self.some(0, self.integer()),
            "seed": self.integer(),
            "grippers": ["x"],
            "scene": self.scene(),
            "hull": self.some(1, 2, 9),
            "hulls": self.integer(),
        }
        for name in self.random.permutation(list(others))[: self.random.integers(3)]:
            setattr(goal, name, others[name])
        return goal


@pytest.mark.parametrize("seed", [0, 1])
def test_random_messages_never_crash_the_node(server, seed):
    cable, random = Cable(server.cable), Random(seed)
    settings = cable.settings(server.address, right__pose_topic="/right", right__joints=["a"])
    node = TwinNode(settings, cable.frames(), lambda *_: None)
    skins, _, stamps = cable.motion(4)
    node.on_cloud(cloud_at(skins[0], stamps[0]), stamps[0])
    reasons = []
    for _ in range(ROUNDS):
        now_ns = START_NS + random.integer(2 * SECOND)
        cloud = random.cloud()
        node.on_cloud(cloud, random.some(now_ns, nanoseconds(cloud.header.stamp)))
        names, positions = [random.some("a", "b") for _ in range(3)], [random.number()] * 2
        node.on_joints(JointState(random.header(), names, positions))
        node.on_pose(random.some("right", "left", ""), PoseStamped(random.header(), random.pose()))
        node.on_scene(random.some(PlanningScene(), random.scene()))
        if random.random.random() < 0.3:
            node.tick(now_ns)
            node.register(RegisterRequest(random.cloud(), True), now_ns)
            reasons.append(node.plan(random.goal(), lambda: False, lambda _: None).reason)
        node.report(now_ns)
    assert sum(node.status.counts.values()) > ROUNDS // 2
    assert {"", "INVALID_GOAL"} <= set(reasons)
    node.reset()
    for skin, at in zip(skins, stamps, strict=True):
        node.on_cloud(cloud_at(skin, at), at)
    assert node.status.follows, node.status
    node.close()
