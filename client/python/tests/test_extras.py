"""Adapters of planner libraries, each against a real server."""

from dataclasses import replace

import numpy as np
import pytest
from server import needs_server, with_rope

from bendtwin import GradientOptions, Keypoints, Returns, Vary, World
from bendtwin.planners import Task, Together

pytestmark = needs_server


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A task of 6 frames, of a heavier rope on another ground, and the state it starts from."""
    with with_rope(tmp_path_factory.mktemp("extras")) as made:
        twin, controls = made.twin, made.controls
        hold = np.stack([controls, controls])[None]
        state = twin.rollout(trajectories=hold, frames=20, returns=Returns(final_state=True)).state(
            0
        )
        goal = np.asarray(state.positions)[:1] + np.array([0.04, 0.0, 0.04])
        costs = [Keypoints(nodes=[0], targets=goal, squared=True)]
        task = Task(
            twin=twin,
            costs=costs,
            space=Together(controls),
            frames=6,
            world=World(ground_friction=0.9),
            vary=Vary(mass=[1.3]),
        )
        by_hand = twin.rollout(
            trajectories=hold,
            frames=6,
            initial=state,
            costs=costs,
            world=task.world,
            vary=task.vary,
        )
        assert task.evaluate(np.zeros((1, 2, 3)), state).costs == by_hand.costs
        yield task, state


def test_torch_differentiates_costs_by_knots(scene):
    torch = pytest.importorskip("torch")
    from bendtwin.planners.torch import rollout_costs

    task, state = scene
    knots = torch.zeros(2, 3, 3, dtype=torch.float64, requires_grad=True)
    costs = rollout_costs(task, knots, state)
    (costs * torch.tensor([1.0, 3.0])).sum().backward()
    # Over the ground the contact is smooth unless the task says otherwise.
    smooth = replace(task, gradient=GradientOptions(smoothing_m=0.001))
    expected = smooth.evaluate(np.zeros((2, 3, 3)), state, gradients=True)
    np.testing.assert_array_equal(costs.detach().numpy(), expected.costs)
    scaled = expected.gradients * np.array([1.0, 3.0])[:, None, None]
    np.testing.assert_allclose(knots.grad.numpy(), scaled)
    assert np.abs(scaled).max() > 0
    impacts = replace(task, gradient=GradientOptions())
    assert (rollout_costs(impacts, knots, state) != costs).any()
    assert not rollout_costs(task, knots.detach(), state).requires_grad


def test_pytorch_mppi_lowers_the_cost(scene):
    torch = pytest.importorskip("torch")
    pytest.importorskip("pytorch_mppi")
    from bendtwin.planners.pytorch_mppi import TwinMppi

    task, state = scene
    torch.manual_seed(0)
    sigma = 1e-4 * torch.eye(3, dtype=torch.float64)
    mppi = TwinMppi(task, sigma, num_samples=32, lambda_=1e-4)
    mppi.initial = state
    for _ in range(3):
        mppi.command(torch.zeros(3, dtype=torch.float64), shift_nominal_trajectory=False)
    changes = mppi.get_action_sequence().numpy()
    path = np.concatenate([np.zeros((1, 3)), changes.cumsum(axis=0)])
    before, after = task.evaluate(np.stack([np.zeros_like(path), path]), state).costs
    assert after < 0.9 * before


def test_judo_lowers_the_cost(scene):
    pytest.importorskip("judo.controller")
    from judo.controller import Controller, ControllerConfig
    from judo.optimizers.mppi import MPPI, MPPIConfig

    from bendtwin.planners.judo import TwinBackend, TwinTask

    task, state = scene
    np.random.seed(0)  # It draws its samples from there.
    goal = TwinTask(task, fastest=0.5, nodes=[0])
    optimizer = MPPI(MPPIConfig(num_rollouts=16, sigma=0.2, temperature=1e-5), goal.nu)
    settings = ControllerConfig(horizon=task.frames * task.frame_s - 1e-9, max_opt_iters=3)
    backend = TwinBackend(goal, 16)
    controller = Controller(settings, goal, optimizer, rollout_backend=backend)
    goal.initial = state
    controller.current_state = goal.state(np.zeros(task.dims))
    controller.update_action()
    assert controller.states.shape == (16, task.frames, 6)
    assert controller.traces.shape[1:] == (2, 3)
    # The sensor is where the node is, and the reward what the task's costs say.
    controls = np.stack([np.zeros((task.frames, 3)), controller.action(controller.rollout_times)])
    states, sensors, _ = backend.rollout(controller.current_state, controls)
    path = np.concatenate([np.zeros((2, 1, 3)), states[:, :, :3]], axis=1)
    before, after = task.evaluate(path, state).costs
    np.testing.assert_allclose(goal.reward(states, sensors, controls), [-before, -after])
    assert after < 0.9 * before
    apart = ((sensors[1, -1, :3] - task.costs[0].targets[0]) ** 2).sum()
    np.testing.assert_allclose(apart, after, rtol=1e-4)


def test_hydrax_lowers_the_cost(scene):
    jax = pytest.importorskip("jax")
    # The package of this name in the registry is another one.
    pytest.importorskip("hydrax.alg_base")
    from hydrax.algs import MPPI

    from bendtwin.planners.hydrax import TwinRollouts, TwinTask

    class TwinMppi(TwinRollouts, MPPI):
        pass

    task, state = scene
    goal = TwinTask(task, fastest=0.5, nodes=[0])
    controller = TwinMppi(
        goal,
        num_samples=16,
        noise_level=0.2,
        temperature=1e-5,
        plan_horizon=task.frames * task.frame_s,
        spline_type="linear",
        iterations=3,
    )
    params = controller.init_params()
    optimize = jax.jit(controller.optimize)
    goal.initial = state
    params, rollouts = optimize(goal.at(np.zeros(3), 0.0), params)
    assert rollouts.costs.shape == (16, task.frames + 1)
    assert rollouts.trace_sites.shape == (16, task.frames + 1, 1, 3)
    times = (np.arange(task.frames) + 0.5) * task.frame_s
    steps = np.asarray(controller.get_action(params, times)) * task.frame_s
    path = np.concatenate([np.zeros((1, 3)), steps.cumsum(axis=0)])
    before, after = task.evaluate(np.stack([np.zeros_like(path), path]), state).costs
    assert after < 0.9 * before
    # The state is read anew in every call.
    goal.initial = None
    _, others = optimize(goal.at(np.zeros(3), 0.0), params)
    assert not np.allclose(others.costs, rollouts.costs)
