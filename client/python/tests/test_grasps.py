"""Where to grasp: searches of places by a real server, beside a plan for each place alone."""

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from server import needs_server

from bendtwin import (
    BendTwinError,
    Bounds,
    Grasp,
    GraspSearch,
    Keypoints,
    Plausibility,
    Returns,
    Search,
    Sphere,
    aio,
    grasp_places,
)
from bendtwin.planners import Grippers, OnServer, Task

pytestmark = needs_server

FRAMES = 10
PLACES = 5
#: Bounds of a lift by 8 cm that leave the plan little beside its place.
LIFT = Bounds(low=[-0.005, -0.005, 0.0], high=[0.005, 0.005, 0.085])


@pytest.fixture(scope="module")
def scene(rope):
    """A rope that lies on the ground, places along it, and the lift of a gripper from each."""
    scene = SimpleNamespace(**vars(rope))
    geometry = scene.twin.geometry()
    dropped = scene.twin.rollout(
        **geometry.released(), frames=45, returns=Returns(final_state=True)
    )
    lying = replace(dropped.state(0), grasping=None)
    scene.places = grasp_places(geometry, lying, count=PLACES)
    hands = [Grasp(hand=hand, closed=False) for hand in range(geometry.hand_count)]
    scene.lifts = np.repeat(scene.places.poses[:, None], 3, axis=1)
    scene.lifts[:, 1:, 0, 2] += 0.08
    middle = scene.places.nodes[2]
    goal = lying.positions[middle] + np.array([0.0, 0.0, 0.08])
    scene.ask = {
        "frames": FRAMES,
        "initial": lying,
        "grasps": [Grasp(region=Sphere(0.03)), *hands],
        "costs": [Keypoints(nodes=[middle], targets=[goal])],
        "space": "translation",
    }
    scene.search = Search(samples=30, iterations=4, sigma=0.002, bounds=LIFT)
    return scene


def alone(scene, place, **arguments):
    """The plan that begins at a place, made without a search of places."""
    search = replace(scene.search, samples=6)
    plan = scene.twin.plan(
        poses=scene.lifts[place][None], **{**scene.ask, **arguments}, search=search
    )
    return (plan.excess, plan.cost), plan


def searched(scene, **arguments):
    """The plan of all places, from a nominal plan that lifts at the first."""
    return scene.twin.plan(
        **{"poses": scene.lifts[:1], **scene.ask, "search": scene.search, **arguments},
        grasp_search=scene.places.search(),
    )


def test_the_place_is_the_best_of_all_and_with_a_limit_of_the_force_another(scene):
    free = [alone(scene, place, plausibility=limit(1e9)) for place in range(PLACES)]
    ranks = [rank for rank, _ in free]
    best = min(range(PLACES), key=ranks.__getitem__)
    found = searched(scene, plausibility=limit(1e9), returns=Returns(forces=True))
    # The middle is to be lifted: it is grasped there.
    assert found.grasp == best == 2
    assert found.cost <= 1.05 * ranks[best][1]
    np.testing.assert_allclose(found.knots[0, 0, 0], scene.places.poses[2, 0], atol=1e-6)
    forces = np.linalg.norm(found.rollout.forces.grasps[0, :, 0, :3], axis=-1)
    assert found.grasp_force_n == pytest.approx(forces.max(), rel=1e-5)
    assert found.rollout.costs[0] == found.cost == found.grasp_costs[found.grasp]
    # Two spans hang from a gripper in the middle. What it lifts is more than the limit between the
    # best place and the next one with less force.
    pulls = np.array([plan.grasp_force_n for _, plan in free])
    most = 0.5 * (pulls[2] + np.sort(pulls[pulls < 0.97 * pulls[2]])[-1])
    kept = [alone(scene, place, plausibility=limit(most))[0] for place in range(PLACES)]
    best = min(range(PLACES), key=kept.__getitem__)
    found = searched(scene, plausibility=limit(most))
    assert found.grasp == best != 2
    assert found.excess == 0.0
    assert found.grasp_force_n <= found.grasp_force_limit_n == pytest.approx(most)
    assert found.overstrained > 0
    assert found.cost <= 1.05 * kept[best][1]


def limit(newtons):
    return Plausibility(grasp_force_n=newtons)


def test_a_rollout_names_grasps_beyond_the_limit(scene):
    asked = {"poses": scene.lifts, "frames": FRAMES, "initial": scene.ask["initial"]}
    asked["grasps"] = scene.ask["grasps"]
    forces = scene.twin.rollout(**asked, returns=Returns(forces=True)).forces.grasps
    most = np.linalg.norm(forces[:, :, 0, :3], axis=-1)
    between = float(np.median(most.max(axis=1)))
    with pytest.warns(RuntimeWarning, match="GRASP_FORCE"):
        result = scene.twin.rollout(**asked, plausibility=limit(between))
    beyond = {found.instance: found for found in result.implausible}
    assert set(beyond) == set(np.flatnonzero(most.max(axis=1) > between * (1 + 1e-6)).tolist())
    for instance, found in beyond.items():
        assert (found.reason, found.grasp) == ("GRASP_FORCE", 0)
        assert found.frame == most[instance].argmax() + 1
        assert found.found == pytest.approx(most[instance].max(), rel=1e-5)


def test_the_same_seed_gives_the_same_place_and_updates_get_better(scene):
    updates = list(
        scene.twin.stream_plan(
            poses=scene.lifts[:1],
            **scene.ask,
            search=scene.search,
            grasp_search=scene.places.search(),
        )
    )
    costs = [update.cost for update in updates]
    assert costs == sorted(costs, reverse=True)
    assert all(update.grasp_costs[update.grasp] == update.cost for update in updates)
    last = updates[-1]
    again = searched(scene)
    np.testing.assert_array_equal(again.knots, last.knots)
    np.testing.assert_array_equal(again.grasp_costs, last.grasp_costs)
    # An iteration of all places has the samples of one.
    assert updates[0].simulated == 30

    async def run():
        async with aio.Client(scene.address) as client:
            twin = await client.twin(scene.twin.name)
            return await twin.plan(
                poses=scene.lifts[:1],
                **scene.ask,
                search=scene.search,
                grasp_search=scene.places.search(),
            )

    np.testing.assert_array_equal(asyncio.run(run()).knots, last.knots)


def test_places_that_hold_nothing_lose_and_none_is_an_error(scene):
    beside = scene.places.poses + np.array([0, 0.3, 0, 0, 0, 0, 0], np.float32)
    mixed = np.concatenate([beside[:3], scene.places.poses[2:3]])
    ask = {"poses": scene.lifts[:1], **scene.ask, "search": scene.search}
    found = scene.twin.plan(**ask, grasp_search=GraspSearch(mixed))
    assert found.grasp == 3
    np.testing.assert_array_equal(np.isinf(found.grasp_costs), [True, True, True, False])
    with pytest.raises(BendTwinError) as nothing:
        scene.twin.plan(**ask, grasp_search=GraspSearch(beside))
    assert nothing.value.reason == "NOTHING_GRASPED"


def test_a_session_is_grasped_once(scene):
    rollout = {name: value for name, value in scene.ask.items() if name != "initial"}
    opened = {name: scene.ask[name] for name in ("initial", "grasps")}
    with scene.client.open_session(scene.twin, **opened) as session:
        search = {"poses": scene.lifts[:1], **rollout, "search": scene.search}
        search["grasp_search"] = scene.places.search()
        planned = session.plan(**search)
        assert planned.grasp == searched(scene).grasp
        step = session.step(None, search, frames=5)
        assert step.plan.grasp == planned.grasp
        assert "grasp_search" not in step.search
        # The next plan continues; the object is held, so that no other place can be searched.
        assert session.plan(**step.search).cost <= 1.5 * planned.cost + 0.01
        with pytest.raises(BendTwinError) as held:
            session.plan(**{**step.search, "grasp_search": scene.places.search()})
        assert held.value.reason == "INVALID_PLAN"


def test_the_planner_of_the_server_takes_the_place(scene):
    task = Task(
        twin=scene.twin,
        costs=scene.ask["costs"],
        space=Grippers(scene.places.poses[0]),
        frames=FRAMES,
        initial=scene.ask["initial"],
        grasps=scene.ask["grasps"],
        grasp_search=scene.places.search(),
    )
    sigma = [0.03, 0.03, 0.05, 0.0, 0.0, 0.0]
    planner = OnServer(task, knots=3, search=Search(samples=30, iterations=4, sigma=sigma))
    plan = planner.plan()
    assert plan.grasp_costs.shape == (PLACES,)
    executed = scene.twin.rollout(
        **plan.actions(), initial=scene.ask["initial"], costs=scene.ask["costs"]
    )
    assert executed.costs[0] == pytest.approx(plan.cost, rel=1e-3)
    following = planner.plan()
    assert following.grasp is None
    assert following.nominal_cost == pytest.approx(plan.cost, rel=1e-3)
    planner.reset()
    assert planner.plan().grasp == plan.grasp
