"""The action's logic: goals become waypoints among obstacles, against a real server."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from server import needs_server

from bendtwin import Returns
from bendtwin_ros.logic import TwinNode
from bendtwin_ros.messages.basic import Header, Point, Pose
from bendtwin_ros.messages.own import PlanGoal
from bendtwin_ros.messages.scene import (
    CollisionObject,
    PlanningScene,
    PlanningSceneWorld,
    SolidPrimitive,
)
from bendtwin_ros.poses import SECOND, applied, inverse, nanoseconds, of_pose, to_points
from made_ros import CAMERA, Cable, cloud_at

pytestmark = needs_server
TIP = 6
WAY = np.array([0.06, 0.08, 0.05])


@pytest.fixture(scope="module")
def cable(server):
    return Cable(server.cable)


@pytest.fixture(scope="module")
def node(server, cable):
    skins, _, stamps = cable.motion(5)
    settings = cable.settings(
        server.address, plan__samples=24, plan__iterations=4, plan__deadline_s=120.0
    )
    node = TwinNode(settings, cable.frames(), lambda *_: None)
    for skin, at in zip(skins, stamps, strict=True):
        node.on_cloud(cloud_at(skin, at), at)
    yield node
    node.close()


def goal_of(node, **more):
    target = node.estimate.state.positions[TIP] + WAY
    goal = PlanGoal(nodes=[TIP], targets=to_points(target[None]), horizon_s=0.8)
    for name, value in more.items():
        setattr(goal, name, value)
    return goal


def planned(node, goal, cancelled=lambda: False):
    feedback = []
    result = node.plan(goal, cancelled, feedback.append)
    return result, feedback


def test_waypoints_bring_the_object_to_its_target(node, cable):
    goal = goal_of(node)
    result, feedback = planned(node, goal)
    assert result.success, result.message
    assert result.cost < 0.5 * result.nominal_cost
    assert [one.iterations for one in feedback][:4] == [1, 2, 3, 4]
    assert feedback[-1].cost == result.cost
    left, right = result.paths
    assert (left.gripper, right.gripper) == ("left_tcp", "right_tcp")
    assert left.closed
    times = [nanoseconds(time) / 1e9 for time in left.times_from_start]
    np.testing.assert_allclose(times, np.linspace(0, 0.8, 6), atol=1e-6)
    poses = np.stack([[of_pose(p) for p in path.waypoints.poses] for path in (left, right)], 1)
    np.testing.assert_allclose(poses[0], node.estimate.poses, atol=1e-5)
    assert np.abs(np.diff(poses[..., :3], axis=0)).max() <= 0.25 * 0.16 + 1e-5
    # The same motion, executed.
    done = cable.twin.rollout(
        poses=poses[None],
        gripper_of_control=cable.geometry.hands,
        frames=24,
        initial=node.estimate.state,
        returns=Returns(final_state=True),
    )
    target = np.array([goal.targets[0].x, goal.targets[0].y, goal.targets[0].z])
    reached = np.linalg.norm(done.final_positions[0, TIP] - target)
    assert reached < 0.6 * np.linalg.norm(WAY)


def test_the_same_seed_gives_the_same_plan(node):
    goals = [goal_of(node, seed=seed, iterations=2) for seed in (3, 3, 4)]
    first, same, other = (planned(node, goal)[0].paths[0] for goal in goals)
    assert first == same
    assert first != other


def test_targets_of_the_skin_and_clouds_in_other_frames(node, cable):
    skin = cable.geometry.skin.positions(node.estimate.state.positions) + WAY
    seen = applied(inverse(CAMERA), skin)
    by_points = PlanGoal(header=Header(frame_id="camera"), skin_points=[4, 20], horizon_s=0.8)
    by_points.targets = to_points(seen[[4, 20]])
    by_cloud = PlanGoal(target_cloud=cloud_at(skin, 1), horizon_s=0.8)
    for goal in (by_points, by_cloud):
        result, _ = planned(node, goal)
        assert result.success, result.message
        assert result.cost < 0.7 * result.nominal_cost
    # Of standing still: the target is that far away.
    result, _ = planned(node, by_points)
    assert result.nominal_cost > 0.03


def test_one_gripper_may_move_alone(node):
    result, _ = planned(node, goal_of(node, grippers=["right_tcp"], hull=PlanGoal.HULL_ATTACHED))
    assert [path.gripper for path in result.paths] == ["right_tcp"]
    assert result.attached_hulls[0].link_name == "right_tcp"


def wall_of(node, at):
    wall = CollisionObject(Header(frame_id="twin"), Pose(Point(*at)), "wall")
    wall.primitives = [SolidPrimitive(SolidPrimitive.BOX, [0.6, 0.02, 1.0])]
    wall.primitive_poses = [Pose()]
    return PlanningScene("", PlanningSceneWorld([wall]), True)


def farthest(result):
    """The largest y that the object reaches."""
    return max(p.y for hull in result.hulls for p in hull.meshes[0].vertices)


def test_obstacles_of_the_scene_are_in_the_way(node):
    at = node.estimate.state.positions[TIP].copy()
    at[1] = node.estimate.state.positions[:, 1].max() + 0.03
    goal = goal_of(node, targets=to_points((at + np.array([0.0, 0.06, 0.0]))[None]))
    goal.iterations, goal.hull = 2, PlanGoal.HULL_WORLD
    free, _ = planned(node, goal)
    goal.scene = wall_of(node, at.tolist())
    blocked, _ = planned(node, goal)
    assert blocked.success, blocked.message
    assert farthest(blocked) < at[1] < farthest(free)
    # The same as a scene that MoveIt publishes.
    goal.scene = PlanningScene(is_diff=True)
    node.on_scene(wall_of(node, at.tolist()))
    known, _ = planned(node, goal)
    assert known.cost == pytest.approx(blocked.cost)
    # One in which a gripper already is.
    goal.scene = wall_of(node, node.estimate.poses[0][:3].tolist())
    inside, _ = planned(node, goal)
    assert inside.success or "wall" in inside.message
    node.on_scene(PlanningScene())


def test_swept_hulls_contain_the_motion(node, cable):
    result, _ = planned(node, goal_of(node, hull=PlanGoal.HULL_WORLD, hulls=4))
    assert len(result.hulls) == 4
    assert all(hull.header.frame_id == "twin" for hull in result.hulls)
    corners = np.concatenate(
        [[[p.x, p.y, p.z] for p in h.meshes[0].vertices] for h in result.hulls]
    )
    skin = cable.geometry.skin.positions(node.estimate.state.positions)
    assert (skin.min(axis=0) > corners.min(axis=0) - 0.02).all()
    assert (corners.max(axis=0) < skin.max(axis=0) + np.abs(WAY) + 0.2).all()
    carried, _ = planned(node, goal_of(node, hull=PlanGoal.HULL_ATTACHED, touch_links=["finger"]))
    [attached] = carried.attached_hulls
    assert attached.link_name == attached.object.header.frame_id == "left_tcp"
    assert attached.touch_links == ["finger"]
    near = np.array([[p.x, p.y, p.z] for p in attached.object.meshes[0].vertices])
    # What the gripper holds is at its origin.
    assert np.linalg.norm(near, axis=1).min() < 0.05


def test_a_plan_is_cancelled_and_another_one_has_to_wait(node, cable):
    begun, go_on = threading.Event(), threading.Event()

    def wait(_):
        begun.set()
        assert go_on.wait(30)

    results = []
    goal = goal_of(node, iterations=100)
    thread = threading.Thread(
        target=lambda: results.append(node.plan(goal, go_on.is_set, wait)), daemon=True
    )
    thread.start()
    assert begun.wait(30)
    assert planned(node, goal_of(node))[0].reason == "BUSY"
    # The twin follows meanwhile.
    before = node.estimate
    skin = cable.geometry.skin.positions(before.state.positions)
    node.on_cloud(cloud_at(skin, before.at_ns + SECOND // 10), before.at_ns + SECOND // 10)
    assert node.estimate.at_ns > before.at_ns
    go_on.set()
    thread.join(30)
    assert results[0].reason == "CANCELLED"
    assert planned(node, goal_of(node, iterations=1))[0].success


def test_a_deadline_ends_the_search_with_its_best_plan(node):
    result, feedback = planned(node, goal_of(node, iterations=1000, deadline_s=0.2))
    assert result.success
    assert 1 <= feedback[-1].iterations < 1000


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"nodes": [], "targets": []}, "no target"),
        ({"nodes": [1, 2]}, "1 targets for 2 points"),
        ({"nodes": [10**9]}, "numbered from 0 to 11"),
        ({"skin_points": [1]}, "not for both"),
        ({"targets": [Point(float("nan"), 0.0, 0.0)]}, "not finite"),
        ({"horizon_s": -1.0}, "horizon_s"),
        ({"horizon_s": float("inf")}, "horizon_s"),
        ({"horizon_s": 1e9}, "at most 10"),
        ({"deadline_s": 121.0}, "deadline_s"),
        ({"samples": 10**6}, "samples"),
        ({"knots": 1}, "knots"),
        ({"grippers": ["third"]}, "no gripper 'third'"),
        ({"header": Header(frame_id="moon")}, "moon"),
        ({"scene": PlanningScene("", PlanningSceneWorld([CollisionObject(id="x")]))}, "``"),
    ],
)
def test_a_goal_that_is_none_is_refused_with_what_to_change(node, change, said):
    result, feedback = planned(node, goal_of(node, **change))
    assert not result.success
    assert result.reason in ("INVALID_GOAL", "INVALID_ROLLOUT", "INVALID_PLAN")
    assert said in result.message
    assert not feedback
