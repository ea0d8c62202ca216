"""The node's logic follows a simulated cable by clouds and grippers, against a real server."""

from __future__ import annotations

import numpy as np
import pytest
from server import needs_server

from bendtwin import Vary
from bendtwin_ros.logic import TwinNode
from bendtwin_ros.messages.basic import Header, JointState, Point, Pose, PoseStamped
from bendtwin_ros.messages.own import RegisterRequest
from bendtwin_ros.messages.shown import DiagnosticStatus, Marker
from bendtwin_ros.poses import SECOND, time_of, to_pose
from made_ros import CAMERA, STEP, Cable, FakeFrames, cloud_at

pytestmark = needs_server
LATENCY_NS = SECOND // 50


@pytest.fixture(scope="module")
def cable(server):
    return Cable(server.cable)


@pytest.fixture(scope="module")
def motion(cable):
    """The cable's skin, its nodes and their stamps: it is softer than its twin."""
    return cable.motion(12, Vary(stiffness=[0.7], bending=[0.5], damping=[0.7]))


@pytest.fixture
def start(server, cable):
    """Starts nodes, and ends them."""
    nodes = []

    def started(frames=None, **given):
        sent = []
        node = TwinNode(
            cable.settings(server.address, **given),
            frames or cable.frames(),
            lambda topic, message: sent.append((topic, message)),
        )
        nodes.append(node)
        return node, sent

    yield started
    for node in nodes:
        node.close()


def follow(node, cable, motion, only=None):
    """Errors of the nodes after each cloud, millimetres."""
    errors = []
    for skin, nodes, at in zip(*motion, strict=True):
        if only is None or at in only:
            node.on_cloud(cloud_at(cable.noisy(skin), at), at + LATENCY_NS)
        errors.append(1e3 * error(node, nodes))
    return np.array(errors)


def error(node, nodes):
    return np.linalg.norm(node.estimate.state.positions - nodes, axis=1).mean()


def verdict(node, sent, at_ns):
    node.report(at_ns)
    [status] = sent[-1][1].status
    return status


def test_clouds_keep_the_twin_at_its_object(start, cable, motion):
    node, sent = start()
    errors = follow(node, cable, motion)
    assert errors[3:].max() < 8.0, errors
    # Grippers alone do not.
    blind, _ = start(clock__max_gap_s=5.0)
    drift = follow(blind, cable, motion, only=[motion[2][0]])
    for at in motion[2][1:]:
        blind.tick(at + int(0.3 * SECOND))
    assert error(blind, motion[1][-1]) * 1e3 > 2.0 * errors[-1], drift
    status = verdict(node, sent, motion[2][-1])
    assert status.level == DiagnosticStatus.OK, status.message
    facts = {value.key: value.value for value in status.values}
    assert float(facts["latency [s]"]) > 0.02
    assert float(facts["misfit"]) < 1.0


def test_wrenches_bear_the_weight(start, cable, motion):
    node, sent = start(mass_kg=0.2, cloud__cell_m=0.001)
    follow(node, cable, motion)
    mean = {}
    for side in ("left", "right"):
        forces = [m.wrench.force for topic, m in sent if topic == f"~/wrench/{side}"]
        mean[side] = np.mean([[f.x, f.y, f.z] for f in forces], axis=0)
    total = mean["left"] + mean["right"]
    # The object pulls the grippers down, and towards one another.
    assert -2.0 * 0.2 * 9.81 < total[2] < -0.5 * 0.2 * 9.81
    assert mean["left"][0] > 0.0 > mean["right"][0]


def test_without_a_mass_there_are_no_wrenches(start, cable, motion):
    node, sent = start(mass_kg=0.0)
    follow(node, cable, [part[:3] for part in motion])
    topics = {topic for topic, _ in sent}
    assert topics == {"~/markers", "~/skin"}


def test_messages_out_of_order_are_counted_and_change_nothing(start, cable, motion):
    skins, nodes, stamps = motion
    node, sent = start()
    follow(node, cable, [part[:4] for part in motion])
    before = node.estimate
    node.on_cloud(cloud_at(skins[3], stamps[3]), stamps[3])
    node.on_cloud(cloud_at(skins[1], stamps[1]), stamps[3])
    node.on_cloud(cloud_at(skins[4], stamps[4] + 5 * SECOND), stamps[4])
    node.on_cloud(cloud_at(skins[4], stamps[4], frame="unknown"), stamps[4])
    node.on_cloud(cloud_at(skins[4], 0), stamps[4])
    assert node.estimate is before
    assert dict(node.status.counts) == {
        "cloud repeated": 1,
        "cloud late": 1,
        "cloud from the future": 1,
        "transform missing": 1,
        "cloud without stamp": 1,
    }
    assert verdict(node, sent, stamps[4]).level == DiagnosticStatus.WARN
    # A cloud in between was lost.
    node.on_cloud(cloud_at(skins[5], stamps[5]), stamps[5])
    assert error(node, nodes[5]) < 0.01


def test_a_bag_that_begins_anew_registers_again(start, cable, motion):
    node, _ = start(clock__max_gap_s=0.2)
    follow(node, cable, motion)
    errors = follow(node, cable, motion)
    assert node.status.counts["clock went back"] == 1
    assert errors.max() < 12.0


def test_after_a_gap_it_registers_near(start, cable, motion):
    node, _ = start(clock__max_gap_s=0.5)
    stamps = motion[2]
    errors = follow(node, cable, motion, only=[*stamps[:2], *stamps[8:]])
    assert node.status.counts["gap"] == 1
    assert errors[-1] < 8.0


def test_a_gripper_whose_pose_is_missing_keeps_its_last_one(start, cable, motion):
    frames = cable.frames()
    left, gone = frames.poses["left_tcp"], motion[2][6]
    frames.poses["left_tcp"] = lambda at: left(at) if at < gone else None
    node, sent = start(frames)
    follow(node, cable, motion)
    # Once for each of the clouds since, as every look-up may wait.
    assert node.status.counts["gripper pose missing"] == 7
    np.testing.assert_allclose(node.estimate.poses[0], left(gone - SECOND // 30), atol=0.01)
    status = verdict(node, sent, motion[2][-1])
    assert "gripper pose missing" in status.message


def test_a_pose_may_come_by_a_topic_in_any_order(start, cable, motion):
    node, _ = start(right__pose_topic="/right/pose")
    skins, nodes, stamps = (part[:6] for part in motion)
    frames = range(STEP * 5 + 1)
    times = [stamps[0] + round(k * SECOND / cable.fps) for k in frames]
    for at in [*times[1::2], *times[::2], times[0]]:
        pose = to_pose(cable.right(at))
        node.on_pose("right", PoseStamped(Header(time_of(at), "twin"), pose))
    node.on_pose("right", PoseStamped(Header(time_of(times[3]), "twin"), Pose(Point(np.nan))))
    errors = follow(node, cable, [skins, nodes, stamps])
    assert errors[-1] < 8.0
    np.testing.assert_allclose(node.estimate.poses[1], cable.right(stamps[-1]), atol=1e-6)
    assert dict(node.status.counts) == {"gripper pose repeated": 1, "gripper pose invalid": 1}


def test_a_gripper_that_opens_lets_go(start, cable, motion):
    node, _ = start(right__joints=["finger"], right__closed_below_m=0.02)
    skins, _, stamps = (part[:8] for part in motion)
    for k, (skin, at) in enumerate(zip(skins, stamps, strict=True)):
        width = 0.01 if k < 3 else 0.06
        node.on_joints(JointState(Header(time_of(at)), ["finger", "other"], [width, 9.0]))
        if k < 3:
            node.on_cloud(cloud_at(skin, at), at)
    held = node.estimate.state.positions[-1]
    node.tick(stamps[-1] + int(0.3 * SECOND))
    fallen = node.estimate.state.positions[-1]
    assert fallen[2] < held[2] - 0.05
    assert not np.any(node.estimate.wrenches[1])


def test_a_lost_object_is_told_and_found_again(start, cable, motion):
    skins, nodes, stamps = motion
    node, sent = start()
    follow(node, cable, [part[:3] for part in motion])
    for k in range(3, 9):
        node.on_cloud(cloud_at(skins[k] + [3.0, 0, 0], stamps[k]), stamps[k])
    assert node.status.counts["cloud not explained"] == 6
    status = verdict(node, sent, stamps[8])
    assert status.level == DiagnosticStatus.ERROR
    assert "lost" in status.message
    for k in range(9, 13):
        node.on_cloud(cloud_at(skins[k], stamps[k]), stamps[k])
    assert not node.status.lost
    assert error(node, nodes[12]) < 0.02


def test_what_is_shown_lies_where_the_object_is(start, cable, motion):
    node, sent = start(cloud__low=[-1, -1, -1], cloud__high=[1, 1, 1])
    skins = motion[0] * 1.0
    far = np.concatenate([skins[0], np.full((500, 3), 2.0)])
    node.on_cloud(cloud_at(far, motion[2][0]), motion[2][0])
    [markers] = [message for topic, message in sent if topic == "~/markers"]
    assert markers.markers[0].type in (Marker.LINE_STRIP, Marker.TRIANGLE_LIST)
    points = np.array([[p.x, p.y, p.z] for p in markers.markers[0].points])
    away = np.linalg.norm(points[:, None] - skins[0], axis=2).min(axis=1)
    assert away.max() < 0.05
    node.reset()
    node.tick(motion[2][0] + SECOND)
    assert sent[-1][1].markers[0].action == Marker.DELETEALL


@pytest.mark.parametrize("begin", ["settled", "rest"])
def test_it_may_start_without_a_registration(start, cable, motion, begin):
    node, _ = start(start=begin)
    follow(node, cable, [part[:2] for part in motion])
    assert node.estimate is not None
    assert node.status.follows


def test_registration_is_also_a_service(start, cable, motion):
    skins, nodes, stamps = motion
    node, _ = start()
    response = node.register(RegisterRequest(cloud_at(skins[4], stamps[4])), stamps[4])
    assert response.success, response.message
    assert response.explained_points > 0.9
    assert error(node, nodes[4]) < 0.02
    again = node.register(RegisterRequest(cloud_at(skins[5], stamps[5]), near=True), stamps[5])
    assert again.median_mm < 5.0
    scattered = np.random.default_rng(0).uniform(-1, 1, (60, 3))
    refused = node.register(RegisterRequest(cloud_at(scattered, stamps[6])), stamps[6])
    assert not refused.success
    assert "points" in refused.message


def test_a_robot_without_grippers_only_looks(start, cable, motion, server):
    node, _ = start(FakeFrames({"camera": CAMERA}), grippers=[""])
    follow(node, cable, [part[:3] for part in motion])
    assert node.status.follows
    node, sent = start(left__hand=7)
    node.on_cloud(cloud_at(motion[0][0], motion[2][0]), motion[2][0])
    assert "left.hand is 7" in verdict(node, sent, motion[2][0]).message
