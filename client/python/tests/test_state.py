import numpy as np
import pytest
from fake import TWIN

from bendtwin import Grasping, Returns, RolloutResult, Settled, State
from bendtwin.v1 import rollout_pb2


@pytest.fixture
def twin(client):
    return client.twin(TWIN)


ACTIONS = np.zeros((2, 3, 1, 3), np.float32)


def test_a_whole_state_is_sent(twin, fake):
    grasping = Grasping(phases=[1], holders=[0, 1, 1], places=np.zeros((3, 3)))
    state = State(
        positions=np.zeros((3, 3)),
        velocities=np.zeros((3, 3)),
        twists=[0.1],
        controls=[[1, 2, 3]],
        grasping=grasping,
    )
    twin.rollout(trajectories=ACTIONS, initial=state)
    given = fake.rollout_request.initial.given
    assert list(given.controls.shape) == [1, 3]
    assert list(given.grasping.holders.shape) == [3]
    twin.rollout(trajectories=ACTIONS, initial=Settled())
    assert fake.rollout_request.initial.HasField("settled")


def test_the_state_of_a_reply_is_one_to_start_from():
    message = rollout_pb2.RollOutResponse()
    batch = State(
        positions=np.arange(18.0).reshape(2, 3, 3),
        velocities=np.ones((2, 3, 3)),
        twists=np.ones((2, 1)),
        controls=np.arange(6.0).reshape(2, 1, 3),
        grasping=Grasping([[1], [2]], [[0, 1, 1], [0, 0, 0]], np.ones((2, 3, 3))),
    )
    given = batch.to_proto().given
    for name in ("positions", "velocities", "twists", "controls", "grasping"):
        getattr(message, f"final_{name}").CopyFrom(getattr(given, name))
    result = RolloutResult.from_proto(message)
    assert result.states().to_proto() == batch.to_proto()
    second = result.state(1)
    np.testing.assert_array_equal(second.controls, [[3, 4, 5]])
    np.testing.assert_array_equal(second.grasping.phases, [2])
    assert list(second.to_proto().given.positions.shape) == [3, 3]
    with pytest.raises(ValueError, match="final_state"):
        RolloutResult.from_proto(rollout_pb2.RollOutResponse()).state(0)


def test_times_of_knots_are_sent(twin, fake):
    twin.rollout(trajectories=ACTIONS, frames=9, at_s=[0, 0.1, 0.3], interpolation="zero")
    request = fake.rollout_request
    assert list(request.knot_times.at_s.shape) == [3]
    assert request.trajectories.interpolation == rollout_pb2.ZERO
    twin.rollout(
        trajectories=ACTIONS, frames=9, period_s=0.1, returns=Returns(action_gradients=True)
    )
    assert fake.rollout_request.knot_times.period_s == 0.1
    assert fake.rollout_request.returns.action_gradients
    with pytest.raises(ValueError, match="either"):
        twin.rollout(trajectories=ACTIONS, frames=9, at_s=[0, 1, 2], period_s=0.1)
