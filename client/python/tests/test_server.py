"""Against the real `bendtwin`, named by BENDTWIN_BIN: one server with its own worker."""

import asyncio
import json
import os
import signal
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bendtwin import (
    BendTwinError,
    CaptureFrame,
    Category,
    Client,
    JobState,
    Keypoints,
    Motion,
    Returns,
    Settled,
    Smoothness,
    aio,
    interpolate,
)
from bendtwin.planners import (
    Bounds,
    Cem,
    GradientDescent,
    Mppi,
    PredictiveSampling,
    Task,
    Together,
)

BINARY = os.environ.get("BENDTWIN_BIN")
START_S = 60
SETTINGS = {
    "graph": {"max_nodes": 30},
    "search": {"generations": 3, "population": 6},
    "refine": {"passes": 2},
}

pytestmark = pytest.mark.skipif(not BINARY, reason="BENDTWIN_BIN names no binary")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("bendtwin")


@pytest.fixture(scope="module")
def client(folder):
    port_file = folder / "port"
    command = [BINARY, "server", "--listen", "127.0.0.1:0", "--port-file", port_file]
    with (folder / "log").open("w") as log:
        server = subprocess.Popen([*command, "--data-dir", folder / "data"], stdout=log, stderr=log)
    (folder / "pid").write_text(str(server.pid))
    try:
        deadline = time.monotonic() + START_S
        while not port_file.exists():
            assert server.poll() is None, (folder / "log").read_text()
            assert time.monotonic() < deadline, "the server does not start"
            time.sleep(0.05)
        with Client(f"127.0.0.1:{port_file.read_text().strip()}") as client:
            yield client
    finally:
        server.terminate()
        server.wait(START_S)


@pytest.fixture(scope="module")
def twin(client, folder):
    archive = folder / "rope.zip"
    subprocess.run([BINARY, "capture", "make", "rope", archive, "--tiny"], check=True)
    capture = client.upload_capture(archive, request_id="rope")
    assert client.upload_capture(archive, request_id="rope").name == capture.name
    assert [c.name for c in client.captures()] == [capture.name]
    read = client.wait_for_capture(capture, timeout_s=120)
    assert read.verdict in ("good", "usable")
    assert client.capture_report(capture.name)["verdict"] == read.verdict
    seen = []
    fit = client.wait(client.fit(capture.name, SETTINGS), timeout_s=120, on_progress=seen.append)
    assert fit.state is JobState.SUCCEEDED
    assert seen[-1].state is JobState.SUCCEEDED
    assert fit.job.settings["graph"]["max_nodes"] == 30
    curves = {(c.stage, c.variant): c for c in client.fit_losses(fit)}
    assert {stage for stage, _ in curves} == {"search", "refine"}
    assert all(np.isfinite(curve.best_losses).all() for curve in curves.values())
    twin = client.twin(fit.twin)
    assert [t.name for t in client.twins(capture.name)] == [twin.name]
    assert twin.info.quality["scores"]
    return twin


def test_motion_capture_becomes_an_observation(client):
    frames, points = 40, 12
    t = np.linspace(0, 1, frames)[:, None]
    along = np.linspace(0, 0.3, points)[None, :]
    rope = np.stack([along + 0 * t, 0.05 * np.sin(3 * along + 4 * t), 0.3 - 0.1 * along * t], 2)
    rope[5, 3] = np.nan
    motion = Motion(rope, controls=rope[:, :1], visible=np.isfinite(rope).all(axis=2))
    edges = [[i, i + 1] for i in range(points - 1)]
    capture = client.upload_motion([motion, motion], fps=60, display_name="two ropes", edges=edges)
    assert capture.display_name == "two ropes"
    assert client.wait_for_capture(capture, timeout_s=120).verdict in ("good", "usable")
    client.delete_capture(capture.name)


def still(twin, client, folder, batch=4, frames=6):
    """Control points that stay where they are at rest, [B, F + 1, C, 3]."""
    path = folder / "twin.safetensors"
    client.export_twin(twin.name, path)
    rest = rest_controls(path.read_bytes())
    return np.tile(rest, (batch, frames + 1, 1, 1))


def rest_controls(file):
    """Reads one array of the file as docs/formats/twin.md says."""

    length = int.from_bytes(file[:8], "little")
    entry = json.loads(file[8 : 8 + length])["controls.rest_position"]
    start, end = (8 + length + offset for offset in entry["data_offsets"])
    return np.frombuffer(file[start:end], "<f4").reshape(entry["shape"])


def test_a_batch_is_predicted_with_costs_positions_and_gradients(twin, client, folder):
    actions = still(twin, client, folder)
    lift = np.linspace(0, 0.02, 7)[None, :] * np.arange(4)[:, None]
    actions[..., 2] += lift[..., None]
    result = twin.rollout(
        trajectories=actions,
        costs=[Keypoints(nodes=[0], targets=[[0, 0, 1]], name="up")],
        returns=Returns(every_frames=2, final_state=True, diagnostics=True, control_gradients=True),
    )
    nodes, controls = twin.info.node_count, twin.info.control_count
    assert result.costs.shape == (4,)
    assert result.cost_names == ["up"]
    assert result.positions.shape == (4, 3, nodes, 3)
    np.testing.assert_array_equal(result.frames, [2, 4, 6])
    assert result.final_velocities.shape == (4, nodes, 3)
    assert result.control_gradients.shape == (4, 7, controls, 3)
    assert np.isfinite(result.control_gradients).all()
    assert len(result.diagnostics) == 4
    assert not result.diverged
    np.testing.assert_array_equal(result.positions[:, -1], result.final_positions)


def test_half_size_positions_are_as_close_as_promised(twin, client, folder):
    actions = still(twin, client, folder, batch=1)
    exact = twin.rollout(trajectories=actions, returns=Returns(every_frames=1)).positions
    half = twin.rollout(
        trajectories=actions, returns=Returns(every_frames=1, encoding="int16")
    ).positions
    extent = np.ptp(exact)
    np.testing.assert_allclose(half, exact, atol=extent / 65535 + 1e-7)


def test_a_rollout_may_start_in_a_frame_of_the_capture(twin):
    poses = np.zeros((2, 2, 1, 7), np.float32)
    poses[..., 6] = 1
    parts = list(
        twin.stream_rollout(
            poses=poses,
            frames=3,
            initial=CaptureFrame(frame=2),
            costs=[Keypoints(nodes=[0], targets=[[0, 0, 0]])],
        )
    )
    assert sum(len(part.costs) for part in parts) == 2


def test_parts_in_time_are_those_of_the_whole(twin):
    poses = swing(12)
    returns = Returns(every_frames=2, velocities=True, frame_costs=True, final_state=True)
    costs = [
        Keypoints(nodes=[0], targets=[[0, 0, 0]], when="every_frame"),
        Smoothness(when="every_frame"),
    ]
    request = {"poses": poses, "initial": Settled(), "costs": costs, "returns": returns}
    whole = twin.rollout(**request)
    parts = list(twin.stream_rollout(**request, part_frames=4))
    assert [part.window for part in parts] == [(1, 4), (5, 8), (9, 12)]
    for name in ("positions", "velocities", "frame_costs"):
        joined = np.concatenate([getattr(part, name) for part in parts], axis=1)
        np.testing.assert_array_equal(joined, getattr(whole, name))
    np.testing.assert_array_equal(np.concatenate([p.frames for p in parts]), whole.frames)
    assert [len(part.costs) for part in parts] == [0, 0, 2]
    np.testing.assert_array_equal(parts[-1].costs, whole.costs)
    np.testing.assert_array_equal(parts[-1].final_positions, whole.final_positions)
    assert parts[0].final_positions is None
    with pytest.raises(BendTwinError, match="part_frames"):
        list(twin.stream_rollout(**request, part_frames=3))


def test_what_is_done_at_a_time_limit_comes_back(twin):
    poses = np.repeat(swing(300, batch=1), 200, axis=0)
    request = {"poses": poses, "costs": [Keypoints(nodes=[0], targets=[[0, 0, 0]])]}
    limited = twin.rollout(**request, time_limit_s=0.2)
    done = np.isfinite(limited.costs)
    done[limited.unfinished] = False
    assert len(limited.unfinished) + done.sum() == 200
    assert np.all(np.isinf(limited.costs[limited.unfinished]))
    if done.any():
        first = int(np.flatnonzero(done)[0])
        alone = twin.rollout(poses=poses[first : first + 1], costs=request["costs"])
        assert alone.costs[0] == limited.costs[first]
    assert twin.rollout(**request | {"poses": poses[:2]}).unfinished is None


@pytest.fixture
def task(twin, client, folder):
    """Brings a node 4 cm away from where it comes to be when nothing moves."""
    rest = still(twin, client, folder, batch=1, frames=1)
    end = twin.rollout(trajectories=rest, frames=10, returns=Returns(final_state=True))
    goal = end.final_positions[0, :1] + np.array([[0.03, 0.0, 0.03]])
    costs = [Keypoints(nodes=[0], targets=goal)]
    return Task(twin=twin, costs=costs, space=Together(rest[0, 0]), frames=10)


@pytest.mark.parametrize(
    "method",
    [
        lambda task, **s: Mppi(task, samples=16, iterations=3, **s),
        lambda task, **s: Cem(task, samples=16, elites=4, iterations=3, **s),
        lambda task, **s: PredictiveSampling(task, samples=16, iterations=3, **s),
        lambda task, **s: GradientDescent(task, iterations=8, rate=0.005, **s),
    ],
    ids=["mppi", "cem", "predictive sampling", "gradient"],
)
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def swing(frames, batch=2):
    """A gripper that moves and turns, with a pose at every frame, [B, F + 1, 1, 7]."""
    t = np.linspace(0, 1, frames + 1)[None, :] * np.arange(1, batch + 1)[:, None]
    zero = np.zeros_like(t)
    return np.stack(
        [0.02 * t, 0.01 * t, 0.3 + 0.01 * t, zero, np.sin(0.1 * t), zero, np.cos(0.1 * t)], axis=-1
    )[:, :, None].astype(np.float32)


def test_poses_go_on_from_a_state_exactly(twin):
    assert twin.geometry().pins.shape == (0, 2)
    final = Returns(final_state=True)
    poses = swing(10)
    whole = twin.rollout(poses=poses, initial=Settled(), returns=final)
    first = twin.rollout(poses=poses[:, :5], initial=Settled(), returns=final)
    second = twin.rollout(poses=poses[:, 4:], initial=first.states(), returns=final)
    np.testing.assert_array_equal(second.final_positions, whole.final_positions)
    np.testing.assert_array_equal(second.final_velocities, whole.final_velocities)
    np.testing.assert_array_equal(second.final_controls, whole.final_controls)
    alone = twin.rollout(poses=poses[1:, 4:], initial=first.state(1), returns=final)
    np.testing.assert_array_equal(alone.final_positions[0], whole.final_positions[1])


def test_knots_are_executed_as_interpolated_here(twin):
    knots = np.repeat(twin.geometry().controls[None, None], 4, axis=1)
    knots = knots + np.array([0.0, 0.01, 0.005, 0.02])[None, :, None, None]
    fps = twin.geometry().fps
    at_s = np.array([0.0, 2.0, 3.5, 6.0], np.float32) / np.float32(fps)
    for interpolation in ("linear", "cubic", "zero"):
        for frames in (3, 5):
            options = {"at_s": at_s, "interpolation": interpolation, "frames": frames}
            result = twin.rollout(trajectories=knots, returns=Returns(final_state=True), **options)
            expected = interpolate(knots, fps=fps, **options)
            np.testing.assert_allclose(result.final_controls, expected[:, -1], atol=1e-7)


@pytest.mark.parametrize(
    "method",
    [
        lambda task, **s: Mppi(task, samples=16, iterations=3, **s),
        lambda task, **s: Cem(task, samples=16, elites=4, iterations=3, **s),
        lambda task, **s: PredictiveSampling(task, samples=16, iterations=3, **s),
        lambda task, **s: GradientDescent(task, iterations=8, rate=0.005, **s),
    ],
    ids=["mppi", "cem", "predictive sampling", "gradient"],
)
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_planning_lowers_the_cost(twin, task, method, interpolation):
    task = replace(task, interpolation=interpolation)
    planner = method(task, knots=3, sigma=0.02, bounds=Bounds(low=-0.2, high=0.2))
    plan = planner.plan()
    assert plan.cost < 0.9 * plan.nominal_cost
    # The plan is executed as it was simulated, by its knots and frame by frame.
    again = twin.rollout(**plan.actions(), costs=task.costs, returns=Returns(every_frames=1))
    assert again.costs[0] == plan.cost
    # Rounding of the actions grows in contacts: only the first frames are near enough.
    dense = twin.rollout(**plan.actions(frames=2), returns=Returns(every_frames=1))
    np.testing.assert_allclose(dense.positions, again.positions[:, :2], atol=5e-4)


def test_the_client_of_asyncio_gets_the_same(client, twin, folder):
    actions = still(twin, client, folder, batch=3)
    expected = twin.rollout(trajectories=actions, returns=Returns(final_state=True))

    async def main():
        async with aio.Client(client._address) as other:
            names = [t.name async for t in other.twins(twin.info.capture)]
            same = await other.twin(names[0])
            imported = await other.import_twin(folder / "twin.safetensors")
            await other.delete_twin(imported.name)
            calls = [
                same.rollout(trajectories=actions, returns=Returns(final_state=True))
                for _ in range(3)
            ]
            parts = [part async for part in same.stream_rollout(trajectories=actions)]
            return await asyncio.gather(*calls), sum(len(part.costs) for part in parts)

    results, streamed = asyncio.run(main())
    for result in results:
        np.testing.assert_array_equal(result.final_positions, expected.final_positions)
    assert streamed == 3


def test_refusals_carry_the_servers_reason(client, twin):
    with pytest.raises(BendTwinError) as refused:
        client.fit(twin.info.capture, {"graph": {"radius": 1}})
    assert refused.value.category is Category.INVALID_ARGUMENT
    assert refused.value.reason == "INVALID_SETTINGS"
    assert refused.value.request_id
    with pytest.raises(BendTwinError) as refused:
        twin.rollout(trajectories=np.zeros((1, 2, 1, 3)))
    assert refused.value.category is Category.INVALID_ARGUMENT


def test_fits_are_cancelled_and_workers_are_listed(client, twin):
    assert [w.backend for w in client.workers()] == ["cpu"]
    fit = client.fit(twin.info.capture, {"search": {"generations": 10000}})
    client.cancel_fit(fit.name)
    states = [f.state for f in client.watch(fit.name, timeout_s=30)]
    assert states[-1] is JobState.CANCELLED
    client.delete_fit(fit.name)
    assert fit.name not in [f.name for f in client.fits(twin.info.capture)]


def test_a_session_is_advanced_and_planned_from(twin, client):
    rest = twin.geometry().controls
    path = rest[None] + np.arange(7)[:, None, None] * np.array([0, 0, 0.002])
    whole = twin.rollout(trajectories=path[None], returns=Returns(final_state=True))
    with client.open_session(twin, slots=3, idle_timeout_s=60) as session:
        for first in (0, 3):
            part = path[None, first : first + 4]
            session.advance(trajectories=part, returns=Returns(final_state=True))
        state = session.states([0])[0]
        np.testing.assert_array_equal(state.positions, whole.final_positions[0])
        assert session.refresh().frames == (6, 0, 0)
        # From there, as from the state itself; and nothing has moved.
        ahead = np.stack(
            [path[6] + np.arange(4)[:, None, None] * np.array([0.003 * b, 0, 0]) for b in (1, 2)]
        )
        returns = Returns(final_state=True)
        planned = session.rollout(trajectories=ahead, returns=returns)
        given = twin.rollout(trajectories=ahead, initial=state, returns=returns)
        np.testing.assert_array_equal(planned.final_positions, given.final_positions)
        session.fork(0)
        several = session.advance(trajectories=ahead, slots=[2, 1], returns=returns)
        states = session.states()
        np.testing.assert_array_equal(states[2].positions, several.final_positions[0])
        np.testing.assert_array_equal(states[1].positions, several.final_positions[1])
        np.testing.assert_array_equal(states[0].positions, state.positions)
        # Frame by frame over one connection, each when the one before has been answered.
        taken, asked = [], []

        def steps():
            for f in range(3):
                asked.append(len(taken))
                yield {"trajectories": ahead[:1, f : f + 2]}

        for reply in session.control(steps()):
            taken.append(reply)
        assert asked == [0, 1, 2]
        with pytest.raises(ValueError, match="give either trajectories or poses"):
            list(session.control([{"frames": 2}]))
        np.testing.assert_array_equal(session.states([0])[0].positions, states[2].positions)
        session.reset()
        np.testing.assert_array_equal(
            session.states([1])[0].positions, twin.geometry().rest_positions
        )
        with pytest.raises(BendTwinError) as refused:
            session.advance(trajectories=ahead, slots=[0])
        assert refused.value.category is Category.INVALID_ARGUMENT
        with pytest.raises(TypeError, match="initial is that of the session"):
            session.advance(trajectories=ahead, initial=state)
    with pytest.raises(BendTwinError) as lost:
        session.refresh()
    assert lost.value.reason == "SESSION_LOST"


def test_sessions_of_asyncio_do_the_same(client, twin):
    rest = twin.geometry().controls
    path = rest[None] + np.arange(4)[:, None, None] * np.array([0.002, 0, 0])
    expected = twin.rollout(trajectories=path[None], returns=Returns(final_state=True))

    async def steps():
        for f in range(3):
            yield {"trajectories": path[None, f : f + 2]}

    async def run():
        async with aio.Client(client._address) as other:
            of = await other.twin(twin.name)
            async with await other.open_session(of, slots=2) as session:
                replies = [reply async for reply in session.control(steps())]
                await session.fork(0)
                ahead = await session.rollout(trajectories=path[None, 3:].repeat(2, axis=1))
                return len(replies), await session.states(), ahead

    count, states, ahead = asyncio.run(run())
    assert count == 3
    assert np.isfinite(ahead.costs).all()
    for state in states:
        np.testing.assert_array_equal(state.positions, expected.final_positions[0])


def workers_of(server):
    """Process ids of the workers of a server, as Linux tells."""
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            pid, _, rest = status.read_text().partition(" ")
        except OSError:
            continue
        if int(rest.rpartition(")")[2].split()[1]) == server:
            yield int(pid)


@pytest.mark.skipif(not Path("/proc").exists(), reason="processes are found as on Linux")
def test_a_session_is_lost_with_its_worker_and_opened_again(client, twin, folder):
    rest = twin.geometry().controls
    path = rest[None] + np.arange(7)[:, None, None] * np.array([0.002, 0, 0.002])
    returns = Returns(final_state=True)
    whole = twin.rollout(trajectories=path[None], returns=returns)
    session = client.open_session(twin, slots=3)
    name = session.name
    session.advance(trajectories=path[None, :4], slots=[2], returns=returns)
    session.advance(trajectories=path[None, :3], slots=[1])
    for worker in workers_of(int((folder / "pid").read_text())):
        os.kill(worker, signal.SIGKILL)
    deadline = time.monotonic() + START_S
    while True:
        try:
            session.advance(trajectories=path[None, 3:], slots=[2])
            pytest.fail("the session outlived its worker")
        except BendTwinError as error:
            # The connection breaks first; then it is known that nobody has the session.
            if error.reason == "SESSION_LOST":
                break
            if error.category is not Category.UNAVAILABLE:
                raise
        assert time.monotonic() < deadline, "nobody says that the session is lost"
        time.sleep(0.05)
    while True:
        try:
            behind = session.reopen()
            break
        except BendTwinError as error:
            if error.category is not Category.UNAVAILABLE:
                raise
            assert time.monotonic() < deadline, "no worker comes back"
            time.sleep(0.1)
    with session:
        # Nobody was told where slot 1 was after its two frames.
        assert (behind, session.name != name) == ([0, 2, 0], True)
        end = session.advance(trajectories=path[None, 3:], slots=[2], returns=returns)
        np.testing.assert_array_equal(end.final_positions, whole.final_positions)
        np.testing.assert_array_equal(
            session.states([1])[0].positions, twin.geometry().rest_positions
        )
