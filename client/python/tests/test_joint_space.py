"""Plans of joints, and contact with the links of an arm, against a real server."""

from dataclasses import replace

import numpy as np
import pytest
from made import rope_and_arm
from server import needs_server

from bendtwin import (
    Collider,
    ConvexMesh,
    Cuboid,
    Grasp,
    Keypoints,
    Plausibility,
    Returns,
    Sphere,
    World,
)
from bendtwin.planners import (
    Bounds,
    Cem,
    GradientDescent,
    MachineSpace,
    Mppi,
    OnServer,
    PredictiveSampling,
    Task,
)
from bendtwin.planners.velocity import simulate
from bendtwin.robots import JointSpace, RobotError, Workcell
from bendtwin.robots.meshes import hull_of, hull_planes

pytestmark = needs_server

NODE, GOAL = 5, [0.08, 0.06, 0.12]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    with rope_and_arm(tmp_path_factory.mktemp("arm")) as made:
        made.geometry = made.twin.geometry()
        made.cell = Workcell(made.robot, made.geometry, margin_m=0.004)
        yield made


def task_of(scene, cell=None, **settings):
    space = JointSpace(cell or scene.cell, scene.joints)
    costs = [Keypoints(nodes=[NODE], targets=[GOAL], squared=True)]
    given = {"costs": costs, "frames": 12, "initial": scene.start} | settings
    return Task(twin=scene.twin, space=space, **given)


def swept(scene, cell):
    """The wrist is low over the table and moves sideways, through the rope."""
    low = scene.robot.positions({"lift": 1.53, "elbow": 0.55, "pitch": -0.5, "turn": -0.25})
    across = low + scene.robot.positions({"turn": 0.4})
    return {**cell.rollout_arguments([[low, across]], frames=15), "initial": scene.start}


def test_contact_with_links_is_reported_and_costed_by_their_names(scene):
    # What holds the rope is not this arm.
    cell = Workcell(scene.robot, scene.geometry, margin_m=0.004, hands={0: None})
    costs = [*cell.force("forearm", "wrist", limit_n=0.1), *cell.clearance("palm", margin_m=0.05)]
    result = scene.twin.rollout(**swept(scene, cell), costs=costs, returns=Returns(forces=True))
    contacts = cell.contacts(result)
    assert list(contacts) == [
        "base", "shoulder", "upper_arm", "forearm", "wrist", "hand_mount", "palm",
    ]  # fmt: skip
    pressed = [link for link, contact in contacts.items() if contact.largest[0] > 0.0]
    assert pressed
    assert set(pressed) <= {"forearm", "wrist", "hand_mount", "palm"}
    for link, contact in contacts.items():
        (number,) = cell.colliders_of(link)
        sizes = np.linalg.norm(result.forces.colliders[0, :, number, :3], axis=-1)
        np.testing.assert_allclose(contact.largest[0], sizes.max(), rtol=1e-6)
        assert (contact.frame[0] == 0) == (link not in pressed)
    terms = dict(zip(result.cost_names, result.cost_terms[0], strict=True))
    for link in ("forearm", "wrist"):
        forces = np.linalg.norm(contacts[link].forces[0], axis=-1)
        by_hand = (np.maximum(forces - 0.1, 0.0) ** 2).sum()
        assert terms[f"force of {link}"] == pytest.approx(by_hand, rel=1e-3, abs=1e-9)
    assert terms["clearance of palm"] > 0.0
    # Without colliders the arm goes through the rope.
    without = swept(scene, cell) | {"world": World()}
    free = scene.twin.rollout(**without, returns=Returns(final_state=True))
    moved = scene.twin.rollout(**swept(scene, cell), returns=Returns(final_state=True))
    assert np.abs(free.final_positions - moved.final_positions).max() > 0.005
    with pytest.raises(ValueError, match="forces=True"):
        cell.contacts(free)
    forces = scene.twin.rollout(**without, returns=Returns(forces=True))
    with pytest.raises(ValueError, match="world of the workcell"):
        cell.contacts(forces)


@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_gradients_by_joints_agree_with_finite_differences(scene, interpolation):
    # In the air, near links that cost but do not touch: there gradients have no impacts.
    world = World(ground="none", gravity=[0, 0, 0])
    cell = Workcell(scene.robot, world=world, margin_m=0.004)
    costs = [
        Keypoints(nodes=[NODE], targets=[GOAL], squared=True),
        *cell.clearance("palm", "forearm", margin_m=0.15, weight=10.0, when="last_frame"),
    ]
    task = task_of(scene, cell, costs=costs, frames=6, interpolation=interpolation)
    random = np.random.default_rng(0)
    knots = np.concatenate([np.zeros((1, 1, 6)), random.normal(0, 0.1, (1, 2, 6))], axis=1)
    gradient = task.evaluate(knots, None, gradients=True).gradients[0]
    step = 2e-3
    units = step * np.eye(18).reshape(18, 3, 6)
    costs = task.evaluate(np.concatenate([knots + units, knots - units]), None).costs
    slopes = ((costs[:18] - costs[18:]) / (2 * step)).reshape(3, 6)
    np.testing.assert_allclose(gradient[1:], slopes[1:], rtol=0.02, atol=2e-3)
    assert np.abs(slopes[1:]).max() > 0.1


@pytest.mark.parametrize(
    ("make", "has_ground"),
    [
        (lambda t: Mppi(t, samples=16, iterations=2, sigma=0.15, knots=3), True),
        (lambda t: Cem(t, samples=16, iterations=3, sigma=0.15, knots=3), True),
        (lambda t: PredictiveSampling(t, samples=16, iterations=2, sigma=0.15, knots=3), True),
        # Impacts with the ground leave no gradient (docs/use/gradients.md).
        (lambda t: GradientDescent(t, iterations=8, rate=0.05, knots=3), False),
    ],
    ids=["mppi", "cem", "predictive sampling", "gradient"],
)
def test_planners_plan_joints_within_their_limits(scene, make, has_ground):
    floating = Workcell(scene.robot, world=World(ground="none", gravity=[0, 0, 0]))
    task = task_of(scene, scene.cell if has_ground else floating)
    planner = make(task)
    plan = planner.plan()
    assert plan.cost < 0.9 * plan.nominal_cost
    assert plan.excess == 0.0
    path = task.space.path(plan)
    assert path.names == scene.robot.joint_names
    assert path.positions.shape == path.velocities.shape == (13, 7)
    np.testing.assert_allclose(path.times_s, np.arange(13) / scene.twin.info.fps)
    np.testing.assert_allclose(path.positions[0], scene.joints)
    assert not path.faults(scene.robot)
    assert scene.cell.depths(path.positions).max() <= task.space.allowed_depth_m + 1e-9
    # What is executed is what was planned, with the arm.
    done = scene.twin.rollout(**plan.actions(), initial=scene.start, costs=task.costs)
    assert done.costs[0] == pytest.approx(plan.cost, rel=1e-6)
    poses = scene.cell.rollout_arguments(path.positions[None])["poses"]
    np.testing.assert_allclose(plan.actions()["poses"], poses, atol=1e-6)
    planner.shift(4)
    assert planner.plan().cost <= task.evaluate(planner.nominal[None], None).costs[0]
    assert len(task.space.path(plan, frames=4).times_s) == 5


def test_speed_limits_of_joints_bind(scene):
    task = task_of(scene, frames=3)
    planner = PredictiveSampling(
        task, samples=16, sigma=2.0, knots=4, finest=1.0, bounds=Bounds(high=[0.02] + 5 * [np.inf])
    )
    plan = planner.plan(nominal=np.linspace(0, 1, 4)[:, None] * np.array([3.0, -3, 0, 0, 0, 0]))
    assert plan.knots[:, 0].max() <= 0.02, "limits of the planner hold beside those of joints"
    path = task.space.path(plan)
    assert not path.faults(scene.robot)
    rates = np.abs(np.diff(path.positions, axis=0)) * scene.twin.info.fps
    assert (rates <= scene.robot.speed * 1.001).all()
    assert (rates > 0.9 * scene.robot.speed)[:, :6].any()
    fast = replace(path, positions=path.positions * 5.0)
    assert any("its limit is" in fault for fault in fast.faults(scene.robot))
    beyond = replace(path, positions=path.positions + 2.0)
    assert any("its limits are" in fault for fault in beyond.faults(scene.robot))


def test_plans_into_the_table_are_worse_than_all_others(scene):
    task = task_of(scene, costs=[Keypoints(nodes=[0], targets=[[0, 0, -0.2]])])
    down = np.linspace(0, 1, 3)[None, :, None] * np.array([0, 0.3, 0, 0, 0, 0])
    both = np.concatenate([0 * down, down])
    evaluation = task.evaluate(both, None)
    assert evaluation.excess[0] == 0.0
    assert evaluation.excess[1] > 0.05
    plan = Mppi(task, samples=8, sigma=0.01, knots=3).plan(nominal=down[0])
    assert plan.excess == 0.0
    assert plan.overstrained > 0
    refused = replace(task, plausibility=Plausibility(refuse=True))
    costs = refused.evaluate(both, None).costs
    assert np.isfinite(costs[0])
    assert np.isinf(costs[1])
    wall = Collider(shape=Cuboid([-0.1, -0.2, 0.2], [0.3, -0.05, 0.6]), name="wall")
    walled = Workcell(scene.robot, scene.geometry, world=World(colliders=[wall]))
    turned = np.linspace(0, 1, 3)[None, :, None] * np.array([-1.0, 0, 0, 0, 0, 0])
    assert task_of(scene, walled).evaluate(turned, None).excess[0] > 0.01


def test_the_server_says_that_it_knows_no_joints(scene):
    with pytest.raises(TypeError, match="JointSpace, such as joints: plan with Mppi"):
        OnServer(task_of(scene))
    request = task_of(scene).request(np.zeros((1, 3, 6)))
    with pytest.raises(TypeError, match="JointSpace, such as joints: plan with Mppi"):
        scene.twin.plan(**request, space=task_of(scene).space)
    assert isinstance(task_of(scene).space, MachineSpace)
    with pytest.raises(ValueError, match="workcell"):
        task_of(scene, world=World())


def test_sessions_and_libraries_move_joints(scene):
    task = task_of(scene)
    knots = np.array([[[0.0] * 6, [0.2, -0.3, 0, 0, 0, 0]]])
    joints = task.space.positions(knots)
    arguments = scene.cell.rollout_arguments(joints, frames=12)
    returns = Returns(final_state=True)
    alone = scene.twin.rollout(**arguments, initial=scene.start, returns=returns)
    by_task = task.rollout(knots, returns=returns)
    np.testing.assert_array_equal(alone.final_positions, by_task.final_positions)
    with scene.client.open_session(
        scene.twin, initial=scene.start, world=scene.cell.world
    ) as session:
        session.advance(**arguments)
        (state,) = session.states()
    np.testing.assert_allclose(state.positions, alone.final_positions[0], atol=1e-6)
    velocities = np.repeat(knots[:, 1:], 12, axis=1) * scene.twin.info.fps / 12
    motion = simulate(task, np.zeros(6), velocities, None, nodes=[NODE])
    np.testing.assert_allclose(motion.nodes[0, -1, 0], alone.final_positions[0, NODE], atol=1e-5)


def test_the_gripper_takes_hold_and_others_stand_still(scene):
    closed = np.arange(13) >= 2
    free = [Grasp(region=Sphere(0.03), closed=closed), Grasp(hand=0, closed=False)]
    task = task_of(scene, grasps=free)
    lift = np.array([0, 0, 0.5, 1])[None, :, None] * np.array([0, -0.4, 0, 0, 0, 0])
    result = task.rollout(lift, returns=Returns(final_state=True))
    np.testing.assert_array_equal(np.asarray(result.final_grasping.phases)[0], [1, 0])
    assert result.final_positions[0, 0, 2] > 0.03
    still = Workcell(scene.robot, scene.geometry, hands={0: None})
    held = task_of(scene, still).rollout(lift, returns=Returns(final_state=True))
    np.testing.assert_allclose(held.final_controls[0], scene.start.controls, atol=1e-5)


def test_the_server_takes_the_hulls_of_meshes(scene):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("scipy")
    random, above = np.random.default_rng(0), np.array([0.0, 0.0, 5.0])
    round_box = trimesh.creation.box((0.2, 0.1, 0.05)).subdivide().subdivide().subdivide()
    bodies = [
        trimesh.creation.icosphere(subdivisions=3).vertices,
        trimesh.creation.cylinder(0.3, 1.0, sections=64).vertices,
        trimesh.creation.annulus(0.2, 0.3, 0.4, sections=64).vertices,
        trimesh.creation.capsule(1.0, 0.2).vertices,
        # Flat but for rounding.
        random.normal(size=(50, 3)) * [1.0, 0.5, 1e-6],
        round_box.vertices + 1e-5 * random.normal(size=round_box.vertices.shape),
        *(random.normal(size=(4 + 3 * k, 3)) * [1.0, 0.5, 0.02 * k + 0.1] for k in range(0, 20, 2)),
    ]
    hulls = [hull_of(np.asarray(points) + above).points for points in bodies]
    world = World(colliders=[Collider(shape=ConvexMesh(points)) for points in hulls])
    hold = np.repeat(scene.geometry.controls[None, None], 2, axis=1)
    result = scene.twin.rollout(trajectories=hold, frames=1, world=world)
    assert np.isfinite(result.costs).all()
    for points, hull in zip(bodies, hulls, strict=True):
        planes = hull_planes(hull)
        beyond = (np.asarray(points) + above) @ planes[:, :3].T + planes[:, 3]
        assert beyond.max() < 1e-9, "a hull contains its mesh"


def test_joints_are_chosen_and_starts_checked(scene):
    space = JointSpace(scene.cell, scene.joints, joints=["lift", "grip"])
    assert space.dims == 2
    positions = space.positions([[0.1, 0.02]])
    changed = np.flatnonzero(positions[0] - scene.joints)
    assert [scene.robot.joint_names[i] for i in changed] == ["lift", "grip"]
    np.testing.assert_allclose(space.coordinates(positions), [[0.1, 0.02]])
    with pytest.raises(RobotError, match="'elbow' starts at -1, beyond"):
        JointSpace(scene.cell, scene.robot.positions({"elbow": -1.0}))
    with pytest.raises(ValueError, match=r"give \[7\]"):
        JointSpace(scene.cell, scene.joints[None])
    with pytest.raises(TypeError, match="another space"):
        space.path(Mppi(task_of(scene), samples=2, knots=2, sigma=0.01).plan())
