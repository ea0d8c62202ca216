"""A MuJoCo model and a twin together, against a real server: cables of 100 g whose ends bodies of
the model hold."""

import time
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import hanging
from server import START_S, needs_server, running

from bendtwin import BendTwinError, Client, Grasp, Sphere, State
from bendtwin.tensors import unpack

mujoco = pytest.importorskip("mujoco")

from bendtwin.coupling import ClosedWhen, Coupling, CouplingError, Gripper  # noqa: E402

pytestmark = needs_server

MASS_KG, GRAVITY, FPS, LENGTH_M = 0.1, 9.81, 30, 0.3  # Those of the cables.
WEIGHT_N = MASS_KG * GRAVITY


@pytest.fixture(autouse=True)
def folder_of_logs(tmp_path, monkeypatch):
    """MuJoCo writes its warnings to the current folder."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def at(tmp_path_factory):
    folder = tmp_path_factory.mktemp("coupling")
    twins = {
        "soft": hanging(),
        "free": hanging(drag=0.0),
        "stiff": hanging(newtons_per_strain=1500.0),
    }
    with running(folder) as address, Client(address) as client:
        for name, file in twins.items():
            (folder / name).write_bytes(file.encode())
            twins[name] = client.import_twin(folder / name)
        wait_for_worker(client)
        yield SimpleNamespace(client=client, **twins)


def wait_for_worker(client):
    deadline = time.monotonic() + START_S
    while not any(worker.backend for worker in client.workers()):
        assert time.monotonic() < deadline, "no worker starts"
        time.sleep(0.05)


def model_of(bodies, *, timestep=1 / 480, gravity=GRAVITY, more=""):
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{timestep}" gravity="0 0 {-gravity}"/>'
        f"<default><geom contype='0' conaffinity='0'/></default>"
        f"<worldbody>{bodies}</worldbody>{more}</mujoco>"
    )
    return model, mujoco.MjData(model)


def plug(mass_kg, *, joint='type="slide" axis="0 0 1"', z=1.0):
    return (
        f'<body name="plug" pos="0 0 {z}"><joint name="way" {joint}/>'
        f'<geom size="0.01" mass="{mass_kg}"/></body>'
    )


HAND = '<body name="hand" mocap="true" pos="0 0 1"><geom size="0.01"/></body>'
HOLDS_TOP = Gripper(Grasp(nodes=[0]))
HOLDS_END = Gripper(Grasp(nodes=[6]))


def seen(coupling, frames):
    """The frames of a coupling, and everything that could differ between two runs."""
    done = [coupling.step() for _ in range(frames)]
    trace = [
        np.concatenate([coupling.data.qpos, *f.wrenches.values(), np.ravel(f.state.positions)])
        for f in done[-1:]
    ]
    return done, trace[-1]


@pytest.mark.parametrize("iterations", [1, 16])
def test_a_body_feels_the_weight_of_what_it_holds(at, iterations):
    spring = 'type="slide" axis="0 0 1" stiffness="400" damping="40"'
    model, data = model_of(plug(1.0, joint=spring))
    with Coupling(
        model, data, at.client, at.soft, grippers={"plug": HOLDS_TOP}, iterations=iterations
    ) as coupling:
        done, _ = seen(coupling, 60)
    np.testing.assert_allclose(done[-1].wrenches["plug"], [0, 0, -WEIGHT_N, 0, 0, 0], atol=0.02)
    assert data.qpos[0] == pytest.approx(-(GRAVITY + WEIGHT_N) / 400, rel=0.01)
    assert done[-1].held["plug"].tolist() == [0]
    np.testing.assert_allclose(done[-1].positions[0], data.body("plug").xpos, atol=1e-6)


def test_a_weight_beside_the_joint_turns_it(at):
    arm = (
        '<body name="arm" pos="-0.2 0 1" gravcomp="1"><joint type="hinge" axis="0 1 0"'
        ' stiffness="20" damping="2"/><geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.01"'
        ' mass="1"/><site name="tip" pos="0.2 0 0"/></body>'
    )
    model, data = model_of(arm)
    with Coupling(model, data, at.client, at.soft, grippers={"tip": HOLDS_TOP}) as coupling:
        seen(coupling, 60)
    angle = data.qpos[0]
    assert 20 * angle == pytest.approx(WEIGHT_N * 0.2 * np.cos(angle), rel=0.02)


def test_a_falling_body_stops_where_its_cable_is_taut(at):
    model, data = model_of(plug(0.3, joint='type="free"', z=0.9))
    with Coupling(
        model,
        data,
        at.client,
        at.stiff,
        grippers={"plug": HOLDS_END},
        held_hands=[0],
        initial=slack(at.stiff),
    ) as coupling:
        falls = [(coupling.step(), data.qpos[2])[1] for _ in range(10)]
        seen(coupling, 60)
    # Freely at first, at the height of the frame's end.
    assert falls[1] == pytest.approx(0.9 - GRAVITY * (2 / FPS) ** 2 / 2, abs=0.005)
    stretch = LENGTH_M * (0.3 + MASS_KG / 2) * GRAVITY / 1500
    assert data.qpos[2] == pytest.approx(1 - LENGTH_M - stretch, abs=0.001)
    assert abs(data.qvel[2]) < 0.02


def slack(twin):
    """A cable in zigzag, whose end is 10 cm below its top."""
    count = len(twin.geometry().rest_positions)
    down, across = 0.1 / (count - 1), LENGTH_M / (count - 1)
    nodes = np.arange(count)[:, None] * [0.0, 0.0, -down] + [0, 0, 1]
    nodes[1::2, 0] = np.sqrt(across**2 - down**2)
    return State(positions=nodes)


def test_a_mocap_body_leads_the_twin_from_pose_to_pose(at):
    model, data = model_of(HAND, timestep=0.007)
    with Coupling(model, data, at.client, at.free, grippers={"hand": HOLDS_TOP}) as coupling:
        sent, impulse = [], np.zeros(3)
        control = coupling.session._control

        def watched(taken, requests):
            def each():
                for request in requests:
                    sent.append(unpack(request.rollout.poses.poses))
                    yield request

            return control(taken, each())

        coupling.session._control = watched
        for _ in range(6):
            data.mocap_pos[0] += [0.01, 0.0, 0.02]
            frame = coupling.step()
            impulse -= frame.wrenches["hand"][:3] / FPS
            np.testing.assert_allclose(frame.positions[0], data.mocap_pos[0], atol=1e-6)
        assert frame.number == 6
        assert frame.iterations == 1, "nothing moves the hand but the caller"
        assert [p.shape for p in sent] == [(1, 2, 2, 7)] * 6
        for before, after in pairwise(sent):
            np.testing.assert_array_equal(before[0, 1], after[0, 0])
    # It bears the weight, and gives the twin the momentum that it has.
    momentum = MASS_KG * np.mean(frame.state.velocities, axis=0)
    weight = np.array([0, 0, 6 * WEIGHT_N / FPS])
    np.testing.assert_allclose(impulse, momentum + weight, atol=1e-4)


def test_steps_of_the_model_do_not_drift_from_frames(at):
    body = '<body name="glider"><freejoint/><geom size="0.01" mass="1"/></body>'
    model, data = model_of(body, timestep=0.007, gravity=0.0)
    data.qvel[:3] = [0.3, 0, 0]
    with Coupling(
        model, data, at.client, at.soft, grippers={"glider": Gripper()}, feedback=False
    ) as coupling:
        places, steps = [], []
        for i in range(1, 22):
            steps.append(coupling.step().steps)
            assert -1e-9 <= i / FPS - data.time < 0.007
            places.append(coupling._poses[0, 0])
    assert set(steps) == {4, 5}
    # The pose is that of the frame's end, between two steps.
    np.testing.assert_allclose(places, 0.3 * np.arange(1, 22) / FPS, atol=1e-6)


def test_the_same_frames_follow_again_bit_for_bit(at):
    model, data = model_of(plug(0.05, joint='type="free"'))
    data.qvel[0] = 0.5
    holds = {"grippers": {"plug": HOLDS_END}, "held_hands": [0]}
    with Coupling(model, data, at.client, at.soft, **holds, **above()) as coupling:
        _, first = seen(coupling, 6)
        middle = coupling.save()
        _, second = seen(coupling, 4)
        coupling.reset()
        assert data.time == 0.0
        np.testing.assert_array_equal(seen(coupling, 6)[1], first)
        np.testing.assert_array_equal(seen(coupling, 4)[1], second)
        coupling.restore(middle)
        np.testing.assert_array_equal(seen(coupling, 4)[1], second)
        # A session that is lost is opened again where it was.
        coupling.restore(middle)
        coupling.step()
        coupling.session.close()
        np.testing.assert_array_equal(seen(coupling, 3)[1], second)
    with pytest.raises(ValueError, match="closed"):
        coupling.step()
    coupling.close()


def test_a_coupling_needs_neither_grippers_nor_colliders(at):
    model, _ = model_of(HAND)
    with Coupling(model, mujoco.MjData(model), at.client, at.soft, held_hands=[0]) as coupling:
        frame = coupling.step()
    assert frame.wrenches == {}
    assert frame.held == {}
    assert np.asarray(frame.state.positions)[0, 2] == 1.0


def above():
    """Places the model so that its origin at 1 m is the end of the cable."""
    return {"world_in_twin": [0, 0, -LENGTH_M, 0, 0, 0, 1]}


def test_a_turned_world_gives_the_same_forces(at):
    model, data = model_of(HAND)
    turn = [0, 0, np.sin(0.4), np.cos(0.4)]
    with Coupling(
        model,
        data,
        at.client,
        at.soft,
        grippers={"hand": HOLDS_TOP},
        world_in_twin=[*np.zeros(3), *turn],
    ) as coupling:
        for i in range(12):
            data.mocap_pos[0, 0] = 0.5 * 4.0 * ((i + 1) / FPS) ** 2  # 4 m/s²
            frame = coupling.step()
        force = frame.wrenches["hand"][:3]
        assert force[0] < -0.05
        assert abs(force[1]) < 0.01
        # It trails behind, in the model's coordinates.
        assert frame.positions[-1, 0] < frame.positions[0, 0] - 0.02
        np.testing.assert_allclose(frame.positions[:, 1], 0, atol=1e-3)


def test_a_jump_is_refused_and_changes_nothing(at):
    model, data = model_of(HAND)
    with Coupling(model, data, at.client, at.soft, grippers={"hand": HOLDS_TOP}) as coupling:
        before, _ = seen(coupling, 2)
        data.mocap_pos[0, 0] = 0.5
        with pytest.raises(CouplingError, match=r"hand moved at 15 m/s") as error:
            coupling.step()
        assert error.value.reason == "TOO_FAST"
        assert data.time == pytest.approx(2 / FPS)
        assert data.mocap_pos[0, 0] == 0.5
        kept = coupling.session.states([coupling.slot])[0]
        np.testing.assert_array_equal(kept.positions, before[-1].state.positions)
        data.mocap_pos[0, 0] = 0.0
        assert coupling.step().number == 3
        # The model may be set elsewhere with the twin at its start.
        data.mocap_pos[0, 0] = 0.004
        coupling.reset(model=False)
        assert data.mocap_pos[0, 0] == 0.004
        assert coupling.step().number == 1


@pytest.mark.parametrize("iterations", [1, 16])
def test_a_twin_that_diverges_leaves_both_as_they_were(at, iterations):
    model, data = model_of(HAND + plug(1.0))
    with Coupling(
        model,
        data,
        at.client,
        at.soft,
        grippers={"hand": HOLDS_TOP, "plug": HOLDS_END},
        max_speed_m_s=1e9,
        iterations=iterations,
    ) as coupling:
        before, trace = coupling.step(), coupling.save()
        data.mocap_pos[0, 0] = 1e6
        with pytest.raises(CouplingError, match="the twin diverged") as error:
            coupling.step()
        assert error.value.reason == "TWIN_DIVERGED"
        data.mocap_pos[0, 0] = 0.0
        np.testing.assert_array_equal(coupling.save().model, trace.model)
        kept = coupling.session.states([coupling.slot])[0]
        np.testing.assert_array_equal(kept.positions, before.state.positions)
        assert coupling.step().number == 2


def test_a_server_that_is_gone_is_reported_when_patience_ends(at, tmp_path):
    (tmp_path / "cable").write_bytes(hanging().encode())
    model, data = model_of(HAND)
    with running(tmp_path) as address:
        client = Client(address)
        twin = client.import_twin(tmp_path / "cable")
        wait_for_worker(client)
        coupling = Coupling(model, data, client, twin, grippers={"hand": HOLDS_TOP}, patience_s=0.0)
        coupling.step()
    before = coupling.save()
    with pytest.raises(BendTwinError, match=r"\[UNAVAILABLE\]"):
        coupling.step()
    np.testing.assert_array_equal(coupling.save().model, before.model)
    assert coupling.save().number == 1
    client.close()


def test_fingers_take_what_lies_between_them_and_let_go(at):
    finger = (
        '<body name="hand" mocap="true" pos="0 0 0.7"><geom size="0.01"/><body name="finger">'
        '<joint name="open" type="slide" axis="1 0 0"/><geom size="0.01" mass="1"/></body></body>'
    )
    model, data = model_of(finger, gravity=0.0)
    data.qpos[0] = 0.05
    hand = Gripper(Grasp(region=Sphere(0.06)), closed=ClosedWhen(joint="open", below=0.02))
    with Coupling(
        model, data, at.client, at.soft, grippers={"hand": hand}, held_hands=[0]
    ) as coupling:
        assert coupling.step().held["hand"].size == 0
        data.qpos[0] = 0.01
        assert coupling.step().held["hand"].tolist() == [5, 6]
        data.mocap_pos[0, 0] += 0.01
        moved = coupling.step()
        np.testing.assert_allclose(moved.positions[6], [0.01, 0, 0.7], atol=1e-5)
        data.qpos[0] = 0.05
        assert coupling.step().held["hand"].size == 0


def test_what_a_body_pushes_gets_the_momentum_that_the_body_loses(at):
    ball = (
        '<body name="ball" pos="-0.1 0 0.85"><joint type="slide" axis="1 0 0"/>'
        '<geom size="0.03" mass="0.5" contype="1"/></body>'
    )
    model, data = model_of(ball, gravity=0.0)
    data.qvel[0] = 1.0
    with Coupling(model, data, at.client, at.free, margin_m=0.01) as coupling:
        assert coupling.colliders == ["geom0"]
        frames, _ = seen(coupling, 12)
        nodes = np.asarray(frames[-1].state.velocities)[:, 0]
    assert data.qvel[0] < 0.97
    pushes = sum(frame.wrenches["ball"][0] for frame in frames) / FPS
    assert 0.5 * (data.qvel[0] - 1.0) == pytest.approx(pushes, rel=0.02)
    # What else there is of the momentum: the springs keep none.
    assert MASS_KG * nodes.mean() == pytest.approx(0.5 * (1.0 - data.qvel[0]), rel=0.02)


def swing(
    at, twin, mass_kg, *, grasp=HOLDS_END, gravity=GRAVITY, held=(0,), damping=0.0, **options
):
    """The largest speeds of a plug in the first and in the last half second of two seconds, or the
    reason of a failure."""
    joint = f'type="slide" axis="0 0 1" damping="{damping}"'
    model, data = model_of(plug(mass_kg, joint=joint), gravity=gravity)
    data.qvel[0] = 0.1
    place = above() if held else {}
    with Coupling(
        model,
        data,
        at.client,
        twin,
        grippers={"plug": grasp},
        held_hands=held,
        max_speed_m_s=20.0,
        **place,
        **options,
    ) as coupling:
        speeds = []
        for _ in range(2 * FPS):
            try:
                coupling.step()
            except CouplingError as error:
                return error.reason
            speeds.append(abs(data.qvel[0]))
    return max(speeds[: FPS // 2]), max(speeds[-FPS // 2 :])


def test_explicit_coupling_holds_for_bodies_above_half_of_the_mass_that_they_carry(at):
    whole = Gripper(Grasp(nodes=list(range(7))))
    free = {"grasp": whole, "gravity": 0.0, "held": ()}
    heavy, light = 1.2 * MASS_KG / 2, 0.8 * MASS_KG / 2
    begin, end = swing(at, at.soft, heavy, **free, iterations=1)
    assert end < begin
    assert swing(at, at.soft, light, **free, iterations=1) == "TOO_FAST"
    # Relaxation moves this limit, to its own share of it.
    begin, end = swing(at, at.soft, light, **free, iterations=1, relaxation=0.5)
    assert end < begin
    assert swing(at, at.soft, 0.8 * light / 2, **free, iterations=1, relaxation=0.5) == "TOO_FAST"
    begin, end = swing(at, at.soft, light / 10, **free)
    assert end < begin


def test_a_taut_cable_needs_implicit_coupling(at):
    assert swing(at, at.stiff, 0.5, iterations=1) == "TOO_FAST"
    assert swing(at, at.stiff, 0.5, iterations=1, relaxation=0.3) == "TOO_FAST"
    begin, end = swing(at, at.stiff, 0.5)
    assert end < begin / 2


def test_explicit_coupling_of_a_taut_cable_holds_with_enough_damping(at):
    limit = 300.0 / LENGTH_M / FPS  # Stiffness times a frame.
    begin, end = swing(at, at.soft, 20.0, iterations=1, damping=0.3 * limit)
    assert end > begin
    begin, end = swing(at, at.soft, 20.0, iterations=1, damping=2 * limit)
    assert end < begin / 2


def test_arguments_that_cannot_be_used_are_refused(at, tmp_path):
    model, data = model_of(HAND)
    unknown = hanging()
    del unknown.about["mass_kg"]
    (tmp_path / "unknown").write_bytes(unknown.encode())
    twin = at.client.import_twin(tmp_path / "unknown")
    for options, says in (
        ({}, "mass of the twin's object is unknown"),
        ({"mass_kg": 0.0}, "mass_kg must be above 0"),
        ({"mass_kg": 0.1, "iterations": 0}, "at least 1"),
        ({"mass_kg": 0.1, "relaxation": 1.5}, "at most 1"),
    ):
        with pytest.raises(ValueError, match=says):
            Coupling(model, data, at.client, twin, **options)
    model.opt.timestep = 0.05
    with pytest.raises(ValueError, match=r"lower model\.opt\.timestep"):
        Coupling(model, data, at.client, at.soft)
    model.opt.timestep = 0.002
    with Coupling(
        model, data, at.client, twin, grippers={"hand": HOLDS_TOP}, mass_kg=2 * MASS_KG
    ) as coupling:
        for _ in range(30):
            frame = coupling.step()
    assert frame.wrenches["hand"][2] == pytest.approx(-2 * WEIGHT_N, rel=0.1)
