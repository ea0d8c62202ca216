"""Obstacles of MoveIt as colliders."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from bendtwin import ConvexMesh, Cuboid, Sphere
from bendtwin.rotations import matrices
from bendtwin_ros import hulls
from bendtwin_ros.frames import MissingTransform
from bendtwin_ros.messages.basic import Header, Point, Pose, Quaternion
from bendtwin_ros.messages.scene import (
    CollisionObject,
    Mesh,
    MeshTriangle,
    Plane,
    PlanningScene,
    PlanningSceneWorld,
    SolidPrimitive,
)
from bendtwin_ros.poses import applied
from bendtwin_ros.scene import Obstacles, SceneFault
from made_ros import FakeFrames, shifted

FRAMES = FakeFrames({"table": shifted([1, 0, 0]), "twin": shifted([0, 0, 0])})
TURNED = Pose(Point(0.0, 0.0, 0.5), Quaternion(0.7071068, 0.0, 0.0, 0.7071068))


def solid(name, kind, *dimensions, pose=None, frame="table", **more):
    one = CollisionObject(Header(frame_id=frame), pose or Pose(), name, **more)
    one.primitives, one.primitive_poses = [SolidPrimitive(kind, list(dimensions))], [Pose()]
    return one


def world(*objects, frames=FRAMES):
    return Obstacles(objects).world("twin", frames, friction=0.4, margin_m=0.002)


def test_solids_keep_their_form_and_place():
    box = solid("box", SolidPrimitive.BOX, 0.2, 0.4, 0.6, pose=TURNED)
    ball = solid("ball", SolidPrimitive.SPHERE, 0.1)
    found = world(box, ball).colliders
    assert isinstance(found[0].shape, Cuboid)
    np.testing.assert_allclose(found[0].shape.high, [0.1, 0.2, 0.3])
    np.testing.assert_allclose(found[0].pose, [1, 0, 0.5, 0.7071068, 0, 0, 0.7071068], atol=1e-6)
    assert isinstance(found[1].shape, Sphere)
    assert [(c.friction, c.margin_m) for c in found] == [(0.4, 0.002)] * 2
    assert len({c.name for c in found}) == 2


@pytest.mark.parametrize("kind", [SolidPrimitive.CYLINDER, SolidPrimitive.CONE])
def test_round_solids_are_within_their_hulls_of_few_faces(kind):
    [collider] = world(solid("pipe", kind, 0.4, 0.05)).colliders
    assert isinstance(collider.shape, ConvexMesh)
    hull = ConvexHull(collider.shape.points)
    assert len(hull.simplices) <= 128
    angles = np.linspace(0, 7, 100)
    high = np.full(100, -0.2)
    rim = np.stack([0.05 * np.cos(angles), 0.05 * np.sin(angles), high], axis=1)
    beyond = rim @ hull.equations[:, :3].T + hull.equations[:, 3]
    assert beyond.max() < 1e-9
    assert beyond.max(axis=1).min() > -0.001


def ball_of(count, center):
    points = np.random.default_rng(0).normal(size=(count, 3))
    points = 0.1 * points / np.linalg.norm(points, axis=1)[:, None] + center
    return points, ConvexHull(points).simplices


def test_each_part_of_a_mesh_is_a_hull_that_contains_it():
    (a, first), (b, second) = ball_of(400, [0, 0, 0]), ball_of(30, [0, 0, 1])
    triangles = [*first.tolist(), *(second + len(a)).tolist()]
    mesh = Mesh(
        [MeshTriangle(t) for t in triangles],
        [Point(*p) for p in np.concatenate([a, b]).tolist()],
    )
    one = CollisionObject(Header(frame_id="twin"), Pose(), "mesh", meshes=[mesh])
    colliders = world(one).colliders
    assert len(colliders) == 2
    for collider, points in zip(colliders, (a, b), strict=True):
        hull = ConvexHull(collider.shape.points)
        assert len(hull.simplices) <= 128
        beyond = points @ hull.equations[:, :3].T + hull.equations[:, 3]
        assert beyond.max() <= collider.margin_m - 0.002 + 1e-9
        assert collider.margin_m < 0.03


def test_a_level_plane_is_the_ground_and_others_are_boxes():
    level = CollisionObject(Header(frame_id="twin"), id="floor")
    level.planes, level.plane_poses = [Plane([0.0, 0.0, 2.0, -0.2])], [Pose()]
    wall = CollisionObject(Header(frame_id="twin"), id="wall")
    wall.planes = [Plane([1.0, 1.0, 0.0, 0.5])]
    found = world(level, wall)
    assert found.ground.offset_m == pytest.approx(0.1)
    np.testing.assert_allclose(found.ground.normal, [0, 0, 1])
    [box] = found.colliders
    inside = applied(box.pose, [[0, 0, -0.01], [1, -2, -0.5]])
    outside = applied(box.pose, [[0, 0, 0.01], [1, -2, 0.5]])
    assert (inside @ [1, 1, 0] + 0.5 < 0).all()
    assert (outside @ [1, 1, 0] + 0.5 > 0).all()
    np.testing.assert_allclose(np.linalg.det(matrices(box.pose[3:])), 1.0)


def scene(*objects, diff=True):
    return PlanningScene("", PlanningSceneWorld(list(objects)), diff)


def names(obstacles):
    return [
        c.name.split(":")[0]
        for c in obstacles.world("twin", FRAMES, friction=0, margin_m=0).colliders
    ]


def test_changes_of_a_scene_add_move_and_remove():
    known = Obstacles()
    ball = solid("ball", SolidPrimitive.SPHERE, 0.1)
    known.update(scene(ball, solid("box", SolidPrimitive.BOX, 1.0, 1.0, 1.0)))
    assert names(known) == ["ball", "box"]
    known.update(scene(CollisionObject(Header(frame_id="table"), TURNED, "ball", operation=b"\3")))
    moved = known.world("twin", FRAMES, friction=0, margin_m=0).colliders[0]
    np.testing.assert_allclose(moved.pose[:3], [1, 0, 0.5])
    known.update(scene(solid("ball", SolidPrimitive.SPHERE, 0.2, operation=b"\2")))
    assert names(known) == ["ball", "ball", "box"]
    both = known.and_of(scene(solid("other", SolidPrimitive.SPHERE, 0.2)))
    assert names(both) == ["ball", "ball", "box", "other"]
    known.update(scene(CollisionObject(id="ball", operation=b"\1")))
    assert names(known) == ["box"]
    known.update(scene(diff=False))
    assert names(known) == []
    with pytest.raises(SceneFault, match="never added"):
        known.update(scene(CollisionObject(id="gone", operation=b"\3")))


@pytest.mark.parametrize(
    "one",
    [
        solid("x", SolidPrimitive.BOX, 0.1),
        solid("x", SolidPrimitive.SPHERE, float("nan")),
        solid("x", SolidPrimitive.SPHERE, -1.0),
        solid("x", 77, 1.0),
        solid("x", SolidPrimitive.SPHERE, 1.0, pose=Pose(Point(), Quaternion(0.0, 0.0, 0.0, 0.0))),
        CollisionObject(id="x", meshes=[Mesh()], header=Header(frame_id="twin")),
        CollisionObject(
            id="x",
            meshes=[Mesh([MeshTriangle([0, 1, 9])], [Point()] * 3)],
            header=Header(frame_id="twin"),
        ),
        CollisionObject(id="x", planes=[Plane()], header=Header(frame_id="twin")),
        CollisionObject(
            id="x", planes=[Plane()], plane_poses=[Pose()] * 2, header=Header(frame_id="twin")
        ),
    ],
)
def test_a_shape_that_is_none_is_named(one):
    with pytest.raises(SceneFault, match="'x'"):
        world(one)


def test_a_frame_that_is_unknown_is_named():
    with pytest.raises(MissingTransform, match="shelf"):
        world(solid("x", SolidPrimitive.SPHERE, 1.0, frame="shelf"))


def test_hulls_have_outward_triangles_also_of_flat_points():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    for points in (ball_of(50, [0, 0, 3])[0], square, square[:1], square[:2]):
        corners, triangles = hulls.hull(points)
        a, b, c = (corners[triangles[:, k]] for k in range(3))
        volume = np.einsum("fi,fi->f", np.cross(a, b), c).sum() / 6
        assert volume > 0


def test_swept_hulls_share_a_time_so_that_no_motion_is_between_them():
    path = np.linspace(0, 1, 7)[:, None, None] + np.zeros((7, 2, 3))
    pieces = hulls.swept(path, 3)
    assert [len(piece) for piece in pieces] == [6, 6, 6]
    for first, second in pairwise(pieces):
        np.testing.assert_array_equal(first[-2:], second[:2])
    assert len(hulls.swept(path, 100)) == 6
    assert len(hulls.swept(path[:1], 3)) == 1
