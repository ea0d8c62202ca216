"""Twins as environments of Gymnasium, against a real server."""

from dataclasses import replace

import numpy as np
import pytest
from made import sheet_at_rest
from server import needs_server

from bendtwin import Ensemble, Grasp, Keypoints, Plausibility, Returns, Sphere, Vary
from bendtwin.planners import Grippers, PerHand, Points, Task, Together

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.vector import AutoresetMode  # noqa: E402

from bendtwin.planners.gymnasium import TwinVectorEnv  # noqa: E402

pytestmark = needs_server
STEP, COUNT = 4, 3


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    with sheet_at_rest(tmp_path_factory.mktemp("environments")) as scene:
        yield scene


@pytest.fixture
def task(scene):
    """Steps of four frames from rest; the far corner is to come up."""
    return Task(
        twin=scene.twin,
        costs=[Keypoints(nodes=[19], targets=[scene.start.positions[19] + np.array([0, 0, 0.05])])],
        space=Together(scene.start.controls),
        frames=STEP,
        initial=scene.start,
    )


def environments(task, **settings):
    settings = {"num_envs": COUNT, "nodes": [0, 19], "episode_frames": 5 * STEP} | settings
    return TwinVectorEnv(task, **settings)


def some_actions(task, steps):
    changes = np.random.default_rng(0).uniform(-0.01, 0.01, (steps, COUNT, task.dims))
    changes[..., 2] = abs(changes[..., 2])
    return changes.astype(np.float32)


def spaces(scene):
    controls, hands = scene.start.controls, scene.twin.geometry().hands
    grip = [*np.asarray(scene.start.positions)[19], 0, 0, 0, 1]
    return {
        "together": Together(controls),
        "per hand": PerHand(controls, hands),
        "points": Points(controls),
        "grippers": Grippers.around(controls, hands),
        "a gripper elsewhere": Grippers([grip]),
    }


def run_in_steps(task, actions, **settings):
    """The last observation and reward of environments, and their way as one rollout."""
    env = environments(task, **settings)
    observed, _ = env.reset(seed=0)
    assert observed.shape == env.observation_space.shape == (COUNT, 12 + task.dims)
    for action in actions:
        observed, reward, *_ = env.step(action)
    path = np.concatenate([np.zeros((1, COUNT, task.dims)), actions.astype(float).cumsum(axis=0)])
    whole = replace(task, frames=len(actions) * STEP).rollout(
        path.swapaxes(0, 1), returns=Returns(final_state=True, diagnostics=True)
    )
    expected = whole.final_positions[:, [0, 19]].reshape(COUNT, -1)
    np.testing.assert_allclose(observed[:, :6], expected, atol=1e-5)
    np.testing.assert_allclose(observed[:, 12:], path[-1], atol=1e-6)
    return reward, whole


@pytest.mark.parametrize("space", ["together", "per hand", "points", "grippers"])
def test_steps_are_one_motion(scene, task, space):
    task = replace(task, space=spaces(scene)[space])
    reward, whole = run_in_steps(task, some_actions(task, 4))
    np.testing.assert_allclose(-reward, whole.costs, rtol=1e-4)


@pytest.mark.filterwarnings("ignore:implausible motion")
def test_steps_into_the_table_are_one_motion(scene, task):
    task = replace(task, space=spaces(scene)["grippers"])
    actions = np.zeros((5, COUNT, task.dims), np.float32)
    actions[:4, :, 2] = -0.03
    actions[4, :, 2] = np.linspace(0.0, 0.03, COUNT)
    _, whole = run_in_steps(task, actions, largest_step=0.03)
    assert all(found.stopped_hand_m > 0.01 for found in whole.diagnostics)
    assert np.abs(whole.final_commanded_controls - whole.final_controls).max() > 0.005


def test_what_is_held_stays_held(scene, task):
    """A gripper takes the far corner from the second step on; the hand lets it."""
    task = replace(
        task,
        space=spaces(scene)["a gripper elsewhere"],
        grasps=[
            Grasp(region=Sphere(0.02), closed=np.arange(100) >= STEP),
            Grasp(hand=0, closed=False),
        ],
    )
    env = environments(task)
    env.reset()
    action = np.zeros((COUNT, 6), np.float32)
    start = np.asarray(scene.start.positions)[19]
    action[1:, 2] = 0.01
    heights = []
    for _ in range(4):
        observed, *_ = env.step(action)
        heights.append(observed[:, 5] - start[2])
    # The gripper has gone up by a step when it closes, which the corner stays below.
    assert abs(heights[0]).max() < 2e-3
    np.testing.assert_allclose(np.diff(heights[1:], axis=0)[:, 1:], 0.01, atol=1e-4)
    assert abs(np.array(heights)[:, 0]).max() < 2e-3
    # Closings begin again with the episode.
    env.step(action)
    env.step(action)
    observed, *_ = env.step(action)
    assert abs(observed[:, 5] - start[2]).max() < 2e-3


def test_episodes_begin_again_in_the_next_step(task):
    env = environments(task, episode_frames=2 * STEP)
    assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    first, info = env.reset(seed=0)
    assert not info["is_success"].any()
    action = some_actions(task, 1)[0]
    assert not env.step(action)[3].any()
    last, _, terminated, truncated, info = env.step(action)
    assert truncated.all()
    assert not terminated.any()
    assert "final_obs" not in info
    assert (last != first).any()
    again, reward, terminated, truncated, info = env.step(action)
    np.testing.assert_array_equal(again, first)
    np.testing.assert_array_equal(reward, 0.0)
    assert not (terminated | truncated).any()
    np.testing.assert_array_equal(info["strain"], 0.0)


def test_episodes_begin_again_in_the_same_step(task):
    env = environments(
        task, episode_frames=2 * STEP, autoreset_mode=AutoresetMode.SAME_STEP, success=is_up
    )
    assert env.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    other = environments(task, episode_frames=2 * STEP, success=is_up)
    first, _ = env.reset()
    other.reset()
    actions = some_actions(task, 2)
    env.step(actions[0])
    other.step(actions[0])
    observed, reward, terminated, truncated, info = env.step(actions[1])
    last, expected, *_, ended = other.step(actions[1])
    np.testing.assert_array_equal(observed, first)
    np.testing.assert_array_equal(reward, expected)
    assert (terminated | truncated).all()
    np.testing.assert_array_equal(np.stack(info["final_obs"]), last)
    assert info["_final_obs"].all()
    for name in ("is_success", "diverged", "strain"):
        np.testing.assert_array_equal(info["final_info"][name], ended[name])
        assert info["final_info"][f"_{name}"].all()
        assert not info[name].any()
    # The next step is the first of another episode.
    np.testing.assert_array_equal(env.step(actions[0])[0], environments_after(task, actions[0]))


def environments_after(task, action):
    env = environments(task)
    env.reset()
    return env.step(action)[0]


def is_up(states):
    """The corner by the hand is higher than at first."""
    return np.asarray(states.positions)[:, 0, 2] > 0.04


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_success_ends_an_episode(scene, task, mode):
    height = np.asarray(scene.start.positions)[0, 2]
    env = environments(
        task,
        success=lambda states: np.asarray(states.positions)[:, 0, 2] > height + 0.015,
        autoreset_mode=mode,
    )
    env.reset()
    action = np.zeros((COUNT, 3), np.float32)
    action[1, 2] = 0.01
    for _ in range(5):
        _, _, terminated, truncated, info = env.step(action)
        if terminated.any():
            break
    np.testing.assert_array_equal(terminated, [False, True, False])
    assert not truncated.any()
    ends = info["final_info"] if mode is AutoresetMode.SAME_STEP else info
    np.testing.assert_array_equal(ends["is_success"], [False, True, False])
    if mode is AutoresetMode.SAME_STEP:
        assert info["final_obs"][0] is None
        np.testing.assert_array_equal(info["_final_info"], [False, True, False])


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_to_diverge_is_the_worst_outcome(task, mode):
    """One environment is moved so fast that the task refuses it, in the second of five steps."""
    task = replace(task, plausibility=Plausibility(control_speed_m_s=0.1, refuse=True))
    env = environments(task, largest_step=1.0, diverged_cost=7.0, autoreset_mode=mode)
    first, _ = env.reset()
    env.step(np.zeros((COUNT, 3), np.float32))
    action = np.zeros((COUNT, 3), np.float32)
    action[1, 2] = 0.5
    _, reward, terminated, _, info = env.step(action)
    np.testing.assert_array_equal(terminated, [False, True, False])
    assert reward[1] == -4 * 7.0, "it costs the steps that are left as well"
    assert (reward[[0, 2]] > -7.0).all()
    ends = info["final_info"] if mode is AutoresetMode.SAME_STEP else info
    np.testing.assert_array_equal(ends["diverged"], [False, True, False])
    if mode is AutoresetMode.NEXT_STEP:
        observed, reward, *_ = env.step(np.zeros((COUNT, 3), np.float32))
        np.testing.assert_array_equal(observed[1], first[1])
        assert reward[1] == 0.0
    # No step that does not diverge costs more.
    dear = replace(task, costs=[replace(task.costs[0], weight=1e6)])
    env = environments(dear, diverged_cost=7.0)
    env.reset()
    np.testing.assert_array_equal(env.step(np.zeros((COUNT, 3)))[1], -7.0)


def test_environments_may_have_parameters_of_their_own(task):
    env = environments(replace(task, vary=Vary(mass=[0.5, 1.0, 2.0])))
    env.reset()
    action = np.zeros((COUNT, 3), np.float32)
    action[:, 2] = 0.01
    observed, *_, info = env.step(action)
    assert len(np.unique(observed[:, 2])) == COUNT
    assert (np.diff(info["strain"]) > 0).all(), "the heavier, the more it is strained"


def test_what_no_environment_is_gets_refused(task):
    with pytest.raises(ValueError, match="one state with control points"):
        environments(replace(task, initial=replace(task.initial, controls=None)))
    with pytest.raises(ValueError, match="vary the task"):
        environments(replace(task, vary=Vary(mass=[1, 2]), ensemble=Ensemble(2)))
    with pytest.raises(ValueError, match="NEXT_STEP or SAME_STEP"):
        environments(task, autoreset_mode=AutoresetMode.DISABLED)
