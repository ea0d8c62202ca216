"""Environments over sessions of a real server: a sheet and a cable, made by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
from scenes import dragged, twisted
from server import needs_server, running

from bendtwin import Client, Session
from bendtwin.v1 import rollout_pb2

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402
from gymnasium.wrappers.vector import RecordEpisodeStatistics  # noqa: E402

from bendtwin.envs import (  # noqa: E402
    Actions,
    Body,
    Camera,
    Observations,
    PointCloud,
    Randomisation,
    RandomPolicy,
    ScriptedPolicy,
    Unsuitable,
    evaluate,
    make,
)

pytestmark = needs_server
VARIED = Randomisation(mass=(0.5, 2.0), friction=(0.5, 1.5), stiffness=(0.8, 1.0))


@pytest.fixture(scope="module")
def objects(tmp_path_factory):
    folder = tmp_path_factory.mktemp("envs")
    with running(folder) as address, Client(address) as client:

        def imported(name, scene):
            (folder / f"{name}.twin").write_bytes(scene()[0].encode())
            return client.import_twin(folder / f"{name}.twin")

        sheet, cable = imported("sheet", dragged), imported("cable", twisted)
        yield SimpleNamespace(
            address=address,
            sheet=sheet,
            cable=cable,
            bodies={sheet.name: Body.of(sheet), cable.name: Body.of(cable)},
        )


@pytest.fixture
def made(objects):
    """Makes environments, and closes them."""
    open_ones = []

    def make_one(task="MoveTip", twin=objects.sheet, num_envs=3, **options):
        options = {"body": objects.bodies[twin.name], **options}
        open_ones.append(make(task, twin, num_envs, **options))
        return open_ones[-1]

    yield make_one
    for env in open_ones:
        env.close()


def actions_of(env, steps, seed=0):
    return np.random.default_rng(seed).uniform(-1, 1, (steps, *env.action_space.shape))


@pytest.mark.parametrize(
    ("task", "name"),
    [
        ("MoveTip", "sheet"),
        ("PutInBin", "sheet"),
        ("Fold", "sheet"),
        ("LayAlong", "cable"),
        ("InsertEnd", "cable"),
    ],
)
def test_a_script_succeeds_where_chance_does_not(objects, made, task, name):
    env = made(task, getattr(objects, name), 4)
    script = evaluate(env, ScriptedPolicy(env), episodes=4)
    assert script.rate >= 0.75, script
    assert script.steps.max() <= env.horizon
    env.horizon = 8
    chance = evaluate(env, RandomPolicy(env), episodes=4)
    assert chance.rate <= 0.2, chance
    assert (script.returns / script.steps).mean() > (chance.returns / chance.steps).mean()


def test_tasks_refuse_objects_that_do_not_suit_them(objects, made):
    with pytest.raises(Unsuitable, match="needs a cable"):
        made("InsertEnd")
    with pytest.raises(Unsuitable, match="needs a long object"):
        made("LayAlong")
    with pytest.raises(ValueError, match="there is no task 'Juggle'; there are Fold, "):
        made("Juggle")
    with pytest.raises(ValueError, match="at least 1"):
        made(num_envs=0)


def test_an_episode_depends_on_its_seed_and_its_actions_alone(made):
    options = {"randomisation": VARIED, "observations": Observations(velocities=True)}
    env, alone = made(**options), made(num_envs=1, **options)
    observed, _ = env.reset(seed=5)
    single, _ = alone.reset(seed=6)
    same(observed, single)
    moved = actions_of(env, 12)
    for action in moved:
        observed, reward, *_ = env.step(action)
        single, reward_alone, *_ = alone.step(action[1:2])
        same(observed, single)
        assert reward[1] == reward_alone[0]
    again, _ = env.reset(seed=[0, 6, None])
    single, _ = alone.reset(seed=6)
    same(again, single)
    assert not np.array_equal(again["goal"][0], again["goal"][1])


def same(observed, single):
    for name, part in single.items():
        np.testing.assert_array_equal(observed[name][1], part[0], err_msg=name)


def test_nothing_of_the_last_episode_is_left_after_a_reset(made):
    env = made(observations=Observations(velocities=True), horizon=8)
    observed, _ = env.reset(seed=0)
    lift = ScriptedPolicy(env)
    fastest = 0.0
    for _ in range(7):
        observed, *_ = env.step(lift(observed))
        fastest = max(fastest, abs(observed["velocities"]).max())
    assert fastest > 0.05
    observed, _, _, truncated, info = env.step(lift(observed))
    assert truncated.any()
    ended = np.flatnonzero(truncated)
    np.testing.assert_array_equal(observed["velocities"][ended], 0.0)
    np.testing.assert_array_equal(observed["agent_pos"][ended, 7], 1.0)
    for slot, state in zip(ended, env._simulation.session.states(ended.tolist()), strict=True):
        np.testing.assert_array_equal(state.velocities, 0.0)
        assert not np.asarray(state.grasping.phases).any() if state.grasping else True
        keypoints = state.positions[env._observer.nodes]
        np.testing.assert_array_equal(observed["keypoints"][slot], keypoints)
        assert info["final_obs"][slot]["keypoints"].shape == keypoints.shape
    # It lies still: nothing moves it before a gripper is there.
    still, *_ = env.step(np.zeros(env.action_space.shape))
    assert abs(still["velocities"][ended]).max() < 0.02


def test_the_kinds_of_automatic_resets_agree(made):
    """The last observation of an episode and the first of the next, in each mode."""
    modes = list(AutoresetMode)
    envs = {mode: made(autoreset_mode=mode, horizon=3) for mode in modes}
    moved = actions_of(envs[modes[0]], 4)
    lasts, nexts = {}, {}
    for mode, env in envs.items():
        env.reset(seed=3)
        for action in moved[:2]:
            _, _, terminated, truncated, info = env.step(action)
            assert not (terminated | truncated).any()
            assert "final_info" not in info
        observed, _, _, truncated, info = env.step(moved[2])
        assert truncated.all()
        if mode is AutoresetMode.SAME_STEP:
            assert info["_final_info"].all()
            assert not info["final_info"]["is_success"].any()
            lasts[mode] = np.stack([one["keypoints"] for one in info["final_obs"]])
            nexts[mode] = observed
            continue
        lasts[mode] = observed["keypoints"]
        if mode is AutoresetMode.NEXT_STEP:
            nexts[mode], reward, terminated, truncated, _ = env.step(moved[3])
            np.testing.assert_array_equal(reward, 0.0)
            assert not (terminated | truncated).any()
        else:
            still, reward, *_ = env.step(moved[3])
            np.testing.assert_array_equal(still["keypoints"], lasts[mode])
            mask = np.array([True, False, True])
            nexts[mode], _ = env.reset(options={"reset_mask": mask})
            np.testing.assert_array_equal(nexts[mode]["keypoints"][1], lasts[mode][1])
            env.reset(options={"reset_mask": ~mask})
            nexts[mode] = env._observation()
    for mode in modes[1:]:
        np.testing.assert_array_equal(lasts[mode], lasts[modes[0]])
        for name, part in nexts[mode].items():
            np.testing.assert_array_equal(part, nexts[modes[0]][name])


def test_success_ends_an_episode_and_is_told(made):
    env = made(task_options={"tolerance": 5.0})
    env.reset(seed=0)
    _, reward, terminated, truncated, info = env.step(np.zeros(env.action_space.shape))
    assert terminated.all()
    assert not truncated.any()
    assert info["final_info"]["is_success"].tolist() == [True] * 3
    assert (reward > 0).all()


def test_one_that_diverges_ends_alone(made, monkeypatch):
    env, other = made(), made()
    env.reset(seed=0)
    other.reset(seed=0)
    action = actions_of(env, 2)
    run, calls = env._simulation._run, []

    def diverging(request):
        calls.append(list(request.slots))
        if len(calls) == 1:
            # As the server answers: nothing has moved.
            return rollout_pb2.RollOutResponse(
                diverged=[rollout_pb2.RollOutResponse.Divergence(instance=1, frame=1)]
            )
        return run(request)

    monkeypatch.setattr(env._simulation, "_run", diverging)
    observed, reward, terminated, truncated, info = env.step(action[0])
    expected, others, *_ = other.step(action[0])
    assert calls == [[0, 1, 2], [0, 2]]
    assert terminated.tolist() == [False, True, False]
    assert not truncated.any()
    assert info["final_info"]["diverged"].tolist() == [False, True, False]
    assert reward[1] == -env.horizon, "no other end of an episode is worse"
    np.testing.assert_array_equal(reward[[0, 2]], others[[0, 2]])
    np.testing.assert_array_equal(observed["keypoints"][[0, 2]], expected["keypoints"][[0, 2]])
    # The others continue as if nothing had happened.
    observed, *_ = env.step(action[1])
    expected, *_ = other.step(action[1])
    np.testing.assert_array_equal(observed["keypoints"][[0, 2]], expected["keypoints"][[0, 2]])


def test_a_lost_session_truncates_and_is_opened_again(made):
    env = made()
    env.reset(seed=0)
    action = actions_of(env, 3)
    env.step(action[0])
    lost = env._simulation.session
    lost.close()  # What a client sees when its worker is lost.
    _, reward, terminated, truncated, info = env.step(action[1])
    assert truncated.all()
    assert not terminated.any()
    np.testing.assert_array_equal(reward, 0.0)
    assert info["final_info"]["session_lost"].all()
    assert env._simulation.session.name != lost.name
    _, _, _, truncated, info = env.step(action[2])
    assert not truncated.any()
    assert not info["session_lost"].any()
    # Lost while one of them begins again: the others say so in the next step.
    env._simulation.session.close()
    env.reset(options={"reset_mask": np.array([True, False, False])})
    _, _, _, truncated, info = env.step(action[0])
    assert truncated.tolist() == [False, True, True]
    assert evaluate(env, RandomPolicy(env), episodes=3).lost == 0


def test_closing_ends_the_session(objects, made):
    env = made()
    session = env._simulation.session
    session.refresh()
    env.close()
    with pytest.raises(Exception, match=session.name.split("/")[1]):
        session.refresh()
    env.close()
    # By its name and an address, an environment has its own connection.
    other = make("MoveTip", objects.sheet.name, 1, address=objects.address)
    other.reset(seed=0)
    other.close()


def test_what_is_randomised_differs(made):
    plain, varied = made(num_envs=2), made(num_envs=2, randomisation=VARIED)
    seen = []
    for env in (plain, varied):
        env.reset(seed=[7, 7])
        script = ScriptedPolicy(env)
        for _ in range(9):
            observed, *_ = env.step(script(None))
        seen.append(observed["keypoints"])
        np.testing.assert_array_equal(observed["keypoints"][0], observed["keypoints"][1])
    assert np.abs(seen[0] - seen[1]).max() > 1e-4
    with pytest.raises(ValueError, match="smallest and the largest"):
        Randomisation(mass=(2.0, 1.0))
    with pytest.raises(ValueError, match="above 0"):
        Randomisation(stiffness=(0.0, 1.0))


def test_observations_have_the_parts_that_were_chosen(made):
    cloud = PointCloud(count=40, noise_m=0.001)
    env = made(observations=Observations(keypoints=[3, 5], velocities=True, point_cloud=cloud))
    observed, _ = env.reset(seed=0)
    assert env.observation_space.contains(observed)
    assert observed["points"].shape == (3, 40, 3)
    nodes = env._points[:, None]
    apart = np.linalg.norm(observed["points"][:, :, None] - nodes, axis=-1).min(axis=-1)
    assert 0 < apart.max() < 0.01, "points are nodes of the sheet, with noise"
    flat = made(observations=Observations(keypoints=4, flat=True))
    observed, _ = flat.reset(seed=0)
    assert set(observed) == {"agent_pos", "environment_state"}
    assert observed["environment_state"].shape == (3, 4 * 3 + 3)
    over = Camera.looking("over", [0, 0, 1], [0, 0, 0], field_of_view_rad=0.6)
    seen = made(observations=Observations(point_cloud=PointCloud(count=40, seen_by=over)))
    layers = np.array([[[0, 0, 0.2], [0, 0, 0.0], [0.1, 0, 0], [0.9, 0, 0], [0, 0, 2.0]]])
    hidden = seen._observer._hidden(layers, over)
    assert hidden.tolist() == [[False, True, False, True, True]], "behind, beside, in the back"
    observed, _ = seen.reset(seed=0)
    assert observed["points"].shape == (3, 40, 3)
    with pytest.raises(ValueError, match="nodes that the twin does not have"):
        made(observations=Observations(keypoints=[99]))


@pytest.mark.skipif(not hasattr(Session, "render"), reason="this client takes no pictures")
def test_pictures_show_the_state_of_each_slot(made):
    seen = Observations(cameras=["front", "wrist"], width=48, height=32)
    options = {"observations": seen, "render_mode": "rgb_array", "horizon": 2}
    env, plain = made(**options), made(horizon=2)
    looks = made(randomisation=Randomisation(brightness=(0.4, 1.0), camera_m=0.02), **options)
    first, _ = env.reset(seed=0)
    assert env.observation_space.contains(first)
    assert first["pixels"]["front"].shape == (3, 32, 48, 3)
    assert all(np.ptp(picture) > 50 for picture in first["pixels"]["front"]), "something is seen"
    # Pictures change nothing else, nor do their looks.
    same(first, {name: part[1:2] for name, part in plain.reset(seed=0)[0].items()})
    other, _ = looks.reset(seed=0)
    np.testing.assert_array_equal(other["keypoints"], first["keypoints"])
    assert (other["pixels"]["front"] != first["pixels"]["front"]).any()
    moved = actions_of(env, 2)
    after, *_ = env.step(moved[0])
    assert (after["pixels"]["wrist"] != first["pixels"]["wrist"]).any()
    *_, truncated, info = env.step(moved[1])
    assert truncated.all()
    assert info["final_obs"][0]["pixels"]["front"].shape == (32, 48, 3)
    again, _ = env.reset(seed=0)
    for name, pictures in first["pixels"].items():
        np.testing.assert_array_equal(again["pixels"][name], pictures)
    frames = env.render()
    assert len(frames) == 3
    assert frames[0].shape == (240, 320, 3)
    np.testing.assert_array_equal(env.envs[1].render(), frames[1])


def test_actions_may_be_knots_along_the_gripper(made):
    env = made("Fold", actions=Actions(knots=2, frames=4, axes="gripper"))
    assert env.single_action_space.shape == (2 * 2 * 7,)
    assert evaluate(env, ScriptedPolicy(env), episodes=3).rate == 1.0
    with pytest.raises(ValueError, match="a frame for each knot"):
        Actions(knots=3, frames=2)


def test_gymnasium_makes_and_checks_them(objects, recwarn):
    single = gymnasium.make("BendTwin/MoveTip-v0", twin=objects.sheet)
    check_env(single.unwrapped, skip_render_check=True)
    assert not [w for w in recwarn if "infinity" not in str(w.message) and is_ours(w)]
    single.reset(seed=0)
    _, reward, _, _, info = single.step(single.action_space.sample())
    assert isinstance(reward, float)
    assert info["is_success"] is False
    single.close()
    many = gymnasium.make_vec("BendTwin/Fold-v0", num_envs=2, twin=objects.sheet, horizon=2)
    assert many.spec.id == "BendTwin/Fold-v0"
    counted = RecordEpisodeStatistics(many)
    counted.reset(seed=0)
    counted.step(many.action_space.sample())
    *_, info = counted.step(many.action_space.sample())
    assert info["episode"]["l"].tolist() == [2, 2]
    many.close()


def is_ours(warning):
    return "bendtwin" in str(warning.message).lower() or issubclass(warning.category, UserWarning)
