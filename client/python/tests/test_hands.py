"""Hands that release a cable and take it elsewhere, and hands that are driven into the table."""

import numpy as np
import pytest
from numpy_twin import norm
from scenes import dragged, twisted
from server import needs_server, running

from bendtwin import Client, Grasp, Keypoints, Plausibility, Rest, Returns

pytestmark = needs_server

KNOTS = 31
OPEN_AT = 10


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    with running(tmp_path_factory.mktemp("bendtwin")) as address, Client(address) as client:
        yield client


def imported(client, folder, file):
    (folder / "twin.safetensors").write_bytes(file.encode())
    return client.import_twin(folder / "twin.safetensors")


def regrasp(nodes, turn=0.0):
    """Gripper 1 releases the cable's end, takes node 6, and lifts and turns it; gripper 0 holds
    the other end."""
    poses = np.zeros((1, KNOTS, 2, 7))
    poses[..., 6] = 1.0
    poses[0, :, 0, :3] = nodes[0]
    t = np.clip((np.arange(KNOTS) - OPEN_AT) / (KNOTS - 1 - OPEN_AT), 0, 1)
    poses[0, :, 1, :3] = nodes[6] + t[:, None] * [0.0, 0.0, 0.05]
    along = nodes[7] - nodes[5]
    along /= norm(along)
    poses[0, :, 1, 3:6] = np.sin(turn * t[:, None] / 2) * along
    poses[0, :, 1, 6] = np.cos(turn * t / 2)
    later = np.arange(KNOTS) >= OPEN_AT
    return {
        "poses": poses,
        "gripper_of_control": [0, 1],
        "grasps": [
            Grasp(gripper=1, hand=1, closed=~later),
            Grasp(gripper=1, nodes=[6, 7], closed=later),
        ],
        "returns": Returns(every_frames=1, final_state=True, diagnostics=True),
    }


def test_a_cable_is_let_go_of_and_taken_elsewhere(client, tmp_path):
    file, _ = twisted()
    twin = imported(client, tmp_path, file)
    nodes = np.asarray(file.tensors["nodes.rest_position"])
    # It settles between its clamps first.
    result = twin.rollout(**regrasp(nodes))
    moved = result.positions[0]
    taken = OPEN_AT - 1  # frame `OPEN_AT` of the recording, which begins with frame 1
    assert norm(moved[:taken, -1] - nodes[-1]).max() < 1e-5
    assert norm(moved[:, 0] - nodes[0]).max() < 1e-5
    held = result.final_grasping.holders[0] == 2
    assert held.sum() >= 2
    lifted = moved[-1, held] - moved[taken, held]
    assert np.allclose(lifted, [0, 0, 0.05], atol=1e-4)
    assert norm(moved[-1, -1] - moved[taken, -1]) > 0.01
    # The gripper turns what it holds, and the part up to the other clamp is twisted by it: 5 of
    # its 10 inner nodes lie between them, so it counts about twice for the rod as a whole.
    turned = twin.rollout(**regrasp(nodes, turn=0.8))
    twist = float(turned.final_twists[0, 0] - result.final_twists[0, 0])
    assert -4.0 < twist < -0.8


def lowered(path, by):
    frames = np.clip(np.arange(21) / 10, 0, 1)
    return path[:1] + frames[:, None, None] * np.array([0, 0, -by])


def test_a_hand_stops_at_the_table_and_the_reply_says_so(client, tmp_path):
    file, path = dragged()
    twin = imported(client, tmp_path, file)
    returns = Returns(forces=True, diagnostics=True, controls=True)

    def force(by, **arguments):
        trajectories = lowered(path, by)[None]
        with pytest.warns(RuntimeWarning, match="CONTROL_IN_OBSTACLE"):
            result = twin.rollout(trajectories=trajectories, returns=returns, **arguments)
        pulls = norm(result.forces.controls[0].astype(float))
        return pulls[-5:].max(), result

    # The control points are 50 mm above the table; 5 mm deep they stop.
    _, result = force(0.06)
    assert result.diagnostics[0].stopped_hand_m == pytest.approx(0.005, abs=1e-4)
    assert result.controls[0, -1, :, 2].min() == pytest.approx(-0.005, abs=1e-4)
    deep, result = force(0.16)
    assert result.diagnostics[0].stopped_hand_m == pytest.approx(0.105, abs=1e-4)
    assert result.controls[0, -1, :, 2].min() == pytest.approx(-0.005, abs=1e-4)
    # Who wants more says so.
    allowed, result = force(0.16, plausibility=Plausibility(control_depth_m=0.08))
    assert result.diagnostics[0].stopped_hand_m == pytest.approx(0.03, abs=1e-4)
    assert allowed > deep
    above = twin.rollout(trajectories=lowered(path, 0.03)[None], returns=returns)
    assert above.diagnostics[0].stopped_hand_m == 0.0


def dive(path, frames=18, turn=0.5):
    """Poses of a gripper around the control points that goes deep into the table, wanders and
    turns there, and comes up again."""
    rng = np.random.default_rng(5)
    t = np.linspace(0.0, 1.0, frames + 1)
    poses = np.zeros((1, frames + 1, 1, 7))
    poses[0, :, 0, :3] = path[0].mean(axis=0)
    poses[0, :, 0, 2] -= 0.5 * t * (1.0 - t)
    poses[0, 1:, 0, :3] += rng.normal(0.0, 0.004, (frames, 3))
    poses[0, :, 0, 3] = np.sin(turn * t / 2)
    poses[0, :, 0, 6] = np.cos(turn * t / 2)
    return poses


@pytest.mark.filterwarnings("ignore:implausible motion")
def test_a_gripper_stops_alike_in_a_plan_in_steps_and_in_a_session(client, tmp_path):
    file, path = dragged()
    twin = imported(client, tmp_path, file)
    poses = dive(path)
    returns = Returns(final_state=True, diagnostics=True, controls=True)
    whole = twin.rollout(poses=poses, returns=returns)
    assert whole.diagnostics[0].stopped_hand_m > 0.05
    assert whole.controls[0, :, :, 2].min() == pytest.approx(-0.005, abs=1e-4)
    # At the end it is where its poses have it.
    assert np.array_equal(whole.final_controls, whole.final_commanded_controls)
    parts = [poses[:, a : b + 1] for a, b in [(0, 1), (1, 7), (7, 9), (9, 18)]]
    state = Rest()
    with client.open_session(twin) as session:
        for part in parts:
            stepped = twin.rollout(poses=part, initial=state, returns=returns)
            state = stepped.state(0)
            session.advance(poses=part)
            (held,) = session.states()
            np.testing.assert_allclose(held.positions, state.positions, atol=1e-6)
            np.testing.assert_allclose(held.controls, state.controls, atol=1e-6)
    np.testing.assert_allclose(state.positions, whole.final_positions[0], atol=1e-6)
    np.testing.assert_allclose(state.controls, whole.final_controls[0], atol=1e-6)


def test_gradients_of_a_stopped_hand_are_those_of_differences(client, tmp_path):
    file, path = dragged()
    twin = imported(client, tmp_path, file)
    nodes = np.asarray(file.tensors["nodes.rest_position"])
    targets = nodes[:4] + np.array([0.05, 0.02, 0.05])
    cost = Keypoints(nodes=[0, 1, 2, 3], targets=targets, squared=True)
    actions = np.stack([path[0], path[0] - [0.0, 0.0, 0.03], path[0] - [0.01, 0.0, 0.09]])

    def run(actions, **wanted):
        with pytest.warns(RuntimeWarning):
            return twin.rollout(
                trajectories=actions[None], frames=12, costs=[cost], returns=Returns(**wanted)
            )

    found = run(actions, action_gradients=True).action_gradients[0]
    for axis in (0, 2):
        step = np.zeros_like(actions)
        step[2, :, axis] = 2e-3
        difference = (run(actions + step).costs[0] - run(actions - step).costs[0]) / 4e-3
        assert found[2, :, axis].sum() == pytest.approx(difference, rel=0.1, abs=1e-4)
