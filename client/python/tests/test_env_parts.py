"""Parts of environments without a server: bodies, actions, cameras, pictures, rates."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from bendtwin import Geometry, State, rotations
from bendtwin.skin import Skin

pytest.importorskip("gymnasium")

from bendtwin.envs import Actions, Body, Camera, Evaluation, Randomisation, View
from bendtwin.envs.actions import Mover, Workspace
from bendtwin.envs.pictures import Pictures
from bendtwin.envs.tasks import MoveTip


def strip(count=9, hands=((0.0, 0.0, 0.0),)):
    """A chain of nodes 0.1 m apart along x, above a ground at -0.01; its hand is at its first."""
    nodes = np.zeros((count, 3), np.float32)
    nodes[:, 0] = 0.1 * np.arange(count)
    edges = np.array([[i, i + 1] for i in range(count - 1)], np.uint32)
    empty = np.zeros(0, np.uint32)
    rows = np.zeros((0, 3), np.uint32)
    skin = Skin(rows.astype(float), empty, empty, empty, empty, rows, rows)
    ground = SimpleNamespace(normal=[0, 0, 1], offset_m=-0.01, friction=0.5, restitution=0.0)
    geometry = Geometry(
        rest_positions=nodes,
        kinds=np.zeros(count, np.uint8),
        edges=edges,
        rest_lengths=np.full(count - 1, 0.1, np.float32),
        triplets=rows,
        spring_stiffness=np.ones(count - 1),
        bend_stiffness=np.zeros(0),
        masses=np.ones(count),
        controls=np.array(hands, np.float32).reshape(-1, 3),
        hands=np.zeros(len(hands), np.uint32),
        pins=np.zeros((0, 2), np.uint32),
        rods=[],
        surface_count=count,
        fps=30.0,
        substeps=10,
        gravity=np.array([0, 0, -9.81]),
        ground=ground,
        mass_kg=None,
        spacing_m=0.1,
        skin=skin,
    )
    return Body.at_rest(geometry, State(nodes, np.ones_like(nodes)))


def test_a_body_has_a_length_and_a_tip_away_from_the_hand():
    body = strip()
    assert body.length_m == pytest.approx(0.8)
    assert body.along.argmin() == 8, "the end without the hand is the tip"
    assert body.is_elongated
    assert body.is_level
    assert body.ground_m == pytest.approx(-0.01)
    assert body.end().tolist() == [8]
    assert 4 in body.place(0.5)
    assert body.spread(3).tolist() == [8, 0, 4]
    assert not np.asarray(body.state.velocities).any()


def test_a_body_is_placed_as_a_rigid_one():
    body = strip()
    placed = body.placed([[0.1, 0.2], [0.0, 0.0]], [np.pi / 2, 0.0])
    np.testing.assert_allclose(placed.positions[1], body.positions, atol=1e-7)
    np.testing.assert_allclose(placed.positions[0, :, 0], 0.4 + 0.1, atol=1e-6)
    np.testing.assert_allclose(placed.positions[0, :, 1], 0.1 * np.arange(9) - 0.4 + 0.2, atol=1e-6)


def test_rotations_agree_with_one_another():
    random = np.random.default_rng(0)
    vectors = random.uniform(-1.5, 1.5, (20, 3))
    turns = rotations.exponential(vectors)
    np.testing.assert_allclose(rotations.logarithm(turns), vectors, atol=1e-12)
    np.testing.assert_allclose(rotations.logarithm(-turns), vectors, atol=1e-12)
    points = random.normal(size=(20, 3))
    turned = rotations.rotated(turns, points)
    np.testing.assert_allclose(rotations.rotated(rotations.conjugate(turns), turned), points)
    axes = np.stack([rotations.rotated(turns, np.eye(3)[i]) for i in range(3)], axis=-1)
    np.testing.assert_allclose(axes @ points[..., None], turned[..., None], atol=1e-12)
    for turn, matrix in zip(turns, axes, strict=True):
        np.testing.assert_allclose(rotations.quaternions(matrix) * np.sign(turn[3]), turn)


@pytest.mark.parametrize("axes", ["world", "gripper"])
@pytest.mark.parametrize("knots", [1, 3])
def test_a_gripper_gets_where_it_is_sent(axes, knots):
    body = strip()
    actions = Actions(axes=axes, knots=knots, frames=6)
    mover = Mover(actions, body, 2, Workspace.around(body, 0.0))
    random = np.random.default_rng(1)

    def some():
        places = np.array([0.4, 0.0, 0.3]) + random.uniform(-0.2, 0.2, (4, 2, 3))
        turns = rotations.exponential(random.uniform(-0.5, 0.5, (4, 2, 3)))
        return np.concatenate([places, turns], axis=-1)

    poses, goals, closed = some(), some(), np.ones((4, 2), bool)
    for _ in range(40):
        action = mover.towards(poses, goals, closed)
        assert np.abs(action).max() <= 1.0
        way, shut = mover.moved(poses, action)
        assert way.shape == (4, knots + 1, 2, 7)
        assert shut.all()
        assert np.abs(np.diff(way[..., :3], axis=1)).max() < 2 * mover.largest[0]
        poses = way[:, -1]
    np.testing.assert_allclose(poses, goals, atol=1e-6)
    # Not below the ground, wherever it is sent.
    down = np.zeros((4, mover.size))
    down.reshape(4, knots, 2, 7)[..., 2] = -1.0 if axes == "world" else 0.0
    for _ in range(30):
        poses = mover.moved(poses, down)[0][:, -1]
    assert poses[..., 2].min() >= 0.0


def test_a_camera_looks_where_it_is_to_look():
    camera = Camera.looking("one", [1.0, -2.0, 1.5], [0.2, 0.1, 0.0])
    pose = np.asarray(camera.pose)
    forward = np.array([0.2, 0.1, 0.0]) - pose[:3]
    np.testing.assert_allclose(
        rotations.rotated(pose[3:], np.array([0.0, 0.0, 1.0])), forward / np.linalg.norm(forward)
    )
    assert rotations.rotated(pose[3:], np.array([0.0, 1.0, 0.0]))[2] < 0, "y is down"
    with pytest.raises(ValueError, match=r"a pose \[7\]"):
        Camera(name="two", pose=[0, 0, 1], intrinsics=[1, 1, 0, 0])


@dataclass
class Taken:
    """What a fake session was asked for."""

    cameras: list
    slots: list
    props: list
    light: object

    @property
    def colors(self):
        camera = self.cameras[0]
        return np.zeros((len(self.slots), camera.height, camera.width, 3), np.uint8)


def test_pictures_are_asked_for_by_slot():
    calls = []

    def render(cameras, *, slots, look, props, light):
        calls.append(Taken(cameras, slots, props, light))
        return [calls[-1] for _ in cameras]

    session = SimpleNamespace(render=render)
    simulation = SimpleNamespace(session=session, run=lambda what: what())
    body = strip()
    cameras = [
        Camera.looking("wrist", [0, -0.1, 0.1], [0, 0, 0], gripper=0, width=1024, height=1024)
    ]
    pictures = Pictures(simulation, MoveTip(body), cameras, None)
    poses = np.zeros((9, 1, 7))
    poses[..., 6], poses[..., 0] = 1.0, np.arange(9)[:, None]
    plain = Randomisation(camera_m=0.0).look(np.random.default_rng(0), 1, 0)
    drawn = pictures.draw(np.arange(9), poses, np.zeros((9, 1), bool), np.ones((9, 3)), [plain] * 9)
    assert drawn["wrist"].shape == (9, 1024, 1024, 3)
    assert [call.slots for call in calls] == [list(range(8)), [8]], "at most 8 million pixels"
    np.testing.assert_allclose(calls[0].cameras[0].pose[:, 0], np.arange(8))
    palm, *fingers, goal = [*calls[0].props[1:], calls[0].props[0]]
    np.testing.assert_allclose(goal.pose[:, :3], 1.0)
    np.testing.assert_allclose(palm.pose[:, 0], np.arange(8))
    assert len(fingers) == 2


def test_looks_differ_within_their_ranges():
    wide = Randomisation(
        camera_m=0.1,
        camera_rad=0.2,
        field_of_view=(0.5, 2.0),
        light_rad=(0.0, 1.0),
        brightness=(0.5, 1.5),
        background=(10, 20),
        colors=30,
    )
    looks = [wide.look(np.random.default_rng(seed), 2, 3) for seed in range(20)]
    assert np.ptp([look.brightness for look in looks]) > 0.5
    for look in looks:
        assert np.abs(look.shift_m).max() <= 0.1
        assert (look.zoom >= 0.5).all()
        assert (look.zoom <= 2.0).all()
        assert look.background.min() >= 10
        assert look.background.max() <= 20
        assert np.abs(look.tint).max() <= 30
        np.testing.assert_allclose(np.linalg.norm(look.light), 1.0)
    same = wide.look(np.random.default_rng(3), 2, 3)
    np.testing.assert_array_equal(same.turn, looks[3].turn)


def test_a_task_judges_by_distance():
    task = MoveTip(strip())
    points = task.body.positions[task.nodes][None].repeat(2, axis=0)
    goals = np.array([[0.8, 0.0, 0.0], [0.8, 0.0, 0.5]])
    grippers = np.zeros((2, 1, 7))
    grippers[:, 0, :3] = task.places(points)[:, 0]
    judged = task.judge(View(points, grippers, np.zeros((2, 1), bool), goals))
    assert judged.success.tolist() == [True, False]
    np.testing.assert_allclose(judged.cost, [0.0, 0.75 * 0.5 / 0.8], atol=1e-6)


def test_rates_have_wilsons_interval():
    def rated(successes, count):
        won = np.arange(count) < successes
        return Evaluation(won, np.zeros(count), np.ones(count, np.int64), 0)

    assert rated(0, 10).interval == pytest.approx((0.0, 0.27753), abs=1e-4)
    assert rated(5, 10).interval == pytest.approx((0.23659, 0.76341), abs=1e-4)
    assert "50% of 10 episodes succeed (95 % interval 24% to 76%)" in str(rated(5, 10))
