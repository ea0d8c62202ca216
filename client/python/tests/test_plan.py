"""Requests for plans, and plans of a real server with its own worker."""

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from server import needs_server

from bendtwin import (
    BendTwinError,
    Bounds,
    Category,
    Keypoints,
    Plausibility,
    Returns,
    Search,
    Settled,
    aio,
    interpolate,
)
from bendtwin.planners import Grippers, Mppi, OnServer, PerHand, Points, Task, Together
from bendtwin.simulation.plan import plan_request
from bendtwin.tensors import unpack
from bendtwin.v1 import planning_pb2

STILL = np.zeros((1, 3, 2, 3), np.float32)
FRAMES = 10
METHODS = [
    Search(samples=16, iterations=3),
    Search(method="cem", samples=16, elites=4, iterations=3),
    Search(method="predictive_sampling", samples=16, iterations=3),
    Search(method="gradient", iterations=8),
]


def message(**arguments):
    return plan_request("twins/x", {"trajectories": STILL, **arguments})


def test_settings_become_a_message():
    search = Search(
        method="cem",
        samples=12,
        sigma=np.full((3, 3), 0.1),
        bounds=Bounds(low=-0.1, speed=[1.0, 2.0, np.inf]),
        deadline_s=0.5,
        seed=7,
        memory=0.0,
    )
    request = message(search=search, shift_frames=3)
    assert (request.samples, request.iterations, request.seed) == (12, 0, 7)
    assert (request.deadline_s, request.shift_frames) == (0.5, 3.0)
    assert request.method.cem.HasField("memory")
    assert request.method.cem.memory == 0.0
    assert unpack(request.sigma).shape == (9,)
    np.testing.assert_array_equal(unpack(request.bounds.speed), [1.0, 2.0, np.inf])
    assert not request.bounds.HasField("high")
    assert request.rollout.twin == "twins/x"


def test_action_spaces_are_known_to_the_server():
    wire = planning_pb2.ActionSpace
    points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    hands = message(space=PerHand(points, [0, 1])).space
    assert hands.coordinates == wire.PER_GROUP
    np.testing.assert_array_equal(unpack(hands.group_of_control), [0, 1])
    np.testing.assert_array_equal(unpack(hands.start), points)
    assert message(space=Together(points)).space.coordinates == wire.TOGETHER
    assert message(space=Points(points)).space.coordinates == wire.POINTS
    grippers = message(space=Grippers.around(points)).space
    assert grippers.coordinates == wire.RIGID
    assert unpack(grippers.start).shape == (1, 7)
    assert message(space="points").space.coordinates == wire.POINTS
    assert not message().HasField("space")


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"search": Search(method="random")}, ValueError),
        ({"search": Search(samples=0)}, ValueError),
        ({"search": Search(deadline_s=0.0)}, ValueError),
        ({"search": Search(sigma=np.nan)}, ValueError),
        ({"search": Search(temperature=0.0)}, ValueError),
        ({"space": "everything"}, ValueError),
        ({"horizon": 3}, TypeError),
    ],
)
def test_what_is_wrong_is_refused_before_it_is_sent(wrong, error):
    with pytest.raises(error):
        message(**wrong)


def test_only_spaces_of_the_server_are_planned_in_by_it():
    task = SimpleNamespace(space=object(), dims=3)
    with pytest.raises(TypeError, match="does not know"):
        OnServer(task)


@pytest.fixture(scope="module")
def scene(rope):
    """A twin, and a task: a node is to be 4 cm from where it comes to be when nothing moves."""
    scene = SimpleNamespace(**vars(rope))
    still = {"trajectories": scene.nominal, "frames": FRAMES}
    end = scene.twin.rollout(**still, returns=Returns(final_state=True))
    goal = end.final_positions[0, :1] + np.array([[0.03, 0.0, 0.03]])
    scene.costs = [Keypoints(nodes=[0], targets=goal, name="tip")]
    scene.ask = {**still, "costs": scene.costs}
    return scene


@needs_server
@pytest.mark.parametrize("search", METHODS, ids=lambda search: search.method)
def test_every_method_lowers_the_cost(scene, search):
    plan = scene.twin.plan(**scene.ask, search=search, returns=Returns(every_frames=1))
    assert plan.cost < 0.9 * plan.nominal_cost
    assert (plan.last, plan.stopped_by_deadline, plan.diverged) == (True, False, 0)
    assert plan.cost_terms == {"tip": pytest.approx(plan.cost)}
    assert plan.knots.shape == scene.nominal.shape
    np.testing.assert_array_equal(plan.knots[:, 0], scene.nominal[:, 0])
    # What came back was simulated, with that cost.
    again = scene.twin.rollout(**plan.actions, frames=FRAMES, costs=scene.costs)
    assert again.costs[0] == plan.cost == plan.rollout.costs[0]
    # The same seed gives the same plan, and its knots are the next nominal plan.
    same = scene.twin.plan(**scene.ask, search=search)
    assert same.rollout is None
    np.testing.assert_array_equal(same.knots, plan.knots)
    following = scene.twin.plan(**{**scene.ask, **plan.actions}, search=search)
    assert following.nominal_cost == plan.cost


@needs_server
@pytest.mark.parametrize("search", METHODS, ids=lambda search: search.method)
def test_a_plan_does_not_tear_the_object_unless_the_limit_is_lifted(scene, search):
    """The goal is a metre away from where an end is, and the control points go each its own way."""
    goal = scene.costs[0].targets + np.array([1.0, 0.0, 0.0])
    far = {**scene.ask, "costs": [Keypoints(nodes=[0], targets=goal)], "space": "points"}
    wide = replace(search, sigma=0.4, rate=0.2)
    kept = scene.twin.plan(**far, search=wide, returns=Returns(diagnostics=True))
    assert kept.strain <= kept.strain_limit == 1.0
    assert kept.rollout.diagnostics[0].max_strain == kept.strain
    assert kept.overstrained > 0
    lifted = Plausibility(strain=float("inf"))
    torn = scene.twin.plan(**far, search=wide, plausibility=lifted)
    assert torn.strain > 1.0
    assert torn.cost < kept.cost
    assert torn.overstrained == 0
    # Planners here keep the same limit.
    task = Task(twin=scene.twin, costs=far["costs"], space=Points(scene.controls), frames=FRAMES)
    plan = Mppi(task, knots=3, samples=16, sigma=0.4).plan()
    again = scene.twin.rollout(**plan.actions(), returns=Returns(diagnostics=True))
    assert again.diagnostics[0].max_strain <= 1.0
    assert plan.overstrained > 0
    assert plan.excess == 0.0


@needs_server
def test_updates_come_iteration_by_iteration_and_can_be_left(scene):
    search = Search(samples=8, iterations=3)
    updates = list(scene.twin.stream_plan(**scene.ask, search=search))
    assert [u.iterations for u in updates] == [1, 2, 3, 3]
    assert [u.last for u in updates] == [False, False, False, True]
    costs = [u.cost for u in updates]
    assert costs == sorted(costs, reverse=True)
    long = Search(samples=64, iterations=10_000)
    updates = scene.twin.stream_plan(**scene.ask, search=long)
    assert not next(updates).last
    updates.close()
    deadline = Search(samples=8, iterations=10_000, deadline_s=0.5)
    plan = scene.twin.plan(**scene.ask, search=deadline)
    assert plan.stopped_by_deadline
    assert plan.cost <= plan.nominal_cost


@needs_server
@pytest.mark.parametrize("ensure", ["Together", "PerHand", "Grippers", "Points"])
def test_plans_of_the_server_are_in_the_coordinates_of_the_space(scene, ensure):
    hands = scene.twin.geometry().hands
    space = {
        "Together": lambda: Together(scene.controls),
        "PerHand": lambda: PerHand(scene.controls, hands),
        "Grippers": lambda: Grippers.around(scene.controls, hands),
        "Points": lambda: Points(scene.controls),
    }[ensure]()
    task = Task(twin=scene.twin, costs=scene.costs, space=space, frames=FRAMES)
    planner = OnServer(task, knots=3, search=Search(samples=16, bounds=Bounds(low=-0.2, high=0.2)))
    plan = planner.plan()
    assert plan.cost < plan.nominal_cost
    assert (plan.stopped, plan.iterations) == ("iterations", 1)
    # The space here has the same mathematics.
    again = scene.twin.rollout(**plan.actions(), costs=scene.costs)
    assert again.costs[0] == pytest.approx(plan.cost, rel=1e-4)
    planner.shift(3)
    assert planner.plan().cost <= 1.001 * planner.plan().nominal_cost


@needs_server
def test_a_session_is_planned_from_without_sending_states(scene):
    search = Search(samples=16, seed=3)
    with scene.client.open_session(scene.twin, initial=Settled(), slots=2) as session:
        nominal, arguments = scene.nominal, {"frames": FRAMES, "costs": scene.costs}
        for step in range(3):
            state = session.states([1])[0]
            plan = session.plan(
                slot=1,
                trajectories=nominal,
                shift_frames=2 if step else 0,
                search=search,
                space="together",
                **arguments,
            )
            np.testing.assert_array_equal(plan.knots[0, 0], state.controls)
            assert plan.cost <= plan.nominal_cost
            # As from the state itself.
            given = scene.twin.rollout(**plan.actions, initial=state, **arguments)
            assert given.costs[0] == plan.cost
            session.advance(slots=[1], trajectories=interpolate(plan.knots, FRAMES)[:, :3])
            nominal = plan.knots
        with pytest.raises(TypeError, match="initial is that of the session"):
            session.plan(trajectories=nominal, initial=Settled(), **arguments)
    with pytest.raises(BendTwinError) as lost:
        session.plan(trajectories=nominal, **arguments)
    assert lost.value.reason == "SESSION_LOST"


@needs_server
def test_the_client_of_asyncio_plans_the_same(scene):
    expected = scene.twin.plan(**scene.ask, search=Search(samples=8, seed=5))

    async def run():
        async with aio.Client(scene.address) as client:
            twin = await client.twin(scene.twin.name)
            plan = await twin.plan(**scene.ask, search=Search(samples=8, seed=5))
            updates = twin.stream_plan(**scene.ask, search=Search(samples=8, seed=5))
            last = [update async for update in updates][-1]
            async with await client.open_session(twin) as session:
                from_session = await session.plan(**scene.ask, search=Search(samples=8, seed=5))
            return plan, last, from_session

    for plan in asyncio.run(run()):
        np.testing.assert_array_equal(plan.knots, expected.knots)
        assert plan.cost == expected.cost


@needs_server
def test_refusals_say_what_to_do(scene):
    def reason(**arguments):
        with pytest.raises(BendTwinError) as refused:
            scene.twin.plan(**{**scene.ask, **arguments})
        return refused.value.reason

    two = np.repeat(scene.nominal, 2, axis=0)
    assert reason(trajectories=two) == "INVALID_PLAN"
    assert reason(search=Search(sigma=[0.1, 0.1])) == "INVALID_PLAN"
    assert reason(costs=[]) == "INVALID_PLAN"
    assert reason(search=Search(samples=100_000)) == "ROLLOUT_TOO_LARGE"
    assert reason(search=Search(iterations=1_000_000)) == "ROLLOUT_TOO_LARGE"
    assert reason(frames=100_001) == "INVALID_ROLLOUT"
    # Not one plan stays within what is said to be possible.
    nothing = Plausibility(control_speed_m_s=0.0, strain=0.0, refuse=True)
    assert reason(plausibility=nothing) == "EVERY_PLAN_DIVERGED"
    long = Search(samples=64, iterations=10_000)
    with pytest.raises(BendTwinError) as late:
        scene.twin.plan(**scene.ask, search=long, timeout_s=0.5)
    assert late.value.category is Category.DEADLINE_EXCEEDED
