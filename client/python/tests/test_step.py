"""Steps of closed loops: their requests, and loops with a real server and its own worker."""

import asyncio

import numpy as np
import pytest
from server import needs_server, with_rope

from bendtwin import (
    BendTwinError,
    Clearance,
    Collider,
    Keypoints,
    Returns,
    Search,
    Settled,
    Sphere,
    World,
    aio,
)
from bendtwin.simulation.step import step_session

STILL = np.zeros((1, 3, 2, 3), np.float32)
POINTS = np.array([[0.1, 0.0, 0.2], [0.2, 0.0, 0.2], [np.nan] * 3])
FRAMES, STEP = 10, 3


def message(points=None, search=None, **arguments):
    defaults = {
        "frames": 2,
        "correct": None,
        "returns": None,
        "deadline_s": None,
        "see": lambda _: None,
    }
    search = {"trajectories": STILL, "frames": 8} if search is None else search
    return step_session("sessions/s", 1, points, search, **{**defaults, **arguments}).request


def test_a_step_becomes_a_message():
    returns = Returns(controls=True)
    request = message(POINTS, correct={"carry": 0.5}, returns=returns, deadline_s=0.1)
    assert (request.name, request.slot, request.execute_frames) == ("sessions/s", 1, 2)
    assert request.deadline_s == 0.1
    assert request.returns.controls
    assert request.correction.options.carry == 0.5
    assert list(request.correction.observation.points.shape) == [2, 3]
    assert not request.correction.name
    rollout = request.search.rollout
    assert not rollout.twin
    assert not rollout.HasField("initial")
    assert not rollout.HasField("returns")
    # That of the session, unless the search says another.
    assert rollout.fidelity == 0
    fast = message(search={"trajectories": STILL, "fidelity": "fast"})
    assert fast.search.rollout.fidelity != 0
    assert not message().HasField("correction")
    assert not message().HasField("returns")


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"search": {"trajectories": STILL, "initial": Settled()}}, TypeError),
        ({"search": {"trajectories": STILL, "returns": Returns()}}, TypeError),
        ({"search": {"trajectories": STILL, "horizon": 3}}, TypeError),
        ({"correct": {"carry": 0.5}}, TypeError),
        ({"points": POINTS, "correct": {"near": True}}, TypeError),
        ({"deadline_s": 0.0}, ValueError),
        ({"frames": -1}, ValueError),
    ],
)
def test_what_is_wrong_is_refused_before_it_is_sent(wrong, error):
    with pytest.raises(error):
        message(**wrong)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A twin that lies still, and a search that brings its end 4 cm away."""
    with with_rope(tmp_path_factory.mktemp("steps")) as scene:
        still = {"trajectories": scene.nominal, "initial": Settled()}
        lying = scene.twin.rollout(**still, frames=1, returns=Returns(final_state=True))
        scene.state = lying.state(0)
        goal = scene.state.positions[:1] + np.array([0.03, 0.0, 0.03])
        scene.search = {
            "trajectories": scene.nominal,
            "frames": FRAMES,
            "costs": [Keypoints(nodes=[0], targets=goal)],
            "space": "together",
            "search": Search(samples=16, seed=3),
        }
        yield scene


@needs_server
def test_a_loop_of_steps_is_one_of_its_parts(scene):
    client, twin, state = scene.client, scene.twin, scene.state
    nodes = np.arange(len(state.positions))
    seen = state.positions + np.array([0.004, 0.0, 0.0])
    correct = {"nodes": nodes}
    with (
        client.open_session(twin, initial=state, slots=2) as whole,
        client.open_session(twin, initial=state, slots=2) as parts,
    ):
        asked = dict(scene.search)
        for round_ in range(3):
            step = whole.step(
                seen,
                asked,
                frames=STEP,
                slot=1,
                correct=correct,
                returns=Returns(controls=True),
            )
            [correction] = parts.correct(seen, slots=[1], **correct)
            assert step.correction.after == correction.after
            assert (step.refused, step.lost) == (None, False)
            plan = parts.plan(slot=1, **asked)
            np.testing.assert_array_equal(step.plan.knots, plan.knots)
            assert (step.plan.cost, step.plan.last) == (plan.cost, True)
            # The frames that are executed are those of the plan.
            (here,) = parts.states([1])
            planned = twin.rollout(
                **plan.actions, frames=FRAMES, initial=here, returns=Returns(controls=True)
            ).controls
            executed = step.advanced.controls
            np.testing.assert_allclose(executed, planned[:, : STEP + 1], rtol=0, atol=1e-6)
            parts.advance(trajectories=executed, slots=[1])
            mine, theirs = whole.states()[1], parts.states()[1]
            np.testing.assert_array_equal(step.state.positions, mine.positions)
            np.testing.assert_array_equal(step.state.velocities, mine.velocities)
            np.testing.assert_array_equal(step.state.controls, mine.controls)
            np.testing.assert_allclose(mine.positions, theirs.positions, rtol=0, atol=1e-5)
            assert whole.refresh().frames == (0, STEP * (round_ + 1))
            assert step.total_s >= step.correct_s + step.plan_s + step.advance_s > 0.0
            asked = step.search
            assert asked["shift_frames"] == STEP
            np.testing.assert_array_equal(asked["trajectories"], plan.knots)
            seen = step.state.positions
        # It is opened again where the last step ended.
        whole.reopen()
        np.testing.assert_array_equal(whole.states()[1].positions, step.state.positions)


@needs_server
def test_parts_of_a_step_can_be_left_out_or_be_refused(scene):
    with scene.client.open_session(scene.twin, initial=scene.state) as session:
        step = session.step(None, scene.search, frames=0)
        assert (step.correction, step.advanced) == (None, None)
        np.testing.assert_array_equal(step.state.positions, scene.state.positions)
        assert step.search["shift_frames"] == 0
        away = scene.state.positions + 3.0
        step = session.step(away, scene.search, frames=STEP)
        assert step.correction is None
        assert step.refused.reason == "OBSERVATION_NOT_EXPLAINED"
        assert step.advanced is not None
        assert session.refresh().frames == (STEP,)
        long = {**scene.search, "search": Search(samples=32, iterations=10_000)}
        step = session.step(None, long, frames=STEP, deadline_s=0.5)
        assert step.plan.stopped_by_deadline
        assert step.advanced is not None
        for wrong, reason in (
            ({"frames": FRAMES + 1}, "INVALID_FIELD"),
            ({"slot": 1}, "INVALID_FIELD"),
            ({"returns": Returns(best=1)}, "INVALID_ROLLOUT"),
        ):
            with pytest.raises(BendTwinError) as refused:
                session.step(away, scene.search, **wrong)
            assert refused.value.reason == reason
        assert session.refresh().frames == (2 * STEP,)
    with pytest.raises(BendTwinError) as lost:
        session.step(None, scene.search)
    assert lost.value.reason == "SESSION_LOST"


@needs_server
def test_costs_see_the_world_of_the_session(scene):
    """A ball beside the end of the rope: the plan that goes through it costs more."""
    near = scene.state.positions[0] + np.array([0.0, 0.0, 0.06])
    ball = Collider(shape=Sphere(0.03, near))
    keeps_away = Clearance(collider=0, margin_m=0.05)
    search = {**scene.search, "costs": [*scene.search["costs"], keeps_away]}
    world = World(colliders=[ball])
    with scene.client.open_session(scene.twin, initial=scene.state, world=world) as session:
        actions = {"trajectories": search["trajectories"], "frames": FRAMES}
        inside = session.rollout(**actions, costs=search["costs"])
        given = scene.twin.rollout(
            **actions, costs=search["costs"], initial=scene.state, world=world
        )
        np.testing.assert_array_equal(inside.cost_terms, given.cost_terms)
        assert inside.cost_terms[0, 1] > 0.0
        plan = session.plan(**search)
        assert plan.cost <= plan.nominal_cost
        step = session.step(None, search, frames=STEP)
        assert step.plan.cost == plan.cost
    with pytest.raises(BendTwinError, match="names collider 0"):
        scene.twin.plan(**search, initial=scene.state)


@needs_server
def test_the_client_of_asyncio_takes_the_same_steps(scene):
    with scene.client.open_session(scene.twin, initial=scene.state) as session:
        expected = session.step(None, scene.search, frames=STEP)

    async def run():
        async with aio.Client(scene.address) as client:
            twin = await client.twin(scene.twin.name)
            async with await client.open_session(twin, initial=scene.state) as session:
                return await session.step(None, scene.search, frames=STEP)

    step = asyncio.run(run())
    np.testing.assert_array_equal(step.plan.knots, expected.plan.knots)
    np.testing.assert_array_equal(step.state.positions, expected.state.positions)
