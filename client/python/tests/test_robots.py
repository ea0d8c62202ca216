"""Kinematics of robots: against MuJoCo, against finite differences, and back from poses."""

import re

import numpy as np
import pytest

from bendtwin.robots import EXAMPLE_URDF, Limits, Robot, RobotError
from bendtwin.rotations import exponential, product

BASE = [0.1, -0.2, 0.3, 0.1, 0.2, 0.3, 0.9]

#: Axes that lean, a prismatic joint in the middle, mimics of each other, and a branch.
ODD = """
<robot name="odd">
  <link name="root"/><link name="a"/><link name="b"/>
  <link name="c"/><link name="d"/><link name="e"/>
  <joint name="ja" type="continuous"><parent link="root"/><child link="a"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 0.6"/><axis xyz="1 2 -1"/></joint>
  <joint name="jb" type="prismatic"><parent link="a"/><child link="b"/>
    <origin xyz="0 0.1 0" rpy="1 0 2"/><axis xyz="0 3 4"/>
    <limit lower="-0.2" upper="0.3" velocity="0.5"/></joint>
  <joint name="jc" type="revolute"><parent link="b"/><child link="c"/>
    <origin xyz="0.2 0 0.1"/><axis xyz="0 0 -1"/><limit lower="0.1" upper="2" velocity="1"/></joint>
  <joint name="jd" type="revolute"><parent link="a"/><child link="d"/>
    <origin rpy="0 1 0" xyz="0.3 0 0"/><axis xyz="0 1 0"/><limit lower="-9" upper="9"/>
    <mimic joint="jc" multiplier="-2" offset="0.3"/></joint>
  <joint name="je" type="revolute"><parent link="c"/><child link="e"/>
    <origin xyz="0 0 0.2"/><limit lower="-9" upper="9"/>
    <mimic joint="jd" multiplier="0.5" offset="0.1"/></joint>
</robot>
"""


def example(**settings):
    return Robot.from_urdf(EXAMPLE_URDF, tip="tool", **settings)


def within_limits(robot, count, seed=0):
    low, high = np.maximum(robot.low, -3.0), np.minimum(robot.high, 3.0)
    return np.random.default_rng(seed).uniform(low, high, (count, len(robot.joints)))


def odd():
    return Robot.from_urdf(ODD, tip=["d", "e"], base_pose=BASE)


@pytest.mark.parametrize("make", [example, odd], ids=["example", "odd"])
def test_link_poses_are_those_of_mujoco(make):
    mujoco = pytest.importorskip("mujoco")
    robot = make()
    text = EXAMPLE_URDF.read_text() if make is example else ODD
    # It would merge links on fixed joints, and wants every moving link to have a mass.
    text = text.replace("</robot>", '<mujoco><compiler fusestatic="false"/></mujoco></robot>')
    about = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'
    mass = f'<inertial><mass value="1"/><inertia {about}/></inertial>'
    text = re.sub(r'<link name="(\w+)"/>', rf'<link name="\1">{mass}</link>', text)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for joints in within_limits(robot, 20):
        for name, position in positions_by_name(robot, joints).items():
            data.qpos[model.joint(name).qposadr[0]] = position
        mujoco.mj_kinematics(model, data)
        poses = robot.link_poses(joints)
        for link, pose in zip(robot.links, poses, strict=True):
            there = data.body(link)
            seen = np.concatenate([there.xpos, there.xquat[[1, 2, 3, 0]]])
            expected = composed(robot.base_pose, seen)
            np.testing.assert_allclose(pose[:3], expected[:3], atol=1e-9, err_msg=link)
            assert abs(pose[3:] @ expected[3:]) == pytest.approx(1.0, abs=1e-9), link


def positions_by_name(robot, joints):
    """All joints of the two descriptions, with those that mimic."""
    named = dict(zip(robot.joint_names, joints, strict=True))
    if "grip" in named:
        return named | {"grip_too": named["grip"]}
    named["jd"] = 0.3 - 2.0 * named["jc"]
    return named | {"je": 0.1 + 0.5 * named["jd"]}


def composed(outer, inner):
    axis, w = outer[3:6], outer[6]
    turned = inner[:3] + 2 * np.cross(axis, np.cross(axis, inner[:3]) + w * inner[:3])
    return np.concatenate([outer[:3] + turned, product(outer[3:], inner[3:])])


@pytest.mark.parametrize("make", [example, odd], ids=["example", "odd"])
def test_jacobians_and_gradients_agree_with_finite_differences(make):
    robot = make()
    joints = within_limits(robot, 3, seed=1).reshape(3, 1, -1)
    poses = robot.link_poses(joints)
    weights = np.random.default_rng(2).normal(size=poses.shape)
    gradient = robot.gradients(poses, weights)
    step = 1e-6
    for j in range(len(robot.joints)):
        unit = step * np.eye(len(robot.joints))[j]
        there, back = robot.link_poses(joints + unit), robot.link_poses(joints - unit)
        slope = (there - back) / (2 * step)
        by_hand = (slope * weights).sum(axis=(2, 3))
        np.testing.assert_allclose(gradient[..., j], by_hand, atol=1e-6)
        for i, link in enumerate(robot.links):
            column = robot.jacobian(joints, link)[..., j]
            np.testing.assert_allclose(column[..., :3], slope[:, :, i, :3], atol=1e-6)
            back_turn = poses[:, :, i, 3:] * [-1, -1, -1, 1]
            turn = 2.0 * product(slope[:, :, i, 3:], back_turn)[..., :3]
            np.testing.assert_allclose(column[..., 3:], turn, atol=1e-6)


def test_poses_come_in_the_shape_of_joints():
    robot = odd()
    assert robot.link_poses(np.full(3, 0.1)).shape == (6, 7)
    assert robot.link_poses(np.zeros((2, 5, 3))).shape == (2, 5, 6, 7)
    assert robot.tip_poses(np.zeros((2, 5, 3))).shape == (2, 5, 2, 7)
    assert robot.jacobian(np.zeros((2, 5, 3))).shape == (2, 5, 6, 3)
    np.testing.assert_allclose(robot.link_poses(np.zeros(3))[0, :3], BASE[:3])


def test_joints_have_the_limits_of_the_description():
    robot = odd()
    assert robot.joint_names == ("ja", "jb", "jc")
    assert robot.joints[0].limits == Limits()
    assert robot.joints[1].limits == Limits(low=-0.2, high=0.3, speed=0.5)
    np.testing.assert_allclose(robot.positions({"ja": 0.7}), [0.7, 0.0, 1.05])
    wider = Robot.from_urdf(ODD, tip="e", limits={"jb": Limits(low=-1, high=1, speed=2)})
    assert wider.high[1] == 1.0
    with pytest.raises(RobotError, match="no joint 'jd' moves by itself"):
        robot.positions({"jd": 1.0})
    with pytest.raises(RobotError, match="'nowhere'"):
        Robot.from_urdf(ODD, tip="e", limits={"nowhere": Limits()})


def test_a_path_of_poses_is_followed_and_found_again():
    robot = example()
    first = robot.positions({"lift": 0.5, "elbow": 1.2, "pitch": 0.6})
    way = np.linspace(0.0, 1.0, 7)[:, None] * np.array([0.4, 0.2, -0.4, 0.3, 0.3, -0.2, 0.0])
    poses = robot.tip_poses(first + way)
    found = robot.inverse(np.stack([poses, poses]), start=first + 0.05)
    assert found.joints.shape == (2, 7, 7)
    assert found.reached.all()
    assert found.position_error_m.max() < 1e-4
    np.testing.assert_allclose(robot.tip_poses(found.joints)[0], poses, atol=2e-3)
    assert np.abs(np.diff(found.joints, axis=1)).max() < 0.4, "it does not jump"
    assert (found.joints >= robot.low).all()
    assert (found.joints <= robot.high).all()
    again = robot.inverse(np.stack([poses, poses]), start=first + 0.05)
    np.testing.assert_array_equal(found.joints, again.joints)


def test_two_tips_are_brought_to_their_poses_together():
    robot = odd()
    joints = np.array([0.5, 0.1, 0.8])
    found = robot.inverse(robot.tip_poses(joints), start=[0.2, 0.0, 1.0])
    assert found.reached
    np.testing.assert_allclose(found.joints, joints, atol=1e-2)


def test_what_cannot_be_reached_is_reported():
    robot = example()
    start = robot.positions({"elbow": 1.0})
    far = robot.tip_poses(start)
    far[0, :3] = [3.0, 0.0, 0.5]
    found = robot.inverse(far, start, restarts=2, iterations=50)
    assert not found.reached
    # The arm is stretched out towards it.
    assert found.position_error_m == pytest.approx(3.0 - 0.85, abs=0.15)
    positions_alone = robot.tip_poses(start)
    positions_alone[0, 3:] = exponential(np.array([0.0, 3.0, 0.0]))
    assert robot.inverse(positions_alone, start, rotation_weight=0.0).reached


@pytest.mark.parametrize(
    ("call", "fault"),
    [
        (lambda r: r.link_poses(np.zeros(3)), "in the order turn, lift"),
        (lambda r: r.link_poses(np.full(7, np.nan)), "finite"),
        (lambda r: r.jacobian(np.zeros(7), "elbow"), "no link 'elbow'"),
        (lambda r: r.inverse(np.zeros((2, 7)), np.zeros(7)), r"poses \[1, 7\]"),
        (lambda r: r.inverse(np.zeros((1, 7)), np.zeros(7)), "quaternion of zeros"),
        (lambda r: r.inverse(r.tip_poses(np.zeros(7)), np.zeros((1, 7))), "start has shape"),
    ],
)
def test_wrong_shapes_are_refused(call, fault):
    with pytest.raises(ValueError, match=fault):
        call(example())
