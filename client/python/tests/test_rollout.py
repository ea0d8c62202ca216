import numpy as np
import pytest
from fake import TWIN

from bendtwin import (
    CaptureFrame,
    GivenState,
    Keypoints,
    Returns,
    Smoothness,
    TargetCloud,
)
from bendtwin.planners import Cem, GradientDescent, Grippers, Mppi, Task, Together


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


def test_a_fast_rollout_says_how_far_it_strays(twin):
    fast = twin.rollout(trajectories=actions(1), fidelity="fast")
    assert (fast.fidelity, fast.substeps) == ("fast", 20)
    assert (fast.deviation.mean_m, fast.deviation.frames) == (5e-4, 30)
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
    assert plan.path().shape == (31, 3)
    few = plan.actions(frames=3)
    assert few["trajectories"].shape == (1, 4, 1, 3)
    np.testing.assert_allclose(few["trajectories"][0, :, 0], 0.2 + plan.path()[:4], atol=1e-6)
    with pytest.raises(ValueError, match="30 frames"):
        plan.actions(frames=31)


def test_gradients_by_frame_become_gradients_by_knot(twin, fake):
    # The server of this test answers with the actions themselves as gradients, in knots.
    task = Task(twin=twin, costs=[Smoothness()], space=Together([[0.2] * 3]), frames=3)
    found = task.evaluate(np.zeros((1, 4, 3)), None, gradients=True)
    np.testing.assert_allclose(found.gradients, 0.2, atol=1e-6)
    assert fake.rollout_request.returns.control_gradients
    poses = Task(twin=twin, costs=[Smoothness()], space=Grippers.around([[0.2] * 3]), frames=3)
    with pytest.raises(ValueError, match="another method"):
        GradientDescent(poses).plan()
