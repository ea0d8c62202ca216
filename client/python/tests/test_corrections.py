"""Registrations and corrections against the real `bendtwin`, named by BENDTWIN_BIN."""

import asyncio
import json
import urllib.error
import urllib.request

import numpy as np
import pytest
from server import make_rope, needs_server, running

from bendtwin import (
    BendTwinError,
    Category,
    Client,
    Collider,
    Cuboid,
    JobState,
    Returns,
    World,
    aio,
)

SETTINGS = {
    "graph": {"max_nodes": 30},
    "search": {"generations": 3, "population": 6},
    "refine": {"passes": 2},
}

pytestmark = needs_server


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    with running(tmp_path_factory.mktemp("bendtwin")) as address, Client(address) as client:
        yield client


@pytest.fixture(scope="module")
def twin(client, tmp_path_factory):
    archive = tmp_path_factory.mktemp("rope") / "rope.zip"
    make_rope(archive)
    capture = client.upload_capture(archive)
    client.wait_for_capture(capture, timeout_s=120)
    fit = client.wait(client.fit(capture.name, SETTINGS), timeout_s=120)
    assert fit.state is JobState.SUCCEEDED
    return client.twin(fit.twin)


@pytest.fixture(scope="module")
def seen(twin):
    """The rope after its hands have moved: what a camera or a tracker would see of it."""
    rest = twin.geometry().controls
    path = rest + np.linspace(0, 1, 13)[:, None, None] * np.array([0.03, 0.06, 0.05])
    result = twin.rollout(trajectories=path[None], returns=Returns(final_state=True))
    return result.state(0)


def test_an_object_is_found_and_rolled_out_from_there(twin, seen):
    by = np.array([0.4, -0.2, 0.0])
    noise = np.random.default_rng(0).normal(0, 0.001, seen.positions.shape)
    points, controls = seen.positions + by + noise, seen.controls + by
    tracked = twin.register(points, nodes=np.arange(len(points)), controls=controls)
    assert tracked.after.median_mm < 5
    assert tracked.before.median_mm > 200
    assert tracked.explained_points > 0.9
    np.testing.assert_array_equal(tracked.state.controls, controls.astype(np.float32))
    hold = np.stack([tracked.state.controls] * 2)[None]
    going_on = twin.rollout(trajectories=hold, frames=5, initial=tracked.state)
    assert np.isfinite(going_on.costs).all()
    assert not going_on.implausible
    # A cloud, some points of which were not seen, from a start that is near.
    surface = points[: twin.geometry().surface_count].copy()
    surface[::7] = np.nan
    found = twin.register(surface, initial=tracked.state, near=True, cameras=[[0.4, -0.2, 1.0]])
    assert found.after.median_mm < 8
    assert 0 < found.explained_surface <= 1
    # Places that were bound when the object was elsewhere.
    bound = twin.register(points, places=seen.positions + noise, node_positions=seen.positions)
    assert bound.after.median_mm < 5


def test_what_is_not_the_object_is_refused(twin, seen):
    scattered = np.random.default_rng(1).uniform(-5, 5, (50, 3))
    with pytest.raises(BendTwinError) as refused:
        twin.register(scattered)
    assert refused.value.reason == "OBSERVATION_NOT_EXPLAINED"
    assert refused.value.category is Category.FAILED_PRECONDITION
    with pytest.raises(BendTwinError) as refused:
        twin.register(seen.positions[:2], nodes=[0, 10**6])
    assert refused.value.reason == "INVALID_OBSERVATION"
    with pytest.raises(BendTwinError) as refused:
        twin.register(seen.positions, noise_m=-1.0)
    assert refused.value.reason == "INVALID_OBSERVATION"


def test_a_session_is_corrected_by_what_is_seen(twin, client, seen):
    nodes = np.arange(len(seen.positions))
    bend = 0.02 * np.sin(np.linspace(0, 3, len(nodes)))[:, None] * np.array([1.0, 0, 0])
    points = seen.positions + bend
    with client.open_session(twin, initial=seen, slots=2) as session:
        with pytest.raises(BendTwinError) as refused:
            session.correct(points, nodes=nodes, slots=[0, 1], max_residual_m=0.0)
        assert refused.value.reason == "OBSERVATION_NOT_EXPLAINED"
        for state in session.states():
            np.testing.assert_array_equal(state.positions, seen.positions)
        [correction] = session.correct(points, nodes=nodes, slots=[1])
        assert correction.slot == 1
        assert correction.moved_mm > 1
        assert correction.after.mean_mm < 0.8 * correction.before.mean_mm
        kept, moved = session.states()
        np.testing.assert_array_equal(kept.positions, seen.positions)
        np.testing.assert_array_equal(moved.controls, seen.controls)
        left = np.linalg.norm(moved.positions - points, axis=1).mean()
        assert left == pytest.approx(correction.after.mean_mm / 1000, rel=1e-3)
        hold = np.stack([seen.controls] * 2)[None]
        assert not session.advance(trajectories=hold, frames=2, slots=[1]).implausible

        def ends_after(carry):
            session.reset()
            for _ in range(3):
                session.correct(points, nodes=nodes, carry=carry)
                session.advance(trajectories=hold, frames=2, returns=Returns(final_state=True))
            [state] = session.states([0])
            return np.linalg.norm(state.positions - points, axis=1).mean()

        assert ends_after(1.0) < ends_after(0.0)
        with pytest.raises(BendTwinError) as refused:
            session.correct(points, nodes=nodes, carry=1.5)
        assert refused.value.reason == "INVALID_OBSERVATION"

    async def same():
        async with aio.Client(client._address) as other:
            theirs = await other.twin(twin.name)
            found = await theirs.register(seen.positions, nodes=nodes, near=True)
            async with await other.open_session(theirs, initial=found.state) as session:
                return await session.correct(points, nodes=nodes)

    assert asyncio.run(same())[0].after.mean_mm < 20


def test_what_is_found_and_corrected_is_outside_of_obstacles(twin, client, seen):
    nodes = np.arange(len(seen.positions))
    # A wall beside the rope, and points behind its surface.
    wall = np.float32(seen.positions[:, 1].max() + 0.001)
    box = Collider(shape=Cuboid([-5, wall, -5], [5, wall + 0.004, 5]), name="wall")
    world, points = World(colliders=[box]), seen.positions + np.array([0, 0.012, 0])
    with client.open_session(twin, initial=seen, world=world) as session:
        [correction] = session.correct(points, nodes=nodes)
        assert correction.moved_mm > 0.5
        assert correction.state.positions[:, 1].max() <= wall
        assert not correction.lost
        assert correction.tracking.misfit < 1
        [state] = session.states()
        for name in ("positions", "velocities", "controls"):
            np.testing.assert_array_equal(getattr(correction.state, name), getattr(state, name))
        [quiet] = session.correct(points, nodes=nodes, world=World(), omit_state=True)
        assert quiet.state is None
        assert session.states()[0].positions[:, 1].max() > wall
    # Of a thin one the points say on which side the rope is; in a thick one it cannot be.
    thick = Collider(shape=Cuboid([-5, wall, -5], [5, 5, 5]))
    found = twin.register(points, nodes=nodes, world=World(colliders=[thick]))
    assert found.state.positions[:, 1].max() <= wall


def test_a_session_that_lost_its_object_says_so_and_finds_it_again(twin, client, seen):
    nodes = np.arange(len(seen.positions))
    away = seen.positions + np.array([5, 0, 0])
    reasons = []
    with client.open_session(twin, initial=seen) as session:
        for _ in range(12):
            with pytest.raises(BendTwinError) as refused:
                session.correct(away, nodes=nodes, register_if_lost=True)
            reasons.append(refused.value.reason)
        assert reasons == ["OBSERVATION_NOT_EXPLAINED"] * 2 + ["OBJECT_LOST"] * 10
        assert session.refresh().lost == (0,)
        [state] = session.states()
        np.testing.assert_array_equal(state.positions, seen.positions)
        [found] = session.correct(seen.positions, nodes=nodes, register_if_lost=True)
        assert found.registered
        assert not found.lost
        assert found.after.median_mm < 5
        np.testing.assert_array_equal(found.state.controls, seen.controls)
        assert session.refresh().lost == ()
        session.reopen()
        np.testing.assert_array_equal(session.states()[0].positions, found.state.positions)


def test_http_finds_and_corrects_too(twin, client, seen):
    def post(path, body):
        request = urllib.request.Request(
            f"http://{client._address}/v1/{path}",
            json.dumps(body).encode(),
            {"content-type": "application/json", "authorization": f"Bearer {client._token}"},
        )
        with urllib.request.urlopen(request, timeout=60) as reply:
            return json.load(reply)

    observation = {"points": seen.positions.tolist(), "nodes": list(range(len(seen.positions)))}
    found = post(f"{twin.name}/register", {"observation": observation})
    assert found["after"]["median_mm"] < 5
    given = {"twin": twin.name, "initial": {"given": found["state"]}}
    session = post("sessions", given)["name"]
    corrected = post(f"{session}/correct", {"observation": observation})
    [correction] = corrected["corrections"]
    assert correction["after"]["mean_mm"] <= correction["before"]["mean_mm"]
    assert corrected["session"]["name"] == session
    with pytest.raises(urllib.error.HTTPError) as refused:
        post(f"{session}/correct", {"observation": {"points": [[0, 1]]}})
    assert refused.value.code == 400
    assert json.load(refused.value)["reason"] == "INVALID_OBSERVATION"
