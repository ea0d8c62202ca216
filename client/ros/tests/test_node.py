"""The node of rclpy, with a rclpy and messages of the tests' own, against a real server."""

from __future__ import annotations

import importlib
import sys

import numpy as np
import pytest
from server import needs_server

import fake_rclpy
from bendtwin_ros import convert
from bendtwin_ros.messages import basic, own
from bendtwin_ros.messages.basic import Point
from bendtwin_ros.poses import SECOND
from made_ros import CAMERA, Cable, cloud_at

pytestmark = needs_server


@pytest.fixture(scope="module")
def ros():
    """The module of the node, among fake modules of ROS."""
    with pytest.MonkeyPatch.context() as patch:
        fake_rclpy.install(patch)
        convert.ros_class.cache_clear()
        yield importlib.import_module("bendtwin_ros.node")
        sys.modules.pop("bendtwin_ros.node")
        convert.ros_class.cache_clear()


@pytest.fixture
def cable(server):
    return Cable(server.cable)


@pytest.fixture
def node(ros, cable, server, monkeypatch):
    values = dict(cable.settings(server.address).values)
    given = {k: v for k, v in values.items() if v != [""]} | {"parent_frame": "world"}
    for name, hand in (("left", 0), ("right", 1)):
        given |= {f"{name}.frame": f"{name}_tcp", f"{name}.hand": hand}
    known = {("twin", "camera"): CAMERA, ("twin", "left_tcp"): cable.left}
    known["twin", "right_tcp"] = cable.right
    monkeypatch.setattr(fake_rclpy.Node, "given", given)
    monkeypatch.setattr(fake_rclpy.Buffer, "known", known)
    node = ros.BendTwinNode()
    yield node
    node.close()


def arrive(node, cable, steps):
    skins, nodes, stamps = cable.motion(steps)
    for skin, at in zip(skins, stamps, strict=True):
        node.now_ns = at + SECOND // 100
        node.send("cloud", convert.to_ros(cloud_at(cable.noisy(skin), at)))
    return nodes[-1]


def test_clouds_arrive_and_the_twin_is_published(node, cable):
    where = arrive(node, cable, 4)
    [transform] = node.published["/tf_static"]
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "twin")
    shown = convert.from_ros(basic.PointCloud2, node.published["~/skin"][-1])
    skin = cable.geometry.skin.positions(where)
    points = np.frombuffer(shown.data, "<f4").reshape(-1, 3)
    assert np.linalg.norm(points - skin, axis=1).mean() < 0.005
    assert node.published["~/markers"][-1].markers[0].points
    left, right = (node.published[f"~/wrench/{side}"][-1] for side in ("left", "right"))
    assert left.header.frame_id == "left_tcp"
    assert left.wrench.force.z + right.wrench.force.z < 0.0
    for _, tick in node.timers_of:
        tick()
    [status] = node.published["/diagnostics"][-1].status
    assert status.level == b"\0", status.message
    assert {value.key: value.value for value in status.values}["follows"] == "True"


def test_an_action_ends_in_waypoints_or_is_cancelled(node, cable):
    arrive(node, cable, 2)
    server = fake_rclpy.ActionServer.last
    tip = node.twin_node.estimate.state.positions[6] + np.array([0.05, 0.05, 0.03])
    goal = own.PlanGoal(nodes=[6], targets=[Point(*tip.tolist())], horizon_s=0.5)
    goal.samples, goal.iterations, goal.hull = 16, 3, own.PlanGoal.HULL_WORLD
    ended, result, feedback = server.send(convert.to_ros(goal))
    assert ended == "succeeded", result.message
    assert result.cost < result.nominal_cost
    assert [one.iterations for one in feedback[:3]] == [1, 2, 3]
    assert len(result.paths) == 2
    assert result.hulls[0].meshes[0].triangles
    ended, result, feedback = server.send(convert.to_ros(goal), cancel_after=1)
    assert (ended, result.reason, len(feedback)) == ("canceled", "CANCELLED", 1)
    goal.nodes = [10**6]
    ended, result, _ = server.send(convert.to_ros(goal))
    assert (ended, result.reason) == ("aborted", "INVALID_GOAL")


def test_services_register_and_reset(node, cable):
    skins, _, stamps = cable.motion(1)
    trigger = sys.modules["std_srvs.srv"].Trigger
    register = sys.modules["bendtwin_msgs.srv"].Register
    node.now_ns = stamps[0]
    request = register.Request(cloud=convert.to_ros(cloud_at(skins[0], stamps[0])))
    response = node.call("~/register", request)
    assert response.success, response.message
    assert response.median_mm < 5.0
    assert node.call("~/reset", trigger.Request()).success
    assert node.twin_node.estimate is None
    response = node.call("~/register", register.Request())
    assert "stamp" in response.message


def test_messages_of_topics_reach_the_logic(node):
    msg = sys.modules["moveit_msgs.msg"]
    node.send("planning_scene", msg.PlanningScene())
    joints = sys.modules["sensor_msgs.msg"].JointState
    node.send("joint_states", joints(name=["a"], position=[0.1]))
    assert not node.twin_node.status.counts


def test_a_wrong_parameter_ends_the_program_with_its_name(ros, capsys, monkeypatch):
    for value, said in (("", "twin is ''"), (3, "'twin' of type str")):
        monkeypatch.setattr(fake_rclpy.Node, "given", {"twin": value})
        assert ros.main() == 2
        assert said in capsys.readouterr().err


def test_the_program_ends_with_ros(ros, node):
    assert ros.main() == 0


def test_every_dataclass_becomes_its_message_and_comes_back(ros):
    from bendtwin_ros.messages import scene, shown

    checked = 0
    for module in (basic, own, scene, shown):
        for cls in vars(module).values():
            if getattr(cls, "__module__", "") == module.__name__:
                assert convert.from_ros(cls, convert.to_ros(cls())) == cls()
                checked += 1
    assert checked > 30
