"""Links of robots as colliders, without a server."""

from itertools import pairwise

import numpy as np
import pytest

from bendtwin import Capsule, Collider, ConvexMesh, Cuboid, Plane, Sphere, World
from bendtwin.robots import EXAMPLE_URDF, Robot, RobotError, Workcell
from bendtwin.robots.description import Ball, Box, Cylinder
from bendtwin.robots.obstacles import Obstacles
from bendtwin.robots.shapes import merged, outline, samples, shape_of
from bendtwin.robots.transforms import placed
from bendtwin.rotations import exponential

IDENTITY = np.array([0.0, 0, 0, 0, 0, 0, 1])
LINKS = ["shoulder", "upper_arm", "forearm", "wrist", "hand_mount"]


def example(**settings):
    return Robot.from_urdf(EXAMPLE_URDF, tip="tool", **settings)


class Twin:
    """What a workcell asks of the geometry of a twin."""

    def __init__(self, hands, ground=None):
        self.hands, self.ground = np.array(hands, np.uint32), ground
        self.hand_count = int(self.hands.max()) + 1 if len(hands) else 0


def test_links_follow_the_tip_as_further_grippers():
    table = Collider(shape=Cuboid([0, 0, 0], [1, 1, 0.1]), name="table")
    robot = example(base_pose=[1, 2, 0, 0, 0, 1, 0])
    cell = Workcell(robot, world=World(colliders=[table], ground_friction=0.7), margin_m=0.004)
    by_name = {c.name: c for c in cell.world.colliders}
    assert list(by_name) == ["table", "base", *LINKS, "palm"], "but not fingers"
    assert cell.world.colliders[0] is table
    assert cell.world.ground_friction == 0.7
    assert [by_name[n].gripper for n in ("base", *LINKS, "palm")] == [None, 1, 2, 3, 4, 5, 0]
    assert by_name["forearm"].margin_m == 0.004
    assert cell.colliders_of("forearm") == [4]
    joints = robot.positions({"turn": 0.3, "lift": 0.4, "elbow": 0.9, "spin": 1.0})
    arguments = cell.rollout_arguments(np.stack([joints, joints])[None])
    assert arguments["poses"].shape == (1, 2, 6, 7)
    assert arguments["frames"] == 1
    poses = dict(zip(robot.links, robot.link_poses(joints), strict=True))
    for gripper, link in enumerate(["tool", *LINKS]):
        np.testing.assert_allclose(arguments["poses"][0, 0, gripper], poses[link], atol=1e-6)
    # The base stands where its pose in the world says, turned by half a turn about z.
    np.testing.assert_allclose(by_name["base"].pose, [1, 2, 0.04, 0, 0, 1, 0], atol=1e-12)
    # The palm is behind the tool that carries it.
    np.testing.assert_allclose(by_name["palm"].pose[:3], [0, 0, -0.075], atol=1e-12)


def test_joints_between_knots_are_interpolated_as_joints():
    robot, cell = example(), Workcell(example())
    joints = np.stack([robot.positions(), robot.positions({"lift": 1.0, "elbow": 2.0})])[None]
    poses = cell.rollout_arguments(joints, frames=10)["poses"]
    middle = robot.tip_poses(robot.positions({"lift": 0.5, "elbow": 1.0}))
    np.testing.assert_allclose(poses[0, 5, 0], middle[0], atol=1e-6)
    straight = 0.5 * (poses[0, 0, 0, :3] + poses[0, 10, 0, :3])
    assert np.linalg.norm(middle[0, :3] - straight) > 0.1
    with pytest.raises(ValueError, match="one frame"):
        cell.rollout_arguments(joints, frames=0)
    with pytest.raises(ValueError, match=r"\[B, K, J\]"):
        cell.rollout_arguments(joints[0])


def test_links_are_chosen_and_bodies_merged():
    pytest.importorskip("scipy")
    assert list(Workcell(example(), links=["forearm", "palm"]).links_of_colliders.values()) == [
        ("forearm",),
        ("palm",),
    ]
    with pytest.raises(RobotError, match="'tool' has no collision shape"):
        Workcell(example(), links=["tool"])
    with pytest.raises(RobotError, match="'hand' has no collider: there are forearm"):
        Workcell(example(), links=["forearm"]).colliders_of("hand")
    text = EXAMPLE_URDF.read_text()
    # Fixed to its wrist, the hand is one body with the forearm beyond its elbow.
    for joint in ("roll", "pitch", "spin"):
        text = text.replace(f'name="{joint}" type="revolute"', f'name="{joint}" type="fixed"')
        text = text.replace(f'name="{joint}" type="continuous"', f'name="{joint}" type="fixed"')
    stiff = Robot.from_urdf(text, tip="tool")
    cell = Workcell(stiff, merge=True)
    assert [c.name for c in cell.world.colliders] == ["base", "shoulder", "upper_arm", "forearm"]
    assert cell.colliders_of("palm") == cell.colliders_of("forearm") == [3]
    assert cell.world.colliders[3].gripper == 0
    assert isinstance(cell.world.colliders[3].shape, ConvexMesh)
    assert len(Workcell(stiff).world.colliders) == 7


def test_too_many_colliders_are_refused_with_advice():
    pytest.importorskip("scipy")
    shape = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    text = f'<robot name="r"><link name="a">{33 * shape}</link></robot>'
    with pytest.raises(RobotError, match="merge=True"):
        Workcell(Robot.from_urdf(text))
    assert len(Workcell(Robot.from_urdf(text), merge=True).world.colliders) == 1
    names = [f"l{i}" for i in range(34)]
    links = "".join(f'<link name="{n}">{shape}</link>' for n in names)
    joints = "".join(
        f'<joint name="j{b}" type="continuous"><parent link="{a}"/><child link="{b}"/></joint>'
        for a, b in pairwise(names)
    )
    long = Robot.from_urdf(f'<robot name="r">{links}{joints}</robot>')
    with pytest.raises(RobotError, match="links="):
        Workcell(long)
    assert Workcell(long, links=names[5:9]).carriers == ["l33", *names[5:9]]
    table = Collider(shape=Sphere(0.1), name="forearm")
    with pytest.raises(RobotError, match="two colliders have the name 'forearm'"):
        Workcell(example(), world=World(colliders=[table]))
    with pytest.raises(RobotError, match="gripper"):
        Workcell(example(), world=World(colliders=[Collider(shape=Sphere(0.1), gripper=0)]))


def test_hands_go_with_tips_or_stand_still():
    robot = example()
    assert Workcell(robot, Twin([0, 0, 1])).gripper_of_control is None
    cell = Workcell(robot, Twin([0, 0, 1]), hands={0: "tool"})
    np.testing.assert_array_equal(cell.gripper_of_control, [0, 0, 6])
    ends = [robot.positions(), robot.positions({"turn": 1.0})]
    poses = cell.rollout_arguments([ends])["poses"]
    np.testing.assert_array_equal(poses[0, 0, 6], poses[0, 1, 6])
    by_poses = np.ones((1, 2, 7, 7))
    link_poses = robot.link_poses(np.array([ends]))
    still = np.concatenate([by_poses[:, :, :6], 0 * by_poses[:, :, 6:]], axis=2)
    np.testing.assert_array_equal(
        cell.gradients(link_poses, by_poses), cell.gradients(link_poses, still)
    )
    both = Robot.from_urdf(EXAMPLE_URDF, tip=["left_finger", "right_finger"])
    np.testing.assert_array_equal(Workcell(both, Twin([1, 0])).gripper_of_control, [1, 0])
    with pytest.raises(RobotError, match="no hand 2"):
        Workcell(robot, Twin([0, 1]), hands={2: "tool"})
    with pytest.raises(RobotError, match="'palm' is no tip"):
        Workcell(robot, Twin([0, 1]), hands={0: "palm"})
    with pytest.raises(RobotError, match="geometry"):
        Workcell(robot, hands={0: "tool"})


def test_costs_have_the_names_of_links():
    cell = Workcell(example())
    costs = cell.clearance("forearm", "wrist", margin_m=0.02, weight=10.0)
    assert [(c.name, c.collider, c.margin_m, c.weight) for c in costs] == [
        ("clearance of forearm", 3, 0.02, 10.0),
        ("clearance of wrist", 4, 0.02, 10.0),
    ]
    assert len(cell.clearance(margin_m=0.02)) == len(cell.force(limit_n=1.0)) == 7
    assert cell.force("palm", limit_n=2.0)[0].by == ("collider", 6)


@pytest.mark.parametrize("cylinders", ["auto", "capsules", "prisms"])
@pytest.mark.parametrize(
    "solid",
    [
        Ball(0.3),
        Box(np.array([0.1, 0.2, 0.3])),
        Cylinder(0.1, 0.5),
        Cylinder(0.2, 0.1),
    ],
    ids=str,
)
def test_colliders_contain_their_shapes(solid, cylinders):
    pytest.importorskip("scipy")
    random = np.random.default_rng(0)
    points = surface(solid, random)
    shape = shape_of(solid, cylinders)
    collider = Obstacles(None, [Collider(shape=shape)])
    small = np.zeros(1)
    # A point of the shape is in the collider, and near its surface unless it is a capsule's end.
    depths = np.array([collider.depth(p[None, None] * (1 - 1e-6), small)[0] for p in points])
    assert (depths > 0.0).all()
    pose = np.concatenate([[0.1, 0.2, 0.3], exponential(np.array([0.3, 0.4, 0.5]))])
    whole = merged([solid, Ball(0.05)], [IDENTITY, pose])
    around = Obstacles(None, [Collider(shape=whole)])
    assert all(around.depth(p[None, None] * (1 - 1e-6), small)[0] > 0 for p in points)
    hull = Obstacles(None, [Collider(shape=ConvexMesh(outline(solid)))])
    assert all(hull.depth(p[None, None] * (1 - 1e-6), small)[0] > 0 for p in points)
    # Samples are in the shape, and near all of its surface.
    at, reach = samples(solid)
    assert (collider.depth(at[:, None] * (1 - 1e-6), small) > 0).all() or isinstance(solid, Ball)
    apart = np.linalg.norm(points[:, None] - at, axis=-1) - reach
    assert apart.min(axis=1).max() < 0.11
    assert len(at) == len(reach) <= 500


def surface(solid, random):
    """Points on a shape, made in another way."""
    unit = random.normal(size=(100, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    if isinstance(solid, Ball):
        return solid.radius_m * unit
    if isinstance(solid, Box):
        cube = unit / np.abs(unit).max(axis=1, keepdims=True)
        return 0.5 * solid.sides_m * cube
    angle, height = random.uniform(0, 2 * np.pi, 100), random.choice([-0.5, 0.3, 0.5], 100)
    return np.stack(
        [
            solid.radius_m * np.cos(angle),
            solid.radius_m * np.sin(angle),
            solid.length_m * height,
        ],
        axis=1,
    )


def test_long_cylinders_become_capsules():
    assert isinstance(shape_of(Cylinder(0.1, 0.4), "auto"), Capsule)
    assert isinstance(shape_of(Cylinder(0.1, 0.39), "auto"), ConvexMesh)
    assert isinstance(shape_of(Cylinder(0.1, 0.1), "capsules"), Capsule)


@pytest.mark.parametrize(
    ("shape", "point", "depth"),
    [
        (Sphere(0.2, center=[0, 0, 1]), [0, 0, 0.9], 0.1),
        (Capsule([0, 0, 0], [1, 0, 0], 0.1), [0.5, 0.04, 0.03], 0.05),
        (Capsule([0, 0, 0], [0, 0, 0], 0.1), [0.05, 0, 0], 0.05),
        (Cuboid([0, 0, 0], [1, 1, 1]), [0.5, 0.9, 0.5], 0.1),
        (Cuboid([0, 0, 0], [1, 1, 1]), [0.5, 1.1, 0.5], 0.0),
        (ConvexMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), [0.1, 0.2, 0.2], 0.1),
    ],
)
def test_depths_in_obstacles_are_exact(shape, point, depth):
    pytest.importorskip("scipy")
    pose = np.concatenate([[0.5, -0.3, 0.2], exponential(np.array([0.3, -1.0, 0.5]))])
    at = placed(pose, np.array([point], float))[None]
    there = Obstacles(None, [Collider(shape=shape, pose=pose)])
    assert there.depth(at, np.zeros(1))[0] == pytest.approx(depth, abs=1e-9)
    moving = Obstacles(None, [Collider(shape=shape, path=[pose, pose])])
    assert moving.depth(at, np.zeros(1))[0] == 0.0


def test_an_arm_that_goes_into_the_table_is_noticed():
    robot = example()
    above, below = robot.positions({"lift": 0.4}), robot.positions({"lift": 1.8, "elbow": 0.3})
    cell = Workcell(robot, Twin([0], Plane(offset_m=0.0)))
    assert cell.depths([[above, above]]).tolist() == [[0.0, 0.0]]
    fingers = robot.link_poses(below)[-2:, 2].min()
    assert fingers < -0.1
    # Their ends are lower than their origins.
    assert -fingers < cell.depths(below) < -fingers + 0.1
    assert Workcell(robot, Twin([0]), world=World(ground="none")).depths(below) == 0.0
    own = Workcell(robot, Twin([0], Plane()), world=World(ground=Plane(offset_m=-1.0)))
    assert own.depths(below) == 0.0
    # The base, which stands on the table, does not count.
    assert Workcell(robot, world=World(ground=Plane(offset_m=0.05))).depths(above) == 0.0
    wall = Collider(shape=Cuboid([0.25, -1, 0], [0.35, 1, 2]))
    assert Workcell(robot, world=World(colliders=[wall])).depths(above) > 0.01
