"""The side of MuJoCo of a coupling: geoms, conditions, poses, wrenches and the fixed point."""

import numpy as np
import pytest

from bendtwin import Cuboid, Geometry, Grasp, Plane, Sphere

mujoco = pytest.importorskip("mujoco")

from bendtwin.coupling import ClosedWhen, CouplingError, Gripper  # noqa: E402
from bendtwin.coupling import geoms as shapes  # noqa: E402
from bendtwin.coupling.interface import FixedPoint  # noqa: E402
from bendtwin.coupling.model import Carrier, Model  # noqa: E402
from bendtwin.coupling.poses import IDENTITY, Change, matrix  # noqa: E402
from bendtwin.coupling.surroundings import surroundings  # noqa: E402

SCENE = """
<mujoco>
  <option timestep="0.007" gravity="0 0 -5"/>
  <asset><mesh name="wedge" vertex="0 0 0  0.1 0 0  0 0.2 0  0 0 0.3  0.02 0.02 0.02"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1" pos="0 0 -0.1" friction="3"/>
    <body name="shelf" pos="0 1 0"><geom name="plank" type="box" size="0.3 0.2 0.1"/></body>
    <body name="arm" pos="0 0 1">
      <joint name="swing" type="hinge" axis="0 1 0" range="-1 1"/>
      <geom name="rod" type="cylinder" size="0.02 0.3" pos="0.3 0 0" quat="1 0 1 0"/>
      <geom name="seen" type="sphere" size="0.5" contype="0" conaffinity="0"/>
      <site name="tip" pos="0.6 0 0" quat="1 1 0 0"/>
      <body name="tool" pos="0.6 0 0">
        <joint name="slide" type="slide" axis="1 0 0" range="0 1"/>
        <geom name="egg" type="ellipsoid" size="0.05 0.02 0.03"/>
        <geom name="cut" type="mesh" mesh="wedge"/>
      </body>
    </body>
    <body name="puck" mocap="true"><geom name="ball" type="sphere" size="0.04"/></body>
    <body name="loose" pos="0 0 2"><freejoint name="free"/><geom name="pill" type="capsule"
      size="0.01 0.1"/></body>
  </worldbody>
  <actuator><position name="squeeze" joint="slide"/></actuator>
</mujoco>
"""
#: A twin with two hands of one control point each, of which little matters here.
_NONE = np.zeros(0, np.uint32)
GEOMETRY = Geometry(
    **{name: _NONE for name in ("kinds", "edges", "rest_lengths", "triplets", "pins")},
    **{name: _NONE for name in ("spring_stiffness", "bend_stiffness", "masses", "rods", "skin")},
    rest_positions=np.zeros((1, 3)),
    controls=np.zeros((2, 3)),
    hands=np.array([0, 1], np.uint32),
    surface_count=1,
    fps=30.0,
    substeps=1,
    gravity=np.zeros(3),
    ground=None,
    mass_kg=None,
    spacing_m=0.01,
)


@pytest.fixture(autouse=True)
def folder_of_logs(tmp_path, monkeypatch):
    """MuJoCo writes its warnings to the current folder."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def scene():
    model = mujoco.MjModel.from_xml_string(SCENE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def around(scene, grippers=None, **named):
    options = {"colliders": None, "ground": None, "margin_m": 0.005, "held_hands": ()}
    options |= {"change": Change(IDENTITY), **named}
    return surroundings(*scene, GEOMETRY, grippers or {}, **options)


def support(points, ways):
    return (ways @ np.asarray(points).T).max(axis=1)


def test_geoms_that_collide_become_colliders_on_their_bodies(scene):
    made = around(scene, {"tip": Grasp(region=Sphere(0.01))})
    names = [c.name for c in made.world.colliders]
    assert names == ["rod", "egg", "cut", "ball", "pill", "plank"]
    assert [c.name for c in made.carriers] == ["tip", "arm", "tool", "puck", "loose"]
    assert made.collider_carriers == [1, 2, 2, 3, 4, -1]
    assert [c.gripper for c in made.world.colliders] == [1, 2, 2, 3, 4, None]
    plank = made.world.colliders[-1]
    assert isinstance(plank.shape, Cuboid)
    np.testing.assert_allclose(plank.pose, [0, 1, 0, 0, 0, 0, 1], atol=1e-12)
    assert isinstance(made.world.ground, Plane)
    assert made.world.ground.offset_m == pytest.approx(-0.1)
    np.testing.assert_allclose(made.world.gravity, [0, 0, -5])
    assert all(c.margin_m == 0.005 for c in made.world.colliders)
    assert around(scene, colliders=["tool", "ball"]).collider_carriers == [0, 0, 1]
    assert around(scene, colliders=(), ground="none").world.ground == "none"
    assert around(scene, colliders=()).world.ground is None


def test_hands_are_released_held_or_taken_by_a_gripper(scene):
    made = around(scene, {"arm": Grasp(hand=1)}, colliders=())
    assert [(g.hand, g.gripper, g.closed) for g in made.grasps] == [(1, 0, True), (0, 1, False)]
    assert made.gripper_of_control.tolist() == [1, 0]
    held = around(scene, {"arm": Grasp(nodes=[0])}, colliders=(), held_hands=[0, 1])
    assert [g.hand for g in held.grasps] == [None]
    assert held.gripper_of_control.tolist() == [1, 1]


def test_shapes_contain_their_geoms(scene):
    model, _ = scene
    ways = shapes.directions(500)
    rod = shapes.shape(model, model.geom("rod").id).points
    exact = 0.02 * np.hypot(ways[:, 0], ways[:, 1]) + 0.3 * np.abs(ways[:, 2])
    assert (support(rod, ways) >= exact - 1e-12).all()
    assert (support(rod, ways) <= 1.01 * exact).all()
    egg = shapes.shape(model, model.geom("egg").id).points
    exact = np.linalg.norm(ways * [0.05, 0.02, 0.03], axis=1)
    assert (support(egg, ways) >= 0.999 * exact).all()
    assert (support(egg, ways) <= 1.1 * exact).all()
    cut = shapes.shape(model, model.geom("cut").id).points
    assert len(cut) == 4, "the corner inside is left out"
    pill = shapes.shape(model, model.geom("pill").id)
    assert (pill.radius_m, pill.end[2]) == pytest.approx((0.01, 0.1))


def test_what_a_twin_cannot_have_is_refused_with_advice(scene):
    with pytest.raises(ValueError, match="neither a geom nor a body 'nose'"):
        around(scene, colliders=["nose"])
    with pytest.raises(ValueError, match="neither a body nor a site 'nose'"):
        around(scene, {"nose": Grasp(nodes=[0])})
    with pytest.raises(ValueError, match="no hand 2"):
        around(scene, {"arm": Grasp(hand=2)})
    with pytest.raises(ValueError, match="closed to the Gripper"):
        Gripper(Grasp(nodes=[0], closed=[0, 1]))
    many = "".join(f'<geom size="1" pos="{i} 0 0"/>' for i in range(33))
    crowd = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{many}<geom name='a' type='plane' size='1 1 1'/>"
        "<geom name='b' type='plane' size='1 1 1'/></worldbody></mujoco>"
    )
    data = mujoco.MjData(crowd)
    mujoco.mj_forward(crowd, data)
    with pytest.raises(ValueError, match="plane 'b' cannot be the ground"):
        around((crowd, data))
    spheres = [f"geom{i}" for i in range(33)]
    for i, name in enumerate(spheres):
        assert shapes.name_of(crowd, i) == name
    crowd.geom_contype[33:] = crowd.geom_conaffinity[33:] = 0
    with pytest.raises(ValueError, match="33 geoms collide: a twin has at most 32"):
        around((crowd, data))
    with pytest.raises(ValueError, match="world_in_twin is a pose"):
        Change([0, 0, 0])


def test_a_gripper_closes_by_a_joint_an_actuator_or_a_function(scene):
    model, data = scene
    below = ClosedWhen(joint="slide", below=0.2).condition(model)
    above = ClosedWhen(actuator="squeeze", above=0.5).condition(model)
    found = []
    for position, control in ((0.1, 0.4), (0.3, 0.6)):
        data.joint("slide").qpos[0], data.actuator("squeeze").ctrl[0] = position, control
        found.append((below(model, data), above(model, data)))
    assert found == [(True, False), (False, True)]
    late = Gripper(Grasp(nodes=[0]), closed=lambda _, data: data.time > 1).condition(model)
    assert not late(model, data)
    assert not Gripper(Grasp(nodes=[0]), closed=False).condition(model)(model, data)
    for wrong, says in (
        ({"joint": "free", "below": 1}, "neither a hinge nor a slide"),
        ({"joint": "slide"}, "either below or above"),
        ({"below": 1}, "either joint or actuator"),
        ({"actuator": "nose", "above": 1}, "no actuator 'nose'"),
    ):
        with pytest.raises(ValueError, match=says):
            ClosedWhen(**wrong).condition(model)


def test_poses_are_those_of_the_twins_world(scene):
    model, data = scene
    turn = np.array([0, 0, np.sin(0.3), np.cos(0.3)])
    change = Change([1, 2, 3, *turn])
    side = Model(model, data, [Carrier.named(model, n) for n in ("tool", "tip")], change)
    tool, tip = side.poses()
    rotation = matrix(turn[[3, 0, 1, 2]])
    np.testing.assert_allclose(tool[:3], [1, 2, 3] + rotation @ [0.6, 0, 1])
    np.testing.assert_allclose(tool[3:], turn, atol=1e-12)
    np.testing.assert_allclose(
        matrix(tip[[6, 3, 4, 5]]), rotation @ data.site("tip").xmat.reshape(3, 3), atol=1e-12
    )
    np.testing.assert_allclose(change.points_back([tool[:3]]), [[0.6, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(change.vectors_back(rotation @ [1.0, 2, 3]), [1, 2, 3])


def test_a_pose_is_carried_on_to_the_end_of_the_frame(scene):
    model, data = scene
    model.opt.gravity[:] = 0
    data.joint("free").qvel[:] = [0.1, 0.2, 0.3, 0, 0, 2.0]
    side = Model(model, data, [Carrier.named(model, "loose")], Change(IDENTITY))
    (here,), (later,) = side.poses(), side.poses(0.5)
    np.testing.assert_allclose(later[:3] - here[:3], [0.05, 0.1, 0.15], atol=1e-12)
    np.testing.assert_allclose(later[3:], [0, 0, np.sin(0.5), np.cos(0.5)], atol=1e-12)


def test_wrenches_act_at_the_origin_of_their_body_or_site(scene):
    model, data = scene
    model.opt.gravity[:] = 0
    carriers = [Carrier.named(model, name) for name in ("tip", "loose")]
    side = Model(model, data, carriers, Change(IDENTITY))
    wrenches = np.array([[1.0, 2, 3, 0.1, 0.2, 0.3], [0, 0, 1, 0, 0.5, 0]])
    expected = np.zeros(model.nv)
    for wrench, carrier in zip(wrenches, carriers, strict=True):
        at = data.xpos[carrier.body] if carrier.site < 0 else data.site_xpos[carrier.site]
        force, torque = wrench[:3].copy(), wrench[3:].copy()
        mujoco.mj_applyFT(model, data, force, torque, at.copy(), carrier.body, expected)
    own = np.random.default_rng(0).normal(size=data.xfrc_applied.shape)
    data.xfrc_applied[:] = own
    before = side.save()
    side.run(1, wrenches, None)
    np.testing.assert_array_equal(data.xfrc_applied, own)
    with_own = data.qfrc_smooth.copy()
    side.restore(before)
    side.run(1, None, None)
    np.testing.assert_allclose(with_own - data.qfrc_smooth, expected, atol=1e-9)
    # The same by a function that is called before each step.
    side.restore(before)
    calls = []
    side.run(2, wrenches, lambda _, data: calls.append(data.time))
    assert calls == pytest.approx([0.0, 0.007])
    twice = side.save()
    side.restore(before)
    side.run(2, wrenches, None)
    np.testing.assert_allclose(side.save(), twice, atol=1e-12)


def test_a_model_that_diverges_says_so_each_time(scene):
    model, data = scene
    side = Model(model, data, [Carrier.named(model, "loose")], Change(IDENTITY))
    before = side.save()

    def breaks(_, data):
        data.qvel[:] = np.nan

    for _ in range(2):
        with pytest.raises(CouplingError, match="diverged") as error:
            side.run(1, None, breaks)
        assert error.value.reason == "MODEL_DIVERGED"
        side.restore(before)
    side.run(1, None, None)
    assert data.time == pytest.approx(0.007)


def iterated(solver, response, guess, limit):
    """The fixed point, and the number of evaluations that it took."""
    solver.begin(np.full(6, 1e-3))
    for count in range(1, limit):
        answer = response(guess)
        if solver.displacement_m(answer - guess) < 1e-6:
            return guess, count
        guess = solver.next(guess, answer)
    raise AssertionError("no fixed point was found")


def test_the_fixed_point_of_a_linear_response_is_found_in_a_few_evaluations():
    random = np.random.default_rng(1)
    matrix = -5 * random.uniform(size=(6, 6)) - 10 * np.eye(6)
    constant = random.normal(size=6)
    exact = np.linalg.solve(np.eye(6) - matrix, constant)
    solver, counts = FixedPoint(6, relaxation=0.5), []
    for _ in range(4):
        guess, count = iterated(solver, lambda w: matrix @ w + constant, np.zeros(6), 30)
        np.testing.assert_allclose(guess, exact, atol=1e-3)
        counts.append(count)
    # Later frames know the response.
    assert counts[-1] < counts[0] / 2


def test_a_cable_that_gets_taut_is_not_taken_for_the_slack_one_that_it_was():
    """The response falls by 60 N for each newton above 1 N, in one direction."""

    def response(w):
        return np.array([8 + min(0.0, -60 * (w[0] - 1)), *np.zeros(5)])

    solver = FixedPoint(6, relaxation=1.0)
    for _ in range(3):
        iterated(solver, lambda w: 0.1 * w + 0.1, np.zeros(6), 8)
    guess, _ = iterated(solver, response, np.zeros(6), 17)
    assert guess[0] == pytest.approx(68 / 61, abs=1e-3)


def test_what_cannot_move_does_not_delay_the_end_of_an_iteration():
    solver = FixedPoint(12, relaxation=1.0)
    solver.begin(np.array([0.01] * 6 + [0.0] * 6))
    assert solver.displacement_m(np.array([0.0] * 6 + [100.0] * 6)) < 1e-6
    assert solver.displacement_m(np.eye(12)[0]) == pytest.approx(0.01)


def test_mobility_is_that_of_all_joints_that_take_part(scene):
    model, data = scene
    carriers = [Carrier.named(model, name) for name in ("loose", "tool", "arm")]
    side = Model(model, data, carriers, Change(IDENTITY))
    loose, tool, arm = side.mobility(np.arange(3))
    mass = model.body("loose").mass[0]
    assert loose[0] == pytest.approx(1 / mass, rel=1e-6)
    assert loose[1] == pytest.approx((1 / model.body("loose").inertia).mean(), rel=1e-6)
    # The hinge turns the tool as well, and moves it.
    assert tool[0] > 1 / 3 / model.body("tool").mass[0]
    assert arm[0] == pytest.approx(0.0, abs=1e-9)
    assert arm[1] > 0
