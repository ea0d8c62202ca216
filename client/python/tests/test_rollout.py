from dataclasses import replace

import numpy as np
import pytest
from fake import TWIN, tensor

from bendtwin import (
    CaptureFrame,
    Clearance,
    ControlPath,
    ControlSpeed,
    Coverage,
    Cuboid,
    Force,
    GivenState,
    Height,
    Keypoints,
    Order,
    Plane,
    Returns,
    RolloutResult,
    Smoothness,
    Strain,
    TargetCloud,
    Winding,
    Within,
)
from bendtwin.planners import Cem, Grippers, Mppi, Task, Together
from bendtwin.v1 import rollout_pb2


@pytest.fixture
def twin(client):
    return client.twin(TWIN)


def actions(batch, knots=4, controls=1):
    values = np.arange(batch * knots * controls * 3, dtype=np.float32) / 100
    return values.reshape(batch, knots, controls, 3)


def test_a_batch_comes_back_as_arrays(twin):
    batch = actions(2)
    result = twin.rollout(trajectories=batch, returns=Returns(every_frames=1))
    assert result.costs.shape == (2,)
    assert result.costs.dtype == np.float64
    assert result.positions.shape == (2, 3, 3, 3)
    np.testing.assert_array_equal(result.positions[:, :, 0], batch[:, 1:, 0])
    np.testing.assert_array_equal(result.frames, [1, 2, 3])
    assert result.timing.compute_s == 0.25
    assert result.diverged[0].node == 2
    assert result.control_gradients is None


def test_half_size_positions_are_close(twin):
    result = twin.rollout(
        trajectories=actions(2), returns=Returns(every_frames=1, encoding="int16")
    )
    np.testing.assert_allclose(result.positions[:, :, 0], actions(2)[:, 1:, 0], atol=6e-4)


def test_gradients_have_the_shape_of_dense_actions(twin):
    result = twin.rollout(trajectories=actions(2), returns=Returns(control_gradients=True))
    assert result.control_gradients.shape == (2, 4, 1, 3)


def test_everything_asked_for_is_sent(twin, fake):
    twin.rollout(
        trajectories=actions(1),
        frames=30,
        interpolation="cubic",
        initial=CaptureFrame(frame=9, sequence=2),
        costs=[
            TargetCloud(points=[[0, 0, 0]], weight=2.0, when="every_frame", name="cloud"),
            Keypoints(nodes=[2], targets=[[1, 2, 3]], squared=True),
            Smoothness(weight=0.5),
        ],
        returns=Returns(best=1, nodes=[0, 2], final_state=True, diagnostics=True),
    )
    request = fake.rollout_request
    assert (request.twin, request.frames) == (TWIN, 30)
    assert request.initial.capture_frame.frame == 9
    assert [c.WhichOneof("kind") for c in request.costs] == [
        "target_cloud",
        "keypoints",
        "smoothness",
    ]
    assert [c.weight for c in request.costs] == [2.0, 1.0, 0.5]
    assert request.returns.best == 1
    assert list(request.returns.nodes.shape) == [2]


def test_every_kind_of_cost_is_sent(twin, fake):
    twin.rollout(
        trajectories=actions(2),
        costs=[
            Strain(limit=0.1, weight=-1.0),
            Force(by="controls", limit_n=2.0),
            Force(by=("grasp", 3)),
            Height(plane=Plane(offset_m=0.02), nodes=[1]),
            Within(cuboid=Cuboid([0, 0, 0], [1, 1, 1])),
            Clearance(collider=1, margin_m=0.01),
            ControlPath(weight=0.0),
            ControlSpeed(limit_m_s=0.5),
            TargetCloud(points=np.zeros((3, 5, 3)), when="soft_min", temperature=1e-4),
            Keypoints(nodes=[0, 2], targets=np.zeros((2, 1, 2, 3))),
            Order(nodes=[0, 1, 2], direction=[0, 1, 0], gap_m=0.01, success_at_most=0.0),
            Winding(skin_points=[2, 0], axis=([0, 0, 1], [1, 0, 0]), turns=1.5),
            Winding(nodes=[0, 1], collider=0, turns=-1.0),
            Coverage(points=np.zeros((4, 3)), reach_m=0.02, point_set="nodes"),
        ],
    )
    costs = fake.rollout_request.costs
    assert [c.WhichOneof("kind") for c in costs] == [
        "strain",
        "force",
        "force",
        "height",
        "within",
        "clearance",
        "control_path",
        "control_speed",
        "target_cloud",
        "keypoints",
        "order",
        "winding",
        "winding",
        "coverage",
    ]
    assert costs[0].weight == -1.0
    assert costs[1].force.WhichOneof("by") == "controls"
    assert (costs[2].force.WhichOneof("by"), costs[2].force.grasp) == ("grasp", 3)
    assert list(costs[3].height.plane.normal) == [0, 0, 1]
    assert not costs[4].within.HasField("nodes")
    assert costs[6].HasField("weight")
    assert (costs[8].when, costs[8].temperature) == (3, 1e-4)
    assert list(costs[8].target_cloud.points.shape) == [3, 5, 3]
    assert list(costs[9].keypoints.targets.shape) == [2, 1, 2, 3]
    assert not costs[9].HasField("success_at_most")
    assert costs[10].HasField("success_at_most")
    order = costs[10].order
    assert (list(order.nodes.shape), list(order.direction)) == ([3], [0, 1, 0])
    assert order.gap_m == np.float32(0.01)
    assert not order.HasField("skin_points")
    around = costs[11].winding
    assert (list(around.axis.point), list(around.axis.direction)) == ([0, 0, 1], [1, 0, 0])
    assert (list(around.skin_points.shape), around.turns) == ([2], 1.5)
    assert costs[12].winding.WhichOneof("around") == "collider"
    coverage = costs[13].coverage
    assert (list(coverage.points.shape), coverage.point_set) == ([4, 3], rollout_pb2.NODES)


def test_wrong_costs_are_refused_before_they_are_sent(twin):
    wrong = [
        TargetCloud(points=[0.0, 0.0, 0.0]),
        Keypoints(nodes=[0], targets=np.zeros((1, 1, 1, 1, 3))),
        Within(cuboid=Cuboid([0, 0], [1, 1, 1])),
        Height(plane=Plane(normal=[0, 1])),
        TargetCloud(points=[[np.nan, 0, 0]]),
        Order(direction=[0, 1, 0]),
        Order(nodes=[0, 1], skin_points=[0, 1], direction=[0, 1, 0]),
        Order(nodes=[0, 1], direction=[0, 1]),
        Winding(nodes=[0, 1], turns=1.0),
        Winding(nodes=[0, 1], turns=1.0, collider=0, axis=([0, 0, 0], [0, 0, 1])),
        Winding(nodes=[0, 1], turns=1.0, axis=([0, 0], [0, 0, 1])),
        Coverage(points=np.zeros((2, 4, 3)), reach_m=0.1),
    ]
    for cost in wrong:
        with pytest.raises(ValueError, match=r"shape|dimensions|finite|either"):
            twin.rollout(trajectories=actions(1), costs=[cost])


def test_all_arrays_come_back_with_their_shapes(twin, fake):
    asked = Returns(
        every_frames=1,
        velocities=True,
        frame_costs=True,
        controls=True,
        control_gradients=True,
        initial_gradients=True,
        gradient_norms=True,
        diagnostics=True,
    )
    result = twin.rollout(trajectories=actions(2), costs=[Smoothness()], returns=asked)
    sent = fake.rollout_request.returns
    assert sent.velocities
    assert sent.frame_costs
    assert sent.controls
    assert sent.initial_gradients
    assert sent.gradient_norms
    assert result.velocities.shape == result.positions.shape
    assert result.frame_costs.shape == (2, 4, 1)
    assert result.controls.shape == (2, 4, 1, 3)
    assert result.initial_position_gradients.shape == (2, 3, 3)
    assert result.initial_velocity_gradients.shape == (2, 3, 3)
    assert result.gradient_norms.shape == (2, 4)
    np.testing.assert_array_equal(result.gradient_exploded, [0, 1])
    nothing = twin.rollout(trajectories=actions(2))
    assert nothing.velocities is None
    assert nothing.frame_costs is None


def test_a_fast_rollout_says_how_far_it_strays(twin):
    fast = twin.rollout(trajectories=actions(1), fidelity="fast")
    assert (fast.fidelity, fast.substeps) == ("fast", 20)
    assert (fast.deviation.mean_m, fast.deviation.frames) == (5e-4, 30)
    planner = twin.rollout(trajectories=actions(1), fidelity="planner")
    assert (planner.fidelity, planner.deviation.mean_m) == ("planner", 1e-3)
    exact = twin.rollout(trajectories=actions(1))
    assert (exact.fidelity, exact.substeps, exact.deviation) == ("exact", 100, None)


def test_a_given_state_may_be_shared_or_per_instance(twin, fake):
    for shape in [(3, 3), (2, 3, 3)]:
        twin.rollout(trajectories=actions(2), initial=GivenState(np.zeros(shape)))
        given = fake.rollout_request.initial.given
        assert tuple(given.positions.shape) == shape
        assert not given.HasField("velocities")


def test_poses_name_the_gripper_of_each_control(twin, fake):
    poses = np.zeros((1, 2, 2, 7))
    poses[..., 6] = 1.0
    twin.rollout(poses=poses, gripper_of_control=[0, 1, 1], frames=5)
    assert list(fake.rollout_request.poses.gripper_of_control.shape) == [3]


def test_parts_in_time_and_time_limits_are_sent(twin, fake):
    twin.rollout(trajectories=actions(1), time_limit_s=0.05)
    assert fake.rollout_request.time_limit_s == 0.05
    assert not fake.rollout_request.returns.part_frames
    list(twin.stream_rollout(trajectories=actions(1), part_frames=2))
    assert fake.rollout_request.returns.part_frames == 2
    assert not fake.rollout_request.HasField("time_limit_s")


def test_what_a_part_covers_is_read():
    window = rollout_pb2.RollOutResponse.Window(first_frame=5, last_frame=8)
    part = RolloutResult.from_proto(
        rollout_pb2.RollOutResponse(window=window, unfinished=tensor(np.array([1], np.uint32)))
    )
    assert part.window == (5, 8)
    assert part.costs.shape == (0,)
    assert part.successes is None
    np.testing.assert_array_equal(part.unfinished, [1])
    whole = RolloutResult.from_proto(rollout_pb2.RollOutResponse())
    assert whole.window is None
    assert whole.unfinished is None


def test_successes_are_read():
    reply = rollout_pb2.RollOutResponse(successes=tensor(np.array([0, 1, 0.25], np.float32)))
    successes = RolloutResult.from_proto(reply).successes
    assert successes.dtype == np.float32
    np.testing.assert_array_equal(successes, [0, 1, 0.25])


def test_parts_arrive_one_by_one(twin):
    parts = list(twin.stream_rollout(trajectories=actions(3)))
    assert [p.first_instance for p in parts] == [0, 1, 2]


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"trajectories": actions(1), "poses": np.zeros((1, 2, 1, 7))},
        {"trajectories": np.zeros((2, 1, 3))},
        {"trajectories": np.full((1, 2, 1, 3), np.nan)},
        {"poses": np.zeros((1, 2, 1, 6))},
        {"trajectories": actions(1), "gripper_of_control": [0]},
        {"trajectories": actions(1), "initial": GivenState(np.zeros(3))},
        {"trajectories": actions(1), "fidelity": "quick"},
    ],
)
def test_wrong_actions_are_refused_before_sending(twin, arguments):
    with pytest.raises(ValueError, match=r"shape|finite|give either|goes with"):
        twin.rollout(**arguments)


def test_an_argument_that_a_rollout_lacks_is_named(twin):
    with pytest.raises(TypeError, match=r"no argument 'trajectory'; it has .*trajectories"):
        twin.rollout(trajectory=np.zeros((1, 2, 1, 3)))


def test_planners_walk_downhill_on_a_twin(twin):
    start = np.array([[0.2, 0.2, 0.2]])
    task = Task(twin=twin, costs=[Smoothness()], space=Together(start), frames=30)
    for method in (Mppi, Cem):
        plan = method(task, knots=4, samples=64, sigma=0.03, iterations=40).plan()
        assert plan.cost < 0.3 * plan.nominal_cost
        assert plan.cost == pytest.approx(np.linalg.norm(start[0] + plan.knots[-1]), rel=1e-5)
        actions = plan.actions()
        assert (actions["frames"], actions["interpolation"]) == (30, "linear")
        np.testing.assert_array_equal(actions["trajectories"][0, 0], start.astype(np.float32))
        assert twin.rollout(**actions, costs=[Smoothness()]).costs[0] == plan.cost


def test_the_first_frames_of_a_plan_are_dense(twin, fake):
    space = Together([[0.2, 0.2, 0.2]])
    task = Task(twin=twin, costs=[Smoothness()], space=space, frames=30, interpolation="cubic")
    plan = Mppi(task, knots=4).plan()
    few, all_of_it = plan.actions(frames=3), plan.actions(frames=30)
    assert few["trajectories"].shape == (1, 4, 1, 3)
    assert few["frames"] == 3
    np.testing.assert_array_equal(few["trajectories"], all_of_it["trajectories"][:, :4])
    knots = plan.actions()["trajectories"]
    np.testing.assert_allclose(all_of_it["trajectories"][:, ::10], knots, atol=1e-6)
    poses = replace(task, space=Grippers.around([[0.2, 0.2, 0.2]]))
    assert poses.actions(np.zeros((4, 6)), frames=2)["poses"].shape == (1, 3, 1, 7)
    with pytest.raises(ValueError, match="30 frames"):
        plan.actions(frames=31)


def test_gradients_by_actions_become_gradients_by_knots(twin, fake):
    # The server of this test answers with the actions themselves as gradients.
    task = Task(twin=twin, costs=[Smoothness()], space=Together([[0.2] * 3] * 2), frames=3)
    found = task.evaluate(np.zeros((1, 4, 3)), None, gradients=True)
    np.testing.assert_allclose(found.gradients, 0.4, atol=1e-6)
    assert fake.rollout_request.returns.action_gradients
