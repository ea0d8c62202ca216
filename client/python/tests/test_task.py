"""Tasks carry whatever a rollout accepts, and all planners and adapters see it."""

from dataclasses import replace

import numpy as np
import pytest
from made import sheet_at_rest
from server import needs_server

from bendtwin import (
    Collider,
    Cuboid,
    Ensemble,
    GradientOptions,
    Grasp,
    Keypoints,
    Plausibility,
    Returns,
    RolloutArguments,
    Search,
    SessionSlots,
    Sphere,
    State,
    Vary,
    World,
)
from bendtwin.planners import (
    Cem,
    EveryPlanDiverged,
    GradientDescent,
    Grippers,
    Mppi,
    OnServer,
    PredictiveSampling,
    Task,
    Together,
)
from bendtwin.planners.velocity import simulate

FRAMES = 12
POSE = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
STILL = np.zeros((1, 4, 6))


def described(**more):
    """A task with all that there is, of a twin that nobody asks."""
    wall = Collider(shape=Cuboid([0, 0, 0], [1, 1, 1]))
    settings = {
        "twin": None,
        "costs": [Keypoints(nodes=[0], targets=[[0, 0, 1]])],
        "space": Grippers([POSE]),
        "frames": FRAMES,
        "interpolation": "cubic",
        "fidelity": "fast",
        "initial": State(np.zeros((3, 3))),
        "world": World(colliders=[wall]),
        "grasps": [Grasp(region=Sphere(0.1))],
        "vary": Vary(mass=[1.0, 2.0]),
        "ensemble": Ensemble(2),
        "gradient": GradientOptions(reach_frames=5),
        "plausibility": Plausibility(strain=0.5),
    }
    return Task(**settings | more)


def test_whatever_a_rollout_accepts_a_task_says():
    task = described(space=Grippers([POSE], [0, 0]))
    asked = task.request(STILL)
    # Beside what comes back, and instead of even knots and of poses.
    left = {"returns", "time_limit_s", "at_s", "period_s", "trajectories"}
    assert asked.keys() == RolloutArguments.__optional_keys__ - left
    for name in asked.keys() - {"poses", "gripper_of_control"}:
        assert asked[name] is task.initial or asked[name] == getattr(task, name), name
    session = SessionSlots("sessions/s")
    assert task.request(STILL, session)["initial"] is session


def test_a_plan_is_executed_in_its_surroundings_alone():
    task = described()
    actions = task.actions(STILL[0])
    expected = {"poses", "frames", "interpolation", "world", "grasps"}
    assert actions.keys() == expected
    assert actions["world"] == task.world
    first = task.actions(STILL[0], 3)
    assert first["poses"].shape == (1, 4, 1, 7)
    assert first["grasps"] == task.grasps


def closed_of(asked):
    return np.asarray(asked["grasps"][0].closed).astype(int).tolist()


def test_closings_are_by_frame_and_go_on_with_the_plan():
    opens = Grasp(nodes=[0], closed=np.arange(FRAMES + 1) < 8)
    task = described(grasps=[opens], interpolation="linear")
    asked = task.request(STILL)
    assert (asked["poses"].shape[1], closed_of(asked)) == (4, [1, 1, 0, 0]), "at knots"
    # Four frames on it is one knot earlier; after that, between knots.
    assert closed_of(task.at(4).request(STILL)) == [1, 0, 0, 0]
    between = task.at(3).request(STILL)
    assert between["poses"].shape[1] == FRAMES + 1
    assert closed_of(between) == [1] * 5 + [0] * 8
    assert closed_of(task.at(100).request(STILL)) == [0] * 4
    executed = task.actions(STILL[0], 9)
    assert executed["poses"].shape[1] == len(closed_of(executed)) == 10
    assert closed_of(executed) == [1] * 8 + [0, 0]
    # By instance, as environments need it.
    each = replace(task, since=np.array([0, 4])).request(np.zeros((2, 4, 6)))
    assert closed_of(each) == [[1, 1, 0, 0], [1, 0, 0, 0]]


def test_paths_are_by_frame_too():
    path = np.tile(POSE, (40, 1))
    path[:, 0] = 0.01 * np.arange(40)
    task = described(
        world=World(colliders=[Collider(shape=Sphere(0.1), path=path)]), interpolation="linear"
    )

    def places(task):
        asked = task.request(STILL)
        return asked["poses"].shape[1], asked["world"].colliders[0].path[:, 0]

    knots, along = places(task)
    np.testing.assert_allclose(along, 0.01 * np.array([0, 4, 8, 12]))
    np.testing.assert_allclose(places(task.at(20))[1], 0.01 * np.array([20, 24, 28, 32]))
    # It ends between knots.
    knots, along = places(task.at(29))
    assert knots == FRAMES + 1
    np.testing.assert_allclose(along, 0.01 * np.minimum(29 + np.arange(13), 39))
    with pytest.raises(ValueError, match="all instances alike"):
        replace(task, since=np.array([0, 3])).request(STILL)


@pytest.mark.parametrize(
    "wrong",
    [
        {"grasps": [Grasp(nodes=[0], closed=[0, 1, 1, 0])]},
        {"grasps": [Grasp(nodes=[0], closed=np.zeros((2, FRAMES + 1)))]},
        {"world": World(colliders=[Collider(shape=Sphere(0.1), path=[POSE, [1, *POSE[1:]]])])},
    ],
)
def test_rows_that_are_not_by_frame_are_refused(wrong):
    with pytest.raises(ValueError, match="a row for each frame boundary, 13 or more"):
        described(**wrong)


# A real server


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    with sheet_at_rest(tmp_path_factory.mktemp("tasks")) as scene:
        yield scene


@pytest.fixture
def task(scene):
    """The far corner is to come nearer, over a wall behind the hand, on a rough ground, with one
    node held and one released on the way, of an object whose mass is not known."""
    start = scene.start
    wall = Collider(shape=Cuboid([-0.3, -0.1, 0.0], [-0.05, 0.2, 0.03]), margin_m=0.005)
    return Task(
        twin=scene.twin,
        costs=[Keypoints(nodes=[19], targets=[start.positions[19] + np.array([-0.05, 0, 0.03])])],
        space=Grippers.around(start.controls, scene.twin.geometry().hands),
        frames=FRAMES,
        initial=start,
        world=World(colliders=[wall], ground_friction=0.9),
        grasps=[Grasp(hand=0), Grasp(nodes=[3], closed=np.arange(FRAMES + 1) < 8)],
        vary=Vary(mass=[0.7, 1.5]),
        ensemble=Ensemble(2, "worst"),
    )


def by_hand(task, **more):
    """Costs of knots as somebody would ask for them who knows the request."""

    def costs(knots):
        dense = FRAMES + 1
        poses = task.space.actions(np.asarray(knots, float)[None])
        closed = [1, 1, 0, 0] if len(knots) == 4 else np.arange(dense) < 8
        return task.twin.rollout(
            **poses,
            frames=FRAMES,
            initial=task.initial,
            costs=task.costs,
            world=task.world,
            grasps=[Grasp(hand=0), Grasp(nodes=[3], closed=closed)],
            vary=task.vary,
            ensemble=task.ensemble,
            plausibility=Plausibility(control_depth_m=1.0),
            **more,
        ).costs[0]

    return costs


METHODS = {
    "mppi": lambda task: Mppi(task, knots=4, samples=12, sigma=0.03),
    "cem": lambda task: Cem(task, knots=4, samples=12, sigma=0.03),
    "predictive sampling": lambda task: PredictiveSampling(task, knots=4, samples=12, sigma=0.03),
    "server": lambda task: OnServer(task, knots=4, search=Search(samples=12, sigma=0.03)),
}


@needs_server
@pytest.mark.parametrize("method", METHODS)
def test_planners_see_all_of_it(task, method, recwarn):
    planner = METHODS[method](task)
    plan = planner.plan()
    costs = by_hand(task)
    assert plan.nominal_cost == pytest.approx(costs(np.zeros((4, 6))), rel=1e-6)
    assert plan.cost == pytest.approx(costs(plan.knots), rel=1e-6)
    assert plan.cost < plan.nominal_cost
    for name in ("world", "grasps", "vary"):
        less = replace(task, **{name: () if name == "grasps" else None})
        less = replace(less, ensemble=less.vary and less.ensemble)
        other = less.evaluate(plan.knots[None], None).costs[0]
        assert abs(other - plan.cost) > 1e-3 * plan.cost, f"{name} changes nothing here"
    # Plans are executed in the surroundings; closings move on by the frames that were executed.
    quiet = {"vary": task.vary, "ensemble": task.ensemble, "initial": task.initial}
    quiet["plausibility"] = Plausibility(control_depth_m=1.0)
    again = task.twin.rollout(**plan.actions(), costs=task.costs, **quiet)
    assert again.costs[0] == pytest.approx(plan.cost, rel=1e-6)
    done = task.twin.rollout(
        **plan.actions(4),
        initial=task.initial,
        plausibility=quiet["plausibility"],
        returns=Returns(final_state=True),
    )
    planner.shift(4)
    following = planner.plan(done.state(0))
    assert closed_of({"grasps": following.actions()["grasps"][1:]}) == [1, 0, 0, 0]
    gaps = [w for w in recwarn if "START_GAP" in str(w.message)]
    assert not gaps, "the next plan begins where this one was executed to"


@needs_server
def test_the_server_plans_where_surroundings_change_at_knots(task):
    planner = OnServer(task, knots=4, search=Search(samples=4))
    planner.plan()
    planner.shift(1)
    with pytest.raises(ValueError, match="between the knots"):
        planner.plan()


@needs_server
def test_gradients_are_those_of_the_task(scene, task):
    smooth = replace(task, gradient=GradientOptions(smoothing_m=0.002))
    plan = GradientDescent(smooth, knots=4, iterations=3).plan()
    asked = {"gradient": smooth.gradient, "returns": Returns(action_gradients=True)}
    assert plan.cost == pytest.approx(by_hand(task, **asked)(plan.knots), rel=1e-6)
    assert plan.cost < plan.nominal_cost
    with pytest.raises(ValueError, match="gradients of poses"):
        smooth.at(1).evaluate(STILL, None, gradients=True)


@needs_server
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_gradients_by_knots_are_right_where_actions_are_by_frame(scene, interpolation):
    """A ball on a path ends between knots, so that there is an action for every frame."""
    start = scene.start
    path = np.tile(POSE, (FRAMES + 1, 1))
    path[:, :3] = [0.06, 0.05, 0.3]
    path[7:, 0] += 0.1
    ball = Collider(shape=Sphere(0.02), path=path)
    task = Task(
        twin=scene.twin,
        costs=[Keypoints(nodes=[0], targets=[[0.0, 0.1, 0.2]], squared=True)],
        space=Together(start.controls),
        frames=FRAMES,
        interpolation=interpolation,
        initial=start,
        world=World(colliders=[ball], ground="none"),
    )
    knots = np.random.default_rng(0).normal(0.01, 0.01, (1, 4, 3))
    knots[:, 0] = 0.0
    assert task.request(knots)["trajectories"].shape[1] == FRAMES + 1
    gradient = task.evaluate(knots, None, gradients=True).gradients[0]
    step = 1e-4
    units = step * np.eye(12).reshape(12, 4, 3)
    there = task.evaluate(knots + units, None).costs
    back = task.evaluate(knots - units, None).costs
    slopes = ((there - back) / (2 * step)).reshape(4, 3)
    np.testing.assert_allclose(gradient[1:], slopes[1:], atol=0.02 * np.abs(slopes).max())


@needs_server
@pytest.mark.parametrize("statistic", ["mean", "worst", "cvar", "mean_prediction"])
def test_costs_by_frame_are_those_of_the_statistic(task, statistic):
    every = replace(task.costs[0], when="every_frame")
    task = replace(
        task,
        costs=[every],
        vary=Vary(mass=[0.5, 1.0, 2.0]),
        ensemble=Ensemble(3, statistic, share=0.6),
        plausibility=Plausibility(control_depth_m=1.0),
    )
    velocities = np.random.default_rng(0).normal(0, 0.05, (2, FRAMES, 6))
    motion = simulate(task, np.zeros(6), velocities, None, nodes=[19, 0])
    steps = np.concatenate([np.zeros((2, 1, 6)), velocities * task.frame_s], axis=1)
    result = task.rollout(steps.cumsum(axis=1), returns=Returns(frame_costs=True, every_frames=1))
    at_start = result.frame_costs[0, 0].sum()
    np.testing.assert_allclose(motion.costs.sum(axis=1) + at_start, result.costs, rtol=1e-6)
    # Of the mean motion there is one row for each action.
    rows = len(result.positions) // 2
    np.testing.assert_allclose(motion.nodes, result.positions[::rows, :, [19, 0]], atol=1e-7)


@needs_server
def test_what_is_refused_counts_as_diverged(scene, task):
    start = scene.start
    into = Collider(shape=Cuboid([-0.3, -0.3, 0.0], [-0.06, 0.3, 0.3]))
    task = replace(
        task,
        world=World(colliders=[into]),
        grasps=(),
        plausibility=Plausibility(refuse=True),
        initial=start,
    )
    knots = np.zeros((2, 4, 6))
    knots[1, 1:, 0] = -0.1
    costs = task.evaluate(knots, None).costs
    assert np.isfinite(costs[0])
    assert np.isinf(costs[1])
    # The batch is answered all the same, and a planner goes elsewhere.
    plan = Mppi(task, knots=4, samples=24, sigma=0.05).plan()
    assert plan.diverged > 0
    assert np.isfinite(plan.cost)
    nothing = Plausibility(strain=0.0, refuse=True)
    with pytest.raises(EveryPlanDiverged):
        Mppi(replace(task, plausibility=nothing), knots=4, samples=4).plan()


@needs_server
@pytest.mark.filterwarnings("error")
def test_only_a_start_elsewhere_is_warned_of(task):
    wild = np.zeros((2, 4, 6))
    wild[:, 1:, 2] = [[-0.1], [0.4]]
    task = replace(task, grasps=())
    assert len(task.rollout(wild).implausible) > 0
    apart = replace(task, space=Together(np.asarray(task.initial.controls) + 0.02))
    with pytest.raises(RuntimeWarning, match="START_GAP"):
        apart.evaluate(np.zeros((1, 4, 3)), None)


@needs_server
def test_a_session_is_a_place_to_begin(scene, task):
    with scene.client.open_session(scene.twin, initial=scene.start) as session:
        session.advance(trajectories=scene.hold, frames=3)
        here = SessionSlots(session.name)
        plain = replace(task, grasps=(), initial=here)
        in_session = Mppi(plain, knots=4, samples=8).plan()
        (state,) = session.states()
        given = Mppi(plain, knots=4, samples=8).plan(state)
        assert in_session.cost == given.cost


@needs_server
def test_slots_keep_their_parameters(scene):
    state, final = scene.start, Returns(final_state=True)
    light = {"trajectories": scene.hold, "frames": 5, "returns": final}
    with scene.client.open_session(
        scene.twin, initial=state, slots=2, vary=Vary(mass=[1.0, 3.0])
    ) as session:
        both = session.rollout(
            **light | {"trajectories": np.repeat(scene.hold, 2, axis=0)}, slots=[0, 1]
        )
        heavy = scene.twin.rollout(**light, initial=state, vary=Vary(mass=[3.0]))
        np.testing.assert_array_equal(both.final_positions[1], heavy.final_positions[0])
        assert (both.final_positions[0] != both.final_positions[1]).any()
        moved = session.advance(**light, slots=[1])
        np.testing.assert_array_equal(moved.final_positions, heavy.final_positions)
        own = session.rollout(**light, slots=[0], vary=Vary(mass=[3.0]))
        np.testing.assert_array_equal(own.final_positions, heavy.final_positions)
        costs = [Keypoints(nodes=[0], targets=[[0, 0, 1]])]
        named = {"trajectories": scene.hold, "frames": 5, "costs": costs}
        plan = session.plan(**named, slot=1, search=Search(samples=2))
        (there,) = session.states([1])
        expected = scene.twin.rollout(**named, initial=there, vary=Vary(mass=[3.0]))
        assert plan.nominal_cost == pytest.approx(expected.costs[0], rel=1e-9)
    with pytest.raises(ValueError, match="one factor, or 2"):
        scene.client.open_session(scene.twin, slots=2, vary=Vary(mass=[1.0, 2.0, 3.0]))
    with pytest.raises(ValueError, match="ensemble"):
        scene.client.open_session(scene.twin, vary=Vary(fits=True))


@needs_server
def test_an_object_drops(scene):
    geometry, final = scene.twin.geometry(), Returns(final_state=True)
    lifted = np.concatenate([scene.hold[:, :1], scene.hold[:, :1] + [0, 0, 0.2]], axis=1)
    up = scene.twin.rollout(trajectories=lifted, frames=20, initial=scene.start, returns=final)
    fallen = scene.twin.rollout(**geometry.released(up.state(0)), frames=40, returns=final)
    assert up.final_positions[0, :, 2].max() > 0.15
    assert fallen.final_positions[0, :, 2].max() < 0.03
    both = scene.twin.rollout(**geometry.released(up.states()), frames=40, returns=final)
    np.testing.assert_array_equal(both.final_positions, fallen.final_positions)
    # For all rollouts of a session, whatever their knots.
    hands = geometry.released()["grasps"]
    with scene.client.open_session(scene.twin, initial=up.state(0), grasps=hands) as session:
        for knots in (2, 5):
            poses = np.tile(np.array(POSE), (1, knots, 1, 1))
            end = session.advance(poses=poses, frames=20, returns=final)
    np.testing.assert_array_equal(end.final_positions, fallen.final_positions)
