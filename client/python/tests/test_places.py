"""Proposed places to grasp, and searches of places as messages."""

from types import SimpleNamespace

import numpy as np
import pytest

from bendtwin import Grasp, GraspSearch, Keypoints, Sphere, State, grasp_places
from bendtwin.planners import Grippers, Mppi, OnServer, Task, Together
from bendtwin.simulation.plan import PlanUpdate, excess_share, plan_request
from bendtwin.tensors import pack_floats, unpack
from bendtwin.v1 import planning_pb2

SPACING = 0.02
STAY = [[0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0]]


def cable(count=41, bend=0.0):
    """A cable along x, of which `bend` is a share of a circle."""
    s = SPACING * np.arange(count)
    radius = s[-1] / (2 * np.pi * max(bend, 1e-6))
    turn = s / radius
    points = np.stack([radius * np.sin(turn), radius * (1 - np.cos(turn)), 0 * s], axis=1)
    # An end in the middle of the numbers: order is not that of the nodes.
    order = np.roll(np.arange(count), count // 3)
    number = np.argsort(order)
    links = [(i, i + k) for k in (1, 2) for i in range(count - k)]
    return SimpleNamespace(
        rest_positions=points[order],
        surface_count=count,
        edges=np.vstack([number[np.array(links)], [[0, count]]]),
        rods=[np.arange(2)],
        spacing_m=SPACING,
        along=s[order],
    )


def cloth(side=13):
    """A sheet in x and y, twice as long in y."""
    x, y = np.meshgrid(np.arange(side), np.arange(2 * side), indexing="ij")
    points = SPACING * np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    number = np.arange(len(points)).reshape(x.shape)
    edges = [
        np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1),
        np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1),
        np.stack([number[:-1, :-1].ravel(), number[1:, 1:].ravel()], axis=1),
        np.stack([number[1:, :-1].ravel(), number[:-1, 1:].ravel()], axis=1),
    ]
    return SimpleNamespace(
        rest_positions=points,
        surface_count=len(points),
        edges=np.concatenate(edges),
        rods=[],
        spacing_m=SPACING,
    )


def axes(poses):
    """The axes of the grippers as columns [P, 3, 3]."""
    x, y, z, w = np.moveaxis(poses[:, 0, 3:].astype(np.float64), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


@pytest.mark.parametrize("bend", [0.0, 0.8])
def test_places_on_a_cable_go_evenly_from_end_to_end(bend):
    rope = cable(bend=bend)
    places = grasp_places(rope, count=6)
    assert places.poses.shape == (6, 1, 7)
    along = rope.along[places.nodes]
    np.testing.assert_allclose(sorted(along), np.linspace(0, along.max(), 6), atol=SPACING / 2)
    assert along.max() == pytest.approx(rope.along.max())
    np.testing.assert_allclose(places.poses[:, 0, :3], rope.rest_positions[places.nodes], atol=1e-6)
    # Fingers close across the cable, in the plane.
    frames = axes(places.poses)
    np.testing.assert_allclose(frames[:, :, 2], np.tile([0, 0, -1.0], (6, 1)), atol=1e-6)
    near = rope.rest_positions[:, None] - rope.rest_positions[places.nodes]
    for i in range(6):
        steps = near[:, i][np.linalg.norm(near[:, i], axis=1) < 1.1 * SPACING]
        across = np.abs(steps @ frames[i, :, 0]) / SPACING
        assert across.max() < 0.2
    same = grasp_places(rope, count=6)
    np.testing.assert_array_equal(places.poses, same.poses)


def test_places_on_a_surface_are_far_apart():
    sheet = cloth()
    places = grasp_places(sheet, count=8, approach=[0.0, 0.0, -2.0], distance_m=0.1)
    assert len(set(places.nodes.tolist())) == 8
    points = sheet.rest_positions[places.nodes]
    np.testing.assert_allclose(places.poses[:, 0, :3], points + np.array([0, 0, 0.1]), atol=1e-6)
    # Two opposite corners, and then what is farthest from all before.
    assert set(places.nodes[:2].tolist()) in ({0, 13 * 26 - 1}, {25, 12 * 26})
    gaps = np.linalg.norm(points[:, None] - points, axis=-1) + np.eye(8)
    assert gaps.min() > 0.1
    # Across the longest direction, which is y.
    np.testing.assert_allclose(np.abs(axes(places.poses)[:, 0, 0]), 1.0, atol=1e-6)


def test_places_follow_the_state_and_what_is_asked_for():
    rope = cable()
    lifted = State(positions=rope.rest_positions + np.array([0.0, 0.0, 0.5]))
    places = grasp_places(
        rope,
        lifted,
        count=2,
        approach=[1.0, 0.0, -1.0],
        closing=[1.0, 0.0, 0.0],
        among=[3, 4, 5],
    )
    assert sorted(places.nodes.tolist()) == [3, 5]
    frames = axes(places.poses)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(frames[0, :, 2], [half, 0, -half], atol=1e-6)
    np.testing.assert_allclose(frames[0, :, 0], [half, 0, half], atol=1e-6)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, atol=1e-6)
    # Along the cable itself any direction across does.
    beside = grasp_places(rope, count=3, approach=[1.0, 0.0, 0.0])
    assert np.isfinite(beside.poses).all()
    search = places.search(1)
    assert search.to_proto().grippers == [1]
    assert unpack(search.to_proto().poses).shape == (2, 1, 7)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"count": 0}, "count is 0"),
        ({"count": 42}, "there are 41"),
        ({"count": 2, "among": [41]}, "not in 0..41"),
        ({"count": 2, "approach": [0, 0, 0]}, "approach"),
        ({"count": 2, "closing": [0, 0, 1]}, "parallel"),
        ({"count": 2, "closing": [0, np.nan, 1]}, "closing"),
        ({"count": 2, "state": State(positions=np.zeros((3, 3)))}, "positions"),
    ],
)
def test_what_cannot_be_proposed_is_said(wrong, text):
    with pytest.raises(ValueError, match=text):
        grasp_places(cable(), **wrong)


def test_a_search_is_part_of_a_plan():
    poses = np.tile(np.array(STAY), (5, 1))
    request = plan_request(
        "twins/x",
        {
            "poses": np.tile(np.array(STAY), (1, 3, 1, 1)),
            "grasps": [Grasp(region=Sphere(0.03))],
            "grasp_search": GraspSearch(poses, grippers=[0]),
        },
    )
    assert unpack(request.grasp_search.poses).shape == (5, 1, 7)
    assert request.grasp_search.grippers == [0]
    assert request.rollout.grasps
    assert not plan_request("twins/x", {"poses": np.zeros((1, 2, 1, 7))}).HasField("grasp_search")
    with pytest.raises(ValueError, match="poses of the grasp search"):
        GraspSearch(np.zeros((5, 6))).to_proto()


def test_an_update_has_the_place_and_the_excess():
    knots = pack_floats("knots", np.zeros((1, 3, 1, 7)), (1, None, 1, 7))
    costs = np.array([1.0, np.inf])
    update = planning_pb2.PlanUpdate(
        knots=knots, grasp=1, grasp_force_n=6.0, grasp_force_limit_n=4.0, strain=0.5, strain_limit=1
    )
    update.grasp_costs.dtype = 2
    update.grasp_costs.shape.append(2)
    update.grasp_costs.data = costs.tobytes()
    read = PlanUpdate.from_proto(update)
    assert (read.grasp, read.grasp_force_n, read.grasp_force_limit_n) == (1, 6.0, 4.0)
    np.testing.assert_array_equal(read.grasp_costs, costs)
    assert read.excess == pytest.approx(0.5)
    plain = PlanUpdate.from_proto(planning_pb2.PlanUpdate(knots=knots, strain=3, strain_limit=2))
    assert (plain.grasp, plain.grasp_costs, plain.grasp_force_n) == (None, None, None)
    assert plain.excess == pytest.approx(0.5)
    assert (excess_share(3.0, np.inf), excess_share(0.5, 0.0), excess_share(0.0, 0.0)) == (
        0,
        0.5,
        0,
    )


def test_planners_of_the_client_say_that_they_search_no_places():
    twin = SimpleNamespace(info=SimpleNamespace(fps=30.0))
    poses = np.array([STAY, [[0.3, *STAY[0][1:]]]])
    asked = {"twin": twin, "costs": [Keypoints(nodes=[0], targets=[[0, 0, 0]])], "frames": 9}
    task = Task(space=Grippers(STAY), grasp_search=GraspSearch(poses), **asked)
    with pytest.raises(ValueError, match="OnServer"):
        Mppi(task)
    with pytest.raises(ValueError, match="OnServer"):
        task.evaluate(np.zeros((1, 3, 6)), None)
    with pytest.raises(TypeError, match="Grippers"):
        Task(space=Together([[0, 0, 0]]), grasp_search=GraspSearch(poses), **asked)
    there = task.at_place(1)
    assert there.grasp_search is None
    np.testing.assert_array_equal(np.asarray(there.space.start)[0, :3], [0.3, 0.0, 0.1])
    assert OnServer(task).task is task
